"""Outlines of grains in the plane.

An :class:`Outline` is a simple polygon, or a circle. Lengths are in whatever unit the scene uses,
angles in radians, counter-clockwise. The named shapes are centred on the origin and sized by the
radius of the circle around them, so that grains of one radius take about the same room.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Outline:
    """A simple closed polygon, or a circle.

    Attributes:
        name: what it is called in file names and messages.
        vertices: (n, 2) corners in counter-clockwise order; for a circle its centre, (1, 2).
        radius: of the circle; 0 for a polygon.

    Raises:
        ValueError: fewer than three corners, corners that coincide, sides that cross, a circle
            without a positive radius, or values that are not finite.
    """

    name: str
    vertices: Array
    radius: float = 0.0

    def __post_init__(self) -> None:
        vertices = np.array(self.vertices, dtype=float)
        if vertices.ndim != 2 or vertices.shape[1] != 2 or not np.isfinite(vertices).all():
            raise ValueError(
                f"outline '{self.name}': vertices must be finite and of shape (n, 2), "
                f"not {vertices.shape}"
            )
        if len(vertices) == 1:
            _positive(self.name, "radius", self.radius)
        elif len(vertices) < 3:
            raise ValueError(f"outline '{self.name}': {len(vertices)} corners, at least 3 needed")
        else:
            if self.radius != 0.0:
                raise ValueError(f"outline '{self.name}': a polygon has radius 0")
            vertices = self._checked_polygon(vertices)
        vertices.setflags(write=False)
        object.__setattr__(self, "vertices", vertices)

    def _checked_polygon(self, vertices: Array) -> Array:
        sides = np.roll(vertices, -1, axis=0) - vertices
        size = np.ptp(vertices, axis=0).max()
        short = np.flatnonzero(np.hypot(*sides.T) <= 1e-9 * size)
        if len(short):
            raise ValueError(
                f"outline '{self.name}': corner {short[0] + 1} coincides with the next one"
            )
        n = len(vertices)
        i, j = np.triu_indices(n, 2)
        apart = ~((i == 0) & (j == n - 1))  # neighbours share a corner and do not count
        i, j = i[apart], j[apart]
        end = np.roll(vertices, -1, axis=0)
        crossing = _segments_cross(vertices[i], end[i], vertices[j], end[j])
        if crossing.any():
            k = int(np.flatnonzero(crossing)[0])
            raise ValueError(
                f"outline '{self.name}': sides {i[k] + 1} and {j[k] + 1} cross each other"
            )
        return vertices if _signed_area(vertices) > 0 else vertices[::-1].copy()

    @property
    def is_circle(self) -> bool:
        """Whether this is a circle."""
        return len(self.vertices) == 1

    @property
    def area(self) -> float:
        """Enclosed area."""
        if self.is_circle:
            return math.pi * self.radius**2
        return _signed_area(self.vertices)

    @property
    def perimeter(self) -> float:
        """Length of the outline."""
        if self.is_circle:
            return 2.0 * math.pi * self.radius
        return float(np.hypot(*(np.roll(self.vertices, -1, axis=0) - self.vertices).T).sum())

    @property
    def centroid(self) -> Array:
        """Centre of area, (2,)."""
        if self.is_circle:
            return np.array(self.vertices[0])
        a, b = self.vertices, np.roll(self.vertices, -1, axis=0)
        cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        return np.asarray(((a + b) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum()))

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Smallest and largest x, smallest and largest y."""
        low = self.vertices.min(axis=0) - self.radius
        high = self.vertices.max(axis=0) + self.radius
        return float(low[0]), float(high[0]), float(low[1]), float(high[1])

    @property
    def reach(self) -> float:
        """Largest distance of a point of the outline from the origin."""
        return float(np.hypot(*self.vertices.T).max()) + self.radius

    def placed(
        self, position: ArrayLike = (0.0, 0.0), angle: float = 0.0, scale: float = 1.0
    ) -> Outline:
        """The same outline scaled and turned about the origin, then moved by ``position``, (2,)."""
        _positive(self.name, "scale", scale)
        c, s = math.cos(angle), math.sin(angle)
        vertices = scale * self.vertices @ np.array([[c, s], [-s, c]]) + np.asarray(position, float)
        vertices.setflags(write=False)
        placed = object.__new__(Outline)  # as valid as this one: not checked again
        for what, value in (
            ("name", self.name),
            ("vertices", vertices),
            ("radius", scale * self.radius),
        ):
            object.__setattr__(placed, what, value)
        return placed

    def boundary(self, spacing: float) -> Array:
        """Points along the outline, (n, 2), counter-clockwise, about ``spacing`` apart.

        A polygon keeps its corners and each side is divided evenly; a circle is divided evenly, so
        that the polygon through the points lies inside the circle.
        """
        _positive(self.name, "spacing", spacing)
        if self.is_circle:
            n = max(6, round(self.perimeter / spacing))
            angle = 2.0 * math.pi * np.arange(n) / n
            circle = np.column_stack([np.cos(angle), np.sin(angle)])
            return np.asarray(self.vertices[0] + self.radius * circle)
        points = []
        for a, b in zip(self.vertices, np.roll(self.vertices, -1, axis=0), strict=True):
            n = max(1, round(float(np.hypot(*(b - a))) / spacing))
            points.append(a + (b - a) * (np.arange(n) / n)[:, None])
        return np.vstack(points)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether each of the points, (n, 2), lies inside."""
        p = np.atleast_2d(np.asarray(points, dtype=float))
        if self.is_circle:
            return np.asarray(np.hypot(*(p - self.vertices[0]).T) < self.radius)
        a, b = self.vertices, np.roll(self.vertices, -1, axis=0)
        x, y = p[:, :1], p[:, 1:]
        straddles = (a[:, 1] > y) != (b[:, 1] > y)
        rise = np.where(b[:, 1] == a[:, 1], 1.0, b[:, 1] - a[:, 1])
        left_of = x < (b[:, 0] - a[:, 0]) * (y - a[:, 1]) / rise + a[:, 0]
        return np.asarray((straddles & left_of).sum(axis=1) % 2 == 1)

    def distance(self, other: Outline) -> float:
        """Smallest distance between the two outlines; 0 where they touch or overlap."""
        return max(0.0, _core_distance(self, other) - self.radius - other.radius)


def _positive(name: str, what: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise ValueError(f"{name}: {what} must be finite and above 0, not {value}")


def _signed_area(vertices: Array) -> float:
    a, b = vertices, np.roll(vertices, -1, axis=0)
    return 0.5 * float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())


def _segments_cross(a: Array, b: Array, c: Array, d: Array) -> NDArray[np.bool_]:
    """Whether the segments a-b and c-d, (n, 2) each, have a point in common inside both."""

    def side(p: Array, q: Array, r: Array) -> Array:
        u, v = q - p, r - p
        return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])

    return np.asarray((side(a, b, c) * side(a, b, d) < 0.0) & (side(c, d, a) * side(c, d, b) < 0.0))


def _points_to_segments(points: Array, a: Array, b: Array) -> Array:
    """Distance of each point (n, 2) from each segment a-b (m, 2): (n, m)."""
    along = b - a
    length2 = (along**2).sum(axis=1)
    t = ((points[:, None] - a) * along).sum(axis=2) / length2
    nearest = a + np.clip(t, 0.0, 1.0)[..., None] * along
    return np.asarray(np.sqrt(((points[:, None] - nearest) ** 2).sum(axis=2)))


def _core_distance(one: Outline, two: Outline) -> float:
    """Distance between polygons, a circle standing for its centre; 0 where they overlap."""
    p, q = one.vertices, two.vertices
    if one.is_circle and two.is_circle:
        return float(np.hypot(*(p[0] - q[0])))
    if two.is_circle:
        return _core_distance(two, one)
    if two.contains(p[:1])[0]:
        return 0.0
    q_end = np.roll(q, -1, axis=0)
    if one.is_circle:
        return float(_points_to_segments(p, q, q_end).min())
    if one.contains(q[:1])[0]:
        return 0.0
    p_end = np.roll(p, -1, axis=0)
    if _segments_cross(p[:, None], p_end[:, None], q[None], q_end[None]).any():
        return 0.0
    return float(
        min(_points_to_segments(p, q, q_end).min(), _points_to_segments(q, p, p_end).min())
    )


# ---- the named shapes ----------------------------------------------------------------------------


def circle(radius: float) -> Outline:
    """A circle."""
    return Outline("circle", np.zeros((1, 2)), radius)


def regular_polygon(sides: int, radius: float, first: float = 0.0, name: str = "") -> Outline:
    """A regular polygon in the circle of the given radius, its first corner at angle ``first``."""
    name = name or f"{sides}-gon"
    _positive(name, "radius", radius)
    if sides < 3:
        raise ValueError(f"{name}: {sides} sides, at least 3 needed")
    angle = first + 2.0 * math.pi * np.arange(sides) / sides
    return Outline(name, radius * np.column_stack([np.cos(angle), np.sin(angle)]))


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


def rectangle(width: float, height: float) -> Outline:
    """A rectangle centred on the origin."""
    _positive("rectangle", "width", width)
    _positive("rectangle", "height", height)
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    return Outline("rectangle", corners * (width, height))


def polygon(vertices: ArrayLike, name: str = "polygon") -> Outline:
    """A polygon through the given corners, (n, 2), in either sense of rotation."""
    return Outline(name, np.asarray(vertices, dtype=float))
