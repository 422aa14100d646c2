"""The numpy model against forces that the PeriDEM library computed at its recorded states.

This checks the oracle of all other tests against a code it shares nothing with.
"""

from __future__ import annotations

import numpy as np
import pytest

from support.oracle import Contact, bond_state, contact_pairs, contact_state, families
from support.peridem_data import Recording, jha_solid


def nodes_of(state, particle):
    return state.particle == int(particle["particle"])


@pytest.mark.parametrize("case", ["single_particle_circle", "twop_circ_nodamp_fine"])
def test_dilatation_and_weighted_volume(case):
    recording = Recording(case)
    compared = 0
    for step in recording.steps:
        state = recording.at(step)
        for particle in recording.particles:
            mine = nodes_of(state, particle)
            bonds = families(
                state.reference[mine],
                state.volume[mine],
                np.ones(mine.sum(), int),
                jha_solid(particle),
            )
            # their 2D linear influence function carries a factor 12, which cancels in the force
            np.testing.assert_allclose(12 * bonds.m, state.m[mine], rtol=1e-12)
            theta = bond_state(bonds, (state.reference + state.u)[mine]).theta
            largest = np.abs(state.theta[mine]).max()
            if largest > 1e-8:  # smaller ones are rounding of coordinates: 1e-16 / 1e-8 = 1e-8
                compared += 1
                np.testing.assert_allclose(theta, state.theta[mine], rtol=0, atol=1e-9 * largest)
    assert compared >= 3


def test_force_density_of_the_stretched_disc_to_rounding():
    recording = Recording("single_particle_circle")
    solid = jha_solid(recording.particles[0])
    for step in recording.steps[1:]:
        state = recording.at(step)
        ones = np.ones(len(state.volume), int)
        bonds = families(state.reference, state.volume, ones, solid)
        force = bond_state(bonds, state.reference + state.u).force / state.volume[:, None]
        # both codes sum 28 rounded terms
        np.testing.assert_allclose(
            force, state.force_density, rtol=0, atol=1e-13 * np.abs(state.force_density).max()
        )


def test_force_density_through_contact():
    """Falling disc: bonds, contact with the held disc, and weight."""
    recording = Recording("twop_circ_nodamp_fine")
    pair = recording.contacts[1]
    law = Contact(radius=float(pair["contactR"]), stiffness=float(pair["Kn"]))
    falling = recording.particles[1]
    touched = 0
    for step in recording.steps:
        state = recording.at(step)
        mine, x = nodes_of(state, falling), state.reference + state.u
        bonds = families(
            state.reference[mine], state.volume[mine], np.ones(mine.sum(), int), jha_solid(falling)
        )
        pairs = contact_pairs(state.particle, state.reference, law.radius, None, fragments=False)
        contact = contact_state(law, *pairs, x, state.v, state.volume)
        touched += int((contact.normal > 0).sum())
        force = contact.force[mine]
        force += bond_state(bonds, x[mine]).force
        density = force / state.volume[mine][:, None]
        density[:, 1] -= 10.0 * float(falling["density"])
        theirs = state.force_density[mine]
        # r is known to a few units in the last place of the coordinates, 4e-3.  One such error is
        # multiplied by K/horizon^2 ~ 6e13 in bonds and by k_N V ~ 4e16 in a contact, beside
        # densities of 1.2e4 (weight) and 7e8 (contact)
        stiffest = law.stiffness * state.volume.max() if (contact.normal > 0).any() else 1e15
        np.testing.assert_allclose(density, theirs, rtol=0, atol=4 * np.spacing(4e-3) * stiffest)
        assert np.abs(theirs).max() >= 1.2e4
    assert touched >= 2
