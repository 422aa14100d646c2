"""The journal of a run: when it was begun, where each ``run`` of the script began and ended.

NAME.journal lies beside the script in.NAME. It tells whether a run was finished, and where a run
that was not goes on. The first line is written here, the others by LAMMPS, the last one here again.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from peridem.run_restart import newest_restart
from peridem.run_script import Command, Resume, commands


def stem(script: Path) -> str:
    """What files that belong to a script are called: in.NAME, NAME.in and NAME give NAME."""
    name = script.name.removeprefix("in.")
    return name.removesuffix(".in").removesuffix(".lmp").removesuffix(".lammps") or "run"


@dataclass(frozen=True)
class Journal:
    """What a journal says.

    Attributes:
        begun: seconds since 1970 when the run was begun; 0 if there is no journal.
        began, ended: steps at which the n-th ``run`` began and ended: {n: step}.
        state: last word on it: 'finished', 'stopped', 'failed' or, if it was killed, ''.
    """

    begun: float
    began: dict[int, int]
    ended: dict[int, int]
    state: str


def journal_path(script: Path) -> Path:
    """Of a script."""
    return script.parent / f"{stem(script)}.journal"


def begin(script: Path, resume: bool) -> None:
    """Start a journal, or note that a run goes on."""
    line = f"begun {time.time():.3f} {script.name}\n"
    if resume and journal_path(script).is_file():
        note(script, "resumed")
    else:
        journal_path(script).write_text(line)


def note(script: Path, word: str) -> None:
    """Add a line."""
    with journal_path(script).open("a") as file:
        file.write(word + "\n")


def read(script: Path) -> Journal:
    """The journal of a script; an empty one if there is none."""
    begun, state = 0.0, ""
    began: dict[int, int] = {}
    ended: dict[int, int] = {}
    path = journal_path(script)
    lines = path.read_text().splitlines() if path.is_file() else []
    for line in lines:
        words = line.split()
        if words[:1] == ["begun"] and len(words) > 1:
            begun = float(words[1])
        elif words[:1] in (["began"], ["ended"]) and len(words) == 3:
            (began if words[0] == "began" else ended)[int(words[1])] = int(words[2])
        elif words:
            state = words[0]
            continue
        state = ""
    return Journal(begun, began, ended, state)


def restart_files(script: Path) -> list[Path]:
    """Where restart files of a script may be: its own, and that which a stop leaves."""
    folder = script.parent
    found = [folder / f"{stem(script)}.restart"]
    for command in commands(script.read_text()):
        for name in _restart_names(command):
            if "$" in name or "%" in name:
                continue
            found += sorted(folder.glob(name)) if "*" in name else [folder / name]
    return list(dict.fromkeys(found))


def _restart_names(command: Command) -> tuple[str, ...]:
    words = command.words
    if command.name == "write_restart" and len(words) > 1:
        return (words[1],)
    if command.name == "restart" and len(words) == 3:
        return (words[2] if "*" in words[2] else f"{words[2]}.*",)
    return words[2:4] if command.name == "restart" else ()


def resume_point(script: Path) -> Resume:
    """Where a script goes on.

    Raises:
        FileNotFoundError: there is no whole restart file.
        ValueError: the run was finished; or nothing tells which of the script's runs it was in.
    """
    journal = read(script)
    if journal.state in ("finished", "complete"):
        raise ValueError(f"{script}: this run is finished, there is nothing to resume")
    paths = restart_files(script)
    # files from before this run belong to another one
    fresh = [p for p in paths if p.is_file() and p.stat().st_mtime >= journal.begun - 1.0]
    path, step = newest_restart(fresh or paths[:1] if not journal.begun else fresh)
    began, ended = journal.began, journal.ended
    if not began:
        began, ended = _by_counting(script, step)
    done = max((n for n, end in ended.items() if end < step), default=0)
    if done + 1 not in began:
        raise ValueError(f"{journal_path(script)} does not say where run {done + 1} began")
    return Resume(path.name, done, began[done + 1], step)


def _by_counting(script: Path, step: int) -> tuple[dict[int, int], dict[int, int]]:
    """As the journal would say if every ``run`` went to its end: for runs of lmp alone."""
    began, ended, at = {1: 0}, {}, 0
    number = 0
    for command in commands(script.read_text()):
        if command.name in ("jump", "include") or (
            command.name == "run" and not command.words[1].isdigit()
        ):
            raise ValueError(
                f"{script}: there is no journal of this run, and its steps cannot be counted "
                f"because of line {command.line}; only runs of 'peridem run' can be resumed then"
            )
        if command.name == "run":
            number += 1
            began[number] = at
            length = int(command.words[1])
            at = length if "upto" in command.words else at + length
            ended[number] = at
    if step > at:
        raise ValueError(f"{script} ends at step {at}, the restart file is of step {step}")
    return began, ended
