#!/usr/bin/env python3
"""Silos empty through slots of three widths: how fast, and how many grains break as they land.

    python silo.py            three silos, two runs at a time
    python silo.py --small    one, with fewer and coarser grains

Everything goes to out/silo/ (another folder with --output).
"""

from __future__ import annotations

import json
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from peridem import cloud, packing, program, render, results, scene, shapes
from peridem.material import Contact, Material
from peridem.regions import Block

MM = 1e-3
GRAVITY = 10.0
DENSITY = 1200.0
RADIUS = 1.0 * MM  # of the circle around a grain
SHAPES = (shapes.circle, shapes.hexagon, shapes.irregular)
SEED = 5
CONTACT, FRICTION = 0.95, 0.4  # contact radius over the node spacing; coefficient


@dataclass(frozen=True)
class Size:
    """How large the computation is; lengths in diameters of the circle around a grain."""

    count: int
    width: float
    openings: tuple[float, ...]
    drop: float
    spacing: float
    duration: float


FULL = Size(
    count=200, width=14.0, openings=(5.0, 6.0, 7.0), drop=14.0, spacing=0.5 * MM, duration=0.3
)
SMALL = Size(count=40, width=10.0, openings=(7.0,), drop=8.0, spacing=0.55 * MM, duration=0.2)


def bed(size: Size, lmp: Path | None = None) -> packing.Packing:
    """Grains at rest on the floor of the silo, moved there as rigid bodies."""
    outlines = [shape(RADIUS) for shape in SHAPES]
    kinds = np.random.default_rng(SEED).permutation(np.arange(size.count) % len(outlines))
    half = size.width * RADIUS
    box = (-half, half, 0.0, 4.0 * RADIUS * size.count / size.width)
    heap = packing.deposited(outlines, kinds, box, 1.15 * size.spacing, SEED)
    # settled leaves grains some tenth further apart than asked for: about a contact radius
    return packing.settled(heap, 0.9 * CONTACT * size.spacing, friction=FRICTION, lmp=lmp)


def make_scene(grains: packing.Packing, size: Size, opening: float) -> scene.Scene:
    """Grains on the floor of a silo, whose slot is open from the start, and a bin below."""
    solid = Material(
        name="grain",
        bulk=1.0e5,
        poisson=0.25,
        density=DENSITY,
        horizon=3.05 * size.spacing,
        s0=0.05,
        viscosity=0.1,  # Pa s
    )
    diameter = 2.0 * RADIUS
    half = 0.5 * size.width * diameter
    slot, drop = 0.5 * opening * diameter, size.drop * diameter
    walls = [
        scene.Wall("left", (-half, 0.0), (1.0, 0.0)),
        scene.Wall("right", (half, 0.0), (-1.0, 0.0)),
        scene.Wall("bin", (0.0, -drop), (0.0, 1.0)),
        scene.RegionWall(
            "shelf_left", Block((-half - diameter, -diameter), (-slot, 0.0), inside=False)
        ),
        scene.RegionWall(
            "shelf_right", Block((slot, -diameter), (half + diameter, 0.0), inside=False)
        ),
    ]
    return scene.Scene(
        title=f"A silo of {size.count} grains empties through a slot of {opening:g} diameters",
        grains=scene.grains_of(
            grains, [cloud.mesh(o, size.spacing) for o in grains.outlines], solid
        ),
        contact=Contact(
            radius=CONTACT * size.spacing, stiff=2.0, restitution=0.5, friction=FRICTION
        ),
        walls=walls,
        gravity=(0.0, -GRAVITY),
        duration=size.duration,
        frames=140,
        records=400,
        attributes=("fragment",),
    )


@dataclass(frozen=True, eq=False)
class Discharge:
    """One silo; lengths in m, masses in kg per m of thickness.

    Attributes:
        times: (t,) of the frames.
        passed: (t,) mass of grains below the slot.
        broken: (t,) how many grains have lost a bond.
        landed: (t,) how many grains have touched the bottom of the bin or what lies there.
        slot: width of the opening for surfaces that touch half a contact radius from the nodes.
        diameter: mean of the circles of the same area, half a contact radius added all around.
        bulk: mass of grains per area in the silo, early on.
        total: mass of all grains.
    """

    times: np.ndarray
    passed: np.ndarray
    broken: np.ndarray
    landed: np.ndarray
    slot: float
    diameter: float
    bulk: float
    total: float

    @property
    def rate(self) -> float:
        """Mass per time while between a tenth and two fifths of all grains have passed; 0 if
        an arch has stopped them before."""
        part = self.passed / self.total
        steady = (part > 0.1) & (part < 0.4)
        if steady.sum() < 3:
            return 0.0
        return float(np.polyfit(self.times[steady], self.passed[steady], 1)[0])

    def beverloo(self, factor: float = 1.03, rim: float = 1.4) -> float:
        """The rate by Beverloo's law for a slot, 1.03 rho sqrt(g) (D - k d)^(3/2)."""
        free = self.slot - rim * self.diameter
        return factor * self.bulk * math.sqrt(GRAVITY) * free**1.5


def discharge(folder: Path, size: Size, opening: float) -> Discharge:
    """Read one silo's frames."""
    output = results.Output(folder)
    grain = output.frame(0)["mol"].astype(int) - 1
    area = np.bincount(grain, output.volumes)
    diameter, bottom = 2.0 * RADIUS, -size.drop * 2.0 * RADIUS
    rows, bulk, down = [], 0.0, np.zeros(len(area), dtype=bool)
    for i in range(len(output.dump)):
        frame, time = output.frame(i), output.time(i)
        _, centre = results.per_grain(frame, weights=output.volumes)
        _, speed = results.per_grain(frame, frame.velocity[:, :2], output.volumes)
        below = centre[:, 1] < -0.5 * diameter
        down |= (centre[:, 1] < 0.4 * bottom) & (np.abs(speed[:, 1]) < 0.3)
        lost = np.bincount(grain, output.field("damage", i)) > 0.0
        rows.append((time, DENSITY * area[below].sum(), lost.sum(), down.sum()))
        if bulk == 0.0 and time > 0.04:
            bulk = _bulk(output, i, size)
    grown = np.sqrt(4.0 * area / math.pi) + output.contact_radius
    slot = opening * diameter - output.contact_radius
    total = DENSITY * float(area.sum())
    return Discharge(*np.array(rows).T, slot, float(grown.mean()), bulk, total)


def _bulk(output: results.Output, i: int, size: Size) -> float:
    """Mass per area between one and five diameters above the floor of the silo."""
    x = output.frame(i).position
    low, high = 2.0 * RADIUS, 10.0 * RADIUS
    between = (x[:, 1] > low) & (x[:, 1] < high)
    width = 2.0 * RADIUS * size.width
    return DENSITY * float(output.volumes[between].sum()) / (width * (high - low))


def measure(folder: Path, size: Size) -> list[dict[str, float]]:
    """The numbers of each silo."""
    rows = []
    for opening in size.openings:
        of = discharge(folder / f"slot_{opening:g}", size, opening)
        output = results.Output(folder / f"slot_{opening:g}")
        pieces = results.fragments(output, -1)
        largest = np.zeros(size.count + 1)
        np.maximum.at(largest, pieces.grain, pieces.volume)
        rows.append(
            {
                "opening": opening,
                "slot over diameter": of.slot / of.diameter,
                "rate": of.rate,
                "beverloo": of.beverloo(),
                "bulk density": of.bulk,
                "passed": float(of.passed[-1]) / of.total,
                "landed": float(of.landed[-1]),
                "broken": float(of.broken[-1]),
                "debris": 1.0 - float(largest.sum() / output.volumes.sum()),
            }
        )
    return rows


def plot(folder: Path, size: Size, path: Path) -> None:
    """Mass that has passed; the rate against Beverloo's law; grains that broke."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 3.4), dpi=110, layout="constrained")
    mass, law, broken = figure.subplots(1, 3)
    for opening in size.openings:
        of = discharge(folder / f"slot_{opening:g}", size, opening)
        label = f"slot {of.slot / of.diameter:.1f} d"
        [line] = mass.plot(1e3 * of.times, of.passed, lw=1.4, label=label)
        law.plot(of.slot / of.diameter, of.rate ** (2 / 3), "o", color=line.get_color())
        broken.plot(of.landed, of.broken, lw=1.4, color=line.get_color())
    wide = np.linspace(1.4, 1.1 * of.slot / of.diameter, 2)
    scale = (1.03 * of.bulk * math.sqrt(GRAVITY)) ** (2 / 3) * of.diameter
    law.plot(wide, scale * (wide - 1.4), "k--", lw=1, label="Beverloo")
    mass.set(xlabel="time (ms)", ylabel="mass that has passed (kg per m)")
    law.set(xlabel="width of the slot (d)", ylabel="rate$^{2/3}$ (kg per m and s)$^{2/3}$")
    law.set(xlim=(0, None), ylim=(0, None))
    broken.set(xlabel="grains that have landed", ylabel="grains with broken bonds")
    broken.axline((0, 0), slope=1.0, color="k", lw=0.6, ls=":")
    for axes in (mass, law, broken):
        axes.grid(alpha=0.3)
    mass.legend(frameon=False)
    law.legend(frameon=False)
    figure.savefig(path)


def main(arguments: list[str] | None = None) -> int:
    """Make, run, measure and draw."""
    options = program.options(
        __doc__, "out/silo", small="one silo with fewer grains", side_by_side=True
    )
    chosen = options.parse_args(arguments)
    folder: Path = chosen.output
    size = SMALL if chosen.small else FULL

    start = bed(size, chosen.lmp)
    scripts = [make_scene(start, size, o).write(folder / f"slot_{o:g}") for o in size.openings]
    program.run(scripts, chosen)
    middle = folder / f"slot_{size.openings[len(size.openings) // 2]:g}"
    last = len(results.Output(middle).dump) - 1
    render.grains_png(middle, folder / "grains.png", [0, last // 4, last // 2, last])
    plot(folder, size, folder / "rates.png")
    rows = measure(folder, size)
    (folder / "numbers.json").write_text(json.dumps(rows, indent=1) + "\n")
    for name in rows[0]:
        print(f"{name:20}" + "".join(f"{row[name]:10.4g}" for row in rows))
    print(f"In {folder}/: numbers.json, rates.png, grains.png, a folder for each run")
    return 0


if __name__ == "__main__":
    sys.exit(main())
