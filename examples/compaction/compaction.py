#!/usr/bin/env python3
"""Uniaxial compaction: loosely poured angular and concave grains pressed to 40 % strain.

    python compaction.py            breaking and unbreakable grains, each run on a core of its own
    python compaction.py --small    fewer and coarser grains

Everything goes to out/compaction/ (another folder with --output).
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from peridem import cloud, packing, program, render, results, run, scene, shapes
from peridem.material import Contact, Material

MM = 1e-3
STRAIN = 0.4  # at the end: way of the lid over the height of the bed
GRAVITY = 10.0
SHAPES = (shapes.irregular, shapes.drum, shapes.hexagon, shapes.triangle)
SEED = 7
SHOWN = (0.0, 0.15, 0.3, 0.4)  # strains that the pictures show


@dataclass(frozen=True)
class Size:
    """How large the computation is."""

    count: int
    width: float
    spacing: float
    speed: float


FULL = Size(count=40, width=14.0 * MM, spacing=0.18 * MM, speed=1.0)
SMALL = Size(count=9, width=6.0 * MM, spacing=0.25 * MM, speed=2.0)


CASES = ("breaking", "unbreakable")


def make_scene(size: Size = FULL, case: str = "breaking") -> scene.Scene:
    """Grains poured into a box, and a lid that comes down on them."""
    solid = Material(
        name="grain",
        bulk=21.6e6,
        poisson=0.25,
        density=1200.0,
        horizon=3.05 * size.spacing,
        gc=6.0 if case == "breaking" else None,  # N/m
        viscosity=4.0,  # Pa s: ringing between neighbouring nodes dies within a few periods
    )
    contact = Contact(radius=0.95 * size.spacing, stiff=2.0, restitution=0.7, friction=0.4)
    outlines = [shape(1.1 * MM) for shape in SHAPES]
    kinds = np.random.default_rng(SEED).permutation(np.arange(size.count) % len(outlines))
    heap = packing.deposited(
        outlines,
        kinds,
        (0.0, size.width, 0.0, 6.0 * size.width),
        1.01 * size.spacing,
        SEED,
    )
    top = max(heap.outline(i).bounds[3] for i in range(len(heap))) + size.spacing
    return scene.Scene(
        title=f"Compaction of {size.count} {case} grains to {STRAIN:.0%} strain",
        grains=scene.grains_of(heap, [cloud.mesh(o, size.spacing) for o in outlines], solid),
        contact=contact,
        walls=scene.box_walls((0.0, 0.0), (size.width, top), lid_velocity=-size.speed),
        gravity=(0.0, -GRAVITY),
        duration=STRAIN * top / size.speed,
        frames=80,
        records=400,
        attributes=("fragment",),
        energies=True,
    )


@dataclass(frozen=True)
class Course:
    """What the walls felt during one run; stresses in Pa, of the lid's record each.

    Attributes:
        strain: way of the lid over the first height.
        lid, floor: vertical stress there.
        side: mean horizontal stress on the two side walls.
        slip: shear over normal force on the side walls.
        voids: void ratio, the area between the grains over that of the grains.
    """

    strain: np.ndarray
    lid: np.ndarray
    floor: np.ndarray
    side: np.ndarray
    slip: np.ndarray
    voids: np.ndarray

    def at(self, strain: float, what: str, width: float = 0.01) -> float:
        """Mean of a record around a strain."""
        near = np.abs(self.strain - strain) <= width
        return float(getattr(self, what)[near].mean())


def course(folder: Path, size: Size) -> Course:
    """Read the forces on the walls."""
    output = results.Output(folder)
    record = results.averages(folder / scene.WALLS)
    height = float(next(w.point[1] for w in output.walls(0.0) if w.name == "lid"))
    travel = record["v_lid_travel"]
    sides = 0.5 * (record["f_right[1]"] - record["f_left[1]"])
    shear = 0.5 * (record["f_right[2]"] + record["f_left[2]"])
    return Course(
        strain=travel / height,
        lid=record["f_lid[2]"] / size.width,
        floor=-record["f_floor[2]"] / size.width,
        side=sides / (height - travel),
        slip=np.abs(shear) / np.maximum(sides, 1e-9),
        voids=size.width * (height - travel) / output.volumes.sum() - 1.0,
    )


def frame_at(output: results.Output, strain: float) -> int:
    """Number of the frame nearest to a strain."""
    part = strain / STRAIN * output.time(-1)
    return int(np.argmin([abs(output.time(i) - part) for i in range(len(output.dump))]))


def energies(folder: Path) -> dict[str, np.ndarray]:
    """The account of all energy against the strain."""
    table = results.thermo(folder / run.LOG)
    names = ("strain", "contact", "broken bonds", "friction", "damping", "walls", "motion", "drift")
    found = {name: table[f"c_books[{k}]"] for k, name in enumerate(names, 1)}
    return found | {"travel": table["v_lid_travel"]}


def measure(folder: Path, size: Size) -> dict[str, dict[str, float]]:
    """The numbers of both runs."""
    found: dict[str, dict[str, float]] = {}
    for case in CASES:
        run_, output = course(folder / case, size), results.Output(folder / case)
        books = energies(folder / case)
        pieces = results.fragments(output, -1)
        grain = float(output.volumes.sum()) / size.count
        row = {"nodes": float(len(output.reference))}
        for strain in (0.1, 0.2, 0.3, 0.39):
            row[f"stress at {strain:g}"] = run_.at(strain, "lid")
        pressed = run_.strain > 0.25
        row |= {
            "void ratio at start": float(run_.voids[0]),
            "void ratio at end": float(run_.voids[-1]),
            "side over lid": float(run_.side[pressed].sum() / run_.lid[pressed].sum()),
            "floor over lid": float(run_.floor[pressed].sum() / run_.lid[pressed].sum()),
            "slip": float(run_.slip[pressed].mean()),
            "largest slip": float(run_.slip[pressed].max()),
            "fragments": float((pieces.nodes > 1).sum()),
            "fines": float(pieces.volume[pieces.volume < 0.1 * grain].sum() / output.volumes.sum()),
            "damage": output.mean_damage(-1),
            "motion over strain energy": float(
                np.median((books["motion"] / np.maximum(books["strain"], 1e-12))[-20:])
            ),
        }
        work = float(books["walls"][-1])
        for name in ("strain", "contact", "broken bonds", "friction", "damping", "drift"):
            row[f"{name} over work"] = float(books[name][-1]) / work
        found[case] = row
    return found


def plot(folder: Path, size: Size, path: Path) -> None:
    """Stress, void ratio, grading and energy."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 6.4), dpi=110, layout="constrained")
    (stress, voids), (grading, energy) = figure.subplots(2, 2)
    for case, colour in zip(CASES, ("#b3261e", "#1f4e79"), strict=True):
        of = course(folder / case, size)
        stress.semilogy(100 * of.strain, of.lid / 1e3, color=colour, lw=1.2, label=f"{case}: lid")
        stress.semilogy(100 * of.strain, of.side / 1e3, color=colour, lw=0.8, ls=":", label="sides")
        voids.semilogx(of.lid / 1e3, of.voids, color=colour, lw=1.2, label=case)
    stress.set(xlabel="strain (%)", ylabel="stress (kPa)", ylim=(1.0, None))
    voids.set(xlabel="vertical stress (kPa)", ylabel="void ratio", xlim=(1.0, None))
    output = results.Output(folder / "breaking")
    for strain, shade in zip((0.0, 0.2, 0.3, STRAIN), (0.8, 0.6, 0.35, 0.0), strict=True):
        pieces = results.fragments(output, frame_at(output, strain))
        at = np.sort(pieces.size)
        grading.step(at / MM, 100 * pieces.finer(at), where="post", color=str(shade))
        grading.plot([], [], color=str(shade), label=f"strain {strain:.0%}")
    grading.set(xlabel="size of fragments (mm)", ylabel="finer by area (%)", xscale="log")
    books = energies(folder / "breaking")
    names = ("strain", "contact", "motion", "broken bonds", "damping", "friction")
    way = 100 * STRAIN * books["travel"] / books["travel"][-1]
    energy.stackplot(way, [books[name] for name in names], labels=names, alpha=0.8)
    energy.plot(way, books["walls"], "k--", lw=1, label="work of the lid")
    energy.set(xlabel="strain (%)", ylabel="energy (J per m)")
    for axes in (stress, voids, grading, energy):
        axes.grid(alpha=0.3)
        axes.legend(frameon=False, fontsize=8)
    figure.savefig(path)


def main(arguments: list[str] | None = None) -> int:
    """Make, run, measure and draw."""
    options = program.options(
        __doc__, "out/compaction", small="fewer and coarser grains", side_by_side=True
    )
    chosen = options.parse_args(arguments)
    folder: Path = chosen.output
    size = SMALL if chosen.small else FULL

    program.run([make_scene(size, case).write(folder / case) for case in CASES], chosen)
    output = results.Output(folder / "breaking")
    shown = [frame_at(output, strain) for strain in SHOWN]
    render.grains_png(folder / "breaking", folder / "grains.png", shown)
    plot(folder, size, folder / "curves.png")
    found = measure(folder, size)
    (folder / "numbers.json").write_text(json.dumps(found, indent=1) + "\n")
    for name in found["breaking"]:
        print(f"{name:28}" + "".join(f"{found[case][name]:14.5g}" for case in CASES))
    print(f"In {folder}/: numbers.json, curves.png, grains.png, a folder for each run")
    return 0


if __name__ == "__main__":
    sys.exit(main())
