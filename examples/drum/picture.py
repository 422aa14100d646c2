#!/usr/bin/env python3
"""Draws the grains in the drum at four times.

python picture.py [folder of the run] [picture]
"""

from __future__ import annotations

import math
import sys

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from peridem import results
from peridem.render_2d import draw_frame
from peridem.render_style import Style

TIMES = (0.0, 0.1, 0.19, 0.36)  # s
TURN = -6.0 * math.pi  # rad/s, and the drum and fin of in.drum
RADIUS, FIN, HALF = 5e-3, 3.5e-3, 0.4e-3
WALL = "#7d8593"


def fin(angle: float) -> np.ndarray:
    """Its corners, (4, 2), when the drum has turned by an angle."""
    out = 1.02 * RADIUS  # beyond the shell
    corners = np.array([(FIN, -HALF), (out, -HALF), (out, HALF), (FIN, HALF)])
    c, s = np.cos(angle), np.sin(angle)
    return corners @ np.array([(c, s), (-s, c)])


def draw(folder: str, path: str) -> None:
    """One picture for each of the times."""
    output = results.Output(folder)
    times = [output.time(i) for i in range(len(output.dump))]
    figure = Figure(figsize=(10.0, 2.75), dpi=100, layout="constrained", facecolor=WALL)
    for axes, time in zip(figure.subplots(1, len(TIMES)), TIMES, strict=True):
        i = min(range(len(times)), key=lambda k: abs(times[k] - time))
        axes.set_xlim(-1.05 * RADIUS, 1.05 * RADIUS)
        axes.set_ylim(-1.05 * RADIUS, 1.05 * RADIUS)
        axes.set_aspect("equal")
        axes.axis("off")
        axes.set_title(f"{1e3 * times[i]:.0f} ms", fontsize=10, color="white")
        axes.add_patch(Circle((0.0, 0.0), RADIUS, facecolor="white", zorder=0))
        axes.add_patch(Polygon(fin(TURN * times[i]), facecolor=WALL, zorder=0))
        draw_frame(axes, output, i, Style("grain", 0.0, 1.0, "Set2"))
    figure.savefig(path, facecolor=WALL)


if __name__ == "__main__":
    given = sys.argv[1:]
    draw(given[0] if given else ".", given[1] if len(given) > 1 else "grains.png")
