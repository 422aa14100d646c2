"""Fifteen grains pressed until they break, against a fine reference and the scatter of chaos."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from peridem import cloud, packing, scene, shapes
from peridem.material import Contact, Material
from peridem.results_tables import averages

from bench import adapt, histories, timing
from bench.histories import Array
from bench.machine import Machine
from bench.pareto import front
from bench.progress import counted
from bench.table import Row

SIZE = "h"
TITLE = "Speed against error: fifteen grains pressed until they break"
KIND = front.KIND
MM = 1e-3
GRAINS, RADIUS, GAP = 15, 1.0 * MM, 0.1 * MM
LID, DURATION, QUICK = 1.5, 1.7e-3, 0.3e-3
RECORDS = {"wall stress": "v_stress", "crack length": "v_cracks"}
# over both sides of a straight crack, the integral of a node's share of broken bonds is so many
# horizons: the mean distance from a diameter of the points of a half disc, once for each side
CRACK = 4 / (3 * np.pi)
REPEATS, FINE = 3, 2  # runs that chaos alone parts: of coarse nodes, of the reference


@dataclass(frozen=True)
class Choice:
    """Spacing of nodes, mm, and all that may be chosen; the defaults are the package's.

    ``outline``: nodes of the surface lie on the grain's outline (drawn), or inside it by half the
    distance at which nodes touch, and walls are moved back as much, so that surfaces meet where
    they were drawn (inset).
    """

    h: float = 0.2
    m: int = 3
    influence: str = "linear"
    volume: str = "taper"
    spring: float = 10.0
    tangential: str = "history"
    safety: float = 0.8
    walls: str = "surfaces"
    outline: str = "inset"
    reach: float = 0.95
    engine: str = "auto"


# runs are held against those with inset outlines: where grains touch is what they are to have alike
DEFAULT: dict[str, object] = asdict(Choice())
PRESENT = {"outline": "drawn"}  # what the package does where that is something else


def choices(quick: bool) -> list[Choice]:
    """Resolutions with horizons, then one thing at a time."""
    one = Choice()
    if quick:
        return [one, replace(one, spring=1.0), replace(one, walls="nodes")]
    sizes = [(0.2, 2), (0.2, 4), (0.14, 2), (0.14, 3), (0.14, 4), (0.1, 2), (0.1, 3)]
    found = [one, *(replace(one, h=h, m=m) for h, m in sizes)]
    changes: list[dict[str, object]] = [
        {"influence": "constant"},
        {"influence": "inverse"},
        {"volume": "full"},
        *({"spring": alpha} for alpha in (1.0, 3.0, 30.0)),
        {"tangential": "regularised"},
        *({"safety": safety} for safety in (0.4, 0.95)),
        {"walls": "nodes"},
        *({"spring": alpha, "h": 0.14} for alpha in (1.0, 3.0)),
        {"reach": 0.7},
        {"outline": "drawn", "h": 0.1},  # coarser nodes would overlap at the start
        *({"engine": engine} for engine in ("general", "batched")),
    ]
    return found + [replace(one, **change) for change in changes]  # type: ignore[arg-type]


def reference(quick: bool) -> Choice:
    """What the others are compared with."""
    return replace(Choice(), h=0.14 if quick else 0.08)


def script(one: Choice, folder: Path) -> str:
    """The scene's script, up to its output."""
    makers: tuple[Callable[[float], shapes.Outline], ...]
    makers = (shapes.circle, shapes.hexagon, shapes.drum)
    kinds = np.arange(GRAINS) % len(makers)
    outlines = [make(RADIUS) for make in makers]
    width = 2.1 * MM * np.ceil(np.sqrt(GRAINS))
    heap = packing.deposited(outlines, kinds, (0.0, width, 0.0, 40 * width), GAP, 4)
    top = max(heap.outline(i).bounds[3] for i in range(len(heap))) + GAP
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
        text, force = _walls_of_nodes(text, one.h * MM, width, top), "c_lid"
    cracks = f"c_cracks/({solid.density * CRACK * solid.horizon * RADIUS})"
    return f"{text}\nvariable stress equal {force}/{width}\nvariable cracks equal {cracks}\n"


def smaller(one: shapes.Outline, by: float) -> shapes.Outline:
    """The outline moved inwards."""
    if by == 0.0:
        return one
    if one.is_circle:
        return shapes.circle(one.radius - by)
    inner = shapely.Polygon(one.vertices).buffer(-by, join_style="mitre")
    return shapes.polygon(np.asarray(inner.exterior.coords)[:-1], one.name)


def _walls_of_nodes(text: str, h: float, width: float, top: float) -> str:
    """Rows of nodes without bonds in place of the walls that are surfaces."""
    across = np.arange(0.0, width + 0.5 * h, h)
    up = np.arange(h, top - 0.5 * h, h)
    # the lid ends a spacing from the sides, which it would touch
    rows = {
        "floor": [(x, 0.0) for x in across],
        "left": [(0.0, y) for y in up],
        "right": [(across[-1], y) for y in up],
        "lid": [(x, top) for x in across[1:-1]],
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
    text = text.replace("displace_atoms all", "displace_atoms grains")
    text = text.replace("fix motion all", "fix motion grains")
    sink = f"velocity lid set 0 {-LID} 0\nfix sink lid nve/noforce"
    return f"{text}\n{sink}\ncompute lid lid reduce sum fy\n"


def _complete(body: str, seed: int, h: float, duration: float) -> str:
    spread = 1e-9 * h * MM
    perturb = f"displace_atoms all random {spread} {spread} 0 {seed}"
    names = " ".join(RECORDS.values())
    body = body.replace("{perturb}", perturb).replace("{motion}", "nve")
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
) -> tuple[timing.Timing, dict[str, Array]]:
    """One run: its time, and the histories that are compared."""
    text = _complete(script(one, folder), seed, one.h, duration)
    timed = timing.run(lmp, text, folder)
    data = averages(folder / "record.dat")
    records = {name: data[column] for name, column in RECORDS.items()}
    return timed, histories.binned(data["v_now"], records, duration)


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """Rows of both quantities, each cheapest first."""
    duration = QUICK if quick else DURATION
    rows: list[Row] = []
    with tempfile.TemporaryDirectory(dir=folder) as name:
        place = Path(name)
        repeats = range(1, (2 if quick else REPEATS) + 1)
        fine = [run(lmp, reference(quick), place, seed, duration) for seed in range(1, FINE + 1)]
        truth = histories.mean([found for _, found in fine])
        coarse = [run(lmp, Choice(), place, seed, duration) for seed in repeats]
        noise = {
            "reference": (reference(quick), fine),
            "default": (Choice(), coarse),
        }
        for one in counted(choices(quick), "compression"):
            timed, found = coarse[0] if one == Choice() else run(lmp, one, place, 1, duration)
            rows += _rows("", one, timed.seconds, histories.difference(found, truth))
        for kind, (one, runs) in noise.items():
            seconds = float(np.median([timed.seconds for timed, _ in runs]))
            scatter = histories.scatter([found for _, found in runs])
            rows += _rows(f"scatter of the {kind}", one, seconds, scatter)
    return _ordered(rows)


def _rows(note: str, one: Choice, seconds: float, errors: dict[str, float]) -> list[Row]:
    return [
        {KIND: kind, **asdict(one), front.COST: seconds, front.ERROR: error, "note": note}
        for kind, error in errors.items()
    ]


def _ordered(rows: list[Row]) -> list[Row]:
    """Runs with their fronts, the scatter of repeats after them."""
    found: list[Row] = []
    for kind in RECORDS:
        of_kind = [row for row in rows if row[KIND] == kind]
        found += front.mark([row for row in of_kind if not row["note"]])
        found += [{**row, front.FRONT: ""} for row in of_kind if row["note"]]
    return found


def comment(rows: list[Row], machine: Machine) -> str:
    """What is compared, what chaos alone gives, what to use."""
    runs = [{k: v for k, v in row.items() if k != "note"} for row in rows if not row["note"]]
    chaos = "; ".join(
        f"{row['note']}, {row[KIND]}: {100 * float(str(row[front.ERROR])):.1f} %"
        for row in rows
        if row["note"]
    )
    size = next(row["h"] for row in rows if "reference" in str(row["note"]))
    return f"""\
Grains of three shapes (radius {RADIUS / MM:g} mm) are pressed by a lid that sinks at {LID} m/s.
Histories are averaged over {histories.BINS}ths of the run; the error is the root mean square of the
difference from the mean of repeated runs with nodes {size} mm apart, over the root mean square of
that mean. Repeats start from nodes moved at random by a billionth of their spacing and then differ
by chaos alone: {chaos}. A difference below that is none.

{front.text(runs, KIND, SIZE)}

{front.changes_text(runs, KIND, DEFAULT)}"""


def plot(rows: list[Row], path: Path) -> None:
    """Error against cost, coloured by the spacing."""
    front.plot([row for row in rows if not row["note"]], path, KIND, "h")
