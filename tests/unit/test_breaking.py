"""Bonds break beyond s0, both ends alike, and never heal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.clouds import cloud, deformed, disc, lattice, ragged
from support.oracle import (
    Solid,
    bond_state,
    break_bonds,
    critical_stretch,
    damage,
    families,
    intact_bonds,
    total_torque,
)
from support.runs import lps_words, solid_script

PAIR = Solid(bulk=3.0, shear=1.2, horizon=1.5, dimension=2, s0=0.1)
WATCH = "compute node all peridem/atom damage bonds stretch\n"
GRAINS = {
    "2D": replace(PAIR, horizon=2.3, s0=0.04),
    "3D": replace(PAIR, horizon=2.3, s0=0.04, dimension=3),
}


def pair_of_nodes(simulation, solid):
    one = cloud([[0, 0], [1, 0]], dimension=2)
    return simulation().load(one, dimension=2).commands(solid_script(solid) + WATCH)


def apart(r: float) -> np.ndarray:
    return np.array([[0.0, 0, 0], [r, 0, 0]])


def bonds_left(sim) -> list[int]:
    return sim.compute("node")[:, 1].astype(int).tolist()


@pytest.mark.parametrize(("stretch", "left"), [(0.0999999, 1), (0.1000001, 0)])
def test_a_bond_breaks_when_its_stretch_exceeds_s0(stretch, left, simulation):
    sim = pair_of_nodes(simulation, PAIR).commands("run 0 post no").at(apart(1 + stretch))
    assert bonds_left(sim) == [left, left]
    assert (sim.atoms("f")[0, 0] != 0.0) == bool(left)


def test_a_bond_does_not_break_in_compression_by_default(simulation):
    sim = pair_of_nodes(simulation, PAIR).commands("run 0 post no").at(apart(0.5))
    assert bonds_left(sim) == [1, 1]
    assert sim.atoms("f")[0, 0] < 0.0  # and pushes back


@pytest.mark.parametrize(("stretch", "left"), [(-0.0999999, 1), (-0.1000001, 0), (0.1000001, 0)])
def test_break_both_breaks_in_compression_too(stretch, left, simulation):
    both = replace(PAIR, break_both=True)
    sim = pair_of_nodes(simulation, both).commands("run 0 post no").at(apart(1 + stretch))
    assert bonds_left(sim) == [left, left]


def test_break_tension_holds_any_compression(simulation):
    """It is the default."""
    for words in ("", " break tension"):
        sim = simulation().load(cloud(apart(1.0), dimension=2, margin=5.0), dimension=2)
        sim.commands(solid_script(PAIR, words) + WATCH + "run 0 post no")
        assert bonds_left(sim.at(apart(0.3))) == [1, 1]
        assert bonds_left(sim.at(apart(1.2))) == [0, 0]


def test_a_broken_bond_never_heals(simulation):
    sim = pair_of_nodes(simulation, PAIR).commands("run 0 post no").at(apart(1.2)).at(apart(1.0))
    assert bonds_left(sim) == [0, 0]
    assert np.all(sim.at(apart(1.05)).atoms("f") == 0.0)


def test_unbreakable_bonds_hold_at_any_stretch(simulation):
    sim = pair_of_nodes(simulation, replace(PAIR, s0=np.inf)).commands("run 0 post no")
    assert bonds_left(sim.at(apart(3.0))) == [1, 1]


def test_the_force_of_the_step_no_longer_contains_the_bond_that_breaks_in_it(simulation):
    """Two nodes flying apart: the energy in the bond is released when s > s0 and not later."""
    one = cloud([[0, 0], [1, 0]], dimension=2, v=np.array([[-1.0, 0, 0], [1.0, 0, 0]]))
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(solid_script(PAIR) + WATCH + "timestep 0.01\nrun 0 post no")
    )
    previous = 0.0
    for _ in range(20):
        sim.commands("run 1 pre no post no")
        stretch = sim.atoms("x")[1, 0] - sim.atoms("x")[0, 0] - 1.0
        if stretch > PAIR.s0:
            assert previous <= PAIR.s0
            assert np.all(sim.atoms("f") == 0.0)
            return
        assert sim.atoms("f")[0, 0] > 0.0
        previous = stretch
    pytest.fail("the nodes never separated beyond s0")


@pytest.mark.parametrize("name", GRAINS)
def test_a_cloud_breaks_the_same_bonds_as_the_numpy_model_and_keeps_its_momentum(
    name, simulation, rng
):
    solid = GRAINS[name]
    one = ragged(rng, (4, 4, 3) if solid.dimension == 3 else (6, 6))
    sim = simulation().load(one, dimension=solid.dimension)
    sim.commands(solid_script(solid) + WATCH + "run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, solid)
    for size in (0.02, 0.06, 0.09, 0.03):
        x = deformed(rng, one, size, solid.dimension)
        sim.at(x)
        break_bonds(bonds, x)
        expected = bond_state(bonds, x)
        node, force = sim.compute("node"), sim.atoms("f")
        assert node[:, 1].astype(int).tolist() == intact_bonds(bonds).tolist()
        # sums of a few dozen volumes
        np.testing.assert_allclose(node[:, 0], damage(bonds), rtol=0, atol=1e-14)
        # rounding, as in test_lps_forces
        np.testing.assert_allclose(
            force, expected.force, rtol=0, atol=1e-12 * np.abs(expected.force).max()
        )
        total = np.abs(force).sum()
        assert np.abs(force.sum(axis=0)).max() < 1e-14 * total
        assert np.abs(total_torque(x, force)).max() < 1e-13 * total
    assert 0.05 < damage(bonds).mean() < 0.95  # the case is about partial damage


def test_both_ends_lose_the_bond_together_in_a_tumbling_grain(simulation, rng):
    """Over many steps and rebuilt neighbour lists the bond counts stay symmetric: even in total."""
    solid = replace(PAIR, horizon=2.3, s0=0.03)
    x = disc(4.5)
    v = np.zeros_like(x)
    v[:, 0] = 0.1 * np.sign(x[:, 0])
    v[:, :2] += 0.3 * np.column_stack([-x[:, 1], x[:, 0]])
    one = cloud(x, dimension=2, v=v, margin=30)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            solid_script(solid) + WATCH + "neigh_modify every 1 delay 0 check no\ntimestep 0.05\n"
        )
    )
    bonds = families(one.reference, one.volume, one.molecule, solid)
    sim.commands("run 0 post no")
    for _ in range(80):
        sim.commands("run 1 pre no post no")
        break_bonds(bonds, sim.atoms("x"))
        assert sim.compute("node")[:, 1].astype(int).tolist() == intact_bonds(bonds).tolist()
    assert 0 < bonds.intact.sum() < bonds.count


@pytest.mark.parametrize("dimension", [2, 3])
def test_lists_kept_over_reneighbourings_are_those_made_anew(dimension, simulation):
    """While bonds break and neighbour lists are renewed, the engine closes gaps in its own."""
    solid = replace(PAIR, horizon=2.3, s0=0.06, dimension=dimension)
    x = disc(5.5) if dimension == 2 else lattice((6, 6, 6))
    v = np.zeros_like(x)
    v[:, :dimension] = 0.12 * np.tanh(x[:, :dimension] - x[:, :dimension].mean(axis=0))
    sim = simulation().load(cloud(x, dimension=dimension, v=v, margin=40), dimension=dimension)
    every_step = "neigh_modify every 1 delay 0 check no\ntimestep 0.05\n"
    sim.commands(solid_script(solid).replace("lps", "lps engine general", 1) + WATCH + every_step)
    sim.commands("run 0 post no")
    before, broke, compared = sim.compute("node")[:, 1].sum(), False, 0
    for _ in range(120):
        sim.commands("run 1 pre no post no")
        kept, left = sim.atoms("f").copy(), sim.compute("node")[:, 1].sum()
        if broke and left == before:  # else nodes at broken bonds are summed in another order
            sim.commands("run 0 post no")  # makes the list anew
            # the same list, so the same sums in the same order
            np.testing.assert_array_equal(sim.atoms("f"), kept)
            compared += 1
        broke, before = left < before, left
    assert compared >= 3, "too few bonds break one after the other"


def test_a_node_that_lost_all_its_bonds_flies_free(simulation):
    """No force, no dilatation, no division by zero: it moves in a straight line."""
    x = lattice((4, 4))
    v = np.zeros_like(x)
    v[15] = (3.0, 2.0, 0.0)
    one = cloud(x, dimension=2, v=v, margin=20)
    solid = replace(PAIR, horizon=1.5, s0=0.02)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            solid_script(solid)
            + "compute node all peridem/atom damage dilatation energy bonds\n"
            + "timestep 0.01\nrun 100 post no"
        )
    )
    node = sim.compute("node")
    assert node[15].tolist() == [1.0, 0.0, 0.0, 0.0]
    before, speed = sim.atoms("x")[15], sim.atoms("v")[15]
    sim.commands("run 100 post no")
    np.testing.assert_array_equal(sim.atoms("v")[15], speed)
    # 100 additions of dt v, each rounded at the size of x (below 10)
    np.testing.assert_allclose(sim.atoms("x")[15], before + 1.0 * speed, atol=1e-12)
    assert np.all(np.isfinite(sim.atoms("f")))


def test_s0_follows_from_the_energy_release_rate(simulation):
    """A pair stretched just below and just above the s0 of the numpy model's quadrature."""
    gc = 0.02
    for base in (
        replace(PAIR, dimension=3),
        PAIR,
        replace(PAIR, plane="stress"),
        replace(PAIR, plane="jha"),
    ):
        for influence in ("linear", "constant", "gaussian", "inverse"):
            solid = replace(base, influence=influence, gaussian_b=0.4)
            s0 = critical_stretch(solid, gc)
            words = lps_words(replace(solid, s0=1.0)).replace("s0 1 ", f"gc {gc} ")
            one = cloud([[0, 0, 0], [1, 0, 0]], dimension=solid.dimension)
            # 1e-9 covers the two quadratures, far below what a wrong factor would give
            for factor, left in ((1 - 1e-9, 1), (1 + 1e-9, 0)):
                sim = simulation().load(
                    one.moved(apart(1 + factor * s0)), dimension=solid.dimension
                )
                sim.commands(f"pair_style peridem/lps\npair_coeff * * {words}\n" + WATCH)
                assert bonds_left(sim.commands("run 0 post no")) == [left, left], solid


def test_damage_is_the_broken_fraction_by_volume(simulation):
    """Middle node with neighbours of volume 1 and 3: losing the larger one is 3/4 of damage."""
    one = cloud([[-1, 0], [0, 0], [1, 0]], volume=[1.0, 2.0, 3.0], dimension=2)
    solid = replace(PAIR, taper=False)
    sim = simulation().load(one, dimension=2).commands(solid_script(solid) + WATCH)
    sim.commands("run 0 post no").at(np.array([[-1.0, 0, 0], [0, 0, 0], [1.2, 0, 0]]))
    assert sim.compute("node")[:, 0].tolist() == [0.0, 0.75, 1.0]


def test_stretch_remembers_the_worst_so_far(simulation):
    """The largest s/s0 up to now, 1 or more once a bond broke."""
    sim = pair_of_nodes(simulation, PAIR).commands("run 0 post no").at(apart(1.05))
    assert sim.compute("node")[:, 2] == pytest.approx([0.5, 0.5], rel=1e-12)
    sim.at(apart(0.98))
    assert sim.compute("node")[:, 2] == pytest.approx([0.5, 0.5], rel=1e-12)
    sim.at(apart(1.13)).at(apart(1.0))
    assert np.all(sim.compute("node")[:, 2] >= 1.0)
