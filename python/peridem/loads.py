"""Loads on nodes: prescribed motion, forces, and initial cracks.

Formulas are those of LAMMPS's variables. In them ``time`` is the time, ``{X}``, ``{Y}`` and ``{Z}``
the reference position of a node and ``{V}`` its volume.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from peridem.regions import Region, Rotation, numbers
from peridem.walls import check_name

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Nodes:
    """Which nodes: of some grains, inside some region, or those of both.

    Attributes:
        grains: numbers of grains from 1; None: of all.
        inside: a region, in the reference position; None: everywhere.
    """

    grains: tuple[int, ...] | None = None
    inside: Region | None = None

    def mask(self, grain: NDArray[np.int64], reference: Array) -> Mask:
        """Which nodes they are.

        Args:
            grain: (n,) number of each node's grain.
            reference: (n, d) reference positions.
        """
        chosen = np.ones(len(grain), dtype=bool)
        if self.grains is not None:
            chosen &= np.isin(grain, self.grains)
        if self.inside is not None:
            chosen &= self.inside.contains(reference)
        return chosen


@dataclass(frozen=True)
class Motion:
    """A prescribed motion of some nodes; directions left out (None) are free.

    Make one with :meth:`held`, :meth:`constant`, :meth:`turning` or :meth:`following`.

    Attributes:
        name: the ID of its group and fixes.
        nodes: which ones.
        velocity: (d,) constant, None for free directions.
        rotation: instead of it: about a fixed axis, all directions.
        displacement, rate: instead of both: (d,) formulas of the displacement and of its change
            per time, None for free directions.
    """

    name: str
    nodes: Nodes
    velocity: tuple[float | None, ...] = ()
    rotation: Rotation | None = None
    displacement: tuple[str | None, ...] = ()
    rate: tuple[str | None, ...] = ()

    def __post_init__(self) -> None:
        check_name("motion", self.name)
        kinds = [bool(self.velocity), self.rotation is not None, bool(self.displacement)]
        if sum(kinds) != 1:
            raise ValueError(
                f"motion '{self.name}': one of velocity, rotation and displacement needed"
            )
        free = [v is None for v in self.displacement]
        if self.displacement and [v is None for v in self.rate] != free:
            raise ValueError(f"motion '{self.name}': a rate for every displacement needed")

    @classmethod
    def held(cls, name: str, nodes: Nodes, directions: Sequence[bool] = (True, True)) -> Motion:
        """Nodes that stay where they are, in the given directions."""
        return cls(name, nodes, tuple(0.0 if fixed else None for fixed in directions))

    @classmethod
    def constant(cls, name: str, nodes: Nodes, velocity: Sequence[float | None]) -> Motion:
        """Nodes that move at a constant velocity."""
        return cls(name, nodes, tuple(velocity))

    @classmethod
    def turning(cls, name: str, nodes: Nodes, rotation: Rotation) -> Motion:
        """Nodes that turn about an axis."""
        return cls(name, nodes, rotation=rotation)

    @classmethod
    def following(
        cls,
        name: str,
        nodes: Nodes,
        displacement: Sequence[str | None],
        rate: Sequence[str | None],
    ) -> Motion:
        """Nodes whose displacement from their first position follows formulas."""
        return cls(name, nodes, displacement=tuple(displacement), rate=tuple(rate))

    @property
    def whole(self) -> bool:
        """Whether all directions are prescribed."""
        return None not in (*self.velocity, *self.displacement)

    @property
    def steady(self) -> bool:
        """Whether it is a constant velocity, which needs no constant time step."""
        return bool(self.velocity)

    def commands(self, dimension: int, mover: str) -> list[str]:
        """The lines of the script that set it in motion (its group is there already).

        Args:
            dimension: 2 or 3.
            mover: ID of its ``fix move``, if it has one.

        A constant velocity is that of nodes without force. The others need ``fix move``, and the
        force on the nodes is taken away as well so that it is known.
        """
        if self.steady:
            speeds = [*self.velocity, 0.0][:3]
            zero = ["NULL" if v is None else "0" for v in speeds]
            speed = ["NULL" if v is None else f"{v + 0.0:.12g}" for v in speeds]
            return [
                f"velocity {self.name} set {' '.join(speed)}",
                f"fix {self.name} {self.name} setforce {' '.join(zero)}",
            ]
        if self.rotation is not None:
            period = 2.0 * np.pi / abs(self.rotation.rate)
            axis = tuple(np.sign(self.rotation.rate) * a for a in self.rotation.axis)
            point = numbers(self.rotation.point)
            move = f"rotate {point} {numbers(axis)} {period:.17g}"
            return [
                f"fix {mover} {self.name} move {move}",
                f"fix {self.name} {self.name} setforce 0 0 0",
            ]
        return self._following(dimension, mover)

    def _following(self, dimension: int, mover: str) -> list[str]:
        lines, words, zero = [], [], []
        for kind, formulas in (("by", self.displacement), ("at", self.rate)):
            for axis, formula in zip("xyz", (*formulas, "0", "0"), strict=False):
                if formula is None:
                    words.append("NULL")
                    continue
                name = f"{self.name}_{kind}_{axis}"
                lines.append(variable(name, formula))
                words.append(f"v_{name}")
            if kind == "by":
                zero = ["NULL" if word == "NULL" else "0" for word in words]
        if dimension == 2:  # fix move wants NULL for z in 2D
            words[2] = words[5] = "NULL"
            zero[2] = "0"
            lines = [line for line in lines if not re.search(r"_(by|at)_z ", line)]
        return [
            *lines,
            f"fix {mover} {self.name} move variable {' '.join(words)}",
            f"fix {self.name} {self.name} setforce {' '.join(zero)}",
        ]


@dataclass(frozen=True)
class Force:
    """A force per volume on some nodes.

    Attributes:
        name: the ID of its group and fix.
        nodes: which ones.
        density: (d,) formulas or numbers, force per volume (per area in 2D).
    """

    name: str
    nodes: Nodes
    density: tuple[str | float, ...]

    def __post_init__(self) -> None:
        check_name("force", self.name)

    def commands(self, dimension: int) -> list[str]:
        """The lines of the script."""
        lines, words = [], []
        for axis, value in zip("xyz", (*self.density, 0.0, 0.0), strict=False):
            if isinstance(value, str) or value:
                name = f"{self.name}_{axis}"
                lines.append(variable(name, f"({value})*{{V}}"))
                words.append(f"v_{name}")
            else:
                words.append("0")
        return [*lines, f"fix {self.name} {self.name} addforce {' '.join(words[:3])}"]


@dataclass(frozen=True)
class Cut:
    """An initial crack: bonds across it are left out.

    Attributes:
        words: of the keyword ``cut`` of ``fix peridem/bonds``.
        region: that the words name, if they do.
    """

    words: str
    region: Region | None = field(default=None)

    @classmethod
    def plane(
        cls, point: Sequence[float], normal: Sequence[float], radius: float | None = None
    ) -> Cut:
        """A plane, or a disc of a plane."""
        disc = "" if radius is None else f" radius {radius:.12g}"
        return cls(f"plane {numbers(point)} {numbers(normal)}{disc}")

    @classmethod
    def segment(cls, start: Sequence[float], end: Sequence[float]) -> Cut:
        """A line between two points, in 2D."""
        return cls("segment " + " ".join(f"{v:.12g}" for v in (*start[:2], *end[:2])))

    @classmethod
    def within(cls, region: Region) -> Cut:
        """All bonds that pass through a region."""
        return cls("region", region)


NODE_VALUES = {"{X}": 1, "{Y}": 2, "{Z}": 3, "{V}": 4}


def variable(name: str, formula: str) -> str:
    """The command that defines a formula: for each node if it needs its place or volume."""
    kind = "atom" if any(key in formula for key in NODE_VALUES) else "equal"
    for key, column in NODE_VALUES.items():
        formula = formula.replace(key, f"c_nodes[{column}]")
    return f'variable {name} {kind} "{formula}"'


def ranges(numbers_: Array | NDArray[np.int64]) -> list[str]:
    """Sorted whole numbers as LAMMPS lists them: ``3:7 9 12:14``."""
    values = np.unique(np.asarray(numbers_, dtype=np.int64))
    starts = np.flatnonzero(np.diff(values, prepend=values[:1] - 2) > 1)
    ends = np.append(starts[1:], len(values)) - 1
    pairs = zip(values[starts].tolist(), values[ends].tolist(), strict=True)
    return [f"{a}" if a == b else f"{a}:{b}" for a, b in pairs]
