"""From the sections of a deck to a scene."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from peridem.deck import loads, sections, solids
from peridem.deck.bodies import Body, bodies
from peridem.deck.contact import Touch, touch
from peridem.deck.record import Record
from peridem.deck.restart import State, restart
from peridem.deck.sections import LoadSet, Model
from peridem.deck.source import Block, DeckError, Report
from peridem.deck.stage import Stage, begin, put_surface, stage
from peridem.deck.walls import Drive, surface
from peridem.loads import Force, Motion, Nodes
from peridem.material import AnyMaterial, Inert
from peridem.scene import Grain, Scene
from peridem.walls import AnyWall, Wall

Array = NDArray[np.float64]

# Names of PeriDEM's output fields: attributes of compute peridem/atom, columns of the dump, or
# nothing where every dump has them or nothing is like them.
ATTRIBUTES = {"Boundary_Node_Flag": ("surface",), "Strain_Stress": ("sxx", "syy", "sxy")}
COLUMNS = {"Force": ("fx", "fy"), "Force_Density": ("fx", "fy")}
ALWAYS = ("Displacement", "Velocity", "Damage_Z", "Damage", "Theta", "Zone_ID", "Particle_ID")
MOST_SIZES = 16  # of particles of a zone that get a type each
TOO_LONG = 10.0  # a published step so much above the stable one is not taken


@dataclass
class Plan:
    """All that a deck says, on its way to a scene."""

    root: Block
    report: Report
    as_published: bool
    model: Model
    bodies: list[Body]
    specs: list[solids.SolidSpec]
    displacements: list[LoadSet]
    forces: list[LoadSet]
    state: State | None
    start: float = 0.0
    stage: Stage | None = None
    whole: dict[int, list[LoadSet]] = field(default_factory=dict)
    walls: dict[int, list[AnyWall]] = field(default_factory=dict)
    names: dict[int, list[str]] = field(default_factory=dict)
    grains: list[int | None] = field(default_factory=list)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.model.dimension

    @cached_property
    def spacings(self) -> list[float]:
        """Node spacing of each particle, for the taper; many different ones gathered in classes.

        Each is an atom type of its own, and pairs of types have a contact law each.
        """
        found = [body.spacing for body in self.bodies]
        for number in {body.zone.number for body in self.bodies}:
            mine = [k for k, body in enumerate(self.bodies) if body.zone.number == number]
            values = np.array([found[k] for k in mine])
            if len(np.unique(values)) <= MOST_SIZES:
                continue
            low, high = float(values.min()), float(values.max())
            width = (high - low) / MOST_SIZES
            place = np.minimum((values - low) // width, MOST_SIZES - 1)
            for k, at in zip(mine, place, strict=True):
                found[k] = low + (float(at) + 0.5) * width
            self.report.add(
                self.specs[number - 1].block.place(),
                f"{len(np.unique(values))} sizes of particles: their tapers are taken in "
                f"{MOST_SIZES} classes, at most {0.5 * width / low:.1%} off",
            )
        return found

    def prescribed(self, k: int) -> bool:
        """Whether the whole motion of particle k is prescribed."""
        body, sets = self.bodies[k], self.whole.get(k, [])
        directions = {d for load in sets for d in load.directions}
        if body.zone.constrained:
            return True
        if body.zone.wall:
            return bool(sets)
        return directions == set(range(self.dimension))

    def drive(self, k: int) -> Drive:
        """How particle k is driven as a whole."""
        sets = self.whole.get(k, [])
        turning = [turn for load in sets if (turn := loads.rotation(load)) is not None]
        full = all(set(load.directions) >= {0, 1} for load in sets)
        if len(sets) == 1 and turning and full:
            return Drive((0.0,) * self.dimension, turning[0])
        speed = [0.0] * self.dimension
        for load in sets:
            given = loads.velocity(load, self.dimension)
            if given is None:
                return Drive(tuple(speed), other=True)
            for d, value in enumerate(given):
                speed[d] = speed[d] if value is None else value
        return Drive(tuple(speed))


@dataclass(frozen=True, eq=False)
class Built:
    """A scene, and which grain each particle has become."""

    scene: Scene
    grains: list[int | None]


def build(root: Block, report: Report, as_published: bool, after: Path | None = None) -> Built:
    """The scene of a deck.

    Args:
        root: the deck.
        report: what is to be said about it.
        as_published: as PeriDEM computes it.
        after: folder of the run with whose end it begins.

    Raises:
        DeckError: the deck asks for what cannot be.
    """
    model = sections.model(root, report)
    zones = sections.zones(root, model, report)
    specs = solids.specs(root, len(zones), model.dimension, report)
    particles = bodies(root, zones, model, report)
    centres = [body.cloud.nodes.mean(axis=0).tolist() for body in particles]
    walls = [k for k, body in enumerate(particles) if body.zone.wall]
    plan = Plan(
        root,
        report,
        as_published,
        model,
        particles,
        specs,
        sections.load_sets(root, "Displacement_BC", model, walls, report),
        sections.load_sets(root, "Force_BC", model, walls, report),
        None
        if after
        else restart(root, model, [len(body.cloud.nodes) for body in particles], report),
    )
    for load in plan.displacements:
        for k in loads.particles_of(load, len(particles)):
            if load.region is None:
                plan.whole.setdefault(k, []).append(load)
    if after is not None:
        drives = {k: plan.drive(k) for k in range(len(particles)) if plan.prescribed(k)}
        plan.stage = stage(root, model, particles, drives, after, as_published, report)
        plan.state = plan.stage.state(particles)
    plan.start = plan.state.time if plan.state is not None else 0.0
    _quirks(plan)
    if not as_published:
        _surfaces(plan)
    number = 0
    for k in range(len(particles)):
        number += k not in plan.walls
        plan.grains.append(None if k in plan.walls else number)
    scene = _scene(plan)
    surfaces = [plan.names.get(k, []) for k in range(len(particles))]
    scene.source = Record(as_published, plan.grains, centres, surfaces).kept()
    return Built(scene, plan.grains)


def _scene(plan: Plan) -> Scene:
    model, report = plan.model, plan.report
    pairs = sections.contacts(plan.root, len(plan.specs), model.single, report)
    names: dict[int, set[str]] = {}
    for k, body in enumerate(plan.bodies):
        if k not in plan.walls:
            names.setdefault(body.zone.number, set()).add(_material(plan, k).name)
    planes = _first_planes(plan)
    alone = len(plan.bodies) == 1 and "Contact" not in plan.root
    said = Report(plan.root.path) if alone else report  # nothing was said of contact
    touching = touch(pairs, plan.bodies, names, plan.walls, planes, plan.as_published, said)
    motions = [_in_time_of_run(plan, motion) for motion in _motions(plan)]
    forces = [_in_time_of_run(plan, force) for force in _forces(plan)]
    walls = _named(plan, touching)
    try:
        scene = Scene(
            title=_title(plan),
            grains=_grains(plan),
            contact=touching.default,
            pairs=touching.pairs,
            duration=_duration(plan),
            walls=walls,
            gravity=_gravity(plan),
            motions=motions,
            forces=forces,
            start_time=plan.stage.end.time if plan.stage is not None else plan.start,
            boundary="s",
            leapfrog=plan.as_published and model.leapfrog and plan.state is None,
            timestep=model.dt if plan.as_published else None,
            **_output(plan),
        )
        scene = _checked_step(plan, scene)
        if plan.stage is None:
            return scene
        return begin(plan.stage, scene, report)
    except DeckError:
        raise
    except ValueError as error:
        raise DeckError(f"{plan.root.path}: {error}") from error


def _checked_step(plan: Plan, scene: Scene) -> Scene:
    """The scene, without the deck's time step where that is far above the stable one."""
    place = plan.root.block("Model").place("Time_Steps")
    if not plan.as_published:
        step = scene._timestep()[0]
        how = "fix peridem/timestep finds the step" if scene.adaptive else "a stable step"
        plan.report.add(
            place, f"steps of {plan.model.dt:.3g} s; {how}, about {step:.2g} s at the start"
        )
        return scene
    _, stable = scene._timestep()
    ratio = plan.model.dt / stable.together
    if ratio > TOO_LONG:
        plan.report.add(
            place, f"steps of {plan.model.dt:.3g} s are {ratio:.2g} times the stable one; not taken"
        )
        return replace(scene, timestep=None, walls=scene.walls, leapfrog=False)
    if ratio > 1.0:
        plan.report.add(
            place,
            f"steps of {plan.model.dt:.3g} s, as published, are {ratio:.2g} times what is stable "
            "when every node is pressed by several",
        )
    return scene


def _title(plan: Plan) -> str:
    name = plan.root.block("Particle").text("Test_Name", "no test name")
    kind = ", as published" if plan.as_published else ""
    return f"PeriDEM deck {plan.root.path.name} ({name}{kind})"


def _duration(plan: Plan) -> float:
    left = plan.model.final_time - plan.start
    if not left > 0.0 and plan.stage is not None:
        raise plan.root.block("Model").error(
            "Final_Time",
            f"{plan.model.final_time:g} s is not after the {plan.start:.6g} s at which the run in "
            f"{plan.stage.folder} has ended",
        )
    if not left > 0.0:
        raise plan.root.block("Restart").error(
            "Step", f"its time {plan.start:g} is not before Final_Time {plan.model.final_time:g}"
        )
    return left


# ---- grains --------------------------------------------------------------------------------------


def _grains(plan: Plan) -> list[Grain]:
    moving = _initial_velocities(plan)
    grains = []
    for k, body in enumerate(plan.bodies):
        if k in plan.walls:
            continue
        grain = Grain(body.cloud, _material(plan, k), velocity=moving.get(k))
        if plan.state is not None:
            u, v = plan.state.of(k, plan.dimension)
            grain = replace(grain, displacement=u, velocity=v)
        grains.append(grain)
    if moving and plan.state is not None:
        place = plan.root.block("IC").place("Constant_Velocity")
        plan.report.add(place, "not used: velocities are those of the state it goes on from")
    return grains


def _material(plan: Plan, k: int) -> AnyMaterial:
    body = plan.bodies[k]
    spec = plan.specs[body.zone.number - 1]
    if plan.prescribed(k):
        name = f"{spec.name}_body" if _mixed(plan, body.zone.number) else spec.name
        return Inert(spec.density, name, spec.bulk or None)
    if plan.as_published:
        spacing = plan.spacings[k]
        return solids.published(spec, spacing, plan.dimension, plan.specs[0].weight)
    return solids.right(spec, body.spacing, plan.dimension)


def _mixed(plan: Plan, zone: int) -> bool:
    """Whether a zone has particles with and without a prescribed motion."""
    kinds = {plan.prescribed(k) for k, b in enumerate(plan.bodies) if b.zone.number == zone}
    return len(kinds) == 2


def _initial_velocities(plan: Plan) -> dict[int, tuple[float, ...]]:
    block = plan.root.block("IC").block("Constant_Velocity")
    if "Velocity_Vector" not in block:
        return {}
    vector = _vector(plan, block, "Velocity_Vector")
    chosen = block.wholes("Particle_List") or ([0] if plan.model.single else [])
    if not chosen:
        plan.report.add(block.place(), "not used, as in PeriDEM: Particle_List names no particle")
    for k in chosen:
        if k >= len(plan.bodies):
            raise block.error("Particle_List", f"particle {k} of {len(plan.bodies)}, from 0")
        if plan.prescribed(k):
            plan.report.add(
                block.place("Particle_List"),
                f"particle {k}: its motion is prescribed, from the start",
            )
    return {k: vector for k in chosen if not plan.prescribed(k)}


def _gravity(plan: Plan) -> tuple[float, ...]:
    return _vector(plan, plan.root.block("Force_BC"), "Gravity")


def _vector(plan: Plan, block: Block, key: str) -> tuple[float, ...]:
    """A vector of a deck, which has up to three components, as one of the scene."""
    given = block.numbers(key)
    if len(given) > 3:
        raise block.error(key, f"at most 3 numbers needed, not {len(given)}")
    if any(given[plan.dimension :]):
        plan.report.add(block.place(key), "its third component means nothing in 2D")
    return tuple((*given, 0.0, 0.0, 0.0)[: plan.dimension])


# ---- walls, motions, forces ----------------------------------------------------------------------


def _surfaces(plan: Plan) -> None:
    """Turn walls of nodes into surfaces where these do the same."""
    free = [k for k in range(len(plan.bodies)) if not plan.prescribed(k)]
    if not free:
        return
    grains = np.vstack([plan.bodies[k].cloud.nodes for k in free])
    if plan.state is not None:
        grains = grains + np.vstack([plan.state.of(k, plan.dimension)[0] for k in free])
    if plan.stage is not None:
        _surfaces_of_run(plan, plan.stage, grains)
        return
    for k, body in enumerate(plan.bodies):
        if not (body.zone.wall and plan.prescribed(k)):
            continue
        if plan.state is not None:
            u, _ = plan.state.of(k, plan.dimension)
            body = replace(body, cloud=replace(body.cloud, nodes=body.cloud.nodes + u))
        drive = plan.drive(k)
        made = [] if plan.state is not None and drive.rotation else surface(body, drive, grains)
        place = body.zone.block.place()
        if made:
            plan.walls[k] = made
            plan.report.add(place, f"its {len(body.cloud.nodes)} nodes are {_said(made)} instead")
        else:
            plan.report.add(place, "a wall of nodes: no plane or region does the same")


def _surfaces_of_run(plan: Plan, stage: Stage, grains: Array) -> None:
    """Walls that are surfaces in the run that comes before; the others stay bodies of nodes."""
    for k, body in enumerate(plan.bodies):
        if stage.grains[k] is not None:
            continue
        going = stage.going.get(k)
        drive = plan.drive(k)
        plan.walls[k] = going or put_surface(stage, body, k, drive, grains, plan.report)


def _first_planes(plan: Plan) -> list[Wall]:
    """Planes where they were as grains were in their reference positions."""
    if plan.stage is not None:
        return plan.stage.planes
    made = []
    for k, walls in plan.walls.items():
        way = np.zeros(plan.dimension)
        if plan.state is not None:
            way = plan.state.of(k, plan.dimension)[0].mean(axis=0)
        for wall in walls:
            if isinstance(wall, Wall):
                made.append(replace(wall, point=tuple((np.array(wall.point) - way).tolist())))
    return made


def _said(walls: list[AnyWall]) -> str:
    names = ", ".join(wall.name for wall in walls)
    return f"the surface{'s' if len(walls) > 1 else ''} {names}"


def _named(plan: Plan, touching: Touch) -> list[AnyWall]:
    """All surfaces, each with a name of its own."""
    going = plan.stage.going if plan.stage is not None else {}
    taken = {wall.name for walls in going.values() for wall in walls}
    found = []
    for k, walls in plan.walls.items():
        for wall in walls:
            name, extra = wall.name, 2
            if k not in going and name in taken:
                name = f"{wall.name}_{k}"
            while k not in going and name in taken:
                name, extra = f"{wall.name}_{k}_{extra}", extra + 1
            taken.add(name)
            plan.names.setdefault(k, []).append(name)
            found.append(replace(wall, name=name, contact=touching.walls.get(k)))
    return found


def _motions(plan: Plan) -> list[Motion]:
    bodies_moved = [
        _body_motion(plan, k)
        for k in range(len(plan.bodies))
        if plan.prescribed(k) and k not in plan.walls
    ]
    made = []
    for load in plan.displacements:
        mine = [k for k in loads.particles_of(load, len(plan.bodies)) if not plan.prescribed(k)]
        for name, nodes, bounds in _targets(plan, load, mine, f"moved_{load.number}"):
            made.append(
                loads.motion(
                    load,
                    name,
                    nodes,
                    bounds,
                    plan.dimension,
                    plan.as_published,
                    plan.report,
                    plan.start,
                )
            )
    return [*bodies_moved, *made]


def _targets(
    plan: Plan, load: LoadSet, particles: list[int], name: str
) -> list[tuple[str, Nodes, loads.Bounds]]:
    """Names, nodes and boxes of what a set acts on; several where the box is that of each one."""
    grains = {k: g for k in particles if (g := plan.grains[k]) is not None}
    if load.region is not None:
        d = plan.dimension
        inside = {
            k: g
            for k, g in grains.items()
            if load.region.contains(plan.bodies[k].cloud.nodes[:, :d]).any()
        }
        if not inside:
            plan.report.add(load.block.place("Region"), "no nodes lie in it")
            return []
        return [(name, Nodes(tuple(inside.values()), load.region), load.region.bounds)]
    if not grains:
        return []
    if load.space.startswith("hat"):
        return [(f"{name}_{k}", Nodes((g,)), plan.bodies[k].bounds) for k, g in grains.items()]
    first = next(iter(grains))
    return [(name, Nodes(tuple(grains.values())), plan.bodies[first].bounds)]


def _body_motion(plan: Plan, k: int) -> Motion:
    """The motion of a particle that is prescribed as a whole."""
    body, drive, grain = plan.bodies[k], plan.drive(k), plan.grains[k]
    assert grain is not None
    nodes, name = Nodes((grain,)), f"{'wall' if body.zone.wall else 'body'}_{k}"
    sets = plan.whole.get(k, [])
    given = {d for load in sets for d in load.directions}
    if sets and not body.zone.constrained and given != set(range(plan.dimension)):
        plan.report.add(
            body.zone.block.place(), "directions of its motion that are left free are held"
        )
    if drive.rotation is not None and plan.dimension == 2:
        return Motion.turning(name, nodes, drive.rotation)
    if not drive.other and drive.rotation is None:
        return Motion.constant(name, nodes, drive.velocity)
    known: dict[int, tuple[str, str]] = {}
    for load in sets:
        known |= loads.formulas(load, body.bounds, plan.as_published, plan.report, plan.start)
    every = [known.get(d, ("0", "0")) for d in range(plan.dimension)]
    return Motion.following(name, nodes, [p[0] for p in every], [p[1] for p in every])


def _forces(plan: Plan) -> list[Force]:
    made: list[Force] = []
    for load in plan.forces:
        mine = [k for k in loads.particles_of(load, len(plan.bodies)) if not plan.prescribed(k)]
        for name, nodes, bounds in _targets(plan, load, mine, f"push_{load.number}"):
            made.append(
                loads.force(
                    load, name, nodes, bounds, plan.dimension, plan.as_published, plan.report
                )
            )
    return made


Load = TypeVar("Load", Motion, Force)


def _in_time_of_run(plan: Plan, load: Load) -> Load:
    """A load whose formulas are of the time of the run that comes before, not of the deck's."""
    clock = plan.stage.clock if plan.stage is not None else 0.0
    if abs(clock) <= 1e-12 * plan.model.final_time:
        return load

    def later(formula: str) -> str:
        return re.sub(r"\btime\b", f"(time-({clock:.17g}))", formula)

    if isinstance(load, Force):
        density = tuple(later(v) if isinstance(v, str) else v for v in load.density)
        return replace(load, density=density)
    shown, rate = (
        tuple(None if f is None else later(f) for f in formulas)
        for formulas in (load.displacement, load.rate)
    )
    return replace(load, displacement=shown, rate=rate)


# ---- the rest ------------------------------------------------------------------------------------


def _output(plan: Plan) -> dict[str, Any]:
    """Frames, records, attributes and columns."""
    out, steps, report = sections.output(plan.root, plan.report), plan.model.steps, plan.report
    steps = max(1, round(steps * _duration(plan) / plan.model.final_time))
    attributes: list[str] = []
    columns: list[str] = []
    none: list[str] = []
    for tag in out.tags:
        if tag in ATTRIBUTES:
            attributes += ATTRIBUTES[tag]
        elif tag in COLUMNS:
            columns += COLUMNS[tag] if plan.dimension == 2 else ("fx", "fy", "fz")
        elif tag not in ALWAYS:
            none.append(tag)
    if none and out.block is not None:
        report.add(out.block.place("Tags"), f"no counterpart in the dump: {', '.join(none)}")
    if "Strain_Stress" in out.tags and plan.dimension == 3:
        attributes += ["szz", "sxz", "syz"]
    frames = 1 if out.interval is None else max(1, round(steps / out.interval))
    if out.interval is not None and out.interval > steps and out.block is not None:
        report.add(
            out.block.place("Output_Interval"), f"longer than the run of {steps} steps; 100 outputs"
        )
        frames = 100
    records = max(frames, round(steps / out.records)) if out.records else max(1000, frames)
    return {
        "frames": frames,
        "records": records,
        "attributes": tuple(dict.fromkeys(attributes)),
        "columns": tuple(dict.fromkeys(columns)),
        "notes": _notes(plan),
    }


def _notes(plan: Plan) -> list[str]:
    how = "as PeriDEM computes it" if plan.as_published else "with right physics"
    return [f"From {plan.root.path.name}, {how}; 'peridem convert' prints what was changed."]


def _quirks(plan: Plan) -> None:
    """What PeriDEM does differently, and what has no counterpart, section by section."""
    root, report = plan.root, plan.report
    neighbour = root.block("Neighbor")
    for key in neighbour.skip("Update_Criteria", "Search_Factor", "Search_Interval"):
        report.add(neighbour.place(key), "not used: LAMMPS knows when its neighbour lists are old")
    reasons = {
        "HPX": "no counterpart: mpirun -np says how many processes",
        "Policy": "no counterpart: nothing is post-processed during a run",
        "Container": "not used: the simulation box follows the nodes",
    }
    for key, reason in reasons.items():
        for here in root.skip(key):
            report.add(root.place(here), reason)
    particle = root.block("Particle")
    name = particle.text("Test_Name", "")
    for key in particle.skip("Compressive_Test"):
        report.add(particle.place(key), "the forces on all walls are in walls.dat")
    if name == "two_particle" and not plan.prescribed(0):
        report.add(
            particle.place("Test_Name"),
            "two_particle lets no force act on particle 0; here forces do",
        )
    if plan.as_published:
        _said_of_published(plan)
    _physics(plan)


def _said_of_published(plan: Plan) -> None:
    """What is kept because it was published, and what is not."""
    root, report = plan.root, plan.report
    model = root.block("Model")
    if plan.model.leapfrog and plan.state is None:
        report.add(
            model.block("Discretization_Type").place("Time"),
            "symplectic Euler, as published: velocities start half a step ahead",
        )
    for body in plan.bodies:
        if body.zone.wall:
            report.add(body.zone.block.place(), "a wall of nodes, as published")
    contact = root.block("Contact")
    if not plan.model.single:
        report.add(
            contact.place(),
            "radius from the smallest node spacing of all particles and walls, as published; "
            "not as published: fragments of a grain touch like grains, friction opposes sliding, "
            "walls feel what they push, damping is that of restitution",
        )


def _physics(plan: Plan) -> None:
    """How the solids are taken."""
    report, published = plan.report, plan.as_published
    for k in sorted({body.zone.number for k, body in enumerate(plan.bodies)}):
        mine = [i for i, body in enumerate(plan.bodies) if body.zone.number == k]
        spec = plan.specs[k - 1]
        if all(plan.prescribed(i) for i in mine):
            report.add(spec.block.place(), "no bonds in bodies whose motion is prescribed")
            continue
        place = spec.block.place()
        if published:
            report.add(place, _published_words(spec.kind, plan.dimension))
            if spec.weight != plan.specs[0].weight:
                report.add(
                    spec.block.place("Influence_Function"),
                    "the influence function of zone 1 counts for all zones, as published",
                )
        else:
            report.add(place, _right_words(spec.kind, plan.dimension))
        wall = plan.bodies[mine[0]].zone.wall
        if wall:
            report.add(
                plan.bodies[mine[0]].zone.block.place(),
                "a wall that can move: a grain here, which others push",
            )


def _published_words(kind: str, dimension: int) -> str:
    flat = dimension == 2
    constants = {
        "PDState": "constants of 3D (plane jha)" if flat else "critical stretch of PeriDEM",
        "PMBBond": "micro-modulus and critical stretch of PeriDEM",
        "PDElasticBond": "micro-modulus of PeriDEM",
        "RNPBond": "depth and beta of PeriDEM",
    }[kind]
    return (
        f"as published: {constants}; bonds break in compression too (break both); the horizon's "
        "taper is the smallest node spacing"
    )


def _right_words(kind: str, dimension: int) -> str:
    flat = "of plane strain or stress, not of 3D" if dimension == 2 else "of 3D"
    return (
        f"constants {flat}; critical stretch from Gc for this influence function; bonds break in "
        "tension only; the horizon's taper follows the nodes' volumes"
    )
