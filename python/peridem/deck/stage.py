"""A deck that goes on where the run of another one has ended, as LAMMPS's restart file has it.

Grains, their bonds and what contacts remember come from that run. Walls that the deck has where the
first one had them go on from where they are; one that it has elsewhere is put there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from peridem.deck.bodies import Body
from peridem.deck.record import Record
from peridem.deck.restart import State
from peridem.deck.sections import Model
from peridem.deck.source import Block, DeckError, Report
from peridem.deck.walls import Drive, surface
from peridem.regions import described_region
from peridem.scene import Scene
from peridem.stages import End, begun
from peridem.walls import AnyWall, RegionWall, Wall

Array = NDArray[np.float64]

SAME = 1e-6  # of a body's size: meshes that far apart lie at the same place
CLOSE = 20  # steps: runs whose step is found end up to ten steps late
DEEPEST = 0.5  # of the contact radius: how near nodes of grains a body may be put


@dataclass(eq=False)
class Stage:
    """How the particles of a deck begin with the end of a run.

    Attributes:
        end: of the run.
        start: the deck's time at the beginning.
        grains: number of each particle's grain in the run, from 1; None: it is a surface there.
        ways: displacement of each particle from its reference position, (n, d) or (d,).
        going: surfaces that go on from where they are, by the numbers of their particles.
        put: particles that are put elsewhere.
    """

    end: End
    start: float
    grains: list[int | None]
    ways: list[Array]
    going: dict[int, list[AnyWall]] = field(default_factory=dict)
    put: list[int] = field(default_factory=list)

    @property
    def folder(self) -> Path:
        """Of the run."""
        return self.end.output.folder

    @property
    def clock(self) -> float:
        """The run's time when that of the deck is 0."""
        return self.end.time - self.start

    @property
    def planes(self) -> list[Wall]:
        """The planes of the run where they were first."""
        return [Wall(w["name"], *_plane(w)) for w in self.end.output.known_walls]

    def state(self, bodies: list[Body]) -> State:
        """Displacements of all nodes."""
        rows = [
            np.broadcast_to(
                np.pad(way, [(0, 0)] * (way.ndim - 1) + [(0, 3 - way.shape[-1])]), (n, 3)
            )
            for way, n in zip(self.ways, (len(b.cloud.nodes) for b in bodies), strict=True)
        ]
        every = np.vstack(rows)
        counts = [len(body.cloud.nodes) for body in bodies]
        return State(self.start, every, np.zeros_like(every), counts)


def stage(
    root: Block,
    model: Model,
    bodies: list[Body],
    drives: Mapping[int, Drive],
    folder: Path,
    as_published: bool,
    report: Report,
) -> Stage:
    """Find the particles in a run, and where they begin; bodies that are put elsewhere get their
    reference positions from the run.

    Args:
        root, model: the deck.
        bodies: its particles.
        drives: how those move whose motion is prescribed.
        folder: of the run.
        as_published: how the deck is read.
        report: where it is said.

    Raises:
        DeckError: the run was one of other particles, or a body cannot be put where it is to be.
    """
    try:
        end = End.of(folder)
    except (FileNotFoundError, ValueError) as error:
        raise DeckError(f"{root.path}: {error}") from error
    known = Record.of(root, end, len(bodies), as_published)
    offsets = _same_shapes(bodies, drives, known, end)
    made = Stage(end, _clock(root, model, end, report), known.grains, [np.zeros(0)] * len(bodies))
    moved = end.frame.position[:, : model.dimension] - end.output.reference[:, : model.dimension]
    for k, (grain, offset) in enumerate(zip(known.grains, offsets, strict=True)):
        body = bodies[k]
        apart = body.cloud.nodes.mean(axis=0) - np.array(known.centres[k])
        put = k in drives and bool(np.abs(apart).max() > SAME * _size(body))
        made.put += [k] * put
        if grain is None:
            _begin_surface(made, body, k, drives[k], known.surfaces[k], report)
            continue
        bodies[k] = _at(body, -offset)
        made.ways[k] = moved[end.frame["mol"] == grain]
        if put:
            had = made.ways[k].mean(axis=0)
            made.ways[k] = offset + _so_far(body, drives[k], made)
            _say_put(made, bodies[k], k, "", made.ways[k] - had, report)
    _check_put(made, bodies, drives)
    return made


# ---- the particles of both decks -----------------------------------------------------------------


def _same_shapes(
    bodies: list[Body], drives: Mapping[int, Drive], known: Record, end: End
) -> list[Array]:
    """How far each particle's mesh is from the reference position of its grain in the run, (d,)."""
    folder, numbers = end.output.folder, end.frame["mol"].astype(int)
    offsets: list[Array] = []
    for k, (body, grain) in enumerate(zip(bodies, known.grains, strict=True)):
        place = body.zone.block
        if grain is None and not (k in drives and body.zone.wall):
            raise place.error("", f"particle {k} is a surface in {folder}, and must be one here")
        nodes, offset = body.cloud.nodes, np.zeros(body.cloud.dimension)
        if grain is not None:
            there = end.output.reference[numbers == grain]
            same = there.shape == nodes.shape
            ways = nodes - there if same else np.zeros_like(nodes)
            if not same or np.ptp(ways, axis=0).max() > SAME * _size(body):
                raise place.error(
                    "",
                    f"particle {k} of {len(nodes)} nodes is of another shape, size or angle than "
                    f"in the deck of {folder} ({len(there)} nodes); they must be the same",
                )
            offset = ways.mean(axis=0)
        if k not in drives and np.abs(offset).max() > SAME * _size(body):
            raise place.error(
                "",
                f"particle {k} lies {np.linalg.norm(offset):.3g} m from where the deck of {folder} "
                "has it; only bodies of prescribed motion may be put elsewhere",
            )
        offsets.append(offset)
    return offsets


def _size(body: Body) -> float:
    return float(np.ptp(body.cloud.nodes, axis=0).max())


def _at(body: Body, way: Array) -> Body:
    """A body whose reference positions are others."""
    return replace(body, cloud=replace(body.cloud, nodes=body.cloud.nodes + way))


# ---- time ----------------------------------------------------------------------------------------


def _clock(root: Block, model: Model, end: End, report: Report) -> float:
    """The deck's time at the beginning."""
    report.add(
        (0, ""),
        f"begins with the end of the run in {end.output.folder} (step {end.step}, "
        f"{end.time:.6g} s): grains, bonds and contacts as they were",
    )
    if "Restart" not in root:
        report.add(
            root.block("Model").place("Final_Time"),
            "how long it goes on: without Restart the deck's time starts at 0",
        )
        return 0.0
    restart = root.block("Restart")
    restart.skip("Change_Reference_Free_Dofs")
    for key in restart.skip("File"):
        report.add(restart.place(key), "not read: the restart file of that run has more")
    start = restart.whole("Step") * model.dt
    step = float(end.output.summary.get("timestep", model.dt))
    if abs(start - end.time) <= CLOSE * max(step, model.dt):
        return end.time
    report.add(
        restart.place("Step"),
        f"{start:.6g} s in the deck, though that run has ended at {end.time:.6g} s; the deck's "
        "time counts",
    )
    return start


# ---- surfaces ------------------------------------------------------------------------------------


def _begin_surface(
    made: Stage, body: Body, k: int, drive: Drive, names: list[str], report: Report
) -> None:
    """A wall that is no body of nodes: it goes on from where it is, or is put elsewhere."""
    if k in made.put:
        made.ways[k] = _so_far(body, drive, made)
        return
    if drive.other:
        raise body.zone.block.error(
            "",
            f"in {made.folder} it is the surface {names[0]}, which can move at constant velocity "
            "only",
        )
    going = _going(made, drive, names)
    if len(going) < len(names):
        raise body.zone.block.error(
            "",
            f"in {made.folder} it is the surfaces {', '.join(names)}, of which some are not there",
        )
    made.going[k] = going
    places = {wall.name: wall.point for wall in made.end.output.walls(made.end.time)}
    places |= {region.name: region.shift for region in made.end.output.regions(made.end.time)}
    first = going[0]
    start = np.array(first.point) if isinstance(first, Wall) else 0.0
    made.ways[k] = np.asarray(places[first.name] - start)
    several = len(going) > 1
    where = "still where the mesh is"
    if made.ways[k].any():
        them = "them" if several else "it"
        where = f"{_vector(made.ways[k])} m from where the deck of that run had {them} first"
    report.add(
        body.zone.block.place(),
        f"the surface{'s' if several else ''} {', '.join(names)} of {made.folder}, {where}",
    )


def _going(made: Stage, drive: Drive, names: list[str]) -> list[AnyWall]:
    """Surfaces of the run, to go on."""
    found: list[AnyWall] = [
        replace(plane, velocity=drive.velocity) for plane in made.planes if plane.name in names
    ]
    for known in made.end.output.summary.get("regions", []):
        if known["name"] in names:
            region = described_region(known["region"])
            found.append(RegionWall(known["name"], region, drive.velocity, rotation=drive.rotation))
    return found


def _plane(wall: Mapping[str, list[float]]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Point, where it was first, and normal."""
    normal = tuple(wall["normal"])
    return tuple(wall.get("origin", wall["point"]))[: len(normal)], normal


def put_surface(
    made: Stage, body: Body, k: int, drive: Drive, grains: Array, report: Report
) -> list[AnyWall]:
    """The surfaces of a wall that is put elsewhere.

    Args:
        made: how the deck begins.
        body: the wall, number k.
        drive: how it moves.
        grains: (n, d) nodes of all grains.
        report: where it is said.

    Raises:
        DeckError: no surface does the same there.
    """
    place = _at(body, made.ways[k])
    found = surface(place, drive, grains)
    if not found or (isinstance(found[0], RegionWall) and made.ways[k].any()):
        raise body.zone.block.error(
            "",
            f"put at {_box_of(place)}, it has grains on both sides ({_reach(grains)}), and no "
            f"surface does the same; it was none of nodes in {made.folder}{_hint(made, drive)}",
        )
    came = {wall.name: wall for wall in made.end.output.walls(made.end.time)}
    for wall in found:
        way = None
        if isinstance(wall, Wall) and wall.name in came:
            n = wall.unit_normal
            way = n * float(n @ (np.array(wall.point) - came[wall.name].point))
        _say_put(made, body, k, f", as the surface {wall.name}", way, report)
    return found


# ---- bodies that are put elsewhere ---------------------------------------------------------------


def _so_far(body: Body, drive: Drive, made: Stage) -> Array:
    """How far the deck has moved a body when it begins, (d,)."""
    if drive.other or drive.rotation is not None:
        raise body.zone.block.error(
            "",
            f"its mesh lies elsewhere than in {made.folder}; only a body of constant velocity can "
            "be put elsewhere",
        )
    return made.start * np.array(drive.velocity)


def _say_put(made: Stage, body: Body, k: int, how: str, way: Array | None, report: Report) -> None:
    came = "" if way is None else f", {_vector(way)} m from where it had come"
    far = f" and has moved for {made.start:.6g} s" if made.ways[k].any() and made.start else ""
    place = _box_of(_at(body, made.ways[k]))
    report.add(
        body.zone.block.place(),
        f"its mesh lies elsewhere than in {made.folder}{far}: put at {place}{how}{came}",
    )


def _check_put(made: Stage, bodies: list[Body], drives: Mapping[int, Drive]) -> None:
    """Bodies of nodes are not put into grains."""
    from scipy.spatial import cKDTree

    free = [k for k in range(len(bodies)) if k not in drives]
    if not free or not made.put:
        return
    nodes = np.vstack([bodies[k].cloud.nodes + made.ways[k] for k in free])
    owner = np.repeat(free, [len(bodies[k].cloud.nodes) for k in free])
    near, tree = DEEPEST * made.end.output.contact_radius, cKDTree(nodes)
    for k in made.put:
        if made.grains[k] is None:
            continue  # surfaces have their own check
        place = _at(bodies[k], made.ways[k])
        apart, which = tree.query(place.cloud.nodes)
        if apart.min() < near:
            raise place.zone.block.error(
                "",
                f"put at {_box_of(place)}, it is {apart.min():.3g} m from a node of particle "
                f"{owner[which[apart.argmin()]]}; at least {near:.3g} m, half the contact radius, "
                f"needed ({_reach(nodes)}){_hint(made, drives[k])}",
            )


def _hint(made: Stage, drive: Drive) -> str:
    """What may be wrong with a place."""
    if not made.start or not any(drive.velocity):
        return ""
    way = made.start * np.array(drive.velocity)
    return f"; by {made.start:.6g} s, the time of Restart, it has moved by {_vector(way)} m"


def _reach(nodes: Array) -> str:
    return f"they reach from {_vector(nodes.min(axis=0))} to {_vector(nodes.max(axis=0))} m"


def _box_of(body: Body) -> str:
    nodes = body.cloud.nodes
    return f"{_vector(nodes.min(axis=0))} to {_vector(nodes.max(axis=0))} m"


def _vector(values: Array) -> str:
    return "(" + ", ".join(f"{v + 0.0:.6g}" for v in np.round(values, 12)) + ")"


# ---- the scene -----------------------------------------------------------------------------------


def begin(made: Stage, scene: Scene, report: Report) -> Scene:
    """The scene of the deck, beginning with the end of the run.

    Args:
        made: how it begins.
        scene: what the deck says; walls that do not go on are at their points.
        report: where it is said.
    """
    going = {wall.name for walls in made.going.values() for wall in walls}
    put = [wall.name for wall in scene.walls if wall.name not in going]
    bodies = {
        grain: tuple(made.ways[k].tolist())
        for k in made.put
        if (grain := made.grains[k]) is not None
    }
    output = made.end.output
    had: list[str] = [
        wall["name"] for wall in (*output.known_walls, *output.summary.get("regions", []))
    ]
    gone = [name for name in had if name not in {wall.name for wall in scene.walls}]
    if gone:
        report.add((0, ""), f"walls of {made.folder} that are no more: {', '.join(gone)}")
    return begun(scene, made.end, put, bodies, anew=True)
