"""Two discs: how far they approach under a force, and how fast they part after a collision."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bench.machine import Machine
from bench.pareto import front
from bench.pareto.meter import Meter
from bench.progress import counted
from bench.table import Row
from support.oracle import Solid
from verification.cases import contact

TITLE = "Speed against error: disc on disc"
KIND = front.KIND
RADII = (6, 9, 13, 18, 25)
SPEED = 0.02  # of approach, over that of longitudinal waves
ASKED = (0.9, 0.7)  # restitution
SIZE = "nodes along a radius"
DEFAULT = {
    SIZE: 13,
    "m": 3,
    "influence": "linear",
    "spring": 10.0,
    "safety": 0.8,
    "tangential": "history",
}


@dataclass(frozen=True)
class Choice:
    """Nodes along a radius, horizon over spacing, influence, spring over K, time step's safety."""

    radius: int
    m: float = 3
    influence: str = "linear"
    spring: float = 10.0
    safety: float = 0.8
    tangential: str = "history"

    @property
    def solid(self) -> Solid:
        flat = contact.FLAT
        return Solid(flat.bulk, flat.shear, self.m + 0.015, 2, influence=self.influence)

    @property
    def words(self) -> str:
        return f"form bulk {self.spring} tangential {self.tangential}"


def choices(quick: bool) -> list[Choice]:
    """All resolutions with all springs, and with the shortest horizon; the rest at two of them."""
    radii = RADII[:2] if quick else RADII
    springs = (1.0, 10.0) if quick else (1.0, 3.0, 10.0, 30.0)
    all_of = [Choice(radius, spring=spring) for radius in radii for spring in springs]
    all_of += [Choice(radius, 2, spring=spring) for radius in radii for spring in springs[-3:-1]]
    for one in () if quick else (Choice(9), Choice(13)):
        all_of += [replace(one, m=2.5), replace(one, m=4), replace(one, influence="constant")]
        all_of += [replace(one, safety=safety) for safety in (0.4, 0.95)]
        all_of += [replace(one, tangential="regularised")]
    return all_of


def _row(kind: str, one: Choice, lab: Meter, error: float) -> Row:
    return {
        KIND: kind,
        SIZE: one.radius,
        "m": one.m,
        "influence": one.influence,
        "spring": one.spring,
        "safety": one.safety,
        "tangential": one.tangential,
        front.COST: lab.seconds,
        front.ERROR: error,
    }


def approach(one: Choice, folder: Path) -> Row:
    """Mean relative error of a disc's approach at three forces, the springs' own included."""
    r = contact.even_radius(one.radius)
    both = contact.disc_on_disc(r)
    both.box[:2] += np.array([[-10.0, 10.0]])
    lab = Meter(folder)
    try:
        # slow enough for waves to cross the column thirty times
        got = contact.pressed(lab, both, one.solid, 0.1 * r, 70.0 * r, 2, one.words, one.safety)
    finally:
        lab.close()
    whole = got.shortened + 0.75 * got.overlap  # of half the column, gaps of its contacts included
    states = [3, 5, 7]
    exact = contact.disc_approach(got.force[states], r)
    return _row("approach", one, lab, float(np.mean(np.abs(whole[states] / exact - 1))))


def restitution(one: Choice, folder: Path) -> Row:
    """Largest difference between the speed of parting over that of approach and what was asked."""
    r = contact.even_radius(one.radius)
    half, errors = 0.5 * SPEED * contact.SPEED, []
    lab = Meter(folder)
    try:
        for asked in ASKED:
            words = f"{one.words} friction 0.3 restitution {asked}"
            both, sim = contact.collision(
                lab, r, words, (half, 0), (-half, 0), solid=one.solid, safety=one.safety
            )
            contact.advance(sim, 0.6 / (2 * half) + 8 * r)
            speeds = [contact.centre_velocity(both, sim, molecule)[0] for molecule in (1, 2)]
            errors.append(abs((speeds[1] - speeds[0]) / (2 * half) - asked))
            lab.close()
    finally:
        lab.close()
    return _row("restitution", one, lab, max(errors))


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """Rows of both quantities, each cheapest first."""
    rows: list[Row] = []
    with tempfile.TemporaryDirectory(dir=folder) as place:
        for case in (approach, restitution):
            rows += front.mark(
                [case(one, Path(place)) for one in counted(choices(quick), case.__name__)]
            )
    return rows


def comment(rows: list[Row], machine: Machine) -> str:
    """What is compared, and what to use."""
    return f"""\
`approach`: a column of two discs between plates; how much each is shortened at a given force, the
overlaps of its contacts included, against Johnson's formula (doc/verification.md, `hertz-discs`),
which takes discs as half-planes: it is itself good to a few per cent at the contact widths here.
`restitution`: two discs meet at {SPEED} of the wave speed; the difference between what was asked
for ({", ".join(f"{e:g}" for e in ASKED)}) and what came out. Springs between nodes are `form bulk`.

{front.text(rows, KIND, SIZE)}

{front.changes_text(rows, KIND, DEFAULT)}"""


def plot(rows: list[Row], path: Path) -> None:
    """Error against cost, coloured by the spring."""
    front.plot(rows, path, KIND, "spring")
