"""Sums over square and cubic lattices in plain numpy: moduli and frequencies that a lattice "
"has."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from support.oracle import SLACK, Array, Solid


@dataclass(frozen=True)
class Family:
    """The family of one node of a lattice of unit spacing: bond vectors, lengths and weights w v.

    ``above``: layers of nodes on the side +y of the node (None: an endless lattice).
    """

    bond: Array  # (p, d)
    length: Array  # (p,)
    weight: Array  # (p,) influence times partial volume

    @property
    def m(self) -> float:
        return float(np.sum(self.weight * self.length**2))

    @property
    def unit(self) -> Array:
        return self.bond / self.length[:, None]


def family(solid: Solid, above: int | None = None) -> Family:
    d, reach = solid.dimension, int(np.ceil(solid.horizon))
    steps = np.arange(-reach, reach + 1)
    bond = np.stack(np.meshgrid(*[steps] * d, indexing="ij"), axis=-1).reshape(-1, d).astype(float)
    length = np.linalg.norm(bond, axis=1)
    keep = (length > 0) & (length <= solid.horizon * (1 + SLACK))
    if above is not None:
        keep &= bond[:, 1] <= above
    bond, length = bond[keep], length[keep]
    part = np.ones(len(length))
    if solid.taper:
        part = np.minimum(1.0, solid.horizon + 0.5 - length)
    return Family(bond, length, solid.weight(length) * part)


def dilatation(solid: Solid, strain: Array, of: Family) -> float:
    e = of.length * np.einsum("pa,ab,pb->p", of.unit, strain, of.unit)
    return float(solid.d / of.m * np.sum(of.weight * of.length * e))


def energy(solid: Solid, strain: Array, of: Family) -> float:
    """Energy density of a small uniform strain."""
    d, g = solid.d, solid.shear
    e = of.length * np.einsum("pa,ab,pb->p", of.unit, strain, of.unit)
    theta = dilatation(solid, strain, of)
    squares = np.sum(of.weight * e**2)
    return float(0.5 * (solid.lame - g) * theta**2 + 0.5 * d * (d + 2) * g / of.m * squares)


def classical_energy(solid: Solid, strain: Array) -> float:
    return float(0.5 * solid.lame * np.trace(strain) ** 2 + solid.shear * np.sum(strain**2))


def unit_strains(d: int) -> dict[str, Array]:
    """Uniaxial along x, biaxial in x and y, and pure shear in x and y."""
    tables = {name: np.zeros((d, d)) for name in ("uniaxial", "biaxial", "shear")}
    tables["uniaxial"][0, 0] = 1.0
    tables["biaxial"][0, 0] = tables["biaxial"][1, 1] = 1.0
    tables["shear"][0, 1] = tables["shear"][1, 0] = 0.5
    return tables


def moduli(energies: dict[str, float]) -> Array:
    """(C11, C12, C44) from the energies of ``unit_strains``."""
    c11 = 2 * energies["uniaxial"]
    return np.array([c11, energies["biaxial"] - c11, 2 * energies["shear"]])


def lattice_moduli(solid: Solid) -> Array:
    """(C11, C12, C44) of the endless lattice."""
    of = family(solid)
    return moduli({k: energy(solid, e, of) for k, e in unit_strains(solid.dimension).items()})


def classical_moduli(solid: Solid) -> Array:
    """(C11, C12, C44) of the classical solid."""
    g = solid.shear
    return np.array([solid.lame + 2 * g, solid.lame, g])


def frequency(solid: Solid, wave: Array, along: int, density: float = 1.0) -> float:
    """Angular frequency of a plane wave exp(i wave . X) polarised along an axis of the lattice.

    The linearised force on node i: sum of w v [d (lambda'-G) R (theta_i + theta_j) / m
    + 2 d (d+2) G n . (u_j - u_i) / m] n.  Exact for wave vectors along an axis, where the
    polarisations decouple by symmetry.
    """
    of, d, g = family(solid), solid.d, solid.shear
    phase = of.bond @ wave
    stretch = of.unit[:, along]
    # theta(k) = (d/m) sum w R n_a (exp(i k.xi) - 1), odd in xi: purely imaginary
    theta = 1j * d / of.m * np.sum(of.weight * of.length * stretch * np.sin(phase))
    both = theta * (1 + np.exp(1j * phase))  # theta_i + theta_j
    pull = d * (solid.lame - g) / of.m * of.length * both
    pull = pull + 2 * d * (d + 2) * g / of.m * stretch * (np.exp(1j * phase) - 1)
    force = np.sum(of.weight * pull * stretch)
    return float(np.sqrt(-force.real / density))
