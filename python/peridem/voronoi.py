"""Volumes of the parts of a mesh that are nearer to one node than to any other.

Every cell is cut by the planes halfway between nodes, so the parts stay within the mesh, whatever
its shape, and fill it: their sum is the mesh's volume. Far from the boundary they are Voronoi
cells.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
Cells = NDArray[np.int64]

# How the part of a simplex on one side of a plane is made of simplices: for a number of corners on
# that side, rows of corners. (a, b) is where the plane cuts the edge from corner a, inside, to b.
_Corner = int | tuple[int, int]
_PARTS: dict[int, dict[int, list[tuple[_Corner, ...]]]] = {
    2: {
        1: [(0, (0, 1), (0, 2))],
        2: [(0, 1, (1, 2)), (0, (1, 2), (0, 2))],
    },
    3: {
        1: [(0, (0, 1), (0, 2), (0, 3))],
        2: [
            (0, (0, 2), (0, 3), (1, 3)),
            (0, (0, 2), (1, 2), (1, 3)),
            (0, 1, (1, 2), (1, 3)),
        ],
        3: [(0, 1, 2, (2, 3)), (0, 1, (1, 3), (2, 3)), (0, (0, 3), (1, 3), (2, 3))],
    },
}


def voronoi_volumes(nodes: Array, cells: Cells) -> Array:
    """Volume of the mesh that is nearest to each node, (n,).

    Args:
        nodes: (n, d), d = 2 or 3.
        cells: (m, d + 1) triangles or tetrahedra.
    """
    volumes = np.zeros(len(nodes))
    step = 1000  # cells at a time: some ten MB in 3D
    tree = cKDTree(nodes)
    for first in range(0, len(cells), step):
        _add(volumes, nodes, cells[first : first + step], tree)
    return volumes


def _add(volumes: Array, nodes: Array, cells: Cells, tree: cKDTree) -> None:
    table = _nodes_near(nodes, cells, tree)
    cell, owner, cuts = _what_cuts(nodes, cells, table)  # each piece is for one node of the table
    pieces = nodes[cells[cell]]
    for k in range(table.shape[1]):
        cut = cuts[:, k]
        if not cut.any():
            continue
        one, two = nodes[table[cell[cut], owner[cut]]], nodes[table[cell[cut], k]]
        kept, of = _clip(pieces[cut], 0.5 * (one + two), one - two)
        from_which = np.concatenate([np.flatnonzero(~cut), np.flatnonzero(cut)[of]])
        pieces = np.concatenate([pieces[~cut], kept])
        cell, owner, cuts = cell[from_which], owner[from_which], cuts[from_which]
    np.add.at(volumes, table[cell, owner], _sizes(pieces))


def _what_cuts(nodes: Array, cells: Cells, table: Cells) -> tuple[Cells, Cells, NDArray[np.bool_]]:
    """Parts: their cell, the column of the table that they are for, which other columns cut."""
    corners = nodes[cells]
    away = np.linalg.norm(corners[:, :, None] - nodes[table][:, None], axis=3)
    away[np.broadcast_to((table < 0)[:, None], away.shape)] = np.inf
    # a cell is on one side of the plane between two nodes if all of its corners are
    nearer = away[:, :, None, :] < away[:, :, :, None]  # (m, corner, i, k): k is nearer than i
    anywhere, everywhere = nearer.any(axis=1), nearer.all(axis=1)
    cell, owner = np.nonzero(~everywhere.any(axis=2) & (table >= 0))
    return cell, owner, anywhere[cell, owner]


def _nodes_near(nodes: Array, cells: Cells, tree: cKDTree) -> Cells:
    """The nodes that may be nearest to a point of each cell, the closest first; filled with -1."""
    d = nodes.shape[1]
    corners = nodes[cells]
    centre = corners.mean(axis=1)
    edges = corners[:, :, None] - corners[:, None]
    longest = np.sqrt((edges**2).sum(axis=3).max(axis=(1, 2)))
    # a corner is within the radius of the smallest ball around a cell (Jung) of each point
    radius = longest * math.sqrt(d / (2.0 * (d + 1.0)))
    radius += np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    found = tree.query_ball_point(centre, radius * (1.0 + 1e-9))
    table = np.full((len(cells), max(len(row) for row in found)), -1)
    for into, row, point in zip(table, found, centre, strict=True):
        away = np.linalg.norm(nodes[row] - point, axis=1)
        into[: len(row)] = np.asarray(row)[np.argsort(away, kind="stable")]
    return table


def _clip(pieces: Array, point: Array, normal: Array) -> tuple[Array, Cells]:
    """What lies on the normal's side of a plane, as simplices, and which piece each came from."""
    d = pieces.shape[2]
    height = ((pieces - point[:, None]) * normal[:, None]).sum(axis=2)
    order = np.argsort(-height, axis=1, kind="stable")
    height = np.take_along_axis(height, order, axis=1)
    pieces = np.take_along_axis(pieces, order[:, :, None], axis=1)
    inside = (height > 0.0).sum(axis=1)
    everything = np.flatnonzero(inside == d + 1)
    parts, of = [pieces[everything]], [everything]
    for count, simplices in _PARTS[d].items():
        rows = np.flatnonzero(inside == count)
        corners, h = pieces[rows], height[rows]
        for simplex in simplices:
            parts.append(np.stack([_corner(corners, h, c) for c in simplex], axis=1))
            of.append(rows)
    return np.concatenate(parts), np.concatenate(of)


def _corner(corners: Array, height: Array, which: _Corner) -> Array:
    if isinstance(which, int):
        return corners[:, which]
    a, b = which
    part = height[:, a] / (height[:, a] - height[:, b])
    return np.asarray(corners[:, a] + part[:, None] * (corners[:, b] - corners[:, a]))


def _sizes(pieces: Array) -> Array:
    d = pieces.shape[2]
    return np.asarray(
        np.abs(np.linalg.det(pieces[:, 1:] - pieces[:, :1])) / math.factorial(d), dtype=float
    )
