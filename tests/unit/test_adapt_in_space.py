"""``fix peridem/adapt`` in three dimensions: what ``test_adapt.py`` shows of discs, of blocks."""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import Cloud, cloud, join, lattice, momenta, rotated
from support.oracle import Contact, Solid
from support.runs import contact_words, lps_words, number

SOLID = Solid(bulk=3.0, shear=1.2, horizon=2.1, dimension=3, s0=0.02, viscosity=1.0)
LAW = Contact(radius=0.95, stiffness=2.0, damping=0.0, friction=0.0, tangential=0.0)
RUBBING = "radius 0.95 stiffness 2.0 friction 0.5 tangential history"
EDGE = 4  # nodes


def two_blocks(speed: float, spin: float = 0.0, offset: float = 0.0) -> Cloud:
    """Two cubes on their way to each other along x, turned and not in line, so that they tumble."""
    x = lattice((EDGE, EDGE, EDGE))
    right = rotated(x, 0.3) + np.array([EDGE + 1.6, offset, 0.5 * offset])
    parts = [cloud(x), cloud(right, molecule=2)]
    for part, sign in zip(parts, (1.0, -1.0), strict=True):
        r = part.x - part.x.mean(axis=0)
        part.v[:] = sign * np.cross((0.3 * spin, -0.2 * spin, spin), r)
        part.v[:, 0] += 0.5 * sign * speed
    return join(*parts, margin=40)


def script(motion: str, law: str = contact_words(LAW), dt: float = 0.02) -> str:
    return f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(SOLID)}
        pair_coeff * * peridem/contact {law}
        fix motion all {motion}
        timestep {number(dt)}
        """


def test_with_all_grains_awake_it_is_fix_nve_to_the_last_bit(simulation):
    one = two_blocks(0.2, spin=0.01, offset=1.0)
    ends = []
    for motion in ("nve", "peridem/adapt eta 0"):
        sim = simulation().load(one, dimension=3)
        sim.commands(script(motion) + "run 600 post no")
        ends.append((sim.atoms("x"), sim.atoms("v"), sim.atoms("f")))
    for nve, adapt in zip(*ends, strict=True):
        np.testing.assert_array_equal(nve, adapt)
    assert np.abs(ends[0][1] - one.v).max() > 0.05  # they did collide


@pytest.mark.parametrize("law", [contact_words(LAW), RUBBING], ids=["frictionless", "friction"])
def test_rigid_grains_move_as_those_of_fix_rigid_small(law, simulation):
    """They fall, hit each other off centre, spin, bounce on a floor and slide on it."""
    one = two_blocks(0.2, spin=0.05, offset=2.0)
    ends = []
    for motion in ("rigid/small molecule", "peridem/adapt eta 1e9"):
        sim = simulation().load(one, dimension=3)
        floor = f"fix floor all peridem/wall plane 0 -3.5 0 0 1 0 {law}\n"
        weight = "fix weight all gravity 0.005 vector 0 -1 0\n"
        # fixes that add forces come before those that sum them up, as the manual says of rigid
        sim.commands("comm_modify cutoff 9.0\n" + script(motion, law) + floor + weight)
        sim.commands("run 1500 post no")
        assert sim.fix_vector("floor", 3)[1] != 0.0 or np.abs(sim.atoms("v")[:, 1]).max() > 0.05
        ends.append((sim.atoms("x"), sim.atoms("v")))
    (x, v), (y, w) = ends
    assert np.abs(v - one.v).max() > 0.05
    # both turn with Richardson's step; rounding of 1500 of them, grown by collisions
    np.testing.assert_allclose(y, x, rtol=0, atol=1e-9)
    np.testing.assert_allclose(w, v, rtol=0, atol=1e-10)


def test_every_switch_keeps_momentum_and_angular_momentum(simulation):
    """Through a collision and after it: the blocks wake, ring, and go back."""
    one = two_blocks(0.05, spin=0.01, offset=1.0)
    sim = simulation().load(one, dimension=3)
    sim.commands(script("peridem/adapt eta 0.2 back 0.6 every 10 hold 2"))
    before = momenta(one, one.x, one.v)
    scale = (one.mass[:, None] * np.abs(one.v)).sum()
    seen = []
    for _ in range(60):
        sim.commands("run 100 post no")
        drift = np.abs(momenta(one, sim.atoms("x"), sim.atoms("v")) - before)
        # rounding; momenta of the order of those of single nodes at coordinates of 10
        assert drift[:3].max() < 1e-12 * scale
        assert drift[3:].max() < 1e-12 * scale * 10
        seen.append(sim.fix_vector("motion", 7))
    wakes, freezes = np.array(seen)[:, 3], np.array(seen)[:, 4]
    assert wakes[-1] >= 2 and freezes[-1] >= 2
    assert seen[0][1] == 2 and seen[-1][1] == 2  # rigid at first and at last


def test_an_impact_breaks_a_sleeping_grain(simulation):
    """As it breaks one that was deformable all along."""
    lying = cloud(lattice((EDGE, EDGE, EDGE)))
    lying.x[:, 1] += 0.5 * (EDGE - 1) + 0.96
    ball = cloud(lattice((EDGE, EDGE, EDGE)) + np.array([0.0, 14.0, 0.0]), molecule=2)
    ball.v[:, 1] = -0.6
    floor = f"fix floor all peridem/wall plane 0 0 0 0 1 0 {contact_words(LAW)}\n"
    damage = {}
    for motion in ("nve", "peridem/adapt eta 0.3 sleep 1e-3 every 10 hold 3"):
        sim = simulation().load(join(lying, ball, margin=40), dimension=3)
        sim.commands(
            script(motion, dt=0.01) + f"compute node all peridem/atom damage\n{floor}"
            "run 500 post no"
        )
        if motion != "nve":
            assert sim.fix_vector("motion", 3).tolist() == [0, 1, 1]  # it flies, the other sleeps
        sim.commands("run 2500 post no")
        damage[motion] = sim.compute("node")[: EDGE**3].mean()
    nve, adapt = damage.values()
    assert nve > 0.05
    # the same waves from a start that is a few steps of rigid motion away
    assert adapt == pytest.approx(nve, rel=0.15)
