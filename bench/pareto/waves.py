"""A spherical pulse in a cube against the classical solution."""

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
from verification.cases import waves

TITLE = "Speed against error: a spherical pulse in a cube"
KIND = front.KIND
COUNTS, MS = (20, 28, 40, 56), (2, 3, 4)
MOST = 168  # nodes along the cube times m: half a minute of processor time for all with more
SIZE = "nodes"
DEFAULT = {SIZE: 28**3, "m": 3, "influence": "linear", "volume": "taper", "safety": 0.8}


@dataclass(frozen=True)
class Choice:
    """Nodes along the cube, horizon over spacing, influence, volumes, step over the stable one."""

    count: int
    m: float = 3
    influence: str = "linear"
    volume: str = "taper"
    safety: float = 0.8


def choices(quick: bool) -> list[Choice]:
    """All resolutions with the two influences that are used most; the rest at one of them."""
    counts = (12, 16) if quick else COUNTS
    all_of = [
        Choice(count, m, influence)
        for count in counts
        for m in (MS[:2] if quick else MS)
        for influence in ("linear", "constant")
        if count * m <= MOST
    ]
    for one in counts[-1:] if quick else (28, 40):
        all_of += [Choice(one, influence=name) for name in ("inverse", "gaussian")]
        all_of += [Choice(one, volume="full"), Choice(one, 2.5)]
        all_of += [Choice(one, safety=safety) for safety in (0.4, 0.95)]
    return all_of


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
        r, u = waves.pulse(lab, one.count, solid, one.safety)
    finally:
        lab.close()
    keep = (r > 0.1) & (r < 0.45)
    exact = waves.classical_pulse(r[keep], waves.END)
    return {
        KIND: "displacement",
        SIZE: one.count**3,
        "m": one.m,
        "influence": one.influence,
        "volume": one.volume,
        "safety": one.safety,
        front.COST: lab.seconds,
        front.ERROR: waves.relative(u[keep], exact),
    }


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """A row for each choice, cheapest first."""
    with tempfile.TemporaryDirectory(dir=folder) as place:
        return front.mark([run(one, Path(place)) for one in counted(choices(quick), "waves")])


def comment(rows: list[Row], machine: Machine) -> str:
    """What to use, and what the defaults cost."""
    return f"""\
The case `pulse` of doc/verification.md: the error is the relative L2 difference of the radial
displacement from the classical solution when the pulse has travelled its own width; m is the
horizon over the node spacing, less 0.015. A star marks what no cheaper run beats.

{front.text(rows, KIND, SIZE)}

{front.changes_text(rows, KIND, DEFAULT)}"""


def plot(rows: list[Row], path: Path) -> None:
    """Error against cost, coloured by m."""
    front.plot(rows, path, KIND, "m")
