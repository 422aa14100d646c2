"""Checks the manual against the program.

    python doc/check_pages.py [lmp]

Runs the blocks of every page's Examples section in a small scene, and looks up every error and
warning of src/PERIDEM in troubleshooting.rst.

The scene has two discs of nodes, a type for each, and the names that examples use (group ends,
region slit). A block that gives a pair style takes the place of the scene's; an atom style, line by
line, that of the scene's.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

DOC = Path(__file__).resolve().parent
SCENE = """
units si
dimension 2
boundary s s p
atom_style peridem
lattice sq 0.1e-3
region box block -8 8 0 22 -0.5 0.5
region low cylinder z 0 5 4.6 -1 1
region high cylinder z 2 15 4.6 -1 1
create_box 2 box
create_atoms 1 region low
create_atoms 2 region high
set region low mol 1
set region high mol 2
set group all volume 1.0e-8
set group all density 1200.0
group ends id 1:5
region slit block -0.05e-3 0.05e-3 0.4e-3 0.6e-3 INF INF units box
"""
PAIR = """
pair_style hybrid/overlay peridem/lps peridem/contact
pair_coeff * * peridem/lps bulk 21.6e6 shear 12.96e6 gc 5 horizon 0.3e-3
pair_coeff * * peridem/contact restitution 0.7 friction 0.3
"""
# LAMMPS's own remark on scenes without contact
HARMLESS = "No pairwise cutoff or binsize set"
RUN = """
timestep 1.0e-8
thermo 10
run 20
"""


def examples(page: str) -> list[str]:
    """The code blocks between the headings Examples and Description."""
    section = re.search(r'^Examples\n"+\n(.*?)^Description\n"+$', page, re.MULTILINE | re.DOTALL)
    if not section:
        return []
    found = re.findall(r"code-block:: LAMMPS\n\n((?: {3}.*\n|\n)+)", section[1])
    return [re.sub(r"^ {3}", "", block, flags=re.MULTILINE) for block in found]


def scripts(block: str) -> list[str]:
    if block.startswith("atom_style"):
        lines = block.strip().splitlines()
        motion = "fix motion all nve"
        return [SCENE.replace("atom_style peridem", one) + PAIR + motion + RUN for one in lines]
    motion = "" if "fix motion" in block else "fix motion all nve"
    return [SCENE + ("" if "pair_style" in block else PAIR) + block + motion + RUN]


def messages() -> list[str]:
    """Of each error and warning in the source, the pieces between what it fills in."""
    found = []
    for path in sorted((DOC.parent / "src" / "PERIDEM").glob("*.cpp")):
        for call in re.findall(
            r"error->(?:all|one|warning)\((.*?)\);", path.read_text(), re.DOTALL
        ):
            text = re.search(r'"(?:[^"\\]|\\.)*"(?:\s*"(?:[^"\\]|\\.)*")*', call)
            if text:
                found.append("".join(re.findall(r'"((?:[^"\\]|\\.)*)"', text[0])))
    return found


def missing_messages() -> list[str]:
    """Those that no line of troubleshooting.rst looks like (dots stand there for what varies)."""
    page = " ".join((DOC / "troubleshooting.rst").read_text().split())
    missing = []
    for message in messages():
        message = message.replace("Pair style peridem/contact", "Pair style {}")
        message = message.replace("pair_coeff peridem/contact", "pair_coeff {}")
        pieces = [piece.strip(" ,") for piece in re.split(r"\{[^}]*\}", message)]
        if max(pieces, key=len) not in page:
            missing.append(message)
    return missing


def tried(script: str, lmp: str) -> str:
    """What is wrong when a script is run: nothing, or the script and what it printed."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "in").write_text(script)
        command = [lmp, "-in", "in", "-nocite", "-log", "none"]
        run = subprocess.run(command, cwd=folder, text=True, capture_output=True)
    warnings = re.findall(rf"^WARNING: (?!{HARMLESS}).*", run.stdout, re.MULTILINE)
    if run.returncode == 0 and not warnings:
        return ""
    return "\n".join([script, *warnings, run.stdout[-1500:], run.stderr[-500:]])


def main() -> int:
    lmp = sys.argv[1] if len(sys.argv) > 1 else str(DOC.parent / "build" / "lmp")
    failed = 0
    for path in sorted(DOC.glob("*.rst")):
        done = [script for block in examples(path.read_text()) for script in scripts(block)]
        for wrong in filter(None, (tried(script, lmp) for script in done)):
            failed += 1
            print(f"{path.name}:\n{wrong}")
        if done:
            print(f"{path.name}: {len(done)} tried")
    missing = missing_messages()
    for message in missing:
        print(f"troubleshooting.rst lacks: {message}")
    print(f"troubleshooting.rst: {len(messages())} messages looked up")
    return 1 if failed or missing else 0


if __name__ == "__main__":
    sys.exit(main())
