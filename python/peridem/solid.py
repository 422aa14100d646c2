"""Solids: grains in space.

A :class:`Solid` is a form (ellipsoid, cylinder, polyhedron) and where it lies. Volume, centroid and
moments are exact; distances are those of polyhedra, from FCL. :mod:`peridem.shapes` makes the named
ones.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Triangles = NDArray[np.int64]

# Curved solids become polyhedra around them to measure distances: a cylinder with so many sides, an
# ellipsoid with SIDES^2/2 points. Distances come out too small, never too large: by 0.5 % of a
# cylinder's radius and 0.8 % of an ellipsoid's semi-axes at most.
SIDES = 32


class Form(ABC):
    """A form in its own position; all lengths are its own."""

    @property
    @abstractmethod
    def volume(self) -> float:
        """Enclosed volume."""

    @property
    @abstractmethod
    def centroid(self) -> Array:
        """Centre of volume, (3,)."""

    @property
    @abstractmethod
    def moments(self) -> Array:
        """Second moments about the centroid, (3, 3)."""

    @property
    @abstractmethod
    def reach(self) -> float:
        """Largest distance of a point of it from its origin."""

    @abstractmethod
    def half_extent(self, turn: Array) -> tuple[Array, Array]:
        """Lowest and highest corner of the box around it when turned by a rotation matrix."""

    @abstractmethod
    def contains(self, points: Array) -> Flags:
        """Whether each of the points, (n, 3), lies inside."""

    @abstractmethod
    def faces(self, outside: bool) -> tuple[Array, Triangles]:
        """Vertices and outward triangles of a polyhedron that contains it, or lies inside it."""

    @abstractmethod
    def mirrored(self) -> Form:
        """The mirror image in x."""


@dataclass(frozen=True, eq=False)
class Ellipsoid(Form):
    """An ellipsoid centred on the origin, its semi-axes along x, y and z."""

    semi_axes: tuple[float, float, float]

    @property
    def volume(self) -> float:
        """4/3 pi a b c."""
        return 4.0 / 3.0 * math.pi * math.prod(self.semi_axes)

    @property
    def centroid(self) -> Array:
        """The origin."""
        return np.zeros(3)

    @property
    def moments(self) -> Array:
        """V a^2/5 along each axis."""
        return np.diag(0.2 * self.volume * np.square(self.semi_axes))

    @property
    def reach(self) -> float:
        """The longest semi-axis."""
        return max(self.semi_axes)

    def half_extent(self, turn: Array) -> tuple[Array, Array]:
        """See :class:`Form`."""
        half = np.sqrt(np.square(turn) @ np.square(self.semi_axes))
        return -half, half

    def contains(self, points: Array) -> Flags:
        """See :class:`Form`."""
        return np.asarray(np.square(points / self.semi_axes).sum(axis=1) < 1.0)

    def faces(self, outside: bool) -> tuple[Array, Triangles]:
        """See :class:`Form`."""
        unit, triangles = _unit_sphere()
        corners = unit[triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        height = (corners[:, 0] * normal).sum(axis=1) / np.linalg.norm(normal, axis=1)
        # faces of the polyhedron through the sphere's points lie at this height and more
        factor = 1.0 / float(height.min()) if outside else 1.0
        return unit * factor * self.semi_axes, triangles

    def mirrored(self) -> Ellipsoid:
        """Itself."""
        return self


@dataclass(frozen=True, eq=False)
class Cylinder(Form):
    """A circular cylinder centred on the origin, its axis along z."""

    radius: float
    height: float

    @property
    def volume(self) -> float:
        """Pi r^2 h."""
        return math.pi * self.radius**2 * self.height

    @property
    def centroid(self) -> Array:
        """The origin."""
        return np.zeros(3)

    @property
    def moments(self) -> Array:
        """V r^2/4 across and V h^2/12 along the axis."""
        r2, h2 = self.radius**2 / 4.0, self.height**2 / 12.0
        return np.diag(self.volume * np.array([r2, r2, h2]))

    @property
    def reach(self) -> float:
        """Up to its rims."""
        return math.hypot(self.radius, 0.5 * self.height)

    def half_extent(self, turn: Array) -> tuple[Array, Array]:
        """See :class:`Form`."""
        along = turn[:, 2]
        across = np.sqrt(np.clip(1.0 - along**2, 0.0, None))
        half = 0.5 * self.height * np.abs(along) + self.radius * across
        return -half, half

    def contains(self, points: Array) -> Flags:
        """See :class:`Form`."""
        inside = np.hypot(points[:, 0], points[:, 1]) < self.radius
        return np.asarray(inside & (np.abs(points[:, 2]) < 0.5 * self.height))

    def faces(self, outside: bool) -> tuple[Array, Triangles]:
        """See :class:`Form`."""
        angle = 2.0 * math.pi * np.arange(SIDES) / SIDES
        r = self.radius / math.cos(math.pi / SIDES) if outside else self.radius
        ring = np.column_stack([r * np.cos(angle), r * np.sin(angle), np.zeros(SIDES)])
        up = np.array([0.0, 0.0, 0.5 * self.height])
        return _hull(np.vstack([ring - up, ring + up]))

    def mirrored(self) -> Cylinder:
        """Itself."""
        return self


@dataclass(frozen=True, eq=False)
class Polyhedron(Form):
    """A closed surface of triangles, their corners counter-clockwise seen from outside.

    Raises:
        ValueError: arrays of the wrong shape, a surface that is not closed or whose triangles do
            not agree about what is outside, or that encloses nothing; numbers count from 1.
    """

    vertices: Array
    triangles: Triangles

    def __post_init__(self) -> None:
        vertices = np.array(self.vertices, dtype=float)
        triangles = np.array(self.triangles, dtype=np.int64)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or not np.isfinite(vertices).all():
            raise ValueError(f"surface: finite vertices (n, 3) needed, not {vertices.shape}")
        if triangles.ndim != 2 or triangles.shape[1] != 3 or len(triangles) < 4:
            raise ValueError(f"surface: triangles (m, 3), 4 or more, needed, not {triangles.shape}")
        if triangles.min() < 0 or triangles.max() >= len(vertices):
            raise ValueError(f"surface: a triangle names a vertex not among the {len(vertices)}")
        _check_closed(triangles)
        if _surface_integrals(vertices, triangles)[0] < 0.0:
            triangles = triangles[:, ::-1].copy()
        if not self._volume_of(vertices, triangles) > 1e-12 * np.ptp(vertices, axis=0).max() ** 3:
            raise ValueError("surface: it encloses no volume")
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "triangles", triangles)

    @staticmethod
    def _volume_of(vertices: Array, triangles: Triangles) -> float:
        return _surface_integrals(vertices, triangles)[0]

    @cached_property
    def _integrals(self) -> tuple[float, Array, Array]:
        return _surface_integrals(self.vertices, self.triangles)

    @property
    def volume(self) -> float:
        """Enclosed, by the divergence theorem."""
        return self._integrals[0]

    @property
    def centroid(self) -> Array:
        """Centre of volume."""
        return self._integrals[1]

    @property
    def moments(self) -> Array:
        """About the centroid."""
        return self._integrals[2]

    @property
    def reach(self) -> float:
        """Up to the furthest vertex."""
        return float(np.linalg.norm(self.vertices, axis=1).max())

    def half_extent(self, turn: Array) -> tuple[Array, Array]:
        """See :class:`Form`."""
        turned = self.vertices @ turn.T
        return turned.min(axis=0), turned.max(axis=0)

    def contains(self, points: Array) -> Flags:
        """See :class:`Form`: the surface winds once around a point inside (solid angle 4 pi)."""
        inside = np.zeros(len(points), dtype=bool)
        step = max(1, 2_000_000 // len(self.triangles))  # memory: some 100 MB at once
        for first in range(0, len(points), step):
            part = points[first : first + step]
            inside[first : first + step] = _solid_angle(part, self.vertices[self.triangles]) > 6.0
        return inside

    def faces(self, outside: bool) -> tuple[Array, Triangles]:
        """The surface itself."""
        return self.vertices, self.triangles

    def mirrored(self) -> Polyhedron:
        """See :class:`Form`."""
        return Polyhedron(self.vertices * (-1.0, 1.0, 1.0), self.triangles[:, ::-1].copy())


@dataclass(frozen=True, eq=False)
class Solid:
    """A form and where it lies.

    Attributes:
        name: what it is called in file names and messages.
        form: its form.
        turn: (3, 3) rotation matrix.
        position: (3,) of the form's origin.
        scale: how much larger than its form it is.
    """

    name: str
    form: Form
    turn: Array
    position: Array
    scale: float = 1.0

    @property
    def dimension(self) -> int:
        """3."""
        return 3

    @property
    def radius(self) -> float:
        """Of a sphere; 0 for all others."""
        if isinstance(self.form, Ellipsoid):
            low, high = min(self.form.semi_axes), max(self.form.semi_axes)
            return self.scale * low if math.isclose(low, high, rel_tol=1e-12) else 0.0
        return 0.0

    @property
    def volume(self) -> float:
        """Enclosed volume."""
        return self.form.volume * self.scale**3

    @property
    def measure(self) -> float:
        """The volume, which is in space what an area is in the plane."""
        return self.volume

    @property
    def centroid(self) -> Array:
        """Centre of volume, (3,)."""
        return np.asarray(self.position + self.scale * self.turn @ self.form.centroid)

    @property
    def moments(self) -> Array:
        """Second moments about the centroid, the integral of (r - c)(r - c)' dV, (3, 3)."""
        return np.asarray(self.scale**5 * self.turn @ self.form.moments @ self.turn.T)

    @property
    def inertia(self) -> Array:
        """Inertia tensor about the centroid for unit density, (3, 3)."""
        return np.asarray(np.trace(self.moments) * np.eye(3) - self.moments)

    @property
    def extent(self) -> tuple[Array, Array]:
        """Lowest and highest corner of the box around it, (3,) each."""
        low, high = self.form.half_extent(self.turn)
        return self.position + self.scale * low, self.position + self.scale * high

    @property
    def reach(self) -> float:
        """Largest distance of a point of it from the origin, or a bound."""
        return float(np.linalg.norm(self.position)) + self.scale * self.form.reach

    def placed(
        self, position: ArrayLike = (0.0, 0.0, 0.0), angle: ArrayLike = 0.0, scale: float = 1.0
    ) -> Solid:
        """The same solid scaled and turned about the origin, then moved.

        Args:
            position: (3,) how far it is moved.
            angle: a rotation vector, (3,), along the axis and as long as the angle in radians; one
                number turns about z.
            scale: how much larger.
        """
        if not (math.isfinite(scale) and scale > 0.0):
            raise ValueError(f"{self.name}: scale must be finite and above 0, not {scale}")
        turn = rotation_matrix(angle, 3)
        moved = scale * turn @ self.position + np.asarray(position, dtype=float)
        return replace(self, turn=turn @ self.turn, position=moved, scale=scale * self.scale)

    def mirrored(self, axis: int = 0) -> Solid:
        """The mirror image: the coordinate ``axis`` (0 for x) changes sign."""
        flip = np.eye(3)
        flip[axis, axis] = -1.0
        local = np.diag([-1.0, 1.0, 1.0])  # the form's own mirror image
        return replace(
            self,
            form=self.form.mirrored(),
            turn=flip @ self.turn @ local,
            position=flip @ self.position,
        )

    def contains(self, points: ArrayLike) -> Flags:
        """Whether each of the points, (n, 3), lies inside."""
        p = np.atleast_2d(np.asarray(points, dtype=float))
        return self.form.contains((p - self.position) @ self.turn / self.scale)

    def surface(self, outside: bool = True) -> tuple[Array, Triangles]:
        """Vertices and outward triangles of a polyhedron around it, or inside it."""
        vertices, triangles = self.form.faces(outside)
        return self.scale * vertices @ self.turn.T + self.position, triangles

    # ---- distances -------------------------------------------------------------------------------

    @cached_property
    def _around(self) -> tuple[Array, Triangles]:
        return self.surface()

    @cached_property
    def _body(self) -> Any:
        return _fcl_body(*self._around)

    def distance(self, other: Solid) -> float:
        """Smallest distance between two solids; 0 where they touch or overlap.

        Exact for spheres and polyhedra. Ellipsoids and cylinders count as polyhedra around them
        (see ``SIDES``), so the distance is never too large.
        """
        if self.radius and other.radius:
            apart = float(np.linalg.norm(self.position - other.position))
            return max(0.0, apart - self.radius - other.radius)
        if other.radius:
            return other.distance(self)
        if self.radius:
            if other.contains(self.position)[0]:
                return 0.0
            return max(0.0, _point_to_triangles(self.position, *other._around) - self.radius)
        gap = _fcl_distance(self._body, other._body)
        if gap <= 0.0 or self.contains(other._around[0][:1])[0]:
            return 0.0
        return 0.0 if other.contains(self._around[0][:1])[0] else gap

    def room_for(self, other: Solid) -> float:
        """Smallest distance of something inside from the surface; 0 where it reaches out."""
        points = other.position[None] if other.radius else other._around[0]
        if not self.contains(points).all():
            return 0.0
        if other.radius:
            inner = self.surface(outside=False)
            return max(0.0, _point_to_triangles(other.position, *inner) - other.radius)
        return max(0.0, _fcl_distance(_fcl_body(*self.surface(outside=False)), other._body))


def solid(name: str, form: Form) -> Solid:
    """A form as it is, at the origin."""
    return Solid(name, form, np.eye(3), np.zeros(3))


def rotation_matrix(angle: ArrayLike, dimension: int) -> Array:
    """Rotation matrix, (d, d), of an angle about z, or in space of a rotation vector, (3,)."""
    vector = np.asarray(angle, dtype=float)
    if vector.shape not in ((), (3,)) or (dimension == 2 and vector.shape):
        raise ValueError(f"rotation: an angle, or in 3D a vector (3,), needed, not {angle!r}")
    if vector.shape == ():
        c, s = math.cos(float(vector)), math.sin(float(vector))
        about_z = np.eye(dimension)
        about_z[:2, :2] = [[c, -s], [s, c]]
        return about_z
    return np.asarray(Rotation.from_rotvec(vector).as_matrix())


def hull_of(points: ArrayLike) -> Polyhedron:
    """The convex hull of points, (n, 3)."""
    return Polyhedron(*_hull(np.asarray(points, dtype=float)))


def _hull(points: Array) -> tuple[Array, Triangles]:
    hull = ConvexHull(points)
    used = np.unique(hull.simplices)
    triangles = np.searchsorted(used, hull.simplices)
    vertices = points[used]
    corners = vertices[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = (normal * (corners[:, 0] - vertices.mean(axis=0))).sum(axis=1) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return vertices, triangles.astype(np.int64)


@lru_cache
def _unit_sphere() -> tuple[Array, Triangles]:
    """Points of the unit sphere, nearly equally spaced (Fibonacci), and their hull."""
    n = SIDES * SIDES // 2
    k = np.arange(n) + 0.5
    z, angle = 1.0 - 2.0 * k / n, math.pi * (1.0 + math.sqrt(5.0)) * k
    r = np.sqrt(1.0 - z**2)
    return _hull(np.column_stack([r * np.cos(angle), r * np.sin(angle), z]))


def _check_closed(triangles: Triangles) -> None:
    """Every side of a triangle belongs to exactly one other, which runs along it the other way."""
    sides = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    of = np.tile(np.arange(len(triangles)), 3)
    directed, first, count = np.unique(sides, axis=0, return_index=True, return_counts=True)
    if (count > 1).any():
        bad = of[first[count > 1][0]] + 1
        raise ValueError(
            f"surface: a side of triangle {bad} is used twice in one direction: triangles are "
            "given twice, meet three at a side, or disagree about what is outside"
        )
    backward = {(int(a), int(b)) for b, a in directed}
    lonely = [k for k, (a, b) in enumerate(directed) if (int(a), int(b)) not in backward]
    if lonely:
        bad = of[first[lonely[0]]] + 1
        raise ValueError(
            f"surface: not closed: {len(lonely)} sides, the first of triangle {bad}, have no "
            "neighbour"
        )


def _surface_integrals(vertices: Array, triangles: Triangles) -> tuple[float, Array, Array]:
    """Volume, centroid and second moments about it of what a closed surface encloses."""
    origin = vertices.mean(axis=0)
    corners = vertices[triangles] - origin
    det = np.linalg.det(corners)  # six times the volume of the tetrahedron with the origin
    total = corners.sum(axis=1)
    volume = float(det.sum()) / 6.0
    first = (det[:, None] * total).sum(axis=0) / 24.0
    pairs = np.einsum("nci,ncj->nij", corners, corners) + np.einsum("ni,nj->nij", total, total)
    second = (det[:, None, None] * pairs).sum(axis=0) / 120.0
    if volume == 0.0:
        return 0.0, origin, second
    return volume, origin + first / volume, second - np.outer(first, first) / volume


def _solid_angle(points: Array, corners: Array) -> Array:
    """Solid angle of a surface seen from points (van Oosterom & Strackee 1983, eq. 8), (n,)."""
    a, b, c = np.moveaxis(corners[None] - points[:, None, None], 2, 0)
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    top = (a * np.cross(b, c)).sum(axis=2)
    bottom = la * lb * lc + (a * b).sum(axis=2) * lc
    bottom += (b * c).sum(axis=2) * la + (c * a).sum(axis=2) * lb
    return np.asarray(2.0 * np.arctan2(top, bottom).sum(axis=1))


def _point_to_triangles(point: Array, vertices: Array, triangles: Triangles) -> float:
    """Smallest distance of a point from triangles."""
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    height = ((point - a) * normal).sum(axis=1)
    foot = point - height[:, None] * normal
    above = np.ones(len(a), dtype=bool)
    nearest = np.full(len(a), math.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        side = end - start
        above &= (np.cross(side, foot - start) * normal).sum(axis=1) >= 0.0
        along = ((point - start) * side).sum(axis=1) / (side**2).sum(axis=1)
        close = start + np.clip(along, 0.0, 1.0)[:, None] * side
        nearest = np.minimum(nearest, np.linalg.norm(point - close, axis=1))
    return float(np.where(above, np.abs(height), nearest).min())


def _fcl_body(vertices: Array, triangles: Triangles) -> Any:
    import fcl

    model = fcl.BVHModel()
    model.beginModel(len(vertices), len(triangles))
    model.addSubModel(vertices, triangles)
    model.endModel()
    return fcl.CollisionObject(model)


def _fcl_distance(one: Any, two: Any) -> float:
    import fcl

    gap = fcl.distance(one, two, fcl.DistanceRequest(), fcl.DistanceResult())
    return max(0.0, float(gap))
