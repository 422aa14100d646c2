"""What packings are made with: the container, and the grains placed in it so far."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from peridem.outline import Outline
from peridem.solid import Solid

Array = NDArray[np.float64]
Image = tuple[int, Array]  # number of a grain, and how far this image of it is moved


@dataclass(frozen=True, eq=False)
class Container:
    """Where grains may be: a box, some sides of which may be periodic, or the inside of a shape.

    Attributes:
        low: (d,) lowest corner.
        high: (d,) highest corner.
        periodic: (d,) for each axis whether what leaves on one side enters on the other.
        inside: a shape within which grains must stay as well, such as a drum's hole.

    Raises:
        ValueError: corners that are not finite or in the wrong order, or a periodic axis with
            a shape.
    """

    low: Array
    high: Array
    periodic: tuple[bool, ...] = ()
    inside: Outline | Solid | None = None

    def __post_init__(self) -> None:
        low, high = np.array(self.low, dtype=float), np.array(self.high, dtype=float)
        periodic = tuple(self.periodic) or (False,) * len(low)
        if len(low) not in (2, 3) or low.shape != high.shape or len(periodic) != len(low):
            raise ValueError(
                f"packing: a container needs corners of 2 or 3 coordinates, not {low} and {high}"
            )
        if not (np.isfinite(low).all() and np.isfinite(high).all() and (low < high).all()):
            names = ", ".join(f"{k}_low, {k}_high" for k in "xyz"[: len(low)])
            raise ValueError(
                f"packing: box must be {names}, each low below its high, not "
                f"{low.tolist()} to {high.tolist()}"
            )
        if self.inside is not None and (any(periodic) or self.inside.dimension != len(low)):
            raise ValueError(
                "packing: a container within a shape has its dimension, no periodic axis"
            )
        for what, value in (("low", low), ("high", high), ("periodic", periodic)):
            object.__setattr__(self, what, value)

    def __str__(self) -> str:
        sides = ", ".join(f"{a:g} to {b:g}" for a, b in zip(self.low, self.high, strict=True))
        return f"{sides}{'' if self.inside is None else f' within {self.inside.name}'}"

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return len(self.low)

    @property
    def measure(self) -> float:
        """Area or volume, of the shape if there is one."""
        if self.inside is not None:
            return self.inside.measure
        return float(np.prod(self.high - self.low))

    def room(self, turned: Outline | Solid, padding: float) -> tuple[Array, Array]:
        """Lowest and highest position of a shape that keep it ``padding`` inside the box."""
        low, high = turned.extent
        free = np.array(self.periodic)
        return (
            np.where(free, self.low, self.low - low + padding),
            np.where(free, self.high, self.high - high - padding),
        )

    def gap(self, placed: Outline | Solid) -> float:
        """Smallest distance of a shape from the boundary; 0 or below if it reaches out."""
        low, high = placed.extent
        sides = np.concatenate([low - self.low, self.high - high])
        fixed = ~np.tile(np.array(self.periodic), 2)
        gap = float(sides[fixed].min()) if fixed.any() else math.inf
        if self.inside is None:
            return gap
        return min(gap, self.inside.room_for(placed))  # type: ignore[arg-type]

    def slab(self, low: float, high: float) -> Container:
        """The part between two heights (along the last axis)."""
        one, two = self.low.copy(), self.high.copy()
        one[-1], two[-1] = low, high
        return Container(one, two, (*self.periodic[:-1], False), self.inside)

    def shifts(self) -> list[Array]:
        """How far the images of a grain are moved: by nothing, and across each periodic side."""
        steps = [(0, -1, 1) if p else (0,) for p in self.periodic]
        return [np.array(s) * (self.high - self.low) for s in product(*steps)]


def container(box: Sequence[float] | Container) -> Container:
    """A container from x_low, x_high, y_low, y_high (and z_low, z_high)."""
    if isinstance(box, Container):
        return box
    if len(box) not in (4, 6):
        raise ValueError(
            f"packing: box must be x_low, x_high, y_low, y_high (z_low, z_high), not {box!r}"
        )
    return Container(np.array(box[::2]), np.array(box[1::2]))


def container_inside(shape: Outline | Solid) -> Container:
    """The inside of a shape; of an outline with a hole, such as a drum's wall, the hole."""
    if isinstance(shape, Outline) and shape.holes:
        shape = shape.holes[0]
    low, high = shape.extent
    return Container(low, high, (), shape)


class Placed:
    """Shapes placed so far, with the balls around them, to ask only near ones for distances."""

    def __init__(self, within: Container | None, dimension: int) -> None:
        self.shapes: list[Outline | Solid] = []
        self._shifts = [np.zeros(dimension)] if within is None else within.shifts()
        self._centre = np.empty((16, dimension))
        self._radius = np.empty(16)
        self._low, self._high = np.empty((16, dimension)), np.empty((16, dimension))

    def add(self, placed: Outline | Solid, centre: ArrayLike, radius: float) -> None:
        """One more, within a radius of a centre."""
        n = len(self.shapes)
        if n == len(self._radius):
            for what in ("_centre", "_radius", "_low", "_high"):
                setattr(self, what, np.concatenate([getattr(self, what)] * 2))
        self._centre[n], self._radius[n] = centre, radius
        self._low[n], self._high[n] = placed.extent
        self.shapes.append(placed)

    def near(self, centre: Array, radius: float, within: float) -> list[Image]:
        """Images that may be closer than ``within`` to something in a ball, likely ones first."""
        n, found = len(self.shapes), []
        for shift in self._shifts:
            away = np.linalg.norm(self._centre[:n] + shift - centre, axis=1)
            gap = away - self._radius[:n] - radius
            found += [(float(gap[j]), int(j), shift) for j in np.flatnonzero(gap < within)]
        return [(j, shift) for _, j, shift in sorted(found, key=lambda f: f[0])]

    def clear(self, placed: Outline | Solid, centre: Array, radius: float, padding: float) -> bool:
        """Whether all are at least ``padding`` away."""
        images = self.near(centre, radius, padding)
        return all(self._distance(placed, image) >= padding for image in images)

    def gap(
        self, placed: Outline | Solid, centre: Array, radius: float, among: Sequence[Image]
    ) -> float:
        """Smallest distance to the given images; inf if there are none."""
        best = math.inf
        least = [
            float(np.linalg.norm(self._centre[j] + shift - centre)) - self._radius[j] - radius
            for j, shift in among
        ]
        for k in np.argsort(least, kind="stable"):
            if least[k] >= best:
                break  # the balls around the others are further away already
            best = min(best, self._distance(placed, among[k]))
        return best

    def under(self, low: Array, high: Array, padding: float) -> list[Image]:
        """Images that something of this extent may meet as it falls along the last axis."""
        n, found = len(self.shapes), []
        for shift in self._shifts:
            apart = (self._low[:n] + shift > high + padding) | (
                self._high[:n] + shift < low - padding
            )
            found += [(int(j), shift) for j in np.flatnonzero(~apart[:, :-1].any(axis=1))]
        return found

    def top(self, image: Image) -> float:
        """Highest point of an image along the last axis."""
        return float(self._high[image[0], -1] + image[1][-1])

    def _distance(self, placed: Outline | Solid, image: Image) -> float:
        j, shift = image
        seen = placed.placed(position=-shift) if shift.any() else placed
        return seen.distance(self.shapes[j])  # type: ignore[arg-type]


@dataclass(frozen=True)
class Sizes:
    """A distribution of sizes: of the factor by which a shape is scaled.

    Make one with :meth:`uniform`, :meth:`normal`, :meth:`lognormal` or :meth:`table`.
    """

    kind: str
    values: tuple[float, ...]
    shares: tuple[float, ...] = ()
    low: float = 0.0
    high: float = math.inf

    @staticmethod
    def uniform(low: float, high: float) -> Sizes:
        """All sizes between two alike (by number of grains)."""
        return Sizes._checked("uniform", (low, high), (), low, high)

    @staticmethod
    def normal(mean: float, deviation: float, low: float = 0.0, high: float = math.inf) -> Sizes:
        """A normal distribution, drawn again where it falls outside low to high."""
        return Sizes._checked("normal", (mean, deviation), (), low, high)

    @staticmethod
    def lognormal(
        median: float, deviation: float, low: float = 0.0, high: float = math.inf
    ) -> Sizes:
        """The logarithm is normal, with this deviation; drawn again outside low to high."""
        return Sizes._checked("lognormal", (median, deviation), (), low, high)

    @staticmethod
    def table(sizes: Sequence[float], shares: Sequence[float]) -> Sizes:
        """Some sizes, each with its share in the number of grains."""
        if len(sizes) != len(shares) or not all(s >= 0.0 for s in shares) or sum(shares) <= 0.0:
            raise ValueError(f"sizes: a share for each of {list(sizes)} needed, not {list(shares)}")
        return Sizes._checked("table", tuple(sizes), tuple(shares))

    @staticmethod
    def _checked(
        kind: str,
        values: tuple[float, ...],
        shares: tuple[float, ...],
        low: float = 0.0,
        high: float = math.inf,
    ) -> Sizes:
        if not (np.isfinite(values).all() and min(values) > 0.0 and 0.0 <= low <= high):
            raise ValueError(
                f"sizes: {kind} with {list(values)}, from {low:g} to {high:g}: numbers above 0, "
                "low up to high, needed"
            )
        return Sizes(kind, values, shares, low, high)

    def draw(self, n: int, random: np.random.Generator) -> Array:
        """Sizes of n grains, (n,)."""
        drawn: Array = np.empty(0)
        for _ in range(1000):
            drawn = np.concatenate([drawn, self._draw(n, random)])
            drawn = drawn[(drawn > 0.0) & (drawn >= self.low) & (drawn <= self.high)]
            if len(drawn) >= n:
                return drawn[:n]
        raise ValueError(
            f"sizes: {self.kind} {self.values} is hardly ever {self.low} to {self.high}"
        )

    def _draw(self, n: int, random: np.random.Generator) -> Array:
        if self.kind == "uniform":
            return random.uniform(self.values[0], self.values[1], n)
        if self.kind == "normal":
            return random.normal(self.values[0], self.values[1], n)
        if self.kind == "lognormal":
            return np.asarray(self.values[0] * np.exp(random.normal(0.0, self.values[1], n)))
        share = np.array(self.shares) / sum(self.shares)
        return np.asarray(random.choice(self.values, n, p=share), dtype=float)


Orientation = str | float


def check_orientation(orientation: Orientation) -> None:
    """Refuse what :func:`turn` does not know."""
    if isinstance(orientation, str):
        if orientation in ("random", "fixed"):
            return
    elif math.isfinite(orientation) and orientation >= 0.0:
        return
    raise ValueError(
        "packing: orientation must be 'random', 'fixed' or a deviation in radians, "
        f"not {orientation!r}"
    )


def turn(orientation: Orientation, dimension: int, random: np.random.Generator) -> ArrayLike:
    """An angle, or in space a rotation vector, (3,).

    Args:
        orientation: "random" (all alike), "fixed" (as the shape is drawn) or the standard deviation
            of the angle (of each component of the rotation vector) from that, in radians.
        dimension: 2 or 3.
        random: where from.
    """
    if orientation == "random":
        if dimension == 2:
            return float(random.uniform(0.0, 2.0 * math.pi))
        quaternion = random.normal(size=4)  # uniform on the sphere: uniform rotations
        return np.asarray(Rotation.from_quat(quaternion).as_rotvec())
    if orientation == "fixed":
        return 0.0 if dimension == 2 else np.zeros(3)
    if dimension == 2:
        return float(random.normal(0.0, float(orientation)))
    return random.normal(0.0, float(orientation), 3)
