"""What a straight crack takes, over the Gc asked for: the bonds it cuts, at their critical stretch.

No run is needed: s0 follows from Gc by integrals over the family (doc/theory.rst), and a crack in a
cloud of nodes cuts the bonds that are there.  Finer nodes with the same number of them in a horizon
change nothing, so this error is one of m alone.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from peridem import cloud, shapes
from peridem.cloud import Cloud
from peridem.material import Influence, Material
from scipy.spatial import cKDTree

from bench.machine import Machine
from bench.table import Row

Array = NDArray[np.float64]
TITLE = "What a straight crack takes, over Gc"
MS: tuple[float, ...] = (2.0, 2.05, 2.5, 3.0, 3.05, 3.5, 4.05, 5.05)
INFLUENCES: tuple[Influence, ...] = ("linear", "constant", "inverse", "gaussian")
RADIUS, LENGTH, OFFSET = 14.0, 12.0, 4.0  # of the disc, the cracks, their way from the middle; in h
CUTS = 300
ENERGY, SCATTER = "energy over Gc", "scatter over directions"


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """A row for each influence and m, on a mesh as grains have it."""
    disc = cloud.mesh(shapes.circle(RADIUS), 1.0)
    ms, cuts = (MS[1:4:2], 30) if quick else (MS, CUTS)
    return [_row(disc, m, influence, cuts) for influence in INFLUENCES for m in ms]


def _row(disc: Cloud, m: float, influence: Influence, cuts: int) -> Row:
    solid = Material(1.0, 0.25, 1.0, horizon=m, influence=influence)
    bonds = _Bonds(disc, solid)
    random = np.random.default_rng(1)
    found = [
        bonds.cut(random.uniform(0, np.pi), random.uniform(-1, 1) * OFFSET) for _ in range(cuts)
    ]
    return {
        "influence": influence,
        "m": m,
        "directed bonds per node": 2 * len(bonds.energy) / len(disc.nodes),
        ENERGY: float(np.mean(found)),
        SCATTER: float(np.std(found)),
    }


class _Bonds:
    """All bonds of a cloud, with the energy that each takes over that of a crack of unit length."""

    def __init__(self, disc: Cloud, solid: Material) -> None:
        self.x, volume = np.asarray(disc.nodes), np.asarray(disc.volumes)
        self.i, self.j = cKDTree(self.x).query_pairs(solid.horizon, output_type="ndarray").T
        length = np.linalg.norm(self.x[self.i] - self.x[self.j], axis=1)
        cell = 0.5 * (np.sqrt(volume[self.i]) + np.sqrt(volume[self.j]))
        taken = solid.weight(length / solid.horizon) * length**2 * solid.cut(length, cell)
        whole = 2 * solid.moment(4) * solid.horizon**5  # I of doc/theory.rst, in 2D
        self.energy = taken * volume[self.i] * volume[self.j] / whole

    def cut(self, angle: float, offset: float) -> float:
        """Energy of a crack per length over Gc, with its normal at an angle."""
        normal = np.array([np.cos(angle), np.sin(angle)])
        along = np.array([-normal[1], normal[0]])
        above, below = (self.x[k] @ normal - offset for k in (self.i, self.j))
        crossing = above * below < 0
        share = (above / (above - below))[crossing]
        place = self.x[self.i[crossing]] * (1 - share)[:, None]
        place += self.x[self.j[crossing]] * share[:, None]
        inside = np.abs(place @ along) < 0.5 * LENGTH
        return float(self.energy[crossing][inside].sum() / LENGTH)


def comment(rows: list[Row], machine: Machine) -> str:
    """What it means for Gc."""
    worst, least = (
        pick(rows, key=lambda row: abs(_number(row, ENERGY) - 1)) for pick in (max, min)
    )
    linear = ", ".join(
        f"{100 * (_number(row, ENERGY) - 1):+.0f} % with m = {row['m']}"
        for row in rows
        if row["influence"] == INFLUENCES[0]
    )
    return f"""\\
A gmsh mesh as grains have it; cracks of {LENGTH:g} spacings in {CUTS} places and directions. It is
the number of nodes in a horizon that counts; finer nodes change nothing. The default influence
({INFLUENCES[0]}) takes, against what was asked for, {linear}. Farthest off is {worst["influence"]}
with m = {worst["m"]} ({_number(worst, ENERGY):.2f}), nearest {least["influence"]} with
m = {least["m"]} ({_number(least, ENERGY):.3f}). Give `gc` over the number here to have it right: s0
goes with its root. The scatter over directions tells how much a mesh leads cracks: at most
{max(_number(row, SCATTER) for row in rows):.3f}."""


def _number(row: Row, key: str) -> float:
    return float(str(row[key]))


def plot(rows: list[Row], path: Path) -> None:
    """Energy over Gc against m."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(5.5, 4.0), layout="constrained")
    for influence, marker in zip(INFLUENCES, "os^D", strict=True):
        mine = [row for row in rows if row["influence"] == influence]
        m, energy, scatter = ([_number(row, k) for row in mine] for k in ("m", ENERGY, SCATTER))
        axes.errorbar(m, energy, scatter, marker=marker, lw=1, ms=4, capsize=2, label=influence)
    axes.axhline(1.0, color="0.6", lw=0.8)
    axes.set(xlabel="m: horizon / spacing", ylabel=ENERGY, title=TITLE)
    axes.legend()
    figure.savefig(path, dpi=130)
    plt.close(figure)
