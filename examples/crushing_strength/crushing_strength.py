#!/usr/bin/env python3
"""Crushing strength of single grains against their size and shape: many small runs side by side.

    python crushing_strength.py           46 grains between plates, two runs at a time
    python crushing_strength.py --small   6 grains
    python crushing_strength.py -np 8     eight runs at a time

Everything goes to out/crushing_strength/ (another folder with --output).
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from peridem import cloud, loads, program, render_2d, results, scene, shapes
from peridem.material import Contact, Material
from peridem.render_style import style_of
from peridem.shapes import Outline

MM = 1e-3
SPACING = 0.15 * MM  # of the nodes, in grains of all sizes
RADII = (0.75 * MM, 1.5 * MM, 3.0 * MM)  # of the circle around a grain
SPEED = 0.5  # of the upper plate, m/s: 0.3 % of the speed of waves
PRESSED = 0.25  # way of the plate over the height of the grain
CRACK = 0.5  # length of the cracks of cracked discs over their diameter
CRACK_FACTOR = 1.387  # K_I of that crack over p sqrt(pi a), p = F/(pi R) (Atkinson et al. 1982)

SOLID = Material(
    name="grain",
    bulk=21.6e6,
    poisson=0.25,
    density=1200.0,
    horizon=3.05 * SPACING,
    gc=5.0,  # N/m
    viscosity=4.0,  # Pa s: ringing between neighbouring nodes dies within a few periods
)


@dataclass(frozen=True)
class Test:
    """One grain to be crushed.

    Attributes:
        series: circles, hexagons, ...; cracked discs are one of their own.
        number: of the grain in its series and size.
        radius: of the circle around it.
        outline: its shape, as it lies on the lower plate.
    """

    series: str
    number: int
    radius: float
    outline: Outline

    @property
    def name(self) -> str:
        """Of its folder."""
        return f"{self.series}_{self.radius / MM:g}mm_{self.number}".replace(" ", "_")

    @property
    def height(self) -> float:
        """Distance of the plates that just touch it."""
        low, high = self.outline.extent
        return float(high[1] - low[1])


def lying(outline: Outline, choice: float = 0.0) -> Outline:
    """A polygon turned so that it lies on one of the sides of its hull on which it can rest.

    Args:
        outline: a polygon; other outlines are handed back as they are.
        choice: 0 to 1, which of these sides.
    """
    from scipy.spatial import ConvexHull

    if len(outline.vertices) < 3:
        return outline
    corners = outline.vertices[ConvexHull(outline.vertices).vertices]
    angles = []
    for one, two in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = (two - one) / np.linalg.norm(two - one)
        if 0.0 < along @ (outline.centroid - one) < np.linalg.norm(two - one):
            angles.append(-math.atan2(along[1], along[0]))
    return outline.placed(angle=angles[int(choice * len(angles) * (1.0 - 1e-9))])


def tests(small: bool) -> Iterator[Test]:
    """All grains."""
    kinds = {
        "circle": shapes.circle,
        "hexagon": shapes.hexagon,
        "triangle": shapes.triangle,
        "drum": shapes.drum,
    }
    for radius in RADII[:1] if small else RADII:
        for name, shape in kinds.items():
            yield Test(name, 1, radius, lying(shape(radius)))
        for number in range(1, 2 if small else 11):
            grain = shapes.irregular(radius, corners=8, roughness=0.2, seed=number)
            yield Test("irregular", number, radius, lying(grain, number / 10))
    for radius in (RADII[1],) if small else (1.0 * MM, 1.5 * MM, 2.0 * MM, 3.0 * MM):
        yield Test("cracked disc", 1, radius, shapes.circle(radius))


def make_scene(test: Test) -> scene.Scene:
    """The grain between a plate that rests and one that comes down."""
    radius = 0.95 * SPACING
    low, high = test.outline.extent
    floor, lid = float(low[1]) - radius, float(high[1]) + 1.02 * radius
    cracks = []
    if test.series == "cracked disc":
        half = CRACK * test.radius
        cracks.append(loads.Cut.segment((0.0, -half), (0.0, half)))
    walls = [
        scene.Wall("floor", (0.0, floor - 0.02 * radius), (0.0, 1.0)),
        scene.Wall("lid", (0.0, lid), (0.0, -1.0), (0.0, -SPEED)),
    ]
    side = 2.0 * test.radius
    return scene.Scene(
        title=f"Crushing a grain: {test.series}, {2 * test.radius / MM:g} mm",
        grains=[scene.Grain(cloud.mesh(test.outline, SPACING), SOLID)],
        contact=Contact(radius=radius, stiff=2.0, restitution=0.8, friction=0.3),
        walls=walls,
        duration=PRESSED * test.height / SPEED,
        frames=50,
        records=250,
        cuts=cracks,
        boundary="s",
        box=((float(low[0]) - side, floor - side), (float(high[0]) + side, lid + side)),
    )


def failure(force: np.ndarray, fall: float = 0.5) -> int:
    """Where the force has its first peak from which it falls by this part of the peak."""
    highest = np.maximum.accumulate(force)
    dropped = np.flatnonzero((force < (1.0 - fall) * highest) & (highest > 0.5 * force.max()))
    end = dropped[0] if len(dropped) else len(force)
    return int(force[:end].argmax())


def young() -> float:
    """Young's modulus of the grains."""
    return 3.0 * SOLID.bulk * (1.0 - 2.0 * SOLID.poisson)


def disc_strength() -> float:
    """Force over height and thickness at which the middle of a disc breaks.

    There sigma_x = 2F/(pi D) and sigma_y = -3 sigma_x (Hertz 1883), so in plane strain
    epsilon_x = (1 + nu)(1 + 2 nu) sigma_x/E, which reaches the critical stretch.
    """
    nu, stretch = SOLID.poisson, SOLID.critical_stretch(2)
    return 0.5 * math.pi * young() * stretch / ((1.0 + nu) * (1.0 + 2.0 * nu))


def cracked_strength(radius: float) -> float:
    """The same of a disc with a central crack along the load, where K_I reaches sqrt(E' Gc)."""
    toughness = math.sqrt(young() / (1.0 - SOLID.poisson**2) * float(SOLID.gc or 0.0))
    stress = toughness / (CRACK_FACTOR * math.sqrt(math.pi * CRACK * radius))  # F/(pi R)
    return 0.5 * math.pi * stress


def crushed(test: Test, folder: Path) -> dict[str, float | str]:
    """Read the strength of a grain from what its run left."""
    record = results.averages(folder / test.name / scene.WALLS)
    force, travel = -record["f_floor[2]"], record["v_lid_travel"]
    peak = failure(force)
    known = {"circle": disc_strength(), "cracked disc": cracked_strength(test.radius)}
    return {
        "name": test.name,
        "series": test.series,
        "size": 2.0 * test.radius,
        "height": test.height,
        "strength": float(force[peak]) / test.height,
        "strain": float(travel[peak]) / test.height,
        "theory": known.get(test.series, math.nan),
    }


def numbers(rows: list[dict[str, float | str]]) -> str:
    """What was measured, as text: strengths by series and size in kPa."""
    sizes = sorted({float(row["size"]) for row in rows})
    lines = ["strength (kPa)    " + "".join(f"{size / MM:7.3g} mm" for size in sizes)]
    for series in dict.fromkeys(str(row["series"]) for row in rows):
        line = f"{series:18}"
        for size in sizes:
            mine = [r for r in rows if r["series"] == series and r["size"] == size]
            values = np.array([r["strength"] for r in mine], dtype=float)
            line += f"{np.median(values) / 1e3:10.0f}" if len(values) else 10 * " "
        lines.append(line)
        theory = {r["size"]: float(r["theory"]) for r in rows if r["series"] == series}
        if np.isfinite(list(theory.values())).all():
            texts = [f"{theory[k] / 1e3:10.0f}" if k in theory else 10 * " " for k in sizes]
            lines.append(f"{'  formula':18}" + "".join(texts))
    return "\n".join(lines)


def plot(rows: list[dict[str, float | str]], path: Path) -> None:
    """Strength against size, with what formulas say."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 4.2), dpi=110, layout="constrained")
    axes = figure.subplots()
    marks = {"circle": "o", "hexagon": "h", "triangle": "^", "drum": "X", "cracked disc": "D"}
    for series in dict.fromkeys(str(row["series"]) for row in rows):
        mine = [r for r in rows if r["series"] == series]
        size = np.array([r["size"] for r in mine], dtype=float) / MM
        strength = np.array([r["strength"] for r in mine], dtype=float) / 1e3
        if series == "irregular":
            axes.plot(size, strength, ".", color="#9aa5b1", ms=4, label="irregular, 10 of each")
            every = np.unique(size)
            middle = [float(np.median(strength[size == d])) for d in every]
            axes.plot(every, middle, "s-", color="#5b6673", ms=6, label="irregular, median")
        else:
            axes.plot(size, strength, marks[series] + "-", lw=1.0, ms=7, label=series)
    ends = np.array([min(float(r["size"]) for r in rows), max(float(r["size"]) for r in rows)])
    ends *= np.array([0.9, 1.1])
    across = np.linspace(*ends, 50)
    lefm = [cracked_strength(0.5 * d) / 1e3 for d in across]
    axes.plot(ends / MM, 2 * [disc_strength() / 1e3], "k--", lw=1, label="disc, by its stretch")
    axes.plot(across / MM, lefm, "k:", lw=1, label="cracked disc, by its toughness")
    axes.set(xscale="log", yscale="log", xlabel="diameter (mm)", ylabel="strength F/(h t) (kPa)")
    ticks = sorted({float(r["size"]) / MM for r in rows})
    axes.set_xticks(ticks, [f"{t:g}" for t in ticks])
    axes.set_xticks([], minor=True)
    axes.set_yticks([200, 300, 500, 700, 1000], ["200", "300", "500", "700", "1000"])
    axes.set_yticks([], minor=True)
    axes.grid(alpha=0.3)
    figure.legend(loc="outside right upper", frameon=False, fontsize=8)
    figure.savefig(path)


def draw(chosen: list[Test], folder: Path, path: Path) -> None:
    """Grains before the load and after they have failed, one column for each."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(1.6 * len(chosen), 3.0), dpi=110)
    for column, test in enumerate(chosen):
        output = results.Output(folder / test.name)
        record = results.averages(folder / test.name / scene.WALLS)
        peak = record["v_now"][failure(-record["f_floor[2]"])]
        times = np.array([output.time(i) for i in range(len(output.dump))])
        after = min(int(np.searchsorted(times, 1.12 * peak)), len(times) - 1)
        y_low, y_high = render_2d.view(output, [0])[2:]
        middle, half = 0.5 * (y_low + y_high), 0.95 * test.radius + 0.25 * test.height
        for row, i in enumerate((0, after)):
            axes = figure.add_axes(
                (column / len(chosen), (1 - row) * 0.46, 0.98 / len(chosen), 0.44)
            )
            axes.axis("off")
            wide = half * 1.6 * 0.98 / (0.44 * 3.0)
            axes.set(xlim=(-wide, wide), ylim=(middle - half, middle + half))
            render_2d.draw_frame(axes, output, i, style_of(output, [i]))
        figure.text((column + 0.5) / len(chosen), 0.94, test.series, ha="center")
    figure.savefig(path)


def main(arguments: list[str] | None = None) -> int:
    """Make, run, measure and draw."""
    options = program.options(
        __doc__, "out/crushing_strength", small="one small grain of each series", side_by_side=True
    )
    chosen = options.parse_args(arguments)
    folder: Path = chosen.output

    every = list(tests(chosen.small))  # gmsh makes one mesh at a time
    program.run([make_scene(test).write(folder / test.name) for test in every], chosen)
    rows = [crushed(test, folder) for test in every]
    (folder / "strengths.json").write_text(json.dumps(rows, indent=1) + "\n")
    plot(rows, folder / "strength.png")
    middle = RADII[0 if chosen.small else 1]
    shown = [t for t in every if t.number == 1 and (t.radius == middle or chosen.small)]
    draw(shown, folder, folder / "grains.png")
    print(numbers(rows))
    print(f"In {folder}/: strengths.json, strength.png, grains.png; a folder for each grain")
    return 0


if __name__ == "__main__":
    sys.exit(main())
