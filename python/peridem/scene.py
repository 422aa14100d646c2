"""A scene: grains, materials, contact, walls and loads, written as LAMMPS input.

:meth:`Scene.write` makes a folder with

- ``grains.data``: the nodes, one line each;
- ``in.grains``: the input script, to be read, edited and run by itself (:mod:`peridem.script`);
- ``mesh.vtu``: the cells of the grains in their reference position, for pictures (node i of the
  file is the atom with ID i + 1);
- ``scene.json``: what else pictures need (walls, contact radius, critical stretches).
"""

from __future__ import annotations

import json
import math
import shutil
import warnings
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from peridem.cloud import Cloud
from peridem.loads import Cut, Force, Motion, Nodes
from peridem.material import (
    AnyMaterial,
    Contact,
    Inert,
    Interface,
    Material,
    Solid,
    bulk_of,
    law_of,
)
from peridem.packing import Packing
from peridem.stages import START, Beginning, sides
from peridem.timestep import StableStep, pieces, stable_step
from peridem.walls import FIXES, AnyWall, RegionWall, Wall

__all__ = [
    "DATA",
    "DUMP",
    "FIXES",
    "MESH",
    "NODE_COLUMNS",
    "RESTART",
    "SCRIPT",
    "STOP",
    "SUMMARY",
    "WALLS",
    "Grain",
    "RegionWall",
    "Scene",
    "Wall",
    "box_walls",
    "grains_of",
    "surface_spacing",
]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

DATA, SCRIPT, MESH, SUMMARY = "grains.data", "in.grains", "mesh.vtu", "scene.json"
DUMP, WALLS, RESTART, STOP = "grains.dump", "walls.dat", "grains.restart", "stop"
NODE_COLUMNS = ("damage", "stretch", "dilatation", "energy", "bonds")
ATTRIBUTES = (
    *NODE_COLUMNS,
    *("surface", "fragment", "sxx", "syy", "szz", "sxy", "sxz", "syz"),
)


@dataclass(frozen=True, eq=False)
class Grain:
    """One grain: a cloud of nodes where it starts, and what it is made of.

    Attributes:
        cloud: nodes in their reference position.
        material: of all nodes that no part takes.
        parts: further materials, each with the nodes, (n,) true or false, that it is of.
        velocity: at the start, (d,) for all nodes or (n, d).
        displacement: of the nodes at the start, (n, d); None: they are in their reference position.
    """

    cloud: Cloud
    material: AnyMaterial
    parts: tuple[tuple[NDArray[np.bool_], AnyMaterial], ...] = ()
    velocity: Array | tuple[float, ...] | None = None
    displacement: Array | None = None

    def materials(self) -> list[AnyMaterial]:
        """All its materials, the main one first."""
        return [self.material, *(material for _, material in self.parts)]


@dataclass
class Scene:
    """All that a run needs.

    Attributes:
        title: first line of the script.
        grains: at least one.
        contact: of all grains and walls that ``pairs`` does not name.
        duration: simulated time, s.
        walls: planes and regions.
        gravity: (d,) acceleration.
        frames: how many dumps after the first.
        records: how many averages of the wall forces are written.
        safety: time step over the largest stable one.
        margin: how far the simulation box reaches beyond all; None: four contact radii.
        timestep: a fixed one; None: ``fix peridem/timestep`` finds and adjusts it.
        pairs: contact of two materials, by their names.
        interfaces: bonds between two materials of one grain.
        motions: prescribed motion of nodes.
        forces: forces on nodes, per volume.
        cuts: initial cracks.
        unbroken: nodes whose bonds among each other never break.
        attributes: further values of ``compute peridem/atom`` to dump, besides damage, stretch,
            dilatation, energy, bonds and, where bonds may break, fragment.
        columns: further columns of the dump (``fx fy``).
        energies: whether the thermo output has the account of all energy.
        start_time: time at the start.
        boundary: of the simulation box in the directions without periodicity: f (a node that leaves
            it is an error), s or m (the box follows the nodes); None: f on sides with a plane wall,
            s on the others.
        periodic: directions (0, 1, 2) in which the box repeats; they need ``box``.
        box: low and high corner of the simulation box; None: around everything.
        leapfrog: whether velocities start half a step ahead, which is symplectic Euler's rule.
        engine: of ``peridem/lps``: auto, general or batched; None: LAMMPS's choice.
        adapt: keywords of ``fix peridem/adapt``, which keeps grains rigid until they are loaded;
            None: ``fix nve`` moves all nodes.
        rest: a speed, root mean square of all nodes, below which the run ends early (not in the
            first tenth of its duration); None: it does not.
        notes: lines for the head of the script.
        source: what it was made from, kept in ``scene.json``; of a deck, its particles.
        begin: the state that it begins with, made by :meth:`after`; None: that of its grains.
    """

    title: str
    grains: Sequence[Grain]
    contact: Contact
    duration: float
    walls: Sequence[AnyWall] = ()
    gravity: tuple[float, ...] = (0.0, 0.0)
    frames: int = 100
    records: int = 1000
    safety: float = 0.8
    margin: float | None = None
    timestep: float | None = None
    pairs: Mapping[tuple[str, str], Contact] = field(default_factory=dict)
    interfaces: Sequence[Interface] = ()
    motions: Sequence[Motion] = ()
    forces: Sequence[Force] = ()
    cuts: Sequence[Cut] = ()
    unbroken: Nodes | None = None
    attributes: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    energies: bool = False
    start_time: float = 0.0
    boundary: str | None = None
    periodic: tuple[int, ...] = ()
    box: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    leapfrog: bool = False
    engine: str | None = None
    adapt: str | None = None
    rest: float | None = None
    notes: Sequence[str] = ()
    source: Mapping[str, Any] = field(default_factory=dict)
    begin: Beginning | None = None
    dimension: int = field(init=False)
    materials: list[AnyMaterial] = field(init=False)

    def __post_init__(self) -> None:
        if not self.grains:
            raise ValueError("scene: no grains")
        dimensions = {grain.cloud.dimension for grain in self.grains}
        if len(dimensions) != 1:
            raise ValueError("scene: grains of two and of three dimensions together")
        self.dimension = dimensions.pop()
        self._check_vectors()
        self._check_numbers()
        self._check_names()
        self._check_grains()
        found = dict.fromkeys(m for grain in self.grains for m in grain.materials())
        groups = dict.fromkeys(self.contact_group(m) for m in found)
        self.materials = [m for g in groups for m in found if self.contact_group(m) == g]
        self._check_pairs()
        self._check_mixtures()
        self._check_walls()
        self._check_loads()

    # ---- checks ----------------------------------------------------------------------------------

    def _check_vectors(self) -> None:
        d = self.dimension
        if self.gravity == (0.0, 0.0) and d == 3:
            self.gravity = (0.0, 0.0, 0.0)
        walls = []
        for wall in self.walls:
            still = not any(wall.velocity) and len(wall.velocity) != d
            walls.append(replace(wall, velocity=(0.0,) * d) if still else wall)
        self.walls = walls
        vectors: list[tuple[str, Sequence[object]]] = [("gravity", self.gravity)]
        for wall in walls:
            vectors.append((f"wall {wall.name}", wall.velocity))
            if isinstance(wall, Wall):
                vectors += [(f"wall {wall.name}", v) for v in (wall.point, wall.normal)]
        for motion in self.motions:
            vectors += [(f"motion {motion.name}", motion.velocity or motion.displacement)]
        vectors += [(f"force {force.name}", force.density) for force in self.forces]
        for what, vector in vectors:
            if vector and len(vector) != d:
                raise ValueError(f"scene: {what} needs {d} components, not {tuple(vector)}")

    def _check_numbers(self) -> None:
        for what in ("duration", "safety", "timestep", "rest"):
            value = getattr(self, what)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"scene: {what} must be above 0, not {value}")
        for what in ("frames", "records"):
            if getattr(self, what) < 1:
                raise ValueError(f"scene: {what} must be at least 1, not {getattr(self, what)}")
        if self.boundary not in (None, "f", "s", "m"):
            raise ValueError(f"scene: boundary must be f, s or m, not '{self.boundary}'")
        if self.engine not in (None, "auto", "general", "batched"):
            raise ValueError(f"scene: engine must be auto, general or batched, not '{self.engine}'")
        unknown = [a for a in self.attributes if a not in ATTRIBUTES]
        if unknown:
            raise ValueError(
                f"scene: attributes must be of {', '.join(ATTRIBUTES)}, not '{unknown[0]}'"
            )
        if not all(0 <= k < self.dimension for k in self.periodic):
            raise ValueError(f"scene: periodic directions must be below {self.dimension}")
        if self.periodic and self.box is None:
            raise ValueError("scene: a periodic scene needs its box")

    def _check_names(self) -> None:
        names = [thing.name for thing in (*self.walls, *self.motions, *self.forces)]
        if len(set(names)) < len(names):
            raise ValueError(
                f"scene: walls, motions and forces need different names, not {', '.join(names)}"
            )

    def _check_grains(self) -> None:
        d = self.dimension
        for number, grain in enumerate(self.grains, 1):
            n = len(grain.cloud.nodes)
            if grain.displacement is not None and grain.displacement.shape != (n, d):
                raise ValueError(
                    f"scene: grain {number} has {n} nodes; its displacement must be ({n}, {d}), "
                    f"not {grain.displacement.shape}"
                )
            if grain.velocity is not None and np.shape(grain.velocity) not in ((d,), (n, d)):
                raise ValueError(
                    f"scene: the velocity of grain {number} must be ({d},) or ({n}, {d}), "
                    f"not {np.shape(grain.velocity)}"
                )
            for mask, material in grain.parts:
                if mask.shape != (n,):
                    raise ValueError(
                        f"scene: the part '{material.name}' of grain {number} must be ({n},), "
                        f"not {mask.shape}"
                    )

    def _check_pairs(self) -> None:
        known = dict.fromkeys(m.name for m in self.materials)
        named = [(pair, "contact") for pair in self.pairs]
        named += [(interface.between, "interface") for interface in self.interfaces]
        for pair, what in named:
            for name in pair:
                if name not in known:
                    raise ValueError(
                        f"scene: {what} of {pair[0]} and {pair[1]}: no material '{name}', "
                        f"there are {', '.join(known)}"
                    )

    def _check_mixtures(self) -> None:
        """Whether LAMMPS can tell what holds between the materials of each style and each grain."""
        said = [set(interface.between) for interface in self.interfaces]
        solids = [m for m in self.materials if not isinstance(m, Inert)]
        for style in dict.fromkeys(m.style for m in solids):
            planes = {m.plane: m.name for m in solids if m.style == style}
            if len(planes) > 1 and self.dimension == 2:
                given = ", ".join(f"{plane} of '{name}'" for plane, name in planes.items())
                raise ValueError(f"scene: all materials must have the same plane, not {given}")
        for number, grain in enumerate(self.grains, 1):
            mine = [m for m in grain.materials() if not isinstance(m, Inert)] if grain.parts else []
            for a, b in combinations(mine, 2):
                if a.style != b.style or law_of(a) == law_of(b) or {a.name, b.name} in said:
                    continue
                raise ValueError(
                    f"scene: grain {number} is of '{a.name}' and '{b.name}', which differ in "
                    "influence, volume, breaking or potential; an Interface must say what bonds "
                    "between them are"
                )

    def _check_walls(self) -> None:
        inert = [isinstance(grain.material, Inert) for grain in self.grains]
        for wall in self.walls:
            for number, grain in enumerate(self.grains, 1):
                if inert[number - 1]:
                    continue  # bodies of nodes may be where they like
                nodes = self._start(grain) - self.shift_of(wall)
                if wall.nodes is not None:
                    touched = np.full(len(nodes), number)
                    nodes = nodes[wall.nodes.mask(touched, grain.cloud.nodes)]
                through = wall.behind(nodes) if len(nodes) else 0.0
                if through > 0.0:
                    how_far = f"{through:g} " if math.isfinite(through) else ""
                    raise ValueError(
                        f"scene: grain {number} reaches {how_far}through the wall '{wall.name}' "
                        "at the start; its normal must point to the grains"
                    )

    def _warn_of_pieces(self) -> None:
        """Of grains that are several bodies from the start, the largest of each mesh looked at."""
        kinds: dict[tuple[int, float], list[int]] = {}
        for number, grain in enumerate(self.grains, 1):
            reach = [m.horizon for m in grain.materials() if not isinstance(m, Inert)]
            if reach and not self.periodic:  # across a boundary there are more bonds
                # grains placed from one cloud share its cells
                kinds.setdefault((id(grain.cloud.cells), max(reach)), []).append(number)
        for (_, horizon), numbers in kinds.items():
            largest = max(numbers, key=lambda k: self.grains[k - 1].cloud.measure)
            cloud = self.grains[largest - 1].cloud
            sizes = pieces(cloud, horizon)
            if len(sizes) > 1:
                more = f" (and {len(numbers) - 1} more of its mesh)" if len(numbers) > 1 else ""
                nodes = ", ".join(map(str, sizes[:8])) + (", ..." if len(sizes) > 8 else "")
                warnings.warn(
                    f"scene: grain {largest}{more}, '{cloud.name}', is of {len(sizes)} pieces, of "
                    f"{nodes} nodes, that no bond within the horizon {horizon:g} joins: they move "
                    "as separate bodies with one molecule-ID; make a grain of each",
                    stacklevel=3,
                )

    def _check_loads(self) -> None:
        loads = [("motion", m.name, m.nodes) for m in self.motions]
        loads += [("force", f.name, f.nodes) for f in self.forces]
        loads += [("wall", w.name, w.nodes) for w in self.walls if w.nodes is not None]
        for what, name, nodes in loads:
            if not nodes.mask(self.grain_of_node, self.reference).any():
                raise ValueError(f"scene: {what} '{name}' has no nodes")

    # ---- nodes -----------------------------------------------------------------------------------

    @staticmethod
    def _start(grain: Grain) -> Array:
        """Where the nodes of a grain are at the start."""
        nodes = grain.cloud.nodes
        return nodes if grain.displacement is None else nodes + grain.displacement

    @cached_property
    def reference(self) -> Array:
        """Reference positions of all nodes, (n, d), in the order of their atom-IDs."""
        return np.vstack([grain.cloud.nodes for grain in self.grains])

    @cached_property
    def grain_of_node(self) -> Ints:
        """Number of each node's grain from 1, (n,)."""
        counts = [len(grain.cloud.nodes) for grain in self.grains]
        return np.repeat(np.arange(1, len(counts) + 1), counts)

    @cached_property
    def type_of_node(self) -> Ints:
        """Atom type of each node from 1, (n,)."""
        number = {material: k for k, material in enumerate(self.materials, 1)}
        types = []
        for grain in self.grains:
            mine = np.full(len(grain.cloud.nodes), number[grain.material])
            for mask, material in grain.parts:
                mine[mask] = number[material]
            types.append(mine)
        return np.concatenate(types)

    def dumped(self) -> list[str]:
        """Attributes of ``compute peridem/atom`` in dumps; fragments too where bonds may break."""
        solids = [m for m in self.materials if not isinstance(m, Inert)]
        breaks = any(math.isfinite(m.critical_stretch(self.dimension)) for m in solids)
        wanted = (*NODE_COLUMNS, *self.attributes, *(("fragment",) if breaks else ()))
        return list(dict.fromkeys(wanted))

    # ---- numbers that follow ---------------------------------------------------------------------

    def contact_group(self, material: AnyMaterial) -> tuple[str, float | None]:
        """Materials with the same one touch alike."""
        return material.name, bulk_of(material, self.dimension)

    def contact_of(self, a: AnyMaterial, b: AnyMaterial) -> Contact:
        """The contact of two materials."""
        given = self.pairs.get((a.name, b.name)) or self.pairs.get((b.name, a.name))
        return given or self.contact

    def modulus_of(self, a: AnyMaterial, b: AnyMaterial) -> float | None:
        """Harmonic mean of two bulk moduli; one that is missing counts as the other."""
        known = [k for k in (bulk_of(a, self.dimension), bulk_of(b, self.dimension)) if k]
        if not known:
            every = [k for m in self.materials if (k := bulk_of(m, self.dimension))]
            return max(every) if every else None
        return len(known) / sum(1.0 / k for k in known)

    @cached_property
    def contact_radius(self) -> float:
        """The contact radius, as given or 0.95 of the smallest spacing of boundary nodes."""
        if self.contact.radius is not None:
            return self.contact.radius
        return 0.95 * min(surface_spacing(cloud) for cloud, _ in self._kinds())

    def radius_of(self, contact: Contact) -> float:
        """Contact radius of a pair of materials."""
        return self.contact_radius if contact.radius is None else contact.radius

    @cached_property
    def radii(self) -> tuple[float, float]:
        """Smallest and largest contact radius of the scene."""
        all_ = [self.radius_of(contact) for contact in (self.contact, *self.pairs.values())]
        return min(all_), max(all_)

    @cached_property
    def _sizes(self) -> list[tuple[Cloud, AnyMaterial]]:
        """The smallest and the largest grain of each mesh and material."""
        found: dict[object, list[tuple[float, Cloud, AnyMaterial]]] = {}
        for grain in self.grains:
            c = grain.cloud
            for material in grain.materials():
                plain = material
                if not isinstance(material, Inert):
                    plain = replace(material, taper=None)
                entry = (float(c.volumes.sum()), c, material)
                found.setdefault((c.name, len(c.nodes), plain), []).append(entry)
        kinds = []
        for entries in found.values():
            small = min(entries, key=lambda entry: entry[0])
            large = max(entries, key=lambda entry: entry[0])
            kinds.append(small[1:])
            if large[0] > small[0] * (1.0 + 1e-6):
                kinds.append(large[1:])
        return kinds

    def _kinds(self) -> list[tuple[Cloud, AnyMaterial]]:
        """The smallest and the largest grain of each kind."""
        return self._sizes

    def stable_step(self) -> StableStep:
        """The largest stable time step at the start (see :mod:`peridem.timestep`)."""
        kinds = [(c, m) for c, m in self._kinds() if not isinstance(m, Inert)]
        clouds = [c for c, _ in kinds]
        solids: list[Solid] = [m for _, m in kinds]
        volumes = np.concatenate([c.volumes for c in clouds])
        ends = (float(volumes.min()), float(volumes.max()))
        spring = 0.0
        for a in self.materials:
            for b in self.materials[:1] if len(self.materials) > 20 else self.materials:
                bulk = self.modulus_of(a, b)
                if bulk is not None:
                    spring = max(spring, self.contact_of(a, b).spring(bulk, ends, self.dimension))
        return stable_step(clouds, solids, spring)

    @cached_property
    def _step(self) -> tuple[float, StableStep]:
        bonds = any(not isinstance(m, Inert) for m in self.materials)
        stable = self.stable_step() if bonds else StableStep(math.inf, math.inf)
        if not bonds and self.timestep is None:
            raise ValueError("scene: no grain has bonds, so a timestep must be given")
        if self.timestep is not None:
            return self.timestep, stable
        return float(f"{self.safety * stable.together:.2g}"), stable

    def _timestep(self) -> tuple[float, StableStep]:
        return self._step

    @property
    def sides(self) -> list[str]:
        """What LAMMPS's ``boundary`` says of each direction: one letter, or two for unlike ends."""
        found = []
        for k in range(3):
            if k in self.periodic or k >= self.dimension:
                found.append("p")
                continue
            if self.boundary is not None:
                found.append(self.boundary)
                continue
            facing = [w.unit_normal[k] for w in self.walls if isinstance(w, Wall)]
            low, high = (any(sign * n > 0.99 for n in facing) for sign in (1.0, -1.0))
            ends = ("f" if low else "s") + ("f" if high else "s")
            found.append(ends[0] if low == high else ends)
        return found

    @property
    def adaptive(self) -> bool:
        """Whether ``fix peridem/timestep`` adjusts the step; ``fix move`` wants a constant one."""
        return self.timestep is None and all(motion.steady for motion in self.motions)

    def corners(self) -> tuple[Array, Array]:
        """Low and high corner of the simulation box: as given, or around all nodes and walls."""
        if self.box is not None:
            return np.array(self.box[0], dtype=float), np.array(self.box[1], dtype=float)
        margin = 4.0 * self.radii[1] if self.margin is None else self.margin
        points = [self._start(grain) for grain in self.grains]
        for wall in self.walls:
            points += [p + self.shift_of(wall)] if len(p := wall.corners(self.duration)) else []
        for motion in self.motions:
            if motion.steady:
                mask = motion.nodes.mask(self.grain_of_node, self.reference)
                way = self.duration * np.array([v or 0.0 for v in motion.velocity])
                points.append(self.reference[mask] + way)
        everything = np.vstack(points)
        return everything.min(axis=0) - margin, everything.max(axis=0) + margin

    # ---- stages ----------------------------------------------------------------------------------

    def after(
        self,
        path: str | Path,
        put: Collection[str] = (),
        bodies: Mapping[int, Sequence[float]] | None = None,
        **changes: Any,
    ) -> Scene:
        """The scene that begins with the state in which the run of this one has ended.

        Args:
            path: the folder of that run, or a restart file in it.
            put: names of walls that start at their points; the others go on from where they are.
            bodies: grains without bonds (:class:`peridem.material.Inert`) that are put elsewhere:
                their numbers from 1, and the displacement from their reference positions, (d,).
            changes: attributes that are other ones from now on: title, duration, walls, ...

        Raises:
            FileNotFoundError: there is no restart file.
            ValueError: the run was one of other grains, or the changes do not go with it.
        """
        from peridem.stages import after

        return after(self, path, put, bodies, **changes)

    # ---- files -----------------------------------------------------------------------------------

    def script(self) -> str:
        """The input script."""
        from peridem.script import script

        return script(self)

    def write(self, folder: str | Path) -> Path:
        """Write the scene into a folder, made if missing; returns the path of the input script.

        A warning names grains of several pieces that no bond joins.

        Raises:
            ValueError: a node without a bond within the horizon.
        """
        script = self.script()
        self._warn_of_pieces()
        folder = Path(folder)
        begin = self.begin.restart if self.begin is not None else None
        new = begin is not None and begin != (folder / START).resolve()
        if new and begin is not None and begin.parent == folder.resolve():
            raise ValueError(f"{folder}: the scene begins with the run there: another one needed")
        folder.mkdir(parents=True, exist_ok=True)
        (folder / DATA).write_text(self.data())
        if new and begin is not None:
            shutil.copyfile(begin, folder / START)
        (folder / SCRIPT).write_text(script)
        self._write_mesh(folder / MESH)
        (folder / SUMMARY).write_text(json.dumps(self._summary(), indent=1) + "\n")
        return folder / SCRIPT

    @property
    def displaced(self) -> bool:
        """Whether a grain does not start in its reference position."""
        return any(grain.displacement is not None for grain in self.grains)

    def data(self) -> str:
        """The data file; numbers have all their digits."""
        low, high = self.corners()
        if self.dimension == 2:
            low, high = np.append(low, -0.5), np.append(high, 0.5)  # unit thickness
        what = "node, grain, material, volume, density, x, y, z"
        what += ", reference position" if self.displaced else ""
        lines = [
            f"{self.title}; columns of Atoms: {what}",
            "",
            f"{len(self.reference)} atoms",
            f"{len(self.materials)} atom types",
            "",
            *(f"{a:.10g} {b:.10g} {k}lo {k}hi" for a, b, k in zip(low, high, "xyz", strict=True)),
            "",
            "Atoms # peridem",
            "",
            *self._atom_lines(),
        ]
        velocities = self._velocity_lines()
        if velocities:
            lines += ["", "Velocities", "", *velocities]
        return "\n".join(lines) + "\n"

    def _atom_lines(self) -> list[str]:
        pad = [(0, 0), (0, 3 - self.dimension)]
        start = np.vstack([self._start(grain) for grain in self.grains])
        columns = [np.pad(start, pad)]
        if self.displaced:
            columns.append(np.pad(self.reference, pad))
        volumes = np.concatenate([grain.cloud.volumes for grain in self.grains])
        density = np.array([m.density for m in self.materials])[self.type_of_node - 1]
        rows = zip(
            self.grain_of_node.tolist(),
            self.type_of_node.tolist(),
            volumes.tolist(),
            density.tolist(),
            np.hstack(columns).tolist(),
            strict=True,
        )
        return [
            f"{k} {grain} {kind} {volume!r} {rho!r} {' '.join(map(repr, place))}"
            for k, (grain, kind, volume, rho, place) in enumerate(rows, 1)
        ]

    def _velocity_lines(self) -> list[str]:
        if all(grain.velocity is None for grain in self.grains):
            return []
        every = []
        for grain in self.grains:
            shape = grain.cloud.nodes.shape
            given = 0.0 if grain.velocity is None else np.asarray(grain.velocity, dtype=float)
            every.append(np.broadcast_to(given, shape))
        rows = np.pad(np.vstack(every), ((0, 0), (0, 3 - self.dimension))).tolist()
        return [f"{k} {' '.join(map(repr, row))}" for k, row in enumerate(rows, 1)]

    def _write_mesh(self, path: Path) -> None:
        import meshio

        cells, surface, first = [], [], 0
        for grain in self.grains:
            cells.append(grain.cloud.cells + first)
            surface.append(grain.cloud.surface.astype(np.int64))
            first += len(grain.cloud.nodes)
        kind = {2: "triangle", 3: "tetra"}[self.dimension]
        meshio.Mesh(
            np.pad(self.reference, ((0, 0), (0, 3 - self.dimension))),
            [(kind, np.vstack(cells))],
            point_data={"grain": self.grain_of_node, "surface": np.concatenate(surface)},
        ).write(path)

    def _interface_stretches(self) -> list[tuple[int, int, float]]:
        """Two atom types and the stretch at which bonds between them break, where it is known."""
        found = []
        for i, a in enumerate(self.materials, 1):
            for j, b in enumerate(self.materials[: i - 1], 1):
                for interface in self.interfaces:
                    if {a.name, b.name} == set(interface.between):
                        stretch = interface.critical_stretch(a, b, self.dimension)
                        found += [] if stretch is None else [(j, i, stretch)]
        return found

    def shift_of(self, wall: AnyWall) -> Array:
        """How far a wall is from its point at the start, (d,)."""
        return np.zeros(self.dimension) if self.begin is None else self.begin.shift(wall)

    def _said(self, wall: Wall) -> Wall:
        """As the script has it."""
        said = wall if self.begin is None else self.begin.said(wall)
        assert isinstance(said, Wall)
        return said

    def _summary(self) -> dict[str, object]:
        stretches = [
            math.inf if isinstance(m, Inert) else m.critical_stretch(self.dimension)
            for m in self.materials
        ]
        return {
            "title": self.title,
            "source": dict(self.source),
            "dimension": self.dimension,
            "contact_radius": self.contact_radius,
            "sides": sides(self),
            "critical_stretch": [s if math.isfinite(s) else None for s in stretches],
            "interfaces": self._interface_stretches(),
            "materials": [m.name for m in self.materials],
            "timestep": self._timestep()[0],
            "adaptive": self.adaptive,
            "start_time": self.start_time,
            "duration": self.duration,
            "node_columns": self.dumped(),
            "walls": [
                {
                    "name": wall.name,
                    "point": (np.array(wall.point) + self.shift_of(wall)).tolist(),
                    "origin": list(wall.point),
                    "said": list(self._said(wall).point),
                    "normal": wall.unit_normal.tolist(),
                    "velocity": list(wall.velocity),
                }
                for wall in self.walls
                if isinstance(wall, Wall)
            ],
            "regions": [
                wall.described() | {"moved": self.shift_of(wall).tolist()}
                for wall in self.walls
                if isinstance(wall, RegionWall) and wall.drawable
            ],
        }


def grains_of(
    packing: Packing, clouds: Sequence[Cloud], materials: Material | Sequence[Material]
) -> list[Grain]:
    """Grains from a packing.

    Args:
        packing: where they go.
        clouds: one mesh for each of the packing's outlines.
        materials: one for all, or one for each of the packing's outlines.
    """
    if isinstance(materials, Material):
        materials = [materials] * len(packing.outlines)
    if not len(clouds) == len(materials) == len(packing.outlines):
        raise ValueError(
            f"{len(packing.outlines)} outlines with {len(clouds)} clouds "
            f"and {len(materials)} materials; one of each for an outline needed"
        )
    grains = []
    for kind, position, angle, scale in zip(
        packing.kind, packing.position, packing.angle, packing.scale, strict=True
    ):
        cloud = clouds[kind].placed(position, angle, float(scale))
        grains.append(Grain(cloud, materials[kind]))
    return grains


def box_walls(low: Sequence[float], high: Sequence[float], lid_velocity: float = 0.0) -> list[Wall]:
    """Walls of a box: ``floor``, ``left``, ``right`` and ``lid``, which may move upwards; in 3D
    ``front`` and ``back`` as well. Upwards is y in 2D and z in 3D.
    """
    if len(low) == 2:
        (x0, y0), (x1, y1) = low, high
        return [
            Wall("floor", (x0, y0), (0.0, 1.0)),
            Wall("left", (x0, y0), (1.0, 0.0)),
            Wall("right", (x1, y0), (-1.0, 0.0)),
            Wall("lid", (x0, y1), (0.0, -1.0), (0.0, lid_velocity)),
        ]
    start, end, still = (*low,), (*high,), (0.0, 0.0, 0.0)
    return [
        Wall("floor", start, (0.0, 0.0, 1.0), still),
        Wall("left", start, (1.0, 0.0, 0.0), still),
        Wall("right", end, (-1.0, 0.0, 0.0), still),
        Wall("front", start, (0.0, 1.0, 0.0), still),
        Wall("back", end, (0.0, -1.0, 0.0), still),
        Wall("lid", end, (0.0, 0.0, -1.0), (0.0, 0.0, lid_velocity)),
    ]


def spacings(cloud: Cloud) -> Array:
    """Lengths of the sides of the cells."""
    ends = cloud.nodes[cloud.edges]
    return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))


def surface_spacing(cloud: Cloud) -> float:
    """Smallest spacing of neighbouring nodes on the boundary of a cloud: 0.95 of it is the contact
    radius where none is given.
    """
    return float(spacings(cloud)[cloud.surface[cloud.edges].all(axis=1)].min())
