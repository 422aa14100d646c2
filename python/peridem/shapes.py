"""The named shapes: outlines in the plane and solids in space.

Lengths are in whatever unit the scene uses, angles in radians, counter-clockwise. The shapes are
centred on the origin; those named by one ``radius`` are sized by the circle or sphere around them,
so that grains of one radius take about the same room.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from peridem.outline import Outline, _positive
from peridem.solid import Cylinder, Ellipsoid, Polyhedron, Solid, hull_of, solid

__all__ = [
    "NAMED",
    "Outline",
    "Shape",
    "Solid",
    "annulus",
    "circle",
    "cuboid",
    "cylinder",
    "drum",
    "ellipse",
    "ellipsoid",
    "hexagon",
    "irregular",
    "irregular_solid",
    "named",
    "polygon",
    "polyhedron",
    "rectangle",
    "regular_polygon",
    "sphere",
    "star",
    "stl",
    "triangle",
]

Array = NDArray[np.float64]
Shape = Outline | Solid


# ---- in the plane --------------------------------------------------------------------------------


def circle(radius: float) -> Outline:
    """A circle."""
    _positive("circle", "radius", radius)
    return Outline("circle", np.zeros((1, 2)), np.diag([radius, radius]))


def ellipse(semi_axis_x: float, semi_axis_y: float) -> Outline:
    """An ellipse with its semi-axes along x and y."""
    _positive("ellipse", "semi_axis_x", semi_axis_x)
    _positive("ellipse", "semi_axis_y", semi_axis_y)
    return Outline("ellipse", np.zeros((1, 2)), np.diag([semi_axis_x, semi_axis_y]))


def regular_polygon(sides: int, radius: float, first: float = 0.0, name: str = "") -> Outline:
    """A regular polygon in the circle of the given radius, its first corner at angle ``first``."""
    name = name or f"{sides}-gon"
    _positive(name, "radius", radius)
    if sides < 3:
        raise ValueError(f"{name}: {sides} sides, at least 3 needed")
    return Outline(name, radius * _round(first + 2.0 * math.pi * np.arange(sides) / sides))


def hexagon(radius: float) -> Outline:
    """A regular hexagon with corners on the x axis; ``radius`` reaches to the corners."""
    return regular_polygon(6, radius, 0.0, "hexagon")


def triangle(radius: float) -> Outline:
    """An equilateral triangle with a corner at the top; ``radius`` reaches to the corners."""
    return regular_polygon(3, radius, 0.5 * math.pi, "triangle")


def drum(radius: float, neck: float = 0.4) -> Outline:
    """A concave drum: the quadrangle of a hexagon's top and bottom sides, drawn in at the middle.

    Args:
        radius: reaches to the four outer corners, at (±1/2, ±√3/2) times the radius.
        neck: width at the middle over the radius; below 1, where the sides would be straight.
    """
    _positive("drum", "radius", radius)
    if not 0.0 < neck < 1.0:
        raise ValueError(f"drum: neck must lie between 0 and 1, not {neck}")
    h = 0.5 * math.sqrt(3.0)
    corners = [(0.5, -h), (0.5 * neck, 0), (0.5, h), (-0.5, h), (-0.5 * neck, 0), (-0.5, -h)]
    return Outline("drum", radius * np.array(corners))


def star(radius: float, points: int = 5, inner: float = 0.5) -> Outline:
    """A concave star with a tip at the top.

    Args:
        radius: reaches to the tips.
        points: how many tips.
        inner: distance of the notches from the centre over the radius; below cos(pi/points), where
            the star would be a polygon.
    """
    _positive("star", "radius", radius)
    if points < 3:
        raise ValueError(f"star: {points} points, at least 3 needed")
    if not 0.0 < inner < math.cos(math.pi / points):
        raise ValueError(
            f"star: inner must lie between 0 and cos(pi/{points}) = "
            f"{math.cos(math.pi / points):.4g}, not {inner}"
        )
    away = radius * np.where(np.arange(2 * points) % 2 == 0, 1.0, inner)
    angle = 0.5 * math.pi + math.pi * np.arange(2 * points) / points
    return Outline("star", away[:, None] * _round(angle))


def rectangle(width: float, height: float) -> Outline:
    """A rectangle centred on the origin."""
    _positive("rectangle", "width", width)
    _positive("rectangle", "height", height)
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    return Outline("rectangle", corners * (width, height))


def annulus(
    inner: float,
    outer: float,
    protrusion: tuple[float, float] | None = None,
    angle: float = -0.5 * math.pi,
) -> Outline:
    """A ring, such as the wall of a rotating drum, perhaps with a fin on its inside.

    Args:
        inner: radius of the hole.
        outer: radius of the circle around it.
        protrusion: length towards the centre and width of a rectangular fin; None: no fin.
        angle: where the fin is.
    """
    _positive("annulus", "inner", inner)
    if not (math.isfinite(outer) and outer > inner):
        raise ValueError(f"annulus: outer must be larger than inner {inner:g}, not {outer:g}")
    centre, axes = np.zeros((1, 2)), np.diag([outer, outer])
    if protrusion is None:
        return Outline("annulus", centre, axes, (circle(inner),))
    length, width = protrusion
    if not (0.0 < length < inner and 0.0 < width < 2.0 * inner):
        raise ValueError(
            f"annulus: a fin needs a length between 0 and {inner:g} and a width between 0 and "
            f"{2.0 * inner:g}, not {protrusion}"
        )
    half = math.asin(0.5 * width / inner)
    arc = inner * _round(np.linspace(half, 2.0 * math.pi - half, 720))
    tip = inner - length
    vertices = np.vstack([arc, [(tip, -0.5 * width), (tip, 0.5 * width)]])
    corner = np.zeros(len(vertices), dtype=bool)
    corner[[0, -3, -2, -1]] = True
    hole = Outline("hole", vertices, corner=corner).placed(angle=angle)
    return Outline("annulus", centre, axes, (hole,))


def polygon(vertices: ArrayLike, name: str = "polygon") -> Outline:
    """A polygon through the given corners, (n, 2), in either sense of rotation."""
    return Outline(name, np.asarray(vertices, dtype=float))


def irregular(
    radius: float, corners: int = 9, roughness: float = 0.25, seed: int = 1, elongation: float = 1.0
) -> Outline:
    """A random angular grain around the origin, its centroid moved there.

    Args:
        radius: reaches to the furthest corner.
        corners: how many.
        roughness: spread of their distances from the centre, 0 (all alike) to below 1.
        seed: another seed, another grain.
        elongation: length over width, roughly; at least 1.
    """
    _positive("irregular", "radius", radius)
    if corners < 3:
        raise ValueError(f"irregular: {corners} corners, at least 3 needed")
    _check_spread("irregular", roughness, elongation)
    random = np.random.default_rng(seed)
    turn = (np.arange(corners) + 0.7 * random.uniform(-0.5, 0.5, corners)) / corners
    away = random.uniform(1.0 - roughness, 1.0, corners)
    points = away[:, None] * _round(2.0 * math.pi * (turn + random.uniform())) * (elongation, 1.0)
    outline = Outline("irregular", points)
    centred = outline.vertices - outline.centroid
    return Outline("irregular", centred * (radius / np.hypot(*centred.T).max()))


# ---- in space ------------------------------------------------------------------------------------


def sphere(radius: float) -> Solid:
    """A sphere."""
    _positive("sphere", "radius", radius)
    return solid("sphere", Ellipsoid((radius, radius, radius)))


def ellipsoid(semi_axis_x: float, semi_axis_y: float, semi_axis_z: float) -> Solid:
    """An ellipsoid with its semi-axes along x, y and z."""
    semi_axes = (semi_axis_x, semi_axis_y, semi_axis_z)
    for what, value in zip("xyz", semi_axes, strict=True):
        _positive("ellipsoid", f"semi_axis_{what}", value)
    return solid("ellipsoid", Ellipsoid(semi_axes))


def cuboid(width: float, depth: float, height: float) -> Solid:
    """A cuboid centred on the origin, its sides along x, y and z."""
    size = (width, depth, height)
    for what, value in zip(("width", "depth", "height"), size, strict=True):
        _positive("cuboid", what, value)
    signs = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return solid("cuboid", hull_of(signs * size))


def cylinder(radius: float, height: float) -> Solid:
    """A circular cylinder centred on the origin, its axis along z."""
    _positive("cylinder", "radius", radius)
    _positive("cylinder", "height", height)
    return solid("cylinder", Cylinder(radius, height))


def polyhedron(vertices: ArrayLike, triangles: ArrayLike, name: str = "polyhedron") -> Solid:
    """A polyhedron from its vertices, (n, 3), and triangles, (m, 3), numbers from 0.

    Raises:
        ValueError: the surface is not closed, or encloses nothing (see
            :class:`peridem.solid.Polyhedron`).
    """
    return solid(name, Polyhedron(np.asarray(vertices), np.asarray(triangles)))


def irregular_solid(
    radius: float,
    corners: int = 14,
    roughness: float = 0.2,
    seed: int = 1,
    elongation: float = 1.0,
) -> Solid:
    """A random convex polyhedron around the origin, its centroid moved there.

    Args:
        radius: reaches to the furthest corner.
        corners: at most so many; those inside the hull of the others are left out.
        roughness: spread of their distances from the centre, 0 (all alike) to below 1.
        seed: another seed, another grain.
        elongation: length over width, roughly; at least 1.
    """
    _positive("irregular_solid", "radius", radius)
    if corners < 6:
        raise ValueError(f"irregular_solid: {corners} corners, at least 6 needed")
    _check_spread("irregular_solid", roughness, elongation)
    random = np.random.default_rng(seed)
    points = _spread_directions(corners, random)
    points *= random.uniform(1.0 - roughness, 1.0, (corners, 1)) * (elongation, 1.0, 1.0)
    hull = hull_of(points)
    centred = hull.vertices - hull.centroid
    scale = radius / np.linalg.norm(centred, axis=1).max()
    return solid("irregular_solid", Polyhedron(centred * scale, hull.triangles))


def stl(path: str | Path, name: str = "") -> Solid:
    """The solid within the closed surface of a file of triangles: .stl, .obj, .ply, ...

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: it is not a mesh of triangles, or the surface is not closed.
    """
    from peridem.meshfile import read_surface

    vertices, triangles = read_surface(path)
    try:
        return solid(name or Path(path).stem, Polyhedron(vertices, triangles))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


# Shapes that a radius alone describes, for command lines and tables; the others in their usual
# proportions.
NAMED: dict[str, Callable[[float], Shape]] = {
    "circle": circle,
    "ellipse": lambda r: ellipse(r, 0.6 * r),
    "hexagon": hexagon,
    "triangle": triangle,
    "drum": drum,
    "star": star,
    "rectangle": lambda r: rectangle(1.6 * r, 1.2 * r),
    "annulus": lambda r: annulus(0.75 * r, r, (0.3 * r, 0.15 * r)),
    "irregular": irregular,
    "sphere": sphere,
    "ellipsoid": lambda r: ellipsoid(r, 0.8 * r, 0.6 * r),
    "cuboid": lambda r: cuboid(*(2.0 * r / math.sqrt(3.0),) * 3),
    "cylinder": lambda r: cylinder(r / math.sqrt(2.0), math.sqrt(2.0) * r),
    "irregular_solid": irregular_solid,
}


def named(name: str, radius: float) -> Shape:
    """A shape by its name, sized by the circle or sphere around it.

    Raises:
        ValueError: there is none of this name; it says which there are.
    """
    if name not in NAMED:
        close = difflib.get_close_matches(name, NAMED, 1)
        hint = f" (did you mean {close[0]}?)" if close else ""
        raise ValueError(f"no shape '{name}'{hint}: one of {', '.join(NAMED)} needed")
    return NAMED[name](radius)


def _round(angle: NDArray[np.floating[Any]]) -> Array:
    return np.column_stack([np.cos(angle), np.sin(angle)])


def _check_spread(name: str, roughness: float, elongation: float) -> None:
    if not 0.0 <= roughness < 1.0:
        raise ValueError(f"{name}: roughness must be at least 0 and below 1, not {roughness}")
    if not (math.isfinite(elongation) and elongation >= 1.0):
        raise ValueError(f"{name}: elongation must be at least 1, not {elongation}")


def _spread_directions(n: int, random: np.random.Generator) -> Array:
    """Random unit vectors, (n, 3), none of them close to another: each the best of 20 draws."""
    chosen = np.empty((0, 3))
    for _ in range(n):
        draws = random.normal(size=(20, 3))
        draws /= np.linalg.norm(draws, axis=1)[:, None]
        nearest = (draws @ chosen.T).max(axis=1) if len(chosen) else np.zeros(20)
        chosen = np.vstack([chosen, draws[nearest.argmin()]])
    return chosen
