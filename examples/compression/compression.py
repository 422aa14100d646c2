#!/usr/bin/env python3
"""Crushing grains in a box: 24 grains of four shapes and two sizes under a sinking lid.

    python compression.py                 makes the scene, runs it on 2 ranks, draws the results
    python compression.py --no-run        only makes out/demo/in.grains and what it reads
    python compression.py --speed 0.1     a slower lid

Everything goes to out/demo/ (another folder with --output).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from peridem import cloud, packing, program, render, results, scene, shapes
from peridem.material import Contact, Material

MM = 1e-3

SPACING = 0.14 * MM  # of the nodes, in grains of both sizes
RADII = (1.0 * MM, 0.7 * MM)
SHAPES = (shapes.circle, shapes.hexagon, shapes.triangle, shapes.drum)
COUNT = 24  # grains, three of each shape and size
WIDTH = 10.0 * MM  # of the box
SINK = 2.5 * MM  # way of the lid
SEED = 4
SHOWN = (0.0, 0.55, 0.8, 1.0)  # parts of the run that the pictures show


def make_scene(speed: float) -> scene.Scene:
    """The scene, its lid sinking at a speed in m/s."""
    solid = Material(
        name="grain",
        bulk=21.6e6,
        poisson=0.25,
        density=1200.0,
        horizon=3.05 * SPACING,  # above three, so that no bond ends just at the edge
        gc=3.0,  # N/m: bonds break at a stretch of 1.8 %
        viscosity=4.0,  # Pa s: ringing between neighbouring nodes dies within a few periods
    )
    contact = Contact(radius=0.95 * SPACING, stiff=2.0, restitution=0.8, friction=0.3)

    outlines = [shape(radius) for radius in RADII for shape in SHAPES]
    clouds = [cloud.mesh(outline, SPACING) for outline in outlines]
    kinds = np.random.default_rng(SEED).permutation(np.arange(COUNT) % len(outlines))
    tall = (0.0, WIDTH, 0.0, 4.0 * WIDTH)
    heap = packing.deposited(outlines, kinds, tall, 1.01 * SPACING, SEED)

    top = max(heap.outline(i).bounds[3] for i in range(len(heap))) + SPACING
    walls = scene.box_walls((0.0, 0.0), (WIDTH, top), lid_velocity=-speed)
    return scene.Scene(
        title=f"Crushing {COUNT} grains of four shapes and two sizes",
        grains=scene.grains_of(heap, clouds, solid),
        contact=contact,
        walls=walls,
        gravity=(0.0, -10.0),
        duration=SINK / speed,
    )


def main() -> int:
    """Make, run and draw."""
    options = program.options(__doc__, "out/demo")
    options.add_argument("--speed", type=float, default=0.3, help="of the lid, m/s (0.3)")
    chosen = options.parse_args()
    folder: Path = chosen.output

    [report] = program.run(make_scene(chosen.speed).write(folder), chosen)
    last = len(results.Dump(folder / scene.DUMP)) - 1
    shown = [round(part * last) for part in SHOWN]
    render.grains_png(folder, folder / "grains.png", shown)
    render.stress_png(folder, folder / "stress.png", frames=shown)
    render.pvd(folder, folder / "grains.pvd")
    print(
        f"""
{report.steps} steps in {report.wall_time:.0f} s. In {folder}/:
  in.grains, grains.data   the scene: read it, change it, run it again with peridem run {folder}
  grains.png               the grains at four times, coloured by damage
  stress.png               pressure on the lid against its penetration
  grains.pvd               the whole course for ParaView: open it, Apply, colour by 'damage'
  grains.dump              the same for OVITO (positions, damage c_node[1], ...)
  log.lammps, walls.dat    energies; forces on the walls
  grains.restart           the last state, for read_restart"""
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
