"""A scene: grains, materials, contact, walls and loads, written as LAMMPS input.

:meth:`Scene.write` makes a folder with

- ``grains.data``: the nodes, one line each;
- ``in.grains``: the input script, to be read, edited and run by itself;
- ``mesh.vtu``: the cells of the grains in their reference position, for pictures (node i of the
  file is the atom with ID i + 1);
- ``scene.json``: what else pictures need (walls, contact radius, critical stretches).
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from peridem import __version__
from peridem.cloud import Cloud
from peridem.material import Contact, Material
from peridem.packing import Packing
from peridem.timestep import StableStep, stable_step

Array = NDArray[np.float64]

DATA, SCRIPT, MESH, SUMMARY = "grains.data", "in.grains", "mesh.vtu", "scene.json"
DUMP, WALLS, RESTART, STOP = "grains.dump", "walls.dat", "grains.restart", "stop"
FIXES = ("weight", "motion", "walls", "halt")  # IDs of the script's own fixes


@dataclass(frozen=True, eq=False)
class Grain:
    """One grain: a cloud of nodes where it starts, and what it is made of."""

    cloud: Cloud
    material: Material


@dataclass(frozen=True)
class Wall:
    """A plane wall.

    Attributes:
        name: the ID of its fix; letters, digits and underscores.
        point: (d,) a point on it at the start.
        normal: (d,) into the side where the grains are; any length.
        velocity: (d,) of the wall, constant.
    """

    name: str
    point: tuple[float, ...]
    normal: tuple[float, ...]
    velocity: tuple[float, ...] = (0.0, 0.0)

    def __post_init__(self) -> None:
        if not re.fullmatch(r"\w+", self.name):
            raise ValueError(f"wall '{self.name}': a name has letters, digits and underscores only")
        if self.name in FIXES:
            raise ValueError(f"wall '{self.name}': the script needs the names {', '.join(FIXES)}")
        values = (*self.point, *self.normal, *self.velocity)
        if not np.isfinite(values).all() or not any(self.normal):
            raise ValueError(f"wall '{self.name}': finite values and a normal other than 0 needed")

    @property
    def moves(self) -> bool:
        """Whether it has a velocity."""
        return any(self.velocity)

    @property
    def unit_normal(self) -> Array:
        """Normal of length 1."""
        normal = np.asarray(self.normal, dtype=float)
        return np.asarray(normal / np.linalg.norm(normal))


@dataclass
class Scene:
    """All that a run needs.

    Attributes:
        title: first line of the script.
        grains: at least one.
        contact: of all grains and walls.
        walls: plane walls.
        duration: simulated time, s.
        gravity: (d,) acceleration.
        frames: how many dumps after the first.
        records: how many averages of the wall forces are written.
        safety: time step over the largest stable one.
        margin: how far the simulation box reaches beyond all; None: four contact radii.
    """

    title: str
    grains: Sequence[Grain]
    contact: Contact
    duration: float
    walls: Sequence[Wall] = ()
    gravity: tuple[float, ...] = (0.0, 0.0)
    frames: int = 100
    records: int = 1000
    safety: float = 0.8
    margin: float | None = None
    dimension: int = field(init=False)
    materials: list[Material] = field(init=False)

    def __post_init__(self) -> None:
        if not self.grains:
            raise ValueError("scene: no grains")
        dimensions = {grain.cloud.dimension for grain in self.grains}
        if len(dimensions) != 1:
            raise ValueError("scene: grains of two and of three dimensions together")
        self.dimension = dimensions.pop()
        vectors = [("gravity", self.gravity)]
        for wall in self.walls:
            vectors += [(f"wall {wall.name}", v) for v in (wall.point, wall.normal, wall.velocity)]
        for what, vector in vectors:
            if len(vector) != self.dimension:
                raise ValueError(f"scene: {what} needs {self.dimension} components, not {vector}")
        names = [wall.name for wall in self.walls]
        if len(set(names)) < len(names):
            raise ValueError(f"scene: walls need different names, not {names}")
        for what in ("duration", "safety"):
            value = getattr(self, what)
            if not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"scene: {what} must be above 0, not {value}")
        for what in ("frames", "records"):
            if getattr(self, what) < 1:
                raise ValueError(f"scene: {what} must be at least 1, not {getattr(self, what)}")
        self.materials = list(dict.fromkeys(grain.material for grain in self.grains))
        self._check_walls()

    def _check_walls(self) -> None:
        for wall in self.walls:
            for number, grain in enumerate(self.grains, 1):
                gap = ((grain.cloud.nodes - wall.point) @ wall.unit_normal).min()
                if gap < 0.0:
                    raise ValueError(
                        f"scene: grain {number} reaches {-gap:g} through the wall '{wall.name}' "
                        "at the start; its normal must point to the grains"
                    )

    # ---- numbers that follow ---------------------------------------------------------------------

    @property
    def contact_radius(self) -> float:
        """The contact radius: as given, or 0.95 of the smallest spacing of boundary nodes."""
        if self.contact.radius is not None:
            return self.contact.radius
        return 0.95 * min(_surface_spacing(cloud) for cloud, _ in self._kinds())

    def _kinds(self) -> list[tuple[Cloud, Material]]:
        """One grain of each kind: the same mesh at the same size, of the same material."""
        kinds: dict[object, tuple[Cloud, Material]] = {}
        for grain in self.grains:
            c = grain.cloud
            key = (c.name, len(c.nodes), f"{c.volumes.sum():.6e} {c.volumes.min():.6e}")
            kinds.setdefault((key, grain.material), (c, grain.material))
        return list(kinds.values())

    def stable_step(self) -> StableStep:
        """The largest stable time step (see :mod:`peridem.timestep`)."""
        kinds = self._kinds()
        clouds, materials = [c for c, _ in kinds], [m for _, m in kinds]
        size = max(float(c.cell_sizes.max()) for c in clouds) ** (self.dimension - 2)
        spring = self.contact.stiff * max(m.bulk for m in materials) * size
        return stable_step(clouds, materials, spring)

    def _box(self) -> tuple[Array, Array]:
        """Low and high corner of the simulation box: around all nodes and all walls."""
        margin = 4.0 * self.contact_radius if self.margin is None else self.margin
        points = [grain.cloud.nodes for grain in self.grains]
        points += [np.atleast_2d(wall.point) for wall in self.walls]
        points += [
            np.atleast_2d(wall.point) + self.duration * np.asarray(wall.velocity)
            for wall in self.walls
        ]
        everything = np.vstack(points)
        return everything.min(axis=0) - margin, everything.max(axis=0) + margin

    # ---- files -----------------------------------------------------------------------------------

    def write(self, folder: str | Path) -> Path:
        """Write the scene into a folder, made if missing; returns the path of the input script.

        Raises:
            ValueError: a node without a bond within the horizon.
        """
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        script = self.script()
        (folder / DATA).write_text(self.data())
        (folder / SCRIPT).write_text(script)
        self._write_mesh(folder / MESH)
        (folder / SUMMARY).write_text(json.dumps(self._summary(), indent=1) + "\n")
        return folder / SCRIPT

    def data(self) -> str:
        """The data file."""
        low, high = self._box()
        if self.dimension == 2:
            low, high = np.append(low, -0.5), np.append(high, 0.5)  # unit thickness
        count = sum(len(grain.cloud.nodes) for grain in self.grains)
        lines = [
            f"{self.title}; columns of Atoms: node, grain, material, volume, density, x, y, z",
            "",
            f"{count} atoms",
            f"{len(self.materials)} atom types",
            "",
            *(f"{a:.10g} {b:.10g} {k}lo {k}hi" for a, b, k in zip(low, high, "xyz", strict=True)),
            "",
            "Atoms # peridem",
            "",
        ]
        node = 0
        for number, grain in enumerate(self.grains, 1):
            kind = self.materials.index(grain.material) + 1
            cloud, density = grain.cloud, grain.material.density
            position = np.zeros((len(cloud.nodes), 3))
            position[:, : self.dimension] = cloud.nodes
            for volume, (x, y, z) in zip(cloud.volumes, position, strict=True):
                node += 1
                lines.append(
                    f"{node} {number} {kind} {volume:.12g} {density:g} {x:.12g} {y:.12g} {z:.12g}"
                )
        return "\n".join(lines) + "\n"

    def _write_mesh(self, path: Path) -> None:
        import meshio

        nodes, cells, grain_of_node, surface = [], [], [], []
        first = 0
        for number, grain in enumerate(self.grains, 1):
            cloud = grain.cloud
            nodes.append(np.pad(cloud.nodes, ((0, 0), (0, 3 - self.dimension))))
            cells.append(cloud.cells + first)
            grain_of_node.append(np.full(len(cloud.nodes), number))
            surface.append(cloud.surface.astype(np.int64))
            first += len(cloud.nodes)
        kind = {2: "triangle", 3: "tetra"}[self.dimension]
        meshio.Mesh(
            np.vstack(nodes),
            [(kind, np.vstack(cells))],
            point_data={"grain": np.concatenate(grain_of_node), "surface": np.concatenate(surface)},
        ).write(path)

    def _summary(self) -> dict[str, object]:
        stretches = [m.critical_stretch(self.dimension) for m in self.materials]
        return {
            "title": self.title,
            "dimension": self.dimension,
            "contact_radius": self.contact_radius,
            "critical_stretch": [s if math.isfinite(s) else None for s in stretches],
            "timestep": self._timestep()[0],
            "walls": [
                {
                    "name": wall.name,
                    "point": list(wall.point),
                    "normal": wall.unit_normal.tolist(),
                    "velocity": list(wall.velocity),
                }
                for wall in self.walls
            ],
        }

    def _timestep(self) -> tuple[float, StableStep]:
        stable = self.stable_step()
        return float(f"{self.safety * stable.together:.2g}"), stable

    # ---- the script ------------------------------------------------------------------------------

    def script(self) -> str:
        """The input script."""
        step, stable = self._timestep()
        total = math.ceil(self.duration / step)
        frame = max(1, round(total / self.frames))
        record = max(1, round(total / self.records))
        total = math.ceil(total / frame) * frame
        sections = [
            self._script_head(),
            self._script_solids(),
            self._script_contact(),
            self._script_walls(),
            self._script_motion(step, stable),
            self._script_output(frame, record),
            self._script_run(total, frame, step),
        ]
        return "\n".join(sections)

    def _script_head(self) -> str:
        count = sum(len(grain.cloud.nodes) for grain in self.grains)
        d = self.dimension
        plane = "2D with unit thickness: volumes are areas, forces are N per m of thickness."
        boundary = "f f p" if d == 2 else "f f f"
        return f"""\
# {self.title}
#
# {len(self.grains)} grains of together {count} nodes. Made by peridem {__version__}; edit it as you
# like, nothing reads it back. Run it in this folder with
#     mpirun -np 2 lmp -in {SCRIPT}
# SI units: m, kg, s, N, Pa. {plane if d == 2 else ""}

units           si
dimension       {d}
boundary        {boundary:<24}# a node that leaves the box is an error: the walls are inside it
atom_style      peridem
read_data       {DATA:<24}# columns: node, grain, material, volume, density, x, y, z
"""

    def _script_solids(self) -> str:
        d = self.dimension
        lines = ["# ---- solids: one atom type for each material", ""]
        lines.append("pair_style      hybrid/overlay peridem/lps peridem/contact")
        for kind, m in enumerate(self.materials, 1):
            clouds = [g.cloud for g in self.grains if g.material == m]
            spacing = float(np.median(np.concatenate([_spacings(c) for c in clouds])))
            stretch = m.critical_stretch(d)
            breaks = "bonds never break"
            if math.isfinite(stretch):
                why = f" = sqrt(Gc m/(d^2 kappa' I)) for Gc = {m.gc:g} N/m" if m.gc else ""
                breaks = f"bonds break at a stretch of {stretch:.3g}{why}"
            lines += [
                f"# {m.name}: G = {m.shear:.4g} Pa, waves travel at {m.wave_speed(d):.3g} m/s",
                f"# horizon = {m.horizon / spacing:.2g} node spacings (median {spacing:.3g} m)",
                f"# {breaks}",
                f"pair_coeff      {kind} {kind} peridem/lps {m.pair_coeff(d)}",
            ]
        return "\n".join(lines) + "\n"

    def _script_contact(self) -> str:
        radius = self.contact_radius
        where = (
            "as given"
            if self.contact.radius is not None
            else "0.95 of the smallest spacing of boundary nodes"
        )
        lines = [
            "# ---- contact between nodes of different grains and of fragments",
            f"# radius: {where}",
            "# modulus: bulk modulus, the harmonic mean of two materials",
            f"# form bulk: the spring of two nodes is {self.contact.stiff:g} times the modulus"
            + (" (times their size)" if self.dimension == 3 else ""),
            "",
        ]
        n = len(self.materials)
        for i in range(n):
            for j in range(i, n):
                a, b = self.materials[i].bulk, self.materials[j].bulk
                words = self.contact.keywords(radius, 2.0 * a * b / (a + b))
                pair = "* *" if n == 1 else f"{i + 1} {j + 1}"
                lines.append(f"pair_coeff      {pair} peridem/contact {words}")
        skin = 0.3 * radius
        lines += [
            f"neighbor        {skin:.3g} bin".ljust(40)
            + "# skin: 0.3 contact radii (the default in si units is 1 mm)",
            "neigh_modify    every 1 delay 0 check yes",
        ]
        return "\n".join(lines) + "\n"

    def _script_walls(self) -> str:
        if not self.walls:
            return "# ---- no walls\n"
        lines = [
            "# ---- walls: a point, the normal towards the grains, a velocity;",
            "# contact as of each node's own material with itself",
            "",
        ]
        for wall in self.walls:
            line = f"fix {wall.name} all peridem/wall plane {_vector(wall.point)}"
            line += f"  {_vector(wall.normal)}"
            if wall.moves:
                line += f"  velocity {_vector(wall.velocity)}"
            lines.append(line)
        return "\n".join(lines) + "\n"

    def _script_motion(self, step: float, stable: StableStep) -> str:
        lines = ["# ---- loads, motion and time step", ""]
        strength = float(np.linalg.norm(self.gravity))
        if strength:
            towards = _vector(tuple(g / strength for g in self.gravity))
            lines.append(f"fix weight all gravity {strength:.8g} vector {towards}")
        lines += [
            "fix motion all nve",
            f"# stable up to {stable.bonds:.3g} s for bonds alone (highest frequency of a grain),",
            f"# {stable.contacts:.3g} s for contacts (each node pressed by several at once),",
            f"# {stable.together:.3g} s for both, with viscosity; taken: {self.safety:g} of that",
            f"timestep        {step:.8g}",
        ]
        return "\n".join(lines) + "\n"

    def _script_output(self, frame: int, record: int) -> str:
        columns = " ".join(f"c_node[{i}]" for i in range(1, len(NODE_COLUMNS) + 1))
        position, velocity = ("x y", "vx vy") if self.dimension == 2 else ("x y z", "vx vy vz")
        lines = [
            "# ---- output",
            f"# columns of c_node: {', '.join(NODE_COLUMNS)}",
            "",
            f"compute node all peridem/atom {' '.join(NODE_COLUMNS)}",
            f"dump grains all custom {frame} {DUMP} id mol type {position} {velocity} {columns}",
            "dump_modify grains sort id",
            "compute damage all reduce ave c_node[1]",
        ]
        shown = "step time c_damage pe ke"
        moving = [wall for wall in self.walls if wall.moves]
        for wall in moving:
            shown += f" v_{wall.name}_travel v_{wall.name}_force"
            speed = float(np.linalg.norm(wall.velocity))
            force = "+".join(
                f"({-n:.8g})*f_{wall.name}[{k}]" for k, n in enumerate(wall.unit_normal, 1) if n
            )
            lines += [
                f"# how far the wall '{wall.name}' has gone, and the force that pushes it back",
                f"variable {wall.name}_travel equal {speed:.8g}*time",
                f"variable {wall.name}_force equal {force}",
            ]
        if self.walls:
            names = [
                f"f_{wall.name}[{k + 1}]" for wall in self.walls for k in range(self.dimension)
            ]
            names = [f"v_{wall.name}_travel" for wall in moving] + names
            lines += [
                f"# forces on the walls, averaged over {record} steps",
                f"fix walls all ave/time 1 {record} {record} {' '.join(names)} file {WALLS}",
            ]
        lines += [
            f"thermo          {frame}",
            f"thermo_style    custom {shown}",
            "thermo_modify   flush yes norm no",
        ]
        return "\n".join(lines) + "\n"

    def _script_run(self, total: int, frame: int, step: float) -> str:
        every = max(1, total // 10 // frame) * frame
        return f"""\
# ---- run: {total} steps of {step:g} s; a file named '{STOP}' in this folder ends it early

variable halted equal is_file({STOP})
fix halt all halt {max(1, frame // 4)} v_halted > 0 error soft
restart         {every} {RESTART}.1 {RESTART}.2
run             {total}
write_restart   {RESTART}
"""


NODE_COLUMNS = ("damage", "stretch", "dilatation", "energy", "bonds")


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
        cloud = clouds[kind].placed(position, float(angle), float(scale))
        grains.append(Grain(cloud, materials[kind]))
    return grains


def box_walls(low: Sequence[float], high: Sequence[float], lid_velocity: float = 0.0) -> list[Wall]:
    """Four walls of a 2D box: ``floor``, ``left``, ``right`` and ``lid``, which may move in y."""
    (x0, y0), (x1, y1) = low, high
    return [
        Wall("floor", (x0, y0), (0.0, 1.0)),
        Wall("left", (x0, y0), (1.0, 0.0)),
        Wall("right", (x1, y0), (-1.0, 0.0)),
        Wall("lid", (x0, y1), (0.0, -1.0), (0.0, lid_velocity)),
    ]


def _spacings(cloud: Cloud) -> Array:
    """Lengths of the sides of the cells."""
    ends = cloud.nodes[cloud.edges]
    return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))


def _surface_spacing(cloud: Cloud) -> float:
    """Smallest spacing of neighbouring nodes on the boundary."""
    return float(_spacings(cloud)[cloud.surface[cloud.edges].all(axis=1)].min())


def _vector(values: Sequence[float]) -> str:
    """Three numbers, the last of a 2D vector 0."""
    return " ".join(f"{v + 0.0:.8g}" for v in (*values, 0.0)[:3])
