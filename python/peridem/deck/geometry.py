"""The geometries of a deck: names with lists of parameters."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from peridem.deck.source import Block
from peridem.regions import Region

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# How many parameters each may have; in a complex geometry each part has the largest number.
PARAMETERS: dict[str, tuple[int, ...]] = {
    "line": (1, 4, 6),
    "triangle": (1, 4, 7),
    "square": (1, 4, 6),
    "rectangle": (2, 5, 6),
    "hexagon": (1, 4, 7),
    "drum2d": (2, 5, 8),
    "cube": (1, 4, 6),
    "cuboid": (3, 6),
    "circle": (1, 4),
    "ellipse": (2, 5, 6),
    "sphere": (1, 4),
    "cylinder": (7, 8),
    "angled_rectangle": (6,),
    "angled_cuboid": (6,),
    "rectangle_minus_rectangle": (12,),
    "cuboid_minus_cuboid": (12,),
}
# in a complex geometry; an ellipse has 5 there
IN_COMPLEX = {kind: 5 if kind == "ellipse" else max(n) for kind, n in PARAMETERS.items()}
NEAR = 1e-12  # points this close to a side count as inside, as in PeriDEM


@dataclass(frozen=True)
class Shape(Region):
    """One geometry.

    Attributes:
        kind: its name.
        values: its parameters.
        parts: of a complex one: simple shapes, each with whether it is added (or taken away).
    """

    kind: str
    values: tuple[float, ...]
    parts: tuple[tuple[Shape, bool], ...] = ()
    inside: bool = field(default=True, init=False)

    @property
    def size(self) -> float | None:
        """The length that the radius of a particle stands for; None where there is none.

        Radius of round shapes and polygons, side of squares and cubes, length along x of
        rectangles and cuboids, first half-axis of ellipses.
        """
        if self.kind in ("rectangle", "angled_rectangle", "cuboid", "square", "cube"):
            low, high = self.bounds
            return float(high[0] - low[0])
        if self.kind in ("circle", "sphere", "hexagon", "triangle", "drum2d", "ellipse"):
            return self.values[0]
        return None

    @property
    def centre(self) -> Array:
        """Its middle, (3,)."""
        n, v = len(self.values), self.values
        first = {"rectangle": 2, "drum2d": 2, "ellipse": 2}.get(self.kind, 1)
        if self._corners:
            return np.asarray(0.5 * (np.array(v[0:3]) + np.array(v[3:6])))
        return np.asarray(v[first : first + 3] if n >= first + 3 else (0.0, 0.0, 0.0), dtype=float)

    @property
    def _corners(self) -> bool:
        """Whether the parameters are two corners."""
        boxes = ("rectangle", "square", "cube", "cuboid", "angled_rectangle", "angled_cuboid")
        return self.kind in boxes and len(self.values) == 6

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Low and high corner of the box around it, (3,) each."""
        if self.parts:
            boxes = [part.bounds for part, added in self.parts if added]
            return np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)
        v, c = self.values, self.centre
        if self._corners:
            a, b = np.array(v[0:3]), np.array(v[3:6])
            return np.minimum(a, b), np.maximum(a, b)
        if self.kind in ("rectangle_minus_rectangle", "cuboid_minus_cuboid"):
            return np.array(v[0:3]), np.array(v[3:6])
        half = {
            "rectangle": lambda: [v[0] / 2, v[1] / 2, 0.0],
            "cuboid": lambda: [x / 2 for x in v[:3]],
            "square": lambda: [v[0] / 2, v[0] / 2, 0.0],
            "cube": lambda: [v[0] / 2] * 3,
            "circle": lambda: [v[0], v[0], 0.0],
            "sphere": lambda: [v[0]] * 3,
            "ellipse": lambda: [max(v[:2])] * 2 + [0.0],
            "line": lambda: [v[0] / 2, 0.0, 0.0],
        }
        if self.kind in half:
            return c - np.array(half[self.kind]()), c + np.array(half[self.kind]())
        points = self._outline() if self.kind != "cylinder" else self._ends()
        return points.min(axis=0), points.max(axis=0)

    def _outline(self) -> Array:
        """Corners of a polygon, (n, 3)."""
        v, c = self.values, self.centre
        first = 5 if self.kind == "drum2d" else 4
        axis = np.array(v[first : first + 3]) if len(v) == first + 3 else np.array([1.0, 0.0, 0.0])
        start = math.atan2(axis[1], axis[0])
        if self.kind == "drum2d":
            radius = np.array([v[1], v[0], v[0], v[1], v[0], v[0]])
        else:
            radius = np.full(3 if self.kind == "triangle" else 6, v[0])
        angle = start + 2.0 * math.pi * np.arange(len(radius)) / len(radius)
        return np.asarray(
            c + np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0.0 * angle])
        )

    def _ends(self) -> Array:
        """Points around a cylinder, (n, 3)."""
        start, axis, radius = self._cylinder()
        ends = np.vstack([start, start + axis])
        return np.vstack([ends - radius, ends + radius])

    def _cylinder(self) -> tuple[Array, Array, float]:
        v = self.values
        if len(v) == 7:  # radius, begin, axis with its length
            return np.array(v[1:4]), np.array(v[4:7]), v[0]
        axis = np.array(v[5:8])  # radius, length, begin, axis
        return np.array(v[2:5]), v[1] * axis / np.linalg.norm(axis), v[0]

    def contains(self, points: ArrayLike) -> Mask:
        """Which of the points, (n, 2) or (n, 3), lie in it or on its surface."""
        x = np.atleast_2d(np.asarray(points, dtype=float))
        d = x.shape[1]
        if self.parts:
            inside: Mask = np.zeros(len(x), dtype=bool)
            for k, (part, added) in enumerate(self.parts):
                mine = part.contains(x)
                inside = mine if k == 0 else (inside | mine if added else inside & ~mine)
            return np.asarray(inside)
        if self.kind in ("circle", "sphere"):
            return np.asarray(np.linalg.norm(x - self.centre[:d], axis=1) <= self.values[0] + NEAR)
        if self.kind == "ellipse":
            return self._in_ellipse(x)
        if self.kind in ("triangle", "hexagon", "drum2d"):
            return self._in_polygon(x)
        if self.kind == "cylinder":
            return self._in_cylinder(x)
        low, high = self.bounds
        flat = 2 if self.kind in ("rectangle", "square", "angled_rectangle") else d
        if self.kind == "rectangle_minus_rectangle":
            flat = 2
        k = min(d, flat)
        within = (x[:, :k] >= low[:k] - NEAR) & (x[:, :k] <= high[:k] + NEAR)
        solid: Mask = np.asarray(within.all(axis=1))
        if self.kind.endswith(("_minus_rectangle", "_minus_cuboid")):
            a, b = np.array(self.values[6:9])[:k], np.array(self.values[9:12])[:k]
            hollow = ((x[:, :k] > a + NEAR) & (x[:, :k] < b - NEAR)).all(axis=1)
            solid &= ~hollow
        return solid

    def _in_ellipse(self, x: Array) -> Mask:
        turn = self.values[5] if len(self.values) == 6 else 0.0
        c, s = math.cos(turn), math.sin(turn)
        y = (x[:, :2] - self.centre[:2]) @ np.array([[c, -s], [s, c]])
        return np.asarray((y / np.array(self.values[:2])) ** 2 @ np.ones(2) <= 1.0 + NEAR)

    def _in_polygon(self, x: Array) -> Mask:
        outline = shapely.Polygon(self._outline()[:, :2]).buffer(NEAR, join_style="mitre")
        return np.asarray(shapely.intersects_xy(outline, x[:, 0], x[:, 1]))

    def _in_cylinder(self, x: Array) -> Mask:
        start, axis, radius = self._cylinder()
        x = np.pad(x, ((0, 0), (0, 3 - x.shape[1])))  # in 2D what the plane z = 0 cuts
        length = float(np.linalg.norm(axis))
        along = (x - start) @ axis / length
        across = np.linalg.norm(x - start - along[:, None] * axis / length, axis=1)
        return np.asarray((along >= -NEAR) & (along <= length + NEAR) & (across <= radius + NEAR))

    def commands(self, name: str, rotate: str = "") -> list[str]:
        """Not written as a region: its nodes are named one by one."""
        raise NotImplementedError(f"{self.kind} as a region {name}")


def shape(block: Block) -> Shape:
    """The geometry of a block with ``Type`` and ``Parameters``.

    Raises:
        DeckError: an unknown name, or a wrong number of parameters.
    """
    kind = block.choice("Type", (*PARAMETERS, "complex"))
    values = block.numbers("Parameters")
    if kind != "complex":
        if len(values) not in PARAMETERS[kind]:
            numbers = " or ".join(map(str, PARAMETERS[kind]))
            raise block.error("Parameters", f"{kind} has {numbers} of them, not {len(values)}")
        _check_size(block, kind, values)
        return Shape(kind, tuple(values))
    kinds, flags = block.words("Vec_Type"), block.words("Vec_Flag")
    known: dict[str, tuple[list[str], tuple[str, ...]]] = {
        "Vec_Type": (kinds, tuple(PARAMETERS)),
        "Vec_Flag": (flags, ("plus", "minus")),
    }
    for key, (words, allowed) in known.items():
        for word in words:
            if word not in allowed:
                raise block.error(key, f"must be of {', '.join(allowed)}, not '{word}'")
    if not kinds or len(kinds) != len(flags):
        raise block.error("Vec_Type", f"{len(kinds)} types with {len(flags)} flags in Vec_Flag")
    counts = [IN_COMPLEX[kind] for kind in kinds]
    if sum(counts) != len(values):
        each = ", ".join(f"{k} {n}" for k, n in zip(kinds, counts, strict=True))
        raise block.error("Parameters", f"{sum(counts)} of them needed ({each}), not {len(values)}")
    parts, at = [], 0
    for one, count, flag in zip(kinds, counts, flags, strict=True):
        parts.append((Shape(one, tuple(values[at : at + count])), flag == "plus"))
        at += count
    return Shape("complex", tuple(values), tuple(parts))


def _check_size(block: Block, kind: str, values: list[float]) -> None:
    """The first parameter of shapes with a radius or a length must be above 0."""
    sized = len(values) in (1, 2, 4, 5, 7, 8) or kind in ("drum2d", "ellipse")
    if sized and not values[0] > 0.0:
        raise block.error("Parameters", f"{kind}: its size must be above 0, not {values[0]:g}")
