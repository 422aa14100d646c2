"""Running ``lmp`` and reading what it says of its time and memory.

On a shared machine wall-clock time tells of the neighbours too.  On one rank the numbers here are
seconds of processor time: LAMMPS's loop time times the share of the processor it says it had.
Cases that are compared run in turns, several times, and the medians are taken.
"""

from __future__ import annotations

import os
import re
import statistics
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

SECTIONS = ("Pair", "Neigh", "Comm", "Modify", "Output", "Other")


@dataclass(frozen=True)
class Timing:
    """One run.

    Attributes:
        steps: of the loop that is timed (the last ``run`` of the script).
        seconds: processor time of the loop per rank; wall-clock time when ranks > 1.
        nodes: nodes in the box.
        sections: LAMMPS's breakdown, seconds in the same measure.
        memory: bytes that the process held at most (the largest of the ranks).
        processor: seconds of processor time of the whole program, with its set-up, all ranks.
        builds: how often the neighbour lists were built.
        ghosts: ghost nodes per rank, average.
        log: what was printed.
    """

    steps: int
    seconds: float
    nodes: int
    sections: dict[str, float]
    memory: int
    processor: float
    builds: int
    ghosts: float
    log: str

    @property
    def per_node(self) -> float:
        """ns per node and step."""
        return 1e9 * self.seconds / (self.steps * self.nodes)

    def number(self, pattern: str) -> float:
        """The first group of the first match in the log."""
        found = re.search(pattern, self.log)
        if found is None:
            raise ValueError(f"nothing like {pattern!r} in the log")
        return float(found[1])


def run(lmp: Path, script: str, folder: Path, ranks: int = 1, loop: int = -1) -> Timing:
    """Run a script.

    Args:
        lmp: the program.
        script: its input.
        folder: where it runs.
        ranks: of MPI.
        loop: which ``run`` of the script is timed; those after it need ``post no``.

    Raises:
        RuntimeError: LAMMPS failed; the message is LAMMPS's.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "in.bench").write_text(script)
    command = [str(lmp), "-in", "in.bench", "-log", "none", "-nocite"]
    environment = dict(os.environ, OMP_NUM_THREADS="1")
    if ranks > 1:
        command = ["mpirun", "-np", str(ranks), *command]
    starter = [sys.executable, "-I", "-S", str(Path(__file__).with_name("usage.py")), "usage"]
    with (folder / "screen").open("w+") as screen:
        done = subprocess.run(
            [*starter, *command],
            cwd=folder,
            env=environment,
            stdout=screen,
            stderr=subprocess.STDOUT,
            check=False,
        )
        screen.seek(0)
        log = screen.read()
    if done.returncode != 0:
        last = [line for line in log.splitlines() if line.startswith("ERROR")] or [log[-400:]]
        raise RuntimeError(f"{folder / 'in.bench'}: {last[0]}")
    memory, processor = (folder / "usage").read_text().split()
    return _parsed(log, ranks, int(memory), float(processor), loop)


def _parsed(log: str, ranks: int, memory: int, processor: float, loop: int) -> Timing:
    loops = re.findall(r"Loop time of (\S+) on \d+ procs for (\d+) steps with (\d+) atoms", log)
    wall, steps, nodes = float(loops[loop][0]), int(loops[loop][1]), int(loops[loop][2])
    share = 1.0
    if ranks == 1:
        share = float(re.findall(r"([\d.]+)% CPU use", log)[-1]) / 100.0
    breakdown = log[log.rindex("MPI task timing breakdown") :] if "timing breakdown" in log else ""
    sections = {}
    for name in SECTIONS:
        row = re.search(rf"^{name} +\|([^|]*)\|([^|]*)\|", breakdown, re.MULTILINE)
        if row:
            sections[name] = float(row[2]) * share
    builds = re.findall(r"Neighbor list builds = (\d+)", log)
    ghosts = re.findall(r"Nghost: +(\S+) ave", log)
    return Timing(
        steps=steps,
        seconds=wall * share,
        nodes=nodes,
        sections=sections,
        memory=memory,
        processor=processor,
        builds=int(builds[-1]) if builds else 0,
        ghosts=float(ghosts[-1]) if ghosts else 0.0,
        log=log,
    )


def in_turns(
    lmp: Path, scripts: Mapping[str, str], folder: Path, repeats: int = 3
) -> dict[str, list[Timing]]:
    """Run each of the scripts several times, in turns, so that all of them see the same machine."""
    timings: dict[str, list[Timing]] = {name: [] for name in scripts}
    for _ in range(repeats):
        for name, script in scripts.items():
            timings[name].append(run(lmp, script, folder / name))
    return timings


def median(timings: Sequence[Timing]) -> Timing:
    """The run with the median time."""
    middle = statistics.median_low([timing.seconds for timing in timings])
    return next(timing for timing in timings if timing.seconds == middle)
