"""A plate with a hole, pulled, against Kirsch's solution."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

from bench.machine import Machine
from bench.pareto import front
from bench.pareto.meter import Meter
from bench.progress import counted
from bench.table import Row
from support.oracle import Solid
from verification.cases import convergence

TITLE = "Speed against error: a plate with a hole"
KIND = front.KIND
SIZES, MS = (4, 6, 9, 13), (2, 3, 4)
LONGEST = 0.76  # horizon over the hole's radius: the held frame is two horizons of four radii
SIZE = "nodes along the radius"
DEFAULT = {SIZE: 9, "m": 3, "influence": "linear", "volume": "taper", "nodes": "gmsh"}


@dataclass(frozen=True)
class Choice:
    """Nodes along the hole's radius, horizon over spacing, influence, volumes, where nodes lie."""

    size: int
    m: float = 3
    influence: str = "linear"
    volume: str = "taper"
    nodes: str = "gmsh"


def choices(quick: bool) -> list[Choice]:
    """All resolutions with two influences and both kinds of nodes; the rest at some of them."""
    sizes = SIZES[:2] if quick else SIZES
    all_of = [
        Choice(size, m, influence, nodes=nodes)
        for size in sizes
        for m in (MS[:2] if quick else MS)
        for influence, nodes in (("linear", "gmsh"), ("constant", "gmsh"), ("linear", "lattice"))
        if m / size <= LONGEST
    ]
    for one in sizes[-1:] if quick else (6, 9, 13):
        all_of += [Choice(one, influence=name) for name in ("inverse", "gaussian")]
        all_of += [Choice(one, volume="full"), Choice(one, 2.5)]
    return all_of


def run(one: Choice, folder: Path) -> Row:
    """Relative L2 error of what the hole adds to the displacement."""
    plate, h = convergence.PLATE, 1.0 / one.size
    solid = Solid(
        plate.bulk,
        plate.shear,
        (one.m + 0.015) * h,
        2,
        plane="stress",
        influence=one.influence,
        gaussian_b=0.2,
        taper=one.volume == "taper",
    )
    lab = Meter(folder)
    try:
        found = convergence.pulled_plate(lab, h, one.nodes, solid)
    finally:
        lab.close()
    return {
        KIND: "displacement",
        SIZE: one.size,
        "m": one.m,
        "influence": one.influence,
        "volume": one.volume,
        "nodes": one.nodes,
        front.COST: lab.seconds,
        front.ERROR: found.error_of_hole,
    }


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """A row for each choice, cheapest first."""
    with tempfile.TemporaryDirectory(dir=folder) as place:
        return front.mark([run(one, Path(place)) for one in counted(choices(quick), "hole")])


def comment(rows: list[Row], machine: Machine) -> str:
    """What to use."""
    return f"""\
The case `hole` of doc/verification.md: plane stress, a square plate ten radii wide whose frame is
held as in an endless plate. The error is the L2 difference of the displacement from Kirsch's
solution over the L2 norm of what the hole adds to that of a whole plate (over the displacement
itself it is some ten times smaller). Nodes are those of a gmsh mesh or of a square lattice with a
stair for an edge.

{front.text(rows, KIND, SIZE)}

{front.changes_text(rows, KIND, DEFAULT)}"""


def plot(rows: list[Row], path: Path) -> None:
    """Error against cost, coloured by m."""
    front.plot(rows, path, KIND, "m")
