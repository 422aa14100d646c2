"""Regions of space, as LAMMPS's ``region`` command knows them.

Each is written as commands (:meth:`Region.commands`) and can tell which points lie in it. Lengths
are those of the simulation (``units box``). In 2D the z direction is left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Rotation:
    """A rotation about a fixed axis.

    Attributes:
        rate: radians per time; counter-clockwise seen against the axis.
        point: on the axis, (2,) or (3,).
        axis: direction, any length; (0, 0, 1) in 2D.
        start, turned: of a wall: the time from which it turns, and its angle until then.
    """

    rate: float
    point: tuple[float, ...]
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    start: float = 0.0
    turned: float = 0.0

    def __post_init__(self) -> None:
        values = (self.rate, *self.point, *self.axis, self.start, self.turned)
        if not np.isfinite(values).all() or not any(self.axis):
            raise ValueError(f"rotation: finite values and an axis other than 0 needed, not {self}")

    @property
    def formula(self) -> str:
        """The angle, as a formula of LAMMPS's ``time``."""
        since = f"(time-{self.start:.12g})" if self.start else "time"
        return f"{self.rate:.12g}*{since}" + (f"+{self.turned:.12g}" if self.turned else "")

    @property
    def words(self) -> str:
        """Point and axis, as ``region ... rotate`` and ``fix move rotate`` take them."""
        return f"{numbers(self.point)} {numbers(self.axis)}"

    def before(self, points: Array) -> Array:
        """Points, (n, d), before they had turned by ``turned``."""
        if not self.turned:
            return points
        from scipy.spatial.transform import Rotation as Turn

        d = points.shape[1]
        centre = np.array((*self.point, 0.0)[:3])
        axis = np.array(self.axis) / np.linalg.norm(self.axis)
        arms = np.pad(points, ((0, 0), (0, 3 - d))) - centre
        back = Turn.from_rotvec(-self.turned * axis).apply(arms) + centre
        return np.asarray(back[:, :d])


class Region:
    """A region; ``inside`` says on which of its sides it lies."""

    inside: bool

    def contains(self, points: ArrayLike) -> Mask:
        """Which of the points, (n, d), lie in it; its surface counts."""
        within = self._within(np.atleast_2d(np.asarray(points, dtype=float)))
        return within if self.inside else ~within

    def commands(self, name: str, rotate: str = "") -> list[str]:
        """The ``region`` commands that define it.

        Args:
            name: its ID; parts get a number behind it.
            rotate: further words for every simple region (``rotate v_angle ...``).
        """
        side = "" if self.inside else " side out"
        return [f"region {name} {self._words()}{side} units box{rotate}"]

    @property
    def known(self) -> bool:
        """Whether :meth:`contains` knows its shape."""
        return True

    @property
    def corners(self) -> Array:
        """Points around its surface in the plane, (n, 2); none if it is not known."""
        return np.empty((0, 2))

    def described(self) -> dict[str, Any]:
        """What :func:`described_region` makes it from again; goes into JSON."""
        return {"kind": type(self).__name__, **asdict(self)}  # type: ignore[call-overload]

    def _within(self, points: Array) -> Mask:
        raise NotImplementedError

    def _words(self) -> str:
        raise NotImplementedError


@dataclass(frozen=True)
class Block(Region):
    """A rectangle or cuboid between two corners.

    Attributes:
        low, high: corners, (2,) or (3,).
        inside: whether the region is its inside.
        open: numbers of faces that are no walls: 1 2 low and high x, 3 4 y, 5 6 z.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    inside: bool = True
    open: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if len(self.low) != len(self.high) or len(self.low) not in (2, 3):
            raise ValueError(f"block: two corners of 2 or 3 numbers needed, not {self}")
        if not all(a < b for a, b in zip(self.low, self.high, strict=True)):
            raise ValueError(f"block: low must be below high, not {self.low} and {self.high}")

    def _within(self, points: Array) -> Mask:
        d = min(len(self.low), points.shape[1])
        above = points[:, :d] >= np.asarray(self.low[:d])
        return np.asarray((above & (points[:, :d] <= np.asarray(self.high[:d]))).all(axis=1))

    @property
    def corners(self) -> Array:
        """As :attr:`Region.corners`."""
        (x0, y0), (x1, y1) = self.low[:2], self.high[:2]
        return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], dtype=float)

    def _words(self) -> str:
        sides = [f"{a:.12g} {b:.12g}" for a, b in zip(self.low, self.high, strict=True)]
        return "block " + "  ".join([*sides, "INF INF"][:3])

    def commands(self, name: str, rotate: str = "") -> list[str]:
        """As :meth:`Region.commands`, with the open faces."""
        return [line + _open(self.open) for line in super().commands(name, rotate)]


@dataclass(frozen=True)
class Prism(Region):
    """A parallelogram or parallelepiped: a block whose upper sides are shifted.

    Attributes:
        low, high: corners of the block, (2,) or (3,).
        tilt: how far the side of high y is shifted along x, (xy,); in space also that of high z
            along x and y, (xy, xz, yz).
        inside: whether the region is its inside.
        open: numbers of faces that are no walls, as of :class:`Block`.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    tilt: tuple[float, ...]
    inside: bool = True
    open: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        d = len(self.low)
        if (d, len(self.high), len(self.tilt)) not in ((2, 2, 1), (3, 3, 3)):
            raise ValueError(
                "prism: two corners and tilts needed, of 2, 2 and 1 or of 3, 3 and 3 numbers, not "
                f"{self.low}, {self.high} and {self.tilt}"
            )
        if not all(a < b for a, b in zip(self.low, self.high, strict=True)):
            raise ValueError(f"prism: low must be below high, not {self.low} and {self.high}")
        if not np.isfinite((*self.low, *self.high, *self.tilt)).all():
            raise ValueError(f"prism: finite numbers needed, not {self}")

    @property
    def _edges(self) -> Array:
        """Edges from the lowest corner as rows, (d, d)."""
        edges = np.diag(np.subtract(self.high, self.low).astype(float))
        edges[1, 0] = self.tilt[0]
        if len(self.low) == 3:
            edges[2, :2] = self.tilt[1:]
        return edges

    def _within(self, points: Array) -> Mask:
        d = len(self.low)
        along = (points[:, :d] - np.asarray(self.low)) @ np.linalg.inv(self._edges)
        return np.asarray(((along >= 0.0) & (along <= 1.0)).all(axis=1))

    @property
    def corners(self) -> Array:
        """As :attr:`Region.corners`: of a parallelogram; of other prisms none."""
        if len(self.low) == 3:
            return np.empty((0, 2))
        round_ = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
        return np.asarray(np.asarray(self.low) + round_ @ self._edges)

    def _words(self) -> str:
        sides = [f"{a:.12g} {b:.12g}" for a, b in zip(self.low, self.high, strict=True)]
        return "prism " + "  ".join([*sides, "INF INF"][:3]) + "  " + numbers((*self.tilt, 0.0))

    def commands(self, name: str, rotate: str = "") -> list[str]:
        """As :meth:`Region.commands`, with the open faces."""
        return [line + _open(self.open) for line in super().commands(name, rotate)]


@dataclass(frozen=True)
class Cone(Region):
    """A part of a cone along an axis, in space: a hopper.

    Attributes:
        centre: of the circles, as of :class:`Cylinder`.
        radii: of the circles at the low and at the high end, at least one above 0.
        low, high: ends along the axis.
        axis: x, y or z.
        inside: whether the region is its inside.
        open: faces that are no walls: 1 low end, 2 high end, 3 the round one.
    """

    centre: tuple[float, float]
    radii: tuple[float, float]
    low: float
    high: float
    axis: str = "z"
    inside: bool = True
    open: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if self.axis not in ("x", "y", "z"):
            raise ValueError(f"cone: axis must be x, y or z, not '{self.axis}'")
        if not (np.isfinite(self.radii).all() and min(self.radii) >= 0.0 < max(self.radii)):
            raise ValueError(f"cone: two radii of at least 0, one above, needed, not {self.radii}")
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise ValueError(f"cone: low must be below high, not {self.low} and {self.high}")

    def _within(self, points: Array) -> Mask:
        along = "xyz".index(self.axis)
        across = [k for k in range(3) if k != along]
        part = (points[:, along] - self.low) / (self.high - self.low)
        radius = self.radii[0] + part * (self.radii[1] - self.radii[0])
        away = np.linalg.norm(points[:, across] - np.asarray(self.centre), axis=1)
        return np.asarray((part >= 0.0) & (part <= 1.0) & (away <= radius))

    def _words(self) -> str:
        values = (*self.centre, *self.radii, self.low, self.high)
        return f"cone {self.axis} " + " ".join(f"{v:.12g}" for v in values)

    def commands(self, name: str, rotate: str = "") -> list[str]:
        """As :meth:`Region.commands`, with the open faces."""
        return [line + _open(self.open) for line in super().commands(name, rotate)]


@dataclass(frozen=True)
class Cylinder(Region):
    """A circle in 2D, a cylinder along an axis in 3D.

    Attributes:
        centre: of the circle: (x, y) for axis z, (y, z) for x, (x, z) for y.
        radius: > 0.
        axis: x, y or z.
        low, high: ends along the axis; None: without end.
        inside: whether the region is its inside.
        open: faces that are no walls: 1 low end, 2 high end, 3 the round one.
    """

    centre: tuple[float, float]
    radius: float
    axis: str = "z"
    low: float | None = None
    high: float | None = None
    inside: bool = True
    open: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if self.axis not in ("x", "y", "z"):
            raise ValueError(f"cylinder: axis must be x, y or z, not '{self.axis}'")
        if not (math.isfinite(self.radius) and self.radius > 0.0):
            raise ValueError(f"cylinder: radius must be above 0, not {self.radius}")

    def _within(self, points: Array) -> Mask:
        along = "xyz".index(self.axis)
        across = [k for k in range(3) if k != along]
        away = np.linalg.norm(points[:, across] - np.asarray(self.centre), axis=1)
        mask = away <= self.radius
        if points.shape[1] == 3:
            low = -math.inf if self.low is None else self.low
            high = math.inf if self.high is None else self.high
            mask &= (points[:, along] >= low) & (points[:, along] <= high)
        return np.asarray(mask)

    @property
    def corners(self) -> Array:
        """As :attr:`Region.corners`: of a circle in the plane, not of other cylinders."""
        if self.axis != "z":
            return np.empty((0, 2))
        angle = np.linspace(0.0, 2.0 * math.pi, 49)
        round_ = np.column_stack([np.cos(angle), np.sin(angle)])
        return np.asarray(np.array(self.centre) + self.radius * round_)

    def _words(self) -> str:
        ends = [f"{v:.12g}" if v is not None else "INF" for v in (self.low, self.high)]
        c1, c2 = self.centre
        return f"cylinder {self.axis} {c1:.12g} {c2:.12g} {self.radius:.12g} {' '.join(ends)}"

    def commands(self, name: str, rotate: str = "") -> list[str]:
        """As :meth:`Region.commands`, with the open faces."""
        return [line + _open(self.open) for line in super().commands(name, rotate)]


@dataclass(frozen=True)
class Sphere(Region):
    """A sphere.

    Attributes:
        centre: (3,).
        radius: > 0.
        inside: whether the region is its inside.
    """

    centre: tuple[float, float, float]
    radius: float
    inside: bool = True

    def __post_init__(self) -> None:
        if not (math.isfinite(self.radius) and self.radius > 0.0):
            raise ValueError(f"sphere: radius must be above 0, not {self.radius}")

    def _within(self, points: Array) -> Mask:
        return np.asarray(np.linalg.norm(points - np.asarray(self.centre), axis=1) <= self.radius)

    def _words(self) -> str:
        return f"sphere {numbers(self.centre)} {self.radius:.12g}"


@dataclass(frozen=True)
class Combined(Region):
    """Several regions: all of them (``intersect``), or any (``union``)."""

    parts: tuple[Region, ...]
    how: str = "intersect"
    inside: bool = True

    def __post_init__(self) -> None:
        if self.how not in ("intersect", "union") or len(self.parts) < 2:
            raise ValueError("combined region: intersect or union of two or more parts needed")

    def _within(self, points: Array) -> Mask:
        masks = [part.contains(points) for part in self.parts]
        join = np.logical_and if self.how == "intersect" else np.logical_or
        return np.asarray(join.reduce(masks))

    @property
    def known(self) -> bool:
        """As :attr:`Region.known`."""
        return all(part.known for part in self.parts)

    @property
    def corners(self) -> Array:
        """As :attr:`Region.corners`: of the parts that grains are inside of, if there are any."""
        around = [part for part in self.parts if part.inside]
        return np.vstack([part.corners for part in around or self.parts])

    def described(self) -> dict[str, Any]:
        """As :meth:`Region.described`."""
        parts = [part.described() for part in self.parts]
        return {"kind": "Combined", "parts": parts, "how": self.how, "inside": self.inside}

    def commands(self, name: str, rotate: str = "") -> list[str]:
        """The parts, then what joins them."""
        names = [f"{name}_{k}" for k in range(1, len(self.parts) + 1)]
        lines = []
        for part, own in zip(self.parts, names, strict=True):
            lines += part.commands(own, rotate)
        side = "" if self.inside else " side out"
        return [*lines, f"region {name} {self.how} {len(names)} {' '.join(names)}{side}"]


@dataclass(frozen=True)
class OtherRegion(Region):
    """Any other style of LAMMPS, in its own words (``ellipsoid 0 0 0 1e-3 2e-3 3e-3``).

    Which points lie in it is not known here: :meth:`contains` says all.
    """

    text: str
    inside: bool = True

    @property
    def known(self) -> bool:
        """As :attr:`Region.known`: it is not."""
        return False

    def contains(self, points: ArrayLike) -> Mask:
        """Everything: the region is LAMMPS's."""
        return np.ones(len(np.atleast_2d(points)), dtype=bool)

    def _words(self) -> str:
        return self.text


def described_region(described: dict[str, Any]) -> Region:
    """The region that :meth:`Region.described` has told of.

    Raises:
        ValueError: no such kind of region.
    """
    kinds: dict[str, Callable[..., Region]] = {
        kind.__name__: kind
        for kind in (Block, Prism, Cone, Cylinder, Sphere, Combined, OtherRegion)
    }
    words = {k: tuple(v) if isinstance(v, list) else v for k, v in described.items()}
    kind = str(words.pop("kind", None))
    if kind not in kinds:
        raise ValueError(f"no region of kind '{kind}': one of {', '.join(kinds)} needed")
    if kind == "Combined":
        words["parts"] = tuple(described_region(part) for part in words["parts"])
    return kinds[kind](**words)


def _open(faces: tuple[int, ...]) -> str:
    return "".join(f" open {face}" for face in faces)


def numbers(values: Sequence[float]) -> str:
    """Three numbers with twelve digits; what a 2D vector lacks is 0."""
    return " ".join(f"{v + 0.0:.12g}" for v in (*values, 0.0)[:3])
