"""``fix peridem/adapt``: grains that are rigid until they must deform.

What is conserved at every switch, what equals ``fix nve`` and ``fix rigid/small``, when a grain
wakes and goes back, what it says when it is asked for the wrong thing.
"""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import Cloud, cloud, disc, join, lattice, momenta, rotated
from support.oracle import Contact, Solid
from support.runs import contact_words, lps_words, number

SOLID = Solid(bulk=3.0, shear=1.2, horizon=3.05, dimension=2, s0=0.02)
LAW = Contact(radius=0.95, stiffness=2.0, damping=0.0, friction=0.0, tangential=0.0)
DT = 0.02
DEFORMABLE, RIGID, ASLEEP = 1, 2, 3  # what the fix gives per atom


def two_discs(speed: float, spin: float = 0.0, offset: float = 0.0, radius: float = 4.0) -> Cloud:
    """Two discs on their way to each other along x."""
    x = disc(radius)
    right = rotated(x, 0.3) + np.array([2 * radius + 1.1, offset, 0.0])
    parts = [cloud(x, dimension=2), cloud(right, dimension=2, molecule=2)]
    for part, sign in zip(parts, (1.0, -1.0), strict=True):
        part.v[:, 0] = 0.5 * sign * speed
        r = part.x - part.x.mean(axis=0)
        part.v[:, :2] += sign * spin * np.column_stack([-r[:, 1], r[:, 0]])
    return join(*parts, margin=40)


def script(motion: str, solid: Solid = SOLID, law: str = contact_words(LAW), dt: float = DT) -> str:
    return f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(solid)}
        pair_coeff * * peridem/contact {law}
        fix motion all {motion}
        timestep {number(dt)}
        """


# --- nothing but time integration ----------------------------------------------------------------


def test_with_all_grains_awake_it_is_fix_nve_to_the_last_bit(simulation):
    one = two_discs(0.2, spin=0.01)
    ends = []
    for motion in ("nve", "peridem/adapt eta 0"):
        sim = simulation().load(one, dimension=2)
        sim.commands(script(motion) + "run 600 post no")
        ends.append((sim.atoms("x"), sim.atoms("v"), sim.atoms("f")))
    for nve, adapt in zip(*ends, strict=True):
        np.testing.assert_array_equal(nve, adapt)
    assert np.abs(ends[0][1] - one.v).max() > 0.05  # they did collide


@pytest.mark.parametrize("law", ["frictionless", "friction"])
def test_rigid_grains_move_as_those_of_fix_rigid_small(law, simulation):
    one = two_discs(0.2, spin=0.02, offset=2.0)
    words = contact_words(LAW)
    if law == "friction":
        words = "radius 0.95 stiffness 2.0 friction 0.5 tangential history"
    ends = []
    for motion in ("rigid/small molecule", "peridem/adapt eta 1e9"):
        sim = simulation().load(one, dimension=2)
        floor = f"fix floor all peridem/wall plane 0 -5 0 0 1 0 {words}\n"
        weight = "fix weight all gravity 0.002 vector 0 -1 0\n"
        lines = script(motion, law=words) + floor + weight
        # fixes that add forces come before those that sum them up, as the manual says of rigid
        sim.commands("comm_modify cutoff 6.0\n" + lines + "run 1500 post no")
        ends.append((sim.atoms("x"), sim.atoms("v")))
    (x, v), (y, w) = ends
    assert np.abs(v - one.v).max() > 0.05
    # rounding of 1500 steps, multiplied by a collision or two
    np.testing.assert_allclose(y, x, rtol=0, atol=1e-9)
    np.testing.assert_allclose(w, v, rtol=0, atol=1e-10)


def test_a_rigid_grain_in_three_dimensions_tumbles_freely(simulation, rng):
    """Euler's top: energy and angular momentum stay while the axis of spin wanders."""
    x = lattice((5, 3, 2)) + rng.uniform(-0.1, 0.1, (30, 3))
    one = cloud(x, dimension=3, margin=20)
    r = one.x - np.average(one.x, axis=0, weights=one.mass)
    one.v[:] = np.cross((0.02, 0.3, 0.01), r)
    solid = Solid(bulk=3.0, shear=1.2, horizon=2.1, dimension=3, s0=0.02)
    sim = simulation().load(one, dimension=3)
    sim.commands(script("peridem/adapt eta 1e9", solid) + "run 2000 post no")
    y, w = sim.atoms("x"), sim.atoms("v")
    before, after = (
        np.cross(a, one.mass[:, None] * b).sum(axis=0) for a, b in ((one.x, one.v), (y, w))
    )
    # rounding of 2000 steps
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-12 * np.linalg.norm(before))
    kinetic = [0.5 * (one.mass[:, None] * u**2).sum() for u in (one.v, w)]
    assert kinetic[1] == pytest.approx(kinetic[0], rel=1e-4)  # Richardson's step, O(dt^2)
    distances = [np.linalg.norm(a[:, None] - a[None], axis=2) for a in (one.x, y)]
    np.testing.assert_allclose(distances[1], distances[0], rtol=0, atol=1e-11)


# --- switching -----------------------------------------------------------------------------------


def test_every_switch_keeps_momentum_and_angular_momentum(simulation):
    """Through a collision and after it: the discs wake, ring, and go back."""
    one = two_discs(0.05, spin=0.005, offset=1.0)
    sim = simulation().load(one, dimension=2)
    motion = "peridem/adapt eta 0.2 back 0.6 every 10 hold 2"
    solid = Solid(**{**SOLID.__dict__, "viscosity": 1.0})  # or they would ring for ever
    sim.commands(script(motion, solid))
    before = momenta(one, one.x, one.v)
    scale = np.abs(one.v).sum()
    seen = []
    for _ in range(60):
        sim.commands("run 50 post no")
        after = momenta(one, sim.atoms("x"), sim.atoms("v"))
        # rounding; momenta of the order of those of single nodes at coordinates of 10
        assert np.abs(after - before)[:3].max() < 1e-12 * scale
        assert np.abs(after - before)[3:].max() < 1e-12 * scale * 10
        seen.append(sim.fix_vector("motion", 7))
    wakes, freezes = np.array(seen)[:, 3], np.array(seen)[:, 4]
    assert wakes[-1] >= 2 and freezes[-1] >= 2
    assert seen[0][1] == 2 and seen[-1][1] == 2  # rigid at first and at last


def test_what_vibrates_does_not_become_rigid_and_what_rests_does(simulation, rng):
    one = cloud(disc(4.0), dimension=2, margin=20)
    one.v[:, :2] = 1e-2 * rng.standard_normal((one.n, 2))
    sim = simulation().load(one, dimension=2)
    lines = script("peridem/adapt eta 0.3 start deformable every 10 hold 2")
    sim.commands(lines + "run 2000 post no")
    assert sim.fix_vector("motion", 3).tolist() == [1, 0, 0]
    sim.commands("velocity all set 0 0 0\nfix calm all viscous 0.5\nrun 4000 post no")
    assert sim.fix_vector("motion", 3).tolist() == [0, 1, 0]


def test_the_energy_that_switches_take_is_booked(simulation):
    """Kinetic, strain, contact, taken and damping: the ledger closes through wakes and freezes."""
    one = two_discs(0.05, spin=0.005)
    sim = simulation().load(one, dimension=2)
    solid = Solid(**{**SOLID.__dict__, "viscosity": 1.0})
    sim.commands(
        script("peridem/adapt eta 0.2 back 0.6 every 10 hold 2", solid)
        + "compute energy all peridem/energy\nthermo_style custom step c_energy\nthermo 100\n"
        "run 4000"
    )
    ledger = sim.lmp.numpy.extract_compute("energy", 0, 1).copy()
    motion = sim.fix_vector("motion", 7)
    assert motion[3] >= 2 and motion[4] >= 2 and motion[5] > 0.0
    kinetic = 0.5 * (one.mass[:, None] * one.v**2).sum()
    # at a switch the share of half a step is missing: measured 3e-5 of the energy that there is
    assert abs(ledger[7]) < 1e-4 * kinetic
    assert ledger[4] > 10 * abs(ledger[7])


def test_an_impact_breaks_a_rigid_grain_as_it_breaks_a_deformable_one(simulation):
    broken = []
    for motion in ("nve", "peridem/adapt eta 0.3"):
        one = two_discs(0.6)
        sim = simulation().load(one, dimension=2)
        sim.commands(
            "fix peridem_bonds all peridem/bonds\n" + script(motion, dt=0.01) + "run 3000 post no"
        )
        broken.append(sim.fix_vector("peridem_bonds", 2)[1])
    assert broken[0] > 50
    # the same waves from a start that is rounding, and a few steps of rigid motion, away
    assert broken[1] == pytest.approx(broken[0], rel=0.15)


def test_a_slow_load_wakes_a_grain_without_a_kick(simulation):
    """A disc pressed between plates: the force on the plate is within 3 % that
    on a disc that was deformable all along."""
    forces = []
    solid = Solid(**{**SOLID.__dict__, "viscosity": 3.0})
    for motion in ("nve", "peridem/adapt eta 0.3"):
        one = cloud(disc(4.0), dimension=2, margin=20)
        sim = simulation().load(one, dimension=2)
        sim.commands(
            script(motion, solid)
            + f"""
            fix low all peridem/wall plane 0 -4.96 0 0 1 0 {contact_words(LAW)}
            fix high all peridem/wall plane 0 4.96 0 0 -1 0 velocity 0 -1e-3 0 {contact_words(LAW)}
            """
        )
        course = []
        for _ in range(100):
            sim.commands("run 100 post no")
            course.append(sim.fix_vector("high", 3)[1])
        if motion != "nve":
            assert sim.fix_vector("motion", 4)[3] >= 1.0
        forces.append(np.array(course))
    nve, adapt = forces
    assert nve[-1] > 5 * nve[20] > 0.0
    late = slice(60, None)
    np.testing.assert_allclose(adapt[late], nve[late], rtol=0.03)


def test_a_grain_at_rest_falls_asleep_and_is_woken_by_a_hit(simulation):
    one = cloud(disc(4.0), dimension=2)
    one.x[:, 1] += 4.948
    ball = cloud(disc(2.0, centre=(0.0, 18.0)), dimension=2, molecule=2)
    scene = join(one, ball, margin=30)
    sim = simulation().load(scene, dimension=2)
    law = "radius 0.95 stiffness 2.0 damping 10"
    sim.commands(
        script("peridem/adapt eta 1e9 sleep 1e-3 every 10 hold 3", law=law)
        + f"fix floor all peridem/wall plane 0 0 0 0 1 0 {law}\n"
        "fix weight all gravity 1e-4 vector 0 -1 0\nrun 3000 post no"
    )
    states = sim.lmp.numpy.extract_fix("motion", 1, 1)[: scene.n][sim.order]
    assert set(states[scene.molecule == 1]) == {ASLEEP}
    assert set(states[scene.molecule == 2]) == {RIGID}
    lying = scene.molecule == 1
    assert np.all(sim.atoms("v")[lying] == 0.0)
    before = sim.atoms("x")[lying]
    sim.commands("group ball molecule 2\nvelocity ball set 0.05 -0.2 0 sum yes\nrun 3000 post no")
    assert np.abs(sim.atoms("x")[lying] - before).max() > 0.01


def test_the_state_of_nodes_and_the_counts_agree(simulation):
    one = two_discs(0.3)
    sim = simulation().load(one, dimension=2)
    sim.commands(script("peridem/adapt eta 0.3") + "run 0 post no")
    states = sim.lmp.numpy.extract_fix("motion", 1, 1)[: one.n]
    assert set(states) == {RIGID}
    sim.commands("run 300 post no")
    states = sim.lmp.numpy.extract_fix("motion", 1, 1)[: one.n]
    assert set(states) == {DEFORMABLE}
    assert sim.fix_vector("motion", 3).tolist() == [2, 0, 0]


# --- the time step -------------------------------------------------------------------------------


def test_rigid_grains_take_longer_steps_until_one_wakes(simulation):
    """No bonds limit them, and a contact pushes a whole grain: and yet it collides as it should."""
    one = two_discs(0.05)
    solid = Solid(**{**SOLID.__dict__, "viscosity": 1.0})
    sim = simulation().load(one, dimension=2)
    sim.commands(script("peridem/adapt eta 0.2", solid) + "fix step all peridem/timestep\nrun 0")
    before = sim.thermo("dt")
    assert sim.fix_vector("step", 1)[0] == 0.0  # no limit by bonds
    nodes = one.molecule == 1
    r = np.linalg.norm(one.x[nodes] - one.x[nodes].mean(axis=0), axis=1)
    felt = 1.0 / (1.0 / one.mass[nodes].sum() + r.max() ** 2 / (one.mass[nodes] @ r**2))
    # the bound of three springs at the farthest node, halved
    expected = 0.8 * 0.5 * np.sqrt(4.0 * felt / (2.0 * 3.0 * LAW.stiffness))
    assert before == pytest.approx(expected, rel=1e-12)
    while sim.fix_vector("motion", 4)[3] == 0.0:
        sim.commands("run 1 post no")
        assert sim.thermo("time") < 100.0
    assert sim.thermo("dt") < 0.3 * before
    sim.commands("run 100 post no")
    kinetic = 0.5 * (one.mass[:, None] * one.v**2).sum()
    assert sim.thermo("pe") + sim.thermo("ke") < 1.01 * kinetic


@pytest.mark.parametrize(
    ("radius", "nodes", "longer"), [(3.3, 37, 1.5), (6.3, 121, 2.7), (12.3, 481, 4.1)]
)
def test_how_much_longer_steps_are(radius, nodes, longer, simulation):
    """The page has these numbers."""
    x = disc(radius)
    assert len(x) == nodes
    width = x[:, 0].max() - x[:, 0].min()
    pair = cloud(x, dimension=2), cloud(x + np.array([width + 0.94, 0, 0]), molecule=2, dimension=2)
    steps = {}
    for eta in (0, 1e9):
        sim = simulation().load(join(*pair, margin=40), dimension=2)
        lines = script(f"peridem/adapt eta {eta}", law="form bulk 10")
        sim.commands(lines + "fix step all peridem/timestep\nrun 0 post no")
        steps[eta] = sim.thermo("dt")
    # a digit after the point is said
    assert steps[1e9] / steps[0] == pytest.approx(longer, abs=0.05)


# --- what it refuses -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("etta 1", "Unknown fix peridem/adapt keyword etta: known are eta, back"),
        ("eta", "eta needs a value"),
        ("eta -1", "eta -1: must be >= 0"),
        ("eta 1 eta 2", "Repeated fix peridem/adapt keyword eta"),
        ("back 1.0", "back 1.0: must be >= 0 and < 1"),
        ("every 0", "every 0: must be >= 1"),
        ("relax -1", "relax -1: must be >= 0"),
        ("hold 0", "hold 0: must be >= 1"),
        ("start stiff", "start stiff: must be rigid or deformable"),
        ("eta 1 stretch 0.1", "eta and stretch: give one of them"),
        ("stretch 0", "stretch 0: must be > 0"),
    ],
)
def test_bad_keywords(words, message, simulation):
    sim = simulation().load(two_discs(0.1), dimension=2)
    with pytest.raises(Exception, match=message):
        sim.commands(script(f"peridem/adapt {words}"))


def test_a_grain_of_which_only_a_part_is_in_the_group_is_an_error(simulation):
    sim = simulation().load(two_discs(0.1), dimension=2)
    sim.commands("group some id 1:20\n" + script("nve").replace("all nve", "some peridem/adapt"))
    with pytest.raises(Exception, match="whole grains only"):
        sim.commands("run 1")


def test_unbreakable_grains_need_a_stretch(simulation):
    solid = Solid(**{**SOLID.__dict__, "s0": np.inf})
    sim = simulation().load(two_discs(0.1), dimension=2)
    with pytest.raises(Exception, match="unbreakable grains, so eta says nothing"):
        sim.commands(script("peridem/adapt eta 0.3", solid) + "run 1")
    sim = simulation().load(two_discs(0.1), dimension=2)
    sim.commands(script("peridem/adapt stretch 0.01", solid) + "run 1 post no")


def test_in_two_dimensions_nothing_leaves_the_plane(simulation):
    """Rounding alone would do: a grain under load buckles out of it."""
    sim = simulation().load(two_discs(0.05, spin=0.005, offset=1.0), dimension=2)
    solid = Solid(**{**SOLID.__dict__, "viscosity": 1.0})
    sim.commands(script("peridem/adapt eta 0.2 back 0.6 every 10 hold 2", solid))
    sim.commands("run 3000 post no")
    assert sim.fix_vector("motion", 4)[3] >= 2
    assert np.all(sim.atoms("x")[:, 2] == 0.0)
    assert np.all(sim.atoms("v")[:, 2] == 0.0)


def test_relax_damps_what_a_slow_load_would_make_ring(simulation):
    """A disc without viscosity between plates that close slowly: what moves once it woke."""
    swings, energies = [], []
    for relax in (0, 4):
        one = cloud(disc(4.0), dimension=2, margin=20)
        sim = simulation().load(one, dimension=2)
        plates = [f"fix low all peridem/wall plane 0 -4.96 0 0 1 0 {contact_words(LAW)}"]
        plates += [f"fix high all peridem/wall plane 0 4.96 0 0 -1 0 {contact_words(LAW)}"]
        plates[1] += " velocity 0 -2e-4 0"
        sim.commands(script(f"peridem/adapt eta 0.3 back 0 relax {relax}") + "\n".join(plates))
        while sim.fix_vector("motion", 4)[3] == 0.0:
            sim.commands("run 50 post no")
        sim.commands("run 1800 post no")  # four periods of 9, and a little
        moving = []
        for _ in range(10):
            sim.commands("run 25 post no")
            v = sim.atoms("v")
            moving.append(np.sum((v - v.mean(axis=0)) ** 2))  # it does not spin
        swings.append(np.mean(moving))
        energies.append(sim.fix_vector("motion", 6)[5])
    assert swings[1] < 0.1 * swings[0]
    assert energies[0] == 0.0 < energies[1]
