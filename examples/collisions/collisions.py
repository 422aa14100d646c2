#!/usr/bin/env python3
"""Two grains collide head-on: equal ones, of two sizes, of two materials, with and without loss.

    python collisions.py                  twelve collisions side by side, and what the law says
    python collisions.py --small          four of them, on coarser grains, in a shorter flight
    python collisions.py --speed 0.3      slower ones

Everything goes to out/collisions/ (another folder with --output).
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from peridem import cloud, program, render, results, scene, shapes
from peridem.material import Contact, Material

MM = 1e-3
RADIUS, LARGE = 1.0 * MM, 1.5 * MM
STIFF = Material(  # the solid of the published two-particle examples
    bulk=21.6e6, poisson=0.25, density=1200.0, horizon=0.6 * MM, gc=50.0, name="stiff"
)
SOFT = replace(STIFF, bulk=0.1 * STIFF.bulk, name="soft")
GAP = 0.05 * MM  # between the contact distances, at the start
WIDE, HIGH = 9.0 * MM, 4.0 * MM  # room of one collision


@dataclass(frozen=True)
class Pair:
    """One collision: the first grain flies at the second, which is at rest.

    Attributes:
        name: of the kind of pair.
        radii: of the two grains.
        solids: of the two grains.
        restitution: asked for.
    """

    name: str
    radii: tuple[float, float]
    solids: tuple[Material, Material]
    restitution: float

    def after(self, masses: np.ndarray, speed: float) -> np.ndarray:
        """Speeds of the two after the collision, by the law of restitution, (2,)."""
        one, two = masses / masses.sum()
        e = self.restitution
        return speed * np.array([one - e * two, one * (1.0 + e)])


def pairs(restitutions: tuple[float, ...]) -> list[Pair]:
    """All collisions, a row for each kind and a column for each restitution."""
    kinds = [
        ("equal", (RADIUS, RADIUS), (STIFF, STIFF)),
        ("two sizes", (RADIUS, LARGE), (STIFF, STIFF)),
        ("two materials", (RADIUS, RADIUS), (STIFF, SOFT)),
        ("sizes and materials", (RADIUS, LARGE), (STIFF, SOFT)),
    ]
    return [Pair(*kind, e) for kind in kinds for e in restitutions]


def make_scene(every: list[Pair], columns: int, speed: float, small: bool) -> scene.Scene:
    """Collisions in a grid, far apart. Each restitution has materials of its own that carry it."""
    spacing = (0.25 if small else 0.2) * MM
    meshes = {r: cloud.mesh(shapes.circle(r), spacing) for r in (RADIUS, LARGE)}
    radius = 0.95 * min(scene.surface_spacing(mesh) for mesh in meshes.values())
    contact = Contact(radius=radius)
    grains, laws = [], {}
    for k, pair in enumerate(every):
        left = np.array([k % columns * WIDE, -(k // columns) * HIGH])
        right = left + np.array([sum(pair.radii) + radius + GAP, 0.0])
        solids = [replace(s, name=f"{s.name} {pair.restitution:g}") for s in pair.solids]
        for place, size, solid, v in zip(
            (left, right), pair.radii, solids, (speed, 0.0), strict=True
        ):
            grains.append(scene.Grain(meshes[size].moved(place), solid, velocity=(v, 0.0)))
        law = replace(contact, restitution=pair.restitution)
        laws[solids[0].name, solids[1].name] = law
    return scene.Scene(
        title=f"{len(every)} head-on collisions at {speed:g} m/s",
        grains=grains,
        contact=contact,
        pairs=laws,
        duration=(0.4 if small else 1.4) * MM / speed,
        margin=4.0 * MM,
        energies=True,
    )


def velocities(output: results.Output, i: int) -> np.ndarray:
    """Velocities of the centres of mass at frame i, (pairs, 2 grains, 2)."""
    frame = output.frame(i)
    return results.per_grain(frame, frame.velocity[:, :2], output.volumes)[1].reshape(-1, 2, 2)


def measure(folder: Path, every: list[Pair], speed: float) -> list[dict[str, float]]:
    """For each pair what came out, and what the law of restitution says."""
    output = results.Output(folder)
    frame = output.frame(-1)
    grain = frame["mol"].astype(int) - 1
    density = STIFF.density
    mass = density * np.bincount(grain, output.volumes).reshape(-1, 2)
    kinetic = 0.5 * density * np.bincount(grain, output.volumes * (frame.velocity**2).sum(axis=1))
    end, rows = velocities(output, -1), []
    for k, pair in enumerate(every):
        wanted = pair.after(mass[k], speed)
        of_centres = 0.5 * (mass[k] * (end[k] ** 2).sum(axis=1)).sum()
        rows.append(
            {
                "asked": pair.restitution,
                "restitution": float(end[k, 1, 0] - end[k, 0, 0]) / speed,
                "v1": end[k, 0, 0],
                "v2": end[k, 1, 0],
                "law1": wanted[0],
                "law2": wanted[1],
                "momentum": float(mass[k] @ end[k, :, 0]) / (mass[k, 0] * speed) - 1.0,
                "ringing": 1.0 - of_centres / kinetic.reshape(-1, 2)[k].sum(),
                "damage": float(output.field("damage", -1)[grain // 2 == k].max()),
            }
        )
    return rows


def table(every: list[Pair], rows: list[dict[str, float]]) -> str:
    """What was measured, as text."""
    lines = ["pair                  asked  came out   v1 (law)          v2 (law)        momentum"]
    for pair, row in zip(every, rows, strict=True):
        lines.append(
            f"{pair.name:20}  {row['asked']:5.2f}  {row['restitution']:8.3f}   "
            f"{row['v1']:+.3f} ({row['law1']:+.3f})  {row['v2']:+.3f} ({row['law2']:+.3f})  "
            f"{row['momentum']:+.0e}"
        )
    return "\n".join(lines)


def plot(folder: Path, every: list[Pair], columns: int, speed: float, path: Path) -> None:
    """Velocities of the centres against time, and what the law says comes of them."""
    from matplotlib.figure import Figure

    output = results.Output(folder)
    course = np.array([velocities(output, i)[:, :, 0] for i in range(len(output.dump))])
    times = 1e3 * np.array([output.time(i) for i in range(len(output.dump))])
    grain = output.frame(0)["mol"].astype(int) - 1
    mass = np.bincount(grain, output.volumes).reshape(-1, 2)
    rows = len(every) // columns
    figure = Figure(figsize=(9.0, 1.9 * rows), dpi=110, layout="constrained")
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for k, (axes, pair) in enumerate(zip(grid.ravel(), every, strict=True)):
        for one, colour in ((0, "#1f4e79"), (1, "#b3261e")):
            axes.axhline(pair.after(mass[k], speed)[one], color=colour, ls=":", lw=1.0)
            axes.plot(times, course[:, k, one], color=colour, lw=1.6, label=f"grain {one + 1}")
        axes.set_title(f"{pair.name}, restitution {pair.restitution:g}", fontsize=9)
        axes.grid(alpha=0.3)
    grid[0, 0].legend(frameon=False, fontsize=8)
    grid[0, 0].set_xlim(0.0, 1e3 * min(0.4 * MM / speed, output.time(-1)))
    for axes in grid[-1]:
        axes.set_xlabel("time (ms)")
    for axes in grid[:, 0]:
        axes.set_ylabel("velocity (m/s)")
    figure.savefig(path)


def main(arguments: list[str] | None = None) -> int:
    """Make, run, measure and draw."""
    options = program.options(__doc__, "out/collisions", small="fewer, coarser, shorter: seconds")
    options.add_argument("--speed", type=float, default=1.0, help="of the first grain, m/s (1)")
    chosen = options.parse_args(arguments)
    folder: Path = chosen.output
    restitutions = (0.5,) if chosen.small else (1.0, 0.9, 0.5)
    every, columns = pairs(restitutions), len(restitutions)
    made = make_scene(every, columns, chosen.speed, chosen.small)
    [report] = program.run(made.write(folder), chosen)
    print(table(every, measure(folder, every, chosen.speed)))
    plot(folder, every, columns, chosen.speed, folder / "velocities.png")
    last = len(results.Dump(folder / scene.DUMP)) - 1
    shown = [last // 12, last]  # the first is during the collisions
    render.grains_png(folder, folder / "grains.png", shown, field="speed", bottom=0.0)
    print(f"{report.steps} steps in {report.wall_time:.0f} s; pictures are in {folder}/")
    return 0


if __name__ == "__main__":
    sys.exit(main())
