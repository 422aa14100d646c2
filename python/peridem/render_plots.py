"""Plots of numbers: wall pressure, thermo output, sizes of fragments."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from peridem import results
from peridem.render_style import time_text
from peridem.results_output import Output
from peridem.results_walls import wall_stress
from peridem.scene import WALLS


def _axes(size: tuple[float, float] = (7.0, 4.2), rows: int = 1) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=150, layout="constrained")
    return figure, figure.subplots(rows, 1, sharex=True)


def stress_png(
    folder: str | Path,
    path: str | Path,
    wall: str | None = None,
    frames: Sequence[int] | None = None,
) -> Path:
    """Pressure on a moving wall against how far it has gone; marks at the times of ``frames``."""
    output = Output(folder)
    travel, stress = wall_stress(folder, wall)
    window = max(1, len(stress) // 50)
    smooth = np.convolve(stress, np.full(window, 1.0 / window), "valid")
    middle = np.convolve(travel, np.full(window, 1.0 / window), "valid")
    unit, name = (1e3, "kPa") if smooth.max() < 1e6 else (1e6, "MPa")
    figure, axes = _axes()
    record = results.averages(Path(folder) / WALLS)
    times = record.get("v_now", record["TimeStep"] * float(output.summary["timestep"]))
    every = float(times[-1]) / len(times)
    for x, y, colour, line, span in (
        (travel, stress, "#9db4cc", 0.7, every),
        (middle, smooth, "#1f4e79", 1.8, window * every),
    ):
        label = f"averaged over {time_text(float(f'{span:.2g}'))}"
        axes.plot(1e3 * x, y / unit, color=colour, lw=line, label=label)
    for k, i in enumerate(output.chosen(frames, 4)):
        at = float(np.interp(output.time(i), times, travel))
        value = float(np.interp(at, middle, smooth)) / unit
        axes.plot(1e3 * at, value, "o", mfc="white", mec="#b3261e", ms=6, zorder=5)
        axes.annotate(f"$t_{{{k + 1}}}$", (1e3 * at, value), (4, 8), textcoords="offset points")
    axes.set_xlabel("penetration of the wall (mm)")
    axes.set_ylabel(f"pressure on the wall ({name})")
    axes.set_xlim(0.0, 1.04e3 * float(travel[-1]))
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    figure.savefig(path)
    return Path(path)


def thermo_png(folder: str | Path, path: str | Path, columns: Sequence[str]) -> Path:
    """Columns of the thermo output against time (or steps, where the log lacks the time).

    Raises:
        KeyError: there is no such column; it says which there are.
    """
    table = Output(folder).thermo
    for name in columns:
        if name not in table:
            raise KeyError(f"no column '{name}' in the log; it has {', '.join(table)}")
    figure, rows = _axes((7.0, 1.0 + 2.2 * len(columns)), len(columns))
    along = "Time" if "Time" in table else "Step"
    for axes, name in zip(np.atleast_1d(rows), columns, strict=True):
        axes.plot(table[along], table[name], color="#1f4e79")
        axes.set_ylabel(name)
        axes.grid(alpha=0.3)
    np.atleast_1d(rows)[-1].set_xlabel(along.lower())
    figure.savefig(path)
    return Path(path)


def fragments_png(
    folder: str | Path, path: str | Path, frames: Sequence[int] | None = None
) -> Path:
    """Grading curves: the part of the volume in fragments finer than a size, at some times."""
    output = Output(folder)
    figure, axes = _axes()
    chosen = output.chosen(frames, 4)
    found = [results.fragments(output, i) for i in chosen]
    low = min(float(pieces.size.min()) for pieces in found)
    high = max(float(pieces.size.max()) for pieces in found)
    sizes = np.array(np.geomspace(0.8 * low, 1.25 * high, 400), dtype=np.float64)
    for k, (i, pieces) in enumerate(zip(chosen, found, strict=True)):
        strong = 0.3 + 0.7 * (k + 1) / len(chosen)  # the last one is the darkest
        label = f"{time_text(output.time(i))}: {len(pieces)} fragments"
        finer = 100.0 * pieces.finer(sizes)
        axes.plot(1e3 * sizes, finer, color="#1f4e79", alpha=strong, label=label)
    axes.set_xscale("log")
    axes.set_xlabel("size: diameter of the same volume (mm)")
    axes.set_ylabel("finer, % of the volume")
    axes.grid(alpha=0.3, which="both")
    axes.legend(frameon=False)
    figure.savefig(path)
    return Path(path)
