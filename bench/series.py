"""How much stiffer are rigid grains, and do softer contacts make up for it?

    python -m bench.series [--picture FILE]

A grain that is rigid gives way at its contacts only.  The contact spring would have to be softer by
a factor for the same force at the same approach.  First a single grain between plates, of several
shapes and turned by several angles: its force from a slow simulation, all deformable, and that of
the rigid grain, which is the sum of its nodes' springs.  Then a packing of fifteen grains pressed
by a lid: all deformable, rigid, and rigid with springs softer by the factor of the single grains.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from peridem import cloud, shapes
from peridem.cloud import Cloud
from peridem.results_tables import averages
from peridem.run import find_lmp

from bench import table, timing
from bench.adapt_scenes import RADIUS, REACH, SPACING, heap

Array = NDArray[np.float64]
BULK, ALPHA = 21.6e6, 4.0
SPRING = ALPHA * BULK  # of two nodes, N/m per m of thickness
STRAINS = (1e-3, 3e-3, 1e-2)
ANGLES = (0.0, 0.3, 0.7)
PLATES = 0.08  # m/s: the fastest strain takes ten periods of a grain
LID = 0.1
PRESS = 2e-3


def _single(one: Cloud, folder: Path) -> str:
    x, volume = one.nodes, one.volumes
    low, high = x.min(axis=0) - 4 * REACH, x.max(axis=0) + 4 * REACH
    rows = [
        f"{k} 1 1 {v:.17g} 1200 {a:.17g} {b:.17g} 0"
        for k, (v, (a, b)) in enumerate(zip(volume, x, strict=True), 1)
    ]
    bounds = f"{low[0]} {high[0]} xlo xhi\n{low[1]} {high[1]} ylo yhi\n{-SPACING} {SPACING} zlo zhi"
    text = f"one grain\n\n{len(x)} atoms\n1 atom types\n{bounds}\n\nAtoms # peridem\n\n"
    (folder / "one.data").write_text(text + "\n".join(rows) + "\n")
    bottom, top = x[:, 1].min() - REACH, x[:, 1].max() + REACH
    steps = STRAINS[-1] * 2 * RADIUS / PLATES
    return f"""
units si
dimension 2
boundary f f p
atom_style peridem
neighbor {0.3 * REACH} bin
read_data {folder / "one.data"}
pair_style hybrid/overlay peridem/lps peridem/contact
pair_coeff * * peridem/lps bulk {BULK} poisson 0.25 horizon {3.05 * SPACING} unbreakable viscosity 8
pair_coeff * * peridem/contact radius {REACH} modulus {BULK} form bulk {ALPHA}
fix floor all peridem/wall plane 0 {bottom} 0 0 1 0 velocity 0 {0.5 * PLATES} 0
fix lid all peridem/wall plane 0 {top} 0 0 -1 0 velocity 0 {-0.5 * PLATES} 0
fix motion all nve
fix step all peridem/timestep
variable now equal time
fix record all ave/time 10 1 10 v_now f_lid[2] f_floor[2] file one.dat
fix over all halt 10 v_now > {steps} error continue message no
run 10000000
"""


def deformable(lmp: Path, one: Cloud, folder: Path) -> tuple[Array, Array]:
    """Approach of the plates, m, and the force between them, N/m."""
    timing.run(lmp, _single(one, folder), folder)
    data = averages(folder / "one.dat")
    return PLATES * data["v_now"], 0.5 * (data["f_lid[2]"] - data["f_floor[2]"])


def rigid(one: Cloud, approach: Array) -> Array:
    """The force of the grain's nodes on plates that approach each other, if it keeps its shape.

    It moves up and down until both plates push alike.
    """
    y = np.sort(one.nodes[:, 1])
    low, high = y - y[0], y[-1] - y[::-1]

    def push(depth: Array, gaps: Array) -> Array:
        return SPRING * np.clip(depth[:, None] - gaps, 0.0, None).sum(axis=1)

    least, most = np.zeros_like(approach), approach.copy()
    for _ in range(60):
        middle = 0.5 * (least + most)
        more = push(middle, low) < push(approach - middle, high)
        least, most = np.where(more, middle, least), np.where(more, most, middle)
    return push(0.5 * (least + most), low)


def single_grains(lmp: Path) -> list[table.Row]:
    """Forces of rigid over deformable grains, at several strains."""
    rows: list[table.Row] = []
    makers: tuple[Callable[[float], shapes.Outline], ...]
    makers = (shapes.circle, shapes.hexagon, shapes.drum)
    for make in makers:
        for angle in ANGLES:
            one = cloud.mesh(make(RADIUS), SPACING).placed((0.0, 0.0), angle)
            with tempfile.TemporaryDirectory() as folder:
                approach, force = deformable(lmp, one, Path(folder))
            at = 2 * RADIUS * np.array(STRAINS)
            ratio = np.interp(at, approach, force) / rigid(one, at)
            words = {f"at strain {e:g}": float(r) for e, r in zip(STRAINS, ratio, strict=True)}
            rows.append({"shape": make.__name__, "turned by": angle, **words})
    return rows


def _pressed(text: str, motion: str, softer: float) -> str:
    text = text.replace("{perturb}", "").replace("form bulk 4", f"form bulk {ALPHA * softer:.4g}")
    return f"""{text.replace("{motion}", motion)}
variable now equal time
fix record all ave/time 20 1 20 v_now f_lid[2] file lid.dat
fix over all halt 20 v_now > {PRESS} error continue message no
thermo_modify lost error
run 10000000
"""


def packing(lmp: Path, factor: float) -> dict[str, tuple[Array, Array]]:
    """Displacement of the lid, m, and the force on it, N/m: averages over a twentieth of it."""
    ways = {
        "deformable": ("nve", 1.0),
        "rigid": ("peridem/adapt eta 1e9", 1.0),
        f"rigid, springs times {factor:.2g}": ("peridem/adapt eta 1e9", factor),
    }
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        text = heap(Path(folder), 15, 4, LID, PRESS, 300.0, settled_by=lmp)
        for name, (motion, softer) in ways.items():
            timing.run(lmp, _pressed(text, motion, softer), Path(folder))
            data = averages(Path(folder) / "lid.dat")
            edges = np.linspace(0.0, PRESS, 21)
            which = np.digitize(data["v_now"], edges) - 1
            force = np.array([data["f_lid[2]"][which == k].mean() for k in range(20)])
            found[name] = (LID * 0.5 * (edges[1:] + edges[:-1]), force)
    return found


def main() -> None:
    """Print the tables."""
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--picture", type=Path, help="force over displacement of the packing")
    picture = options.parse_args().picture
    lmp = find_lmp(None)
    rows = single_grains(lmp)
    print(table.markdown(rows), flush=True)
    factors = np.array([float(str(row[f"at strain {STRAINS[1]:g}"])) for row in rows])
    found = packing(lmp, float(np.median(factors)))
    whole = found["deformable"][1]
    compared: list[table.Row] = []
    for name, (moved, force) in found.items():
        forces = {f"{1e6 * moved[k]:.0f} um": float(force[k]) for k in (4, 9, 14, 19)}
        error = float(np.sqrt(np.mean((force - whole) ** 2) / np.mean(whole**2)))
        compared.append({"lid force, N/m": name, **forces, "difference": error})
    print(table.markdown(compared))
    if picture:
        _draw(found, picture)


def _draw(found: dict[str, tuple[Array, Array]], picture: Path) -> None:
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots(figsize=(4.5, 3.2))
    for name, (moved, force) in found.items():
        ax.plot(1e6 * moved, force, label=name)
    ax.set(xlabel="displacement of the lid, um", ylabel="force on the lid, N/m")
    ax.legend()
    figure.tight_layout()
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    main()
