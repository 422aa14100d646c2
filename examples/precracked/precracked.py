#!/usr/bin/env python3
"""Discs with a crack in their middle, pressed between two platens until they split.

    python precracked.py                  six discs: no crack, two lengths, four directions
    python precracked.py --small          two coarse discs: no crack, and a crack along the load

Everything goes to out/precracked/, a folder for each disc (another one with --output).
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from peridem import cloud, program, results, scene, shapes
from peridem.loads import Cut
from peridem.material import Contact, Material

MM = 1e-3
RADIUS = 20.0 * MM
YOUNG, POISSON, GC = 5.0e9, 0.25, 10.0  # about those of gypsum
SPEED = 0.2  # m/s of each platen
WAY = 0.14 * MM  # of each platen


@dataclass(frozen=True)
class Crack:
    """A straight crack through the middle of a disc.

    Attributes:
        half: of its length, over the radius of the disc; 0: no crack.
        angle: to the load, degrees.
    """

    half: float
    angle: float = 0.0

    @property
    def name(self) -> str:
        """Of its folder."""
        return f"{self.half:g}_at_{self.angle:g}" if self.half else "no_crack"

    @property
    def title(self) -> str:
        """Above its picture."""
        return f"a = {self.half:g} R, {self.angle:g}°" if self.half else "no crack"

    def load(self) -> float:
        """Load per thickness at which a crack along the load grows, N/m; nan for all others.

        K_I = N P sqrt(a / (pi R^2)) with the N of Shetty, Rosenfield and Duckworth (1985), and
        K_I^2 (1 - nu^2) = E Gc.
        """
        a = self.half
        if not a or self.angle:
            return math.nan
        n = 0.991 + 0.141 * a + 0.863 * a**2 + 0.886 * a**3
        toughness = math.sqrt(GC * YOUNG / (1.0 - POISSON**2))
        return toughness * math.sqrt(math.pi * RADIUS / a) / n


def solid(spacing: float) -> Material:
    """A brittle solid for nodes so far apart."""
    bulk = YOUNG / (3.0 * (1.0 - 2.0 * POISSON))
    return Material(
        name="gypsum",
        bulk=bulk,
        poisson=POISSON,
        density=1200.0,
        horizon=3.05 * spacing,
        gc=GC,
        viscosity=50.0,  # Pa s: waves between neighbouring nodes die within a few periods
    )


def make_scene(crack: Crack, spacing: float, restitution: float = 1.0) -> scene.Scene:
    """One disc between two platens that approach each other."""
    disc = cloud.mesh(shapes.circle(RADIUS), spacing, exact=True)
    contact = Contact(
        radius=0.95 * scene.surface_spacing(disc),
        stiff=2.0,
        friction=0.3,
        restitution=restitution,
    )
    reach = RADIUS + 1.001 * contact.radius
    turn = math.radians(crack.angle)
    end = crack.half * RADIUS * np.array([math.sin(turn), math.cos(turn)])
    return scene.Scene(
        title=f"Disc with a crack: {crack.title}",
        grains=[scene.Grain(disc, solid(spacing))],
        contact=contact,
        walls=[
            scene.Wall("lower", (0.0, -reach), (0.0, 1.0), (0.0, SPEED)),
            scene.Wall("upper", (0.0, reach), (0.0, -1.0), (0.0, -SPEED)),
        ],
        cuts=[Cut.segment(-end, end)] if crack.half else [],
        duration=WAY / SPEED,
        margin=4.0 * MM,
        frames=40,
        records=500,
        energies=True,
    )


def course(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """How far the platens have come together, and the load (N/m), the mean of both."""
    record = results.averages(folder / scene.WALLS)
    load = 0.5 * (record["f_upper[2]"] - record["f_lower[2]"])
    smooth = np.convolve(load, np.full(5, 0.2), "valid")  # of 1 % of the run
    return 2.0 * record["v_upper_travel"][2:-2], smooth


def measure(folder: Path, crack: Crack) -> dict[str, float]:
    """Largest load (N/m), where, what the formula says, and what became of the disc."""
    way, load = course(folder)
    top = int(load.argmax())
    output = results.Output(folder)
    before = output.mean_damage(0)
    return {
        "load": float(load[top]),
        "way": float(way[top]),
        "formula": crack.load(),
        "damage": float(output.mean_damage(-1) - before),
        "pieces": int((results.fragments(output, -1).volume > 0.02 * output.volumes.sum()).sum()),
        "drift": float(abs(output.thermo["c_books[8]"]).max() / output.thermo["c_books[6]"][-1]),
    }


def table(cracks: list[Crack], rows: list[dict[str, float]]) -> str:
    """What was measured, as text."""
    lines = ["disc             largest load  formula   at a way of  pieces  drift"]
    for crack, row in zip(cracks, rows, strict=True):
        formula = f"{1e-3 * row['formula']:4.1f} kN/m" if row["formula"] > 0.0 else "    --   "
        lines.append(
            f"{crack.title:16} {1e-3 * row['load']:6.1f} kN/m  {formula}  "
            f"{1e3 * row['way']:5.3f} mm    {row['pieces']:3d}   {row['drift']:7.1e}"
        )
    return "\n".join(lines)


def draw(folder: Path, cracks: list[Crack], path: Path) -> None:
    """The discs at the end, and their loads."""
    from matplotlib.figure import Figure
    from peridem.render_2d import draw_frame
    from peridem.render_style import Style

    columns = max(3, len(cracks))
    figure = Figure(figsize=(2.1 * columns, 5.6), dpi=110)
    wide, reach = 1.0 / columns, 1.1 * RADIUS
    for k, crack in enumerate(cracks):
        output = results.Output(folder / crack.name)
        axes = figure.add_axes((k * wide, 0.62, 0.98 * wide, 0.33))
        axes.set_xlim(-reach, reach)
        axes.set_ylim(-reach, reach)
        axes.set_aspect("equal")
        axes.axis("off")
        axes.set_title(crack.title, fontsize=9)
        draw_frame(axes, output, len(output.dump) - 1, Style("damage", 0.0, 0.6))
    axes = figure.add_axes((0.09, 0.1, 0.88, 0.47))
    for crack in cracks:
        way, load = course(folder / crack.name)
        axes.plot(1e3 * way, 1e-3 * load, label=crack.title)
    axes.set_xlabel("platens come together by (mm)")
    axes.set_ylabel("load (kN per m of thickness)")
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(path)


def main(arguments: list[str] | None = None) -> int:
    """Make, run, measure and draw."""
    options = program.options(__doc__, "out/precracked", small="two coarse discs: seconds")
    options.add_argument(
        "--restitution", type=float, default=1.0, help="of discs and platens (1: see the README)"
    )
    chosen = options.parse_args(arguments)
    folder: Path = chosen.output
    cracks = [Crack(0.0), Crack(0.5)]
    if not chosen.small:
        cracks[1:] = [Crack(0.3), Crack(0.5), Crack(0.5, 20.0), Crack(0.5, 45.0), Crack(0.5, 90.0)]
    spacing = RADIUS / (14.0 if chosen.small else 28.0)
    scenes = [make_scene(crack, spacing, chosen.restitution) for crack in cracks]
    program.run([s.write(folder / c.name) for s, c in zip(scenes, cracks, strict=True)], chosen)
    print(table(cracks, [measure(folder / crack.name, crack) for crack in cracks]))
    draw(folder, cracks, folder / "discs.png")
    print(f"picture: {folder / 'discs.png'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
