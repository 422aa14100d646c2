"""A small scene that the tests of scenes, runs and pictures share."""

from __future__ import annotations

import numpy as np
from peridem import cloud, packing, scene, shapes
from peridem.material import Contact, Material

SPACING = 2e-4
SOLID = Material(
    bulk=21.6e6, poisson=0.25, density=1200.0, horizon=3 * SPACING, gc=3.0, viscosity=4.0
)


def two_grains(**changes):
    """A hexagon above a disc between a floor and a sinking lid; nothing touches at the start."""
    outlines = [shapes.circle(8e-4), shapes.hexagon(8e-4)]
    rows = [(0, 1e-3, 1.01e-3, 1.0, 0.0), (1, 1.1e-3, 2.85e-3, 1.0, 0.4)]
    placed = packing.table(outlines, rows, SPACING)
    clouds = [cloud.mesh(outline, SPACING) for outline in outlines]
    words = {
        "title": "A hexagon on a disc",
        "grains": scene.grains_of(placed, clouds, SOLID),
        "contact": Contact(stiff=2.0, friction=0.3),
        "walls": scene.box_walls((0.0, 0.0), (2e-3, 3.9e-3), lid_velocity=-2.0),
        "gravity": (0.0, -10.0),
        "duration": 1e-4,
        "frames": 4,
        "records": 20,
        "timestep": 2.5e-7,  # constant, so that steps tell the time
    }
    return scene.Scene(**(words | changes))


def write_dump(path, frames, columns, extra=""):
    """A text dump of (step, rows) frames, as LAMMPS writes it."""
    with path.open("w") as file:
        for step, rows in frames:
            rows = np.asarray(rows)
            file.write(f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(rows)}\n")
            file.write("ITEM: BOX BOUNDS ff ff pp\n0 1\n0 2\n-0.5 0.5\n")
            file.write(f"ITEM: ATOMS {columns}\n")
            for row in rows:
                file.write(" ".join(f"{value:.12g}" for value in row) + "\n")
        file.write(extra)
