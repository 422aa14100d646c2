#!/usr/bin/env python3
"""Attrition in a turning drum with a fin: what grains of two sizes and toughnesses lose in a turn.

    python attrition.py            three turns of 40 grains, on 2 ranks
    python attrition.py --small    half a turn of 16 coarser grains
    python attrition.py --turns 5  for longer

Everything goes to out/attrition/ (another folder with --output).
"""

from __future__ import annotations

import json
import math
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from peridem import cloud, packing, program, render, results, run, scene, shapes
from peridem.material import Contact, Material
from peridem.regions import Block, Combined, Cylinder, Rotation

MM = 1e-3
GRAVITY = 10.0
DRUM = 15.0 * MM  # inner radius
FIN = (4.0 * MM, 0.6 * MM)  # how far it reaches in, and its thickness
RATE = -6.0 * math.pi  # rad/s: clockwise, three turns in a second
RADII = {"small": 1.0 * MM, "large": 2.0 * MM}
STRETCH = {"brittle": 0.04, "tough": 0.08}  # at which bonds break
SHAPES = (shapes.circle, shapes.triangle, shapes.hexagon, shapes.drum)
SEED = 3


@dataclass(frozen=True)
class Size:
    """How large the computation is: grains of each shape and toughness, nodes, turns."""

    small: int
    large: int
    spacing: float
    turns: float


FULL = Size(small=4, large=1, spacing=0.35 * MM, turns=3.0)
SMALL = Size(small=1, large=1, spacing=0.45 * MM, turns=0.5)


def solid(toughness: str, spacing: float) -> Material:
    """What grains of a toughness are made of."""
    return Material(
        name=toughness,
        bulk=1.0e5,
        poisson=0.25,
        density=1200.0,
        horizon=3.05 * spacing,
        s0=STRETCH[toughness],
        viscosity=0.1,  # Pa s
    )


def classes(size: Size) -> list[tuple[str, str]]:
    """Size and toughness of each grain, in the order of their numbers."""
    return [
        (extent, toughness)
        for extent, count in (("large", size.large), ("small", size.small))
        for toughness in STRETCH
        for _ in range(count * len(SHAPES))
    ]


def make_scene(size: Size = FULL) -> scene.Scene:
    """Grains thrown into a drum of two regions that turn together."""
    every = classes(size)
    outlines = [shape(RADII[extent]) for extent in RADII for shape in SHAPES]
    kinds = [
        len(SHAPES) * list(RADII).index(extent) + k % len(SHAPES)
        for k, (extent, _) in enumerate(every)
    ]
    hole = shapes.annulus(DRUM, DRUM + MM, FIN, angle=0.0).holes[0]
    low = np.array([-DRUM, -DRUM])
    within = packing.Container(low, np.array([DRUM, 4.0 * MM]), inside=hole)  # not its top
    thrown = packing.random_sequential(outlines, kinds, within, 1.1 * size.spacing, SEED)
    clouds = [cloud.mesh(outline, size.spacing) for outline in outlines]
    grains = [
        scene.Grain(clouds[kind].placed(place, angle), solid(toughness, size.spacing))
        for kind, place, angle, (_, toughness) in zip(
            kinds, thrown.position, thrown.angle, every, strict=True
        )
    ]
    fin = Block((DRUM - FIN[0], -0.5 * FIN[1]), (DRUM + MM, 0.5 * FIN[1]), inside=False)
    shell = Combined((Cylinder((0.0, 0.0), DRUM), fin))
    turn = Rotation(RATE, (0.0, 0.0))
    return scene.Scene(
        title=f"{len(grains)} grains in a drum with a fin",
        grains=grains,
        contact=Contact(radius=0.95 * size.spacing, stiff=2.0, restitution=0.6, friction=0.5),
        walls=[scene.RegionWall("drum", shell, rotation=turn)],
        gravity=(0.0, -GRAVITY),
        duration=size.turns * 2.0 * math.pi / abs(RATE),
        frames=max(20, round(40 * size.turns)),
        records=max(50, round(200 * size.turns)),
        attributes=("fragment",),
        energies=True,
        box=((-1.2 * DRUM, -1.2 * DRUM), (1.2 * DRUM, 1.2 * DRUM)),
    )


@dataclass(frozen=True, eq=False)
class Wear:
    """What grains have lost; all that no longer hangs on the largest piece of its grain.

    Attributes:
        turns: (t,) of the drum, one for each frame.
        lost: (t, n) area that each grain has lost.
        area: (n,) of each grain.
        fines: (t,) part of all area in pieces smaller than a tenth of a small circle.
        chipped: (t,) how many grains have lost something.
    """

    turns: np.ndarray
    lost: np.ndarray
    area: np.ndarray
    fines: np.ndarray
    chipped: np.ndarray

    def part(self, grains: np.ndarray) -> np.ndarray:
        """Part of the area that some of the grains have lost, (t,)."""
        return np.asarray(self.lost[:, grains].sum(axis=1) / self.area[grains].sum())


def wear(folder: Path) -> Wear:
    """Read the fragments in all frames."""
    output = results.Output(folder)
    area = np.bincount(output.frame(0)["mol"].astype(int) - 1, output.volumes)
    small = 0.1 * math.pi * RADII["small"] ** 2
    turns, lost, fines = [], [], []
    for i in range(len(output.dump)):
        pieces = results.fragments(output, i)
        largest = np.zeros(len(area))
        np.maximum.at(largest, pieces.grain - 1, pieces.volume)
        turns.append(output.time(i) * abs(RATE) / (2.0 * math.pi))
        lost.append(area - largest)
        fines.append(pieces.volume[pieces.volume < small].sum() / area.sum())
    gone = np.array(lost)
    return Wear(np.array(turns), gone, area, np.array(fines), (gone > 1e-15).sum(axis=1))


def groups(size: Size) -> dict[str, np.ndarray]:
    """Grains by size and toughness, and by shape: which, (n,) true or false."""
    every = classes(size)
    found = {}
    for extent, toughness in dict.fromkeys(every):
        found[f"{extent}, {toughness}"] = np.array([c == (extent, toughness) for c in every])
    for k, shape in enumerate(SHAPES):
        found[f"{shape.__name__}s"] = np.arange(len(every)) % len(SHAPES) == k
    return found


def measure(folder: Path, size: Size) -> dict[str, float]:
    """The numbers."""
    worn = wear(folder)
    record = results.averages(folder / scene.WALLS)
    books = results.thermo(folder / run.LOG)
    torque = record["f_drum[6]"]
    tumbling = record["v_now"] > 0.3 * record["v_now"][-1]
    span = np.diff(record["v_now"], prepend=0.0)
    row = {
        "grains": float(len(worn.area)),
        "turns": float(worn.turns[-1]),
        "lost": float(worn.part(np.ones(len(worn.area), dtype=bool))[-1]),
        "fines": float(worn.fines[-1]),
        "damage": results.Output(folder).mean_damage(-1),
        "grains that lost something": float(worn.chipped[-1]),
        "torque": float(np.abs(torque[tumbling].mean())),
        "work by torque": float(-(torque * span).sum() * RATE),
        "work": float(books["c_books[6]"][-1]),
        "friction over work": float(books["c_books[4]"][-1] / books["c_books[6]"][-1]),
        "damping over work": float(books["c_books[5]"][-1] / books["c_books[6]"][-1]),
        "broken bonds over work": float(books["c_books[3]"][-1] / books["c_books[6]"][-1]),
        "drift over work": float(books["c_books[8]"][-1] / books["c_books[6]"][-1]),
    }
    for name, grains in groups(size).items():
        row[f"lost by {name}"] = float(worn.part(grains)[-1])
    return row


def plot(folder: Path, size: Size, path: Path) -> None:
    """What grains lose against turns, by kind; fines; the torque."""
    from matplotlib.figure import Figure

    worn, record = wear(folder), results.averages(folder / scene.WALLS)
    figure = Figure(figsize=(10.0, 3.4), dpi=110, layout="constrained")
    kinds, forms, torque = figure.subplots(1, 3)
    for name, grains in groups(size).items():
        axes = kinds if "," in name else forms
        axes.plot(worn.turns, 100.0 * worn.part(grains), lw=1.3, label=name)
    forms.plot(worn.turns, 100.0 * worn.fines, "k--", lw=1.2, label="fines of all")
    turns = record["v_now"] * abs(RATE) / (2.0 * math.pi)
    torque.plot(turns, 1e3 * np.abs(record["f_drum[6]"]), lw=0.5, color="#9db4cc")
    window = max(1, len(turns) // 30)
    smooth = np.convolve(record["f_drum[6]"], np.full(window, 1.0 / window), "same")
    torque.plot(turns, 1e3 * np.abs(smooth), lw=1.4, color="#1f4e79")
    kinds.set(xlabel="turns", ylabel="area lost (%)")
    forms.set(xlabel="turns", ylabel="area lost (%)")
    torque.set(xlabel="turns", ylabel="torque (mN m per m)")
    torque.set_ylim(0.0, 3.0e3 * float(np.abs(smooth).mean()))
    for axes in (kinds, forms, torque):
        axes.grid(alpha=0.3)
        axes.set_xlim(0.0, worn.turns[-1])
    kinds.legend(frameon=False, fontsize=8)
    forms.legend(frameon=False, fontsize=8)
    figure.savefig(path)


def main(arguments: list[str] | None = None) -> int:
    """Make, run, measure and draw."""
    options = program.options(__doc__, "out/attrition", small="half a turn of 16 coarser grains")
    options.add_argument("--turns", type=float, help="how many turns (3)")
    chosen = options.parse_args(arguments)
    folder: Path = chosen.output
    size = SMALL if chosen.small else FULL
    if chosen.turns is not None:
        size = replace(size, turns=chosen.turns)

    program.run(make_scene(size).write(folder), chosen)
    last = len(results.Output(folder).dump) - 1
    shown = [0, round(0.22 * last), round(0.61 * last), last]
    render.grains_png(folder, folder / "grains.png", shown)
    plot(folder, size, folder / "wear.png")
    found = measure(folder, size)
    (folder / "numbers.json").write_text(json.dumps(found, indent=1) + "\n")
    for name, value in found.items():
        print(f"{name:28}{value:12.4g}")
    print(f"In {folder}/: numbers.json, wear.png, grains.png, in.grains and what it wrote")
    return 0


if __name__ == "__main__":
    sys.exit(main())
