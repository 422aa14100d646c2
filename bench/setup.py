"""How long a scene takes to start: meshing, writing, reading, families."""

from __future__ import annotations

import time
from pathlib import Path

from bench import scripts, timing
from bench.machine import Machine
from bench.table import Row

TITLE = "Set-up time"
COUNTS = (64, 256, 1024, 4000)


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """One row for each number of grains; seconds of one core."""
    rows: list[Row] = []
    for count in COUNTS[:2] if quick else COUNTS:
        start = time.process_time()
        clouds = scripts.two_shapes()
        meshed = time.process_time()
        data = scripts.packed_grains(count, folder, clouds)
        written = time.process_time()
        one = timing.run(lmp, scripts.compression(data, 0), folder / f"setup_{count}")
        rows.append(
            {
                "grains": count,
                "nodes": one.nodes,
                "meshing 2 shapes, s": meshed - start,
                "placing and writing, s": written - meshed,
                "reading, families, first step, s": one.processor,
            }
        )
    return rows


def comment(rows: list[Row], machine: Machine) -> str:
    """What dominates."""
    last = rows[-1]
    seconds = float(str(last["reading, families, first step, s"]))
    nodes = float(str(last["nodes"]))
    return f"""\
A shape is meshed once, however many grains have it. LAMMPS needs {1e6 * seconds / nodes:.0f} µs
per node from its start to the first forces, the search for the stable time step included."""
