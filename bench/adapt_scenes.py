"""The scenes of the benchmark of adaptive grains, with the motion of the grains left open."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from peridem import cloud, packing, scene, shapes
from peridem.material import Contact, Material

from bench import timing

MM = 1e-3
RADIUS, SPACING = 1.0 * MM, 0.2 * MM
REACH = 0.65 * SPACING  # of contacts


@dataclass(frozen=True)
class Case:
    """A scene and what is compared.

    Attributes:
        script: the input; ``{motion}`` stands for the style of the time integration, ``{perturb}``
            for a command that moves nodes a little.
        duration: simulated time, s.
        records: LAMMPS variables or vectors, by name.
        grains: how many there are.
        at_end: names of records of which the last value counts, not the mean over time.
        repeats: how often the scene is run, each time from a slightly different start.
    """

    script: str
    duration: float
    records: dict[str, str]
    grains: int
    at_end: tuple[str, ...] = ()
    repeats: int = 8


def _solid(gc: float) -> Material:
    return Material(
        name="grain",
        bulk=21.6e6,
        poisson=0.25,
        density=1200.0,
        horizon=3.05 * SPACING,
        gc=gc,
        viscosity=4.0,
    )


def from_scene(one: scene.Scene, folder: Path) -> str:
    """The scene's script up to its output, with its time integration left open."""
    text = one.write(folder).read_text()
    text = text[: text.index("compute node")]
    text = text.replace("read_data       grains.data", f"read_data {folder / scene.DATA}")
    return text.replace("fix motion all nve", "{perturb}\nfix motion all {motion}")


def heap(
    folder: Path,
    count: int,
    columns: int,
    lid: float,
    duration: float,
    gc: float,
    settled_by: Path | None = None,
    fall: float = 40e-3,
) -> str:
    """The script of a heap of discs, hexagons and drums in a box, under a lid.

    Args:
        folder: for its data.
        count: of grains.
        columns: the width of the box in grains.
        lid: speed at which it sinks, m/s.
        duration: of the run, s.
        gc: energy release rate, J/m^2.
        settled_by: the lmp program: the grains come to rest first, as rigid ones, and the lid
            starts on top of them; None: grains hang where they were placed.
        fall: how long they take to rest, s.
    """
    outlines = [shape(RADIUS) for shape in (shapes.circle, shapes.hexagon, shapes.drum)]
    clouds = [cloud.mesh(outline, SPACING) for outline in outlines]
    kinds = [number % len(outlines) for number in range(count)]
    width = 2.1 * RADIUS * columns
    placed = packing.deposited(outlines, kinds, (0.0, width, 0.0, 40 * width), 1.25 * SPACING, 4)
    top = max(placed.outline(i).bounds[3] for i in range(len(placed))) + SPACING
    one = scene.Scene(
        title="adaptive grains",
        grains=scene.grains_of(placed, clouds, _solid(gc)),
        contact=Contact(radius=REACH, stiff=4.0, restitution=0.7, friction=0.3),
        walls=scene.box_walls((0.0, 0.0), (width, top), lid_velocity=-lid),
        gravity=(0.0, -10.0),
        duration=duration,
    )
    text = from_scene(one, folder)
    return text if settled_by is None else _settled(text, settled_by, folder, lid, fall)


def _settled(text: str, lmp: Path, folder: Path, lid: float, fall: float) -> str:
    """The same script from where the grains, rigid and slowed down, have come to rest."""
    rest = text.replace("{perturb}", "").replace("{motion}", "peridem/adapt eta 1e9")
    rest = re.sub(r"(fix lid all .*) velocity .*", r"\1", rest)
    rest += f"""
fix calm all viscous 2e-3
thermo_modify lost error
variable over equal time>={fall}
fix over all halt 10 v_over > 0 error continue message no
run 100000000
variable top equal bound(all,ymax)+{1.01 * REACH}
print "${{top}}" file top.txt
velocity all set 0 0 0
write_data {folder / "rest.data"}
"""
    timing.run(lmp, rest, folder / "rest")
    top = (folder / "rest" / "top.txt").read_text().strip()
    text = text.replace(str(folder / scene.DATA), str(folder / "rest.data"))
    lowered = rf"\1 {top} \2 velocity 0 {-lid} 0"
    return re.sub(r"(fix lid all peridem/wall plane \S+) \S+ (\S+ +0 -1 0).*", lowered, text)


FORCE = "force on the wall"
PRESSED = {FORCE: "f_lid[2]", "damage": "c_broken", "work": "f_lid[8]"}
SUMS = ("damage", "work")  # of all that has happened so far
FALLING = {FORCE: "f_floor[2]", "height": "c_height[2]", "kinetic energy": "c_moving"}


def compression(lmp: Path, folder: Path, quick: bool) -> Case:
    """Fifteen grains pressed until most of them break."""
    duration = 0.4e-3 if quick else 6e-3
    return Case(heap(folder, 15, 4, 0.35, duration, 3.0), duration, PRESSED, 15, SUMS)


def pressing(lmp: Path, folder: Path, quick: bool) -> Case:
    """Fifteen grains that have settled, pressed slowly; they are ten times as strong."""
    fall, duration = (1e-3, 0.4e-3) if quick else (40e-3, 6e-3)
    text = heap(folder, 15, 4, 0.1, duration, 300.0, settled_by=lmp, fall=fall)
    records = {name: PRESSED[name] for name in (FORCE, "work")}
    return Case(text, duration, records, 15, SUMS)


def settling(lmp: Path, folder: Path, quick: bool) -> Case:
    """Thirty grains fall, hit each other and come to rest; nothing breaks."""
    duration = 0.4e-3 if quick else 40e-3
    return Case(heap(folder, 30, 6, 0.0, duration, 50.0), duration, FALLING, 30, repeats=4)


def drum(lmp: Path, folder: Path, quick: bool) -> Case:
    """The drum with a fin of examples/drum."""
    duration = 1e-3 if quick else 60e-3
    source = Path(__file__).resolve().parents[1] / "examples" / "drum" / "in.drum"
    text = source.read_text()
    text = text[: text.index("compute        node")]
    text = re.sub(r"fix +motion all nve", "{perturb}\nfix motion all {motion}", text)
    records = {"torque on the wall": "f_drum[6]", **FALLING}
    del records[FORCE]
    return Case(text, duration, records, 7)


def bed(lmp: Path, folder: Path, quick: bool) -> Case:
    """502 grains that have settled, pressed until those on top break."""
    count, columns = (24, 6) if quick else (502, 23)
    fall, duration = (1e-3, 0.3e-3) if quick else (30e-3, 2.5e-3)
    text = heap(folder, count, columns, 0.8, duration, 3.0, settled_by=lmp, fall=fall)
    return Case(text, duration, PRESSED, count, SUMS, repeats=4)


CASES: dict[str, Callable[[Path, Path, bool], Case]] = {
    "settling, 30 grains": settling,
    "drum, 7 grains": drum,
    "pressing, 15 grains": pressing,
    "crushing, 15 grains": compression,
    "crushing, 502 grains": bed,
}
