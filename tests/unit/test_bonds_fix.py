"""``fix peridem/bonds``: made by the pair style or by hand; what it counts and keeps."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from support.clouds import cloud, deformed, lattice, ragged
from support.oracle import Solid, bond_state, break_bonds, families
from support.runs import header, lps_words, read_dump, solid_script

SOLID = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, s0=0.04)


def test_it_counts_intact_and_broken_bonds_and_measures_the_longest(simulation, rng):
    one = ragged(rng, (6, 6))
    x = deformed(rng, one, 0.06, 2)
    sim = simulation().load(one.moved(x), dimension=2)
    sim.commands("fix glue all peridem/bonds\n" + solid_script(SOLID) + "run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, SOLID)
    count = bonds.count
    broken = break_bonds(bonds, x)
    assert sim.fix_vector("glue", 2).tolist() == [count - broken, broken]
    sim.commands("run 0 post no")  # the longest is measured when neighbour lists are made
    r = np.linalg.norm(x[bonds.j] - x[bonds.i], axis=1)[bonds.intact]
    assert sim.fix_vector("glue", 3)[2] == pytest.approx(r.max(), rel=1e-14)


def test_only_nodes_of_its_group_are_bonded(simulation, rng):
    one = ragged(rng, (6, 6))
    x = deformed(rng, one, 0.02, 2)
    sim = simulation().load(one.moved(x), dimension=2)
    sim.commands(
        "group some id 1:20\nfix glue some peridem/bonds\n" + solid_script(SOLID) + "run 0 post no"
    )
    inside = np.where(np.arange(36) < 20, 1, 0)  # molecule 0 has no bonds in the numpy model
    bonds = families(one.reference, one.volume, inside, SOLID)
    force = bond_state(bonds, x).force
    # rounding
    np.testing.assert_allclose(sim.atoms("f"), force, rtol=0, atol=1e-12 * np.abs(force).max())


def test_new_grains_get_their_families_when_they_arrive(simulation, rng):
    """A second grain is read into a running simulation: the first keeps its broken bonds."""
    first = ragged(rng, (6, 6))
    first.box[:2] = [[-10.0, 30.0], [-10.0, 10.0]]
    x = deformed(rng, first, 0.06, 2)
    sim = simulation().load(first.moved(x), dimension=2)
    sim.commands(solid_script(SOLID) + "compute node all peridem/atom bonds\nrun 0 post no")
    counted = sim.compute("node")
    second = ragged(rng, (5, 5), molecule=2)
    second.box = first.box
    second.write(sim.folder / "second.data")
    sim.commands(
        f"read_data {sim.folder / 'second.data'} add append offset 0 0 0 0 0 &\n"
        "  shift 15 0 0\nrun 0 post no"
    )
    after = sim.compute("node")
    assert after[:36].tolist() == counted.tolist()
    assert np.all(after[36:] > 0)


def test_a_data_file_warns_that_broken_bonds_are_lost(simulation, rng):
    one = ragged(rng, (6, 6))
    sim = simulation().load(one.moved(deformed(rng, one, 0.06, 2)), dimension=2)
    sim.commands(solid_script(SOLID) + "run 0 post no")
    sim.commands(f"write_data {sim.folder / 'broken.data'} nocoeff")
    assert "broken bonds are not kept by a data file: use write_restart" in sim.printed()


def test_bonds_of_a_restart_belong_to_the_fix_of_the_same_name(simulation, rng):
    one = ragged(rng, (6, 6))
    sim = simulation().load(one.moved(deformed(rng, one, 0.06, 2)), dimension=2)
    sim.commands(solid_script(SOLID) + "run 0 post no")
    restart = sim.folder / "state.restart"
    sim.commands(f"write_restart {restart}")
    other = simulation().commands(f"read_restart {restart}\nfix glue all peridem/bonds")
    with pytest.raises(Exception, match="but the script has fix glue peridem/bonds"):
        other.commands("run 0 post no")


@pytest.mark.seconds
def test_a_node_with_more_than_five_hundred_partners_migrates(mpi, rng):
    """Each node of a block is bonded to all 624 others, and the block flies through two ranks."""
    solid = replace(SOLID, horizon=40.0, s0=np.inf)
    one = ragged(rng, (25, 25), density=1.0)
    one.v[:, 0] = 50.0
    one.box[:2] = [[-45.0, 45.0], [-15.0, 15.0]]
    one.periodic = (False, False, False)
    one.x[:, 0] -= 30.0
    one.reference[:, 0] -= 30.0
    one.write(mpi.folder / "block.data")
    mpi(
        header(one, "block.data", dimension=2, extra="processors 2 1 1")
        + f"""
pair_style peridem/lps
pair_coeff * * {lps_words(solid)}
compute node all peridem/atom bonds
fix motion all nve
timestep 0.01
run 120 post no
write_dump all custom block.last id x y z fx fy fz c_node modify format float %.17g
""",
        2,
    )
    (last,) = read_dump(mpi.folder / "block.last")
    assert np.all(last["c_node"] == 624)
    # 120 steps of 0.5: it flew as it was; forces of rounding only
    np.testing.assert_allclose(last["x"], one.x[:, 0] + 60.0, rtol=0, atol=1e-9)
    np.testing.assert_allclose(last["y"], one.x[:, 1], rtol=0, atol=1e-9)


# --- what would go wrong a few steps later -------------------------------------------------------


def test_bonded_nodes_that_leave_a_fixed_box_are_named(simulation):
    one = cloud(lattice((4, 4)), dimension=2, margin=1.0)
    one.v[:, 0] = 1.0
    sim = simulation().load(one, dimension=2)
    sim.commands(f"pair_style peridem/lps\npair_coeff * * {lps_words(SOLID)}\nfix m all nve")
    message = (
        "4 bonded nodes have left the box through a fixed boundary (the first is atom-ID 13): make "
        "the box larger"
    )
    with pytest.raises(Exception, match=re.escape(message)):
        sim.commands("timestep 0.05\nneigh_modify every 1 delay 0 check yes\nrun 100")


@pytest.mark.parametrize("part", [0.2, 0.3])
def test_crushed_bonds_are_said_once(part, simulation):
    one = cloud(lattice((4, 4)), dimension=2, margin=9.0)
    sim = simulation().load(one.moved(one.x * (part, 1, 1)), dimension=2)
    sim.commands(
        f"pair_style peridem/lps\npair_coeff * * {lps_words(SOLID)}\nfix m all move linear 0 0 0\n"
        "timestep 1e-3\nneigh_modify every 1 delay 0 check no\nrun 5"
    )
    said = sim.printed().count("Bonds are compressed to 0.2 of their length (nodes ")
    # CRUSHED of peridem_bond_watch.cpp
    assert said == (part < 0.25)


@pytest.mark.parametrize("second", [1, 2], ids=["in one grain", "in two grains"])
def test_atom_ids_given_twice_are_refused(simulation, tmp_path, second):
    """LAMMPS reads such files; bonds, which know partners by ID, would join the wrong nodes."""
    atoms = "1 1 1 1 1 0 0 0\n2 1 1 1 1 1 0 0\n2 {0} 1 1 1 0 1 0\n4 {0} 1 1 1 1 1 0\n"
    (tmp_path / "twice.data").write_text(
        "twice\n\n4 atoms\n1 atom types\n\n-5 5 xlo xhi\n-5 5 ylo yhi\n-0.5 0.5 zlo zhi\n\n"
        f"Atoms # peridem\n\n{atoms.format(second)}"
    )
    sim = simulation()
    sim.commands(
        f"dimension 2\nboundary f f p\natom_style peridem\nread_data {tmp_path / 'twice.data'}\n"
        "pair_style peridem/lps\npair_coeff * * bulk 1 shear 0.6 horizon 1.5 unbreakable"
    )
    with pytest.raises(Exception, match="Atom-ID 2 is given to more than one node"):
        sim.commands("run 0")
