"""The shell commands that the pages of the repository show, and what is wrong with them.

A command is a line of a block that a shell reads (``bash`` in reStructuredText; in Markdown an
indented block with a line that begins with one of our programs), or words between backticks that
begin with one. Nothing is run: programs, files, targets, options and variables have to exist.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from peridem import cli

ROOT = Path(__file__).resolve().parents[2]
WRITTEN = {"performance.md", "verification.md"}  # by programs
# what readers have from elsewhere, and words of the shell: their options are not ours
FOREIGN = {"apt-get", "cat", "cd", "cp", "export", "git", "grep", "head", "ls", "mkdir", "module",
           "mv", "pip", "pre-commit", "rm", "sed", "source", "srun", "tail", "touch"}  # fmt: skip
ASSIGNED = re.compile(r"\w+=.*")


@dataclass(frozen=True)
class Command:
    """A line that a reader may copy.

    Attributes:
        page: where it stands.
        text: one command, without a comment.
        whole: from a block, so it has all its arguments.
    """

    page: Path
    text: str
    whole: bool

    @property
    def words(self) -> list[str]:
        """As a shell splits them, variables that come first left out."""
        words = shlex.split(self.text)
        while words and ASSIGNED.fullmatch(words[0]):
            words = words[1:]
        return words

    @property
    def folder(self) -> Path:
        """Where the page has its reader stand."""
        return self.page.parent if self.page.parent.name != "doc" else ROOT


def pages() -> list[Path]:
    found = [*ROOT.glob("*.md"), *(ROOT / "doc").glob("*.md"), *(ROOT / "doc").glob("*.rst")]
    found += [*ROOT.glob("examples/**/README.md")]
    found += [ROOT / name / "README.md" for name in ("bench", "tests", "python")]
    return sorted(path for path in found if path.name not in WRITTEN)


def blocks(page: Path) -> list[str]:
    """Of a page, those that a shell reads."""
    text = page.read_text()
    if page.suffix == ".rst":
        body = r"((?: {3}.*\n|\n)+)"
        found = re.findall(r"code-block:: bash\n(?: {3}:.*\n)*\n" + body, text)
        literal = re.findall(r"parsed-literal::\n\n" + body, text)
        return found + [block for block in literal if any(map(ours, block.splitlines()))]
    found = re.findall(r"(?m)^```(?:bash|sh)\n(.*?)^```$", text, re.DOTALL)
    indented = re.findall(r"(?<=\n\n)((?: {4}\S.*\n)+)", text)
    return found + [block for block in indented if any(map(ours, block.splitlines()))]


def ours(line: str) -> bool:
    with contextlib.suppress(ValueError):
        words = Command(ROOT, line.strip(), whole=True).words
        return bool(words) and Path(words[0]).name in CHECKS
    return False


def pieces(line: str) -> list[str]:
    """The commands of a line: between && and |, in brackets; without comments, and, in Markdown,
    without what stands far to the right.
    """
    line = re.split(r"(?:^|\s)#|\s{3,}\S", line.strip())[0].strip()
    parts = re.split(r"&&|\|(?!\|)|;", line.strip("()& "))
    return [part.strip() for part in parts if part.strip()]


def commands() -> list[Command]:
    found = []
    for page in pages():
        for block in blocks(page):
            joined = block.replace("\\\n", " ").replace("\\*", "*")
            lines = [line for line in joined.splitlines() if line.strip()]
            found += [Command(page, piece, True) for line in lines for piece in pieces(line)]
        running = re.sub(r"(?m)^```.*?^```$", "", page.read_text(), flags=re.DOTALL)
        for span in re.findall(r"``([^`]+)``|`([^`]+)`", running):
            text = " ".join((span[0] or span[1]).split())
            if " " in text and ours(text):
                found += [Command(page, piece, False) for piece in pieces(text)]
    return list(dict.fromkeys(found))


def wrong(command: Command) -> str:
    """Nothing, or why a reader cannot follow."""
    words = command.words
    if not words:
        return "" if re.match(r"[A-Z]", command.text) else "nothing to run"
    name = Path(words[0]).name
    if name in FOREIGN:
        return ""
    if name not in CHECKS:
        return f"nobody knows {words[0]}"
    if "/" in words[0] and not words[0].startswith((".venv/", "build/", "../../build/")):
        return here(words[0], ROOT)
    return CHECKS[name](command, words[1:])


def here(name: str, folder: Path) -> str:
    return "" if (folder / name).exists() else f"{name} is not there"


# ---- make ----------------------------------------------------------------------------------------


def check_make(command: Command, words: Sequence[str]) -> str:
    makefile = (ROOT / "Makefile").read_text()
    scripts = "".join(path.read_text() for path in (ROOT / "cmake").glob("*.sh"))
    for word in words:
        known = re.search(rf"(?m)^{word}:(?!=)", makefile) or ASSIGNED.fullmatch(word)
        if not known:
            return f"no target {word}"
    assigned = [word.split("=")[0] for word in shlex.split(command.text) if "=" in word]
    for name in assigned:
        if not re.search(rf"\b{name}\b", makefile + scripts):
            return f"the Makefile knows no {name}"
    return check_parts(command)


def check_parts(command: Command) -> str:
    """What ``make bench`` and the like hand on to a program."""
    programs = {"BENCH_ARGS": "bench", "PARETO_ARGS": "bench.pareto",
                "VERIFY_ARGS": "verification.report"}  # fmt: skip
    for word in shlex.split(command.text):
        name, _, value = word.partition("=")
        if name in programs:
            return check_module(programs[name], shlex.split(value))
    return ""


# ---- peridem -------------------------------------------------------------------------------------


def check_peridem(command: Command, words: Sequence[str]) -> str:
    words = ["2" if word.startswith("$") else word for word in words]
    if words == ["--help"]:
        return ""
    if not command.whole:
        return check_options(words, peridem_help(words[0]))
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said):
            cli.parser().parse_args(words)
    except SystemExit:
        return said.getvalue().strip().splitlines()[-1]
    return ""


def peridem_help(name: str) -> str:
    kinds = [a for a in cli.parser()._actions if isinstance(a, argparse._SubParsersAction)]
    known = kinds[0].choices
    return known[name].format_help() if name in known else ""


def check_options(words: Sequence[str], text: str) -> str:
    """That a text of help has all the options."""
    if not text:
        return f"no command {words[0]}"
    options = [word for word in words if re.match(r"--?[a-z]", word)]
    lacks = [option for option in options if not re.search(rf"(?<![\w-]){option}\b", text)]
    return f"no option {', '.join(lacks)}" if lacks else ""


# ---- Python --------------------------------------------------------------------------------------


def check_python(command: Command, words: Sequence[str]) -> str:
    if not words:
        return ""
    if words[0] == "-m":
        return check_module(words[1], words[2:])
    for folder in (command.folder, ROOT):
        if (folder / words[0]).is_file():
            return check_options(words[1:], help_of(str(folder / words[0])))
    return f"{words[0]} is not there"


def check_module(module: str, words: Sequence[str]) -> str:
    text = help_of("-m", module)
    if not text:
        return f"no module {module}"
    parts = [word for word in words if re.fullmatch("[a-z]+", word)]
    if module.startswith("bench"):
        known = re.search(r"any of ([\w, \n]+)", text)
        assert known, text
        lacks = set(parts) - set(re.findall(r"\w+", known[1]))
        if lacks:
            return f"{module} has no part {', '.join(sorted(lacks))}"
    return check_options(words, text)


@cache
def help_of(*words: str) -> str:
    """What a program prints about itself: of one that takes no options, its source."""
    if words[0] == "-m":
        path = ROOT / ("tests" if words[1].startswith(("support", "verification")) else "")
        path = path.joinpath(*words[1].split("."))
        source = path.with_suffix(".py") if path.with_suffix(".py").is_file() else None
        source = source or (path / "__main__.py" if path.is_dir() else None)
    else:
        source = Path(words[0])
    if source is None:
        return ""
    text = source.read_text()
    if not re.search("argparse|command.main|program.options", text):
        return text
    done = subprocess.run(
        [sys.executable, *words, "--help"],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": f"{ROOT}:{ROOT / 'tests'}:{ROOT / 'python'}:"
             + os.environ.get("PYTHONPATH", ""), "MPLBACKEND": "Agg"},
        text=True,
        capture_output=True,
    )  # fmt: skip
    return done.stdout if done.returncode == 0 else ""


# ---- LAMMPS, MPI, CMake --------------------------------------------------------------------------


def check_lmp(command: Command, words: Sequence[str]) -> str:
    known = {"-in", "-log", "-screen", "-nocite", "-h"}
    options = [word for word in words if re.fullmatch("-[a-z]+", word)]
    if set(options) - known:
        return f"lmp has no {', '.join(sorted(set(options) - known))}"
    if "-in" not in words:
        return ""
    script = words[words.index("-in") + 1]
    text = command.page.read_text()
    copied = re.search(rf"cp (\S*{re.escape(script)}) ", text)
    if copied:
        return here(copied[1], ROOT)
    made = f":caption: {script}\n" in text or f"Save them as `{script}`" in text
    folders = [command.folder, *(ROOT / name for name in re.findall(r"cd (\S+) &&", text))]
    if made or any((folder / script).is_file() for folder in folders):
        return ""
    program = command.folder / f"{command.folder.name}.py"
    if program.is_file() and "Scene(" in program.read_text() and script == "in.grains":
        return ""  # which the program of the folder writes
    return f"{script} is not there"


def check_mpirun(command: Command, words: Sequence[str]) -> str:
    if words[0] != "-np" or not words[1].isdigit():
        return "mpirun wants -np and a number first"
    return wrong(Command(command.page, shlex.join(words[2:]), command.whole))


def check_cmake(command: Command, words: Sequence[str]) -> str:
    files = [ROOT / "CMakeLists.txt", *(ROOT / "cmake").glob("*.cmake")]
    text = "".join(path.read_text() for path in files)
    for name, value in re.findall(r"-D (\w+)=(\S+)", command.text):
        # LAMMPS's own project is named lammps; the install prefix is CMake's
        standard = ("CMAKE_PROJECT_lammps_INCLUDE", "CMAKE_INSTALL_PREFIX")
        if name not in standard and not re.search(rf"\b{name}\b", text):
            return f"no CMake file knows {name}"
        if value.endswith(".cmake") and here("cmake/" + value.rsplit("/", 1)[1], ROOT):
            return f"{value} is not there"
    options = {word for word in words if re.match(r"--?[a-zA-Z]", word)}
    strange = options - {"-S", "-B", "-D", "--build", "--install", "--prefix", "--parallel"}
    return f"cmake has no {', '.join(sorted(strange))}" if strange else ""


def check_script(command: Command, _words: Sequence[str]) -> str:
    return here(shlex.split(command.text)[0], ROOT)


CHECKS: dict[str, Callable[[Command, Sequence[str]], str]] = {
    "make": check_make,
    "peridem": check_peridem,
    "python": check_python,
    "lmp": check_lmp,
    "mpirun": check_mpirun,
    "cmake": check_cmake,
    **{path.name: check_script for path in (ROOT / "cmake").glob("*.sh")},
}
