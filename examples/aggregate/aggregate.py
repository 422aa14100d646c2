#!/usr/bin/env python3
"""An aggregate of irregular grains in space, dropped into a box and crushed by a lid.

    python aggregate.py                  128 grains of six shapes and two sizes
    python aggregate.py --small          16 coarser grains

Everything goes to out/aggregate/ (another folder with --output).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from peridem import cloud, packing, program, render, results, scene, shapes
from peridem.material import Contact, Material

MM = 1e-3
RADII = (1.0 * MM, 0.8 * MM)  # of the spheres around the grains
SEEDS = (1, 2, 3)  # of shapes of each size
FALL, SPEED = 1.0, 0.7  # m/s: of the grains at the start, of the lid; the grains land first
FILLED = 0.6  # part of the room between the walls that the grains fill at the end
SEED = 5


def solid(spacing: float) -> Material:
    """A soft, brittle stone: K is small so that waves are slow and steps long."""
    return Material(
        name="stone",
        bulk=21.6e6,
        poisson=0.25,
        density=1200.0,
        horizon=2.3 * spacing,  # between the shells of the lattice at 2.24 and 2.45
        gc=4.0,  # N/m: bonds break at a stretch of 1.2 %
        viscosity=4.0,  # Pa s: ringing between neighbouring nodes dies within a few periods
    )


def make_scene(small: bool) -> scene.Scene:
    """Grains on a grid in a tall box; a lid follows them down and goes on."""
    spacing = (0.36 if small else 0.28) * MM
    across, layers = (2, 4) if small else (4, 8)
    outlines = [
        shapes.irregular_solid(radius, corners=16, roughness=0.2, seed=seed, elongation=1.2)
        for radius in RADII
        for seed in SEEDS
    ]
    # nodes of one volume: the surface nodes of a mesh are light, and need short steps
    clouds = [cloud.lattice(outline, spacing) for outline in outlines]
    radius = 0.95 * spacing
    count = across * across * layers
    kinds = np.random.default_rng(SEED).permutation(np.arange(count) % len(outlines))
    cell = 2.0 * RADII[0] + 1.1 * radius  # a little room to be moved about
    width, high = across * cell + 1.01 * radius, layers * cell + 1.01 * radius
    box = (0.0, width, 0.0, width, 0.0, high)
    heap = packing.grid(outlines, kinds, box, 1.01 * radius, jitter=1.0, seed=SEED)
    # walls keep nodes a contact radius away, their cells half of that; count what is between
    end = heap.area / FILLED / (width - radius) ** 2 + radius  # height of the lid
    return scene.Scene(
        title=f"{count} irregular grains dropped and crushed",
        grains=[
            scene.Grain(grain.cloud, grain.material, velocity=(0.0, 0.0, -FALL))
            for grain in scene.grains_of(heap, clouds, solid(spacing))
        ],
        contact=Contact(radius=radius, stiff=1.0, restitution=0.5, friction=0.4),
        walls=scene.box_walls((0.0, 0.0, 0.0), (width, width, high), lid_velocity=-SPEED),
        gravity=(0.0, 0.0, -10.0),
        duration=(high - end) / SPEED,
        frames=60,
        records=400,
        attributes=("fragment",),
        energies=True,
    )


def course(folder: Path) -> dict[str, np.ndarray]:
    """Records of the run: time, part of the room that is filled, pressures (Pa) on lid, floor and
    sides, mean damage.
    """
    output, record = results.Output(folder), results.averages(folder / scene.WALLS)
    walls = {wall.name: wall.point for wall in output.walls(0.0)}
    width = walls["right"][0] - walls["left"][0]
    height = walls["lid"][2] - record["v_lid_travel"]
    gap = output.contact_radius  # as in make_scene
    sides = record["f_right[1]"] - record["f_left[1]"] + record["f_back[2]"] - record["f_front[2]"]
    frames = range(len(output.dump))
    damage = [output.mean_damage(i) for i in frames]
    return {
        "time": record["v_now"],
        "filled": output.volumes.sum() / ((width - gap) ** 2 * (height - gap)),
        "lid": record["f_lid[3]"] / width**2,
        "floor": -record["f_floor[3]"] / width**2,
        "sides": sides / (4.0 * width * height),
        "damage": np.interp(record["v_now"], [output.time(i) for i in frames], damage),
    }


def measure(folder: Path) -> dict[str, float]:
    """Pressures, damage, pieces, overlaps and energies."""
    output, run_ = results.Output(folder), course(folder)
    last, late = len(output.dump) - 1, slice(-8, None)  # the last 2 % of the run
    grain = output.frame(0)["mol"].astype(int) - 1
    damage = output.field("damage", last)
    of_grain = np.bincount(grain, damage) / np.bincount(grain)
    pieces, books = results.fragments(output, last), output.thermo
    work = books["c_books[6]"][-1]
    return {
        "grains": len(of_grain),
        "nodes": len(grain),
        "filled": float(run_["filled"][-1]),
        "lid": float(run_["lid"][late].mean()),
        "floor": float(run_["floor"][late].mean()),
        "sides": float(run_["sides"][late].mean()),
        "landing": float(run_["floor"][run_["lid"] == 0.0].max()),
        "landed": float(
            np.interp(0.98 * run_["time"][run_["lid"] > 0.0][0], run_["time"], run_["damage"])
        ),
        "damage": float(damage.mean()),
        "broken": int((of_grain > 0.5).sum()),
        "intact": int((of_grain == 0.0).sum()),
        "pieces": len(pieces),
        "dust": float(pieces.volume[pieces.nodes < 5].sum() / pieces.volume.sum()),
        "overlap": float(results.contacts(output, last).overlap.max() / output.contact_radius),
        "work": float(work),
        "kinetic": float(books["c_books[7]"][-1] / books["c_books[1]"][-1]),
        "friction": float(books["c_books[4]"][-1] / work),
        "damping": float(books["c_books[5]"][-1] / work),
        "breaking": float(books["c_books[3]"][-1] / work),
        "drift": float(abs(books["c_books[8]"]).max() / work),
    }


def table(found: dict[str, float]) -> str:
    """What was measured, as text."""
    return f"""\
grains, nodes                      {found["grains"]}, {found["nodes"]}
floor, highest while grains land   {1e-3 * found["landing"]:.1f} kPa
mean damage before the lid arrives {found["landed"]:.4f}
at the end, {found["filled"]:.0%} of the room filled
  pressure on the lid              {1e-3 * found["lid"]:.0f} kPa
  on the floor, on the sides       {1e-3 * found["floor"]:.0f} kPa, {1e-3 * found["sides"]:.0f} kPa
  mean damage                      {found["damage"]:.3f}
  grains more than half broken     {found["broken"]}; without a broken bond {found["intact"]}
  pieces                           {found["pieces"]}; in those of 1 to 4 nodes {found["dust"]:.1%}
  deepest overlap                  {found["overlap"]:.0%} of the contact radius
  kinetic over strain energy       {found["kinetic"]:.3f}
work of the lid                    {1e3 * found["work"]:.2f} mJ
  lost to friction, to damping     {found["friction"]:.0%}, {found["damping"]:.0%}
  gone with broken bonds           {found["breaking"]:.0%}
  drift of the account             {found["drift"]:.1e}"""


def plot(folder: Path, path: Path) -> None:
    """Pressures and damage against how much of the room is filled."""
    from matplotlib.figure import Figure

    found = course(folder)
    figure = Figure(figsize=(7.0, 4.2), dpi=110, layout="constrained")
    axes = figure.subplots()
    touched = found["lid"].cumsum() > 0.0
    for name, colour in (("lid", "#1f4e79"), ("floor", "#7aa5cf"), ("sides", "#9a9a9a")):
        smooth = np.convolve(found[name], np.full(5, 0.2), "same")[:-2]
        axes.plot(
            found["filled"][touched][:-2], 1e-3 * smooth[touched[:-2]], color=colour, label=name
        )
    axes.set_xlabel("part of the room that grains fill")
    axes.set_ylabel("pressure (kPa)")
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
    beside = axes.twinx()
    beside.plot(found["filled"][touched], found["damage"][touched], color="#b3261e", ls="--")
    beside.set_ylabel("mean damage (dashed)", color="#b3261e")
    beside.set_ylim(0.0, None)
    figure.savefig(path)


def main(arguments: list[str] | None = None) -> int:
    """Make, run, measure and draw."""
    options = program.options(__doc__, "out/aggregate", small="fewer, coarser grains: seconds")
    chosen = options.parse_args(arguments)
    folder: Path = chosen.output
    [report] = program.run(make_scene(chosen.small).write(folder), chosen)
    print(table(measure(folder)))
    plot(folder, folder / "pressure.png")
    last = len(results.Dump(folder / scene.DUMP)) - 1
    shown = [0, last // 2, 5 * last // 6, last]
    render.grains_png(folder, folder / "grains.png", shown)
    print(f"{report.steps} steps in {report.wall_time:.0f} s; pictures are in {folder}/")
    return 0


if __name__ == "__main__":
    sys.exit(main())
