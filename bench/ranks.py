"""Ranks: measured on 1 and 2, on paper to 4096.

The model is one of computation and messages for a scene in a square box, cut into squares:

    T(P) = c N/P + B G(P)/b + m l + r l log2(P)

with c the measured seconds per node and step on one rank, G(P) the ghosts of a rank, B the bytes a
ghost moves in a step, b and l bandwidth and latency, m messages to the neighbours, and r sums over
all ranks per step.  G is density times the area of a frame as wide as the ghost cutoff around a
rank's square; it is compared with what LAMMPS counts on 2 and 4 ranks.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

from peridem.cloud import Cloud

from bench import scripts, timing
from bench.machine import Machine
from bench.table import Row

TITLE = "Ranks"
NETWORKS = {"InfiniBand class": (1.5e-6, 10e9), "Ethernet class": (20e-6, 1e9)}
GHOST_BYTES = 8 * (3 + 3 + 1 + 3)  # positions, velocities, dilatation there; forces back
MESSAGES = 4 * 3  # four neighbours; positions with velocities, dilatation, forces
SUMS = 0.2 + 1.0  # of all ranks per step: the time step's every ten steps, the list's check


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """Rows of runs and of the model."""
    count, steps = (64, 100) if quick else (502, 500)
    clouds = scripts.two_shapes()
    one = _run(lmp, count, steps, 1, folder, clouds)
    two = _run(lmp, count, steps, 2, folder, clouds)
    double = _run(lmp, 2 * count, steps, 2, folder, clouds)
    four = _run(lmp, count, 50, 4, folder, clouds)
    rows = [
        _row("measured", 1, one, one),
        _row("measured, same grains (strong)", 2, two, one),
        _row("measured, twice the grains (weak)", 2, double, one),
    ]
    rows += [_ghost_row(p, run, one) for p, run in ((2, two), (4, four))]
    rows += _model(one, count)
    return rows


def _run(
    lmp: Path, count: int, steps: int, ranks: int, folder: Path, clouds: list[Cloud]
) -> timing.Timing:
    data = scripts.packed_grains(count, folder, clouds)
    script = scripts.compression(data, steps)
    where = folder / f"ranks_{ranks}_{count}"
    return timing.median([timing.run(lmp, script, where, ranks) for _ in range(3)])


def _row(what: str, ranks: int, one: timing.Timing, base: timing.Timing) -> Row:
    per_node = one.seconds / one.steps / one.nodes
    return {
        "what": what,
        "ranks": ranks,
        "nodes": one.nodes,
        "ms per step": 1e3 * one.seconds / one.steps,
        "efficiency": base.seconds / base.steps / base.nodes / (per_node * ranks),
        "ghosts per rank": one.ghosts,
    }


def _frame(nodes: float, ranks: int, width: float, spacing: float, outer: bool) -> float:
    """Ghosts of a rank of a square box cut into squares; outer: of the average rank of a few."""
    columns = 2 ** math.ceil(math.log2(ranks) / 2)
    rows = ranks // columns
    side = math.sqrt(nodes) * spacing
    across, along = side / columns, side / rows
    sides_x, sides_y = (2, 2) if not outer else (2 - 2 / columns, 2 - 2 / rows)
    area = width * (sides_x * along + sides_y * across) + sides_x * sides_y * width**2
    return float(area / spacing**2)


def _width(one: timing.Timing) -> float:
    return one.number(r"ghost atom cutoff = (\S+)")


def _ghost_row(ranks: int, run: timing.Timing, base: timing.Timing) -> Row:
    # free room between the grains makes the box a little larger than its nodes fill: the spacing of
    # nodes all over the box
    spacing = scripts.GAP
    return {
        "what": f"ghosts by the model: {_frame(run.nodes, ranks, _width(base), spacing, True):.0f}",
        "ranks": ranks,
        "nodes": run.nodes,
        "ms per step": "",
        "efficiency": "",
        "ghosts per rank": run.ghosts,
    }


def _model(one: timing.Timing, count: int) -> list[Row]:
    rows: list[Row] = []
    per_node = one.seconds / one.steps / one.nodes
    for name, (latency, bandwidth) in NETWORKS.items():
        for grains in (count, 100 * count):
            nodes = one.nodes * grains / count
            for ranks in (2, 16, 128, 1024, 4096):
                if nodes / ranks < 50:
                    continue
                ghosts = _frame(nodes, ranks, _width(one), scripts.GAP, False)
                messages = MESSAGES * latency + SUMS * latency * math.log2(ranks)
                total = per_node * nodes / ranks + GHOST_BYTES * ghosts / bandwidth + messages
                rows.append(
                    {
                        "what": f"model, {grains} grains, {name}",
                        "ranks": ranks,
                        "nodes": int(nodes),
                        "ms per step": 1e3 * total,
                        "efficiency": per_node * nodes / ranks / total,
                        "ghosts per rank": ghosts,
                    }
                )
    return rows


def latency() -> tuple[float, float]:
    """Latency, s, and bandwidth, bytes/s, between two ranks of this machine."""
    program = str(Path(__file__).with_name("pingpong.py"))
    done = subprocess.run(
        ["mpirun", "-np", "2", sys.executable, program],
        capture_output=True,
        text=True,
        check=True,
        env=dict(os.environ),
    )
    short, fast = done.stdout.split()
    return float(short), float(fast)


def comment(rows: list[Row], machine: Machine) -> str:
    """What the model assumes, and where it ends."""
    seconds, fast = latency()
    networks = [
        f"{name}: {1e6 * a:.1f} µs, {b / 1e9:.0f} GB/s" for name, (a, b) in NETWORKS.items()
    ]
    return f"""\
Two ranks of this machine exchange a short message in {1e6 * seconds:.1f} µs and long ones at
{fast / 1e9:.1f} GB/s; the networks of the model are {", ".join(networks)}.
The measured runs use wall-clock time: other work on the machine shows in them.  The model knows no
imbalance: `fix balance` has to keep the nodes per rank even."""
