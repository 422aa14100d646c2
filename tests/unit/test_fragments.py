"""Contact inside a grain: bonded nodes never touch, fragments do, breaking adds no energy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.clouds import cloud, deformed, disc, lattice, ragged
from support.oracle import (
    Contact,
    Solid,
    bond_state,
    break_bonds,
    contact_pairs,
    contact_state,
    families,
)
from support.runs import contact_words, lps_words

SOLID = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, s0=0.04)
LAW = Contact(radius=1.2, stiffness=5.0)


def both_script(solid: Solid, law: Contact, extra: str = "") -> str:
    return f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(solid)}
        pair_coeff * * peridem/contact {contact_words(law, extra)}
        compute node all peridem/atom damage bonds
        fix motion all nve
        """


def test_bonded_nodes_inside_the_contact_radius_do_not_touch(simulation):
    """Spacing 1, contact radius 1.2: a whole grain at rest stays at rest."""
    one = cloud(lattice((5, 5)), dimension=2)
    sim = simulation().load(one, dimension=2).commands(both_script(SOLID, LAW))
    sim.commands("run 0 post no")
    # bonds at their reference lengths: rounding only
    assert np.abs(sim.atoms("f")).max() < 1e-13
    squeezed = one.reference * 0.9
    bonds = families(one.reference, one.volume, one.molecule, SOLID)
    force = bond_state(bonds, squeezed).force  # the spread of the lattice is beyond the horizon
    i, j, reach = contact_pairs(one.molecule, one.reference, LAW.radius, bonds)
    assert np.all(np.linalg.norm(squeezed[j] - squeezed[i], axis=1) > reach)
    np.testing.assert_allclose(
        sim.at(squeezed).atoms("f"), force, rtol=0, atol=1e-12 * np.abs(force).max()
    )


def test_a_partly_broken_grain_equals_the_numpy_model_of_bonds_and_contact(simulation, rng):
    one = ragged(rng, (6, 6))
    sim = simulation().load(one, dimension=2).commands(both_script(SOLID, LAW))
    bonds = families(one.reference, one.volume, one.molecule, SOLID)
    sim.commands("run 0 post no")
    touched = 0
    for size in (0.09, 0.2, 0.25):
        x = deformed(rng, one, size, 2)
        sim.at(x)
        break_bonds(bonds, x)
        pairs = contact_pairs(one.molecule, one.reference, LAW.radius, bonds)
        contact = contact_state(LAW, *pairs, x, one.v, one.volume)
        state = bond_state(bonds, x)
        expected = state.force + contact.force
        touched += int((contact.normal > 0).sum())
        np.testing.assert_allclose(
            sim.atoms("f"), expected, rtol=0, atol=1e-12 * np.abs(expected).max()
        )
        energy = state.energy.sum() + contact.energy.sum()
        # rounding of sums over bonds and contacts
        assert sim.thermo("pe") == pytest.approx(energy, rel=1e-12)
    assert touched > 10


def test_distant_nodes_of_one_grain_touch_at_the_contact_radius_when_it_folds(simulation):
    """Two pairs of nodes of one molecule, ten apart in the reference: R > radius, d_c = radius."""
    reference = np.array([[0.0, 0, 0], [1, 0, 0], [11, 0, 0], [12, 0, 0]])
    one = cloud(reference, dimension=2)
    folded = reference - np.array([[0.0, 0, 0], [0, 0, 0], [9.1, 0, 0], [9.1, 0, 0]])
    sim = (
        simulation()
        .load(one.moved(folded), dimension=2)
        .commands(both_script(replace(SOLID, horizon=1.5), LAW) + "run 0 post no")
    )
    push = LAW.stiffness * (LAW.radius - 0.9)
    assert sim.atoms("f")[:, 0] == pytest.approx([0, -push, push, 0], abs=1e-12)


def test_fragments_no_leaves_nodes_of_one_grain_alone(simulation, rng):
    one = ragged(rng, (6, 6))
    x = deformed(rng, one, 0.25, 2)
    sim = simulation().load(one.moved(x), dimension=2)
    sim.commands(both_script(SOLID, LAW, "fragments no") + "run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, SOLID)
    break_bonds(bonds, x)
    expected = bond_state(bonds, x).force
    np.testing.assert_allclose(
        sim.atoms("f"), expected, rtol=0, atol=1e-12 * np.abs(expected).max()
    )


def test_nodes_touch_right_after_their_bond_breaks_between_two_neighbour_lists(simulation):
    """The list is built once; the bond breaks at step 1 and the nodes are back at step 2."""
    one = cloud([[0, 0], [1, 0]], dimension=2)
    sim = simulation().load(one, dimension=2, skin=2.0)
    sim.commands(both_script(replace(SOLID, s0=0.1), LAW))
    sim.commands("neigh_modify every 1000 delay 1000 check no\ntimestep 0.001\nrun 0 post no")

    def step_from(r):
        x, v = sim.lmp.numpy.extract_atom("x"), sim.lmp.numpy.extract_atom("v")
        x[:2] = np.array([[0.0, 0, 0], [r, 0, 0]])[np.argsort(sim.order)]
        v[:2] = 0.0
        sim.lmp.numpy.extract_atom("f")[:2] = 0.0
        sim.commands("run 1 pre no post no")
        return sim.atoms("f")[:, 0]

    assert np.all(step_from(1.2) == 0.0)  # broken
    # d_c = min(1.2, R = 1): overlap 0.1
    assert step_from(0.9) == pytest.approx([-5 * 0.1, 5 * 0.1], rel=1e-9)
    assert np.all(step_from(1.05) == 0.0)  # below the contact radius, above R


@pytest.mark.parametrize("both", [False, True], ids=["tension", "both"])
def test_a_breaking_grain_gains_no_energy(both, simulation, rng):
    """Discs thrown against each other until they break: the total energy only falls.

    Breaking takes the energy of the bond away, and the contact that opens in its place starts from
    zero.  Bonds that break in compression (``both``) are the hard case: s < -s0 means r < R.
    """
    solid = replace(SOLID, s0=0.05, break_both=both)
    law = Contact(radius=0.95, stiffness=20.0)
    left = cloud(disc(4.3, centre=(-5.0, 0.0)), dimension=2)
    right = cloud(disc(4.3, centre=(5.0, 0.7)), dimension=2, molecule=2)
    left.v[:, 0], right.v[:, 0] = 0.4, -0.4
    from support.clouds import join

    one = join(left, right, margin=60)
    sim = simulation().load(one, dimension=2).commands(both_script(solid, law))
    sim.commands("timestep 0.01\nrun 0 post no")
    energy = [sim.thermo("pe") + sim.thermo("ke")]
    for _ in range(150):
        sim.commands("run 10 post no")
        energy.append(sim.thermo("pe") + sim.thermo("ke"))
    assert sim.compute("node")[:, 0].mean() > 0.05  # they did break
    # the integrator's own wiggle: (omega dt)^2/8 with omega <= 7: 6e-4 of the exchanged energy
    assert np.diff(energy).max() < 1e-3 * energy[0]
    assert energy[-1] < energy[0]
    v, mass = sim.atoms("v"), sim.atoms("rmass")
    # 1500 steps of rounding
    assert np.abs((mass[:, None] * v).sum(axis=0)).max() < 1e-11 * np.abs(mass[:, None] * v).sum()
