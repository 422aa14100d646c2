"""A spherical pulse in a cube against the classical solution."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

from bench.machine import Machine
from bench.pareto import front
from bench.pareto.meter import Meter
from bench.table import Row
from support.oracle import Solid
from verification.cases import waves

TITLE = "Speed against error: a spherical pulse in a cube"
KIND = "quantity"
COUNTS, MS = (12, 16, 24, 32, 40, 64), (2, 3, 4)
DEFAULT_COURANT = 0.4
DEFAULT = {
    "nodes": 24**3,
    "m": 3,
    "influence": "linear",
    "volume": "taper",
    "step, h/c": DEFAULT_COURANT,
}


@dataclass(frozen=True)
class Choice:
    """Nodes along the cube, horizon over spacing, influence, volumes, time step over h/c."""

    count: int
    m: int = 3
    influence: str = "linear"
    volume: str = "taper"
    courant: float = DEFAULT_COURANT


def choices(quick: bool) -> list[Choice]:
    """All resolutions with the two influences that are used most; the rest at one of them."""
    counts = COUNTS[:2] if quick else COUNTS
    all_of = [
        Choice(count, m, influence)
        for count in counts
        for m in (MS[:2] if quick else MS)
        for influence in ("linear", "constant")
        if count * m <= 192  # half a minute
    ]
    one = counts[-1] if quick else 24
    all_of += [Choice(one, influence=name) for name in ("inverse", "gaussian")]
    all_of += [Choice(one, influence=name, volume="full") for name in ("linear", "constant")]
    return all_of + [Choice(one, courant=step) for step in (0.1, 0.8)]


def run(one: Choice, folder: Path) -> Row:
    """Relative L2 error of the radial displacement between r = 0.1 and 0.45."""
    h, cube = 1.0 / one.count, waves.CUBE
    # gaussian: exp(-q²/b) with the width that the Python package takes
    solid = Solid(
        cube["bulk"],
        cube["shear"],
        (one.m + 0.015) * h,
        influence=one.influence,
        gaussian_b=0.2,
        taper=one.volume == "taper",
    )
    lab = Meter(folder)
    try:
        r, u = waves.pulse(lab, one.count, solid, one.courant)
    finally:
        lab.close()
    keep = (r > 0.1) & (r < 0.45)
    exact = waves.classical_pulse(r[keep], waves.END)
    return {
        KIND: "displacement",
        "nodes": one.count**3,
        "m": one.m,
        "influence": one.influence,
        "volume": one.volume,
        "step, h/c": one.courant,
        front.COST: lab.seconds,
        front.ERROR: waves.relative(u[keep], exact),
    }


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """A row for each choice, cheapest first."""
    with tempfile.TemporaryDirectory(dir=folder) as place:
        return front.mark([run(one, Path(place)) for one in choices(quick)])


def comment(rows: list[Row], machine: Machine) -> str:
    """What to use, and what the defaults cost."""
    return f"""\
The case `pulse` of doc/verification.md: the error is the relative L2 difference of the radial
displacement from the classical solution when the pulse has travelled its own width; m is the
horizon over the node spacing, less 0.015. A star marks what no cheaper run beats.

{front.text(rows, KIND, "nodes")}

{front.changes_text(rows, KIND, DEFAULT)}"""


def plot(rows: list[Row], path: Path) -> None:
    """Error against cost, coloured by m."""
    front.plot(rows, path, KIND, "m")
