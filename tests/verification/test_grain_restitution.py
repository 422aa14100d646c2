"""``restitution`` of deformable grains: two discs of 123 nodes, and one on a wall.

Speeds are 0.0007 to 0.017 of the speed of sound.  Measured ratios of the speeds of parting and
approach, without friction, over these speeds (one number varies by 0.01 between them):

=====  =============  =============  =============  =============  =============
asked  head-on        head-on        head-on        wall           wall
       tip to tip     gap to gap     tip to gap     head-on        at 0.5 rad
=====  =============  =============  =============  =============  =============
1.0    0.98 to 0.99   0.98           0.97 to 0.99   0.98 to 0.99   0.98 to 0.99
0.9    0.90           0.91           0.87           0.88 to 0.90   0.88 to 0.90
0.7    0.74           0.78           0.74 to 0.75   0.68 to 0.72   0.68 to 0.72
0.5    0.64           0.63 to 0.64   0.60 to 0.61   0.52 to 0.58   0.52 to 0.58
=====  =============  =============  =============  =============  =============

So 0.9 is met within 0.05, also 0.7 on a wall; 0.7 between discs within 0.1, 0.5 on a wall within
0.1; and 0.5 between discs within 0.15: less is lost than asked for.

A disc of nodes is a cogwheel: where nodes of one do not meet nodes or gaps of the other, the force
between two nodes points up to 30 degrees past the centres, and turns the discs even without
friction.  Head-on and a quarter of a node off, 0.98 becomes 0.44 to 0.94 along the line of centres
(the rest is spin), and oblique collisions give 0.27 to 1.02.  That is the shape of the surface and
no loss; what is asserted there is that momentum is kept and energy is not gained.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from support.clouds import Cloud, cloud, join, rotated
from support.oracle import Solid
from support.runs import lps_words, number

SOLID = Solid(bulk=30.0, shear=18.0, horizon=3.75, dimension=2)
REACH, DT = 0.95, 0.02
RINGS = (1, 6, 12, 17, 23, 29, 35)  # nodes on circles of radius 0, 1, ... 6
RADIUS = len(RINGS) - 1
SPEEDS = (0.005, 0.03, 0.12)
PHASES = {"tip to tip": (0.0, 0.0), "gap to gap": (0.5, 0.5), "tip to gap": (0.0, 0.5)}
ALLOWED = {0.9: 0.05, 0.7: 0.1, 0.5: 0.15}  # measured, see above


def round_disc(phase: float) -> np.ndarray:
    """A disc of rings, turned by a part of the spacing of its outermost nodes."""
    parts = []
    for radius, count in enumerate(RINGS):
        angle = 2 * np.pi * np.arange(count) / count
        parts.append(radius * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]))
    return rotated(np.concatenate(parts), 2 * np.pi * phase / RINGS[-1])


def discs(speed: float, angle: float, phases: tuple[float, float]) -> Cloud:
    """Two discs a little apart along x, one the other in a mirror, on their way to each other."""
    right = round_disc(phases[1]) * (-1, 1, 1) + (2 * RADIUS + REACH + 0.02, 0, 0)
    parts = [cloud(round_disc(phases[0]), dimension=2), cloud(right, dimension=2, molecule=2)]
    velocity = 0.5 * speed * np.array([np.cos(angle), np.sin(angle), 0.0])
    parts[0].v[:], parts[1].v[:] = velocity, -velocity
    return join(*parts, margin=40)


def collided(simulation, one: Cloud, restitution: float, speed: float, dt: float = DT):
    sim = simulation().load(one, dimension=2)
    return sim.commands(
        f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(SOLID)}
        pair_coeff * * peridem/contact radius {REACH} restitution {restitution}
        fix motion all nve
        timestep {number(dt)}
        run {round((0.4 / speed + 30.0) / dt)} post no
        """
    )


def parting(simulation, restitution, speed, phases) -> float:
    one = discs(speed, 0.0, phases)
    v = collided(simulation, one, restitution, speed).atoms("v")[:, 0]
    return float(v[one.molecule == 2].mean() - v[one.molecule == 1].mean()) / speed


def rebound(simulation, restitution, speed, angle, phase) -> float:
    """Speed away from a floor, as a part of that towards it."""
    x = rotated(round_disc(phase), -0.5 * np.pi)
    x[:, 1] += RADIUS + REACH + 0.02
    one = cloud(x, dimension=2, margin=40)
    one.v[:] = speed * np.array([np.sin(angle), -np.cos(angle), 0.0])
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"""
        pair_style peridem/lps
        pair_coeff * * {lps_words(SOLID)}
        fix floor all peridem/wall plane 0 0 0 0 1 0 radius {REACH} restitution {restitution}
        fix motion all nve
        timestep {number(DT)}
        run {round((0.4 / speed + 30.0) / DT)} post no
        """
    )
    v = sim.atoms("v")
    # no friction: what goes along the floor stays
    assert v[:, 0].mean() == pytest.approx(speed * np.sin(angle), abs=1e-9 * speed)
    return float(v[:, 1].mean() / (speed * np.cos(angle)))


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("speed", SPEEDS)
def test_discs_part_with_the_restitution_asked_for(speed, phase, simulation):
    ratios = [parting(simulation, value, speed, PHASES[phase]) for value in (1.0, 0.9, 0.7, 0.5)]
    assert 0.95 < ratios[0] <= 1.0  # without loss in the law, 3 parts in 100 stay as vibration
    assert all(more > less for more, less in itertools.pairwise(ratios))
    for (asked, allowed), got in zip(ALLOWED.items(), ratios[1:], strict=True):
        assert got == pytest.approx(asked, abs=allowed)


@pytest.mark.parametrize("angle", [0.0, 0.5])
@pytest.mark.parametrize("speed", SPEEDS)
def test_a_disc_leaves_a_wall_with_the_restitution_asked_for(speed, angle, simulation):
    for phase in (0.0, 0.5):
        ratios = [rebound(simulation, value, speed, angle, phase) for value in (1.0, 0.9, 0.7, 0.5)]
        assert 0.95 < ratios[0] <= 1.0
        assert all(more > less for more, less in itertools.pairwise(ratios))
        # measured, see above
        for asked, allowed, got in zip((0.9, 0.7, 0.5), (0.05, 0.05, 0.1), ratios[1:], strict=True):
            assert got == pytest.approx(asked, abs=allowed)


@pytest.mark.parametrize("restitution", [1.0, 0.7])
@pytest.mark.parametrize("phases", [(0.0, 0.0), (0.0, 0.5), (0.0, 0.25)])
def test_oblique_collisions_keep_momentum_and_gain_no_energy(phases, restitution, simulation):
    speed = 0.12
    one = discs(speed, 0.5, phases)
    sim = collided(simulation, one, restitution, speed, dt=0.5 * DT)
    x, v = sim.atoms("x"), sim.atoms("v")
    scale = np.abs(one.v).sum()
    # some 4000 steps of rounding at coordinates of 20
    assert np.abs(v.sum(axis=0)).max() < 1e-12 * scale
    spin = np.cross(one.x, one.v).sum(axis=0)[2]
    assert np.cross(x, v).sum(axis=0)[2] == pytest.approx(spin, abs=1e-11 * scale * RADIUS)
    before, after = 0.5 * np.sum(one.v**2), sim.thermo("ke") + sim.thermo("pe")
    turned = v[one.molecule == 2].mean(axis=0) - one.v[one.molecule == 2][0]
    assert turned[0] > 0.3 * speed  # they did collide
    # the drift of the integrator, and real loss where it was asked for
    assert after < before * (1.0 + 1e-3)
    assert (after < 0.9 * before) == (restitution < 1.0)
