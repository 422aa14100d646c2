"""Where the grains go.

A :class:`Packing` is a table: which shape, where, how large, how turned. Every function here
returns one in which any two shapes, and any shape and the container, are at least ``padding`` apart
by their true distance (see :mod:`peridem.outline` and :mod:`peridem.solid`), not by circles around
them; so no two nodes start closer than the contact radius; give that as the padding. In 2D and 3D,
in boxes, periodic boxes and shapes (:class:`Container`). A seed makes each result repeatable.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from peridem.placing import (
    Container,
    Orientation,
    Placed,
    Sizes,
    check_orientation,
    container,
    container_inside,
    turn,
)
from peridem.shapes import Shape

__all__ = [
    "Box",
    "Container",
    "Layer",
    "Packing",
    "Sizes",
    "container_inside",
    "deposited",
    "dropped",
    "fill",
    "grid",
    "layered",
    "random_sequential",
    "settled",
    "table",
]

Array = NDArray[np.float64]
Box = Sequence[float] | Container


@dataclass(frozen=True, eq=False)
class Packing:
    """Grains as rows of a table.

    Attributes:
        outlines: the shapes that ``kind`` counts, from 0: outlines or solids.
        kind: (n,) which shape each grain has.
        position: (n, d) where the origin of its shape goes.
        angle: (n,) how far it is turned, radians; in space rotation vectors, (n, 3).
        scale: (n,) how much larger than its shape it is.
        container: where the grains are; its periodic axes count in distances.
    """

    outlines: tuple[Shape, ...]
    kind: NDArray[np.int64]
    position: Array
    angle: Array
    scale: Array
    container: Container | None = None

    def __post_init__(self) -> None:
        n, d = len(self.kind), self.dimension
        shapes = (self.position.shape, self.angle.shape, self.scale.shape)
        if shapes != ((n, d), (n,) if d == 2 else (n, 3), (n,)):
            raise ValueError(f"packing of {n} grains with arrays of the shapes {shapes}")
        if n and (self.kind.min() < 0 or self.kind.max() >= len(self.outlines)):
            raise ValueError(
                f"packing: kinds {self.kind.min()} to {self.kind.max()} "
                f"with {len(self.outlines)} outlines (counted from 0)"
            )

    def __len__(self) -> int:
        return len(self.kind)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.outlines[0].dimension

    def outline(self, i: int) -> Shape:
        """The outline or solid of grain i where it lies."""
        shape = self.outlines[int(self.kind[i])]
        return shape.placed(self.position[i], self.angle[i], float(self.scale[i]))

    @property
    def area(self) -> float:
        """Area, or in space volume, of all grains together."""
        sizes = np.array([shape.measure for shape in self.outlines])
        return float((sizes[self.kind] * self.scale**self.dimension).sum())

    @property
    def fraction(self) -> float:
        """Part of the container that the grains fill.

        Raises:
            ValueError: the packing has no container.
        """
        if self.container is None:
            raise ValueError("packing: without a container it has no fraction")
        return self.area / self.container.measure

    def reaches(self) -> Array:
        """For each grain how far it reaches from its position, (n,)."""
        reach = np.array([shape.reach for shape in self.outlines])
        return np.asarray(reach[self.kind] * self.scale)

    def smallest_gap(self) -> tuple[float, int, int]:
        """Smallest distance of two grains (0 where they overlap) and which two; inf if one only."""
        best = (math.inf, -1, -1)
        near, reach = Placed(self.container, self.dimension), self.reaches()
        for i in range(len(self)):
            placed = self.outline(i)
            for image in near.near(self.position[i], reach[i], best[0]):
                gap = near.gap(placed, self.position[i], reach[i], [image])
                if gap < best[0]:
                    best = (gap, image[0], i)
            near.add(placed, self.position[i], reach[i])
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
            within = container(box)
            for k in range(len(self)):
                wall = within.gap(self.outline(k))
                if wall < padding * (1.0 - 1e-9):
                    raise ValueError(
                        f"packing: grain {k + 1} is {wall:g} inside the box {within}, "
                        f"at least {padding:g} needed"
                    )
        return self


def table(
    outlines: Sequence[Shape],
    rows: ArrayLike | str | Path,
    padding: float,
    box: Box | None = None,
) -> Packing:
    """A given table: an array or a comma-separated file with a line of headings.

    Columns: kind (from 0), x, y, scale, angle in radians; in space kind, x, y, z, scale and the
    three components of a rotation vector.

    Args:
        outlines: the shapes that the first column counts.
        rows: (n, 5), in space (n, 8), or the path of a file.
        padding: smallest distance between grains, and to the box.
        box: where they must lie; None: anywhere.

    Raises:
        ValueError: a wrong number of columns, or grains that are too close (:meth:`Packing.check`).
    """
    if isinstance(rows, str | Path):
        data = np.loadtxt(rows, delimiter=",", skiprows=1, ndmin=2)
    else:
        data = np.atleast_2d(np.asarray(rows, dtype=float))
    d = outlines[0].dimension
    columns = {2: "kind x y scale angle", 3: "kind x y z scale ax ay az"}[d]
    if data.ndim != 2 or data.shape[1] != len(columns.split()):
        raise ValueError(f"packing table: columns {columns} needed, not {data.shape}")
    if not np.isfinite(data).all():
        raise ValueError("packing table: values that are not finite")
    angle = data[:, -1] if d == 2 else data[:, -3:]
    kind, scale = data[:, 0].astype(np.int64), data[:, d + 1]
    within = None if box is None else container(box)
    packing = Packing(tuple(outlines), kind, data[:, 1 : d + 1], angle, scale, within)
    return packing.check(padding, within)


def grid(
    outlines: Sequence[Shape],
    kind: ArrayLike,
    box: Box,
    padding: float,
    jitter: float = 0.0,
    seed: int = 1,
    sizes: Sizes | None = None,
    orientation: Orientation = "random",
) -> Packing:
    """One grain in each cell of a square or cubic grid, row by row from the lowest corner.

    Args:
        outlines: the shapes.
        kind: (n,) which shape each grain has.
        box: x_low, x_high, y_low, y_high (z_low, z_high), or a container.
        padding: smallest gap between grains, and between grains and box.
        jitter: how far each grain leaves the middle of its cell, over the room there, 0 to 1.
        seed: of the random numbers.
        sizes: by how much grains are scaled; None: not at all.
        orientation: see :func:`peridem.placing.turn`.

    Raises:
        ValueError: the grid does not fit the box.
    """
    outlines, kinds, within = _checked(outlines, kind, box, padding, orientation)
    if not 0.0 <= jitter <= 1.0:
        raise ValueError(f"grid packing: jitter must lie in 0 to 1, not {jitter}")
    random, d = np.random.default_rng(seed), within.dimension
    scale = _scales(sizes, len(kinds), random)
    reach = np.array([shape.reach for shape in outlines])[kinds] * scale
    room = within.high - within.low - padding
    pitch = 2.0 * reach.max() + padding
    count = (room / pitch * (1 + 1e-12)).astype(int)
    floor = int(np.prod(count[:-1]))
    layers = math.ceil(len(kinds) / floor) if floor else 0
    if floor == 0 or layers > count[-1]:
        raise ValueError(
            f"grid packing: {len(kinds)} grains of radius up to {reach.max():g} asked for, "
            f"{floor * count[-1]} fit into the box {within}; a larger box or smaller grains needed"
        )
    cell = np.append(room[:-1] / count[:-1], pitch)
    n = np.arange(len(kinds))
    index = np.column_stack(np.unravel_index(n, (layers, *count[-2::-1])))[:, ::-1]
    middle = within.low + 0.5 * padding + (index + 0.5) * cell
    free = np.clip(0.5 * (cell - padding) - reach[:, None], 0.0, None)
    position = middle + jitter * free * random.uniform(-1.0, 1.0, (len(n), d))
    if d == 2 and orientation == "random":
        angle = random.uniform(0.0, 2.0 * math.pi, len(n))
    else:
        angle = np.array([turn(orientation, d, random) for _ in n], dtype=float)
    return Packing(outlines, kinds, position, angle, scale, within).check(padding, within)


def random_sequential(
    outlines: Sequence[Shape],
    kind: ArrayLike,
    box: Box,
    padding: float,
    seed: int = 1,
    attempts: int = 2000,
    sizes: Sizes | ArrayLike | None = None,
    orientation: Orientation = "random",
) -> Packing:
    """Grains thrown in one by one at random places, the largest first, kept where they fit.

    Args:
        outlines: the shapes.
        kind: (n,) which shape each grain has.
        box: x_low, x_high, y_low, y_high (z_low, z_high), or a container.
        padding: smallest gap between grains, and between grains and box.
        seed: of the random numbers.
        attempts: how often a place is sought for each grain.
        sizes: by how much grains are scaled, a distribution or (n,); None: not at all.
        orientation: see :func:`peridem.placing.turn`.

    Raises:
        ValueError: no place found for a grain; it says how many fitted and how full the box was.
    """
    outlines, kinds, within = _checked(outlines, kind, box, padding, orientation)
    random, d = np.random.default_rng(seed), within.dimension
    scale = _scales(sizes, len(kinds), random)
    reach = np.array([shape.reach for shape in outlines])[kinds] * scale
    _check_periodic(within, reach.max(), padding)
    position, angle = np.zeros((len(kinds), d)), _no_angles(len(kinds), d)
    near, filled = Placed(within, d), 0.0
    for done, i in enumerate(np.argsort(-reach, kind="stable")):
        shape = outlines[kinds[i]]
        for _ in range(attempts):
            angle[i] = turn(orientation, d, random)
            turned = shape.placed(angle=angle[i], scale=float(scale[i]))
            low, high = within.room(turned, padding)
            if (high < low).any():
                continue
            position[i] = random.uniform(low, high)
            placed = turned.placed(position[i])
            if within.inside is not None and within.inside.room_for(placed) < padding:
                continue
            if near.clear(placed, position[i], reach[i], padding):
                break
        else:
            raise ValueError(
                f"random sequential packing: no place for grain {done + 1} of {len(kinds)} in "
                f"{attempts} attempts; those before fill {filled / within.measure:.0%} of the box "
                f"{within}. More attempts, fewer or smaller grains, less padding, or gravity "
                "(deposited, settled) help"
            )
        near.add(placed, position[i], reach[i])
        filled += placed.measure
    return Packing(outlines, kinds, position, angle, scale, within)


def fill(
    outlines: Sequence[Shape],
    fraction: float,
    box: Box,
    padding: float,
    seed: int = 1,
    attempts: int = 2000,
    shares: Sequence[float] | None = None,
    sizes: Sizes | None = None,
    orientation: Orientation = "random",
) -> Packing:
    """Random sequential addition up to a wanted fraction of the box.

    So many grains are drawn that together they come as close to the fraction as whole grains
    can, and then placed by :func:`random_sequential`. Discs of one size jam at 0.547 and spheres
    at 0.38, without padding (Feder 1980; Meakin & Jullien 1992).

    Args:
        outlines: the shapes.
        fraction: area or volume of all grains over that of the box.
        box: x_low, x_high, y_low, y_high (z_low, z_high), or a container.
        padding: smallest gap between grains, and between grains and box.
        seed: of the random numbers.
        attempts: how often a place is sought for each grain.
        shares: of each shape in the number of grains; None: all alike.
        sizes: by how much grains are scaled; None: not at all.
        orientation: see :func:`peridem.placing.turn`.

    Raises:
        ValueError: a fraction that is not between 0 and 1, or that cannot be reached.
    """
    within = container(box)
    if not 0.0 < fraction < 1.0:
        raise ValueError(f"packing: fraction must lie between 0 and 1, not {fraction}")
    random = np.random.default_rng((seed, 1))
    weight = np.ones(len(outlines)) if shares is None else np.asarray(shares, dtype=float)
    if weight.shape != (len(outlines),) or not (weight >= 0.0).all() or weight.sum() <= 0.0:
        raise ValueError(
            f"packing: a share for each of {len(outlines)} shapes needed, not {shares}"
        )
    measure = np.array([shape.measure for shape in outlines])
    wanted, kinds, scales, total = fraction * within.measure, [], [], 0.0
    while True:
        kind = int(random.choice(len(outlines), p=weight / weight.sum()))
        scale = 1.0 if sizes is None else float(sizes.draw(1, random)[0])
        size = float(measure[kind]) * scale**within.dimension
        if abs(total + size - wanted) > abs(total - wanted):
            break
        kinds.append(kind)
        scales.append(scale)
        total += size
    if not kinds:
        raise ValueError(f"packing: no grain is small enough for a fraction of {fraction:g}")
    return random_sequential(
        outlines, kinds, within, padding, seed, attempts, np.array(scales), orientation
    )


@dataclass(frozen=True, eq=False)
class Layer:
    """One layer of :func:`layered`.

    Attributes:
        height: of the layer.
        kind: which shape each of its grains has; None: so many as ``fraction`` takes.
        fraction: part of the layer that its grains fill, if ``kind`` is not given.
        shares: of each shape in the number of grains.
        sizes: by how much its grains are scaled.
        orientation: see :func:`peridem.placing.turn`.
    """

    height: float
    kind: Sequence[int] | None = None
    fraction: float = 0.4
    shares: Sequence[float] | None = None
    sizes: Sizes | None = None
    orientation: Orientation = "random"


def layered(
    outlines: Sequence[Shape],
    layers: Sequence[Layer],
    box: Box,
    padding: float,
    seed: int = 1,
    attempts: int = 2000,
) -> Packing:
    """Layers of different grains above each other, from the bottom of the box; random in each.

    Grains keep within their layer.

    Args:
        outlines: the shapes that layers count.
        layers: from the bottom up.
        box: where they go.
        padding: smallest distance between grains, and to the box.
        seed: the same one gives the same packing.
        attempts: random places that are tried for each grain.

    Raises:
        ValueError: the layers are higher than the box, or the grains of one do not fit; it says
            which (from 1).
    """
    within = container(box)
    height = sum(layer.height for layer in layers)
    room = float(within.high[-1] - within.low[-1])
    if not layers or height > room * (1.0 + 1e-12):
        raise ValueError(f"layered packing: layers of together {height:g} in a box {room:g} high")
    made, bottom = [], float(within.low[-1])
    for number, layer in enumerate(layers, 1):
        slab = within.slab(bottom, min(bottom + layer.height, float(within.high[-1])))
        bottom += layer.height
        try:
            made.append(_layer(outlines, layer, slab, padding, seed + number - 1, attempts))
        except ValueError as error:
            raise ValueError(f"layer {number}: {error}") from error
    return Packing(
        tuple(outlines),
        np.concatenate([part.kind for part in made]),
        np.concatenate([part.position for part in made]),
        np.concatenate([part.angle for part in made]),
        np.concatenate([part.scale for part in made]),
        within,
    )


def _layer(
    outlines: Sequence[Shape],
    layer: Layer,
    slab: Container,
    padding: float,
    seed: int,
    attempts: int,
) -> Packing:
    """The grains of one layer: so many of each kind, or up to a fraction."""
    how = layer.sizes, layer.orientation
    if layer.kind is not None:
        return random_sequential(outlines, layer.kind, slab, padding, seed, attempts, *how)
    return fill(outlines, layer.fraction, slab, padding, seed, attempts, layer.shares, *how)


def deposited(
    outlines: Sequence[Shape],
    kind: ArrayLike,
    box: Box,
    padding: float,
    seed: int = 1,
    trials: int = 60,
    sizes: Sizes | None = None,
    orientation: Orientation = "random",
) -> Packing:
    """A heap: each grain in turn falls straight down where it comes to lie lowest.

    For each grain several places and angles are tried; it comes down (along the last axis) until it
    is ``padding`` above the floor or another grain, and the one with the lowest centre is kept. The
    result is dense but not at rest: grains lean on single points until they are pressed or shaken.

    Args:
        outlines: the shapes.
        kind: (n,) which shape each grain has, in the order in which they fall.
        box: x_low, x_high, y_low, y_high (z_low, z_high), or a container that is a box.
        padding: smallest gap between grains, and between grains and box.
        seed: of the random numbers.
        trials: how many places are tried for each grain.
        sizes: by how much grains are scaled; None: not at all.
        orientation: see :func:`peridem.placing.turn`.

    Raises:
        ValueError: the box is full before all grains are in, or is no box.
    """
    outlines, kinds, within = _checked(outlines, kind, box, padding, orientation)
    if within.inside is not None or within.periodic[-1]:
        raise ValueError("deposited packing: a box with a floor and a top needed")
    random, d = np.random.default_rng(seed), within.dimension
    scale = _scales(sizes, len(kinds), random)
    reach = np.array([shape.reach for shape in outlines])[kinds] * scale
    _check_periodic(within, reach.max(), padding)
    position, angle = np.zeros((len(kinds), d)), _no_angles(len(kinds), d)
    near, filled = Placed(within, d), 0.0
    for i, k in enumerate(kinds):
        lowest = math.inf
        for _ in range(trials):
            turned_by = turn(orientation, d, random)
            turned = outlines[k].placed(angle=turned_by, scale=float(scale[i]))
            low, high = within.room(turned, padding)
            if (high < low).any():
                continue
            across = random.uniform(low[:-1], high[:-1])
            at = _fall(turned, across, float(low[-1]), float(reach[i]), near, padding)
            height = float(at[-1] + turned.centroid[-1])
            if at[-1] <= high[-1] and height < lowest:
                lowest, position[i], angle[i] = height, at, turned_by
        if lowest == math.inf:
            raise ValueError(
                f"deposited packing: the box {within} is full after {i} of {len(kinds)} grains, "
                f"which fill {filled / within.measure:.0%} of it"
            )
        placed = outlines[k].placed(position[i], angle[i], float(scale[i]))
        near.add(placed, position[i], reach[i])
        filled += placed.measure
    return Packing(outlines, kinds, position, angle, scale, within)


def dropped(packing: Packing, padding: float) -> Packing:
    """The packing with each grain straight down on the floor or on what lies below it.

    The lowest grain first, without turning: free fall, without the time it takes.

    Args:
        packing: grains in a container that is a box, ``padding`` apart from each other.
        padding: smallest gap between grains, and between grains and box.

    Raises:
        ValueError: the packing has no container, or one without a floor.
    """
    within = packing.container
    if within is None or within.inside is not None or within.periodic[-1]:
        raise ValueError("dropped packing: a packing in a box with a floor and a top needed")
    reach, position = packing.reaches(), packing.position.copy()
    shapes = [packing.outline(i) for i in range(len(packing))]
    near = Placed(within, packing.dimension)
    for i in np.argsort([shape.extent[0][-1] for shape in shapes], kind="stable"):
        kind, scale = packing.kind[i], float(packing.scale[i])
        turned = packing.outlines[kind].placed(angle=packing.angle[i], scale=scale)
        across, start = position[i, :-1], float(position[i, -1])
        if not near.clear(shapes[i], position[i], float(reach[i]), padding):
            start = math.inf  # one that was above it has come down past it: on top, then
        floor, top = (float(end[-1]) for end in within.room(turned, padding))
        at = _fall(turned, across, floor, float(reach[i]), near, padding, start)
        if at[-1] > max(top, position[i, -1]):
            return packing  # there is no room for it
        position[i] = at
        near.add(turned.placed(at), at, float(reach[i]))
    return replace(packing, position=position)


def settled(
    packing: Packing,
    padding: float,
    spacing: float | None = None,
    friction: float = 0.0,
    lmp: str | Path | None = None,
    ranks: int = 1,
) -> Packing:
    """The packing after its grains have fallen and come to rest, as rigid bodies in LAMMPS.

    It needs ``lmp`` with the RIGID package.

    Args:
        packing: grains in a box with a floor and a top, apart from each other.
        padding: smallest distance between grains, and to the box, at the end.
        spacing: of the nodes that stand for the grains while they fall; None: the padding, at most
            a third of the smallest grain's radius.
        friction: Coulomb's coefficient; more makes looser heaps.
        lmp: the program (see :func:`peridem.run.find_lmp`).
        ranks: MPI processes.

    Raises:
        ValueError: the packing has no such box, or friction is below 0.
        RuntimeError: grains are nearer than the padding at the end, or have not come to rest.
        RunError: LAMMPS failed, or is not there.
    """
    from peridem import settle

    return settle.settled(packing, padding, spacing, friction, lmp, ranks)


def _fall(
    turned: Shape,
    across: Array,
    floor: float,
    reach: float,
    near: Placed,
    padding: float,
    start: float = math.inf,
) -> Array:
    """Where a shape that falls along the last axis, from above all or from a height, comes to rest,
    (d,)."""
    flat = np.append(across, 0.0)
    low, high = turned.extent
    below = near.under(low + flat, high + flat, padding)
    tolerance = 1e-3 * padding
    y = min(start, max([floor, *(near.top(image) + reach + padding for image in below)]))
    while y > floor:
        at = np.append(across, y)
        gap = near.gap(turned.placed(at), at, reach, below) - padding
        if gap <= tolerance:
            break
        y = max(floor, y - gap)  # no point of the shape moves further than the gap
    return np.append(across, y)


def _no_angles(n: int, dimension: int) -> Array:
    return np.zeros(n) if dimension == 2 else np.zeros((n, 3))


def _scales(sizes: Sizes | ArrayLike | None, n: int, random: np.random.Generator) -> Array:
    if sizes is None:
        return np.ones(n)
    if isinstance(sizes, Sizes):
        return sizes.draw(n, random)
    given = np.asarray(sizes, dtype=float)
    if given.shape != (n,) or not (np.isfinite(given) & (given > 0.0)).all():
        raise ValueError(f"packing: sizes of {n} grains must be {n} numbers above 0")
    return given


def _check_periodic(within: Container, reach: float, padding: float) -> None:
    for axis, (period, length) in enumerate(
        zip(within.periodic, within.high - within.low, strict=True)
    ):
        if period and length < 2.0 * reach + padding:
            raise ValueError(
                f"packing: a grain of radius {reach:g} meets itself across the periodic side "
                f"{'xyz'[axis]} of length {length:g}"
            )


def _checked(
    outlines: Sequence[Shape],
    kind: ArrayLike,
    box: Box,
    padding: float,
    orientation: Orientation,
) -> tuple[tuple[Shape, ...], NDArray[np.int64], Container]:
    kinds = np.atleast_1d(np.asarray(kind, dtype=np.int64))
    if not (math.isfinite(padding) and padding > 0.0):
        raise ValueError(f"packing: padding must be above 0, not {padding}")
    within = container(box)
    if len(kinds) == 0 or kinds.min() < 0 or kinds.max() >= len(outlines):
        raise ValueError(f"packing: kinds must count {len(outlines)} outlines from 0, not {kinds}")
    dimensions = {shape.dimension for shape in outlines} | {within.dimension}
    if len(dimensions) != 1:
        raise ValueError(
            "packing: outlines, solids and box of two and of three dimensions together"
        )
    check_orientation(orientation)
    return tuple(outlines), kinds, within
