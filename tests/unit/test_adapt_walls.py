"""The time step of ``fix peridem/adapt`` beside walls that are nodes without bonds.

What is held weighs nothing in the balance: rigid grains that only touch such walls take the steps
of whole grains, and collide with them as they should.
"""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import Cloud, cloud, disc, join, lattice
from support.oracle import Contact, Solid
from support.runs import contact_words, lps_words

SOLID = Solid(bulk=3.0, shear=1.2, horizon=3.05, dimension=2, s0=0.02)
LAW = Contact(radius=0.95, stiffness=2.0, damping=0.3, friction=0.0, tangential=0.0)
HOLDS = {
    "not integrated": "",
    "fix move": "fix hold wall move linear 0 0 0",
    "fix nve/noforce": "fix hold wall nve/noforce",
    "fix setforce": "fix hold wall nve\nfix still wall setforce 0 0 0",
    "fix setforce of two": "fix hold wall nve\nfix still wall setforce 0 0 NULL",
}
FREE = {
    "fix nve": "fix hold wall nve",
    "fix setforce of one": "fix hold wall nve\nfix still wall setforce 0 NULL NULL",
}


def disc_over_wall(gap: float) -> Cloud:
    """A disc and, below it, a row of nodes of another type."""
    ball = cloud(disc(4.0), dimension=2)
    row = lattice((21, 1)) - np.array([0.0, 4.0 + gap, 0.0])
    wall = cloud(row, dimension=2, molecule=2, types=2, volume=0.5)
    return join(ball, wall, margin=20)


def script(hold: str) -> str:
    return f"""
        group ball type 1
        group wall type 2
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff 1 1 peridem/lps {lps_words(SOLID)}
        pair_coeff * * peridem/contact {contact_words(LAW)}
        fix motion ball peridem/adapt eta 1e9
        {hold}
        """


def first_step(simulation, hold: str, gap: float) -> float:
    sim = simulation().load(disc_over_wall(gap), dimension=2)
    # not fix peridem/timestep: fix move does not let it change the step
    sim.commands(
        script(hold) + "compute dt all peridem/dt\nthermo_style custom c_dt\nrun 0 post no"
    )
    return sim.lmp.extract_compute("dt", 0, 0)


# apart, and with some nodes of the disc in the wall
@pytest.mark.parametrize("gap", [2.0, 0.94])
def test_a_held_wall_of_nodes_does_not_shorten_the_step(gap, simulation):
    steps = {name: first_step(simulation, hold, gap) for name, hold in {**HOLDS, **FREE}.items()}
    for name in HOLDS:
        assert steps[name] == pytest.approx(steps["not integrated"], rel=1e-12), name
    for name in FREE:  # single nodes: a disc has 49 of twice their mass, and a quarter is taken
        assert steps[name] < 0.4 * steps["not integrated"], name


def test_a_rigid_grain_bounces_off_a_wall_of_nodes(simulation):
    """As it does with a step ten times as short; no energy comes from the long one."""
    ends = {}
    for safety in (0.8, 0.08):
        one = disc_over_wall(1.2)
        one.v[one.molecule == 1, 1] = -0.1
        sim = simulation().load(one, dimension=2)
        sim.commands(
            script(f"fix step all peridem/timestep every 1 safety {safety}\n")
            + "variable now equal time\nfix over all halt 1 v_now > 80 error continue\n"
            "run 100000 post no"
        )
        v = sim.atoms("v")[one.molecule == 1]
        ends[safety] = v[:, 1].mean()
    assert 0.0 < ends[0.8] < 0.1  # the dashpots took something
    # second order in a step that resolves the collision with some twenty
    assert ends[0.8] == pytest.approx(ends[0.08], rel=0.03)
