"""``replicate``: copies of a grain are grains of their own, and their references move along."""

from __future__ import annotations

import re

import numpy as np
import pytest

from support.clouds import cloud, disc, join, ragged
from support.oracle import Solid
from support.runs import header, lps_words, solid_script

SOLID = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, s0=0.5)
NODE = "compute node all peridem/atom bonds energy\nrun 0 post no"


def two_grains(rng):
    """Two grains of unlike shape, already strained, in a box that ends one spacing beside them."""
    first = ragged(rng, (5, 4))
    second = cloud(disc(2.6, centre=(0.0, 8.0)), dimension=2, molecule=4)
    one = join(first, second)
    x = one.reference + 0.03 * rng.normal(size=one.reference.shape) * (1, 1, 0)
    one = one.moved(x, v=rng.normal(size=x.shape) * (1, 1, 0))
    one.box = np.array([[-4.0, 4.0], [-4.0, 12.0], [-0.5, 0.5]])
    return one


def replicated(simulation, one, counts, style="", periodic=(True, True, False), **options):
    one.periodic = periodic
    sim = simulation().load(one, dimension=2, **options)
    return sim.commands(f"{style}\nreplicate {' '.join(map(str, counts))}")


@pytest.mark.parametrize("periodic", [(True, True, False), (False, False, False)])
@pytest.mark.parametrize("before", ["", solid_script(SOLID)], ids=["first", "after the styles"])
def test_every_copy_has_the_grains_of_the_original(before, periodic, simulation, rng):
    one = two_grains(rng)
    alone = simulation().load(one, dimension=2).commands(solid_script(SOLID) + NODE)
    sim = replicated(simulation, one, (3, 2, 1), before, periodic)
    sim.commands(("" if before else solid_script(SOLID)) + NODE)
    copies, n = 6, one.n
    assert sim.lmp.get_natoms() == copies * n
    grains = sim.atoms("molecule").reshape(copies, n)
    for k in range(copies):
        np.testing.assert_array_equal(grains[k], one.molecule + 4 * k)
    forces = sim.atoms("f").reshape(copies, n, 3)
    bonds = sim.compute("node").reshape(copies, n, 2)
    scale = np.abs(alone.atoms("f")).max()
    assert scale > 0.1
    for k in range(copies):
        # positions of copies are sums of positions and box lengths: rounding of numbers near 20
        np.testing.assert_allclose(forces[k], alone.atoms("f"), rtol=0, atol=1e-12 * scale)
        assert bonds[k][:, 0].tolist() == alone.compute("node")[:, 0].tolist()
    np.testing.assert_array_equal(
        sim.atoms("v").reshape(copies, n, 3), np.broadcast_to(one.v, (copies, n, 3))
    )


def test_copies_of_copies(simulation, rng):
    one = two_grains(rng)
    sim = replicated(simulation, one, (2, 1, 1)).commands("replicate 1 3 1")
    sim.commands(solid_script(SOLID) + NODE)
    grains = sim.atoms("molecule")
    assert len(np.unique(grains)) == 12
    for mol in np.unique(grains):
        assert (grains == mol).sum() in (20, (one.molecule == 4).sum())


@pytest.mark.parametrize("where", ["x", "y"])
def test_a_grain_across_the_boundary_is_whole_in_every_copy(where, simulation, rng):
    """Image flags say where its nodes belong."""
    one = two_grains(rng)
    shift = np.array([4.0, 0.0, 0.0] if where == "x" else [0.0, 6.0, 0.0])
    alone = simulation().load(one, dimension=2).commands(solid_script(SOLID) + NODE)
    one.x = one.x + shift
    one.reference = one.reference + shift
    sim = replicated(simulation, one, (2, 2, 1)).commands(solid_script(SOLID) + NODE)
    bonds = sim.compute("node").reshape(4, one.n, 2)
    for k in range(4):
        assert bonds[k][:, 0].tolist() == alone.compute("node")[:, 0].tolist()
        np.testing.assert_allclose(bonds[k][:, 1], alone.compute("node")[:, 1], rtol=1e-10)


def test_a_grain_in_two_halves_without_image_flags_is_refused(simulation, rng):
    one = two_grains(rng)
    one.x[:, 0] += 4.0
    one.x[:, 0] -= 8.0 * (one.x[:, 0] >= 4.0)
    one.reference = one.x.copy()
    sim = replicated(simulation, one, (2, 1, 1)).commands(solid_script(SOLID))
    with pytest.raises(Exception, match="crossed the periodic boundary in x when the box was"):
        sim.commands("run 0")


def test_the_original_of_one_grain_that_nearly_fills_its_box(simulation):
    """A cell of a heap: the copies are neighbours, not one grain."""
    one = cloud(disc(4.4), dimension=2)
    one.box = np.array([[-5.0, 5.0], [-5.0, 5.0], [-0.5, 0.5]])
    sim = replicated(simulation, one, (2, 2, 1)).commands(solid_script(SOLID) + NODE)
    assert sorted(np.unique(sim.atoms("molecule"))) == [1, 2, 3, 4]


@pytest.mark.seconds
def test_ranks_make_the_same_copies(mpi, rng):
    one = two_grains(rng)
    one.periodic = (True, True, False)
    one.write(mpi.folder / "cloud.data")
    states = []
    for ranks, words in ((1, ""), (2, ""), (4, "bbox")):
        script = header(one, "cloud.data", dimension=2) + f"replicate 3 2 1 {words}\n"
        script += f"pair_style peridem/lps\npair_coeff * * {lps_words(SOLID)}\n"
        script += (
            "run 0 post no\nwrite_dump all custom state id mol fx fy modify sort id "
            "format float %.15g\n"
        )
        mpi(script, ranks)
        rows = (mpi.folder / "state").read_text().splitlines()[9:]
        states.append(np.array([row.split() for row in rows], float))
    for state in states[1:]:
        np.testing.assert_array_equal(state[:, 1], states[0][:, 1])
        # rounding: ranks sum in another order
        np.testing.assert_allclose(state, states[0], rtol=0, atol=1e-12)


def test_families_cannot_be_copied(simulation, rng):
    """After the first run LAMMPS refuses: the families are per-atom data of a fix."""
    one = two_grains(rng)
    one.periodic = (True, True, False)
    sim = simulation().load(one, dimension=2).commands(solid_script(SOLID) + "run 0 post no")
    message = "Cannot replicate with fixes that store per-atom quantities"
    with pytest.raises(Exception, match=re.escape(message)):
        sim.commands("replicate 2 1 1")
