"""Clouds of nodes: the mesh of a grain, with a volume for each node.

A node carries its share of every cell around it (lumped volumes: a third of a triangle's area, a
quarter of a tetrahedron's volume). The cells are kept for drawing, not for computing.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from peridem.shapes import Outline

Array = NDArray[np.float64]
Cells = NDArray[np.int64]

_CELL_TYPES = {"triangle": 2, "tetra": 3}


@dataclass(frozen=True, eq=False)
class Cloud:
    """The nodes and cells of one grain in its reference position.

    Make one with :func:`mesh`, :func:`read` or :func:`from_cells`, which check it.

    Attributes:
        name: what it is called in files and messages.
        nodes: (n, d) positions, d = 2 or 3.
        volumes: (n,) volumes; areas in 2D.
        cells: (m, d + 1) triangles or tetrahedra, positively oriented, as rows of node numbers.
        surface: (n,) whether a node lies on the boundary of the mesh.
    """

    name: str
    nodes: Array
    volumes: Array
    cells: Cells
    surface: NDArray[np.bool_]

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.nodes.shape[1])

    @cached_property
    def spacing(self) -> float:
        """Smallest distance of two nodes."""
        return float(cKDTree(self.nodes).query(self.nodes, k=2)[0][:, 1].min())

    @property
    def cell_sizes(self) -> Array:
        """Size of each node's share of the grain, volume^(1/d), (n,)."""
        return np.asarray(self.volumes ** (1.0 / self.dimension))

    @cached_property
    def edges(self) -> Cells:
        """The sides of all cells as sorted pairs of node numbers, each once, (e, 2)."""
        return unique_faces(self.cells, 2)[0]

    @property
    def centroid(self) -> Array:
        """Centre of volume, (d,)."""
        return np.asarray(self.volumes @ self.nodes / self.volumes.sum())

    def placed(self, position: ArrayLike = 0.0, angle: float = 0.0, scale: float = 1.0) -> Cloud:
        """The cloud scaled and turned (in the x-y plane) about the origin, then moved."""
        if not (math.isfinite(scale) and scale > 0.0):
            raise ValueError(f"cloud '{self.name}': scale must be above 0, not {scale}")
        c, s = math.cos(angle), math.sin(angle)
        nodes = scale * self.nodes
        nodes[:, :2] = nodes[:, :2] @ np.array([[c, s], [-s, c]])
        return replace(
            self,
            nodes=nodes + np.asarray(position, dtype=float),
            volumes=self.volumes * scale**self.dimension,
        )

    def write(self, path: str | Path) -> None:
        """Write nodes and cells to a file of any kind that meshio knows by its ending."""
        import meshio

        points = np.zeros((len(self.nodes), 3))
        points[:, : self.dimension] = self.nodes
        kind = {2: "triangle", 3: "tetra"}[self.dimension]
        mesh = meshio.Mesh(points, [(kind, self.cells)])
        path = Path(path)
        if path.suffix == ".msh":
            tags = [np.ones(len(self.cells), dtype=np.int64)]
            mesh.cell_data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
            meshio.write(path, mesh, file_format="gmsh22", binary=False)
        else:
            meshio.write(path, mesh)


def from_cells(nodes: ArrayLike, cells: ArrayLike, name: str = "cloud") -> Cloud:
    """A checked cloud from nodes, (n, d), and triangles or tetrahedra, (m, d + 1).

    If every cell has the opposite orientation all of them are turned round. Nodes that no cell uses
    (such as construction points of a mesh file) carry no volume and are left out with a warning.

    Raises:
        ValueError: arrays of the wrong shape, values that are not finite, cells that are empty,
            inverted against the others or given twice, nodes at one place. Numbers in the messages
            count from 1 in the given order.
    """
    x = np.array(nodes, dtype=float)
    c = np.array(cells, dtype=np.int64)
    if x.ndim != 2 or x.shape[1] not in (2, 3) or c.ndim != 2 or c.shape[1] != x.shape[1] + 1:
        raise ValueError(
            f"cloud '{name}': nodes (n, d) with cells (m, d + 1) needed, d = 2 or 3, "
            f"not {x.shape} and {c.shape}"
        )
    if len(c) == 0:
        raise ValueError(f"cloud '{name}': no cells")
    if c.min() < 0 or c.max() >= len(x):
        raise ValueError(f"cloud '{name}': a cell names a node that is not among the {len(x)}")
    if not np.isfinite(x).all():
        bad = np.flatnonzero(~np.isfinite(x).all(axis=1))
        raise ValueError(f"cloud '{name}': {_listed('node', bad)} not finite")

    ordered = np.sort(c, axis=1)
    twice = np.flatnonzero(_repeats(ordered))
    if len(twice):
        raise ValueError(f"cloud '{name}': {_listed('cell', twice)} given twice")
    volume = _signed_volumes(x, c)
    if np.median(np.sign(volume)) < 0:
        c[:, [0, 1]] = c[:, [1, 0]]
        volume = -volume
    empty = np.flatnonzero(np.abs(volume) <= 1e-9 * np.median(np.abs(volume)))
    if len(empty):
        raise ValueError(f"cloud '{name}': {_listed('cell', empty)} empty (no area or volume)")
    inverted = np.flatnonzero(volume < 0)
    if len(inverted):
        raise ValueError(f"cloud '{name}': {_listed('cell', inverted)} inverted against the others")

    used = np.unique(c)
    if len(used) < len(x):
        unused = np.setdiff1d(np.arange(len(x)), used)
        warnings.warn(
            f"cloud '{name}': {_listed('node', unused)} in no cell, left out", stacklevel=2
        )
        c = np.searchsorted(used, c)
        x = x[used]
    faces, count = unique_faces(c, c.shape[1] - 1)
    if count.max() > 2:
        raise ValueError(f"cloud '{name}': a side is shared by {count.max()} cells; 2 at most")
    surface = np.zeros(len(x), dtype=bool)
    surface[faces[count == 1]] = True
    lumped = np.zeros(len(x))
    np.add.at(lumped, c, (volume / c.shape[1])[:, None])
    cloud = Cloud(name, x, lumped, c, surface)
    size = float(np.median(cloud.cell_sizes))
    if cloud.spacing <= 1e-6 * size:
        nearest = cKDTree(x).query(x, k=2)[0][:, 1]
        close = np.flatnonzero(nearest <= 1e-6 * size)
        raise ValueError(f"cloud '{name}': {_listed('node', close)} at the place of another")
    return cloud


def read(path: str | Path, name: str = "") -> Cloud:
    """A cloud from a mesh file (.msh, .vtu, .inp and whatever else meshio reads).

    The highest-dimensional cells count: tetrahedra, else triangles, which must be flat
    in z.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: it is not a mesh, or has no triangles and no tetrahedra, or :func:`from_cells`
            refuses it.
    """
    import meshio

    path = Path(path)
    name = name or path.stem
    if not path.is_file():
        raise FileNotFoundError(f"no mesh file {path}")
    try:
        # meshio would try other programs' .msh too, and print what it thinks of it
        mesh = meshio.read(path, "gmsh" if path.suffix == ".msh" else None)
    except (meshio.ReadError, KeyError, ValueError, SystemExit) as error:
        raise ValueError(f"{path} cannot be read as a mesh: {error}") from error
    found = {block.type for block in mesh.cells}
    for kind in ("tetra", "triangle"):
        if kind in found:
            cells = np.vstack([block.data for block in mesh.cells if block.type == kind])
            break
    else:
        raise ValueError(
            f"{path} has cells of the kinds {', '.join(sorted(found)) or 'none'}; "
            "triangles or tetrahedra needed"
        )
    d = _CELL_TYPES[kind]
    points = np.asarray(mesh.points, dtype=float)
    if d == 2 and points.shape[1] == 3:
        flat = points[np.unique(cells)]
        if np.ptp(flat[:, 2]) > 1e-9 * np.ptp(flat[:, :2]):
            raise ValueError(f"{path} is curved: a mesh of triangles must lie in one plane")
    return from_cells(points[:, :d], cells, name)


def mesh(outline: Outline, spacing: float) -> Cloud:
    """Mesh an outline with gmsh at a node spacing.

    Nodes sit on the outline, evenly divided (see :meth:`Outline.boundary`), and inside it about
    ``spacing`` apart. The same outline and spacing give the same mesh, node for node.

    Raises:
        ValueError: a spacing that is not positive or too coarse to mesh the outline.
        RuntimeError: gmsh cannot be loaded, or fails.
    """
    x_low, x_high, y_low, y_high = outline.bounds
    size = min(x_high - x_low, y_high - y_low)
    if not (math.isfinite(spacing) and 0.0 < spacing <= 0.5 * size):
        raise ValueError(
            f"mesh of '{outline.name}': spacing must be above 0 and at most half of its width "
            f"{size:g}, not {spacing:g}"
        )
    boundary = outline.boundary(spacing)
    nodes, cells = _gmsh_fill(boundary / size, spacing / size, outline.name)
    return from_cells(nodes * size, cells, outline.name)


def _gmsh_fill(boundary: Array, spacing: float, name: str) -> tuple[Array, Cells]:
    """Triangles inside a closed row of points that stay the only ones on the boundary."""
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
        gmsh.model.add(name)
        geo = gmsh.model.geo
        points = [geo.addPoint(x, y, 0.0) for x, y in boundary]
        lines = [geo.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
        geo.addPlaneSurface([geo.addCurveLoop(lines)])
        for line in lines:
            geo.mesh.setTransfiniteCurve(line, 2)  # no further node between two points
        geo.synchronize()
        gmsh.model.mesh.generate(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        kinds, _, connections = gmsh.model.mesh.getElements(2)
        if list(kinds) != [2]:
            raise RuntimeError(f"gmsh made no triangles of '{name}'")
        order = np.argsort(tags)
        nodes = np.asarray(coordinates).reshape(-1, 3)[order, :2]
        cells = np.searchsorted(tags[order], np.asarray(connections[0]).reshape(-1, 3))
        return nodes, cells.astype(np.int64)
    except RuntimeError:
        raise
    except Exception as error:  # gmsh raises plain Exception
        raise RuntimeError(f"gmsh could not mesh '{name}': {error}") from error
    finally:
        gmsh.finalize()


def _signed_volumes(nodes: Array, cells: Cells) -> Array:
    corners = nodes[cells]
    d = nodes.shape[1]
    return np.asarray(np.linalg.det(corners[:, 1:] - corners[:, :1]) / math.factorial(d))


def unique_faces(cells: Cells, corners: int) -> tuple[Cells, NDArray[np.int64]]:
    """All sub-simplices with so many corners, each once, and how many cells have it."""
    from itertools import combinations

    columns = combinations(range(cells.shape[1]), corners)
    faces = np.sort(np.vstack([cells[:, list(c)] for c in columns]), axis=1)
    unique, count = np.unique(faces, axis=0, return_counts=True)
    return unique, count


def _repeats(rows: Cells) -> NDArray[np.bool_]:
    """Whether a row was there before."""
    first = np.unique(rows, axis=0, return_index=True)[1]
    again = np.ones(len(rows), dtype=bool)
    again[first] = False
    return again


def _listed(what: str, indices: NDArray[np.int64]) -> str:
    """'cells 3, 5, 8 are', numbers from 1, at most eight of them named."""
    named = ", ".join(str(i + 1) for i in indices[:8])
    more = f" and {len(indices) - 8} more" if len(indices) > 8 else ""
    return f"{what} {named} is" if len(indices) == 1 else f"{what}s {named}{more} are"
