"""Where the grains go.

A :class:`Packing` is a table: which outline, where, how large, how turned. Every function here
returns one in which any two outlines, and any outline and the box, are at least ``padding`` apart
by their true distance, so that no two nodes start closer than the contact radius; give that as the
padding. A seed makes each result repeatable.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from peridem.shapes import Outline

Array = NDArray[np.float64]
Box = tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class Packing:
    """Grains as rows of a table.

    Attributes:
        outlines: the outlines that ``kind`` counts, from 0.
        kind: (n,) which outline each grain has.
        position: (n, 2) where the origin of its outline goes.
        angle: (n,) how far it is turned, radians.
        scale: (n,) how much larger than its outline it is.
    """

    outlines: tuple[Outline, ...]
    kind: NDArray[np.int64]
    position: Array
    angle: Array
    scale: Array

    def __post_init__(self) -> None:
        n = len(self.kind)
        shapes = (self.position.shape, self.angle.shape, self.scale.shape)
        if shapes != ((n, 2), (n,), (n,)):
            raise ValueError(f"packing of {n} grains with arrays of the shapes {shapes}")
        if n and (self.kind.min() < 0 or self.kind.max() >= len(self.outlines)):
            raise ValueError(
                f"packing: kinds {self.kind.min()} to {self.kind.max()} "
                f"with {len(self.outlines)} outlines (counted from 0)"
            )

    def __len__(self) -> int:
        return len(self.kind)

    def outline(self, i: int) -> Outline:
        """The outline of grain i where it lies."""
        outline = self.outlines[int(self.kind[i])]
        return outline.placed(self.position[i], self.angle[i], self.scale[i])

    @property
    def area(self) -> float:
        """Area of all grains together."""
        areas = np.array([outline.area for outline in self.outlines])
        return float((areas[self.kind] * self.scale**2).sum())

    def smallest_gap(self) -> tuple[float, int, int]:
        """Smallest distance of two grains (0 where they overlap) and which two; inf if one only."""
        placed = [self.outline(i) for i in range(len(self))]
        best = (math.inf, -1, -1)
        near = _Neighbours()
        for i in range(len(self)):
            for j in near.of(self.position[i], placed[i], best[0]):
                if j < i:
                    gap = placed[i].distance(placed[j])
                    if gap < best[0]:
                        best = (gap, j, i)
            near.add(self.position[i], placed[i])
        return best

    def check(self, padding: float, box: Box | None = None) -> Packing:
        """The packing itself, if grains (and grains and box) are at least ``padding`` apart.

        Raises:
            ValueError: two grains, or a grain and the box, are closer; it says which (from 1).
        """
        gap, i, j = self.smallest_gap()
        if gap < padding * (1.0 - 1e-9):
            raise ValueError(
                f"packing: grains {i + 1} and {j + 1} are {gap:g} apart, not {padding:g} as needed"
            )
        if box is not None:
            for k in range(len(self)):
                wall = _gap_to_box(self.outline(k), box)
                if wall < padding * (1.0 - 1e-9):
                    raise ValueError(
                        f"packing: grain {k + 1} is {wall:g} inside the box {box}, "
                        f"at least {padding:g} needed"
                    )
        return self


def table(
    outlines: Sequence[Outline],
    rows: ArrayLike | str | Path,
    padding: float,
    box: Box | None = None,
) -> Packing:
    """A given table: an array, (n, 5), or a comma-separated file with a line of headings.

    Columns: kind (from 0), x, y, scale, angle in radians.

    Raises:
        ValueError: a wrong number of columns, or grains that are too close (:meth:`Packing.check`).
    """
    if isinstance(rows, str | Path):
        data = np.loadtxt(rows, delimiter=",", skiprows=1, ndmin=2)
    else:
        data = np.atleast_2d(np.asarray(rows, dtype=float))
    if data.ndim != 2 or data.shape[1] != 5:
        raise ValueError(f"packing table: columns kind x y scale angle needed, not {data.shape}")
    if not np.isfinite(data).all():
        raise ValueError("packing table: values that are not finite")
    packing = Packing(
        tuple(outlines), data[:, 0].astype(np.int64), data[:, 1:3], data[:, 4], data[:, 3]
    )
    return packing.check(padding, box)


def grid(
    outlines: Sequence[Outline],
    kind: ArrayLike,
    box: Box,
    padding: float,
    jitter: float = 0.0,
    seed: int = 1,
) -> Packing:
    """One grain in each cell of a square grid, row by row from the lower left, turned at random.

    Args:
        outlines: the outlines.
        kind: (n,) which outline each grain has.
        box: x_low, x_high, y_low, y_high.
        padding: smallest gap between grains, and between grains and box.
        jitter: how far each grain leaves the middle of its cell, over the room there, 0 to 1.
        seed: of the random numbers.

    Raises:
        ValueError: the grid does not fit the box.
    """
    outlines, kinds = _checked(outlines, kind, box, padding)
    if not 0.0 <= jitter <= 1.0:
        raise ValueError(f"grid packing: jitter must lie in 0 to 1, not {jitter}")
    random = np.random.default_rng(seed)
    reach = np.array([outline.reach for outline in outlines])[kinds]
    room = np.array([box[1] - box[0], box[3] - box[2]]) - padding
    pitch = 2.0 * reach.max() + padding
    columns = int(room[0] / pitch * (1 + 1e-12))
    rows = math.ceil(len(kinds) / columns) if columns else 0
    if columns == 0 or rows * pitch > room[1] * (1 + 1e-12):
        fit = columns * int(room[1] / pitch * (1 + 1e-12))
        raise ValueError(
            f"grid packing: {len(kinds)} grains of radius up to {reach.max():g} asked for, "
            f"{fit} fit into the box {box}"
        )
    cell = np.array([room[0] / columns, pitch])
    n = np.arange(len(kinds))
    corner = np.array([box[0], box[2]]) + 0.5 * padding
    middle = corner + (np.column_stack([n % columns, n // columns]) + 0.5) * cell
    free = np.clip(0.5 * (cell - padding) - reach[:, None], 0.0, None)
    position = middle + jitter * free * random.uniform(-1.0, 1.0, (len(n), 2))
    angle = random.uniform(0.0, 2.0 * math.pi, len(n))
    return Packing(outlines, kinds, position, angle, np.ones(len(n))).check(padding, box)


def random_sequential(
    outlines: Sequence[Outline],
    kind: ArrayLike,
    box: Box,
    padding: float,
    seed: int = 1,
    attempts: int = 2000,
) -> Packing:
    """Grains thrown in one by one at random places, the largest first, kept where they fit.

    Args:
        outlines: the outlines.
        kind: (n,) which outline each grain has.
        box: x_low, x_high, y_low, y_high.
        padding: smallest gap between grains, and between grains and box.
        seed: of the random numbers.
        attempts: how often a place is sought for each grain.

    Raises:
        ValueError: no place found for a grain; it says how many fitted and how full the box was.
    """
    outlines, kinds = _checked(outlines, kind, box, padding)
    random = np.random.default_rng(seed)
    reach = np.array([outline.reach for outline in outlines])[kinds]
    position, angle = np.zeros((len(kinds), 2)), np.zeros(len(kinds))
    near, filled = _Neighbours(), 0.0
    for done, i in enumerate(np.argsort(-reach, kind="stable")):
        outline = outlines[kinds[i]]
        for _ in range(attempts):
            angle[i] = random.uniform(0.0, 2.0 * math.pi)
            turned = outline.placed(angle=angle[i])
            low, high = _free_room(turned, box, padding)
            if (high < low).any():
                continue
            position[i] = random.uniform(low, high)
            placed = turned.placed(position[i])
            if near.clear(position[i], placed, padding):
                break
        else:
            raise ValueError(
                f"random sequential packing: no place for grain {done + 1} of {len(kinds)} in "
                f"{attempts} attempts; those before fill {filled / _area(box):.0%} of the box {box}"
            )
        near.add(position[i], placed)
        filled += outline.area
    return Packing(outlines, kinds, position, angle, np.ones(len(kinds)))


def deposited(
    outlines: Sequence[Outline],
    kind: ArrayLike,
    box: Box,
    padding: float,
    seed: int = 1,
    trials: int = 60,
) -> Packing:
    """A heap: each grain in turn falls straight down where it comes to lie lowest.

    For each grain several places and angles are tried; it comes down until it is ``padding`` above
    the floor or another grain, and the one with the lowest centre of area is kept. The result is
    dense but not at rest: grains lean on single points until they are pressed or shaken.

    Args:
        outlines: the outlines.
        kind: (n,) which outline each grain has, in the order in which they fall.
        box: x_low, x_high, y_low, y_high.
        padding: smallest gap between grains, and between grains and box.
        seed: of the random numbers.
        trials: how many places are tried for each grain.

    Raises:
        ValueError: the box is full before all grains are in.
    """
    outlines, kinds = _checked(outlines, kind, box, padding)
    random = np.random.default_rng(seed)
    position, angle = np.zeros((len(kinds), 2)), np.zeros(len(kinds))
    near, filled = _Neighbours(), 0.0
    for i, k in enumerate(kinds):
        lowest = math.inf
        for _ in range(trials):
            turned_by = random.uniform(0.0, 2.0 * math.pi)
            turned = outlines[k].placed(angle=turned_by)
            low, high = _free_room(turned, box, padding)
            if (high < low).any():
                continue
            x = random.uniform(low[0], high[0])
            y = _fall(turned, x, low[1], near, padding)
            height = y + turned.centroid[1]
            if y <= high[1] and height < lowest:
                lowest, position[i], angle[i] = height, (x, y), turned_by
        if lowest == math.inf:
            raise ValueError(
                f"deposited packing: the box {box} is full after {i} of {len(kinds)} grains, "
                f"which fill {filled / _area(box):.0%} of it"
            )
        near.add(position[i], outlines[k].placed(position[i], angle[i]))
        filled += outlines[k].area
    return Packing(outlines, kinds, position, angle, np.ones(len(kinds)))


def _fall(turned: Outline, x: float, floor: float, near: _Neighbours, padding: float) -> float:
    """Height at which an outline falling along x comes to rest, never closer than ``padding``."""
    below = near.under(x, turned, padding)
    tolerance = 1e-3 * padding
    y = max([floor, *(near.top(j) + turned.reach + padding for j in below)])
    while y > floor:
        here = turned.placed((x, y))
        gap = near.gap((x, y), here, below) - padding
        if gap <= tolerance:
            break
        y = max(floor, y - gap)  # no point of the outline moves further than the gap
    return y


class _Neighbours:
    """Outlines placed so far with the circles around them, to ask only near ones for distances."""

    def __init__(self) -> None:
        self.placed: list[Outline] = []
        self._centre: list[ArrayLike] = []
        self._radius: list[float] = []
        self._bounds: list[Box] = []

    def add(self, position: ArrayLike, placed: Outline) -> None:
        self._centre.append(np.array(position))
        self._radius.append(_reach_from(position, placed))
        self._bounds.append(placed.bounds)
        self.placed.append(placed)

    def of(self, position: ArrayLike, placed: Outline, within: float) -> list[int]:
        """Numbers of the outlines that may be closer than ``within``."""
        if not self.placed:
            return []
        away = np.hypot(*(np.array(self._centre) - position).T)
        reach = np.array(self._radius) + _reach_from(position, placed) + within
        return [int(j) for j in np.flatnonzero(away < reach)]

    def clear(self, position: ArrayLike, placed: Outline, padding: float) -> bool:
        """Whether all outlines so far are at least ``padding`` away."""
        near = self.of(position, placed, padding)
        return all(placed.distance(self.placed[j]) >= padding for j in near)

    def gap(self, position: ArrayLike, placed: Outline, among: list[int]) -> float:
        """Smallest distance to the outlines of the given numbers; inf if there are none."""
        if not among:
            return math.inf
        away = np.hypot(*(np.array([self._centre[j] for j in among]) - position).T)
        reach = np.array([self._radius[j] for j in among]) + _reach_from(position, placed)
        best = math.inf
        for least, j in sorted(zip((away - reach).tolist(), among, strict=True)):
            if least >= best:
                break  # the circles around the others are further away already
            best = min(best, placed.distance(self.placed[j]))
        return best

    def under(self, x: float, turned: Outline, padding: float) -> list[int]:
        """Numbers of the outlines that one at the height of the origin may meet as it falls."""
        low, high = turned.bounds[0] + x - padding, turned.bounds[1] + x + padding
        return [j for j, b in enumerate(self._bounds) if b[1] > low and b[0] < high]

    def top(self, j: int) -> float:
        return self._bounds[j][3]


def _reach_from(position: ArrayLike, placed: Outline) -> float:
    return float(np.hypot(*(placed.vertices - np.asarray(position)).T).max()) + placed.radius


def _checked(
    outlines: Sequence[Outline], kind: ArrayLike, box: Box, padding: float
) -> tuple[tuple[Outline, ...], NDArray[np.int64]]:
    kinds = np.atleast_1d(np.asarray(kind, dtype=np.int64))
    if not (math.isfinite(padding) and padding > 0.0):
        raise ValueError(f"packing: padding must be above 0, not {padding}")
    if not (box[0] < box[1] and box[2] < box[3]):
        raise ValueError(f"packing: box must be x_low, x_high, y_low, y_high, not {box}")
    if len(kinds) == 0 or kinds.min() < 0 or kinds.max() >= len(outlines):
        raise ValueError(f"packing: kinds must count {len(outlines)} outlines from 0, not {kinds}")
    return tuple(outlines), kinds


def _area(box: Box) -> float:
    return (box[1] - box[0]) * (box[3] - box[2])


def _free_room(turned: Outline, box: Box, padding: float) -> tuple[Array, Array]:
    """Lowest and highest position of an outline that keep it ``padding`` inside the box."""
    b = turned.bounds
    low = np.array([box[0] - b[0], box[2] - b[2]]) + padding
    high = np.array([box[1] - b[1], box[3] - b[3]]) - padding
    return low, high


def _gap_to_box(outline: Outline, box: Box) -> float:
    b = outline.bounds
    return min(b[0] - box[0], box[1] - b[1], b[2] - box[2], box[3] - b[3])
