"""Fifteen grains between walls, pressed by a lid until they break: the scene, and a run of it."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from peridem import cloud, packing, scene, shapes
from peridem.material import Contact, Material
from peridem.results_tables import averages

from bench import adapt, histories, timing
from bench.histories import Array

MM = 1e-3
GRAINS, RADIUS, GAP = 15, 1.0 * MM, 0.1 * MM
JITTER = 1e-3 * RADIUS
LID, DURATION, QUICK = 1.5, 1.7e-3, 0.3e-3
STRESS, IMPULSE, CRACKS = "wall stress", "impulse on the wall", "crack length"
RECORDS = {STRESS: "v_stress", CRACKS: "v_cracks"}
# over both sides of a straight crack, the integral of a node's share of broken bonds is so many
# horizons: the mean distance from a diameter of the points of a half disc, once for each side
CRACK = 4 / (3 * np.pi)


@dataclass(frozen=True)
class Choice:
    """Spacing of nodes, mm, and all that may be chosen; the defaults are the package's.

    ``outline``: nodes of the surface lie on the grain's outline (drawn), or inside it by half the
    distance at which nodes touch, and walls are moved back as much, so that surfaces meet where
    they were drawn (inset).
    """

    h: float = 0.2
    m: float = 3
    influence: str = "linear"
    volume: str = "taper"
    spring: float = 10.0
    tangential: str = "history"
    safety: float = 0.8
    walls: str = "surfaces"
    outline: str = "inset"
    reach: float = 0.95
    engine: str = "auto"


def script(one: Choice, folder: Path, seed: int) -> str:
    """The scene's script, up to its output; the seed is of where exactly grains start."""
    makers: tuple[Callable[[float], shapes.Outline], ...]
    makers = (shapes.circle, shapes.hexagon, shapes.drum)
    kinds = np.arange(GRAINS) % len(makers)
    outlines = [make(RADIUS) for make in makers]
    width = 2.1 * MM * np.ceil(np.sqrt(GRAINS))
    heap = packing.deposited(outlines, kinds, (0.0, width, 0.0, 40 * width), GAP, 4)
    top = max(heap.outline(i).bounds[3] for i in range(len(heap))) + GAP
    heap = replace(heap, position=heap.position + _jitter(seed))
    reach = one.reach * one.h * MM
    inset = 0.5 * reach if one.outline == "inset" else 0.0
    clouds = [cloud.mesh(smaller(outline, inset), one.h * MM) for outline in outlines]
    solid = Material(
        name="grain",
        bulk=21.6e6,
        poisson=0.25,
        density=1200.0,
        horizon=(one.m + 0.05) * one.h * MM,
        gc=3.0,
        viscosity=4.0,
        influence=one.influence,  # type: ignore[arg-type]
        volume=one.volume,  # type: ignore[arg-type]
    )
    contact = Contact(
        radius=reach,
        stiff=one.spring,
        restitution=0.7,
        friction=0.3,
        tangential=one.tangential,  # type: ignore[arg-type]
    )
    scene_ = scene.Scene(
        title="fifteen grains",
        grains=scene.grains_of(heap, clouds, solid),
        contact=contact,
        walls=scene.box_walls((-inset, -inset), (width + inset, top + inset), lid_velocity=-LID),
        gravity=(0.0, -10.0),
        duration=DURATION,
        safety=one.safety,
        engine=one.engine,
    )
    text = adapt.from_scene(scene_, folder)
    force = "f_lid[2]"
    if one.walls == "nodes":
        text, force = _walls_of_nodes(text, one.h * MM, width, top, inset), "c_lid"
    cracks = f"c_cracks/({solid.density * CRACK * solid.horizon * RADIUS})"
    return f"{text}\nvariable stress equal {force}/{width}\nvariable cracks equal {cracks}\n"


def _jitter(seed: int) -> Array:
    """Where grains start, off their places, (GRAINS, 2): so little that nobody would know."""
    return np.random.default_rng(seed).uniform(-JITTER, JITTER, (GRAINS, 2))


def smaller(one: shapes.Outline, by: float) -> shapes.Outline:
    """The outline moved inwards."""
    if by == 0.0:
        return one
    if one.is_circle:
        return shapes.circle(one.radius - by)
    inner = shapely.Polygon(one.vertices).buffer(-by, join_style="mitre")
    return shapes.polygon(np.asarray(inner.exterior.coords)[:-1], one.name)


def _walls_of_nodes(text: str, h: float, width: float, top: float, back: float) -> str:
    """Rows of nodes without bonds in place of the walls that are surfaces, so far back."""
    across = np.linspace(-back, width + back, 1 + round((width + 2 * back) / h))
    up = np.arange(h - back, top + back - 0.5 * h, h)
    # the lid ends a spacing from the sides, which it would touch
    rows = {
        "floor": [(x, -back) for x in across],
        "left": [(across[0], y) for y in up],
        "right": [(across[-1], y) for y in up],
        "lid": [(x, top + back) for x in across[1:-1]],
    }
    lines = []
    for number, (name, points) in enumerate(rows.items(), GRAINS + 1):
        lines += [f"create_atoms {number - GRAINS + 1} single {x} {y} 0" for x, y in points]
        lines += [f"group {name} type {number - GRAINS + 1}", f"set group {name} mol {number}"]
    lines += [f"set type 2*5 volume {h * h}", "set type 2*5 density 1200"]
    text = re.sub(r"(read_data +\S+).*", r"\1 extra/atom/types 4\n" + "\n".join(lines), text)
    text = re.sub(r"(pair_coeff +\* \* peridem/contact)", r"group grains type 1\n\1", text)
    text = re.sub(r"fix (floor|left|right|lid) all peridem/wall.*", "", text)
    text = text.replace("fix weight all", "fix weight grains")
    text = text.replace("fix motion all", "fix motion grains")
    sink = f"velocity lid set 0 {-LID} 0\nfix sink lid nve/noforce"
    return f"{text}\n{sink}\ncompute lid lid reduce sum fy\n"


def _complete(body: str, duration: float) -> str:
    names = " ".join(RECORDS.values())
    body = body.replace("{perturb}", "").replace("{motion}", "nve")
    return f"""{body}
compute node all peridem/atom damage
group solid type 1
variable broken atom c_node*mass
compute cracks solid reduce sum v_broken
variable now equal time
fix record all ave/time 10 1 10 v_now {names} file record.dat
thermo_style custom step time dt c_cracks
thermo 100000
variable over equal time>={duration}
fix over all halt 10 v_over > 0 error soft message no
run 100000000
"""


def run(
    lmp: Path, one: Choice, folder: Path, seed: int, duration: float
) -> tuple[float, dict[str, Array]]:
    """One run: seconds of processor time of its steps, and the histories that are compared."""
    text = _complete(script(one, folder, seed), duration)
    timed = timing.run(lmp, text, folder)
    data = averages(folder / "record.dat")
    records = {name: data[column] for name, column in RECORDS.items()}
    found = histories.binned(data["v_now"], records, duration)
    return timed.seconds, {**found, IMPULSE: np.cumsum(found[STRESS])}
