"""The numpy model itself: it must be right before anything is compared with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support import oracle
from support.clouds import deformed, ragged, rotated
from support.oracle import Solid, bond_state, critical_stretch, families

SOLIDS = {
    "3D": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=3),
    "plane strain": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, plane="strain"),
    "plane stress": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, plane="stress"),
    "jha": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, plane="jha"),
}


def ragged_family(solid, rng):
    shape = (4, 4, 3) if solid.dimension == 3 else (6, 6)
    one = ragged(rng, shape)
    return one, families(one.reference, one.volume, one.molecule, solid)


@pytest.mark.parametrize("name", SOLIDS)
def test_force_is_minus_the_derivative_of_the_energy(name, rng):
    solid = SOLIDS[name]
    one, bonds = ragged_family(solid, rng)
    x = deformed(rng, one, 0.05, solid.dimension)
    force = bond_state(bonds, x).force
    step = 1e-6
    for node in (0, one.n // 2, one.n - 1):
        for axis in range(solid.dimension):
            push = np.zeros_like(x)
            push[node, axis] = step
            up, down = (bond_state(bonds, x + sign * push).energy.sum() for sign in (1, -1))
            # central difference: O(step^2) truncation and eps*E/step rounding, both below 1e-8
            assert -(up - down) / (2 * step) == pytest.approx(force[node, axis], abs=1e-7)


@pytest.mark.parametrize("name", ["3D", "plane strain", "plane stress"])
def test_isotropic_strain_has_the_exact_dilatation_and_elastic_energy(name, rng):
    """theta = d eps at every node, whatever the cloud; W = d^2 kappa' eps^2 / 2, no shear part."""
    solid = SOLIDS[name]
    one, bonds = ragged_family(solid, rng)
    eps, d = 1e-3, solid.dimension
    state = bond_state(bonds, one.reference * (1 + eps))
    kappa = solid.lame + 2 * solid.shear / d
    np.testing.assert_allclose(state.theta, d * eps, rtol=1e-10)  # rounding of e against R
    np.testing.assert_allclose(state.energy / one.volume, 0.5 * kappa * (d * eps) ** 2, rtol=1e-10)


@pytest.mark.parametrize("name", SOLIDS)
def test_rigid_motion_leaves_no_force(name, rng):
    solid = SOLIDS[name]
    one, bonds = ragged_family(solid, rng)
    state = bond_state(bonds, rotated(one.reference, 0.7) + np.array([0.3, -0.2, 0.0]))
    assert np.abs(state.force).max() < 1e-13 * solid.bulk  # rounding of lengths of order one


def test_moduli_of_a_three_dimensional_solid_are_recovered_by_a_fine_lattice():
    """Uniaxial strain energy of an interior node against (K + 4G/3) eps^2 / 2.

    Horizon 3.015 spacings, w = 1 - R/horizon, tapered volumes: the lattice sum is 1.003 of the
    exact modulus, a discretisation error, so 1 % is asked for.
    """
    from support.clouds import lattice

    x = lattice((7, 7, 7))
    solid = Solid(bulk=5.0 / 3.0, shear=1.0, horizon=3.015)
    bonds = families(x, np.ones(len(x)), np.ones(len(x), int), solid)
    eps = 1e-4
    stretched = x * np.array([1 + eps, 1, 1])
    centre = int(np.argmin(np.linalg.norm(x, axis=1)))
    energy = bond_state(bonds, stretched).energy[centre]
    exact = 0.5 * (solid.bulk + 4 * solid.shear / 3) * eps**2
    assert energy == pytest.approx(exact, rel=0.01)


def test_critical_stretch_reduces_to_the_known_closed_forms():
    k, gc, delta = 7.0, 0.3, 0.9
    solid = Solid(bulk=k, shear=0.6 * k, horizon=delta)  # nu = 1/4
    constant = critical_stretch(replace(solid, influence="constant"), gc)
    inverse = critical_stretch(replace(solid, influence="inverse"), gc)
    young = 9 * k * solid.shear / (3 * k + solid.shear)
    flat = critical_stretch(replace(solid, influence="inverse", dimension=2), gc)
    # quadrature is exact for these polynomials, so only rounding is left
    assert constant == pytest.approx(np.sqrt(8 * gc / (15 * k * delta)), rel=1e-12)
    assert inverse == pytest.approx(np.sqrt(5 * gc / (9 * k * delta)), rel=1e-12)
    assert flat == pytest.approx(np.sqrt(5 * np.pi * gc / (12 * young * delta)), rel=1e-12)


def test_any_two_moduli_give_the_same_pair():
    k, g = 2.7, 1.1
    young, nu = 9 * k * g / (3 * k + g), (3 * k - 2 * g) / (6 * k + 2 * g)
    values = {"bulk": k, "shear": g, "young": young, "poisson": nu}
    names = sorted(values)
    for a in range(4):
        for b in range(a + 1, 4):
            given = {name: values[name] for name in (names[a], names[b])}
            # rounding of formulas of few terms, some with differences
            assert oracle.bulk_shear(**given) == pytest.approx((k, g), rel=1e-13)
    with pytest.raises(ValueError, match="two moduli"):
        oracle.bulk_shear(bulk=1.0)


def test_contact_never_pulls_and_friction_opposes_sliding():
    law = oracle.Contact(radius=1.0, stiffness=5.0, damping=100.0, friction=0.4, tangential=2.0)
    x = np.array([[0.0, 0, 0], [0.9, 0, 0]])
    apart = np.array([[0.0, 0, 0], [3.0, 0.7, 0]])
    pair = (np.array([0]), np.array([1]), np.array([1.0]))
    leaving = oracle.contact_state(law, *pair, x, apart, np.ones(2))
    assert np.all(leaving.force == 0.0)
    closing = oracle.contact_state(law, *pair, x, -apart, np.ones(2))
    assert closing.force[1, 0] > 0 > closing.force[0, 0]
    assert np.einsum("na,na->", closing.friction, (apart[1:] - apart[:1])) < 0
