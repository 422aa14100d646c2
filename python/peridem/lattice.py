"""Clouds whose nodes are the sites of a lattice within a shape."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, cKDTree

from peridem.outline import Outline
from peridem.solid import Solid

Array = NDArray[np.float64]
Cells = NDArray[np.int64]

# Unit cell (over the spacing of nearest neighbours), sites in it (over its sides), and how many
# nearest neighbours a site has
_KINDS: dict[str, tuple[tuple[float, ...], tuple[tuple[float, ...], ...], int]] = {
    "square": ((1.0, 1.0), ((0.5, 0.5),), 4),
    "hexagonal": ((1.0, math.sqrt(3.0)), ((0.25, 0.25), (0.75, 0.75)), 6),
    "cubic": ((1.0, 1.0, 1.0), ((0.5, 0.5, 0.5),), 6),
    "fcc": (
        (math.sqrt(2.0),) * 3,
        ((0.25, 0.25, 0.25), (0.75, 0.75, 0.25), (0.75, 0.25, 0.75), (0.25, 0.75, 0.75)),
        12,
    ),
}
KINDS = tuple(_KINDS)


def sites(shape: Outline | Solid, spacing: float, kind: str) -> tuple[Array, NDArray[np.bool_]]:
    """The sites of a lattice inside a shape, (n, d), and which of them lack a neighbour.

    The lattice lies symmetrically in the box around the shape, so that a rectangle or cuboid with
    sides of whole numbers of spacings is filled without a gap.

    Raises:
        ValueError: a lattice of another dimension, a spacing that is not positive, or no site
            inside.
    """
    d = shape.dimension
    allowed = [name for name, (cell, _, _) in _KINDS.items() if len(cell) == d]
    if kind not in allowed:
        raise ValueError(f"lattice in {d}D: one of {', '.join(allowed)} needed, not '{kind}'")
    if not (math.isfinite(spacing) and spacing > 0.0):
        raise ValueError(f"lattice: spacing must be finite and above 0, not {spacing}")
    low, high = shape.extent
    cell, basis, neighbours = _KINDS[kind]
    side = spacing * np.array(cell)
    count = np.maximum(1, np.round((high - low) / side)).astype(int)
    start = 0.5 * (low + high) - 0.5 * count * side
    # one more cell on each side: a shape may reach beyond the whole number of cells
    ranges = [range(-1, n + 1) for n in count]
    corners = np.array(list(product(*ranges)), dtype=float)
    points = np.vstack([start + (corners + np.array(b)) * side for b in basis])
    points = points[np.lexsort(points.T)]
    points = points[shape.contains(points)]
    if len(points) < d + 1:
        raise ValueError(
            f"lattice: {len(points)} sites {spacing:g} apart lie in '{shape.name}'; a smaller "
            "spacing needed"
        )
    tree = cKDTree(points)
    near = tree.query_ball_point(points, 1.01 * spacing, return_length=True) - 1
    return points, np.asarray(near < neighbours)


def cells_between(points: Array, spacing: float, shape: Outline | Solid) -> Cells:
    """Triangles or tetrahedra between neighbouring sites, for drawing, (m, d + 1)."""
    d = points.shape[1]
    # sites on one circle or sphere have many Delaunay meshes: a little disorder chooses one
    moved = points + 1e-3 * spacing * np.random.default_rng(1).uniform(-1.0, 1.0, points.shape)
    cells = Delaunay(moved).simplices.astype(np.int64)
    corners = points[cells]
    edges = corners[:, :, None] - corners[:, None]
    longest = np.sqrt((edges**2).sum(axis=3).max(axis=(1, 2)))
    size = np.linalg.det(corners[:, 1:] - corners[:, :1]) / math.factorial(d)
    cells[size < 0.0, :2] = cells[size < 0.0, 1::-1]
    keep = (np.abs(size) > 0.01 * spacing**d) & (longest < 1.8 * spacing)
    keep &= shape.contains(corners.mean(axis=1))
    return np.asarray(cells[keep])
