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
RANKS = (2, 4, 16, 64, 256, 1024, 4096)
FEWEST, HALF = 50, 0.5  # nodes of a rank; efficiency that is worth having
MODEL = "model: "
MEASURED, PREDICTED = "ms per step", "predicted, ms"
SUMS = 0.2 + 1.0  # of all ranks per step: the time step's every ten steps, the list's check


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """Rows of runs and of the model."""
    count, steps, repeats = (64, 20, 1) if quick else (502, 500, 3)
    clouds = scripts.two_shapes()
    one = _run(lmp, count, steps, 1, folder, clouds, repeats)
    two = _run(lmp, count, steps, 2, folder, clouds, repeats)
    double = _run(lmp, 2 * count, steps, 2, folder, clouds, repeats)
    four = _run(lmp, count, 1, 4, folder, clouds, 1)
    here = latency()
    rows = [
        _row(f"one rank, {count} grains", 1, one, one, here),
        _row("two ranks, the same grains (strong)", 2, two, one, here),
        _row("two ranks, twice the grains (weak)", 2, double, one, here),
    ]
    # more ranks than cores, for the ghosts alone
    counted = _row("four ranks, the same grains, ghosts", 4, four, one, here)
    rows.append({**counted, MEASURED: "", PREDICTED: "", "efficiency": ""})
    return rows + _model(one, count)


def _run(
    lmp: Path,
    count: int,
    steps: int,
    ranks: int,
    folder: Path,
    clouds: list[Cloud],
    repeats: int,
) -> timing.Timing:
    data = scripts.packed_grains(count, folder, clouds)
    script = scripts.compression(data, steps)
    where = folder / f"ranks_{ranks}_{count}"
    return timing.median([timing.run(lmp, script, where, ranks) for _ in range(repeats)])


def _row(
    what: str, ranks: int, one: timing.Timing, base: timing.Timing, network: tuple[float, float]
) -> Row:
    per_node = one.seconds / one.steps / one.nodes
    width = _width(base)
    ghosts = _frame(one.nodes, ranks, width, scripts.GAP, outer=True) if ranks > 1 else 0.0
    alone = base.seconds / base.steps / base.nodes
    return {
        "what": what,
        "ranks": ranks,
        "nodes": one.nodes,
        MEASURED: 1e3 * one.seconds / one.steps,
        PREDICTED: 1e3 * _step(alone, one.nodes, ranks, ghosts, network),
        "efficiency": alone / (per_node * ranks),
        "ghosts per rank": one.ghosts,
        "by the model": ghosts,
    }


def _step(
    per_node: float, nodes: float, ranks: int, ghosts: float, network: tuple[float, float]
) -> float:
    """Seconds of a step by the model; network: latency, s, and bandwidth, bytes/s."""
    latency, bandwidth = network
    if ranks == 1:
        return per_node * nodes
    messages = (MESSAGES + SUMS * math.log2(ranks)) * latency
    return per_node * nodes / ranks + GHOST_BYTES * ghosts / bandwidth + messages


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


def _model(one: timing.Timing, count: int) -> list[Row]:
    rows: list[Row] = []
    per_node = one.seconds / one.steps / one.nodes
    for name, network in NETWORKS.items():
        for grains in (count, 100 * count):
            nodes = one.nodes * grains / count
            for ranks in RANKS:
                if nodes / ranks < FEWEST:
                    continue
                # free room between the grains makes the box a little larger than its nodes fill:
                # GAP is the spacing of nodes all over the box
                ghosts = _frame(nodes, ranks, _width(one), scripts.GAP, outer=False)
                total = _step(per_node, nodes, ranks, ghosts, network)
                rows.append(
                    {
                        "what": f"{MODEL}{grains} grains, {name}",
                        "ranks": ranks,
                        "nodes": int(nodes),
                        PREDICTED: 1e3 * total,
                        "efficiency": per_node * nodes / ranks / total,
                        "by the model": ghosts,
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
    """What the model assumes, how it does here, and where it ends."""
    networks = [
        f"{name}: {1e6 * a:.1f} µs, {b / 1e9:.0f} GB/s" for name, (a, b) in NETWORKS.items()
    ]
    two = [row for row in rows if row["ranks"] == 2 and MEASURED in row]
    off = ", ".join(f"{_number(row, MEASURED) / _number(row, PREDICTED):.2f}" for row in two)
    counted = [row for row in rows if MEASURED in row and row["ranks"] != 1]
    ghosts = ", ".join(
        f"{_number(row, 'ghosts per rank') / _number(row, 'by the model'):.2f}" for row in counted
    )
    return f"""\
A step of P ranks with N nodes is said to take c N/P + B G/b + m l + r l log2(P): c as measured on
one rank, B = {GHOST_BYTES} bytes for each of G ghosts (a frame as wide as the ghost cutoff around
the square of a rank), m = {MESSAGES} messages to neighbours, r = {SUMS:g} sums over all ranks,
latency l and bandwidth b. In the rows that were run l and b are those between two ranks of this
machine, in the others {"; ".join(networks)}.
Measured over predicted: {off} for two ranks; ghosts counted over those of the model: {ghosts}.
Runs on several ranks are wall-clock time: other work on the machine shows in them. The model knows
no imbalance: `fix balance` has to keep the nodes per rank even.

{_good(rows)}"""


def _good(rows: list[Row]) -> str:
    """For each scene of the model, how far ranks are worth having."""
    lines = []
    for what in dict.fromkeys(str(row["what"]) for row in rows if MODEL in str(row["what"])):
        mine = [row for row in rows if row["what"] == what]
        worth = [row for row in mine if _number(row, "efficiency") >= HALF]
        if worth:
            last = max(worth, key=lambda row: _number(row, "ranks"))
            each = _number(last, "nodes") / _number(last, "ranks")
            lines.append(
                f"* {what.removeprefix(MODEL)}: {last['ranks']} ranks at an efficiency of "
                f"{_number(last, 'efficiency'):.2f}, {each:.0f} nodes each"
            )
        else:
            lines.append(f"* {what.removeprefix(MODEL)}: below {HALF:g} from 2 ranks on")
    return f"Most ranks of an efficiency of {HALF:g} or more:\n\n" + "\n".join(lines)


def _number(row: Row, key: str) -> float:
    return float(str(row[key]))


def plot(rows: list[Row], path: Path) -> None:
    """Efficiency against ranks: the model's, and what was measured."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7.6, 4.2), layout="constrained")
    names = dict.fromkeys(str(row["what"]) for row in rows if MODEL in str(row["what"]))
    for name, style in zip(names, ("o-", "o--", "s-", "s--"), strict=False):
        mine = [row for row in rows if row["what"] == name]
        x, y = ([_number(row, key) for row in mine] for key in ("ranks", "efficiency"))
        axes.plot(x, y, style, ms=4, label=name.removeprefix(MODEL))
    two = [row for row in rows if row["ranks"] == 2 and MEASURED in row]
    measured = [_number(row, "efficiency") for row in two]
    axes.plot([2] * len(two), measured, "k*", ms=9, label="measured: strong, weak")
    axes.set_xscale("log", base=2)
    axes.set_xticks(RANKS, [str(ranks) for ranks in RANKS])
    top = max(1.05, *(1.05 * value for value in measured))
    axes.set(xlabel="ranks", ylabel="efficiency", ylim=(0, top), title="Model of ranks")
    figure.legend(fontsize="small", loc="outside right center")
    figure.savefig(path, dpi=130)
    plt.close(figure)
