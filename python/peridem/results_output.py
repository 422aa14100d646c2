"""A folder in which LAMMPS ran: frames, fields, cells, walls, times.

A folder that :mod:`peridem.scene` wrote has a mesh and a summary of the scene. Of any other folder
the script and the log tell what they can, and cells are made from the positions in the first frame.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from peridem.cloud import unique_faces
from peridem.regions import Region, described_region
from peridem.results_dump import Dump, Frame
from peridem.results_tables import Table, thermo
from peridem.run_script import LOG, commands
from peridem.scene import DATA, DUMP, MESH, SUMMARY

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

LONGEST = 1.6  # of a cell made from positions: longest side over the usual spacing
STRETCH = 0.1  # of a side that counts as broken, where no critical stretch is known


@dataclass(frozen=True)
class PlacedWall:
    """A plane wall at some time: a point, the unit normal towards the grains, the velocity."""

    name: str
    point: Array
    normal: Array
    velocity: Array


@dataclass(frozen=True)
class PlacedRegion:
    """A region that is a wall, at some time: moved, after it was turned about an axis along z.

    Attributes:
        name: of the wall.
        region: before it moved.
        angle: by which it has turned.
        axis: (2,) where the axis was.
        shift: (d,) how far it has moved.
    """

    name: str
    region: Region
    angle: float
    axis: Array
    shift: Array

    def contains(self, points: Array) -> NDArray[np.bool_]:
        """Which of the points, (n, d), are on its free side."""
        back = points - self.shift
        back[:, :2] = self._turned(back[:, :2], -self.angle)
        return self.region.contains(back)

    @property
    def corners(self) -> Array:
        """Points that a picture of it must hold, (n, 2)."""
        return self._turned(self.region.corners, self.angle) + self.shift[:2]

    def _turned(self, points: Array, angle: float) -> Array:
        c, s = math.cos(angle), math.sin(angle)
        return np.asarray((points - self.axis) @ np.array([[c, s], [-s, c]]) + self.axis)


class Output:
    """A folder of results.

    Attributes:
        folder: where they are.
        dump: frames.

    Raises:
        FileNotFoundError: there is no dump.
        ValueError: the folder holds several dumps and nothing tells which one is meant.
    """

    def __init__(self, folder: str | Path, dump: str | Path | None = None) -> None:
        self.folder = Path(folder)
        if not self.folder.is_dir():
            raise FileNotFoundError(f"no folder {self.folder}")
        self.dump = Dump(dump or self._find_dump())
        if len(self.dump) == 0:
            raise ValueError(f"{self.dump.path} has no whole frame")
        self._broken: list[NDArray[np.bool_]] = []

    # ---- what the files say ----------------------------------------------------------------------

    @cached_property
    def script(self) -> str:
        """The input script, or ''."""
        found = sorted(self.folder.glob("in.*"))
        return found[0].read_text() if found else ""

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What the scene left, or {}."""
        path = self.folder / SUMMARY
        try:
            return dict(json.loads(path.read_text())) if path.is_file() else {}
        except ValueError as error:
            raise ValueError(f"{path} is damaged, or not as a scene left it: {error}") from error

    @cached_property
    def log(self) -> str:
        """LAMMPS's log, or ''."""
        path = self.folder / LOG
        return path.read_text(errors="replace") if path.is_file() else ""

    @cached_property
    def thermo(self) -> Table:
        """Thermo output, or {}."""
        return thermo(self.folder / LOG) if re.search(r"^\s*Step\b", self.log, re.M) else {}

    def _find_dump(self) -> Path:
        for command in commands(self.script):
            words = command.words
            if command.name == "dump" and len(words) > 5 and words[3].startswith("custom"):
                path = self.folder / words[5]
                if "$" not in words[5] and (path.is_file() or "*" in words[5]):
                    return path
        if (self.folder / DUMP).is_file() or self.script:
            return self.folder / DUMP
        found = [p for end in ("dump", "dump.gz", "bin") for p in self.folder.glob(f"*.{end}")]
        if len(found) > 1:
            raise ValueError(f"several dumps in {self.folder}: {', '.join(p.name for p in found)}")
        return found[0] if found else self.folder / DUMP

    @property
    def title(self) -> str:
        """Of the scene; else the name of the folder."""
        return str(self.summary.get("title", self.folder.resolve().name))

    @cached_property
    def dimension(self) -> int:
        """2 or 3."""
        if self.summary:
            return int(self.summary["dimension"])
        said = re.search(r"^\s*dimension\s+([23])", self.script, re.MULTILINE)
        if said:
            return int(said[1])
        return 3 if self.script or "z" in self.dump[0] else 2

    def time(self, i: int) -> float:
        """Time of frame i: from the dump, else from the log, else steps times the time step."""
        i = range(len(self.dump))[i]
        frame, step = self.frame(i), float(self.dump.steps[i])
        if frame.time is not None:
            return frame.time
        if "Time" in self.thermo:
            return float(np.interp(step, self.thermo["Step"], self.thermo["Time"]))
        return step * float(self.summary.get("timestep", 1.0))

    @cached_property
    def contact_radius(self) -> float:
        """The contact distance; 0.95 spacings where neither scene nor log tell."""
        if "contact_radius" in self.summary:
            return float(self.summary["contact_radius"])
        said = re.findall(r"^PERIDEM: contact of types \d+ \d+: radius (\S+),", self.log, re.M)
        return max(map(float, said)) if said else 0.95 * self.spacing

    @cached_property
    def spacing(self) -> float:
        """The usual (median) distance of neighbouring nodes in the reference positions."""
        from scipy.spatial import cKDTree

        return float(np.median(cKDTree(self.reference).query(self.reference, k=2)[0][:, 1]))

    @cached_property
    def volumes(self) -> Array:
        """Volumes of the nodes, (n,), from the data file; from the cells where there is none."""
        path = self.folder / DATA
        section = None
        if path.is_file():
            section = re.search(r"^Atoms\b.*\n\s*\n((?:.+\n)+)", path.read_text(), re.MULTILINE)
        if section:
            lines = section[1].splitlines()
            rows = np.array([line.split()[:4] for line in lines], dtype=float)
            volumes: Array = rows[np.argsort(rows[:, 0]), 3]
            if len(volumes) == len(self.reference):
                return volumes
        corners = self.reference[self.cells]
        size = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
        share = size / math.factorial(self.dimension) / (self.dimension + 1)
        total = np.zeros(len(self.reference))
        for column in self.cells.T:
            np.add.at(total, column, share)
        return total

    # ---- frames and fields -----------------------------------------------------------------------

    def frame(self, i: int) -> Frame:
        """Frame i (negative: from the end), kept until another one is asked for."""
        i = range(len(self.dump))[i]
        kept = getattr(self, "_kept", None)
        if kept is None or kept[0] != i:
            self._kept = (i, self.dump[i])
            self._check(self._kept[1])
        return self._kept[1]

    def _check(self, frame: Frame) -> None:
        if "mol" not in frame or "id" not in frame:
            raise ValueError(f"{self.dump.path} lacks 'id' or 'mol' among its columns")
        known = len(self.reference)
        if len(frame["id"]) != known:
            first = "the scene" if (self.folder / MESH).is_file() else "its first frame"
            raise ValueError(
                f"{self.dump.path} has {len(frame['id'])} atoms at step {frame.step}, "
                f"{first} {known}"
            )

    @cached_property
    def attributes(self) -> dict[str, str]:
        """Attributes of ``compute peridem/atom`` → columns of the dump that hold them."""
        found: dict[str, str] = {}
        for command in commands(self.script):
            words = command.words
            if command.name == "compute" and words[3:4] == ("peridem/atom",):
                for k, name in enumerate(words[4:], 1):
                    column = f"c_{words[1]}" + (f"[{k}]" if len(words) > 5 else "")
                    if column in self.dump[0].columns:
                        found.setdefault(name, column)
        return found

    def fields(self) -> list[str]:
        """What :meth:`field` knows."""
        made = ["grain", "displacement"] + (["speed"] if "vx" in self.dump[0] else [])
        return [*self.attributes, *made, *self.dump[0].columns]

    def field(self, name: str, i: int) -> Array:
        """A value for each node at frame i, (n,).

        Args:
            name: an attribute of ``compute peridem/atom``, a column of the dump, or ``grain``,
                ``speed``, ``displacement``.
            i: number of the frame.

        Raises:
            KeyError: there is no such field; it says which there are.
        """
        frame = self.frame(i)
        if name in self.attributes:
            return frame[self.attributes[name]]
        if name == "grain":
            return frame["mol"]
        if name == "displacement":
            moved: Array = np.linalg.norm(frame.position - self.reference, axis=1)
            return moved
        if name == "speed" and "vx" in frame:
            speed: Array = np.linalg.norm(frame.velocity, axis=1)
            return speed
        if name not in frame:
            raise KeyError(f"no field '{name}'; there are {', '.join(self.fields())}")
        return frame[name]

    def mean_damage(self, i: int) -> float:
        """Mean over the nodes that have, or had, bonds: nodes of walls and bodies have none."""
        damage = self.field("damage", i)
        if "bonds" in self.attributes:
            damage = damage[(damage > 0.0) | (self.field("bonds", i) > 0)]
        return float(damage.mean()) if len(damage) else 0.0

    # ---- shapes ----------------------------------------------------------------------------------

    @cached_property
    def _mesh(self) -> tuple[Array, Ints]:
        if (self.folder / MESH).is_file():
            import meshio

            mesh = meshio.read(self.folder / MESH)
            points: Array = mesh.points[:, : self.dimension]
            cells: Ints = mesh.cells[0].data.astype(np.int64)
            return points, cells
        frame = self.dump[0]
        points = frame.position[:, : self.dimension]
        return points, cells_of_points(points, frame["mol"])

    @property
    def reference(self) -> Array:
        """Reference positions in the order of the atom IDs, (n, d)."""
        return self._mesh[0]

    @property
    def cells(self) -> Ints:
        """Triangles or tetrahedra as rows of atom numbers from 0, (m, d + 1)."""
        return self._mesh[1]

    @cached_property
    def edges(self) -> Ints:
        """Sides of cells, each once, (e, 2)."""
        return unique_faces(self.cells, 2)[0]

    @cached_property
    def _rest(self) -> Array:
        return self._lengths(self.reference)

    def _lengths(self, position: Array) -> Array:
        ends = position[self.edges]
        return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))

    def _critical(self) -> Array:
        """The stretch at which each side of a cell breaks, (e,): the smaller one of its ends, or
        that of the interface between them.
        """
        limit = self._critical_of_nodes()[self.edges].min(axis=1)
        first = self.frame(0)
        if "type" in first:
            ends = np.sort(first["type"].astype(np.int64)[self.edges], axis=1)
            for a, b, stretch in self.summary.get("interfaces", ()):
                limit[(ends[:, 0] == min(a, b)) & (ends[:, 1] == max(a, b))] = stretch
        return np.asarray(limit)

    def _critical_of_nodes(self) -> Array:
        """The stretch at which a node's type breaks, (n,)."""
        first = self.frame(0)
        kind = first["type"].astype(np.int64) if "type" in first else None
        if "critical_stretch" in self.summary and kind is not None:
            known = [np.inf if s is None else s for s in self.summary["critical_stretch"]]
            return np.asarray(np.array(known)[kind - 1])
        said = re.findall(r"^PERIDEM: type (\d+): .*?critical stretch ([\d.eE+-]+)", self.log, re.M)
        stretch = dict((int(t), float(s)) for t, s in said)
        if kind is None:
            return np.full(len(self.reference), STRETCH)
        return np.array([stretch.get(int(k), STRETCH) for k in kind])

    def broken_edges(self, i: int) -> NDArray[np.bool_]:
        """Which sides of cells have been stretched beyond breaking in a frame up to i."""
        i = range(len(self.dump))[i]
        critical = self._critical()
        while len(self._broken) <= i:
            frame = self.frame(len(self._broken))
            stretch = self._lengths(frame.position[:, : self.dimension]) / self._rest - 1.0
            over = stretch > critical
            if "fragment" in self.attributes:
                pieces = frame[self.attributes["fragment"]][self.edges]
                # nodes of walls and bodies have no bonds: each is a piece of its own
                over |= (pieces[:, 0] != pieces[:, 1]) & np.isfinite(critical)
            before = self._broken[-1] if self._broken else np.zeros(len(over), dtype=bool)
            self._broken.append(over | before)
        return self._broken[i]

    def intact_cells(self, i: int) -> Ints:
        """The cells none of whose sides is broken at frame i."""
        broken = self.edges[self.broken_edges(i)]
        n = len(self.reference)
        codes = broken[:, 0] * n + broken[:, 1]
        ordered = np.sort(self.cells, axis=1)
        keep = np.ones(len(ordered), dtype=bool)
        for a in range(ordered.shape[1]):
            for b in range(a + 1, ordered.shape[1]):
                keep &= ~np.isin(ordered[:, a] * n + ordered[:, b], codes)
        return np.asarray(self.cells[keep])

    def pick(self, count: int) -> list[int]:
        """Numbers of so many frames, evenly spread from the first to the last."""
        return sorted(set(np.linspace(0, len(self.dump) - 1, count).round().astype(int).tolist()))

    def chosen(self, frames: Sequence[int] | None, count: int) -> list[int]:
        """Frames as asked for, negative ones from the end; None: so many, spread.

        Raises:
            ValueError: there is no such frame.
        """
        if frames is None:
            return self.pick(count)
        total = len(self.dump)
        for i in frames:
            if not -total <= i < total:
                raise ValueError(
                    f"no frame {i}: {self.dump.path} has {total}, from 0 to {total - 1}"
                )
        return [range(total)[i] for i in frames]

    # ---- walls -----------------------------------------------------------------------------------

    @cached_property
    def known_walls(self) -> list[dict[str, Any]]:
        """The plane walls as the scene or the script has them."""
        if "walls" in self.summary:
            return list(self.summary["walls"])
        return [wall for command in commands(self.script) if (wall := _plane(command.words))]

    def walls(self, time: float) -> list[PlacedWall]:
        """The plane walls where they are at a time; walls with other motions are left out."""
        since = time - float(self.summary.get("start_time", 0.0))
        walls = []
        for wall in self.known_walls:
            point, normal, velocity = (
                np.array(wall[k], dtype=float)[: self.dimension]
                for k in ("point", "normal", "velocity")
            )
            normal = normal / np.linalg.norm(normal)
            walls.append(PlacedWall(wall["name"], point + since * velocity, normal, velocity))
        return walls

    def regions(self, time: float) -> list[PlacedRegion]:
        """The walls that are regions, of a scene, where they are at a time; those whose shape or
        motion is known to LAMMPS alone are left out."""
        since = time - float(self.summary.get("start_time", 0.0))
        return [
            PlacedRegion(
                wall["name"],
                described_region(wall["region"]),
                wall["rate"] * (time - wall.get("start", 0.0)) + wall.get("turned", 0.0),
                np.array(wall["axis"]),
                since * np.array(wall["velocity"], dtype=float)[: self.dimension]
                + np.array(wall.get("moved", (0.0,) * self.dimension)),
            )
            for wall in self.summary.get("regions", [])
        ]


def cells_of_points(points: Array, grain: Array) -> Ints:
    """Cells between the nodes of each grain, from their positions alone: (m, d + 1).

    Delaunay's, without those that are longer than nodes are usually apart.
    """
    from scipy.spatial import Delaunay, QhullError, cKDTree

    d = points.shape[1]
    pieces = []
    for name in np.unique(grain):
        mine = np.flatnonzero(grain == name)
        if len(mine) <= d or name == 0:
            continue
        x = points[mine]
        usual = float(np.median(cKDTree(x).query(x, k=2)[0][:, 1]))
        try:
            found = Delaunay(x).simplices
        except QhullError:  # all in one line
            continue
        corners = x[found]
        longest = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=-1).max(axis=(1, 2))
        pieces.append(mine[found[longest < LONGEST * usual * math.sqrt(d / 2)]])
    return np.vstack(pieces).astype(np.int64) if pieces else np.zeros((0, d + 1), dtype=np.int64)


def _plane(words: tuple[str, ...]) -> dict[str, Any] | None:
    """A plane wall of a script, if it is given in plain numbers and does not move by a formula."""
    if words[0:1] != ("fix",) or words[3:5] != ("peridem/wall", "plane") or "move" in words:
        return None
    try:
        numbers = [float(word) for word in words[5:11]]
        at = words.index("velocity") if "velocity" in words else 0
        velocity = [float(word) for word in words[at + 1 : at + 4]] if at else [0.0] * 3
    except ValueError:
        return None
    return {"name": words[1], "point": numbers[:3], "normal": numbers[3:], "velocity": velocity}
