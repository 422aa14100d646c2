"""How far a run is: read from the files that LAMMPS writes, shown as a line kept up to date."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, Task, TextColumn
from rich.table import Column

# of time and energy, by LAMMPS's systems of units; those of lj have none
UNITS = {
    "si": (" s", " J"),
    "cgs": (" s", " erg"),
    "metal": (" ps", " eV"),
    "real": (" fs", " kcal/mol"),
    "electron": (" fs", " hartree"),
    "micro": (" us", " pg um^2/us^2"),
    "nano": (" ns", " ag nm^2/ns^2"),
}


@dataclass
class State:
    """What is known of a run: step, time, broken bonds, drift of the energy balance; its units."""

    step: int = 0
    time: float | None = None
    broken: int | None = None
    drift: float | None = None
    units: str = "lj"

    def __str__(self) -> str:
        time, energy = UNITS.get(self.units, ("", ""))
        words = [] if self.time is None else [f"t {self.time:.4g}{time}"]
        if self.broken is not None:
            words.append(f"{self.broken:,} broken")
        if self.drift is not None:
            words.append(f"drift {self.drift:.1e}{energy}")
        return ", ".join(words)


class Follower:
    """Follows the thermo lines of the log, and the file of reports, as they grow.

    Args:
        log: of LAMMPS.
        reports: lines with step, time and, perhaps, the number of broken bonds.
        drift: names of thermo columns that hold the energy drift.
        units: LAMMPS's name of the system of units.
    """

    def __init__(
        self, log: Path, reports: Path, drift: tuple[str, ...] = (), units: str = "lj"
    ) -> None:
        self.state = State(units=units)
        self._log, self._reports = _Tail(log), _Tail(reports)
        self._drift = drift
        self._names: list[str] = []

    def update(self) -> State:
        """Read what is new."""
        for line in self._log.lines():
            self._thermo(line)
        for line in self._reports.lines():
            words = line.split()
            if len(words) >= 2 and words[0].isdigit():
                self.state.step = max(self.state.step, int(words[0]))
                self.state.time = float(words[1])
                self.state.broken = int(words[2]) if len(words) > 2 else None
        return self.state

    def _thermo(self, line: str) -> None:
        words = line.split()
        if words[:1] == ["Step"]:
            self._names = words
        elif line.startswith("Loop time"):
            self._names = []
        elif words and len(words) == len(self._names) and words[0].isdigit():
            self.state.step = max(self.state.step, int(words[0]))
            for name in self._drift:
                if name in self._names:
                    self.state.drift = float(words[self._names.index(name)])


class _Tail:
    """The whole lines that were added to a file since the last look."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._offset = 0

    def lines(self) -> list[str]:
        if not self._path.is_file():
            return []
        if self._path.stat().st_size < self._offset:  # begun anew
            self._offset = 0
        with self._path.open("rb") as file:
            file.seek(self._offset)
            text = file.read()
        end = text.rfind(b"\n") + 1
        self._offset += end
        return text[:end].decode(errors="replace").splitlines()


class Bar:
    """The line on the screen."""

    def __init__(self, progress: Progress, task: Task, steps: int | None, by_time: bool) -> None:
        self._progress, self._task, self._steps, self._by_time = progress, task, steps, by_time

    def show(self, state: State, word: str = "") -> None:
        """Bring it up to date."""
        step = f"step {state.step:,}"
        if self._steps and not self._by_time:
            step += f" of {self._steps:,}"
        done = (state.time or 0.0) if self._by_time else float(state.step)
        text = ", ".join(part for part in (word, step, str(state)) if part)
        left = self._task.time_remaining
        clock = "" if left is None else f"{timedelta(seconds=int(left))} left"
        self._progress.update(self._task.id, completed=done, text=text, clock=clock)

    def end(self, state: State, word: str) -> None:
        """The last word, and the time that it took in place of the time left."""
        self.show(state, word)
        taken = timedelta(seconds=int(self._task.elapsed or 0.0))
        self._progress.update(self._task.id, clock=f"{taken} taken")


@contextmanager
def bar(
    steps: int | None, quiet: bool, begin: int = 0, end_time: float | None = None
) -> Iterator[Bar]:
    """A progress bar on the standard error output.

    Args:
        steps: at its end; None: not known.
        quiet: nothing is shown.
        begin: step at its start.
        end_time: simulated time at its end, if that rather than the number of steps ends the run.
    """
    columns = (
        BarColumn(bar_width=10),
        TextColumn("{task.fields[text]}", table_column=Column(no_wrap=True)),
        TextColumn("{task.fields[clock]}", table_column=Column(no_wrap=True)),
    )
    console = Console(file=sys.stderr)
    with Progress(*columns, console=console, disable=quiet, refresh_per_second=4) as progress:
        by_time = end_time is not None
        total = end_time if by_time else steps
        start = 0 if by_time else begin
        progress.add_task("", total=total, completed=start, text="starting", clock="")
        yield Bar(progress, progress.tasks[0], steps, by_time)
