"""Whole grains in LAMMPS: minimisers, rigid neighbours, notches, weak interfaces, fragments."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.clouds import cloud, deformed, disc, join, lattice, ragged
from support.oracle import (
    Contact,
    Solid,
    bond_state,
    contact_pairs,
    contact_state,
    damage,
    families,
    intact_bonds,
    total_torque,
)
from support.runs import contact_words, lps_words, solid_script

SOLID = Solid(bulk=30.0, shear=15.0, horizon=2.3, dimension=2)


# --- minimisers ----------------------------------------------------------------------------------


@pytest.mark.parametrize("style", ["fire", "quickmin"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_strained_grain_relaxes_to_no_force(style, dimension, simulation, rng):
    solid = replace(SOLID, dimension=dimension)
    one = ragged(rng, (6, 6) if dimension == 2 else (4, 4, 4))
    x = deformed(rng, one, 0.05, dimension)
    sim = simulation().load(one.moved(x), dimension=dimension)
    sim.commands(solid_script(solid) + "timestep 0.02\nrun 0 post no")
    force, energy = np.abs(sim.atoms("f")).max(), sim.thermo("pe")
    sim.commands(f"min_style {style}\nminimize 0 1e-8 20000 20000")
    # asked for 1e-8 of the whole force vector; energies go with its square
    assert np.abs(sim.atoms("f")).max() < 1e-8 < 1e-6 * force
    assert sim.thermo("pe") < 1e-12 * energy
    # at rest all bonds have their lengths: nothing but a rigid motion is left
    bonds = families(one.reference, one.volume, one.molecule, solid)
    assert np.abs(bond_state(bonds, sim.atoms("x")).stretch).max() < 1e-8


def test_a_minimiser_finds_the_stretched_state_of_a_pulled_bar(simulation):
    """One end held, the other pulled by a constant force: quasi-static loading."""
    one = cloud(lattice((12, 4)), dimension=2)
    last = one.x[:, 0] > 5
    sim = simulation().load(one, dimension=2)
    sim.commands(
        solid_script(SOLID)
        + """
        region left block INF -4.9 INF INF INF INF
        region right block 4.9 INF INF INF INF INF
        group left region left
        group right region right
        fix hold left setforce 0 0 0
        fix pull right addforce 0.02 0 0
        timestep 0.02
        min_style fire
        minimize 0 1e-8 20000 20000
        """
    )
    bonds = families(one.reference, one.volume, one.molecule, SOLID)
    inner = bond_state(bonds, sim.atoms("x")).force
    free = ~(one.x[:, 0] < -5) & ~last
    # the numpy model agrees that nothing is left, and that the ends carry the load
    assert np.abs(inner[free]).max() < 1e-7
    assert inner[last, 0] == pytest.approx([-0.02] * last.sum(), abs=1e-7)
    moved = sim.atoms("x")[last, 0].mean() - one.x[last, 0].mean()
    # plane strain, E' = 4 G (lambda + G)/(lambda + 2 G) = 42.9: 0.02 over the width of a node.
    # Held ends, free faces of half families and both ends make it off by a part of some tens.
    assert moved == pytest.approx(0.02 / 42.9 * 11, rel=0.3)


def test_a_grain_sinks_onto_the_floor_by_its_weight_in_minimisation(simulation):
    """As the manual's troubleshooting says: fix gravity acts in dynamics alone."""
    one = cloud(disc(4.3, centre=(0.0, 5.1)), dimension=2, density=2.0)
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(SOLID)}
        pair_coeff * * peridem/contact radius 0.95
        fix floor all peridem/wall plane 0 0 0 0 1 0
        variable fy atom -0.001*mass
        variable e atom 0.001*mass*y
        fix weight all addforce 0 v_fy 0 energy v_e
        fix_modify weight energy yes
        timestep 0.02
        min_style fire
        minimize 0 1e-7 20000 20000
        """
    )
    weight = 0.001 * 2.0 * one.volume.sum()
    # 1e-7 is the length of all forces that are left; their sum is at most sqrt(61) of it
    assert sim.fix_vector("floor", 2)[1] == pytest.approx(-weight, abs=1e-6)
    assert np.abs(sim.atoms("f")).max() < 1e-7


# --- a rigid grain beside a deformable one -------------------------------------------------------


def test_a_rigid_grain_and_a_deformable_one_exchange_momentum_exactly(simulation):
    left = cloud(disc(4.3, centre=(-4.85, 0.0)), dimension=2)
    right = cloud(disc(4.3, centre=(4.85, 2.0)), dimension=2, molecule=2)
    left.v[:, 0], right.v[:, 0] = 0.1, -0.1
    one = join(left, right, margin=40)
    law = Contact(radius=0.95, stiffness=200.0)
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"""
        comm_modify cutoff 10
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(SOLID)}
        pair_coeff * * peridem/contact {contact_words(law)}
        group stiff molecule 1
        group soft molecule 2
        fix body stiff rigid/small molecule
        fix motion soft nve
        timestep 0.01
        run 2000 post no
        """
    )
    x, v = sim.atoms("x"), sim.atoms("v")
    stiff = one.molecule == 1
    assert v[stiff, 0].mean() < 0.05  # they did collide
    scale = np.abs(one.v).sum()
    # 2000 steps of rounding
    assert np.abs(v.sum(axis=0) - one.v.sum(axis=0)).max() < 1e-12 * scale
    # the rigid one is as it was, turned: all its distances, to rounding over 2000 steps
    bonds = families(one.reference[stiff], one.volume[stiff], one.molecule[stiff], SOLID)
    assert np.abs(bond_state(bonds, x[stiff]).stretch).max() < 1e-11
    assert np.abs(sim.atoms("v")[~stiff] - v[~stiff].mean(axis=0)).max() > 1e-3  # the other rings


# --- bonds of no weight --------------------------------------------------------------------------


def test_nodes_at_the_horizon_of_a_linear_influence_are_not_bonded(simulation):
    """w = 0 at R = horizon: no bond, no share in damage."""
    one = cloud(lattice((6, 6)), dimension=2)
    solid = replace(SOLID, horizon=2.0)
    sim = simulation().load(one, dimension=2)
    sim.commands(
        solid_script(solid) + "compute node all peridem/atom bonds damage surface\nrun 0 post no"
    )
    bonds = families(one.reference, one.volume, one.molecule, solid)
    bonds.intact = bonds.weight > 1e-12
    assert 0 < bonds.intact.sum() < bonds.count
    node = sim.compute("node")
    assert node[:, 0].astype(int).tolist() == intact_bonds(bonds).tolist()
    assert np.all(node[:, 1] == 0.0)


def test_nodes_at_the_horizon_of_a_linear_influence_touch(simulation):
    """A row of three: the outer two are no neighbours, and meet when it is squeezed."""
    solid, law = replace(SOLID, horizon=2.0), Contact(radius=1.9, stiffness=5.0)
    one = cloud([[0, 0], [1, 0], [2, 0]], dimension=2)
    x = np.array([[0.0, 0, 0], [0.9, 0, 0], [1.8, 0, 0]])
    sim = simulation().load(one.moved(x), dimension=2)
    sim.commands(
        f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(solid)}
        pair_coeff * * peridem/contact {contact_words(law)}
        run 0 post no
        """
    )
    bonds = families(one.reference, one.volume, one.molecule, solid)
    bonds.intact = bonds.weight > 1e-12
    pairs = contact_pairs(one.molecule, one.reference, law.radius, bonds)
    contact = contact_state(law, *pairs, x, one.v, one.volume)
    assert contact.normal.max() == pytest.approx(0.5)
    expected = bond_state(bonds, x).force + contact.force
    np.testing.assert_allclose(
        sim.atoms("f"), expected, rtol=0, atol=1e-12 * np.abs(expected).max()
    )


# --- notches and weak interfaces -----------------------------------------------------------------

STRIP = (24, 16)
BRITTLE = replace(SOLID, s0=0.02, viscosity=1.0)


def pulled_strip(simulation, one, lines: str, fixes: str = "", speed: float = 0.01):
    """Grips of two rows at top and bottom move apart, slowly against sound."""
    one.box[0], one.box[1] = (-30, 30), (-30, 30)
    sim = simulation().load(one, dimension=2)
    return sim.commands(
        f"""
        region up block INF INF 5.9 INF INF INF
        region down block INF INF INF -5.9 INF INF
        group up region up
        group down region down
        group grips union up down
        group free subtract all grips
        {fixes}
        {lines}
        compute node all peridem/atom damage
        compute piece all peridem/atom fragment
        fix rise up move linear 0 {speed} 0
        fix sink down move linear 0 {-speed} 0
        fix motion free nve
        timestep 0.05
        run 0 post no
        """
    )


def test_a_notched_strip_cracks_from_its_notch_and_parts_along_it(simulation):
    """The notch ends in the middle; the crack begins there and runs through to the other side."""
    one = cloud(lattice(STRIP), dimension=2)
    sim = pulled_strip(
        simulation,
        one,
        solid_script(BRITTLE).replace("fix motion all nve", ""),
        "fix glue all peridem/bonds cut segment -20 0 0 0 unbroken grips",
        speed=0.002,
    )
    before = sim.compute("node")
    ahead = one.x[:, 0] > BRITTLE.horizon
    assert np.all(before[ahead] == 0.0)
    front = []
    for _ in range(100):
        sim.commands("run 10 pre no post no")
        new = sim.compute("node") > before + 1e-12
        if new.any():
            front.append(one.x[new, 0].max())
            if len(front) == 1:
                # the first bonds to break are those around the tip
                assert np.linalg.norm(one.x[new, :2], axis=1).max() < 1.5 * BRITTLE.horizon
    assert len(set(front)) > 3  # it runs, and is not everywhere at once
    assert front[-1] == one.x[:, 0].max()
    sim.commands("run 14000 pre no post no")  # the last bonds along the crack are long to part
    damage_now, piece = sim.compute("node"), sim.compute("piece")
    assert not set(piece[one.x[:, 1] > 3]) & set(piece[one.x[:, 1] < -3])
    # straight: nothing breaks further from its line than two horizons
    assert np.all(damage_now[np.abs(one.x[:, 1]) > 2 * BRITTLE.horizon] == 0.0)


def test_a_weak_interface_parts_first(simulation):
    """Two materials in one grain, their common bonds a third as strong: only those break."""
    x = lattice(STRIP)
    one = cloud(x, dimension=2, types=np.where(x[:, 1] > 0, 1, 2))
    words = lps_words(BRITTLE)
    weak = lps_words(replace(BRITTLE, s0=0.007))
    sim = pulled_strip(
        simulation,
        one,
        f"""
        pair_style peridem/lps
        pair_coeff 1 1 {words}
        pair_coeff 2 2 {words}
        pair_coeff 1 2 {weak}
        """,
    )
    sim.commands("run 1600 post no")
    bonds = families(one.reference, one.volume, one.molecule, SOLID)
    across = one.types[bonds.i] != one.types[bonds.j]
    bonds.intact = ~across
    # every bond across the interface is gone and no other
    np.testing.assert_allclose(sim.compute("node"), damage(bonds), rtol=0, atol=1e-14)
    assert set(sim.compute("piece")) == {1.0, float(np.flatnonzero(x[:, 1] > 0)[0] + 1)}


# --- fragments -----------------------------------------------------------------------------------


def test_fragments_do_not_pass_through_each_other(simulation):
    """The halves of a cut grain thrown at each other: they bounce, momentum and torque are kept."""
    one = cloud(lattice((10, 8)), dimension=2, margin=30)
    upper = one.x[:, 1] > 0
    one.v[:, 1] = np.where(upper, -0.2, 0.2)
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"""
        fix glue all peridem/bonds cut plane 0 0 0 0 1 0
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(SOLID)}
        pair_coeff * * peridem/contact radius 0.95
        compute piece all peridem/atom fragment
        fix motion all nve
        timestep 0.01
        run 0 post no
        """
    )
    closest = np.inf
    for _ in range(60):
        sim.commands("run 20 pre no post no")
        x = sim.atoms("x")
        closest = min(closest, x[upper, 1].min() - x[~upper, 1].max())
    # contact of ten times the bulk stiffness: speeds of 0.03 of sound press faces by a part of that
    assert closest > 0.5 * 0.95
    v = sim.atoms("v")
    assert v[upper, 1].mean() > 0.1
    assert len(set(sim.compute("piece"))) == 2
    # 1200 steps of rounding
    assert np.abs(v.sum(axis=0)).max() < 1e-12 * np.abs(one.v).sum()
    assert np.abs(total_torque(sim.atoms("x"), sim.atoms("v"))).max() < 1e-10
