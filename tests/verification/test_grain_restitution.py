"""``restitution`` of deformable grains: discs of 123 nodes and other shapes, and walls.

What is measured is what ``restitution`` means for any two bodies: the speed at which they part
along the line of the total impulse between them, over that at which they came, both of the points
on that line as if the bodies were rigid (:func:`restitution_of`).  Head-on that is the ratio of the
speeds of the centres.  Speeds are 0.0007 to 0.017 of the speed of sound, without friction.

Where two grains meet tip to tip, gap to gap or tip to gap, measured (``pytest -s`` prints them):

=====  ============  ============  =================  =================
asked  head-on       disc on wall  oblique, 0.3 rad,  oblique, 0.6 rad,
                                   slowest            slowest
=====  ============  ============  =================  =================
1.0    0.97 to 0.99  0.98 to 0.99  0.98 to 0.99       0.97 to 0.99
0.9    0.88 to 0.89  0.88 to 0.89  0.88 to 0.91       0.87 to 0.89
0.7    0.68 to 0.69  0.68 to 0.70  0.68 to 0.72       0.68 to 0.69
0.5    0.49 to 0.50  0.49 to 0.50  0.49 to 0.55       0.48 to 0.50
0.3    0.29 to 0.30  0.29 to 0.30  0.29 to 0.33       0.29 to 0.32
=====  ============  ============  =================  =================

A disc of nodes is a cogwheel.  Elsewhere two of them meet at one node after another: each of these
collisions has the restitution asked for, their sum need not have it, and has not for rigid bodies
of the same shape either (0.58 for 0.5, and 0.37 for balls of 147 nodes).  So there rigid bodies are
what deformable grains are compared with.

Where nodes slide past each other by a tenth of their distance and more while they touch, fast and
oblique, the direction of the contact turns meanwhile: 0.62 to 0.76 for 0.7, 0.40 to 0.59 for 0.5.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from support.clouds import Cloud, cloud, disc, join, lattice, rotated
from support.oracle import Array, Solid
from support.runs import lps_words, number

SOLID = Solid(bulk=30.0, shear=18.0, horizon=3.75, dimension=2)
SOLID_3D = Solid(bulk=30.0, shear=18.0, horizon=2.5, dimension=3)
REACH, DT = 0.95, 0.02
RINGS = (1, 6, 12, 17, 23, 29, 35)  # nodes on circles of radius 0, 1, ... 6
RADIUS = len(RINGS) - 1
SPEEDS = (0.005, 0.03, 0.12)
PHASES = {"tip to tip": (0.0, 0.0), "gap to gap": (0.5, 0.5), "tip to gap": (0.0, 0.5)}
BETWEEN = {"quarter": (0.0, 0.25), "fifths": (0.1, 0.4)}
VALUES = (0.9, 0.7, 0.5, 0.3)
ALLOWED = 0.05  # what this law promises; measured: see above


def round_disc(phase: float) -> np.ndarray:
    """A disc of rings, turned by a part of the spacing of its outermost nodes."""
    parts = []
    for radius, count in enumerate(RINGS):
        angle = 2 * np.pi * np.arange(count) / count
        parts.append(radius * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]))
    return rotated(np.concatenate(parts), 2 * np.pi * phase / RINGS[-1])


def facing(left: Array, right: Array, speed: float, angle: float, turn: float = 0.0, **options):
    """Two grains on their way to each other: the second at +x, then all turned in the plane."""
    # as near as can be without a contact: no two nodes nearer than the contact distance
    shift = 0.0
    for x in left:
        across = np.sum((right[:, 1:] - x[1:]) ** 2, axis=1)
        reach = np.sqrt(np.maximum(REACH**2 - across, 0.0))
        needed = np.where(across < REACH**2, x[0] + reach - right[:, 0], -np.inf)
        shift = max(shift, float(needed.max()))
    right = right + np.array([shift + 0.02, 0, 0])
    velocity = 0.5 * speed * np.array([np.cos(angle), np.sin(angle), 0.0])
    parts = [cloud(left, **options), cloud(right, molecule=2, **options)]
    total = sum(part.mass.sum() for part in parts)
    for part, other, sign in ((parts[0], parts[1], 1), (parts[1], parts[0], -1)):
        part.v[:] = sign * 2 * velocity * other.mass.sum() / total
    for part in parts:
        part.x[:] = rotated(part.x, turn)
        part.reference[:], part.v[:] = part.x, rotated(part.v, turn)
    return join(*parts, margin=40)


def discs(speed: float, angle: float, phases: tuple[float, float], turn: float = 0.0) -> Cloud:
    """Two discs a little apart, one the other in a mirror."""
    right = round_disc(phases[1]) * (-1, 1, 1)
    return facing(round_disc(phases[0]), right, speed, angle, turn, dimension=2)


def collided(
    simulation, one: Cloud, restitution: float, speed: float, dt: float = DT, solid: Solid = SOLID
):
    sim = simulation().load(one, dimension=solid.dimension)
    return sim.commands(
        f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(solid)}
        pair_coeff * * peridem/contact radius {REACH} restitution {restitution}
        fix motion all nve
        timestep {number(dt)}
        run {round((0.6 / speed + 30.0) / dt)} post no
        """
    )


def motion(x: Array, v: Array, mass: Array) -> tuple[Array, Array, Array]:
    """Velocity of the centre of mass, tensor of inertia and angular momentum of one grain."""
    total = mass.sum()
    arm, velocity = x - mass @ x / total, mass @ v / total
    spin = (mass[:, None] * np.cross(arm, v - velocity)).sum(axis=0)
    squares = np.einsum("i,ij,ik->jk", mass, arm, arm)
    return velocity, np.trace(squares) * np.eye(3) - squares, spin


def restitution_of(one: Cloud, x: Array, v: Array) -> float:
    """Speed of parting over that of approach, on the line of the impulse between two grains."""
    speeds = np.zeros(2)
    states = []
    for grain in (1, 2):
        own = one.molecule == grain
        mass = one.mass[own]
        states.append([motion(one.x[own], one.v[own], mass), motion(x[own], v[own], mass)])
    mass = one.mass[one.molecule == 2].sum()
    impulse = mass * (states[1][1][0] - states[1][0][0])
    size = np.linalg.norm(impulse)
    for (before, after), sign in zip(states, (-1, 1), strict=True):
        # the moment of the impulse about the centre is the change of the angular momentum
        lever = (after[2] - before[2]) / size
        for when, (velocity, inertia, spin) in enumerate((before, after)):
            speeds[when] += sign * velocity @ impulse / size + lever @ np.linalg.solve(
                inertia, spin
            )
    return -speeds[1] / speeds[0]


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
    for asked in (1.0, *VALUES):
        one = discs(speed, 0.0, PHASES[phase])
        sim = collided(simulation, one, asked, speed)
        got = restitution_of(one, sim.atoms("x"), sim.atoms("v"))
        print(f"head-on: {asked} asked, {got:.3f} found")  # pytest -s
        assert got == pytest.approx(asked, abs=ALLOWED), asked


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("angle", [0.3, 0.6])
def test_oblique_collisions_have_the_restitution_asked_for(angle, phase, simulation):
    speed = SPEEDS[0]  # at higher ones nodes slide past each other, see above
    for asked in (1.0, *VALUES):
        one = discs(speed, angle, PHASES[phase])
        sim = collided(simulation, one, asked, speed)
        got = restitution_of(one, sim.atoms("x"), sim.atoms("v"))
        print(f"by {angle}: {asked} asked, {got:.3f} found")
        assert got == pytest.approx(asked, abs=ALLOWED), asked


@pytest.mark.parametrize("angle", [0.3, 0.9])
def test_fast_oblique_collisions_stray_by_a_tenth(angle, simulation):
    for speed, phase, asked in itertools.product(SPEEDS[1:], PHASES.values(), (0.9, 0.7, 0.5)):
        one = discs(speed, angle, phase)
        sim = collided(simulation, one, asked, speed)
        got = restitution_of(one, sim.atoms("x"), sim.atoms("v"))
        print(f"fast, by {angle}: {asked} asked, {got:.3f} found")
        assert got == pytest.approx(asked, abs=0.11)  # measured, see above


@pytest.mark.parametrize("angle", [0.0, 0.3])
def test_the_direction_of_the_pair_does_not_matter(angle, simulation):
    speed, found = SPEEDS[1], []
    for turn in (0.0, 0.4):
        one = discs(speed, angle, BETWEEN["fifths"], turn)
        sim = collided(simulation, one, 0.5, speed)
        found.append(restitution_of(one, sim.atoms("x"), sim.atoms("v")))
    # the same scene in other coordinates; rounding grows while nodes rattle
    assert found[1] == pytest.approx(found[0], abs=1e-6)
    assert found[0] == pytest.approx(0.5, abs=ALLOWED)


def rigid(simulation, one: Cloud, restitution: float, speed: float, solid: Solid = SOLID) -> float:
    """The same collision of rigid bodies."""
    sim = simulation().load(one, dimension=solid.dimension)
    sim.commands(
        f"""
        comm_modify cutoff 20
        pair_style peridem/contact
        pair_coeff * * modulus {solid.bulk} radius {REACH} restitution {restitution}
        fix motion all rigid/nve/small molecule
        timestep {DT}
        run {round((0.6 / speed + 30.0) / DT)} post no
        """
    )
    return restitution_of(one, sim.atoms("x"), sim.atoms("v"))


@pytest.mark.parametrize("phase", BETWEEN)
@pytest.mark.parametrize("angle", [0.0, 0.6])
def test_cogwheels_part_as_rigid_ones_do(angle, phase, simulation):
    speed = SPEEDS[0]
    one = discs(speed, angle, BETWEEN[phase])
    for asked in (0.7, 0.5):
        sim = collided(simulation, one, asked, speed)
        got = restitution_of(one, sim.atoms("x"), sim.atoms("v"))
        assert got == pytest.approx(rigid(simulation, one, asked, speed), abs=ALLOWED), asked


def test_rigid_grains_that_meet_once_part_exactly_as_asked(simulation):
    """A node of one on a node of the other, off centre: the closed form."""
    one = discs(SPEEDS[0], 0.6, BETWEEN["quarter"])
    for asked in (1.0, *VALUES):
        # some 200 steps of contact, with velocities half a step behind: measured 0.001
        assert rigid(simulation, one, asked, SPEEDS[0]) == pytest.approx(asked, abs=0.003)


@pytest.mark.parametrize("angle", [0.0, 0.5])
@pytest.mark.parametrize("speed", SPEEDS)
def test_a_disc_leaves_a_wall_with_the_restitution_asked_for(speed, angle, simulation):
    for phase in (0.0, 0.5):
        for asked in (1.0, *VALUES):
            got = rebound(simulation, asked, speed, angle, phase)
            print(f"wall: {asked} asked, {got:.3f} found")
            assert got == pytest.approx(asked, abs=ALLOWED), asked


def hexagon(rings: int = 6) -> Array:
    """A hexagon of a triangular lattice, a corner at +x; 127 nodes."""
    a, b = np.meshgrid(*2 * [np.arange(-rings, rings + 1.0)])
    inside = np.abs(a + b) <= rings
    a, b = a[inside], b[inside]
    return np.column_stack([a + 0.5 * b, np.sqrt(0.75) * b, 0 * a])


SHAPES = {
    "lattice discs": (disc(6.2), disc(6.2)),
    "large and small": (disc(8.1), disc(4.1)),
    "corner on corner": (hexagon(), hexagon()),
    "corner on face": (hexagon(), rotated(hexagon(), np.pi / 6)),
    "corner off centre": (hexagon(), rotated(hexagon(), np.pi / 6) + np.array([0, 2.2, 0])),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_grains_of_other_shapes_have_the_restitution_asked_for(shape, simulation):
    speed = SPEEDS[1]
    for asked in (1.0, 0.9, 0.5):
        one = facing(*SHAPES[shape], speed, 0.0, dimension=2)
        sim = collided(simulation, one, asked, speed)
        got = restitution_of(one, sim.atoms("x"), sim.atoms("v"))
        assert got == pytest.approx(asked, abs=ALLOWED), asked


def test_slender_bars_keep_more_as_vibration(simulation):
    """The end of one hits the middle of the other, which bends: 0.51 without loss in the law."""
    got = []
    for asked in (1.0, 0.9, 0.5):
        one = facing(lattice((16, 4)), lattice((4, 16)), SPEEDS[1], 0.0, dimension=2)
        sim = collided(simulation, one, asked, SPEEDS[1])
        got.append(restitution_of(one, sim.atoms("x"), sim.atoms("v")))
        assert got[-1] < asked + ALLOWED
    assert got[0] > got[1] > got[2] > 0.2


@pytest.mark.parametrize(("tilt", "angle"), [(0.0, 0.0), (0.0, 0.2), (0.3, 0.0), (0.3, 0.2)])
def test_balls_part_as_rigid_ones_do(tilt, angle, simulation):
    points = lattice((7, 7, 7))
    ball = points[np.linalg.norm(points, axis=1) < 3.2]
    speed = 0.01
    one = facing(ball, rotated(ball, tilt, (0, 1, 1)), speed, angle)
    for asked in (0.7, 0.5):
        sim = collided(simulation, one, asked, speed, solid=SOLID_3D)
        got = restitution_of(one, sim.atoms("x"), sim.atoms("v"))
        assert got == pytest.approx(rigid(simulation, one, asked, speed, SOLID_3D), abs=ALLOWED)
        if tilt == 0.0:  # one node on one node
            assert got == pytest.approx(asked, abs=ALLOWED)


def cut(simulation, one: Cloud, restitution: float, speed: float, words: str):
    """After the collision of grains some bonds of which are gone from the start."""
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(SOLID)}
        pair_coeff * * peridem/contact radius {REACH} restitution {restitution}
        fix glue all peridem/bonds {words}
        fix motion all nve
        timestep {number(DT)}
        run {round((0.6 / speed + 30.0) / DT)} post no
        """
    )
    return sim


@pytest.mark.parametrize("depth", [1.5, 5.5])
def test_a_cracked_disc_that_holds_together_is_one_body(depth, simulation):
    """A crack from the far rim towards the contact, half through the disc at most."""
    speed = SPEEDS[1]
    for asked in (0.9, 0.5):
        one = discs(speed, 0.0, PHASES["tip to tip"])
        far = one.x[one.molecule == 2, 0].max() + 0.5
        sim = cut(simulation, one, asked, speed, f"cut segment {far} 0.1 {far - depth} 0.1")
        got = restitution_of(one, sim.atoms("x"), sim.atoms("v"))
        # a crack as deep as the radius lets the disc bend: some more stays as vibration
        assert got == pytest.approx(asked, abs=ALLOWED), (asked, depth)


def test_pieces_of_one_grain_have_the_restitution_asked_for(simulation):
    """Two discs of one molecule-ID, cut apart: two bodies."""
    speed = SPEEDS[1]
    for asked in (0.9, 0.5):
        one = discs(speed, 0.0, PHASES["tip to tip"])
        both = one.molecule.copy()
        between = 0.5 * (one.x[both == 1, 0].max() + one.x[both == 2, 0].min())
        one.molecule[:] = 1
        sim = cut(simulation, one, asked, speed, f"cut plane {between} 0 0 1 0 0")
        one.molecule[:] = both
        got = restitution_of(one, sim.atoms("x"), sim.atoms("v"))
        assert got == pytest.approx(asked, abs=ALLOWED), asked


def meshed_disc() -> Cloud:
    """Nodes of a gmsh mesh about as fine as the rings, with their own volumes."""
    from peridem import cloud as clouds
    from peridem import shapes

    mesh = clouds.mesh(shapes.circle(RADIUS), 1.08)
    x = np.zeros((len(mesh.volumes), 3))
    x[:, :2] = np.asarray(mesh.nodes)[:, :2]
    return cloud(x, volume=mesh.volumes, dimension=2)


def test_discs_of_a_mesh_have_the_restitution_asked_for(simulation):
    """Of unlike nodes, each with its own volume, and a horizon of three and a half spacings."""
    disc_of_mesh = meshed_disc()
    volume = np.tile(disc_of_mesh.volume, 2)
    assert 100 < disc_of_mesh.n < 150
    speed = SPEEDS[1]
    for asked in (1.0, 0.9, 0.7, 0.5):
        one = facing(disc_of_mesh.x, disc_of_mesh.x * (-1, 1, 1), speed, 0.0, dimension=2)
        one.volume[:] = volume
        sim = collided(simulation, one, asked, speed)
        got = restitution_of(one, sim.atoms("x"), sim.atoms("v"))
        assert got == pytest.approx(asked, abs=ALLOWED), asked


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
    assert np.linalg.norm(turned) > 0.3 * speed  # they did collide
    # the drift of the integrator, and real loss where it was asked for
    assert after < before * (1.0 + 1e-3)
    assert (after < 0.9 * before) == (restitution < 1.0)
