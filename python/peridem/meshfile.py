"""Mesh files, through meshio."""

from __future__ import annotations

import warnings
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

if TYPE_CHECKING:
    from peridem.cloud import Cloud

Array = NDArray[np.float64]
Cells = NDArray[np.int64]

# What other cells are made of: triangles of a quadrilateral, tetrahedra of a hexahedron (all around
# one diagonal, so that neighbours that are numbered alike fit together)
_SPLIT = {
    "quad": ("triangle", [(0, 1, 2), (0, 2, 3)]),
    "hexahedron": (
        "tetra",
        [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)],
    ),
}
_CORNERS = {"triangle": 3, "tetra": 4}


@dataclass(frozen=True, eq=False)
class MeshFile:
    """What a mesh file holds.

    Attributes:
        points: (n, 3).
        cells: (m, 4) tetrahedra if it has any, else (m, 3) triangles.
        volumes: (n,) if the file has point data of the name ``volume``, else None.
        tags: (m,) number of the physical group of each cell, 0 where the file has none.
    """

    points: Array
    cells: Cells
    volumes: Array | None
    tags: NDArray[np.int64]


def read_mesh(path: str | Path) -> MeshFile:
    """The nodes and the highest-dimensional cells of a mesh file.

    Quadrilaterals are divided into triangles and hexahedra into tetrahedra.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: it is not a mesh, or has no cells of these kinds.
    """
    mesh = _read(path)
    given = np.asarray(mesh.points, dtype=float)
    if given.ndim != 2:
        raise ValueError(f"{path} has no nodes: it is empty or cut off")
    points = np.zeros((len(given), 3))
    points[:, : given.shape[1]] = given
    for kind in ("tetra", "triangle"):
        blocks, tags = _blocks(mesh, kind)
        if blocks:
            data = mesh.point_data.get("volume")
            volumes = None if data is None else np.asarray(data, dtype=float).ravel()
            cells = np.vstack(blocks)
            _check_nodes(path, cells, len(points))
            return MeshFile(points, cells, volumes, np.concatenate(tags))
    found = sorted({block.type for block in mesh.cells})
    raise ValueError(
        f"{path} has cells of the kinds {', '.join(found) or 'none'}; triangles, quadrilaterals, "
        "tetrahedra or hexahedra with straight sides (first order) needed"
    )


def _check_nodes(path: str | Path, cells: Cells, count: int) -> None:
    """Whether all nodes of the cells are there."""
    wrong = np.flatnonzero(((cells < 0) | (cells >= count)).any(axis=1))
    if len(wrong):
        nodes = ", ".join(str(n + 1) for n in cells[wrong[0]])
        raise ValueError(f"{path}: cell {wrong[0] + 1} is of the nodes {nodes}; there are {count}")


def read_surface(path: str | Path) -> tuple[Array, Cells]:
    """Vertices and triangles of a surface; vertices at one place, as .stl has them, become one.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: it is not a mesh of triangles.
    """
    mesh = read_mesh(path)
    if mesh.cells.shape[1] != 3:
        raise ValueError(f"{path} has tetrahedra: a surface of triangles needed")
    return _merged(mesh.points, mesh.cells)


def write_mesh(cloud: Cloud, path: str | Path) -> None:
    """Write nodes and cells to a file of any kind that meshio knows by its ending.

    A .msh file is of version 2.2, in text; .vtu and .vtk hold volumes and surface flags too.

    Raises:
        ValueError: meshio knows no such ending, or the kind of file cannot hold the cells.
    """
    import meshio

    path = Path(path)
    points = np.zeros((len(cloud.nodes), 3))
    points[:, : cloud.dimension] = cloud.nodes
    kind = {2: "triangle", 3: "tetra"}[cloud.dimension]
    if path.suffix not in meshio.extension_to_filetypes:
        raise ValueError(
            f"{path} cannot be written: no mesh format ends in '{path.suffix}'; .msh, .vtu, .vtk, "
            ".inp do, and what else meshio knows"
        )
    mesh = meshio.Mesh(points, [(kind, cloud.cells)])
    try:
        if path.suffix == ".msh":
            tags = [np.ones(len(cloud.cells), dtype=np.int64)]
            mesh.cell_data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
            meshio.write(path, mesh, file_format="gmsh22", binary=False)
            return
        if path.suffix in (".vtu", ".vtk"):
            mesh.point_data = {"volume": cloud.volumes, "surface": cloud.surface.astype(np.int64)}
        meshio.write(path, mesh)
    except (meshio.WriteError, meshio.ReadError, KeyError, ImportError, SystemExit) as error:
        path.unlink(missing_ok=True)
        raise ValueError(f"{path} cannot be written: {error}") from error


def _read(path: str | Path) -> Any:
    import meshio

    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"no mesh file {path}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # of its guess whether .stl is binary
            if path.suffix == ".msh":
                return meshio.gmsh.read(path)
            # meshio prints what it thinks of a file
            with redirect_stderr(StringIO()), redirect_stdout(StringIO()):
                return meshio.read(path)
    except (SystemExit, SyntaxError) as error:  # ... and would end the program
        raise ValueError(f"{path} cannot be read as a mesh ({path.suffix[1:]})") from error
    except (meshio.ReadError, KeyError, ValueError, IndexError, TypeError) as error:
        raise ValueError(f"{path} cannot be read as a mesh: {error}".rstrip(": ")) from error


def _blocks(mesh: Any, kind: str) -> tuple[list[Cells], list[NDArray[np.int64]]]:
    """The cells of a kind, (m, d + 1) each, also from cells that are divided, and their tags."""
    physical = mesh.cell_data.get("gmsh:physical")
    blocks: list[Cells] = []
    tags: list[NDArray[np.int64]] = []
    for k, block in enumerate(mesh.cells):
        into, parts = _SPLIT.get(block.type, (block.type, [tuple(range(_CORNERS[kind]))]))
        if into != kind:
            continue
        data = np.asarray(block.data, dtype=np.int64)
        tag = np.zeros(len(data), np.int64) if physical is None else np.asarray(physical[k])
        blocks.append(data[:, np.array(parts)].reshape(-1, _CORNERS[kind]))
        tags.append(np.repeat(tag.astype(np.int64), len(parts)))
    return blocks, tags


def _merged(points: Array, cells: Cells) -> tuple[Array, Cells]:
    used = np.unique(cells)
    points, cells = points[used], np.searchsorted(used, cells)
    pairs = cKDTree(points).query_pairs(
        1e-8 * float(np.ptp(points, axis=0).max()), output_type="ndarray"
    )
    n = len(points)
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(n, n))
    label = connected_components(graph, directed=False)[1]
    first = np.unique(label, return_index=True)[1]
    order = np.argsort(first)  # keep the order of first mention
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return points[first[order]], rank[label][cells]
