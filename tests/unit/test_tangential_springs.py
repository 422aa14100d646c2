"""``tangential history``: a spring that remembers, cut at the Coulomb limit, at nodes and walls."""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import cloud, lattice
from support.oracle import Solid
from support.runs import Simulation, lps_words, number

ACCURACY = 1e-12  # rounding
NORMAL, RATIO, MU = 5.0 * 0.4, 0.5, 0.3  # stiffness 5, overlap 0.4
WORDS = f"radius 1.0 stiffness 5.0 friction {MU} tangential history {RATIO}"
DT = 0.01


def dragged_pair(simulation, speed: tuple[float, float, float], extra: str = "") -> Simulation:
    """Node 1 held, node 2 dragged past it at a fixed distance of 0.6 in x."""
    one = cloud([[0, 0, 0], [0.6, 0, 0]], molecule=[1, 2], v=np.array([(0, 0, 0), speed]))
    sim = simulation().load(one)
    return sim.commands(
        f"""
        pair_style peridem/contact
        pair_coeff * * {WORDS} {extra}
        group dragged id 2
        fix drag dragged move linear {" ".join(number(value) for value in speed)}
        timestep {DT}
        run 0 post no
        """
    )


def along(sim: Simulation) -> np.ndarray:
    """Tangential force on node 2, in the plane normal to the line between the nodes."""
    x, f = sim.atoms("x"), sim.atoms("f")
    n = (x[1] - x[0]) / np.linalg.norm(x[1] - x[0])
    return f[1] - (f[1] @ n) * n


def test_the_spring_stretches_with_the_way_slid(simulation):
    """Below the limit: force = k_t times the way, opposite to it, the same on both nodes.

    The pair turns a little on the way: a second-order effect, 1e-4 of the force.
    """
    sim = dragged_pair(simulation, (0.0, 0.02, 0.0))
    for done in (100, 200):
        sim.commands("run 100 post no")
        way = 0.02 * DT * done
        assert along(sim)[1] == pytest.approx(-RATIO * 5.0 * way, rel=5e-3)
        force = sim.atoms("f")
        np.testing.assert_array_equal(force[0], -force[1])


def test_the_force_is_cut_at_mu_times_the_normal_force(simulation):
    sim = dragged_pair(simulation, (0.0, 0.2, 0.0)).commands("run 150 post no")
    x, f = sim.atoms("x"), sim.atoms("f")
    r = np.linalg.norm(x[1] - x[0])
    assert np.linalg.norm(along(sim)) == pytest.approx(MU * 5.0 * (1.0 - r), rel=1e-9)
    assert f[1] @ (0.0, 1.0, 0.0) < f[1] @ (x[1] - x[0]) / r * (x[1] - x[0])[1] / r  # drags back


def wall_dragged(simulation, words: str = WORDS) -> Simulation:
    """A node at rest 0.6 above a floor that moves; the node is held (no integration)."""
    one = cloud([[0, 0.6], [9, 9]], molecule=[1, 2], dimension=2, margin=20)
    return (
        simulation()
        .load(one, dimension=2)
        .commands(
            f"""
        pair_style zero 2.0
        pair_coeff * *
        fix floor all peridem/wall plane 0 0 0 0 1 0 {words} velocity 0.2 0 0
        timestep {DT}
        run 0 post no
        """
        )
    )


def test_at_a_wall_the_spring_grows_linearly_then_slides(simulation):
    sim = wall_dragged(simulation)
    stiffness, limit = RATIO * 5.0, MU * NORMAL
    for done in range(20, 201, 20):
        sim.commands("run 20 post no")
        expected = min(stiffness * 0.2 * DT * done, limit)
        # one step more or less at the start: nothing is lost, so only rounding is allowed
        assert sim.atoms("f")[0, 0] == pytest.approx(expected, rel=1e-9)
    assert expected == limit


def test_sliding_back_unloads_the_spring_from_the_limit(simulation):
    """After slip the spring holds mu f_N; 50 steps back release k_t times the way back."""
    sim = wall_dragged(simulation).commands("run 200 post no")
    sim.commands("velocity all set 0.4 0 0\nrun 50 post no")  # twice as fast as the wall
    back = 0.2 * DT * 50
    assert sim.atoms("f")[0, 0] == pytest.approx(MU * NORMAL - RATIO * 5.0 * back, rel=1e-9)


def test_the_spring_is_forgotten_when_contact_is_lost(simulation):
    sim = wall_dragged(simulation).commands("run 50 post no")
    held = sim.atoms("x")
    lifted = held + np.array([[0.0, 1.0, 0], [0, 0, 0]])
    count, order = 2, sim.order
    sim.lmp.numpy.extract_atom("x")[:count][order] = lifted
    sim.commands("run 1 post no")
    sim.lmp.numpy.extract_atom("x")[:count][order] = held
    sim.commands("run 10 post no")
    # rounding of positions of order 1, from whose differences the slip comes
    assert sim.atoms("f")[0, 0] == pytest.approx(RATIO * 5.0 * 0.2 * DT * 10, rel=1e-9)


def test_runs_in_pieces_neither_stretch_nor_lose_the_spring(simulation):
    whole = wall_dragged(simulation).commands("run 60 post no").atoms("f")
    pieces = wall_dragged(simulation)
    for _ in range(6):
        pieces.commands("run 10 post no\nrun 0 post no")
    # rounding: the same steps, sums of few terms
    np.testing.assert_allclose(pieces.atoms("f"), whole, rtol=1e-13)


SOLID = Solid(bulk=60.0, shear=30.0, horizon=2.3, dimension=2)


def block_on_slope(simulation, tangent: float, steps: int, words: str) -> Simulation:
    """A square block on the floor, weight tilted instead of the floor: tan(slope) = tangent."""
    one = cloud(lattice((5, 3)) + np.array([0, 1.995, 0]), dimension=2, margin=30)
    return (
        simulation()
        .load(one, dimension=2)
        .commands(
            f"""
        pair_style peridem/lps
        pair_coeff * * {lps_words(SOLID)} viscosity 2.0
        fix weight all gravity 0.1 vector {tangent} -1 0
        fix floor all peridem/wall plane 0 0 0 0 1 0 radius 1.0 stiffness 50.0 {words}
        fix motion all nve
        timestep 0.02
        run {steps} post no
        """
        )
    )


def test_a_block_rests_on_a_slope_below_the_friction_angle(simulation):
    """It sticks: after it has settled it does not creep, however long one waits."""
    sim = block_on_slope(simulation, 0.2, 4000, "damping 10.0 friction 0.3")
    before = sim.atoms("x")[:, 0].mean()
    sim.commands("run 4000 post no")
    # at rest but for what is left of the vibration
    assert abs(sim.atoms("x")[:, 0].mean() - before) < 1e-5
    assert np.abs(sim.atoms("v")).max() < 1e-5


def test_a_block_slides_on_a_slope_above_the_friction_angle(simulation):
    """Acceleration g (sin a - mu cos a), with g cos a the part across the floor."""
    tangent, mu = 0.6, 0.3
    sim = block_on_slope(simulation, tangent, 1000, f"damping 10.0 friction {mu}")
    start = sim.atoms("v")[:, 0].mean()
    sim.commands("run 1000 post no")
    across = 0.1 / np.hypot(1.0, tangent)
    gained = (sim.atoms("v")[:, 0].mean() - start) / (1000 * 0.02)
    # the block still rocks a little: its normal force varies about its weight
    assert gained == pytest.approx(across * (tangent - mu), rel=1e-2)


def test_regularised_friction_creeps_on_the_slope_at_the_speed_it_should(simulation):
    """gamma v = weight along the slope: five nodes carry the block, v = M g sin a / (5 gamma)."""
    gamma = 4.0
    sim = block_on_slope(
        simulation, 0.2, 6000, f"damping 10.0 friction 0.3 tangential regularised {gamma}"
    )
    along_slope = 15 * 0.1 * 0.2 / np.hypot(1.0, 0.2)
    # settled to the rocking that is left
    assert sim.atoms("v")[:, 0].mean() == pytest.approx(along_slope / (5 * gamma), rel=1e-2)


def test_springs_come_back_from_a_restart(simulation):
    sim = dragged_pair(simulation, (0.0, 0.02, 0.0)).commands("run 100 post no")
    restart = sim.folder / "springs.restart"
    sim.commands(f"write_restart {restart}")
    sim.commands("run 50 post no")
    again = simulation().commands(
        f"""
        read_restart {restart}
        group dragged id 2
        fix drag dragged move linear 0.0 0.02 0.0
        run 50 post no
        """
    )
    # the springs are most of the tangential force; x of the dragged node is the same to rounding
    np.testing.assert_allclose(again.atoms("f"), sim.atoms("f"), rtol=1e-12, atol=1e-14)


def test_springs_at_a_wall_come_back_from_a_restart(simulation):
    words = f"plane 0 0 0 0 1 0 {WORDS} velocity 0.2 0 0"
    sim = wall_dragged(simulation).commands("run 50 post no")
    restart = sim.folder / "springs.restart"
    sim.commands(f"write_restart {restart}\nrun 20 post no")
    again = simulation().commands(
        f"""
        read_restart {restart}
        pair_style zero 2.0
        pair_coeff * *
        fix floor all peridem/wall {words}
        run 20 post no
        """
    )
    np.testing.assert_allclose(again.atoms("f"), sim.atoms("f"), rtol=1e-12, atol=1e-14)
    # 70 steps of 0.2 dt in all
    assert again.atoms("f")[0, 0] == pytest.approx(RATIO * 5.0 * 0.2 * DT * 70, rel=1e-9)


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 1)])
def test_the_spring_turns_with_the_pair_and_reverses_after_any_turn(axis, simulation):
    """Node 2 circles about node 1, past the limit and through a large angle, then back.

    Where it turns round the spring is at its limit whatever way it points by then; going back it
    unloads with k_t times the way, and reaches the limit of the other sign.
    """
    axis = np.asarray(axis) / np.linalg.norm(axis)
    one = cloud([[0, 0, 0], 0.6 * np.cross(axis, [0, 1, 0])], molecule=[1, 2])
    one.x[1] *= 0.6 / np.linalg.norm(one.x[1])
    one.reference[:] = one.x
    limit, kt, rate = MU * NORMAL, RATIO * 5.0, 0.4
    sim = simulation().load(one)
    sim.commands(
        f"""
        pair_style peridem/contact
        pair_coeff * * {WORDS}
        group circling id 2
        timestep {DT}
        """
    )

    def turned(sign: int, angle: float) -> float:
        """Force along the way forward, after going on by an angle."""
        centre_and_axis = f"0 0 0 {' '.join(number(sign * a) for a in axis)}"
        sim.commands(
            f"""
            fix circle circling move rotate {centre_and_axis} {number(2 * np.pi / rate)}
            run {round(angle / rate / DT)} post no
            unfix circle
            """
        )
        x, f = sim.atoms("x"), sim.atoms("f")
        n = (x[1] - x[0]) / np.linalg.norm(x[1] - x[0])
        forward = np.cross(axis, n)
        # all of it in the plane of the circle: the spring has turned with the pair
        assert f[1] @ axis == pytest.approx(0.0, abs=1e-9)
        return float(f[1] @ forward)

    assert turned(1, 2.6) == pytest.approx(-limit, rel=1e-9)
    # one step is 0.6 rate DT = 0.0024 of way and 0.006 of force
    assert turned(-1, 0.2) == pytest.approx(-limit + kt * 0.6 * 0.2, abs=0.01)
    assert turned(-1, 0.3) == pytest.approx(-limit + kt * 0.6 * 0.5, abs=0.01)
    assert turned(-1, 2.0) == pytest.approx(limit, rel=1e-9)
