"""Outlines of grains in the plane: polygons and ellipses, with holes.

Lengths are in whatever unit the scene uses, angles in radians, counter-clockwise. Distances come
from GEOS through shapely. :mod:`peridem.shapes` makes the named ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Where an ellipse, or a circle with holes, must become a polygon to measure distances, it has so
# many sides and contains the curve (holes and rooms: lies inside it): distances come out too small
# by at most 1/cos(pi/240) - 1 = 9e-5 of the semi-axis, never too large.
SIDES = 240


@dataclass(frozen=True, eq=False)
class Outline:
    """A simple closed polygon or an ellipse, perhaps with holes.

    Attributes:
        name: what it is called in file names and messages.
        vertices: (n, 2) vertices in counter-clockwise order; for an ellipse its centre, (1, 2).
        axes: of an ellipse: (2, 2), its two semi-axes as columns, at right angles; None: a polygon.
        holes: outlines of the holes, which have none themselves.
        corner: (n,) which vertices of a polygon are corners that a mesh keeps, the others being
            points of a smooth curve; None: all.

    Raises:
        ValueError: fewer than three corners, corners that coincide, sides that cross, semi-axes
            that are not positive, holes outside or across each other, values that are not finite.
    """

    name: str
    vertices: Array
    axes: Array | None = None
    holes: tuple[Outline, ...] = ()
    corner: Flags | None = None

    def __post_init__(self) -> None:
        vertices = np.array(self.vertices, dtype=float)
        if vertices.ndim != 2 or vertices.shape[1] != 2 or not np.isfinite(vertices).all():
            raise ValueError(
                f"outline '{self.name}': vertices must be finite and of shape (n, 2), "
                f"not {vertices.shape}"
            )
        if self.axes is not None:
            self._check_ellipse(vertices)
        elif len(vertices) < 3:
            raise ValueError(f"outline '{self.name}': {len(vertices)} corners, at least 3 needed")
        else:
            vertices = self._checked_polygon(vertices)
        vertices.setflags(write=False)
        object.__setattr__(self, "vertices", vertices)
        self._check_holes()

    def _check_ellipse(self, vertices: Array) -> None:
        axes = np.array(self.axes, dtype=float)
        if vertices.shape != (1, 2) or axes.shape != (2, 2) or not np.isfinite(axes).all():
            raise ValueError(f"outline '{self.name}': an ellipse has one centre and two semi-axes")
        length = np.hypot(*axes)
        if np.linalg.det(axes) <= 0.0 or abs(axes[:, 0] @ axes[:, 1]) > 1e-9 * length.prod():
            raise ValueError(
                f"outline '{self.name}': semi-axes must be positive and at right angles, "
                f"the second counter-clockwise from the first, not {axes.T.tolist()}"
            )
        axes.setflags(write=False)
        object.__setattr__(self, "axes", axes)

    def _checked_polygon(self, vertices: Array) -> Array:
        sides = np.roll(vertices, -1, axis=0) - vertices
        size = np.ptp(vertices, axis=0).max()
        short = np.flatnonzero(np.hypot(*sides.T) <= 1e-9 * size)
        if len(short):
            raise ValueError(
                f"outline '{self.name}': corner {short[0] + 1} coincides with the next one"
            )
        if not shapely.is_valid(shapely.linearrings(vertices)):
            i, j = _crossing_sides(vertices)
            raise ValueError(f"outline '{self.name}': sides {i} and {j} cross each other")
        if self.corner is not None:
            corner = np.array(self.corner, dtype=bool)
            if corner.shape != (len(vertices),):
                raise ValueError(
                    f"outline '{self.name}': corner must say yes or no for each of the "
                    f"{len(vertices)} vertices, not have the shape {corner.shape}"
                )
            object.__setattr__(self, "corner", corner)
        if _signed_area(vertices) > 0:
            return vertices
        if self.corner is not None:
            object.__setattr__(self, "corner", self.corner[::-1].copy())
        return vertices[::-1].copy()

    def _check_holes(self) -> None:
        for k, hole in enumerate(self.holes, 1):
            if hole.holes:
                raise ValueError(f"outline '{self.name}': hole {k} has a hole itself")
            if self.shell.room_for(hole) <= 0.0:
                raise ValueError(f"outline '{self.name}': hole {k} is not inside the outline")
            for j, other in enumerate(self.holes[: k - 1], 1):
                if hole.distance(other) <= 0.0:
                    raise ValueError(f"outline '{self.name}': holes {j} and {k} meet")

    # ---- what it is ------------------------------------------------------------------------------

    @property
    def dimension(self) -> int:
        """2."""
        return 2

    @property
    def shell(self) -> Outline:
        """The outline without its holes."""
        return replace(self, holes=()) if self.holes else self

    @property
    def radius(self) -> float:
        """Of a circle; 0 for all others."""
        if self.axes is None:
            return 0.0
        one, two = np.hypot(*self.axes)
        return float(one) if math.isclose(one, two, rel_tol=1e-12) else 0.0

    @property
    def is_circle(self) -> bool:
        """Whether this is a circle without holes."""
        return self.radius > 0.0 and not self.holes

    @cached_property
    def _integrals(self) -> tuple[float, Array, Array]:
        """Area, first and second moments about the shell's first vertex or centre."""
        origin = self.vertices[0]
        area, first, second = _ring_integrals(self, origin)
        for hole in self.holes:
            a, f, s = _ring_integrals(hole, origin)
            area, first, second = area - a, first - f, second - s
        return area, first, second

    @property
    def area(self) -> float:
        """Enclosed area, without the holes."""
        return self._integrals[0]

    @property
    def measure(self) -> float:
        """The area, which is in the plane what a volume is in space."""
        return self.area

    @property
    def perimeter(self) -> float:
        """Length of the outline and of its holes."""
        return _ring_length(self) + sum(_ring_length(hole) for hole in self.holes)

    @property
    def centroid(self) -> Array:
        """Centre of area, (2,)."""
        area, first, _ = self._integrals
        return np.asarray(self.vertices[0] + first / area)

    @property
    def moments(self) -> Array:
        """Second moments of area about the centroid, the integral of (r - c)(r - c)', (2, 2)."""
        area, first, second = self._integrals
        return np.asarray(second - np.outer(first, first) / area)

    @property
    def inertia(self) -> float:
        """Polar moment of inertia about the centroid, for unit mass per area."""
        return float(np.trace(self.moments))

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Smallest and largest x, smallest and largest y."""
        extent = 0.0 if self.axes is None else np.hypot(*self.axes.T)
        low, high = self.vertices.min(axis=0) - extent, self.vertices.max(axis=0) + extent
        return float(low[0]), float(high[0]), float(low[1]), float(high[1])

    @property
    def extent(self) -> tuple[Array, Array]:
        """Lowest and highest corner of the box around it, (2,) each."""
        x_low, x_high, y_low, y_high = self.bounds
        return np.array([x_low, y_low]), np.array([x_high, y_high])

    @property
    def reach(self) -> float:
        """Largest distance of a point of the outline from the origin, or for an ellipse a bound."""
        away = float(np.hypot(*self.vertices.T).max())
        return away if self.axes is None else away + float(np.hypot(*self.axes).max())

    # ---- the same elsewhere ----------------------------------------------------------------------

    def placed(
        self, position: ArrayLike = (0.0, 0.0), angle: float = 0.0, scale: float = 1.0
    ) -> Outline:
        """The same outline scaled and turned about the origin, then moved by ``position``, (2,)."""
        _positive(self.name, "scale", scale)
        c, s = math.cos(angle), math.sin(angle)
        return self._mapped(scale * np.array([[c, -s], [s, c]]), np.asarray(position, dtype=float))

    def mirrored(self, axis: int = 0) -> Outline:
        """The mirror image: x (``axis`` 0) or y (1) changes sign."""
        matrix = np.eye(2)
        matrix[axis, axis] = -1.0
        image = self._mapped(matrix, np.zeros(2))
        return image._reversed()

    def _mapped(self, matrix: Array, shift: Array) -> Outline:
        axes = None if self.axes is None else matrix @ self.axes
        holes = tuple(hole._mapped(matrix, shift) for hole in self.holes)
        return self._as_valid(vertices=self.vertices @ matrix.T + shift, axes=axes, holes=holes)

    def _reversed(self) -> Outline:
        """Counter-clockwise again after a reflection."""
        return self._as_valid(
            vertices=self.vertices[::-1].copy(),
            axes=None if self.axes is None else self.axes * (1.0, -1.0),
            holes=tuple(hole._reversed() for hole in self.holes),
            corner=None if self.corner is None else self.corner[::-1].copy(),
        )

    def _as_valid(self, **changes: object) -> Outline:
        """A copy with changes that leave it valid: not checked again."""
        other = object.__new__(Outline)
        for what in ("name", "vertices", "axes", "holes", "corner"):
            value = changes.get(what, getattr(self, what))
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
            object.__setattr__(other, what, value)
        return other

    # ---- points ----------------------------------------------------------------------------------

    def boundary(self, spacing: float) -> Array:
        """Points along the outline, (n, 2), counter-clockwise, about ``spacing`` apart.

        A polygon keeps its corners, and what lies between two of them is divided evenly; an ellipse
        is divided evenly by arc length, so that the polygon through the points lies inside it.
        Holes are left to :meth:`rings`.
        """
        _positive(self.name, "spacing", spacing)
        if self.axes is not None:
            n = max(6, round(_ring_length(self) / spacing))
            return _on_ellipse(self.vertices[0], self.axes, _even_angles(self.axes, n))
        closed = np.vstack([self.vertices, self.vertices[:1]])
        corner = np.ones(len(self.vertices), dtype=bool) if self.corner is None else self.corner
        if not corner.any():
            return _divided(closed, max(6, round(_length(closed) / spacing)))
        first = int(np.flatnonzero(corner)[0])
        closed = np.vstack([np.roll(self.vertices, -first, axis=0), self.vertices[[first]]])
        ends = [*np.flatnonzero(np.roll(corner, -first)), len(self.vertices)]
        pieces = [closed[a : b + 1] for a, b in pairwise(ends)]
        return np.vstack([_divided(p, max(1, round(_length(p) / spacing))) for p in pieces])

    def rings(self, spacing: float) -> list[Array]:
        """Points along the outline and along each hole (clockwise), about ``spacing`` apart."""
        return [
            self.boundary(spacing),
            *(hole.boundary(spacing)[::-1].copy() for hole in self.holes),
        ]

    def contains(self, points: ArrayLike) -> Flags:
        """Whether each of the points, (n, 2), lies inside."""
        p = np.atleast_2d(np.asarray(points, dtype=float))
        if self.axes is not None:
            local = np.linalg.solve(self.axes, (p - self.vertices[0]).T)
            inside = np.hypot(*local) < 1.0
        else:
            inside = shapely.contains_xy(self._polygon, p[:, 0], p[:, 1])
        for hole in self.holes:
            inside &= ~hole.contains(p)
        return np.asarray(inside)

    # ---- distances -------------------------------------------------------------------------------

    @cached_property
    def _polygon(self) -> shapely.Polygon:
        """The shell as a polygon, a curve as one around it."""
        return shapely.Polygon(_around(self))

    @cached_property
    def _core(self) -> tuple[shapely.Geometry, float]:
        """A geometry, and how far the outline reaches beyond it: a circle is its centre."""
        if self.is_circle:
            return shapely.Point(self.vertices[0]), self.radius
        if self.holes:
            holes = [_within(hole) for hole in self.holes]
            return shapely.Polygon(_around(self), holes), 0.0
        return self._polygon, 0.0

    def distance(self, other: Outline) -> float:
        """Smallest distance between two outlines; 0 where they touch or overlap.

        Exact for polygons and circles; ellipses, and circles with holes, count as polygons around
        them (see ``SIDES``), so the distance is never too large.
        """
        one, beyond = self._core
        two, beyond_two = other._core
        return max(0.0, float(shapely.distance(one, two)) - beyond - beyond_two)

    def room_for(self, other: Outline) -> float:
        """Smallest distance of something inside from the outline; 0 where it reaches out."""
        room = shapely.Polygon(_within(self), [_around(hole) for hole in self.holes])
        core, beyond = other._core
        if not shapely.contains(room, core):
            return 0.0
        return max(0.0, float(shapely.distance(room.boundary, core)) - beyond)


def _positive(name: str, what: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise ValueError(f"{name}: {what} must be finite and above 0, not {value}")


def _signed_area(vertices: Array) -> float:
    a, b = vertices, np.roll(vertices, -1, axis=0)
    return 0.5 * float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())


def _crossing_sides(vertices: Array) -> tuple[int, int]:
    """Two sides of a polygon, counted from 1, that cross or touch without being neighbours."""
    n = len(vertices)
    sides = shapely.linestrings(np.stack([vertices, np.roll(vertices, -1, axis=0)], axis=1))
    i, j = np.triu_indices(n, 2)
    apart = ~((i == 0) & (j == n - 1))  # neighbours share a corner and do not count
    i, j = i[apart], j[apart]
    crossing = np.flatnonzero(shapely.intersects(sides[i], sides[j]))
    if not len(crossing):  # two neighbours that run back over each other
        back = [
            k for k in range(n) if sides[k].crosses(sides[k - 1]) or sides[k].overlaps(sides[k - 1])
        ]
        k = back[0] if back else 0
        return (k - 1) % n + 1, k + 1
    return int(i[crossing[0]]) + 1, int(j[crossing[0]]) + 1


def _ring_integrals(ring: Outline, origin: Array) -> tuple[float, Array, Array]:
    """Area, first (2,) and second (2, 2) moments about a point, holes left out."""
    if ring.axes is not None:
        area = math.pi * float(np.linalg.det(ring.axes))
        c = ring.vertices[0] - origin
        return area, area * c, 0.25 * area * ring.axes @ ring.axes.T + area * np.outer(c, c)
    a = ring.vertices - origin
    b = np.roll(a, -1, axis=0)
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    first = (cross[:, None] * (a + b)).sum(axis=0) / 6.0
    pairs = np.einsum("ni,nj->nij", a, a) + np.einsum("ni,nj->nij", b, b)
    pairs += np.einsum("ni,nj->nij", a + b, a + b)
    return 0.5 * float(cross.sum()), first, (cross[:, None, None] * pairs).sum(axis=0) / 24.0


def _ring_length(ring: Outline) -> float:
    if ring.axes is not None:
        from scipy.special import ellipe

        one, two = sorted(np.hypot(*ring.axes))
        return float(4.0 * two * ellipe(1.0 - (one / two) ** 2))
    return _length(np.vstack([ring.vertices, ring.vertices[:1]]))


def _length(points: Array) -> float:
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def _divided(points: Array, n: int) -> Array:
    """Points that divide a polyline into n parts of one length, without its end, (n, 2)."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    if len(points) == 2:
        return np.asarray(points[0] + (points[1] - points[0]) * (np.arange(n) / n)[:, None])
    at = along[-1] * np.arange(n) / n
    return np.column_stack([np.interp(at, along, x) for x in points.T])


def _even_angles(axes: Array, n: int) -> Array:
    """Parameters of n points of an ellipse that are equally far apart along it."""
    one, two = np.hypot(*axes)
    even = 2.0 * math.pi * np.arange(n) / n
    if math.isclose(one, two, rel_tol=1e-12):
        return even
    fine = np.linspace(0.0, 2.0 * math.pi, 4001)
    speed = np.hypot(one * np.sin(fine), two * np.cos(fine))
    along = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine))])
    return np.asarray(np.interp(even / (2.0 * math.pi) * along[-1], along, fine))


def _on_ellipse(centre: Array, axes: Array, angle: Array) -> Array:
    return np.asarray(centre + np.column_stack([np.cos(angle), np.sin(angle)]) @ axes.T)


def _around(ring: Outline) -> Array:
    """Vertices of a polygon that contains the shell; the shell itself if it is a polygon."""
    return ring.vertices if ring.axes is None else _sided(ring, 1.0 / math.cos(math.pi / SIDES))


def _within(ring: Outline) -> Array:
    """Vertices of a polygon inside the shell; the shell itself if it is a polygon."""
    return ring.vertices if ring.axes is None else _sided(ring, 1.0)


def _sided(ring: Outline, factor: float) -> Array:
    assert ring.axes is not None
    angle = 2.0 * math.pi * np.arange(SIDES) / SIDES
    return _on_ellipse(ring.vertices[0], factor * ring.axes, angle)
