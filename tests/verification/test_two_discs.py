"""A disc falls on a held one: node by node through the contact against the PeriDEM library.

Time stepping: see test_stretched_disc.  PeriDEM's velocity v at a dump is LAMMPS's velocity minus
half a kick, so a run that starts from a dump adds dt f/2m with the forces of ``run 0``.
The held disc is not moved at all and the contact has neither friction nor damping.
"""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import cloud
from support.oracle import Contact
from support.peridem_data import Recording, jha_solid
from support.runs import contact_words, lps_words, number

DT, GRAVITY = 3e-8, 10.0
FIRST_TOUCH, LAST_TOUCH = 140600, 142100  # as recorded


@pytest.fixture
def recording() -> Recording:
    return Recording("twop_circ_nodamp_fine")


def started(simulation, recording, step):
    """LAMMPS in the recorded state of ``step``, with velocities half a kick ahead."""
    state, particles = recording.at(step), recording.particles
    one = cloud(
        state.reference,
        volume=state.volume,
        molecule=state.particle + 1,
        density=float(particles[0]["density"]),
        types=state.particle + 1,
        dimension=2,
        margin=2e-3,
    )
    # both discs have one h, horizon and material, to the last digits of h
    law = Contact(
        radius=float(recording.contacts[1]["contactR"]),
        stiffness=float(recording.contacts[1]["Kn"]),
    )
    sim = simulation().load(
        one.moved(state.reference + state.u, state.v), dimension=2, units="si", skin=3e-4
    )
    sim.commands(
        f"""
        group falling type 2
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff 1 1 peridem/lps {lps_words(jha_solid(particles[0]))}
        pair_coeff 2 2 peridem/lps {lps_words(jha_solid(particles[1]))}
        pair_coeff * * peridem/contact {contact_words(law)}
        fix weight falling gravity {GRAVITY} vector 0 -1 0
        fix motion falling nve
        timestep {number(DT)}
        run 0 post no
        """
    )
    sim.kick = lambda: 0.5 * DT * sim.atoms("f") / sim.atoms("rmass")[:, None]
    count, order = sim.lmp.extract_global("nlocal"), sim.order
    falling = state.particle == 1
    ahead = state.v + np.where(falling[:, None], sim.kick(), 0.0)
    sim.lmp.numpy.extract_atom("v")[:count][order] = ahead
    return sim, falling


def errors(sim, falling, recording, step):
    """Largest error of position over the deformation, and of velocity over the speed."""
    expected = recording.at(step)
    u, v = sim.atoms("x") - sim.atoms("x0"), sim.atoms("v") - sim.kick()
    mean = expected.u[falling].mean(axis=0)
    deformation = np.abs(expected.u[falling] - mean).max()
    du = np.abs(u - expected.u)[falling].max()
    dv = np.abs(v - expected.v)[falling].max() / np.abs(expected.v[falling]).max()
    return du, deformation, dv


def test_state_during_and_after_the_first_contact(simulation, recording):
    """From the recorded fall at step 140000, through the touch, to step 144000."""
    sim, falling = started(simulation, recording, 140000)
    done = 140000
    for step in (141000, 142000, 143000, 144000):
        sim.commands(f"run {step - done} post no")
        done = step
        du, deformation, dv = errors(sim, falling, recording, step)
        # Coordinates of 4e-3 are rounded to 4e-19 at each step; in contact k_N V = 4e16 turns that
        # into 2e-2 of 7e8 in force density, and 4000 steps into 1e-9 of the deformation (1e-6).
        assert du < 1e-7 * deformation
        assert dv < 1e-7
    assert np.all((sim.atoms("x") - sim.atoms("x0"))[~falling] == 0.0)


@pytest.mark.slow
def test_state_from_the_start_to_the_end(simulation, recording):
    """All 160000 steps: fall, contact and rebound."""
    sim, falling = started(simulation, recording, 0)
    done = 0
    for step in recording.steps[1:]:
        sim.commands(f"run {step - done} post no")
        done = step
        du, deformation, dv = errors(sim, falling, recording, step)
        # 140000 steps of fall round the position, u = 4e-4 added up, to a part in 1e13 of 4e-4
        assert du < 1e-16 + 1e-6 * deformation
        assert dv < 1e-6
