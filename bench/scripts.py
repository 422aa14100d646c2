"""Input scripts of the benchmarks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from peridem import cloud, shapes
from peridem.cloud import Cloud

H = 1e-3  # spacing of the nodes in blocks
BULK, SHEAR, DENSITY = 14.9e9, 14.9e9, 2200.0
HORIZON = 3.015 * H
SKIN = 0.3 * H

RADIUS, GAP = 1e-3, 2e-4  # of grains, and the spacing of their nodes
GRAIN_HORIZON = 3.0 * GAP


def block(
    style: str, side: int, steps: int, dimension: int = 3, horizon: float = HORIZON / H
) -> str:
    """A cubic (square) block of side^d nodes that vibrates, in ``peridem/*`` or ``peri/*``.

    Args:
        style: of the pair.
        side: nodes along an edge.
        steps: of the run.
        dimension: 2 or 3.
        horizon: over the spacing of the nodes.
    """
    reach = horizon * H
    ours = style.startswith("peridem")
    depth = f"0 {side - 0.5}" if dimension == 3 else "-0.1 0.1"
    coefficients = {
        "peridem/lps": f"bulk {BULK} shear {SHEAR} s0 0.1 horizon {reach} influence inverse",
        "peridem/pmb": f"bulk {BULK} s0 0.1 horizon {reach} influence constant",
        "peri/lps": f"{BULK} {SHEAR} {reach} 0.1 0.0",
        # the micro-modulus of Silling and Askari 2005
        "peri/pmb": f"{18 * BULK / (np.pi * reach**4)} {reach} 0.1 0.0",
    }[style.split()[0]]
    return f"""
units si
dimension {dimension}
boundary s s {"s" if dimension == 3 else "p"}
atom_style {"peridem" if ours else "peri"}
atom_modify map array
lattice {"sc" if dimension == 3 else "sq"} {H}
region b block 0 {side - 0.5} 0 {side - 0.5} {depth}
create_box 1 b
create_atoms 1 box
{"set group all mol 1" if ours else ""}
set group all volume {H**dimension}
set group all density {DENSITY}
neighbor {SKIN} bin
pair_style {style}
pair_coeff * * {coefficients}
velocity all create {1e10 if dimension == 3 else 1e16} 1234
{"fix flat all enforce2d" if dimension == 2 else ""}
fix motion all nve
timestep 1e-7
thermo {steps}
run {steps}
"""


def two_shapes() -> list[Cloud]:
    """A disc and a hexagon of about a hundred nodes."""
    return [cloud.mesh(shape(RADIUS), GAP) for shape in (shapes.circle, shapes.hexagon)]


def packed_grains(count: int, folder: Path, clouds: list[Cloud] | None = None) -> Path:
    """A data file of grains in rows, each a little turned and scaled, just in contact.

    Args:
        count: of grains.
        folder: for the file.
        clouds: of the grains in turn; default: discs and hexagons.
    """
    clouds = two_shapes() if clouds is None else clouds
    columns = max(2, round(np.sqrt(count)))
    reach = 0.95 * min(one.spacing for one in clouds)
    pitch = 2 * RADIUS + 0.99 * reach
    rng = np.random.default_rng(5)
    rows, lines = [], []
    for number in range(count):
        one = clouds[number % len(clouds)]
        row, column = divmod(number, columns)
        place = pitch * np.array([column + 0.5 * (row % 2), np.sqrt(0.75) * row])
        angle = rng.uniform(0.0, 2.0 * np.pi) if one.name == "circle" else 0.0
        placed = one.placed(place, angle)
        rows.append(placed.nodes)
        kind = clouds.index(one) + 1
        lines += [
            f"{number + 1} {kind} {volume:.17g} 1200 {x:.17g} {y:.17g} 0"
            for volume, (x, y) in zip(placed.volumes, placed.nodes, strict=True)
        ]
    nodes = np.concatenate(rows)
    low, high = nodes.min(axis=0) - 5 * GAP, nodes.max(axis=0) + 5 * GAP
    header = f"""grains in rows, contact radius {reach:.17g}

{len(lines)} atoms
{len(clouds)} atom types
{low[0]:.17g} {high[0]:.17g} xlo xhi
{low[1]:.17g} {high[1]:.17g} ylo yhi
{-GAP} {GAP} zlo zhi

Atoms # peridem

"""
    folder.mkdir(parents=True, exist_ok=True)
    data = folder / f"grains_{count}.data"
    data.write_text(header + "\n".join(f"{k} {line}" for k, line in enumerate(lines, 1)) + "\n")
    return data


def _solid(engine: str) -> str:
    return "peridem/lps" + (f" engine {engine}" if engine != "auto" else "")


def free_grains(data: Path, engine: str, steps: int) -> str:
    """Grains that vibrate, without contact: the bonds alone."""
    return f"""
units si
dimension 2
boundary s s p
atom_style peridem
neighbor {0.3 * GAP} bin
read_data {data.resolve()}
pair_style {_solid(engine)}
pair_coeff * * bulk 21.6e6 poisson 0.25 gc 50 horizon {GRAIN_HORIZON}
velocity all create 1e16 1234
fix flat all enforce2d
fix motion all nve
timestep 1e-7
thermo {steps}
run {steps}
"""


def compression(
    data: Path, steps: int, engine: str = "auto", contact: str = "friction 0.3", extra: str = ""
) -> str:
    """Grains in a box under gravity, pressed by a lid: every part of a real scene."""
    text = data.read_text()
    bounds = {line.split()[2]: line.split()[:2] for line in text.splitlines()[4:7]}
    (left, right), (floor, lid) = bounds["xlo"], bounds["ylo"]
    radius = float(text.splitlines()[0].split()[-1])
    reach = 5 * GAP - 1.01 * radius
    return f"""
units si
dimension 2
boundary f f p
atom_style peridem
neighbor {0.3 * GAP} bin
read_data {data.resolve()}
pair_style hybrid/overlay {_solid(engine)} peridem/contact
pair_coeff * * peridem/lps bulk 21.6e6 poisson 0.25 gc 50 horizon {GRAIN_HORIZON}
pair_coeff * * peridem/contact radius {radius} {contact}
fix floor all peridem/wall plane 0 {float(floor) + reach} 0  0 1 0
fix left all peridem/wall plane {float(left) + reach} 0 0  1 0 0
fix right all peridem/wall plane {float(right) - reach} 0 0  -1 0 0
fix lid all peridem/wall plane 0 {float(lid) - reach} 0  0 -1 0  velocity 0 -0.2 0
fix weight all gravity 10 vector 0 -1 0
fix step all peridem/timestep
fix motion all nve
{extra}
thermo_style custom step time f_lid[2] pe ke
thermo {max(steps, 1)}
run {steps}
"""
