"""``compute peridem/atom``: its fields against the numpy model, and how it is shaped."""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import deformed, ragged
from support.oracle import Solid, bond_state, break_bonds, damage, families, intact_bonds
from support.runs import solid_script

SOLIDS = {
    "3D": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=3, s0=0.04),
    "plane strain": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, s0=0.04),
    "jha": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, plane="jha", s0=0.04),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_all_fields_equal_the_numpy_model(name, simulation, rng):
    solid = SOLIDS[name]
    one = ragged(rng, (4, 4, 3) if solid.dimension == 3 else (6, 6))
    x = deformed(rng, one, 0.05, solid.dimension)
    sim = (
        simulation()
        .load(one.moved(x), dimension=solid.dimension)
        .commands(
            solid_script(solid)
            + "compute node all peridem/atom damage stretch dilatation energy bonds\nrun 0 post no"
        )
    )
    bonds = families(one.reference, one.volume, one.molecule, solid)
    ratio = np.zeros(one.n)  # stretch: the largest s/s0; compression does not count
    state = bond_state(bonds, x)
    for end in (bonds.i, bonds.j):
        np.maximum.at(ratio, end, state.stretch / bonds.s0)
    break_bonds(bonds, x)
    state = bond_state(bonds, x)
    node = sim.compute("node")
    # rounding only, on values of order one (damage, stretch) and 1e-2 (dilatation, energy)
    np.testing.assert_allclose(node[:, 0], damage(bonds), atol=1e-14)
    np.testing.assert_allclose(node[:, 1], ratio, rtol=1e-12)
    np.testing.assert_allclose(node[:, 2], state.theta, atol=1e-14)
    np.testing.assert_allclose(node[:, 4], intact_bonds(bonds), atol=0)
    np.testing.assert_allclose(node[:, 3].sum(), sim.thermo("pe"), rtol=1e-12)
    np.testing.assert_allclose(node[:, 3], state.energy, rtol=0, atol=1e-12 * state.energy.max())


def test_one_word_gives_a_vector_and_several_give_columns_in_their_order(simulation, rng):
    solid = SOLIDS["plane strain"]
    one = ragged(rng, (5, 5))
    sim = (
        simulation()
        .load(one.moved(deformed(rng, one, 0.05, 2)), dimension=2)
        .commands(
            solid_script(solid)
            + """
        compute lonely all peridem/atom bonds
        compute several all peridem/atom bonds damage
        run 0 post no
        """
        )
    )
    lonely, several = sim.compute("lonely"), sim.compute("several")
    assert lonely.shape == (25,)
    assert several.shape == (25, 2)
    assert lonely.tolist() == several[:, 0].tolist()


def test_nodes_outside_the_group_are_zero(simulation, rng):
    solid = SOLIDS["plane strain"]
    one = ragged(rng, (5, 5))
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            solid_script(solid)
            + """
        group some id 1:10
        compute some some peridem/atom bonds
        run 0 post no
        """
        )
    )
    bonds = sim.compute("some")
    assert np.all(bonds[:10] > 0)
    assert np.all(bonds[10:] == 0)


def test_stretch_counts_compression_where_compression_breaks(simulation, rng):
    from dataclasses import replace

    solid = replace(SOLIDS["plane strain"], break_both=True)
    one = ragged(rng, (6, 6))
    x = deformed(rng, one, 0.05, 2)
    sim = (
        simulation()
        .load(one.moved(x), dimension=2)
        .commands(solid_script(solid) + "compute worst all peridem/atom stretch\nrun 0 post no")
    )
    bonds = families(one.reference, one.volume, one.molecule, solid)
    ratio = np.zeros(one.n)
    for end in (bonds.i, bonds.j):
        np.maximum.at(ratio, end, np.abs(bond_state(bonds, x).stretch) / bonds.s0)
    np.testing.assert_allclose(sim.compute("worst"), ratio, rtol=1e-12)  # rounding


def test_stretch_reaches_one_exactly_where_a_bond_broke_also_between_unlike_types(simulation, rng):
    """Two types of different strength in one grain: each bond is measured by its own s0."""
    weak = "bulk 3.0 shear 1.2 horizon 2.3 s0 0.02"
    strong = "bulk 3.0 shear 1.2 horizon 2.3 s0 0.2"
    types = np.where(np.arange(36) < 12, 1, 2)
    one = ragged(rng, (6, 6), types=types)
    x = deformed(rng, one, 0.05, 2)
    sim = (
        simulation()
        .load(one.moved(x), dimension=2)
        .commands(
            f"""
        pair_style peridem/lps
        pair_coeff 1 1 {weak}
        pair_coeff 2 2 {strong}
        compute node all peridem/atom stretch damage
        run 0 post no
        """
        )
    )
    node = sim.compute("node")
    broke = node[:, 1] > 0
    assert 0 < broke.sum() < 36
    assert (node[:, 0] >= 1.0).tolist() == broke.tolist()
