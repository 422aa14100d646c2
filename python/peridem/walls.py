"""Walls: planes and regions that push nodes away (``fix peridem/wall``)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from peridem.material import Contact
from peridem.regions import Region, Rotation, numbers

if TYPE_CHECKING:
    from peridem.loads import Nodes

Array = NDArray[np.float64]

# IDs of the script's own fixes
FIXES = (
    *("weight", "motion", "walls", "halt", "step", "bonds", "duration"),
    *(
        "grains",
        "node",
        "nodes",
        "damage",
        "books",
        "now",
        "halted",
        "free",
        "kicked",
        "bodies",
        "solids",
        "rested",
    ),
)


def check_name(what: str, name: str) -> None:
    """Refuse a name that no fix, group or variable may have, or that the script needs itself."""
    if not re.fullmatch(r"\w+", name):
        raise ValueError(f"{what} '{name}': a name has letters, digits and underscores only")
    if name in FIXES or name == "all":
        raise ValueError(f"{what} '{name}': the script needs the names {', '.join(FIXES)}")


@dataclass(frozen=True)
class Wall:
    """A plane wall.

    Attributes:
        name: the ID of its fix; letters, digits and underscores.
        point: (d,) a point on it at the start.
        normal: (d,) into the side where the grains are; any length.
        velocity: (d,) of the wall, constant.
        displacement: (d,) instead of it: how far the wall has moved, as LAMMPS formulas of
            ``time``; None for a direction in which it does not.
        contact: of this wall; None: of each node's own material with itself.
        nodes: that it touches; None: all. Others pass through it, as through a sieve.
    """

    name: str
    point: tuple[float, ...]
    normal: tuple[float, ...]
    velocity: tuple[float, ...] = (0.0, 0.0)
    displacement: tuple[str | None, ...] = ()
    contact: Contact | None = None
    nodes: Nodes | None = None

    def __post_init__(self) -> None:
        check_name("wall", self.name)
        values = (*self.point, *self.normal, *self.velocity)
        if not np.isfinite(values).all() or not any(self.normal):
            raise ValueError(f"wall '{self.name}': finite values and a normal other than 0 needed")
        _one_motion(self.name, self.velocity, self.displacement)

    @property
    def moves(self) -> bool:
        """Whether it has a velocity."""
        return any(self.velocity)

    @property
    def unit_normal(self) -> Array:
        """Normal of length 1."""
        normal = np.asarray(self.normal, dtype=float)
        return np.asarray(normal / np.linalg.norm(normal))

    def behind(self, nodes: Array) -> float:
        """How far the nodes reach through it at the start; 0 or less if they do not."""
        return -float(((nodes - np.asarray(self.point)) @ self.unit_normal).min())

    def corners(self, duration: float) -> Array:
        """Points that the simulation box must hold, (2, d)."""
        point = np.asarray(self.point, dtype=float)
        return np.vstack([point, point + duration * np.asarray(self.velocity)])

    def commands(self, words: str) -> list[str]:
        """The lines of the script.

        Args:
            words: keywords of its own contact.
        """
        line = f"fix {self.name} {group_of(self)} peridem/wall plane {_vector(self.point)}"
        line += f"  {_vector(self.normal)}"
        lines, motion = _motion(self.name, self.velocity, self.displacement)
        return [*lines, line + motion + words]


@dataclass(frozen=True)
class RegionWall:
    """The surface of a region as a wall: a drum, a hopper, a box with edges.

    Attributes:
        name: the ID of its fix.
        region: grains are inside it (a region of ``inside=False`` has them outside its shape).
        velocity, displacement, contact, nodes: as of :class:`Wall`.
        rotation: of the whole region.
    """

    name: str
    region: Region
    velocity: tuple[float, ...] = (0.0, 0.0)
    displacement: tuple[str | None, ...] = ()
    rotation: Rotation | None = None
    contact: Contact | None = None
    nodes: Nodes | None = None

    def __post_init__(self) -> None:
        check_name("wall", self.name)
        _one_motion(self.name, self.velocity, self.displacement)

    @property
    def moves(self) -> bool:
        """Whether it has a velocity."""
        return any(self.velocity)

    @property
    def drawable(self) -> bool:
        """Whether it is known where it is at any time."""
        about_z = self.rotation is None or not any(self.rotation.axis[:2])
        return self.region.known and not self.displacement and about_z

    def described(self) -> dict[str, object]:
        """What :class:`peridem.results_output.PlacedRegion` is made from; goes into JSON."""
        turn = self.rotation
        sense = 1.0 if turn is None or turn.axis[2] > 0.0 else -1.0
        return {
            "name": self.name,
            "region": self.region.described(),
            "velocity": list(self.velocity),
            "rate": 0.0 if turn is None else turn.rate * sense,
            "start": 0.0 if turn is None else turn.start,
            "turned": 0.0 if turn is None else turn.turned * sense,
            "axis": [0.0, 0.0] if turn is None else list(turn.point[:2]),
        }

    def behind(self, nodes: Array) -> float:
        """Above 0 if a node is on the wrong side at the start (how far is not known)."""
        if self.rotation is not None:
            nodes = self.rotation.before(nodes)
        return 0.0 if self.region.contains(nodes).all() else float("inf")

    def corners(self, duration: float) -> Array:
        """None: a region is no part of what the simulation box must hold."""
        return np.empty((0, 0))

    def commands(self, words: str) -> list[str]:
        """The lines of the script, as of :meth:`Wall.commands`."""
        lines, rotate = [], ""
        if self.rotation is not None:
            lines.append(f"variable {self.name}_angle equal {self.rotation.formula}")
            rotate = f" rotate v_{self.name}_angle {self.rotation.words}"
        lines += self.region.commands(f"{self.name}_shape", rotate)
        more, motion = _motion(self.name, self.velocity, self.displacement)
        line = (
            f"fix {self.name} {group_of(self)} peridem/wall region {self.name}_shape{motion}{words}"
        )
        return [*lines, *more, line]


AnyWall = Wall | RegionWall


def group_of(wall: AnyWall) -> str:
    """The group of the nodes that a wall touches."""
    return "all" if wall.nodes is None else f"{wall.name}_nodes"


def _one_motion(
    name: str, velocity: tuple[float, ...], displacement: tuple[str | None, ...]
) -> None:
    if any(velocity) and displacement:
        raise ValueError(f"wall '{name}': one of velocity and displacement, not both")


def _motion(
    name: str, velocity: tuple[float, ...], displacement: tuple[str | None, ...]
) -> tuple[list[str], str]:
    """Variables that the motion needs, and the keywords of the fix."""
    if any(velocity):
        return [], f"  velocity {_vector(velocity)}"
    if not displacement:
        return [], ""
    lines, words = [], []
    for axis, formula in zip("xyz", (*displacement, None, None), strict=False):
        if formula is None:
            words.append("NULL")
            continue
        lines.append(f'variable {name}_to_{axis} equal "{formula}"')
        words.append(f"v_{name}_to_{axis}")
    return lines, "  move " + " ".join(words[:3])


def _vector(values: tuple[float, ...]) -> str:
    return numbers(values)
