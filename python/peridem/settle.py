"""Packings settled by gravity: rigid grains fall and come to rest in LAMMPS.

What is free fall needs no simulation: before, each grain is put straight down on what lies below it
(:func:`peridem.packing.dropped`). Grains are clouds of nodes that move as rigid bodies
(fix rigid/small) and touch through peridem/contact. Lengths are measured in the largest grain's
radius, the density and gravity are 1: at rest, a packing depends on neither. Nothing of this run is
kept but where the grains end.
"""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from peridem.cloud import Cloud, mesh
from peridem.packing import Packing, dropped
from peridem.placing import Container

Array = NDArray[np.float64]

# Speed that drag lets a grain of radius 1 reach as it falls; free fall over its radius gives 1.4.
SPEED = 1.5
# How deep contacts may be, over the padding: in passing at that speed, and at rest.
DEPTH_PASSING, DEPTH_RESTING = 0.4, 0.05
# Grains that start closer than they may be at rest are pushed apart first, in so many stages.
STAGES, STAGE_STEPS = 10, 160


@dataclass(frozen=True, eq=False)
class _Bodies:
    """The grains as nodes, in units of the largest radius, and what follows from them."""

    nodes: Array
    volumes: Array
    grain: NDArray[np.int64]
    padding: float
    surface_spacing: float
    low: Array
    high: Array
    unit: float
    periodic: tuple[bool, ...]

    @property
    def dimension(self) -> int:
        return self.nodes.shape[1]

    @property
    def masses(self) -> Array:
        return np.asarray(np.bincount(self.grain, self.volumes), dtype=float)

    @property
    def contact_radius(self) -> float:
        """Distance of touching nodes that keeps the shapes between them a padding apart.

        A point of one surface opposite the middle between nodes of the other (half their distance
        away in the plane, 1/sqrt(3) of it in space) is closer to the surface than to the nodes.
        """
        off = self.surface_spacing * (0.5 if self.dimension == 2 else 1.0 / math.sqrt(3.0))
        return math.hypot((1.0 + 2.0 * DEPTH_RESTING) * self.padding, off)

    @cached_property
    def clearance(self) -> float:
        """Smallest distance of two nodes of different grains, or of a node and a side of the box,
        as far as it is below the contact radius."""
        reach = self.contact_radius
        i, j = cKDTree(self.nodes).query_pairs(reach, output_type="ndarray").T
        other = self.grain[i] != self.grain[j]
        near = np.linalg.norm(self.nodes[i] - self.nodes[j], axis=1)[other]
        fixed = ~np.array(self.periodic)
        sides = np.concatenate([self.nodes - self.low, self.high - self.nodes], axis=1)
        sides = sides[:, np.tile(fixed, 2)]
        return float(min([reach, *near, sides.min()]))

    @property
    def fall(self) -> float:
        """How far the heap may still sink: to where its grains would fill the box below."""
        across = np.prod((self.high - self.low)[:-1])
        height = float(self.nodes[:, -1].max() - self.low[-1])
        return max(0.0, height - float(self.volumes.sum() / across))

    @property
    def spring(self) -> float:
        """Of one pair of nodes: stiff enough for a falling grain and for the weight of a column."""
        heaviest = float(self.masses.max())
        passing = heaviest * (SPEED / (DEPTH_PASSING * self.padding)) ** 2
        column = heaviest * max(2.0, 0.5 * float(self.nodes[:, -1].max() - self.low[-1]))
        return max(passing, column / (DEPTH_RESTING * self.padding))

    @property
    def step(self) -> float:
        """A tenth of the time scale of the lightest grain with ten touching nodes."""
        return 0.1 * math.sqrt(float(self.masses.min()) / (10.0 * self.spring))


def settled(
    packing: Packing,
    padding: float,
    spacing: float | None = None,
    friction: float = 0.0,
    lmp: str | Path | None = None,
    ranks: int = 1,
) -> Packing:
    """The packing after its grains have fallen along the last axis and come to rest.

    Args:
        packing: grains in a container that is a box, apart from each other.
        padding: smallest gap between grains, and between grains and box, at the end.
        spacing: of the nodes that stand for the grains while they fall; None: the padding, at most
            a third of the smallest grain's radius.
        friction: Coulomb's coefficient between grains and with the box; more makes looser heaps.
        lmp: the lmp program (see :func:`peridem.run.find_lmp`).
        ranks: MPI processes.

    Raises:
        ValueError: the packing has no container, or one without a floor.
        RuntimeError: grains are closer than the padding at the end, or have not come to rest.
        peridem.run.RunError: LAMMPS cannot be run, or fails.
    """
    from peridem import run

    box = packing.container
    if box is None or box.inside is not None or box.periodic[-1]:
        raise ValueError("settled packing: a packing in a box with a floor and a top needed")
    if not (math.isfinite(friction) and friction >= 0.0):
        raise ValueError(f"settled packing: friction must be at least 0, not {friction}")
    radius = packing.reaches()
    spacing = spacing or min(padding, float(radius.min()) / 3.0)
    clouds = _clouds(packing, spacing)
    gap = packing.smallest_gap()[0]
    if not gap > 1e-6 * float(radius.max()):
        raise ValueError("settled packing: grains that are apart from each other needed")
    packing = dropped(packing, min(padding, (1.0 - 1e-9) * gap))
    bodies = _bodies(packing, clouds, padding, box)
    with tempfile.TemporaryDirectory(prefix="peridem-settle-") as name:
        folder = Path(name)
        (folder / "grains.data").write_text(_data(bodies, box))
        (folder / "in.settle").write_text(_script(bodies, box, friction))
        run.run(folder / "in.settle", ranks, lmp, quiet=True)
        rows = np.loadtxt(folder / "end.dump", skiprows=9, ndmin=2)
        energy = float((folder / "energy.txt").read_text())
    _check_rest(bodies, energy)
    end = rows[np.argsort(rows[:, 0]), 1 : 1 + bodies.dimension]
    found = _moved(packing, bodies, end)
    try:
        return found.check(padding, box)
    except ValueError as error:
        raise RuntimeError(
            f"settled {error}; nodes {spacing:g} apart stood for the grains: a smaller spacing, or "
            "a packing that starts closer to rest, needed"
        ) from error


def _clouds(packing: Packing, spacing: float) -> list[Cloud]:
    """A cloud for each shape, fine enough for its smallest grain."""
    made = []
    for kind, shape in enumerate(packing.outlines):
        scale = packing.scale[packing.kind == kind]
        made.append(mesh(shape, spacing / float(scale.max() if len(scale) else 1.0)))
    return made


def _bodies(packing: Packing, clouds: list[Cloud], padding: float, box: Container) -> _Bodies:
    unit = float(packing.reaches().max())
    nodes, volumes, grain, widest = [], [], [], 0.0
    for i, kind in enumerate(packing.kind):
        cloud = clouds[kind]
        placed = cloud.placed(packing.position[i], packing.angle[i], float(packing.scale[i]))
        nodes.append(placed.nodes / unit)
        volumes.append(placed.volumes / unit**packing.dimension)
        grain.append(np.full(len(placed.nodes), i))
    for kind, cloud in enumerate(clouds):
        edges = cloud.edges[cloud.surface[cloud.edges].all(axis=1)]
        longest = np.linalg.norm(cloud.nodes[edges[:, 1]] - cloud.nodes[edges[:, 0]], axis=1).max()
        used = packing.scale[packing.kind == kind]
        widest = max(widest, float(longest) * float(used.max() if len(used) else 0.0))
    return _Bodies(
        np.vstack(nodes),
        np.concatenate(volumes),
        np.concatenate(grain),
        padding / unit,
        widest / unit,
        box.low / unit,
        box.high / unit,
        unit,
        box.periodic,
    )


def _data(bodies: _Bodies, box: Container) -> str:
    d = bodies.dimension
    margin = np.where(box.periodic, 0.0, 1.0)
    low, high = bodies.low - margin, bodies.high + margin
    if d == 2:
        low, high = np.append(low, -0.5), np.append(high, 0.5)
    position = np.pad(bodies.nodes, ((0, 0), (0, 3 - d)))
    lines = ["rigid grains that settle", "", f"{len(position)} atoms", "1 atom types", ""]
    lines += [f"{a:.15g} {b:.15g} {k}lo {k}hi" for a, b, k in zip(low, high, "xyz", strict=True)]
    lines += ["", "Atoms # peridem", ""]
    for n, (grain, volume, (x, y, z)) in enumerate(
        zip(bodies.grain, bodies.volumes, position, strict=True), 1
    ):
        lines.append(f"{n} {grain + 1} 1 {volume:.12g} 1.0 {x:.15g} {y:.15g} {z:.15g}")
    return "\n".join(lines) + "\n"


def _walls(bodies: _Bodies, box: Container) -> list[str]:
    """Planes at the ends of the box in the directions in which it does not repeat."""
    walls = []
    for axis in range(bodies.dimension):
        if box.periodic[axis]:
            continue
        for side, where, sign in (("low", bodies.low, 1), ("high", bodies.high, -1)):
            point, normal = np.zeros(3), np.zeros(3)
            point[axis], normal[axis] = where[axis], sign
            numbers = " ".join(f"{v:.15g}" for v in (*point, *normal))
            walls.append(f"fix {side}{axis} all peridem/wall plane {numbers}")
    return walls


def _script(bodies: _Bodies, box: Container, friction: float) -> str:
    d, spring, step = bodies.dimension, bodies.spring, bodies.step
    lightest, heaviest = float(bodies.masses.min()), float(bodies.masses.max())
    sides = " ".join("p" if p else "f" for p in box.periodic) + (" p" if d == 2 else "")
    modulus = spring if d == 2 else spring / float(np.median(bodies.volumes)) ** (1.0 / 3.0)
    contact = f"modulus {modulus:.12g} form bulk 1"
    contact += f" damping {0.2 * math.sqrt(spring * lightest):.12g}"
    if friction:
        contact += f" friction {friction:.12g} tangential history"
    # drag on each node that gives the heaviest grain its final speed
    drag = heaviest / (np.bincount(bodies.grain).max() * SPEED)
    fall = 2.0 + bodies.fall / SPEED
    still = 1e-6 * float(bodies.masses.sum())
    down, place = ("0 -1 0", "xu yu") if d == 2 else ("0 0 -1", "xu yu zu")
    return f"""\
units lj
dimension {d}
boundary {sides}
atom_style peridem
atom_modify map yes
comm_modify vel yes cutoff {2.2 + bodies.contact_radius:.8g}
read_data grains.data
pair_style peridem/contact
pair_coeff * * radius {bodies.contact_radius:.12g} {contact} fragments no
neighbor {0.3 * bodies.contact_radius:.8g} bin
neigh_modify every 1 delay 0 check yes exclude molecule/intra all
{chr(10).join(_walls(bodies, box))}
fix drag all viscous {drag:.12g}
fix bodies all rigid/small molecule
timestep {step:.8g}
variable energy equal ke
thermo 1000
thermo_style custom step ke pe
thermo_modify norm no lost error
{_pushed_apart(bodies, contact)}
fix weight all gravity 1 vector {down}
run {math.ceil(fall / step)}
fix rest all halt 200 v_energy < {still:.8g} error soft
run {math.ceil((fall + 40.0) / step)}
write_dump all custom end.dump id {place} modify sort id format float %.17g
print "${{energy}}" file energy.txt
"""


def _pushed_apart(bodies: _Bodies, contact: str) -> str:
    """Lets the contact radius grow from the smallest distance there is, without weight."""
    start, end = bodies.clearance, bodies.contact_radius
    if start >= end:
        return ""
    radii = np.linspace(start, end, STAGES + 1)[1:]
    return "\n".join(
        f"pair_coeff * * radius {radius:.12g} {contact} fragments no\nrun {STAGE_STEPS}"
        for radius in radii
    )


def _check_rest(bodies: _Bodies, energy: float) -> None:
    # a grain that falls over the padding gains this much
    limit = 0.01 * bodies.padding * float(bodies.masses.sum())
    if not energy < limit:
        raise RuntimeError(
            f"settled packing: the grains still move (energy {energy:.3g}, over {limit:.3g} "
            "in units of the largest radius, gravity and density); friction helps, or a lower start"
        )


def _moved(packing: Packing, bodies: _Bodies, end: Array) -> Packing:
    """The packing with each grain turned and moved as its nodes were."""
    position, angle = packing.position.copy(), packing.angle.copy()
    for i in range(len(packing)):
        mine = bodies.grain == i
        turn, shift = rigid_motion(bodies.nodes[mine] * bodies.unit, end[mine] * bodies.unit)
        position[i] = turn @ position[i] + shift
        if packing.dimension == 2:
            angle[i] += math.atan2(turn[1, 0], turn[0, 0])
        else:
            both = Rotation.from_matrix(turn) * Rotation.from_rotvec(angle[i])
            angle[i] = both.as_rotvec()
    return replace(packing, position=position, angle=angle)


def rigid_motion(before: Array, after: Array) -> tuple[Array, Array]:
    """Rotation matrix and shift that bring points, (n, d), closest to others (Kabsch 1976)."""
    one, two = before.mean(axis=0), after.mean(axis=0)
    u, _, vt = np.linalg.svd((before - one).T @ (after - two))
    flip = np.ones(before.shape[1])
    flip[-1] = np.sign(np.linalg.det(vt.T @ u.T))
    turn = (vt.T * flip) @ u.T
    return turn, two - turn @ one
