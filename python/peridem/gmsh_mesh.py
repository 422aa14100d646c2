"""Triangles and tetrahedra from gmsh.

All lengths are divided by the size of the shape before gmsh sees them, since its tolerances are
absolute.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from peridem.outline import Outline
from peridem.solid import Cylinder, Ellipsoid, Polyhedron, Solid

Array = NDArray[np.float64]
Cells = NDArray[np.int64]


def fill_outline(outline: Outline, spacing: float) -> tuple[Array, Cells]:
    """Nodes, (n, 2), and triangles, (m, 3), inside an outline.

    The points of :meth:`Outline.rings` stay the only ones on the boundary.

    Raises:
        RuntimeError: gmsh cannot be loaded, or fails.
    """
    low, high = outline.extent
    size = float((high - low).min())
    rings = [ring / size for ring in outline.rings(spacing)]

    def build(gmsh: Any) -> None:
        geo = gmsh.model.geo
        loops = []
        for ring in rings:
            points = [geo.addPoint(x, y, 0.0) for x, y in ring]
            ends = zip(points, points[1:] + points[:1], strict=True)
            lines = [geo.addLine(a, b) for a, b in ends]
            loops.append(geo.addCurveLoop(lines))
            for line in lines:
                geo.mesh.setTransfiniteCurve(line, 2)  # no further node between two points
        geo.addPlaneSurface(loops)
        geo.synchronize()

    nodes, cells = _generate(outline.name, spacing / size, 2, build)
    return nodes[:, :2] * size, cells


def fill_solid(solid: Solid, spacing: float) -> tuple[Array, Cells]:
    """Nodes, (n, 3), and tetrahedra, (m, 4), inside a solid.

    Ellipsoids and cylinders have their nodes on the true surface. A polyhedron keeps its sides and
    corners, unless most of its sides are shorter than half a spacing, as in a scanned grain: its
    surface is then meshed anew at the spacing, keeping edges sharper than 40 degrees.

    Raises:
        RuntimeError: gmsh cannot be loaded, or fails.
    """
    form, size = solid.form, solid.scale * solid.form.reach
    h = spacing / size
    if isinstance(form, Ellipsoid):
        axes = tuple(a / form.reach for a in form.semi_axes)
        build = _ellipsoid(axes)
    elif isinstance(form, Cylinder):
        build = _cylinder(form.radius / form.reach, form.height / form.reach)
    elif isinstance(form, Polyhedron):
        vertices = form.vertices / form.reach
        facets = facet_loops(vertices, form.triangles)
        ends = [
            vertices[loop] - vertices[loop[1:] + loop[:1]] for loops in facets for loop in loops
        ]
        fine = np.median(np.linalg.norm(np.vstack(ends), axis=1)) < 0.5 * h
        build = _remeshed(vertices, form.triangles) if fine else _facets(vertices, facets)
    else:
        raise TypeError(f"no way to mesh a {type(form).__name__}")
    nodes, cells = _generate(solid.name, h, 3, build)
    return (nodes * size) @ solid.turn.T + solid.position, cells


def _ellipsoid(axes: tuple[float, ...]) -> Callable[[Any], None]:
    def build(gmsh: Any) -> None:
        occ = gmsh.model.occ
        ball = occ.addSphere(0.0, 0.0, 0.0, 1.0)
        occ.dilate([(3, ball)], 0.0, 0.0, 0.0, *axes)
        occ.synchronize()

    return build


def _cylinder(radius: float, height: float) -> Callable[[Any], None]:
    def build(gmsh: Any) -> None:
        occ = gmsh.model.occ
        occ.addCylinder(0.0, 0.0, -0.5 * height, 0.0, 0.0, height, radius)
        occ.synchronize()

    return build


def _facets(vertices: Array, facets: list[list[list[int]]]) -> Callable[[Any], None]:
    """The plane faces of a polyhedron, see :func:`facet_loops`."""

    def build(gmsh: Any) -> None:
        geo = gmsh.model.geo
        used = sorted({k for loops in facets for loop in loops for k in loop})
        points = {k: geo.addPoint(*vertices[k]) for k in used}
        lines: dict[tuple[int, int], int] = {}
        faces = []
        for loops in facets:
            curves = []
            for loop in loops:
                signed = []
                for a, b in zip(loop, loop[1:] + loop[:1], strict=True):
                    if (b, a) in lines:
                        signed.append(-lines[b, a])
                    else:
                        lines[a, b] = geo.addLine(points[a], points[b])
                        signed.append(lines[a, b])
                curves.append(geo.addCurveLoop(signed))
            faces.append(geo.addPlaneSurface(curves))
        geo.addVolume([geo.addSurfaceLoop(faces)])
        geo.synchronize()

    return build


def facet_loops(vertices: Array, triangles: Cells) -> list[list[list[int]]]:
    """The plane faces of a polyhedron: the boundary loops of each, the outer first.

    A face is all triangles in one plane that hang together; loops are vertex numbers. Vertices
    within a face, or within the straight side between two faces, are left out.
    """
    corners = vertices[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal = np.asarray(normal / np.linalg.norm(normal, axis=1)[:, None], dtype=float)
    of_side = {
        (int(t[k]), int(t[(k + 1) % 3])): i for i, t in enumerate(triangles) for k in range(3)
    }
    facet = _facet_of_each(triangles, normal, of_side)
    sides: dict[int, list[tuple[int, int]]] = {}
    for (a, b), i in of_side.items():
        if facet[of_side[b, a]] != facet[i]:
            sides.setdefault(facet[i], []).append((a, b))
    faces = [_walk(rows, vertices) for rows in sides.values()]
    return _without_straight_corners(faces, vertices)


def _facet_of_each(
    triangles: Cells, normal: NDArray[np.floating[Any]], of_side: dict[tuple[int, int], int]
) -> list[int]:
    """For each triangle the first one of its face."""
    facet = [-1] * len(triangles)
    for seed in range(len(triangles)):
        if facet[seed] >= 0:
            continue
        facet[seed], waiting = seed, [seed]
        while waiting:
            t = triangles[waiting.pop()]
            for k in range(3):
                j = of_side[int(t[(k + 1) % 3]), int(t[k])]
                if facet[j] < 0 and normal[j] @ normal[seed] > 1.0 - 1e-10:
                    facet[j] = seed
                    waiting.append(j)
    return facet


def _without_straight_corners(
    faces: list[list[list[int]]], vertices: Array
) -> list[list[list[int]]]:
    """Loops without the vertices at which two faces alone meet, in a straight line."""
    neighbours: dict[int, set[int]] = {}
    for loops in faces:
        for loop in loops:
            for before, at, after in zip(
                loop[-1:] + loop[:-1], loop, loop[1:] + loop[:1], strict=True
            ):
                neighbours.setdefault(at, set()).update((before, after))
    straight = set()
    for at, around in neighbours.items():
        if len(around) == 2:
            one, two = (vertices[k] - vertices[at] for k in around)
            cosine = one @ two / (np.linalg.norm(one) * np.linalg.norm(two))
            if cosine < -1.0 + 1e-10:
                straight.add(at)
    return [[[k for k in loop if k not in straight] for loop in loops] for loops in faces]


def _walk(sides: list[tuple[int, int]], vertices: Array) -> list[list[int]]:
    """Closed loops of sides, the longest first."""
    after, loops = dict(sides), []
    while after:
        at, loop = next(iter(after)), []
        while at in after:
            loop.append(at)
            at = after.pop(at)
        loops.append(loop)
    return sorted(loops, key=lambda loop: -float(np.ptp(vertices[loop], axis=0).max()))


def _remeshed(vertices: Array, triangles: Cells) -> Callable[[Any], None]:
    """A surface of many small triangles, cut into smooth patches that are meshed anew."""

    def build(gmsh: Any) -> None:
        surface = gmsh.model.addDiscreteEntity(2)
        numbers = np.arange(1, len(vertices) + 1)
        gmsh.model.mesh.addNodes(2, surface, numbers, vertices.ravel())
        gmsh.model.mesh.addElementsByType(surface, 2, [], (triangles + 1).ravel())
        gmsh.model.mesh.classifySurfaces(math.radians(40.0), True, True, math.pi)
        gmsh.model.mesh.createGeometry()
        faces = [tag for _, tag in gmsh.model.getEntities(2)]
        gmsh.model.geo.addVolume([gmsh.model.geo.addSurfaceLoop(faces)])
        gmsh.model.geo.synchronize()

    return build


def _generate(
    name: str, spacing: float, dimension: int, build: Callable[[Any], None]
) -> tuple[Array, Cells]:
    with _session(spacing) as gmsh:
        try:
            gmsh.model.add(name)
            build(gmsh)
            gmsh.model.mesh.generate(dimension)
            tags, coordinates, _ = gmsh.model.mesh.getNodes()
            kinds, _, connections = gmsh.model.mesh.getElements(dimension)
        except Exception as error:  # gmsh raises plain Exception
            raise RuntimeError(f"gmsh could not mesh '{name}': {error}") from error
    corners = dimension + 1
    if list(kinds) != [{2: 2, 3: 4}[dimension]]:
        what = {2: "triangles", 3: "tetrahedra"}[dimension]
        raise RuntimeError(f"gmsh made no {what} of '{name}'")
    order = np.argsort(tags)
    nodes = np.asarray(coordinates).reshape(-1, 3)[order]
    cells = np.searchsorted(tags[order], np.asarray(connections[0]).reshape(-1, corners))
    used = np.unique(cells)  # gmsh keeps construction points too
    return nodes[used], np.searchsorted(used, cells).astype(np.int64)


@contextmanager
def _session(spacing: float) -> Iterator[Any]:
    """gmsh, started with the settings that make meshes repeatable and even."""
    try:
        import gmsh
    except OSError as error:  # a library of the system is missing
        raise RuntimeError(
            f"gmsh cannot be loaded: {error}. The system packages that it needs are listed in "
            "python/system-packages.txt"
        ) from error
    # interruptible would take the signals of the whole process
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        set_number = gmsh.option.setNumber
        set_number("General.Verbosity", 1)
        set_number("General.NumThreads", 1)
        set_number("Mesh.RandomSeed", 1)
        set_number("Mesh.Algorithm", 6)  # frontal Delaunay: nearly equilateral triangles
        set_number("Mesh.Smoothing", 20)
        set_number("Mesh.MeshSizeExtendFromBoundary", 0)
        set_number("Mesh.MeshSizeFromPoints", 0)
        set_number("Mesh.MeshSizeMin", spacing)
        set_number("Mesh.MeshSizeMax", spacing)
        set_number("Mesh.Optimize", 1)
        set_number("Mesh.OptimizeNetgen", 1)  # fewer flat tetrahedra
        yield gmsh
    finally:
        gmsh.finalize()
