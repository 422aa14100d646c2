"""Materials and the stable step, against closed forms and a direct evaluation of the model."""

import math

import numpy as np
import pytest
from peridem import cloud, shapes, timestep
from peridem.material import INFLUENCE, Contact, Material


def solid(**changes):
    words = {"bulk": 2.16e7, "poisson": 0.25, "density": 1200.0, "horizon": 0.6, "gc": 50.0}
    return Material(**(words | changes))


# Gauss's rule of 8 points is exact for these integrands; the rest is rounding.
ROUNDING = 1e-13


@pytest.mark.parametrize(
    ("material", "dimension", "expected"),
    [
        (solid(influence="constant"), 3, math.sqrt(8 * 50 / (15 * 2.16e7 * 0.6))),
        (solid(influence="inverse"), 3, math.sqrt(5 * 50 / (9 * 2.16e7 * 0.6))),
        # plane strain with nu = 1/4: E = 3 K (1 - 2 nu) = 1.5 K
        (
            solid(influence="inverse"),
            2,
            math.sqrt(5 * math.pi * 50 / (12 * 1.5 * 2.16e7 * 0.6)),
        ),
        (solid(gc=None, s0=0.02), 2, 0.02),
        (solid(gc=None), 2, math.inf),
    ],
)
def test_critical_stretch_is_the_closed_form(material, dimension, expected):
    assert material.critical_stretch(dimension) == pytest.approx(expected, rel=ROUNDING)


def test_moduli_and_wave_speed():
    material = solid()
    assert material.shear == pytest.approx(0.6 * 2.16e7, rel=ROUNDING)
    # K + 4G/3 = 1.8 K in plane strain and 3D, E/(1 - nu^2) = 1.6 K in plane stress
    assert material.wave_speed(2) == pytest.approx(math.sqrt(1.8 * 2.16e7 / 1200.0), rel=ROUNDING)
    stress = solid(plane="stress")
    assert stress.wave_speed(2) == pytest.approx(math.sqrt(1.6 * 2.16e7 / 1200.0), rel=ROUNDING)


def energy(grain, material, displacement):
    """Strain energy of a cloud for small displacements, bond by bond from the model's formulas."""
    x, volume, d = grain.nodes, grain.volumes, grain.dimension
    dc = 3 if material.plane == "jha" else d
    shear, lame = material.shear, material.lame(d)
    size = volume ** (1.0 / d)
    total = 0.0
    for i in range(len(x)):
        reference = x - x[i]
        length = np.linalg.norm(reference, axis=1)
        near = (length <= material.horizon) & (length > 0.0)
        reference, length = reference[near], length[near]
        extension = ((displacement[near] - displacement[i]) * reference).sum(axis=1) / length
        h = 0.5 * (size[i] + size[near])
        cut = np.minimum(1.0, (material.horizon + 0.5 * h - length) / h)
        weight = INFLUENCE[material.influence](length / material.horizon) * cut * volume[near]
        m = (weight * length**2).sum()
        theta = dc / m * (weight * length * extension).sum()
        density = 0.5 * (lame - shear) * theta**2
        density += dc * (dc + 2) * shear / (2.0 * m) * (weight * extension**2).sum()
        total += volume[i] * density
    return total


@pytest.mark.parametrize("plane", ["strain", "stress", "jha"])
@pytest.mark.parametrize("influence", ["linear", "constant", "inverse"])
def test_stiffness_holds_the_energy_of_the_model(plane, influence):
    grain = cloud.mesh(shapes.drum(1.0), 0.25)
    material = solid(influence=influence, plane=plane, poisson=0.2)
    matrix = timestep.stiffness(grain, material)
    u = np.random.default_rng(2).standard_normal(grain.nodes.shape)
    # two orders of summation over some 600 bonds
    assert 0.5 * u.ravel() @ (matrix @ u.ravel()) == pytest.approx(
        energy(grain, material, u), rel=1e-12
    )


def test_rigid_motion_and_turning_cost_nothing():
    grain = cloud.mesh(shapes.triangle(1.0), 0.2)
    matrix = timestep.stiffness(grain, solid())
    turn = np.column_stack([-grain.nodes[:, 1], grain.nodes[:, 0]])
    scale = abs(matrix).max()
    for motion in (np.tile((1.0, 0.0), (len(grain.nodes), 1)), turn):
        # a dozen rounded bonds cancel at each node
        assert np.abs(matrix @ motion.ravel()).max() < 1e-13 * scale * 30


def test_highest_frequency_of_two_nodes():
    # three corners of a triangle, horizon so small that only one pair of nodes could bond: refused
    corners = cloud.from_cells([(0.0, 0.0), (0.1, 0.0), (0.0, 5.0)], [(0, 1, 2)])
    with pytest.raises(ValueError, match=r"1 of 3 nodes have no other .* node 3"):
        timestep.stiffness(corners, solid(horizon=0.2))


def test_frequency_bounds_the_step_of_a_leapfrog():
    """Just below the limit an oscillation stays, just above it grows."""
    grain, material = cloud.mesh(shapes.hexagon(1.0), 0.25), solid(horizon=0.8)
    matrix = timestep.stiffness(grain, material)
    mass = (material.density * grain.volumes).repeat(2)
    limit = 2.0 / timestep.highest_frequency(grain, material)
    start = np.random.default_rng(1).standard_normal(len(mass))
    largest = {}
    for factor in (0.999, 1.01):
        u, v = start.copy(), np.zeros_like(start)
        for _ in range(2000):
            v -= factor * limit * (matrix @ u) / mass
            u += factor * limit * v
        largest[factor] = np.abs(u).max()
    # the bounded one may beat: its amplitude grows by 1/sqrt(1 - 0.999^2) = 22 at most
    assert largest[0.999] < 100.0 * np.abs(start).max()
    assert largest[1.01] > 1e6 * np.abs(start).max()


def test_stable_step_joins_bonds_and_contacts():
    step = timestep.StableStep(bonds=3.0, contacts=4.0)
    assert step.together == pytest.approx(2.4)
    grain = cloud.mesh(shapes.circle(1.0), 0.25)
    soft = timestep.stable_step([grain], [solid()], 1e-12)
    assert soft.together == pytest.approx(soft.bonds, rel=1e-9)
    viscous = timestep.stable_step([grain], [solid(viscosity=2e3)], 1e-12)
    assert viscous.bonds == soft.bonds
    # a viscosity of G T: the damping ratio of the fastest motion is omega T / 2
    z = 0.5 * (2.0 / soft.bonds) * 2e3 / solid().shear
    assert viscous.together == pytest.approx(soft.bonds * (math.hypot(1.0, z) - z), rel=1e-9)
    stiff = timestep.stable_step([grain], [solid()], 4e9)
    softer = timestep.stable_step([grain], [solid()], 1e9)
    assert softer.contacts == pytest.approx(2.0 * stiff.contacts)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: solid(poisson=0.5), r"poisson must lie in \(-1, 1/2\), not 0.5"),
        (lambda: solid(bulk=-1.0), "bulk"),
        (lambda: solid(horizon=0.0), "horizon"),
        (lambda: solid(density=float("nan")), "density"),
        (lambda: solid(s0=0.1), "not both"),
        (lambda: solid(gc=-1.0), "gc"),
        (lambda: solid(viscosity=-1.0), "viscosity"),
        (lambda: solid(influence="cubic"), "linear, constant, inverse"),
        (lambda: solid(plane="bent"), "strain, stress or jha"),
        (lambda: Contact(radius=0.0), "radius"),
        (lambda: Contact(stiff=0.0), "stiff"),
        (lambda: Contact(restitution=0.0), "restitution"),
        (lambda: Contact(friction=-0.1), "friction"),
    ],
)
def test_unphysical_values_are_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()
