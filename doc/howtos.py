"""Does what the manual's howtos say, command by command.

    python doc/howtos.py [page ...] [--keep folder]

Each page ``howto_*.rst`` is followed in a folder of its own that looks like the repository: the
blocks of a page run in their order,

- ``bash``: as they stand, with ``build/`` and ``.venv/`` where a reader has them;
- ``python``: all of a page in this process, one after another;
- any with a caption: written to the file that the caption names;
- ``LAMMPS`` without one: lines for a script, tried in the small scene of ``check_pages.py``;
- ``slurm``: a job script, whose syntax bash checks.

Other blocks without a caption (``text``, parsed literals) show output, or what is not to be run.
What the commands print is in ``printed.txt``.
--keep leaves the folders of the pages there, with what they made.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import textwrap
from dataclasses import dataclass
from pathlib import Path

import check_pages

DOC = Path(__file__).resolve().parent
REPOSITORY = DOC.parent
PRINTED = "printed.txt"
# what commands of a reader use, beside build/ and .venv/
NEEDED = ("bench", "cmake", "doc", "examples", "python", "src", "tests", "Makefile", "README.md")


@dataclass(frozen=True)
class Block:
    """A code block of a page.

    Attributes:
        language: of the directive.
        caption: name of a file, or nothing.
        text: without its indentation.
        line: where it is on the page, from 1.
    """

    language: str
    caption: str
    text: str
    line: int


class HowtoError(RuntimeError):
    """A block did not do what the page says: which one, and what came out."""


def pages() -> list[str]:
    return sorted(path.stem for path in DOC.glob("howto_*.rst"))


def blocks(text: str) -> list[Block]:
    pattern = r"(?m)^( *)\.\. code-block:: (\w+)\n((?:\1 {3}:.*\n)*)\n((?:\1 {3}.*\n|[ \t]*\n)+)"
    found = []
    for match in re.finditer(pattern, text):
        caption = re.search(r":caption: (\S+)", match[3])
        line = text.count("\n", 0, match.start()) + 1
        body = textwrap.dedent(match[4]).strip("\n") + "\n"
        found.append(Block(match[2], caption[1] if caption else "", body, line))
    return found


def place(folder: Path, lmp: Path) -> None:
    """Makes a folder look like the repository after ``make build``."""
    for name in NEEDED:
        (folder / name).symlink_to(REPOSITORY / name)
    (folder / "build").mkdir()
    (folder / "build" / "lmp").symlink_to(lmp)
    (folder / ".venv").symlink_to(sys.prefix)


def follow(page: str, folder: Path, lmp: Path) -> int:
    """Does what a page says, in a folder.

    Returns:
        How many blocks there were.

    Raises:
        HowtoError: a block did not run.
    """
    place(folder, lmp)
    names: dict[str, object] = {"__name__": "__howto__"}
    found = blocks((DOC / f"{page}.rst").read_text())
    for block in found:
        if block.caption:
            (folder / block.caption).write_text(block.text)
        elif block.language == "bash":
            shell(page, block, ["bash", "-euo", "pipefail", "-c", block.text], folder, lmp)
        elif block.language == "slurm":
            (folder / "job.sh").write_text(block.text)
            shell(page, block, ["bash", "-n", "job.sh"], folder, lmp)
        elif block.language == "LAMMPS":
            for script in check_pages.scripts(block.text):
                (folder / "in.lines").write_text(script)
                lines = [str(lmp), "-in", "in.lines", "-nocite", "-log", "none"]
                shell(page, block, lines, folder, lmp)
        elif block.language == "python":
            python(page, block, names, folder, lmp)
    return len(found)


def shell(page: str, block: Block, command: list[str], folder: Path, lmp: Path) -> None:
    done = subprocess.run(
        command,
        cwd=folder,
        env=os.environ | {"LAMMPS_LMP": str(lmp), "MPLBACKEND": "Agg"},
        stdin=subprocess.DEVNULL,
        text=True,
        capture_output=True,
    )
    with (folder / PRINTED).open("a") as printed:
        printed.write(done.stdout + done.stderr)
    if done.returncode:
        raise HowtoError(
            f"doc/{page}.rst:{block.line} ended with {done.returncode}\n"
            f"{block.text}\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
        )


def python(page: str, block: Block, names: dict[str, object], folder: Path, lmp: Path) -> None:
    before, given = Path.cwd(), os.environ.get("LAMMPS_LMP")
    os.environ["LAMMPS_LMP"] = str(lmp)
    os.chdir(folder)
    try:
        # the numbers of lines in a traceback are those of the page
        lines = "\n" * (block.line + 1) + block.text
        exec(compile(lines, f"doc/{page}.rst", "exec"), names)
    except Exception as error:
        raise HowtoError(f"doc/{page}.rst:{block.line}: {error!r}\n{block.text}") from error
    finally:
        os.chdir(before)
        if given is None:
            del os.environ["LAMMPS_LMP"]
        else:
            os.environ["LAMMPS_LMP"] = given


def main() -> int:
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("page", nargs="*", help="without doc/ and .rst (all)")
    options.add_argument("--keep", type=Path, help="folder for what the pages make")
    chosen = options.parse_args()
    lmp = Path(os.environ.get("LAMMPS_LMP", REPOSITORY / "build" / "lmp")).resolve()
    failed = 0
    for page in chosen.page or pages():
        with tempfile.TemporaryDirectory() as scratch:
            folder = (chosen.keep or Path(scratch)).resolve() / page
            folder.mkdir(parents=True)
            try:
                print(f"{page}: {follow(page, folder, lmp)} blocks", flush=True)
            except HowtoError as error:
                failed += 1
                print(error, flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
