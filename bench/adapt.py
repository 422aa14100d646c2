"""Adaptive grains: speed against error over eta, beside the scatter that chaos alone gives.

Three scenes run with all grains deformable (``fix nve``), several times from starts that differ by
a billionth of the node spacing, and with ``fix peridem/adapt`` at several eta.  Each run records a
few histories; the error of a run is the root mean square of its difference from the mean of the
deformable runs, over the size of that mean.  The scatter is what one deformable run differs from
the mean of the others.  An error no larger than the scatter is none.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from peridem import cloud, packing, scene, shapes
from peridem.material import Contact, Material
from peridem.results_tables import averages

from bench import histories, timing
from bench.machine import Machine
from bench.table import Row

Array = NDArray[np.float64]
TITLE = "Adaptive grains: speed against error"
ETAS = (0.1, 0.3, 1.0, 1e9)
REPEATS = 3
MM = 1e-3


@dataclass(frozen=True)
class Case:
    """A scene and what is compared.

    Attributes:
        script: the input; ``{motion}`` stands for the style of the time integration.
        duration: simulated time, s.
        records: LAMMPS variables or vectors, by name.
    """

    script: str
    duration: float
    records: dict[str, str]


def _solid(gc: float) -> Material:
    return Material(
        name="grain",
        bulk=21.6e6,
        poisson=0.25,
        density=1200.0,
        horizon=3.05 * 0.2 * MM,
        gc=gc,
        viscosity=4.0,
    )


def from_scene(one: scene.Scene, folder: Path) -> str:
    """The scene's script up to its output, with its time integration left open."""
    text = one.write(folder).read_text()
    text = text[: text.index("compute node")]
    text = text.replace("read_data       grains.data", f"read_data {folder / scene.DATA}")
    return text.replace("fix motion all nve", "{perturb}\nfix motion all {motion}")


def _scene(folder: Path, count: int, lid: float, duration: float, gc: float) -> str:
    outlines = [shape(1.0 * MM) for shape in (shapes.circle, shapes.hexagon, shapes.drum)]
    clouds = [cloud.mesh(outline, 0.2 * MM) for outline in outlines]
    kinds = np.arange(count) % len(outlines)
    width = 2.1 * MM * np.ceil(np.sqrt(count))
    heap = packing.deposited(outlines, kinds, (0.0, width, 0.0, 40 * width), 0.25 * MM, 4)
    top = max(heap.outline(i).bounds[3] for i in range(len(heap))) + 0.2 * MM
    walls = scene.box_walls((0.0, 0.0), (width, top), lid_velocity=-lid)
    one = scene.Scene(
        title="adaptive grains",
        grains=scene.grains_of(heap, clouds, _solid(gc)),
        contact=Contact(radius=0.13 * MM, stiff=4.0, restitution=0.7, friction=0.3),
        walls=walls,
        gravity=(0.0, -10.0),
        duration=duration,
    )
    return from_scene(one, folder)


def compression(folder: Path, quick: bool) -> Case:
    """Fifteen grains pressed until most of them break."""
    duration = 0.4e-3 if quick else 6e-3
    text = _scene(folder, 15, 0.35, duration, 3.0)
    records = {
        "pressure on the lid": "f_lid[2]",
        "damage": "c_broken",
        "kinetic energy": "c_moving",
    }
    return Case(text, duration, records)


def settling(folder: Path, quick: bool) -> Case:
    """Thirty grains fall, hit each other and come to rest; nothing breaks."""
    duration = 0.4e-3 if quick else 40e-3
    text = _scene(folder, 30, 0.0, duration, 50.0)
    records = {
        "force on the floor": "f_floor[2]",
        "height": "c_height[2]",
        "kinetic energy": "c_moving",
    }
    return Case(text, duration, records)


def drum(folder: Path, quick: bool) -> Case:
    """The drum with a fin of examples/drum."""
    duration = 1e-3 if quick else 60e-3
    source = Path(__file__).resolve().parents[1] / "examples" / "drum" / "in.drum"
    text = source.read_text()
    text = text[: text.index("compute        node")]
    text = re.sub(r"fix +motion all nve", "{perturb}\nfix motion all {motion}", text)
    records = {"torque": "f_drum[6]", "height": "c_height[2]", "kinetic energy": "c_moving"}
    return Case(text, duration, records)


CASES: dict[str, Callable[[Path, bool], Case]] = {
    "compression, 15 grains": compression,
    "settling, 30 grains": settling,
    "drum, 7 grains": drum,
}


def _complete(case: Case, motion: str, seed: int) -> str:
    """A script that records, for one motion."""
    spread = 1e-9 * 0.2 * MM
    names = " ".join(case.records.values())
    awake = "f_motion[1]" if "adapt" in motion else "v_all"
    perturb = f"displace_atoms all random {spread} {spread} 0 {seed}"
    body = case.script.replace("{perturb}", perturb).replace("{motion}", motion)
    return f"""{body}
compute height all com
compute node all peridem/atom damage
compute broken all reduce ave c_node
compute moving all ke
variable now equal time
variable all equal 1
compute energy all peridem/energy
fix record all ave/time 20 1 20 v_now {names} {awake} file record.dat
thermo_style custom step time dt c_energy[8] c_broken
thermo_modify norm no lost error
thermo 100000
variable over equal time>={case.duration}
fix over all halt 10 v_over > 0 error soft message no
run 100000000
"""


def _histories(case: Case, folder: Path) -> tuple[dict[str, Array], float]:
    """Each record averaged in bins of time, and the mean number of deformable grains."""
    data = averages(folder / "record.dat")
    now = data["v_now"]
    records = {name: data[column] for name, column in case.records.items()}
    found = histories.binned(now, records, case.duration)
    awake = next((data[name] for name in ("f_motion[1]",) if name in data), np.ones_like(now))
    weights = np.diff(now, prepend=0.0)  # steps are longer while nobody is awake
    return found, float(awake @ weights / weights.sum())


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """Rows of every scene: the deformable runs, then each eta."""
    rows: list[Row] = []
    for name, make in CASES.items():
        with tempfile.TemporaryDirectory(dir=folder) as place:
            rows += _one_case(lmp, name, make(Path(place), quick), Path(place))
    return rows


def _one_case(lmp: Path, name: str, case: Case, folder: Path) -> list[Row]:
    def run(motion: str, seed: int) -> tuple[timing.Timing, dict[str, Array], float]:
        timed = timing.run(lmp, _complete(case, motion, seed), folder)
        return timed, *_histories(case, folder)

    whole = [run("nve", seed) for seed in range(1, REPEATS + 1)]
    runs = [found for _, found, _ in whole]
    mean, scatter = histories.mean(runs), histories.scatter(runs)
    seconds = float(np.median([timed.seconds for timed, _, _ in whole]))
    rows: list[Row] = [
        {
            "scene": name,
            "eta": "all deformable",
            "s": seconds,
            "gain": 1.0,
            "mean grains awake": "all",
            **{f"error: {key}": value for key, value in scatter.items()},
        }
    ]
    for eta in ETAS:
        timed, found, awake = run(f"peridem/adapt eta {eta:g}", 1)
        rows.append(
            {
                "scene": name,
                "eta": f"{eta:g}",
                "s": timed.seconds,
                "gain": seconds / timed.seconds,
                "mean grains awake": awake,
                **{f"error: {k}": v for k, v in histories.difference(found, mean).items()},
            }
        )
    return rows


def comment(rows: list[Row], machine: Machine) -> str:
    """How to read it."""
    return """\
In the rows of deformable grains the errors are the scatter between repeats. The gain is in
processor time on one core."""
