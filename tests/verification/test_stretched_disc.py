"""A disc pulled at two corners, node by node against the states the PeriDEM library recorded.

PeriDEM steps with symplectic Euler: v += dt f/rho, then u += dt v, then f(u).  LAMMPS steps with
velocity Verlet: v += dt f/2m, x += dt v, f(x), v += dt f/2m.  Call w the velocity LAMMPS has
between its half kicks.  From one step to the next w += dt f/m and x += dt w, which is PeriDEM's
sequence with w in the place of its v.  So the two agree step by step when LAMMPS starts with
PeriDEM's velocity plus half a kick, v_LAMMPS = v_PeriDEM + dt f(0)/2m, and their velocities differ
by half a kick in every dump.  Here the disc starts at rest, whole and unloaded: the first half kick
is zero.

Displacement conditions are applied after u += dt v and before the forces, u = rate times the time
of the step that just ended: ``fix move linear`` does the same in its initial_integrate.
"""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import Cloud, cloud
from support.peridem_data import Recorded, Recording, jha_solid
from support.runs import number, solid_script

DT, RATE, DENSITY = 1.25e-6, 0.005, 1200.0


def corner(reference: np.ndarray, low: float, high: float) -> np.ndarray:
    """Nodes whose x and y are both in [low, high]."""
    return np.all((reference[:, :2] >= low) & (reference[:, :2] <= high), axis=1)


def disc_of(state: Recorded) -> Cloud:
    return cloud(state.reference, volume=state.volume, density=DENSITY, dimension=2, margin=2e-3)


def ids(mask: np.ndarray) -> str:
    return " ".join(str(k + 1) for k in np.flatnonzero(mask))


@pytest.fixture
def recording() -> Recording:
    return Recording("single_particle_circle")


def pulled_disc(simulation, recording):
    start = recording.at(0)
    held, pulled = corner(start.reference, -1e-3, -5e-4), corner(start.reference, 5e-4, 1e-3)
    assert np.all(start.u == 0.0) and np.all(start.v[~pulled] == 0.0)
    sim = simulation().load(disc_of(start), dimension=2, units="si", skin=2e-4)
    solid = jha_solid(recording.particles[0])
    sim.commands(solid_script(solid).replace("fix motion all nve", ""))
    sim.commands(
        f"""
        group held id {ids(held)}
        group pulled id {ids(pulled)}
        group free subtract all held pulled
        fix motion free nve
        fix pull pulled move linear {RATE} {RATE} 0.0
        timestep {number(DT)}
        run 0 post no
        """
    )
    return sim, held, pulled


def relative(actual: np.ndarray, expected: np.ndarray) -> float:
    return float(np.abs(actual - expected).max() / np.abs(expected).max())


def test_displacements_velocities_and_forces_at_the_first_dump(simulation, recording):
    """Required: 1e-8 of the largest displacement.  Rounding of 2000 steps leaves far less."""
    sim, held, pulled = pulled_disc(simulation, recording)
    sim.commands("run 2000 post no")
    expected = recording.at(2000)
    u = sim.atoms("x") - sim.atoms("x0")
    force, mass = sim.atoms("f"), sim.atoms("rmass")
    assert np.all(u[held] == 0.0)
    assert relative(u, expected.u) < 1e-8
    # forces follow displacement differences of neighbours, 1/100 of the largest displacement
    density = force / expected.volume[:, None]
    assert relative(density, expected.force_density) < 1e-6
    half_kick = 0.5 * DT * force / mass[:, None]
    free = ~(held | pulled)
    assert relative((sim.atoms("v") - half_kick)[free], expected.v[free]) < 1e-6


def test_displacements_stay_equal_until_the_end(simulation, recording):
    """40000 steps, no breakage, so no chaos: errors of rounding add up but do not explode.

    1e-8 of the largest displacement as for the first dump.
    """
    sim, _, _ = pulled_disc(simulation, recording)
    done = 0
    for step in recording.steps[1:]:
        sim.commands(f"run {step - done} post no")
        done = step
        assert relative(sim.atoms("x") - sim.atoms("x0"), recording.at(step).u) < 1e-8
    assert done == 40000
