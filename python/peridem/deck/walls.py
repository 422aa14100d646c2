"""Walls of a deck as surfaces: planes where their meshes are flat, regions where they are round.

PeriDEM's walls are meshes whose nodes push grains away. A flat side with all grains in front of it
does the same as a plane, and the inside of a drum the same as a region.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from peridem.cloud import Cloud
from peridem.deck.bodies import Body
from peridem.deck.geometry import Shape
from peridem.regions import Block, Combined, Cylinder, Region, Rotation, Sphere
from peridem.walls import AnyWall, RegionWall, Wall

Array = NDArray[np.float64]

MOST_SIDES = 24  # a mesh with more flat sides counts as round
SIDES = {(0, 1): "left", (0, -1): "right"}
UPRIGHT = {2: {(1, 1): "floor", (1, -1): "lid"}, 3: {(2, 1): "floor", (2, -1): "lid"}}
DEEP = {(1, 1): "front", (1, -1): "back"}


@dataclass(frozen=True)
class Drive:
    """How a wall moves: a constant velocity, a rotation, or neither of these.

    Attributes:
        velocity: (d,).
        rotation: or a rotation about a fixed axis.
        other: whether it moves in another way.
    """

    velocity: tuple[float, ...]
    rotation: Rotation | None = None
    other: bool = False


@dataclass(frozen=True, eq=False)
class Side:
    """A flat side of a mesh: outward normal, offset along it, and its nodes."""

    normal: Array
    offset: float
    nodes: Array


def surface(body: Body, drive: Drive, grains: Array) -> list[AnyWall]:
    """The surfaces that do what a wall of nodes does; none if there are no such.

    Args:
        body: the wall.
        drive: how it moves.
        grains: (n, d) nodes of all grains.
    """
    if drive.other:
        return []
    if drive.rotation is None:
        flat = planes(body.cloud, drive, grains)
        if flat:
            return flat
    return _region(body, drive, grains)


# ---- planes --------------------------------------------------------------------------------------


def planes(mesh: Cloud, drive: Drive, grains: Array) -> list[AnyWall]:
    """A plane for each flat side that all grains are in front of; none if one side has grains both
    in front and behind, or is too short to stop all of them."""
    made: list[AnyWall] = []
    size = float(np.ptp(mesh.nodes, axis=0).max())
    for side in sides(mesh):
        ahead = grains @ side.normal - side.offset
        if ahead.max() <= 1e-6 * size:
            continue  # no grain can come here
        if ahead.min() < -1e-6 * size or not _covers(side, grains):
            return []
        made.append(
            Wall(
                _name(side.normal),
                tuple(side.nodes.mean(axis=0).tolist()),
                tuple((side.normal + 0.0).tolist()),
                drive.velocity,
            )
        )
    return made


def sides(mesh: Cloud) -> list[Side]:
    """The flat sides of a mesh; none if there are too many, which means that it is round."""
    d, cells, x = mesh.dimension, mesh.cells, mesh.nodes
    faces = np.vstack([np.delete(cells, k, axis=1) for k in range(d + 1)])
    inner = np.concatenate([cells[:, k] for k in range(d + 1)])
    _, first, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = first[count == 1]
    faces, inner = faces[outer], inner[outer]
    edge = x[faces[:, 1:]] - x[faces[:, :1]]
    if d == 2:
        normal = np.column_stack([edge[:, 0, 1], -edge[:, 0, 0]])
    else:
        normal = np.cross(edge[:, 0], edge[:, 1])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    normal *= -np.sign(((x[inner] - x[faces[:, 0]]) * normal).sum(axis=1))[:, None]
    offset = (x[faces[:, 0]] * normal).sum(axis=1)
    size = float(np.ptp(x, axis=0).max())
    key = np.round(np.column_stack([normal, offset / size]), 5) + 0.0
    kinds, member = np.unique(key, axis=0, return_inverse=True)
    if len(kinds) > MOST_SIDES:
        return []
    found = []
    for k in range(len(kinds)):
        mine = member.ravel() == k
        average = normal[mine].mean(axis=0)
        average = np.round(average / np.linalg.norm(average), 12) + 0.0
        nodes = x[np.unique(faces[mine])]
        found.append(Side(average, float((nodes @ average).mean()), nodes))
    return found


def _covers(side: Side, grains: Array) -> bool:
    """Whether the side is as wide as the grains are, along every direction in it."""
    across = np.linalg.svd(side.normal[None, :])[2][1:]
    mine, theirs = side.nodes @ across.T, grains @ across.T
    return bool((mine.min(axis=0) <= theirs.min(axis=0)).all()) and bool(
        (mine.max(axis=0) >= theirs.max(axis=0)).all()
    )


def _name(normal: Array) -> str:
    """Of a wall that faces this way."""
    d, axis = len(normal), int(np.abs(normal).argmax())
    if abs(normal[axis]) < 1.0 - 1e-6:
        return "slope"
    key = axis, int(np.sign(normal[axis]))
    return {**DEEP, **SIDES, **UPRIGHT[d]}[key]


# ---- regions -------------------------------------------------------------------------------------


def _region(body: Body, drive: Drive, grains: Array) -> list[AnyWall]:
    if body.zone.shape is None or not body.zone.own:
        return []
    region = inside_of(body.zone.shape, grains)
    if region is None or not region.contains(grains).all():
        return []
    return [RegionWall("drum", region, drive.velocity, rotation=drive.rotation)]


def inside_of(shape: Shape, grains: Array) -> Region | None:
    """The region in which a wall of some shape leaves the grains.

    A complex shape is a solid, a hollow in which the grains are, and fins in it.
    """
    if shape.kind in ("rectangle_minus_rectangle", "cuboid_minus_cuboid"):
        return _hollow_box(shape, grains.shape[1])
    if not shape.parts:
        return simple(shape, False, grains.shape[1])
    for k in range(len(shape.parts) - 1, -1, -1):
        part, added = shape.parts[k]
        if added or not part.contains(grains).all():
            continue
        regions = [simple(part, True, grains.shape[1])]
        regions += [
            simple(fin, False, grains.shape[1]) for fin, more in shape.parts[k + 1 :] if more
        ]
        known = [region for region in regions if region is not None]
        if len(known) < len(regions):
            return None
        return known[0] if len(known) == 1 else Combined(tuple(known))
    return None


def simple(shape: Shape, inside: bool, dimension: int) -> Region | None:
    """A simple shape as a region, or None."""
    centre = shape.centre
    if shape.kind == "circle" and dimension == 2:
        return Cylinder((float(centre[0]), float(centre[1])), shape.values[0], inside=inside)
    if shape.kind == "sphere":
        x, y, z = centre.tolist()
        return Sphere((x, y, z), shape.values[0], inside)
    boxes = ("rectangle", "square") if dimension == 2 else ("cuboid", "cube")
    if shape.kind in boxes:
        low, high = (tuple(corner[:dimension].tolist()) for corner in shape.bounds)
        return Block(low, high, inside)
    if shape.kind == "cylinder":
        return _cylinder(shape, inside)
    return None


def _cylinder(shape: Shape, inside: bool) -> Region | None:
    start, axis, radius = shape._cylinder()
    along = int(np.abs(axis).argmax())
    if np.abs(np.delete(axis, along)).max() > 1e-9 * abs(axis[along]):
        return None
    a, b = np.delete(start, along).tolist()
    ends = sorted((float(start[along]), float(start[along] + axis[along])))
    return Cylinder((a, b), radius, "xyz"[along], ends[0], ends[1], inside)


def _hollow_box(shape: Shape, dimension: int) -> Region:
    """The inside of a box; a side with no wall behind it is open."""
    outer, inner = np.array(shape.values[:6]), np.array(shape.values[6:])
    low, high = inner[:dimension], inner[3 : 3 + dimension]
    open_ = []
    for k in range(dimension):
        if low[k] <= outer[k]:
            open_.append(2 * k + 1)
        if high[k] >= outer[3 + k]:
            open_.append(2 * k + 2)
    return Block(tuple(low.tolist()), tuple(high.tolist()), True, tuple(open_))
