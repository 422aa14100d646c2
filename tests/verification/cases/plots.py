"""One look for all plots of the report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib

matplotlib.use("Agg")

from matplotlib.figure import Figure

from .base import Row

COLOURS = ("#0b5394", "#cc4125", "#38761d", "#8e5ea2", "#e69138", "#444444", "#45818e")
STYLE = {
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.prop_cycle": matplotlib.cycler(color=COLOURS),
    "lines.linewidth": 1.4,
    "lines.markersize": 4.5,
    "legend.frameon": False,
    "legend.fontsize": 8,
}


def panels(count: int = 1, width: float = 4.2, height: float = 3.2) -> tuple[Figure, list[Any]]:
    """A figure with ``count`` plots side by side."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(width * count, height), layout="constrained")
        axes = figure.subplots(1, count, squeeze=False)[0]
    return figure, list(axes)


def save(figure: Figure, path: str) -> None:
    with matplotlib.rc_context(STYLE):
        figure.savefig(path, dpi=110, metadata={"Software": None})


def cloud(ax: Any, x: Any, values: Any, label: str, unit: float = 1.0, **options: Any) -> None:
    """Nodes as dots coloured by a value; lengths over ``unit``."""
    options = {"s": 2.0, "cmap": "viridis", "linewidths": 0} | options
    dots = ax.scatter(x[:, 0] / unit, x[:, 1] / unit, c=values, rasterized=True, **options)
    ax.set_aspect("equal")
    ax.grid(False)
    ax.figure.colorbar(dots, ax=ax, label=label, shrink=0.85)


def plain_log(axis: Any) -> None:
    """Numbers as they are on a logarithmic axis of less than two decades."""
    from matplotlib.ticker import LogLocator, ScalarFormatter

    axis.set_major_locator(LogLocator(subs=(1, 2, 3, 5)))
    axis.set_major_formatter(ScalarFormatter())
    axis.set_minor_locator(LogLocator(subs=()))


def margins(rows: Sequence[Row]) -> Figure:
    """For cases without a picture of their own: how much of its room each number takes."""
    used = [(row.used, row.holds) for row in rows if row.used is not None]
    figure, (ax,) = panels(1, width=5.0)
    for place, (value, holds) in enumerate(used, 1):
        ax.plot(max(value, 1e-17), place, "o" if holds else "X", color=COLOURS[0 if holds else 1])
    ax.axvline(1.0, color="0.4", lw=1.0)
    ax.set(xscale="log", xlim=(5e-18, 10), xlabel="share of its tolerance that a number takes")
    ax.set(ylabel="number, in the order of the table", ylim=(len(used) + 1, 0))
    return figure
