"""Cost against the number of grains: it has to be a straight line."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bench import scripts, timing
from bench.machine import Machine
from bench.table import Row

TITLE = "Cost against the number of grains"
COUNTS = (4, 16, 64, 256, 1024, 4000)
MANY = 1000  # from here on one run, most of which is set-up, is long enough


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """One row for each number of grains."""
    rows: list[Row] = []
    clouds = scripts.two_shapes()
    for count in COUNTS[:4] if quick else COUNTS:
        data = scripts.packed_grains(count, folder, clouds)
        steps = int(min(2000, max(60, 200_000 / count)))
        script = scripts.compression(data, steps // 10 if quick else steps)
        repeats = 3 if count < MANY else 1
        where = folder / f"grains_{count}"
        one = timing.median([timing.run(lmp, script, where) for _ in range(repeats)])
        rows.append(
            {
                "grains": count,
                "nodes": one.nodes,
                "steps": one.steps,
                "ms per step": 1e3 * one.seconds / one.steps,
                "ns per node and step": one.per_node,
            }
        )
    return rows


def comment(rows: list[Row], machine: Machine) -> str:
    """How straight the line is."""
    count = np.array([float(str(row["grains"])) for row in rows])
    cost = np.array([float(str(row["ms per step"])) for row in rows])
    power = np.polyfit(np.log(count[1:]), np.log(cost[1:]), 1)[0]
    return f"""\
Between {count[1]:.0f} and {count[-1]:.0f} grains the cost grows like the number of grains to the
power of {power:.2f}."""


def plot(rows: list[Row], path: Path) -> None:
    """ms per step against grains, with a straight line through the largest."""
    import matplotlib.pyplot as plt

    count = np.array([float(str(row["grains"])) for row in rows])
    cost = np.array([float(str(row["ms per step"])) for row in rows])
    figure, axes = plt.subplots(figsize=(5.5, 4.0), layout="constrained")
    axes.loglog(count, cost, "o-", label="measured")
    axes.loglog(count, cost[-1] * count / count[-1], "k:", label="in proportion to the grains")
    axes.set(xlabel="grains", ylabel="ms per step, one core", title=TITLE)
    axes.legend()
    figure.savefig(path, dpi=130)
    plt.close(figure)
