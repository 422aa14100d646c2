"""``fix peridem/wall plane``: the contact law against a surface, and what the wall reports."""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import cloud, disc, lattice
from support.oracle import Solid
from support.runs import lps_words, number

ACCURACY = 1e-12  # rounding of gaps of 0.1 at coordinates of order one

FLOOR = "plane 0 0 0 0 1 0"
ALONE = "pair_style zero 2.0\npair_coeff * *\nfix motion all nve\n"


def nodes_at_a_wall(simulation, x, wall, volume=1.0, v=None, dimension=2, density=1.0):
    """Single-node grains beside one wall, no other contact."""
    x = np.array(x, dtype=float)
    one = cloud(
        x,
        volume=volume,
        molecule=np.arange(len(x)) + 1,
        dimension=dimension,
        v=None if v is None else np.array(v, float),
        density=density,
        margin=20,
    )
    sim = simulation().load(one, dimension=dimension)
    return sim.commands(ALONE + f"fix floor all peridem/wall {wall}\nrun 0 post no")


def test_the_wall_pushes_along_its_normal_with_the_overlap(simulation):
    """k_N V^2: a wall node would be the mirror image of the node."""
    sim = nodes_at_a_wall(
        simulation, [[0, 0.3], [3, 1.0], [6, 2.0]], f"{FLOOR} radius 1.0 stiffness 5.0", volume=0.7
    )
    force = sim.atoms("f")
    assert force[0, 1] == pytest.approx(5.0 * 0.7**2 * 0.7, rel=ACCURACY)
    assert np.all(force[1:] == 0.0)
    assert np.all(force[:, [0, 2]] == 0.0)


@pytest.mark.parametrize("overlap", [0.1, 0.7])
def test_the_wall_takes_the_onset_of_contacts(overlap, simulation):
    k, w = 5.0 * 0.7**2, 0.3
    sim = nodes_at_a_wall(
        simulation, [[0, 1.0 - overlap]], f"{FLOOR} radius 1.0 stiffness 5.0 onset 0.3", volume=0.7
    )
    expected = k * overlap**2 / (2 * w) if overlap < w else k * (overlap - 0.5 * w)
    assert sim.atoms("f")[0, 1] == pytest.approx(expected, rel=ACCURACY)


def test_a_plane_pushes_back_what_has_gone_through_whatever_the_depth(simulation):
    sim = nodes_at_a_wall(
        simulation, [[0, 0.3], [3, 0.3]], f"{FLOOR} radius 1.0 stiffness 5.0", volume=0.7
    )
    sim.commands("displace_atoms all move 0 -8.3 0\nrun 0 post no")
    # the overlap is now the contact radius and the way behind the plane
    expected = np.full(2, 5.0 * 0.7**2 * 9.0)
    assert sim.atoms("f")[:, 1] == pytest.approx(expected, rel=ACCURACY)


def test_default_stiffness_follows_the_modulus(simulation):
    flat = nodes_at_a_wall(simulation, [[0, 0.3]], f"{FLOOR} radius 1.0 modulus 2.0", volume=0.7)
    assert flat.atoms("f")[0, 1] == pytest.approx(10 * 2.0 * 0.7, rel=ACCURACY)
    solid = nodes_at_a_wall(
        simulation,
        [[0, 0.3, 0]],
        f"{FLOOR} radius 1.0 modulus 2.0 form bulk 4",
        volume=0.7,
        dimension=3,
    )
    assert solid.atoms("f")[0, 1] == pytest.approx(4 * 2.0 * 0.7 ** (1 / 3) * 0.7, rel=ACCURACY)


def test_a_tilted_plane_measures_the_distance_along_its_normal(simulation):
    sim = nodes_at_a_wall(
        simulation,
        [[1.0, 2.0, 2.0]],
        "plane 0.5 1.0 1.5 1 2 2 radius 2.0 stiffness 5.0",
        dimension=3,
    )
    n = np.array([1.0, 2.0, 2.0]) / 3.0
    distance = np.array([0.5, 1.0, 0.5]) @ n
    np.testing.assert_allclose(sim.atoms("f")[0], 5.0 * (2.0 - distance) * n, rtol=ACCURACY)


def test_damping_of_the_wall_never_pulls(simulation):
    words = f"{FLOOR} radius 1.0 stiffness 5.0 damping 0.4"
    x = [[0, 0.6], [3, 0.6], [6, 0.6]]
    sim = nodes_at_a_wall(simulation, x, words, v=[[0, -2, 0], [0, 2, 0], [0, 20, 0]])
    expected = [5 * 0.4 + 0.8, 5 * 0.4 - 0.8, 0.0]
    assert sim.atoms("f")[:, 1] == pytest.approx(expected, rel=ACCURACY)


def test_friction_of_the_wall_opposes_sliding(simulation):
    words = f"{FLOOR} radius 1.0 stiffness 5.0 friction 0.3 tangential regularised 2.0"
    x = [[0, 0.6], [3, 0.6]]
    sim = nodes_at_a_wall(simulation, x, words, v=[[0.1, 0, 0], [-5.0, 0, 0]])
    # viscous below the cap, Coulomb above
    assert sim.atoms("f")[:, 0] == pytest.approx([-0.2, 0.3 * 2.0], rel=ACCURACY)


def test_velocities_are_relative_to_a_moving_wall(simulation):
    words = (
        f"{FLOOR} radius 1.0 stiffness 5.0 damping 0.4 friction 0.3 "
        "tangential regularised 2.0 velocity 0.1 0.5 0"
    )
    sim = nodes_at_a_wall(simulation, [[0, 0.6]], words, v=[[0, 0, 0]])
    # approach at 0.5, dragged along at 0.1
    assert sim.atoms("f")[0, :2] == pytest.approx([0.2, 5 * 0.4 + 0.4 * 0.5], rel=ACCURACY)


def test_the_wall_reports_reaction_torque_and_deepest_overlap(simulation, rng):
    x = np.zeros((20, 3))
    x[:, 0], x[:, 1], x[:, 2] = rng.uniform(-8, 8, 20), rng.uniform(0.1, 1.5, 20), np.arange(20)
    v = rng.normal(size=(20, 3))
    words = (
        "plane 1.0 0 2.0 0 1 0 radius 1.0 stiffness 5.0 damping 0.1 friction 0.3 "
        "tangential regularised 2.0"
    )
    sim = nodes_at_a_wall(simulation, x, words, v=v, dimension=3, volume=rng.uniform(0.5, 1.5, 20))
    force, output = sim.atoms("f"), sim.fix_vector("floor", 8)
    np.testing.assert_allclose(output[:3], -force.sum(axis=0), rtol=ACCURACY)
    foot = x * (1, 0, 1) - (1.0, 0, 2.0)  # where each node touches the plane, from its point
    np.testing.assert_allclose(
        output[3:6],
        -np.cross(foot, force).sum(axis=0),
        rtol=0,
        atol=ACCURACY * np.abs(force).sum() * 20,
    )
    assert output[6] == pytest.approx(1.0 - x[:, 1].min(), rel=ACCURACY)
    assert output[7] == 0.0  # it does not move


def test_a_node_bounces_off_and_keeps_its_energy(simulation):
    sim = nodes_at_a_wall(
        simulation, [[0, 1.2]], f"{FLOOR} radius 1.0 stiffness 5.0", v=[[0.2, -1.0, 0]]
    )
    sim.commands("timestep 0.0005\nrun 5000 post no")
    # O((omega dt)^2): omega = sqrt(5), so 1e-6
    assert sim.atoms("v")[0, :2] == pytest.approx([0.2, 1.0], abs=1e-5)


def test_a_moving_wall_is_where_its_velocity_takes_it_also_through_runs_in_pieces(simulation):
    """The node is held: the overlap grows by the way of the wall."""
    sim = nodes_at_a_wall(
        simulation, [[0, 2.0]], f"{FLOOR} radius 1.0 stiffness 5.0 velocity 0 0.5 0"
    )
    sim.commands("unfix motion\ntimestep 0.01")
    for done in (150, 300):
        sim.commands("run 150 post no")
        way = 0.5 * 0.01 * done
        assert sim.atoms("f")[0, 1] == pytest.approx(max(0.0, 5.0 * (1.0 - (2.0 - way))), abs=1e-12)
    sim.commands("run 50 pre no post no")
    assert sim.atoms("f")[0, 1] == pytest.approx(5.0 * 0.75, abs=1e-12)


def test_the_work_of_a_moving_wall_is_the_energy_it_brings(simulation):
    """A piston pushes a row of nodes: kinetic, contact and wall energy equal its work."""
    x = np.column_stack([np.zeros(6), 1.0 + np.arange(6), np.zeros(6)])
    one = cloud(x, molecule=np.arange(6) + 1, dimension=2, margin=30)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            f"""
        pair_style peridem/contact
        pair_coeff * * radius 1.0 stiffness 5.0
        fix motion all nve
        fix floor all peridem/wall {FLOOR} velocity 0 0.3 0
        fix_modify floor energy yes
        timestep 0.002
        run 0 post no
        """
        )
    )
    for _ in range(10):
        sim.commands("run 300 post no")
        work = sim.fix_vector("floor", 8)[7]
        energy = sim.thermo("pe") + sim.thermo("ke")
        # the work is summed with the force at the end of each step: off by F v dt / 2 < 1e-3
        assert work == pytest.approx(energy, abs=1.5e-3)
    assert work > 0.5


def test_wall_without_coefficients_takes_those_of_contact_of_each_type_with_itself(simulation):
    x = np.array([[0, 0.5], [5, 0.5]])
    one = cloud(x, molecule=[1, 2], types=[1, 2], dimension=2, margin=20)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            f"""
        pair_style peridem/contact
        pair_coeff 1 1 radius 1.0 stiffness 5.0
        pair_coeff 2 2 radius 0.8 stiffness 3.0
        pair_coeff 1 2 radius 0.7 stiffness 9.0
        fix floor all peridem/wall {FLOOR}
        run 0 post no
        """
        )
    )
    assert sim.atoms("f")[:, 1] == pytest.approx([5 * 0.5, 3 * 0.3], rel=ACCURACY)


def test_wall_without_contact_takes_modulus_and_spacing_of_the_solid(simulation):
    solid = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2)
    one = cloud(lattice((4, 4)) + np.array([0, 1.5 + 0.6, 0]), dimension=2, margin=20)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            f"""
        pair_style peridem/lps
        pair_coeff * * {lps_words(solid)}
        fix floor all peridem/wall {FLOOR}
        run 0 post no
        """
        )
    )
    lowest = one.x[:, 1].min()
    expected = 4 * 10 * 3.0 * (0.95 - lowest)  # radius 0.95 of the spacing 1
    assert sim.fix_vector("floor", 8)[1] == pytest.approx(-expected, rel=ACCURACY)


def test_only_nodes_of_the_group_feel_the_wall(simulation):
    one = cloud([[0, 0.5], [5, 0.5]], molecule=[1, 2], dimension=2, margin=20)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            ALONE
            + f"""
        group one id 2
        fix floor one peridem/wall {FLOOR} radius 1.0 stiffness 5.0
        run 0 post no
        """
        )
    )
    assert sim.atoms("f")[:, 1] == pytest.approx([0.0, 2.5], rel=ACCURACY)


def test_a_moving_wall_continues_from_a_restart(simulation):
    words = f"{FLOOR} radius 1.0 stiffness 5.0 velocity 0 0.5 0"
    sim = nodes_at_a_wall(simulation, [[0, 2.0], [5, 2.2], [9, 5.0]], words)
    sim.commands("unfix motion\ntimestep 0.01\nrun 300 post no")
    restart = sim.folder / "wall.restart"
    before = sim.fix_vector("floor", 8)
    sim.commands(f"write_restart {restart}")
    again = simulation().commands(
        f"""
        read_restart {restart}
        pair_style zero 2.0
        pair_coeff * *
        fix floor all peridem/wall {words}
        run 0 post no
        """
    )
    np.testing.assert_array_equal(again.fix_vector("floor", 8), before)
    assert before[7] > 0.0


def test_a_disc_dropped_on_the_floor_comes_to_no_more_than_its_height(simulation):
    """Weight, bonds, floor with friction and damping: energy falls, nothing passes the plane."""
    solid = Solid(bulk=30.0, shear=12.0, horizon=2.3, dimension=2)
    one = cloud(disc(4.2, centre=(0.0, 7.0)), dimension=2, margin=20)
    one.v[:, 0] = 0.5
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            f"""
        pair_style peridem/lps
        pair_coeff * * {lps_words(solid)}
        fix weight all gravity 0.1 vector 0 -1 0
        fix_modify weight energy yes
        fix floor all peridem/wall {FLOOR} restitution 0.7 friction 0.4
        fix_modify floor energy yes
        fix motion all nve
        timestep {number(0.02)}
        run 0 post no
        """
        )
    )
    energy = [sim.thermo("pe") + sim.thermo("ke")]
    scale = sim.thermo("ke") + 0.1 * one.mass.sum() * 3.0
    for _ in range(60):
        sim.commands("run 25 post no")
        energy.append(sim.thermo("pe") + sim.thermo("ke"))
        assert sim.atoms("x")[:, 1].min() > 0.0
    # the integrator's wiggle: (omega dt)^2/8 with omega ~ 15 is 1e-2 of the little energy that
    # vibrates, 1e-3 of the whole
    assert np.diff(energy).max() < 1e-3 * scale
    assert energy[-1] < energy[0] - 0.01 * scale


def test_nodes_that_overlap_the_wall_at_the_start_are_warned_about(simulation):
    """A wall at the outline of a grain, and not a contact distance away from it."""
    one = cloud(lattice((4, 3)) + np.array([0, 1.4, 0]), dimension=2)
    messages = []
    for height in (0.0, -0.7):
        sim = simulation().load(one, dimension=2)
        sim.commands(
            f"""
            pair_style zero 2.0
            pair_coeff * *
            fix floor all peridem/wall plane 0 {height} 0 0 1 0 radius 1.0 stiffness 5.0
            run 0 post no
            run 0 post no
            """
        )
        messages.append([line for line in sim.printed().splitlines() if "overlap the" in line])
    assert len(messages[0]) == 1  # not again at the second run
    assert "Fix floor peridem/wall: 4 nodes overlap the wall at the start" in messages[0][0]
    assert "the deepest by 60.0 % of the contact distance" in messages[0][0]
    assert not messages[1]
