"""What LAMMPS says when it fails, and the line of the script where it did."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

RULE = "\n" + "-" * 70  # above and below what mpirun says; LAMMPS's own rules are shorter


def failure(output: str, script: Path, copy: str = "", origin: Sequence[int] = ()) -> str:
    """LAMMPS's error message from its output, with the line of the script where it happened.

    Args:
        output: log and screen output.
        script: as the user gave it.
        copy: the text that LAMMPS read in its place, if that is another one.
        origin: for each line of the copy that of the script.
    """
    error = re.search(r"^ERROR( on proc \d+)?: ", output, re.MULTILINE)
    start = error.start() if error else 0
    lines = output[start:].splitlines()
    if error is None:  # it crashed, or was killed
        crash = re.search(r"exited on (signal \d+ \(.*?\))", output)
        lines = [f"ended by {crash[1]}, after" if crash else "ended without a message, after"]
        said = output.split(RULE)[0] if RULE in output else output.split("\nlmp exited on")[0]
        lines += said.splitlines()[-5:]
    shown: list[str] = []
    for line in lines:
        if line.startswith((RULE.strip(), "MPI_ABORT", "Primary job")):
            break
        if not re.match(r"\[[\w.-]+:\d+\] ", line):  # mpirun's own talk
            shown.append(line.rstrip())
    where = re.search(r"Last (?:input line|command): *(.*)", output[start:])
    number = None
    if where:
        number = _line_number(script.read_text(), where[1])
        if number is None and (place := _line_number(copy, where[1])):
            number = origin[place - 1]
    shown.append(
        f"at line {number} of {script}{_quoted(script, number)}" if number else f"in {script}"
    )
    text = "\n".join(line for line in shown[:20] if line)
    if "nknown atom style 'peridem'" in text or "nrecognized atom style 'peridem'" in text:
        text += "\nthis lmp was built without the PERIDEM package"
    return f"LAMMPS failed: {text}"


def _quoted(script: Path, number: int) -> str:
    return ": " + " ".join(script.read_text().splitlines()[number - 1].split())


def _line_number(script: str, command: str) -> int | None:
    wanted = command.split("#")[0].split()
    for number, line in enumerate(script.splitlines(), 1):
        if wanted and line.split("#")[0].split() == wanted:
            return number
    return None
