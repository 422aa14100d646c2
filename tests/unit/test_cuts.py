"""``fix peridem/bonds ... cut`` and ``unbroken``: which bonds are gone, and what else stays."""

from __future__ import annotations

import re

import numpy as np
import pytest

from support.clouds import cloud, deformed, lattice, ragged
from support.oracle import (
    Bonds,
    Contact,
    Solid,
    bond_state,
    break_bonds,
    contact_pairs,
    contact_state,
    damage,
    families,
    intact_bonds,
)
from support.runs import contact_words, header, lps_words, read_dump, solid_script

FLAT = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2)
SOLID = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=3)
LAW = Contact(radius=1.2, stiffness=5.0)
WATCH = "compute node all peridem/atom damage bonds energy\n"


def across_plane(x, bonds: Bonds, point, normal, radius=np.inf):
    """Bonds whose ends lie on both sides of the plane and that cross it within the radius."""
    normal = np.asarray(normal) / np.linalg.norm(normal)
    a, b = (x[end] - point for end in (bonds.i, bonds.j))
    sides = np.stack([a @ normal, b @ normal])
    parts = (sides[0] < 0) != (sides[1] < 0)
    share = np.zeros(bonds.count)
    np.divide(sides[0], sides[0] - sides[1], out=share, where=parts)
    where = a + share[:, None] * (b - a)
    return parts & (np.linalg.norm(where, axis=1) <= radius)


def across_segment(x, bonds: Bonds, begin, end):
    """Bonds that cross the segment: each has the ends of the other on both sides."""

    def side(p, q, r):
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) > (q[..., 1] - p[..., 1]) * (
            r[..., 0] - p[..., 0]
        )

    p, q, a, b = np.asarray(begin), np.asarray(end), x[bonds.i], x[bonds.j]
    return (side(p, q, a) != side(p, q, b)) & (side(a, b, p) != side(a, b, q))


def through_disc(x, bonds: Bonds, centre, radius):
    """Bonds that come as near to the centre as the radius (in the plane)."""
    a, b = x[bonds.i, :2] - centre, x[bonds.j, :2] - centre
    way = b - a
    share = np.clip(-np.einsum("pa,pa->p", a, way) / np.einsum("pa,pa->p", way, way), 0, 1)
    return np.linalg.norm(a + share[:, None] * way, axis=1) < radius


CUTS = {
    "a line": (
        "cut plane 0.1 0.2 0 1 2 0",
        lambda x, b: across_plane(x, b, [0.1, 0.2, 0], (1, 2, 0)),
    ),
    "a line of finite length": (
        "cut plane 0.1 0.2 0 1 2 0 radius 1.7",
        lambda x, b: across_plane(x, b, [0.1, 0.2, 0], (1, 2, 0), 1.7),
    ),
    "a segment": (
        "cut segment -1.3 0.4 2.1 -0.7",
        lambda x, b: across_segment(x, b, (-1.3, 0.4), (2.1, -0.7)),
    ),
    "a segment and a line": (
        "cut segment -1.3 0.4 2.1 -0.7 cut plane 1.2 0 0 1 0 0 radius 1.1",
        lambda x, b: (
            across_segment(x, b, (-1.3, 0.4), (2.1, -0.7))
            | across_plane(x, b, [1.2, 0, 0], (1, 0, 0), 1.1)
        ),
    ),
    "a region": ("cut region hole", lambda x, b: through_disc(x, b, (0.3, -0.2), 1.1)),
}
HOLE = "region hole cylinder z 0.3 -0.2 1.1 INF INF\n"


def check(sim, bonds, gone, x):
    """The bonds of the model less those gone: counts, damage and forces."""
    bonds.intact &= ~gone
    assert 5 < gone.sum() < 0.7 * bonds.count  # the case is about some of the bonds
    node, force = sim.compute("node"), sim.atoms("f")
    expected = bond_state(bonds, x)  # m of the whole family: cut bonds stay in it
    assert node[:, 1].astype(int).tolist() == intact_bonds(bonds).tolist()
    # sums of a few dozen volumes, forces and energies of order one: rounding
    np.testing.assert_allclose(node[:, 0], damage(bonds), rtol=0, atol=1e-14)
    scale = np.abs(expected.force).max()
    np.testing.assert_allclose(force, expected.force, rtol=0, atol=1e-12 * scale)
    np.testing.assert_allclose(
        node[:, 2], expected.energy, rtol=0, atol=1e-12 * expected.energy.max()
    )


@pytest.mark.parametrize("name", CUTS)
def test_a_cut_takes_the_bonds_that_cross_it_and_leaves_the_others_as_they_are(
    name, simulation, rng
):
    words, gone = CUTS[name]
    one = ragged(rng, (8, 8))
    x = deformed(rng, one, 0.05, 2)
    sim = simulation().load(one.moved(x), dimension=2)
    sim.commands(
        f"{HOLE}fix glue all peridem/bonds {words}\n{solid_script(FLAT)}{WATCH}run 0 post no"
    )
    bonds = families(one.reference, one.volume, one.molecule, FLAT)
    check(sim, bonds, gone(one.reference, bonds), x)


@pytest.mark.parametrize("radius", [np.inf, 1.6])
def test_a_plane_cuts_a_solid_in_3d(radius, simulation, rng):
    one = ragged(rng, (5, 5, 5))
    x = deformed(rng, one, 0.05, 3)
    words = "cut plane 0.1 0.2 -0.3 1 2 -1" + (f" radius {radius}" if radius < np.inf else "")
    sim = simulation().load(one.moved(x))
    sim.commands(f"fix glue all peridem/bonds {words}\n{solid_script(SOLID)}{WATCH}run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, SOLID)
    gone = across_plane(one.reference, bonds, [0.1, 0.2, -0.3], (1, 2, -1), radius)
    check(sim, bonds, gone, x)


def test_a_region_cuts_a_solid_in_3d(simulation, rng):
    """A slab between two planes: every bond with an end in it or with ends on both sides."""
    one = ragged(rng, (5, 5, 5))
    x = deformed(rng, one, 0.05, 3)
    sim = simulation().load(one.moved(x))
    sim.commands(
        "region slab block INF INF INF INF 0.3 0.8\nfix glue all peridem/bonds cut region slab\n"
        f"{solid_script(SOLID)}{WATCH}run 0 post no"
    )
    bonds = families(one.reference, one.volume, one.molecule, SOLID)
    a, b = one.reference[bonds.i, 2], one.reference[bonds.j, 2]
    check(sim, bonds, (np.minimum(a, b) < 0.8) & (np.maximum(a, b) > 0.3), x)


def test_the_reference_decides_and_not_where_the_nodes_are_now(simulation, rng):
    """A grain read in far from its reference is cut where the line crosses its reference."""
    one = ragged(rng, (8, 8))
    x = deformed(rng, one, 0.02, 2) + np.array([20.0, 3.0, 0.0])
    one.box[:2] = [[-10, 40], [-10, 20]]
    sim = simulation().load(one.moved(x), dimension=2)
    sim.commands(
        "fix glue all peridem/bonds cut plane 0.1 0.2 0 1 2 0\n"
        f"{solid_script(FLAT)}{WATCH}run 0 post no"
    )
    bonds = families(one.reference, one.volume, one.molecule, FLAT)
    check(sim, bonds, across_plane(one.reference, bonds, [0.1, 0.2, 0], (1, 2, 0)), x)


def test_a_cut_grain_at_rest_feels_nothing(simulation):
    """Contact inside a grain begins at the reference distance: its faces just touch."""
    one = cloud(lattice((6, 6)), dimension=2)
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"""
        fix glue all peridem/bonds cut plane 0 0 0 0 1 0
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(FLAT)}
        pair_coeff * * peridem/contact {contact_words(LAW)}
        run 0 post no
        """
    )
    # bonds at their reference lengths: rounding only
    assert np.abs(sim.atoms("f")).max() < 1e-13


def test_the_faces_of_a_cut_push_each_other_when_they_close(simulation, rng):
    one = ragged(rng, (6, 6))
    x = one.reference.copy()
    x[x[:, 1] > 0, 1] -= 0.15
    sim = simulation().load(one.moved(x), dimension=2)
    sim.commands(
        f"""
        fix glue all peridem/bonds cut plane 0 0 0 0 1 0
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(FLAT)}
        pair_coeff * * peridem/contact {contact_words(LAW)}
        run 0 post no
        """
    )
    bonds = families(one.reference, one.volume, one.molecule, FLAT)
    bonds.intact &= ~across_plane(one.reference, bonds, [0, 0, 0], (0, 1, 0))
    pairs = contact_pairs(one.molecule, one.reference, LAW.radius, bonds)
    contact = contact_state(LAW, *pairs, x, one.v, one.volume)
    assert (contact.normal > 0).sum() > 5
    expected = bond_state(bonds, x).force + contact.force
    np.testing.assert_allclose(
        sim.atoms("f"), expected, rtol=0, atol=1e-12 * np.abs(expected).max()
    )


@pytest.mark.seconds
def test_ranks_cut_the_same_bonds(mpi, rng):
    """The line is an end of both ranks' boxes, and of bonds between them."""
    one = ragged(rng, (8, 8))
    one.write(mpi.folder / "cut.data")
    for ranks, grid in ((1, "1 1 1"), (2, "2 1 1"), (4, "2 2 1")):
        mpi(
            header(one, "cut.data", dimension=2, extra=f"processors {grid}")
            + f"{HOLE}fix glue all peridem/bonds cut plane 0 0.2 0 1 0.1 0 radius 2.5 &\n"
            f"  cut region hole cut segment -3 1 0.4 3.1\n{solid_script(FLAT)}{WATCH}"
            f"dump state all custom 1 cut{ranks}.dump id c_node[1] c_node[2]\n"
            "dump_modify state format float %.17g\nrun 0 post no\n",
            ranks,
        )
    bonds = families(one.reference, one.volume, one.molecule, FLAT)
    x = one.reference
    bonds.intact &= ~(
        across_plane(x, bonds, [0, 0.2, 0], (1, 0.1, 0), 2.5)
        | through_disc(x, bonds, (0.3, -0.2), 1.1)
        | across_segment(x, bonds, (-3, 1), (0.4, 3.1))
    )
    for ranks in (1, 2, 4):
        (frame,) = read_dump(mpi.folder / f"cut{ranks}.dump")
        assert frame["c_node[2]"].astype(int).tolist() == intact_bonds(bonds).tolist(), ranks
        # sums of a few dozen volumes
        np.testing.assert_allclose(frame["c_node[1]"], damage(bonds), rtol=0, atol=1e-14)


def test_bonds_between_nodes_of_the_unbroken_group_never_break(simulation, rng):
    """Bonds with one end or none in the group break at s0 as ever."""
    one = ragged(rng, (8, 8))
    solid = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, s0=0.03)
    x = deformed(rng, one, 0.08, 2)
    sim = simulation().load(one.moved(x), dimension=2)
    sim.commands(
        "group grip id 1:24\nfix glue all peridem/bonds unbroken grip\n"
        f"{solid_script(solid)}{WATCH}run 0 post no"
    )
    bonds = families(one.reference, one.volume, one.molecule, solid)
    inside = (bonds.i < 24) & (bonds.j < 24)
    bonds.s0 = np.where(inside, np.inf, bonds.s0)
    would = bond_state(bonds, x).stretch > solid.s0
    assert (would & inside).sum() > 10
    break_bonds(bonds, x)
    assert sim.compute("node")[:, 1].astype(int).tolist() == intact_bonds(bonds).tolist()


def test_a_cut_goes_through_the_unbroken_group_too(simulation, rng):
    """Initial cracks are where they are put; unbroken is about what happens later."""
    one = ragged(rng, (8, 8))
    sim = simulation().load(one, dimension=2)
    sim.commands(
        "fix glue all peridem/bonds unbroken all cut plane 0 0 0 1 0 0\n"
        f"{solid_script(FLAT)}{WATCH}run 0 post no"
    )
    bonds = families(one.reference, one.volume, one.molecule, FLAT)
    bonds.intact &= ~across_plane(one.reference, bonds, [0, 0, 0], (1, 0, 0))
    assert sim.compute("node")[:, 1].astype(int).tolist() == intact_bonds(bonds).tolist()


BAD = {
    "unknown cut": ("cut sphere 0 0 0 1", "cut sphere: must be plane, segment or region"),
    "cut of nothing": ("cut", "must be plane, segment or region"),
    "unknown region": ("cut region nowhere", "cut region nowhere: there is no such region"),
    "region without a name": ("cut region", "cut region needs a region-ID"),
    "zero normal": ("cut plane 0 0 0 0 0 0", "cut plane: the normal is zero"),
    "short plane": ("cut plane 0 0 0 1 0", "Too few numbers for fix peridem/bonds cut plane"),
    "plane of words": ("cut plane 0 0 zero 1 0 0", "instead of 'zero' in input script"),
    "zero radius": ("cut plane 0 0 0 1 0 0 radius 0", "radius 0: must be > 0"),
    "negative radius": ("cut plane 0 0 0 1 0 0 radius -2", "radius -2: must be > 0"),
    "radius of nothing": ("cut plane 0 0 0 1 0 0 radius", "Too few numbers for"),
    "short segment": ("cut segment 0 0 1", "Too few numbers for fix peridem/bonds cut segment"),
    "segment of no length": ("cut segment 1 2 1 2", "its two ends are the same point"),
    "unknown group": ("unbroken nobody", "unbroken nobody: there is no such group"),
    "group without a name": ("unbroken", "unbroken needs a group-ID"),
    "repeated unbroken": (
        "unbroken all unbroken all",
        "Repeated fix peridem/bonds keyword unbroken",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_words(case, simulation):
    words, message = BAD[case]
    sim = simulation().load(cloud(lattice((4, 4)), dimension=2), dimension=2)
    with pytest.raises(Exception, match=re.escape(message)):
        sim.commands(f"fix glue all peridem/bonds {words}")


def test_a_segment_in_3d_says_what_to_use(simulation):
    sim = simulation().load(cloud(lattice((3, 3, 3))))
    with pytest.raises(Exception, match="segments cut 2d simulations only, use plane or region"):
        sim.commands("fix glue all peridem/bonds cut segment 0 0 1 1")
