#!/usr/bin/env python3
"""Concave grains, stars and drums, fall on a wall, hook into each other and come to rest.

    python concave.py                  twelve grains of two sizes and two materials
    python concave.py --small          four grains, half the time

Everything goes to out/concave/ (another folder with --output).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from peridem import cloud, packing, program, render, results, run, scene, shapes
from peridem.material import Contact, Material

MM = 1e-3
RADII = (1.2 * MM, 0.9 * MM)  # of the stars and of the drums: circles around them
SPACING = 0.13 * MM
GRAVITY = 10.0
SPEED = 0.2  # m/s downwards at the start
WALLS = ("floor", "left", "right")
SEED = 3


def solids() -> tuple[Material, Material]:
    """Two rubbery solids, one of them three times as stiff and half as heavy again."""
    common = {"poisson": 0.25, "horizon": 3.05 * SPACING, "viscosity": 0.1}
    soft = Material(name="soft", bulk=0.216e6, density=1200.0, **common)
    stiff = Material(name="stiff", bulk=0.648e6, density=1800.0, **common)
    return soft, stiff


def make_scene(small: bool) -> scene.Scene:
    """Stars and drums on a grid above a floor between two walls."""
    outlines = [
        shapes.star(RADII[0], 5, 0.45),
        shapes.drum(RADII[0], 0.35),
        shapes.star(RADII[1], 4, 0.45),
        shapes.drum(RADII[1], 0.35),
    ]
    clouds = [cloud.mesh(outline, SPACING) for outline in outlines]
    count, width = (4, 5.2 * MM) if small else (12, 7.8 * MM)
    kinds = np.random.default_rng(SEED).permutation(np.arange(count) % len(outlines))
    radius = 0.95 * min(scene.surface_spacing(mesh) for mesh in clouds)
    box = (0.0, width, 0.0, 14.0 * MM)
    heap = packing.grid(outlines, kinds, box, 1.05 * radius, jitter=1.0, seed=SEED)
    soft, stiff = solids()
    grains = [
        scene.Grain(grain.cloud, grain.material, velocity=(0.0, -SPEED))
        for grain in scene.grains_of(heap, clouds, [soft, stiff, stiff, soft])
    ]
    top = max(heap.outline(i).bounds[3] for i in range(count))
    floor, left, right, _ = scene.box_walls((0.0, 0.0), (width, top))
    return scene.Scene(
        title=f"{count} concave grains fall on a wall",
        grains=grains,
        contact=Contact(radius=radius, stiff=0.5, restitution=0.4, friction=0.4),
        walls=[floor, left, right],
        gravity=(0.0, -GRAVITY),
        duration=0.08 if small else 0.1,
        margin=3.0 * MM,
        records=300,
        energies=True,
    )


def measure(folder: Path) -> dict[str, float]:
    """What the heap weighs, what the walls feel, and how quiet it is at the end."""
    output = results.Output(folder)
    of = {solid.name: solid.density for solid in solids()}
    density = np.array([of[name] for name in output.summary["materials"]])
    mass = density[output.frame(0)["type"].astype(int) - 1] * output.volumes
    record = results.averages(folder / scene.WALLS)
    late = slice(-len(record["v_now"]) // 10, None)  # the last tenth
    touching = results.contacts(output, -1)
    between = results.network(touching)
    thermo = output.thermo
    start = thermo["c_books[7]"][0]
    height = mass @ (output.frame(0).position[:, 1] - output.frame(-1).position[:, 1])
    return {
        "weight": GRAVITY * mass.sum(),
        "floor": -record["f_floor[2]"][late].mean(),
        "carried": -sum(record[f"f_{wall}[2]"][late].mean() for wall in WALLS),
        "sideways": sum(record[f"f_{wall}[1]"][late].mean() for wall in WALLS),
        "peak": -record["f_floor[2]"].min(),
        "fallen": GRAVITY * height,
        "kinetic_start": start,
        "kinetic_end": thermo["c_books[7]"][-1],
        "strain_end": thermo["c_books[1]"][-1],
        "friction": thermo["c_books[4]"][-1],
        "damping": thermo["c_books[5]"][-1],
        "drift": abs(thermo["c_books[8]"]).max(),
        "overlap": float(touching.overlap.max()) / output.contact_radius,
        "touching": len(between.bodies),
        "broken": thermo["c_damage"][-1],
    }


def table(found: dict[str, float]) -> str:
    """What was measured, as text."""
    put_in = found["kinetic_start"] + found["fallen"]
    part = {k: found[k] / put_in for k in ("friction", "damping", "kinetic_end", "drift")}
    return f"""\
weight of the grains             {found["weight"]:.4f} N/m
carried by all walls, at the end {found["carried"]:.4f} N/m, by the floor {found["floor"]:.4f} N/m
sideways on all walls together   {found["sideways"]:+.5f} N/m
largest force on the floor       {found["peak"]:.2f} N/m
energy put in                    {put_in:.3e} J/m, {found["fallen"] / put_in:.0%} by the fall
  lost to friction               {part["friction"]:.1%}
  lost to damping                {part["damping"]:.1%}
  still in motion                {part["kinetic_end"]:.1e}
  drift of the account           {part["drift"]:.1e}
pairs of grains that touch       {found["touching"]:.0f}
overlap at the end               up to {found["overlap"]:.2%} of the contact radius"""


def plot(folder: Path, path: Path) -> None:
    """Force on the floor and kinetic energy against time."""
    from matplotlib.figure import Figure

    record, found = results.averages(folder / scene.WALLS), measure(folder)
    thermo = results.thermo(folder / run.LOG)
    figure = Figure(figsize=(7.5, 4.6), dpi=110, layout="constrained")
    force, energy = figure.subplots(2, 1, sharex=True)
    force.plot(1e3 * record["v_now"], -record["f_floor[2]"], color="#1f4e79", lw=0.9)
    force.axhline(found["weight"], color="#b3261e", ls="--", lw=1.2, label="weight of the grains")
    force.set_ylabel("force on the floor (N/m)")
    force.legend(frameon=False)
    time = 1e3 * thermo["Time"]
    for column, name in ((7, "kinetic"), (4, "lost to friction"), (5, "lost to damping")):
        energy.plot(time, 1e6 * thermo[f"c_books[{column}]"], label=name)
    energy.set_ylabel("energy (µJ/m)")
    energy.set_xlabel("time (ms)")
    energy.legend(frameon=False, ncols=3, loc="center right", bbox_to_anchor=(1.0, 0.64))
    for axes in (force, energy):
        axes.grid(alpha=0.3)
    figure.savefig(path)


def main(arguments: list[str] | None = None) -> int:
    """Make, run, measure and draw."""
    options = program.options(__doc__, "out/concave", small="fewer grains, less time: seconds")
    chosen = options.parse_args(arguments)
    folder: Path = chosen.output
    [report] = program.run(make_scene(chosen.small).write(folder), chosen)
    print(table(measure(folder)))
    plot(folder, folder / "force.png")
    last = len(results.Dump(folder / scene.DUMP)) - 1
    shown = [0, last // 5, last // 3, last]
    render.grains_png(folder, folder / "grains.png", shown, field="type", colours="Pastel1")
    print(f"{report.steps} steps in {report.wall_time:.0f} s; pictures are in {folder}/")
    return 0


if __name__ == "__main__":
    sys.exit(main())
