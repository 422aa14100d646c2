"""Deformable grains in a rotating drum that is made of regions alone, in 2D and 3D."""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import Cloud, cloud, disc, join, lattice
from support.oracle import Solid
from support.runs import Simulation, lps_words, number

SPIN, WEIGHT = -0.05, 0.02
DRUM = f"""
    variable turn equal {SPIN}*time
    region shell cylinder z 0 0 12 INF INF units box rotate v_turn 0 0 0 0 0 1
    region fin block 8 15 -1 1 INF INF side out units box rotate v_turn 0 0 0 0 0 1
    region drum intersect 2 shell fin
"""


def grains(dimension: int) -> Cloud:
    """Three discs, or three cubes, beside each other at the bottom of the drum."""
    centres = [(-4.6, -6.0), (0.0, -8.0), (4.6, -6.0)]
    parts = []
    for k, centre in enumerate(centres):
        if dimension == 2:
            x = disc(2.1, centre=centre)
        else:
            x = lattice((3, 3, 3)) + np.array([*centre, 0.0])
        parts.append(cloud(x, molecule=k + 1, dimension=dimension))
    return join(*parts, margin=25)


def tumbling(simulation, dimension: int, contact: str, drum: str = DRUM) -> Simulation:
    solid = Solid(bulk=20.0, shear=8.0, horizon=2.3, dimension=dimension)
    return (
        simulation()
        .load(grains(dimension), dimension=dimension)
        .commands(
            f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(solid)}
        pair_coeff * * peridem/contact form bulk 1 {contact}
        {drum}
        fix drum all peridem/wall region drum
        fix_modify drum energy yes
        fix weight all gravity {WEIGHT} vector 0 -1 0
        fix_modify weight energy yes
        fix motion all nve
        thermo_style custom step pe ke
        thermo_modify norm no
        timestep {number(0.02)}
        run 0 post no
        """
        )
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_without_losses_the_work_of_the_drum_is_the_energy_of_the_grains(dimension, simulation):
    sim = tumbling(simulation, dimension, "restitution 1 friction 0")
    start = sim.thermo("pe") + sim.thermo("ke")
    for _ in range(10):
        sim.commands("run 150 post no")
        work = sim.fix_vector("drum", 8)[7]
        # second order in the step: (omega dt)^2 / 8 is 7e-3 for the stiffest vibrations, which
        # hold some percent of the energy; work taken at the end of each step would miss by 1e-2
        energy = sim.thermo("pe") + sim.thermo("ke") - start
        assert energy == pytest.approx(work, abs=5e-4 * max(work, 1.0))
    assert work > 5.0


def test_losses_only_take(simulation):
    """Friction and restitution: the energy that the drum has not brought falls, never rises."""
    sim = tumbling(simulation, 2, "restitution 0.6 friction 0.5")
    start = sim.thermo("pe") + sim.thermo("ke")
    lost, work = [0.0], 0.0
    for _ in range(40):
        sim.commands("run 50 post no")
        work = sim.fix_vector("drum", 8)[7]
        lost.append(start + work - sim.thermo("pe") - sim.thermo("ke"))
    # the integrator gives or takes 5e-4 of the work, see above, and far less within 50 steps
    assert np.diff(lost).min() > -1e-4 * work
    assert lost[-1] > 0.05 * work > 0.0


def test_a_disc_at_rest_in_a_round_drum_rolls_with_it(simulation):
    """No slip where they touch, on average over some turns."""
    round_drum = f"""
        variable turn equal {SPIN}*time
        region drum cylinder z 0 0 12 INF INF units box rotate v_turn 0 0 0 0 0 1
    """
    x = disc(3.3)
    lowest = 12.0 - np.abs(x[:, 1]).max() - 0.94
    one = cloud(x - (0, lowest, 0), dimension=2, margin=15)
    solid = Solid(bulk=20.0, shear=8.0, horizon=2.3, dimension=2, viscosity=1.0)
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(solid)}
        pair_coeff * * peridem/contact form bulk 1 friction 0.5 damping 1
        {round_drum}
        fix drum all peridem/wall region drum
        fix weight all gravity 0.05 vector 0 -1 0
        fix motion all nve
        timestep 0.02
        run 20000 post no
        """
    )
    turn = []
    for _ in range(400):
        sim.commands("run 20 post no")
        x, v = sim.atoms("x"), sim.atoms("v")
        arm, rate = x - x.mean(axis=0), v - v.mean(axis=0)
        turn.append(np.sum(np.cross(arm, rate)[:, 2]) / np.sum(arm**2))
    # nodes at the wall have its speed, and the outline passes by them: an octagon with sides 2
    # and sqrt(8); corners on edges of its rolling slip a little
    outline = 4 * (2 + np.sqrt(8))
    assert np.mean(turn) == pytest.approx(2 * np.pi * SPIN * 12.0 / outline, rel=0.05)
