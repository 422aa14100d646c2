"""Clouds of nodes: the mesh or the lattice of a grain, with a volume for each node.

A node of a mesh carries its share of every cell around it (lumped volumes: a third of a triangle's
area, a quarter of a tetrahedron's volume), or what is nearer to it than to any other node (Voronoi
volumes). The cells are kept for drawing, not for computing.
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

from peridem.outline import Outline
from peridem.solid import Solid, rotation_matrix

Array = NDArray[np.float64]
Cells = NDArray[np.int64]

MOST_NODES = 5_000_000  # of one cloud

VOLUMES = ("lumped", "voronoi")


@dataclass(frozen=True, eq=False)
class Cloud:
    """The nodes and cells of one grain in its reference position.

    Make one with :func:`mesh`, :func:`lattice`, :func:`read` or :func:`from_cells`, which check it.

    Attributes:
        name: what it is called in files and messages.
        nodes: (n, d) positions, d = 2 or 3.
        volumes: (n,) volumes; areas in 2D.
        cells: (m, d + 1) triangles or tetrahedra, positively oriented, as rows of node numbers.
        surface: (n,) whether a node lies on the boundary of the mesh.
        tags: (m,) number of the group of each cell, as the mesh file has it; 0 without groups.
    """

    name: str
    nodes: Array
    volumes: Array
    cells: Cells
    surface: NDArray[np.bool_]
    tags: NDArray[np.int64] | None = None

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
    def links(self) -> Cells:
        """Sides enough to join the nodes of each cell: pairs of node numbers, (d m, 2)."""
        return np.vstack([self.cells[:, [0, k]] for k in range(1, self.dimension + 1)])

    @cached_property
    def pieces(self) -> NDArray[np.int64]:
        """Nodes of each piece that cells join, (p,), the largest first: one for a whole grain."""
        return piece_sizes(len(self.nodes), self.links)

    @property
    def measure(self) -> float:
        """All volumes together; the area in 2D."""
        return float(self.volumes.sum())

    @property
    def centroid(self) -> Array:
        """Centre of volume, (d,)."""
        return np.asarray(self.volumes @ self.nodes / self.volumes.sum())

    @property
    def moments(self) -> Array:
        """Second moments of the nodes about the centroid, sum of V (r - c)(r - c)', (d, d)."""
        arm = self.nodes - self.centroid
        return np.asarray((self.volumes[:, None] * arm).T @ arm)

    # ---- the same elsewhere ----------------------------------------------------------------------

    def placed(
        self, position: ArrayLike = 0.0, angle: ArrayLike = 0.0, scale: float = 1.0
    ) -> Cloud:
        """The cloud scaled and turned about the origin, then moved.

        Args:
            position: (d,) how far it is moved.
            angle: in radians about z, or in 3D a rotation vector, (3,).
            scale: how much larger.
        """
        return self.scaled(scale).rotated(angle).moved(position)

    def moved(self, shift: ArrayLike) -> Cloud:
        """The cloud moved by a vector, (d,)."""
        return replace(self, nodes=self.nodes + np.asarray(shift, dtype=float))

    def rotated(self, angle: ArrayLike) -> Cloud:
        """The cloud turned about the origin: an angle about z, or a rotation vector, (3,)."""
        turn = rotation_matrix(angle, self.dimension)
        return replace(self, nodes=self.nodes @ turn.T)

    def scaled(self, factor: ArrayLike) -> Cloud:
        """The cloud stretched from the origin: one factor, or one for each axis, (d,)."""
        factors = np.broadcast_to(np.asarray(factor, dtype=float), (self.dimension,))
        if not (np.isfinite(factors).all() and (factors > 0.0).all()):
            raise ValueError(f"cloud '{self.name}': scale must be above 0, not {factor!r}")
        volumes = self.volumes * float(np.prod(factors))
        return replace(self, nodes=self.nodes * factors, volumes=volumes)

    def mirrored(self, axis: int = 0) -> Cloud:
        """The mirror image: the coordinate ``axis`` (0 for x) changes sign."""
        if not 0 <= axis < self.dimension:
            raise ValueError(
                f"cloud '{self.name}': axis must be below {self.dimension}, not {axis}"
            )
        sign = np.ones(self.dimension)
        sign[axis] = -1.0
        cells = self.cells.copy()
        cells[:, [0, 1]] = cells[:, [1, 0]]
        return replace(self, nodes=self.nodes * sign, cells=cells)

    def with_measure(self, measure: float) -> Cloud:
        """The cloud with all volumes scaled so that they add up to an area or volume."""
        if not (math.isfinite(measure) and measure > 0.0):
            raise ValueError(f"cloud '{self.name}': measure must be above 0, not {measure}")
        return replace(self, volumes=self.volumes * (measure / self.volumes.sum()))

    def write(self, path: str | Path) -> None:
        """Write nodes and cells to a file (see :func:`peridem.meshfile.write_mesh`)."""
        from peridem.meshfile import write_mesh

        write_mesh(self, path)


def from_cells(
    nodes: ArrayLike,
    cells: ArrayLike,
    name: str = "cloud",
    volumes: str | ArrayLike = "lumped",
    tags: ArrayLike | None = None,
) -> Cloud:
    """A checked cloud from nodes, (n, d), and triangles or tetrahedra, (m, d + 1).

    If every cell has the opposite orientation all of them are turned round. Nodes that no cell uses
    (such as construction points of a mesh file) carry no volume and are left out with a warning.

    Args:
        nodes: positions.
        cells: rows of node numbers, from 0.
        name: what it is called in files and messages.
        volumes: "lumped", "voronoi", or the volume of each node, (n,).
        tags: (m,) number of the group of each cell.

    Raises:
        ValueError: arrays of the wrong shape, values that are not finite, cells that are empty,
            inverted against the others or given twice, nodes at one place. Numbers in the messages
            count from 1 in the given order.
    """
    x, c = _checked_arrays(nodes, cells, name)
    c, size = _checked_cells(x, c, name)
    given = _given_volumes(volumes, len(x), name)
    used = np.unique(c)
    if len(used) < len(x):
        unused = np.setdiff1d(np.arange(len(x)), used)
        warnings.warn(
            f"cloud '{name}': {_listed('node', unused)} in no cell, left out", stacklevel=2
        )
        c, x = np.searchsorted(used, c), x[used]
        given = None if given is None else given[used]
    faces, count = unique_faces(c, c.shape[1] - 1)
    if count.max() > 2:
        raise ValueError(f"cloud '{name}': a side is shared by {count.max()} cells; 2 at most")
    surface = np.zeros(len(x), dtype=bool)
    surface[faces[count == 1]] = True
    if given is None:
        given = _lumped(len(x), c, size) if volumes == "lumped" else _voronoi(x, c)
    group = None if tags is None else np.array(tags, dtype=np.int64)
    cloud = Cloud(name, x, given, c, surface, group)
    typical = float(np.median(_lumped(len(x), c, size))) ** (1.0 / cloud.dimension)
    if cloud.spacing <= 1e-6 * typical:
        nearest = cKDTree(x).query(x, k=2)[0][:, 1]
        close = used[np.flatnonzero(nearest <= 1e-6 * typical)]
        raise ValueError(f"cloud '{name}': {_listed('node', close)} at the place of another")
    return cloud


def _checked_arrays(nodes: ArrayLike, cells: ArrayLike, name: str) -> tuple[Array, Cells]:
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
    return x, c


def _checked_cells(x: Array, c: Cells, name: str) -> tuple[Cells, Array]:
    """The cells, positively oriented, and their volumes."""
    twice = np.flatnonzero(_repeats(np.sort(c, axis=1)))
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
    return c, volume


def _given_volumes(volumes: str | ArrayLike, n: int, name: str) -> Array | None:
    if isinstance(volumes, str):
        if volumes not in VOLUMES:
            raise ValueError(
                f"cloud '{name}': volumes must be {' or '.join(VOLUMES)}, not '{volumes}'"
            )
        return None
    given = np.array(volumes, dtype=float)
    if given.shape != (n,):
        raise ValueError(f"cloud '{name}': {n} nodes with volumes of the shape {given.shape}")
    bad = np.flatnonzero(~(np.isfinite(given) & (given > 0.0)))
    if len(bad):
        raise ValueError(f"cloud '{name}': {_listed('node', bad)} without a volume above 0")
    return given


def _lumped(n: int, cells: Cells, size: Array) -> Array:
    volumes = np.zeros(n)
    np.add.at(volumes, cells, (size / cells.shape[1])[:, None])
    return volumes


def _voronoi(nodes: Array, cells: Cells) -> Array:
    from peridem.voronoi import voronoi_volumes

    return voronoi_volumes(nodes, cells)


def read(
    path: str | Path, name: str = "", volumes: str = "lumped", spacing: float | None = None
) -> Cloud:
    """A cloud from a mesh file (.msh, .vtu, .inp, .stl and whatever else meshio reads).

    The highest-dimensional cells count: tetrahedra, else triangles (hexahedra and
    quadrilaterals are divided into them). Triangles that lie in one plane z = constant are a
    cloud in the plane; triangles that do not, as in an .stl file, are the surface of a solid,
    which gmsh fills.

    Args:
        path: the file.
        name: of the cloud; the file's without ending if left out.
        volumes: "lumped", "voronoi", or "file": the point data named ``volume``.
        spacing: of the nodes, for a file that holds a surface.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: it is not a mesh, or has no triangles and no tetrahedra, or is a surface and
            there is no spacing, or :func:`from_cells` refuses it.
    """
    from peridem import meshfile

    path = Path(path)
    name = name or path.stem
    found = meshfile.read_mesh(path)
    d = found.cells.shape[1] - 1
    if d == 2:
        corners = found.points[np.unique(found.cells)]
        if np.ptp(corners[:, 2]) > 1e-9 * np.ptp(corners[:, :2]):
            return _filled(path, name, volumes, spacing)
    if spacing is not None:
        raise ValueError(f"{path} holds cells, not a surface: its spacing is what it is")
    if volumes == "file" and found.volumes is None:
        raise ValueError(f"{path} has no point data named 'volume'")
    by = found.volumes if volumes == "file" and found.volumes is not None else volumes
    try:
        return from_cells(found.points[:, :d], found.cells, name, by, found.tags)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _filled(path: Path, name: str, volumes: str, spacing: float | None) -> Cloud:
    from peridem import shapes

    if spacing is None:
        raise ValueError(
            f"{path} does not lie in a plane z = constant: a mesh of triangles must, or be a "
            "closed surface to fill with tetrahedra; give a spacing for that"
        )
    return mesh(shapes.stl(path, name), spacing, volumes)


def mesh(
    shape: Outline | Solid, spacing: float, volumes: str = "lumped", exact: bool = False
) -> Cloud:
    """Mesh a shape with gmsh at a node spacing.

    Nodes sit on the boundary, evenly divided, and inside about ``spacing`` apart. The same shape
    and spacing give the same mesh, node for node.

    Args:
        shape: an outline or a solid.
        spacing: wanted distance of neighbouring nodes.
        volumes: "lumped" or "voronoi".
        exact: scale all volumes so that they add up to the area or volume of the shape; a mesh lies
            inside a curved boundary and falls short of it.

    Raises:
        ValueError: a spacing that is not positive or too coarse to mesh the shape.
        RuntimeError: gmsh cannot be loaded, or fails.
    """
    from peridem import gmsh_mesh

    low, high = shape.extent
    size = float((high - low).min())
    if not (math.isfinite(spacing) and 0.0 < spacing <= 0.5 * size):
        raise ValueError(
            f"mesh of '{shape.name}': spacing must be above 0 and at most half of its width "
            f"{size:g}, not {spacing:g}"
        )
    _check_size(shape, spacing)
    if isinstance(shape, Outline):
        nodes, cells = gmsh_mesh.fill_outline(shape, spacing)
    else:
        nodes, cells = gmsh_mesh.fill_solid(shape, spacing)
    made = from_cells(nodes, cells, shape.name, volumes)
    return made.with_measure(shape.measure) if exact else made


def lattice(shape: Outline | Solid, spacing: float, kind: str = "") -> Cloud:
    """The sites of a regular lattice inside a shape.

    Each node carries the same volume, and all together the shape's. Nodes are the more regular, and
    the boundary the rougher, than with :func:`mesh`; which is better depends on the question. Cells
    join neighbouring sites, so they do not reach the boundary.

    Args:
        shape: an outline or a solid.
        spacing: distance of nearest neighbours.
        kind: "square" (default) or "hexagonal" in the plane, "cubic" (default) or "fcc" in space.

    Raises:
        ValueError: a wrong kind or spacing, or too few sites inside.
    """
    from peridem import lattice as lattices

    kind = kind or {2: "square", 3: "cubic"}[shape.dimension]
    _check_size(shape, spacing)
    nodes, surface = lattices.sites(shape, spacing, kind)
    cells = lattices.cells_between(nodes, spacing, shape)
    share = np.full(len(nodes), shape.measure / len(nodes))
    return Cloud(shape.name, nodes, share, cells, surface)


def make(
    what: str,
    radius: float = 1e-3,
    spacing: float | None = None,
    volumes: str = "lumped",
    kind: str = "",
) -> Cloud:
    """A cloud as a command line names it: a named shape, or a mesh file.

    Args:
        what: one of :data:`peridem.shapes.NAMED`, or the path of a file.
        radius: of the circle or sphere around a named shape.
        spacing: of the nodes; None: a fifth of the radius, or what the file has.
        volumes: "lumped", "voronoi" or, for a file, "file".
        kind: of a lattice (see :func:`lattice`) instead of a mesh of a named shape.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: what shapes, :func:`mesh`, :func:`lattice` and :func:`read` refuse.
    """
    from peridem import shapes

    if what not in shapes.NAMED and Path(what).suffix:
        if kind:
            raise ValueError(f"{what} is a mesh file: a lattice fills named shapes only")
        return read(what, volumes=volumes, spacing=spacing)
    shape = shapes.named(what, radius)
    spacing = radius / 5.0 if spacing is None else spacing
    return lattice(shape, spacing, kind) if kind else mesh(shape, spacing, volumes)


def _check_size(shape: Outline | Solid, spacing: float) -> None:
    """Refuse more nodes than a grain can have: they would take hours and all memory."""
    nodes = shape.measure / spacing**shape.dimension if spacing > 0.0 else 0.0
    if nodes > MOST_NODES:
        raise ValueError(
            f"'{shape.name}' at a spacing of {spacing:g} has some {nodes:.1g} nodes, and at most "
            f"{MOST_NODES:,} are made: a larger spacing needed"
        )


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


def piece_sizes(n: int, pairs: Cells) -> NDArray[np.int64]:
    """How many of n nodes are in each piece that pairs of them, (e, 2), join; the largest first."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(pairs), dtype=np.int8), pairs.T), shape=(n, n))
    label = connected_components(graph, directed=False)[1]
    return np.sort(np.bincount(label))[::-1]


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
