#!/usr/bin/env python3
"""Rock as a mosaic of crystals: the weaker the boundaries between them, the sooner it breaks there.

    python mosaic.py                  three discs, with strong, weak and very weak boundaries
    python mosaic.py --small          two coarse discs

The discs are pressed between two platens until they split. Everything goes to out/mosaic/, a folder
for each disc (another one with --output).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from peridem import cloud, program, results, scene, shapes
from peridem.material import Contact, Interface, Material
from scipy.spatial import cKDTree

MM = 1e-3
RADIUS = 20.0 * MM
YOUNG, POISSON, GC = 5.0e9, 0.25, 10.0  # about those of gypsum
CRYSTALS, APART = 70, 4.0 * MM  # how many in the square around the disc; their smallest distance
SPEED = 0.2  # m/s of each platen
WAY = 0.12 * MM  # of each platen
SEED = 7


def crystals() -> np.ndarray:
    """Middles of crystals, (n, 2): random, none nearer to another than a smallest distance."""
    random = np.random.default_rng(SEED)
    middles = np.empty((0, 2))
    while len(middles) < CRYSTALS:
        point = random.uniform(-RADIUS, RADIUS, 2)
        if not len(middles) or np.linalg.norm(middles - point, axis=1).min() > APART:
            middles = np.vstack([middles, point])
    return middles


def colours(disc: cloud.Cloud, crystal: np.ndarray, reach: float) -> np.ndarray:
    """A colour, from 0, for each crystal, such that no bond joins two of one colour.

    Bonds reach from crystal to crystal wherever two of their nodes are within the horizon.
    """
    near = cKDTree(disc.nodes).query_pairs(reach, output_type="ndarray")
    near = np.unique(np.sort(crystal[near], axis=1), axis=0)
    colour = np.full(crystal.max() + 1, -1)
    for k in range(len(colour)):
        others = np.concatenate([near[near[:, 0] == k, 1], near[near[:, 1] == k, 0]])
        taken = set(colour[others].tolist())
        colour[k] = next(c for c in range(len(colour)) if c not in taken)
    return colour


def make_scene(part: float, spacing: float) -> scene.Scene:
    """A disc whose boundaries have a part of the crystals' Gc, between two platens."""
    disc = cloud.mesh(shapes.circle(RADIUS), spacing, exact=True)
    crystal = cKDTree(crystals()).query(disc.nodes)[1]  # the nearest middle: Voronoi cells
    horizon = 3.05 * spacing
    colour = colours(disc, crystal, horizon)[crystal]
    kinds = [
        Material(
            name=f"crystal {k + 1}",
            bulk=YOUNG / (3.0 * (1.0 - 2.0 * POISSON)),
            poisson=POISSON,
            density=1200.0,
            horizon=horizon,
            gc=GC,
            viscosity=50.0,  # Pa s: waves between neighbouring nodes die within a few periods
        )
        for k in range(colour.max() + 1)
    ]
    weak = f"s0 {kinds[0].critical_stretch(2) * part**0.5:.6g}"  # s0 goes with the root of Gc
    radius = 0.95 * scene.surface_spacing(disc)
    reach = RADIUS + 1.001 * radius
    parts = tuple((colour == k, kinds[k]) for k in range(1, len(kinds)))
    return scene.Scene(
        title=f"Mosaic whose boundaries have {part:g} of the crystals' Gc",
        grains=[scene.Grain(disc, kinds[0], parts)],
        contact=Contact(radius=radius, stiff=2.0, friction=0.3),
        interfaces=[
            Interface((a.name, b.name), weak) for i, a in enumerate(kinds) for b in kinds[:i]
        ],
        walls=[
            scene.Wall("lower", (0.0, -reach), (0.0, 1.0), (0.0, SPEED)),
            scene.Wall("upper", (0.0, reach), (0.0, -1.0), (0.0, -SPEED)),
        ],
        duration=WAY / SPEED,
        margin=4.0 * MM,
        frames=40,
        records=500,
        attributes=("fragment",),
        energies=True,
    )


def course(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """How far the platens have come together, and the load (N/m), the mean of both."""
    record = results.averages(folder / scene.WALLS)
    load = 0.5 * (record["f_upper[2]"] - record["f_lower[2]"])
    smooth = np.convolve(load, np.full(5, 0.2), "valid")  # of 1 % of the run
    return 2.0 * record["v_upper_travel"][2:-2], smooth


def along_boundaries(output: results.Output, i: int) -> tuple[float, float]:
    """The part of the broken, and of all, sides of cells that join two crystals."""
    kind = output.frame(0)["type"][output.edges]
    between = kind[:, 0] != kind[:, 1]
    broken = output.broken_edges(i)
    return float(between[broken].mean()) if broken.any() else 0.0, float(between.mean())


def measure(folder: Path) -> dict[str, float]:
    """Largest load (N/m), where, which bonds broke, and how many pieces came of it."""
    way, load = course(folder)
    output = results.Output(folder)
    top = int(load.argmax())
    peak = int(
        np.argmin([abs(2.0 * SPEED * output.time(i) - way[top]) for i in range(len(output.dump))])
    )
    broken, every = along_boundaries(output, -1)
    return {
        "load": float(load[top]),
        "way": float(way[top]),
        "along": broken,
        "all": every,
        "damage_at_peak": output.mean_damage(peak),
        "damage": output.mean_damage(-1),
        "pieces": int((results.fragments(output, -1).nodes >= 10).sum()),
        "drift": float(abs(output.thermo["c_books[8]"]).max() / output.thermo["c_books[6]"][-1]),
    }


def table(parts: list[float], rows: list[dict[str, float]]) -> str:
    """What was measured, as text."""
    lines = [
        "Gc of boundaries  largest load  at a way of  damage  "
        " broken between crystals  pieces  drift"
    ]
    for part, row in zip(parts, rows, strict=True):
        lines.append(
            f"{part:10g}        {1e-3 * row['load']:6.1f} kN/m  {1e3 * row['way']:7.3f} mm   "
            f"{row['damage']:.3f}    {row['along']:4.0%} (of all {row['all']:.0%})       "
            f"{row['pieces']:3d}     {row['drift']:.1e}"
        )
    return "\n".join(lines)


def draw(folder: Path, parts: list[float], path: Path) -> None:
    """The discs in the colours of their crystals and of damage, and the loads."""
    from matplotlib.figure import Figure
    from peridem.render_2d import draw_frame
    from peridem.render_style import Style

    figure = Figure(figsize=(10.0, 4.3), dpi=110)
    wide, reach = 0.58 / len(parts), 1.1 * RADIUS
    for k, part in enumerate(parts):
        output = results.Output(folder / f"{part:g}")
        for low, style in ((0.47, Style("type", 0.0, 1.0)), (0.0, Style("damage", 0.0, 0.6))):
            axes = figure.add_axes((k * wide, low, 0.98 * wide, 0.46))
            axes.set_xlim(-reach, reach)
            axes.set_ylim(-reach, reach)
            axes.set_aspect("equal")
            axes.axis("off")
            draw_frame(axes, output, len(output.dump) - 1, style)
            if low:
                axes.set_title(f"boundaries: {part:g} Gc", fontsize=9)
    axes = figure.add_axes((0.66, 0.12, 0.32, 0.8))
    for part in parts:
        way, load = course(folder / f"{part:g}")
        axes.plot(1e3 * way, 1e-3 * load, label=f"boundaries: {part:g} Gc")
    axes.set_xlabel("platens come together by (mm)")
    axes.set_ylabel("load (kN per m of thickness)")
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(path)


def main(arguments: list[str] | None = None) -> int:
    """Make, run, measure and draw."""
    options = program.options(__doc__, "out/mosaic", small="two coarse discs: seconds")
    chosen = options.parse_args(arguments)
    folder: Path = chosen.output
    parts = [1.0, 0.05] if chosen.small else [1.0, 0.2, 0.05]
    spacing = RADIUS / (14.0 if chosen.small else 28.0)
    scripts = [make_scene(part, spacing).write(folder / f"{part:g}") for part in parts]
    program.run(scripts, chosen)
    print(table(parts, [measure(folder / f"{part:g}") for part in parts]))
    draw(folder, parts, folder / "discs.png")
    print(f"picture: {folder / 'discs.png'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
