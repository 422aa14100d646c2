"""Draws the pictures of the manual's page of shapes and packings.

    python doc/gallery.py [folder]

Writes shapes.png and packings.png into doc/, or the folder.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from peridem import cloud, packing, shapes
from peridem.cloud import Cloud, unique_faces

FILL, EDGE, BACK = "#c9dcec", "#33668f", "#d9812b"


def flat(axes: plt.Axes, made: Cloud) -> None:
    """A cloud in the plane: its cells, and its nodes with those of the surface in colour."""
    cells = PolyCollection(made.nodes[made.cells], facecolor=FILL, edgecolor=EDGE, linewidth=0.4)
    axes.add_collection(cells)
    for where, colour in ((made.surface, BACK), (~made.surface, EDGE)):
        axes.plot(*made.nodes[where].T, ".", color=colour, markersize=2.5)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_axis_off()


def hull(axes: plt.Axes, nodes: np.ndarray, cells: np.ndarray, colour: str = FILL) -> None:
    """The outer faces of a mesh in space, lit from one side."""
    faces, count = unique_faces(cells, 3)
    corners = nodes[faces[count == 1]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = np.sign(((corners.mean(axis=1) - nodes.mean(axis=0)) * normal).sum(axis=1))
    normal *= (outward / np.linalg.norm(normal, axis=1))[:, None]
    light = 0.65 + 0.35 * normal @ np.array([0.4, -0.5, 0.77])
    shade = np.outer(light, matplotlib.colors.to_rgb(colour)).clip(0.0, 1.0)
    axes.add_collection3d(
        Poly3DCollection(corners, facecolors=shade, edgecolors=EDGE, linewidths=0.2)
    )


def scaled_axes(axes: plt.Axes, low: np.ndarray, high: np.ndarray) -> None:
    """Equal scales on the three axes."""
    for set_limits, a, b in zip(
        (axes.set_xlim, axes.set_ylim, axes.set_zlim), low, high, strict=True
    ):
        set_limits(a, b)
    axes.set_box_aspect(high - low, zoom=1.05)
    axes.set_axis_off()


def draw_shapes(path: Path) -> None:
    """Every named shape as gmsh meshes it, and two lattices."""
    made = []
    for name in shapes.NAMED:
        shape = shapes.named(name, 1.0)
        spacing = {"annulus": 0.09}.get(name, 0.16 if shape.dimension == 2 else 0.22)
        made.append((name, cloud.mesh(shape, spacing)))
    made.insert(
        9, ("circle, lattice\nhexagonal", cloud.lattice(shapes.circle(1.0), 0.16, "hexagonal"))
    )
    made.append(("sphere, lattice fcc", cloud.lattice(shapes.sphere(1.0), 0.25, "fcc")))
    figure = plt.figure(figsize=(12.0, 7.6))
    for k, (name, one) in enumerate(made):
        space = one.dimension == 3
        axes = figure.add_subplot(3, 6, k + 1, projection="3d" if space else None)
        if space:
            hull(axes, one.nodes, one.cells)
            scaled_axes(axes, one.nodes.min(axis=0), one.nodes.max(axis=0))
        else:
            flat(axes, one)
        axes.set_title(f"{name}\n{len(one.nodes)} nodes", fontsize=9)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw_packings(path: Path) -> None:
    """What the functions of packing make of the same grains."""
    kinds = [shapes.named(name, 1.0) for name in ("circle", "star", "drum", "irregular", "ellipse")]
    sizes = packing.Sizes.uniform(0.6, 1.0)
    box = (0.0, 16.0, 0.0, 14.0)
    some = np.arange(30) % len(kinds)
    wall = shapes.annulus(7.5, 8.2, (2.0, 0.8))
    layers = [packing.Layer(7.0, fraction=0.3, shares=[1, 0, 0, 0, 0], sizes=sizes)]
    layers.append(packing.Layer(7.0, fraction=0.25, shares=[0, 1, 1, 0, 0], sizes=sizes))
    loose = packing.fill(kinds, 0.3, box, 0.2, sizes=sizes)
    periodic = packing.Container(np.zeros(2), np.array([16.0, 14.0]), (True, True))
    made = {
        "grid, jitter 1": packing.grid(kinds, some, box, 0.2, 1.0, sizes=sizes),
        "fill 0.3": loose,
        "layered": packing.layered(kinds, layers, box, 0.2),
        "deposited": packing.deposited(kinds, some, box, 0.2, sizes=sizes),
        "settled": packing.settled(loose, 0.2, friction=0.3),
        "fill, periodic": packing.fill(kinds, 0.3, periodic, 0.2, sizes=sizes),
        "fill, inside a drum": packing.fill(
            kinds, 0.3, packing.container_inside(wall), 0.2, sizes=sizes
        ),
    }
    figure = plt.figure(figsize=(12.0, 6.2))
    for k, (name, one) in enumerate(made.items()):
        axes = figure.add_subplot(2, 4, k + 1)
        draw_packing(axes, one)
        axes.set_title(f"{name}\n{len(one)} grains, {one.fraction:.0%}", fontsize=9)
    rocks = [shapes.irregular_solid(1.0, seed=s) for s in range(6)]
    loose = packing.fill(rocks, 0.12, (0, 6, 0, 6, 0, 9), 0.2, sizes=sizes)
    heap = packing.settled(loose, 0.2, friction=0.3)
    axes = figure.add_subplot(2, 4, 8, projection="3d")
    for i in range(len(heap)):
        grain = cloud.mesh(heap.outline(i), 0.4 * float(heap.scale[i]))
        hull(axes, grain.nodes, grain.cells, f"C{heap.kind[i]}")
    scaled_axes(axes, heap.container.low, np.array([6.0, 6.0, 6.0]))
    axes.set_title(f"settled in space\n{len(heap)} grains", fontsize=9)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw_packing(axes: plt.Axes, made: packing.Packing) -> None:
    """The outlines, with their images across periodic sides, in the box."""
    low, high = made.container.low, made.container.high
    for i in range(len(made)):
        for shift in made.container.shifts():
            ring = made.outline(i).boundary(0.1) + shift
            axes.fill(
                *ring.T, facecolor=f"C{made.kind[i]}", edgecolor="k", linewidth=0.4, alpha=0.7
            )
    inside = made.container.inside
    frame = (
        inside.boundary(0.1)
        if inside
        else np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    )
    axes.plot(*np.vstack([frame, frame[:1]]).T, color="k", linewidth=0.8)
    axes.set_xlim(low[0] - 0.3, high[0] + 0.3)
    axes.set_ylim(low[1] - 0.3, high[1] + 0.3)
    axes.set_aspect("equal")
    axes.set_axis_off()


def main() -> int:
    """Draw both."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent
    for name, draw in (("shapes", draw_shapes), ("packings", draw_packings)):
        draw(folder / f"{name}.png")
        print(f"written to {folder / f'{name}.png'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
