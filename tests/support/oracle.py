"""The model in plain numpy: what the C++ styles are checked against.

Written from the equations alone, one pair list and no tricks, so that it can be read as the
specification.  Arrays: positions ``(n, 3)``, per-node values ``(n,)``, pairs ``(p,)``.  In 2D the
third coordinate is ignored by the caller setting it to zero everywhere.  Units are the caller's.

Pairs are listed once, ``i < j``; ``n_ij`` points from i to j.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SLACK = 1.0e-9  # relative slack of "R <= horizon", part of the definition of a family


# --- material ------------------------------------------------------------------------------------


def bulk_shear(**moduli: float) -> tuple[float, float]:
    """(K, G) of three-dimensional isotropic elasticity from any two of young, bulk, shear, poisson.

    Raises ValueError when the number of moduli given is not two.
    """
    given = frozenset(moduli)
    e, k, g, nu = (moduli.get(name, np.nan) for name in ("young", "bulk", "shear", "poisson"))
    if given == {"bulk", "shear"}:
        return k, g
    if given == {"young", "poisson"}:
        return e / (3 * (1 - 2 * nu)), e / (2 * (1 + nu))
    if given == {"young", "bulk"}:
        return k, 3 * k * e / (9 * k - e)
    if given == {"young", "shear"}:
        return e * g / (3 * (3 * g - e)), g
    if given == {"bulk", "poisson"}:
        return k, 3 * k * (1 - 2 * nu) / (2 * (1 + nu))
    if given == {"shear", "poisson"}:
        return 2 * g * (1 + nu) / (3 * (1 - 2 * nu)), g
    raise ValueError(f"two moduli are needed, got {sorted(given)}")


@dataclass(frozen=True)
class Solid:
    """A linear peridynamic solid.  Stress units for ``bulk`` and ``shear``, length for ``horizon``.

    ``plane`` (strain, stress, jha) matters in 2D only; jha keeps the constants of 3D.
    ``taper_length``: cell size of the volume taper; None means the mean of the two V^(1/d).
    """

    bulk: float
    shear: float
    horizon: float
    dimension: int = 3
    plane: str = "strain"
    influence: str = "linear"
    gaussian_b: float = 1.0
    taper: bool = True
    taper_length: float | None = None
    s0: float = np.inf
    break_both: bool = False
    viscosity: float = 0.0

    @property
    def d(self) -> int:
        """Dimension in the constants: 3 in 3D and for ``jha``, else 2."""
        return 3 if self.dimension == 3 or self.plane == "jha" else 2

    @property
    def lame(self) -> float:
        """lambda' of the model."""
        lam = self.bulk - 2.0 * self.shear / 3.0
        if self.dimension == 2 and self.plane == "stress":
            return 2.0 * lam * self.shear / (lam + 2.0 * self.shear)
        return lam

    def weight(self, length: Array, horizon: Array | float | None = None) -> Array:
        """Influence w(R / horizon), dimensionless, shape of ``length``."""
        delta = self.horizon if horizon is None else horizon
        ratio = np.asarray(length) / delta
        if self.influence == "linear":
            return 1.0 - ratio
        if self.influence == "constant":
            return np.ones_like(ratio)
        if self.influence == "inverse":
            return 1.0 / ratio
        if self.influence == "gaussian":
            return np.exp(-(ratio**2) / self.gaussian_b)
        raise ValueError(f"unknown influence {self.influence!r}")


def integrate(function, upper: float, order: int = 60) -> float:
    """Gauss-Legendre integral of a smooth function from 0 to ``upper``."""
    points, weights = np.polynomial.legendre.leggauss(order)
    radius = 0.5 * upper * (points + 1.0)
    return float(0.5 * upper * np.sum(weights * function(radius)))


def critical_stretch(solid: Solid, gc: float) -> float:
    """s0 from the energy release rate ``gc`` (energy per area), for any influence and dimension.

    The energy of isotropic extension spent in opening a plane equals gc:
    s0^2 = gc m / (d^2 kappa I), kappa = lambda' + 2 G / d.  ``jha`` takes the published 3D formula.
    """
    if solid.dimension == 2 and solid.plane == "jha":
        stiffness = 3 * solid.shear + 0.75**4 * (solid.bulk - 5 * solid.shear / 3)
        return float(np.sqrt(gc / (stiffness * solid.horizon)))
    d, delta = solid.dimension, solid.horizon
    kappa = solid.lame + 2.0 * solid.shear / d
    if d == 3:
        m = 4 * np.pi * integrate(lambda r: solid.weight(r) * r**4, delta)
        crossing = np.pi * integrate(lambda r: solid.weight(r) * r**5, delta)
    else:
        m = 2 * np.pi * integrate(lambda r: solid.weight(r) * r**3, delta)
        crossing = 2 * integrate(lambda r: solid.weight(r) * r**4, delta)
    return float(np.sqrt(gc * m / (d**2 * kappa * crossing)))


# --- bonds ---------------------------------------------------------------------------------------


@dataclass
class Bonds:
    """Families of a cloud of nodes: one entry per bond, and what never changes about it."""

    i: Ints
    j: Ints
    length: Array  # R
    weight: Array  # w(R / horizon)
    part: Array  # v, the part of a cell inside the horizon
    s0: Array
    volume: Array  # per node
    m: Array  # per node, weighted volume in the reference state
    d: Array  # per node
    lame: Array  # per node
    shear: Array  # per node
    viscosity: Array  # per node
    break_both: NDArray[np.bool_]
    intact: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))

    @property
    def count(self) -> int:
        return len(self.i)


def partial_volume(solid: Solid, length: Array, delta: Array, cell: Array) -> Array:
    """The part of a cell that lies within the horizon: 1 inside, linear over its size."""
    if not solid.taper:
        return np.ones_like(length)
    h = cell if solid.taper_length is None else solid.taper_length
    return np.where(length <= delta - 0.5 * h, 1.0, (delta + 0.5 * h - length) / h)


def families(
    reference: Array,
    volume: Array,
    molecule: Ints,
    solids: Solid | dict[int, Solid],
    types: Ints | None = None,
    dimension: int | None = None,
) -> Bonds:
    """Bonds between nodes of one molecule whose reference distance is within the horizon.

    ``solids`` maps an atom type to its solid; unlike types take the mean horizon and smaller s0,
    and each node answers with its own moduli.  Molecule 0 has no bonds between its nodes.
    """
    n = len(volume)
    types = np.ones(n, int) if types is None else types
    if isinstance(solids, Solid):
        solids = {int(t): solids for t in np.unique(types)}
    first = next(iter(solids.values()))
    dimension = first.dimension if dimension is None else dimension
    i, j = np.triu_indices(n, 1)
    same = (molecule[i] == molecule[j]) & (molecule[i] > 0)
    i, j = i[same], j[same]
    length = np.linalg.norm(reference[j] - reference[i], axis=1)
    horizon = np.array([solids[int(t)].horizon for t in types])
    delta = 0.5 * (horizon[i] + horizon[j])
    near = length <= delta * (1.0 + SLACK)
    i, j, length, delta = i[near], j[near], length[near], delta[near]

    weight = first.weight(length, delta)
    cell = volume ** (1.0 / dimension)
    part = partial_volume(first, length, delta, 0.5 * (cell[i] + cell[j]))
    node = {
        name: np.array([getattr(solids[int(t)], name) for t in types], dtype=float)
        for name in ("d", "lame", "shear", "s0", "viscosity")
    }
    m = np.zeros(n)
    np.add.at(m, i, weight * length**2 * part * volume[j])
    np.add.at(m, j, weight * length**2 * part * volume[i])
    return Bonds(
        i=i,
        j=j,
        length=length,
        weight=weight,
        part=part,
        s0=np.minimum(node["s0"][i], node["s0"][j]),
        volume=volume,
        m=m,
        d=node["d"],
        lame=node["lame"],
        shear=node["shear"],
        viscosity=node["viscosity"],
        break_both=np.full(len(i), first.break_both),
        intact=np.ones(len(i), bool),
    )


@dataclass
class BondState:
    """What a set of bonds does at given positions."""

    theta: Array  # dilatation per node
    force: Array  # (n, 3)
    energy: Array  # energy per node (density times volume)
    virial: Array  # (n, 6) xx yy zz xy xz yz, half of each bond to each of its nodes
    stretch: Array  # per bond


def scatter(n: int, i: Ints, j: Ints, on_i: Array) -> Array:
    """Sum of pair forces: ``on_i`` on node i, its opposite on node j."""
    total = np.zeros((n, 3))
    np.add.at(total, i, on_i)
    np.subtract.at(total, j, on_i)
    return total


def pair_virial(n: int, i: Ints, j: Ints, between: Array, on_i: Array) -> Array:
    """Per-node virial of pair forces; ``between`` is x_j - x_i and ``on_i`` the force on i."""
    minus = -between  # x_i - x_j
    terms = np.stack(
        [minus[:, a] * on_i[:, b] for a, b in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))],
        axis=1,
    )
    virial = np.zeros((n, 6))
    np.add.at(virial, i, 0.5 * terms)
    np.add.at(virial, j, 0.5 * terms)
    return virial


def break_bonds(bonds: Bonds, x: Array) -> int:
    """Break, for ever, every intact bond stretched beyond s0; the number broken now."""
    stretch = np.linalg.norm(x[bonds.j] - x[bonds.i], axis=1) / bonds.length - 1.0
    measure = np.where(bonds.break_both, np.abs(stretch), stretch)
    now = bonds.intact & (measure > bonds.s0)
    bonds.intact = bonds.intact & ~now
    return int(now.sum())


def safe_inverse(value: Array) -> Array:
    """1/value, and 0 where value is 0 (a node without a family)."""
    return np.divide(1.0, value, out=np.zeros_like(value), where=value > 0)


def bond_state(bonds: Bonds, x: Array, v: Array | None = None) -> BondState:
    """Dilatation, force, energy and virial of the intact bonds at positions ``x``.

    With velocities, bonds of viscous nodes also resist the rate of their length as the deviatoric
    spring resists its change: t_i gains d (d+2) eta w (dr/dt) / m_i.
    """
    i, j, big_r = bonds.i, bonds.j, bonds.length
    n, volume, d, g = len(bonds.volume), bonds.volume, bonds.d, bonds.shear
    between = x[j] - x[i]
    r = np.linalg.norm(between, axis=1)
    e = r - big_r
    mu = bonds.intact.astype(float)
    over_m = safe_inverse(bonds.m)

    theta = np.zeros(n)
    moment = mu * bonds.weight * big_r * e * bonds.part
    np.add.at(theta, i, moment * volume[j])
    np.add.at(theta, j, moment * volume[i])
    theta *= d * over_m

    def state(node: Ints) -> Array:
        isotropic = d[node] * (bonds.lame[node] - g[node]) * theta[node] * big_r
        deviatoric = d[node] * (d[node] + 2) * g[node] * e
        return bonds.weight * (isotropic + deviatoric) * over_m[node]

    pull = state(i) + state(j)
    if v is not None:
        rate = np.einsum("pa,pa->p", v[j] - v[i], between) / r
        resistance = d * (d + 2) * bonds.viscosity * over_m
        pull += bonds.weight * (resistance[i] + resistance[j]) * rate
    pull *= mu * bonds.part * volume[i] * volume[j]
    on_i = (pull / r)[:, None] * between

    squares = np.zeros(n)
    term = mu * bonds.weight * e**2 * bonds.part
    np.add.at(squares, i, term * volume[j])
    np.add.at(squares, j, term * volume[i])
    density = 0.5 * (bonds.lame - g) * theta**2 + 0.5 * d * (d + 2) * g * over_m * squares
    return BondState(
        theta=theta,
        force=scatter(n, i, j, on_i),
        energy=density * volume,
        virial=pair_virial(n, i, j, between, on_i),
        stretch=e / big_r,
    )


def damage(bonds: Bonds) -> Array:
    """Broken fraction of each node's family by volume v V_j; 0 for a node without a family."""
    whole, broken = np.zeros(len(bonds.volume)), np.zeros(len(bonds.volume))
    gone = ~bonds.intact
    for a, b in ((bonds.i, bonds.j), (bonds.j, bonds.i)):
        np.add.at(whole, a, bonds.part * bonds.volume[b])
        np.add.at(broken, a, gone * bonds.part * bonds.volume[b])
    return broken * safe_inverse(whole)


def intact_bonds(bonds: Bonds) -> Ints:
    """Number of intact bonds of each node."""
    count = np.zeros(len(bonds.volume), dtype=np.int64)
    np.add.at(count, bonds.i, bonds.intact)
    np.add.at(count, bonds.j, bonds.intact)
    return count


# --- contact -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Contact:
    """Spring, dashpot and slider between two nodes, or a node and a surface.

    ``stiffness`` k_N (force per length and volume squared), ``damping`` beta (force per speed),
    ``friction`` mu, ``tangential`` gamma_t of the regularised slider (force per speed), ``onset``
    part of the radius over which the stiffness grows from nothing.
    """

    radius: float
    stiffness: float
    damping: float = 0.0
    friction: float = 0.0
    tangential: float = 0.0
    onset: float = 0.0


def contact_pairs(
    molecule: Ints, reference: Array, radius: float, bonds: Bonds | None, fragments: bool = True
) -> tuple[Ints, Ints, Array]:
    """Pairs that may touch and their contact distance d_c.

    Different grains: d_c = radius.  One grain, no intact bond: d_c = min(radius, R).  Nodes of
    molecule 0 are grains of their own.
    """
    n = len(molecule)
    i, j = np.triu_indices(n, 1)
    same = (molecule[i] == molecule[j]) & (molecule[i] > 0)
    bonded = np.zeros((n, n), bool)
    if bonds is not None:
        bonded[bonds.i[bonds.intact], bonds.j[bonds.intact]] = True
    keep = ~same | (fragments & ~bonded[i, j])
    i, j, same = i[keep], j[keep], same[keep]
    length = np.linalg.norm(reference[j] - reference[i], axis=1)
    return i, j, np.where(same, np.minimum(radius, length), radius)


@dataclass
class ContactState:
    """Contact forces at given positions and velocities."""

    force: Array  # (n, 3)
    energy: Array  # elastic energy per pair
    normal: Array  # f_N per pair, >= 0
    friction: Array  # (p, 3) force on i


def contact_state(
    law: Contact,
    i: Ints,
    j: Ints,
    reach: Array,
    x: Array,
    v: Array,
    volume: Array,
    damping: Array | float | None = None,
) -> ContactState:
    """Contact forces of the listed pairs.  ``damping`` replaces the law's, one value per pair."""
    between = x[j] - x[i]
    r = np.linalg.norm(between, axis=1)
    n_ij = between / r[:, None]
    gap = r - reach
    touching = gap < 0.0
    relative = v[j] - v[i]
    approach = np.einsum("pa,pa->p", relative, n_ij)  # rate of the gap
    beta = law.damping if damping is None else damping
    k, depth = law.stiffness * volume[i] * volume[j], law.onset * law.radius
    soft = -gap < depth
    grown = gap**2 / (2.0 * depth) if depth else 0.0 * gap
    spring = k * np.where(soft, grown, -gap - 0.5 * depth)
    normal = np.where(touching, np.maximum(0.0, spring - beta * approach), 0.0)
    sliding = relative - approach[:, None] * n_ij  # of j as seen from i
    speed = np.linalg.norm(sliding, axis=1)
    size = np.minimum(law.friction * normal, law.tangential * speed)
    direction = sliding / np.where(speed > 0, speed, 1.0)[:, None]
    friction = size[:, None] * direction  # j drags i along
    on_i = -normal[:, None] * n_ij + friction
    beyond = 0.5 * (-gap - 0.5 * depth) ** 2 + depth**2 / 24.0
    energy = np.where(touching, k * np.where(soft, -gap * grown / 3.0, beyond), 0.0)
    return ContactState(scatter(len(volume), i, j, on_i), energy, normal, friction)


# --- conserved sums ------------------------------------------------------------------------------


def total_torque(x: Array, force: Array, about: Array | None = None) -> Array:
    """Sum of moments of ``force`` about a point (default the mean position)."""
    centre = x.mean(axis=0) if about is None else about
    return np.cross(x - centre, force).sum(axis=0)
