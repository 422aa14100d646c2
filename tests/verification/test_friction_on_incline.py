"""A block on an incline: sticks below atan(mu), slides at g (sin - mu cos) above.

The incline is a floor, and gravity is tilted instead.  The block is 8 by 4 nodes in 2D and 5 by 3
by 5 in 3D and just touches at the start; viscous bonds and a damped floor bring it to rest.
"""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import cloud, lattice
from support.oracle import Solid
from support.runs import lps_words, number

FRICTION, GRAVITY, DT = 0.4, 0.02, 0.02
CRITICAL = np.arctan(FRICTION)
SETTLE, WATCH = 40.0, 40.0
SOLID = Solid(bulk=30.0, shear=15.0, horizon=2.3, dimension=2, viscosity=3.0)


def block_on_an_incline(simulation, tangential: str, angle: float, dimension: int = 2):
    """Positions and speeds along the slope, of the middle: once settled and ``WATCH`` later."""
    x = lattice((8, 4) if dimension == 2 else (5, 3, 5))
    x[:, 1] += 0.94 - x[:, 1].min()
    one = cloud(x, dimension=dimension, margin=30)
    sim = simulation().load(one, dimension=dimension)
    words = lps_words(SOLID if dimension == 2 else Solid(30.0, 15.0, 2.3, viscosity=3.0))
    down = f"{number(np.sin(angle))} {number(-np.cos(angle))} 0"
    sim.commands(
        f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {words}
        pair_coeff * * peridem/contact radius 0.95
        fix floor all peridem/wall plane 0 0 0 0 1 0 friction {FRICTION} damping 1.0 &
            tangential {tangential}
        fix weight all gravity {GRAVITY} vector {down}
        fix motion all nve
        timestep {DT}
        run {round(SETTLE / DT)} post no
        """
    )
    pages = [along(sim)]
    sim.commands(f"run {round(WATCH / DT)} post no")
    return sim, one, [*pages, along(sim)]


def along(sim) -> tuple[float, float]:
    return float(sim.atoms("x")[:, 0].mean()), float(sim.atoms("v")[:, 0].mean())


@pytest.mark.parametrize("share", [0.5, 0.9])
@pytest.mark.parametrize("dimension", [2, 3])
def test_with_springs_it_sticks_below_the_angle_of_friction_and_does_not_creep(
    dimension, share, simulation
):
    angle = share * CRITICAL
    sim, one, (before, after) = block_on_an_incline(simulation, "history", angle, dimension)
    # What is left of its vibration, which has died to 1e-7 of the speed of the fall.  Without
    # friction it would slide by 3 and more in this time, with the regularised law by 0.02.
    assert abs(after[0] - before[0]) < 1e-5
    assert abs(after[1]) < 1e-7
    weight = GRAVITY * one.mass.sum()
    on_floor = sim.fix_vector("floor", 2)
    # the floor carries all of it, as far as the block is at rest
    assert on_floor[0] == pytest.approx(weight * np.sin(angle), rel=1e-5)
    assert on_floor[1] == pytest.approx(-weight * np.cos(angle), rel=1e-5)


@pytest.mark.parametrize("tangential", ["history", "regularised"])
@pytest.mark.parametrize("share", [1.1, 1.5])
@pytest.mark.parametrize("dimension", [2, 3])
def test_above_it_slides_with_the_acceleration_of_coulomb(dimension, share, tangential, simulation):
    angle = share * CRITICAL
    _, _, (before, after) = block_on_an_incline(simulation, tangential, angle, dimension)
    expected = GRAVITY * (np.sin(angle) - FRICTION * np.cos(angle))
    # all nodes of the sole slip, so the floor takes mu times the weight; the vibration that is left
    # of the fall is below 1e-5 of the speed
    assert (after[1] - before[1]) / WATCH == pytest.approx(expected, rel=1e-4)


def test_the_regularised_law_creeps_at_the_speed_that_carries_the_weight(simulation):
    """No rest below the angle of friction: weight along the slope over gamma, for 8 nodes."""
    angle, gamma = 0.5 * CRITICAL, 5.0
    _, one, (before, after) = block_on_an_incline(simulation, f"regularised {gamma}", angle)
    speed = GRAVITY * one.mass.sum() * np.sin(angle) / (8 * gamma)
    # as above
    assert after[1] == pytest.approx(speed, rel=1e-4)
    assert after[0] - before[0] == pytest.approx(speed * WATCH, rel=1e-2)  # still slowing at first
