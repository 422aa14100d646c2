"""The particles of a deck: meshes, the particle table, and where each particle lies."""

from __future__ import annotations

import csv
import math
import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from peridem import cloud
from peridem.cloud import Cloud
from peridem.deck.geometry import Shape, shape
from peridem.deck.sections import Model, Zone
from peridem.deck.source import Block, DeckError, Report

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Body:
    """One particle.

    Attributes:
        zone: its zone.
        cloud: nodes where they start.
        spacing: smallest distance of two of its nodes (PeriDEM's h).
        bounds: low and high corner of the box around its geometry, (3,) each.
    """

    zone: Zone
    cloud: Cloud
    spacing: float
    bounds: tuple[Array, Array]


def bodies(root: Block, zones: list[Zone], model: Model, report: Report) -> list[Body]:
    """All particles, in PeriDEM's order: zone by zone, in a zone as the table has them."""
    section = root.block("Particle_Generation")
    rows = _table(section, model, report) if "Particle_Generation" in root else None
    found: list[Body] = []
    used = np.zeros(0 if rows is None else len(rows), dtype=bool)
    for zone in zones:
        mesh = _mesh(zone, model, report)
        mine = np.zeros(0, dtype=bool) if rows is None else rows[:, 0] == zone.number - 1
        if zone.own or (zone.wall and not mine.any()):
            found.append(_as_it_is(zone, mesh))
            continue
        if rows is None:
            raise root.missing("Particle_Generation", f"it says where zone {zone.number} goes")
        used |= mine
        if not mine.any():
            report.add(zone.block.place(), "no particle of this zone in the table")
        found += [_placed(zone, mesh, row) for row in rows[mine]]
    if rows is not None and not used.all():
        zone_numbers = sorted({int(z) for z in rows[~used, 0]})
        report.add(
            section.place("From_File"),
            f"{(~used).sum()} rows of zones {zone_numbers} (counted from 0) make no particles",
        )
    if not found:
        raise section.error("From_File", "there are no particles")
    return found


def find(block: Block, key: str) -> Path:
    """A file that a deck names: beside the deck, or from where PeriDEM may have been started."""
    name = Path(block.text(key))
    folder = block.path.resolve().parent
    places = [folder, Path.cwd(), *folder.parents[:2]]
    places = list(dict.fromkeys(places))
    for place in places:
        if (place / name).is_file():
            return place / name
    beside = folder / name.name
    if beside.is_file():
        return beside
    raise block.error(key, f"no file {name} (looked in {', '.join(map(str, places))})")


# ---- the particle table --------------------------------------------------------------------------


def _table(section: Block, model: Model, report: Report) -> Array:
    """Rows of zone (from 0), x, y, z, radius, angle."""
    path = find(section, "From_File")
    kind = section.choice("File_Data_Type", ("loc_rad", "loc_rad_orient"), "loc_rad")
    names = ["i", "x", "y", "z", "r"] + (["o"] if kind == "loc_rad_orient" else [])
    with path.open(newline="") as file:
        reader = csv.reader(file, skipinitialspace=True)
        head = [word.strip() for word in next(reader, [])]
        lacking = [name for name in names if name not in head]
        if lacking:
            raise section.error(
                "From_File",
                f"{path.name} lacks the columns {', '.join(lacking)}; it has {', '.join(head)}",
            )
        columns = [head.index(name) for name in names]
        rows = [_row(path, reader.line_num, words, columns) for words in reader if any(words)]
    if not rows:
        raise section.error("From_File", f"{path.name} has no particles")
    table = np.array(rows, dtype=float)
    if kind == "loc_rad":
        table = np.column_stack([table, _angles(section, len(table), model, report)])
    return table


def _row(path: Path, line: int, words: list[str], columns: list[int]) -> list[float]:
    try:
        values = [float(words[k]) for k in columns]
    except (ValueError, IndexError):
        raise DeckError(
            f"{path}:{line}: {len(columns)} numbers needed, not '{','.join(words)}'"
        ) from None
    if not all(map(math.isfinite, values)) or not values[4] > 0.0:
        raise DeckError(f"{path}:{line}: finite numbers and a radius above 0 needed, not {values}")
    return values


def _angles(section: Block, count: int, model: Model, report: Report) -> Array:
    report.add(
        section.place("File_Data_Type"),
        f"no orientations: random ones of seed {model.seed}, not the numbers of PeriDEM",
    )
    return np.random.default_rng(model.seed).uniform(0.0, 2.0 * math.pi, count)


# ---- meshes --------------------------------------------------------------------------------------


def _mesh(zone: Zone, model: Model, report: Report) -> Cloud:
    block = zone.mesh
    if "File" in block:
        block.skip("Mesh_Size")
    create = block.block("CreateMesh")
    if create.flag("Flag"):
        return _uniform(zone, create, model)
    create.skip("Info", "Geometry")
    if "File" not in block:
        raise block.missing("File", "a mesh, or CreateMesh, is needed")
    path = find(block, "File")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            made = cloud.read(path, path.stem)
        except ValueError as error:
            raise block.error("File", str(error)) from error
    for warning in caught:
        report.add(block.place("File"), f"{warning.message}")
    if made.dimension != model.dimension:
        raise block.error(
            "File", f"{path.name} is a mesh of {made.dimension} dimensions, not {model.dimension}"
        )
    return made


def _uniform(zone: Zone, create: Block, model: Model) -> Cloud:
    """PeriDEM's own mesh of a rectangle or cuboid: equal cells, no smaller than the mesh size."""
    create.choice("Info", ("uniform",))
    geometry = shape(create.block("Geometry")) if "Geometry" in create else zone.shape
    if geometry is None or geometry.kind not in ("rectangle", "cuboid", "square", "cube"):
        kind = "none" if geometry is None else geometry.kind
        raise create.error("Flag", f"a mesh is made of rectangles and cuboids only, not of {kind}")
    size = zone.mesh.positive("Mesh_Size")
    low, high = (corner[: model.dimension] for corner in geometry.bounds)
    cells = ((high - low) / size).astype(np.int64)
    if (cells < 1).any():
        raise zone.mesh.error("Mesh_Size", f"{size:g} is larger than the {geometry.kind}")
    return lattice(low, high, cells, f"{geometry.kind}_{zone.number}")


def lattice(low: Array, high: Array, cells: NDArray[np.int64], name: str) -> Cloud:
    """A box of equal cells; nodes at their corners, x fastest, volumes of the cells around them.

    Each rectangle is drawn as two triangles, each cuboid as six tetrahedra.
    """
    d = len(low)
    axes = [np.linspace(low[k], high[k], cells[k] + 1) for k in range(d)]
    grid = np.meshgrid(*axes, indexing="ij")
    nodes = np.column_stack([g.ravel(order="F") for g in grid])
    share = [np.ones(n + 1) for n in cells]
    for part in share:
        part[[0, -1]] = 0.5
    weights = np.array([1.0])
    for part in share:  # x fastest
        weights = np.multiply.outer(part, weights).ravel()
    volume = float(np.prod((high - low) / cells))
    stride = np.cumprod([1, *(cells[:-1] + 1)])
    corners = np.array([[(k >> a) & 1 for a in range(d)] for k in range(2**d)]) @ stride
    first = np.zeros(int(np.prod(cells)), dtype=np.int64)
    for k, i in enumerate(np.meshgrid(*[np.arange(n) for n in cells.tolist()], indexing="ij")):
        first += stride[k] * i.ravel(order="F")
    cut: dict[int, list[tuple[int, ...]]] = {
        2: [(0, 1, 3), (0, 3, 2)],
        3: [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)],
    }
    tiles = [first[:, None] + corners[list(tile)] for tile in cut[d]]
    made = cloud.from_cells(nodes, np.vstack(tiles), name)
    return replace(made, volumes=volume * weights)


# ---- particles -----------------------------------------------------------------------------------


def _as_it_is(zone: Zone, mesh: Cloud) -> Body:
    """A particle that is the mesh itself."""
    return Body(zone, mesh, mesh.spacing, _bounds(zone.shape, mesh))


def _placed(zone: Zone, mesh: Cloud, row: Array) -> Body:
    """A particle of the table: the mesh scaled, turned about the z axis, and moved."""
    radius, angle = float(row[4]), float(row[5])
    size = zone.shape.size if zone.shape is not None else None
    if size is None:
        kind = "none" if zone.shape is None else zone.shape.kind
        raise zone.block.error("Type", f"a particle of the table cannot be scaled to {kind}")
    if not size > 0.0:
        raise zone.block.error("Parameters", f"its size is {size:g}: particles cannot be scaled")
    scale = radius / size
    place = row[1 : 1 + mesh.dimension]
    made = mesh.placed(place, angle, scale)
    return Body(zone, made, scale * mesh.spacing, _bounds(None, made))


def _bounds(geometry: Shape | None, mesh: Cloud) -> tuple[Array, Array]:
    if geometry is not None:
        return geometry.bounds
    pad = np.zeros(3 - mesh.dimension)
    low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
    return np.append(low, pad), np.append(high, pad)
