"""gmsh meshes of shapes that ``peridem.cloud.mesh`` does not draw: with a hole, and in 3D."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from support.oracle import Array


def meshed(dimension: int, h: float, build: Callable[[Any], object]) -> tuple[Array, Array]:
    """Nodes and lumped volumes of what ``build(gmsh.model.occ)`` makes, nodes about ``h`` "
    "apart."""
    import gmsh
    from peridem.cloud import from_cells

    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        for option, value in (
            ("General.Verbosity", 1),
            ("General.NumThreads", 1),
            ("Mesh.RandomSeed", 1),
            ("Mesh.Algorithm", 6),
            ("Mesh.Smoothing", 20),
            ("Mesh.MeshSizeMin", h),
            ("Mesh.MeshSizeMax", h),
        ):
            gmsh.option.setNumber(option, value)
        build(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(dimension)
        tags, points, _ = gmsh.model.mesh.getNodes()
        kind = {2: 2, 3: 4}[dimension]  # gmsh's numbers of triangles and tetrahedra
        _, corners = gmsh.model.mesh.getElementsByType(kind)
    finally:
        gmsh.finalize()
    order = np.argsort(tags)
    cells = np.searchsorted(tags[order], np.asarray(corners))
    used, cells = np.unique(cells, return_inverse=True)
    nodes = np.asarray(points).reshape(-1, 3)[order][used, :dimension]
    made = from_cells(nodes, cells.reshape(-1, dimension + 1), "shape")
    return np.asarray(made.nodes), np.asarray(made.volumes)


def ball(radius: float, h: float) -> tuple[Array, Array]:
    """A sphere about the origin."""
    return meshed(3, h, lambda occ: occ.addSphere(0, 0, 0, radius))


def cube(side: float, h: float) -> tuple[Array, Array]:
    """A cube about the origin."""
    return meshed(3, h, lambda occ: occ.addBox(*(3 * [-0.5 * side]), *(3 * [side])))


def plate_with_hole(half: float, h: float) -> tuple[Array, Array]:
    """A square from -half to half with a hole of radius 1 in its middle."""

    def build(occ: Any) -> None:
        plate = occ.addRectangle(-half, -half, 0, 2 * half, 2 * half)
        occ.cut([(2, plate)], [(2, occ.addDisk(0, 0, 0, 1, 1))])

    return meshed(2, h, build)
