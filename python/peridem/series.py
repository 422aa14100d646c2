"""Contact springs for grains that stay rigid, as soft as grains that deform would be.

A rigid grain (``fix peridem/adapt`` with a very large *eta*, ``fix rigid/small``) gives way at its
contacts only, so a packing of rigid grains is stiffer than one of deformable grains.  Here a grain
is pressed between plates, by its nodes' springs: once as the linear peridynamic solid that it is
and once rigid.  The ratio of the two forces is the factor by which the springs of the rigid grain
have to be softer at a wall.  There half of the grain is in series with the spring, between two
grains two halves are: from the factor f at walls follows f / (2 - f) between grains.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from peridem.cloud import Cloud
from peridem.material import Material

Array = NDArray[np.float64]
MOST_NODES = 2500  # matrices are dense: 3 x 2500 squared is half a gigabyte
TRIES = 50  # to find which nodes touch the plates: a few are enough


@dataclass(frozen=True)
class Elastic:
    """A grain as a linear elastic solid.

    Attributes:
        cloud: its nodes.
        stretch: (bonds, d n) stretches of the bonds from displacements (x0, y0, x1, y1, ...).
        stiffness: (d n, d n) forces from displacements; rigid motion has none.
    """

    cloud: Cloud
    stretch: Array
    stiffness: Array


@dataclass(frozen=True)
class Factors:
    """By what springs of rigid grains are to be multiplied.

    Attributes:
        wall: at walls.
        pair: between two grains of the same kind.
    """

    wall: float
    pair: float


def elastic(cloud: Cloud, material: Material) -> Elastic:
    """The linear peridynamic solid of ``pair_style peridem/lps`` about its reference, as matrices.

    Raises:
        ValueError: more nodes than dense matrices are good for, or constants of ``plane jha``.
    """
    x, volume, d = cloud.nodes, cloud.volumes, cloud.dimension
    n = len(x)
    if n > MOST_NODES:
        raise ValueError(f"elastic grain: {n} nodes, at most {MOST_NODES} (matrices are dense)")
    if material.plane == "jha":
        raise ValueError("elastic grain: plane strain or stress, not jha")
    i, j = cKDTree(x).query_pairs(material.horizon, output_type="ndarray").T
    length = np.linalg.norm(x[j] - x[i], axis=1)
    normal = (x[j] - x[i]) / length[:, None]
    cell = 0.5 * (volume[i] ** (1 / d) + volume[j] ** (1 / d))
    weight = material.weight(length / material.horizon) * material.cut(length, cell)

    extension, row = np.zeros((len(i), d * n)), np.arange(len(i))
    for k in range(d):
        extension[row, d * j + k] = normal[:, k]
        extension[row, d * i + k] = -normal[:, k]
    family, dilatation, spring = np.zeros(n), np.zeros((n, d * n)), np.zeros(len(i))
    for a, b in ((i, j), (j, i)):
        np.add.at(family, a, weight * length**2 * volume[b])
    for a, b in ((i, j), (j, i)):
        share = d / family[a] * weight * length * volume[b]
        np.add.at(dilatation, a, share[:, None] * extension)
        spring += d * (d + 2) * material.shear / family[a] * weight * volume[a] * volume[b]
    pressure = (material.lame(d) - material.shear) * volume
    stiffness = dilatation.T @ (pressure[:, None] * dilatation)
    stiffness += extension.T @ (spring[:, None] * extension)
    return Elastic(cloud, np.asarray(extension / length[:, None]), stiffness)


def factors(
    shapes: Sequence[Cloud],
    material: Material,
    stiff: float = 10.0,
    strain: float = 3e-3,
    directions: int = 8,
) -> Factors:
    """Factors of grains of several shapes that are equally many.

    Compliances add up along a chain of grains, so the factors of shapes and directions have their
    harmonic mean.  Each grain is kept from turning while it is pressed.

    Args:
        shapes: their nodes; sizes count only as far as they differ in spacing over size.
        material: of the grains.
        stiff: the springs of deformable grains, as of :class:`peridem.material.Contact`.
        strain: approach of the plates over the size of the grain at which forces are compared.
        directions: in which each grain is pressed, in 2D over half a turn.

    Returns:
        The factors: ``Contact(stiff=stiff * pair)`` with walls of ``Contact(stiff=stiff * wall)``.

    Raises:
        ValueError: a value outside its range, or no set of nodes that touch was found.
    """
    if not (shapes and stiff > 0.0 and 0.0 < strain < 0.1 and directions >= 1):
        raise ValueError(
            "factors: shapes, stiff > 0, 0 < strain < 0.1 and directions >= 1 are needed, not "
            f"{len(shapes)} shapes, stiff {stiff}, strain {strain}, directions {directions}"
        )
    compliances = []
    for one in shapes:
        solid = elastic(one, material)
        spring = _spring(one, material, stiff)
        for n in _directions(one.dimension, directions):
            compliances.append(1.0 / _factor(solid, spring, n, strain))
    wall = 1.0 / float(np.mean(compliances))
    return Factors(wall, wall / (2.0 - wall))


def pressed_factor(
    cloud: Cloud,
    material: Material,
    direction: Sequence[float],
    stiff: float = 10.0,
    strain: float = 3e-3,
) -> float:
    """The factor of one grain between plates that press it along ``direction``, a unit vector."""
    solid = elastic(cloud, material)
    return _factor(solid, _spring(cloud, material, stiff), np.asarray(direction, float), strain)


def _spring(cloud: Cloud, material: Material, stiff: float) -> float:
    """Of two typical nodes, as ``form bulk`` has it."""
    d = cloud.dimension
    return float(stiff * material.bulk * np.median(cloud.volumes) ** (1 - 2 / d))


def _directions(dimension: int, count: int) -> Array:
    """Over half a turn; in 3D Fibonacci's spiral over half a sphere. (count, d)."""
    if dimension == 2:
        angle = np.pi * np.arange(count) / count
        return np.column_stack([np.cos(angle), np.sin(angle)])
    z = (np.arange(count) + 0.5) / count
    turn = np.pi * (1.0 + math.sqrt(5.0)) * np.arange(count)
    across = np.sqrt(1.0 - z * z)
    return np.column_stack([across * np.cos(turn), across * np.sin(turn), z])


def _factor(solid: Elastic, spring: float, n: Array, strain: float) -> float:
    """Force of the elastic grain over that of the rigid one, pressed along n."""
    along = solid.cloud.nodes @ n
    approach = strain * float(np.ptp(along))
    return _pressed(solid, spring, n, along, approach) / _rigid(spring, along, approach)


def _rigid(spring: float, along: Array, approach: float) -> float:
    """Force on a rigid grain that sits where both plates push alike, found by bisection."""
    low, high = along - along.min(), along.max() - along
    least, most = 0.0, approach
    for _ in range(60):
        middle = 0.5 * (least + most)
        below = np.clip(middle - low, 0.0, None).sum()
        above = np.clip(approach - middle - high, 0.0, None).sum()
        least, most = (middle, most) if below < above else (least, middle)
    return spring * float(np.clip(most - low, 0.0, None).sum())


def _pressed(solid: Elastic, spring: float, n: Array, along: Array, approach: float) -> float:
    """Force on the elastic grain: which nodes touch is found by trying.

    Rigid motion across n and turning are held: a frictionless plate does not resist them.
    """
    count = len(solid.cloud.nodes)
    low, high = along - along.min(), along.max() - along
    held = solid.stiffness + _holders(solid, n)
    towards = np.kron(np.eye(count), n)  # (n, d n): displacement along n
    touching = (low < 0.5 * approach).astype(int) - (high < 0.5 * approach).astype(int)
    for _ in range(TRIES):
        at = np.flatnonzero(touching)
        sign = touching[at].astype(float)
        gap = np.where(sign > 0, low[at], high[at])
        rows = sign[:, None] * towards[at]  # growth of the gap to the plate
        depth = 0.5 * approach - gap  # of the undeformed grain
        matrix = held + spring * rows.T @ rows
        u = np.linalg.solve(matrix, spring * rows.T @ depth)
        moved = towards @ u
        below = 0.5 * approach - low - moved
        above = 0.5 * approach - high + moved
        force = spring * float(np.clip(below, 0.0, None).sum())
        now = (below > 0).astype(int) - (above > 0).astype(int)
        if np.array_equal(now, touching):
            return force
        touching = now
    raise ValueError(
        f"cloud '{solid.cloud.name}': which nodes touch changes to and fro at an approach "
        f"of {approach:.3g}; a finer mesh or another approach"
    )


def _holders(solid: Elastic, n: Array) -> Array:
    """Stiffness for the rigid motions that plates do not hold: across n, and turning."""
    r = solid.cloud.nodes - solid.cloud.nodes.mean(axis=0)
    count, d = r.shape
    modes = [np.tile(e, count) for e in np.eye(d)]
    for a in range(d):
        for b in range(a):
            turning = np.zeros_like(r)
            turning[:, a], turning[:, b] = r[:, b], -r[:, a]
            modes.append(turning.ravel())
    whole = np.tile(n, count)
    modes[:d] = [mode - (mode @ whole) / count * whole for mode in modes[:d]]
    scale = float(np.trace(solid.stiffness)) / (count * d)
    held = np.zeros_like(solid.stiffness)
    for mode in modes:
        size = float(np.linalg.norm(mode))
        if size > 1e-9 * math.sqrt(count):
            held += scale * np.outer(mode, mode) / size**2
    return held
