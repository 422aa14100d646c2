"""How much stiffer are rigid grains, and do softer contacts make up for it?

A grain that is rigid gives way at its contacts only.  For the same force at the same approach the
springs would have to be softer by some factor.  First a single grain between plates, of several
shapes: its force from a slow simulation, deformable, and that of the rigid grain, which is the sum
of its nodes' springs: their ratio is the factor f of a contact with a wall, beside what
``peridem.series`` computes.  Then a packing of fifteen grains pressed by a lid: deformable, rigid,
and rigid with springs softer by the factors of ``peridem.series``.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from peridem import cloud, series, shapes
from peridem.cloud import Cloud
from peridem.material import Material
from peridem.results_tables import averages

from bench import timing
from bench.adapt_scenes import RADIUS, REACH, SPACING, heap
from bench.machine import Machine
from bench.table import COURSE, Row

Array = NDArray[np.float64]
TITLE = "Rigid grains: contact stiffness in series"
BULK, ALPHA = 21.6e6, 4.0
SPRING = ALPHA * BULK  # of two nodes, N/m per m of thickness
STRAINS = (1e-3, 3e-3, 1e-2)
# they lie on a side: turned otherwise they roll away
GRAINS: tuple[Callable[[float], shapes.Outline], ...]
GRAINS = (shapes.circle, shapes.hexagon, shapes.drum)
SOLID = Material(
    bulk=BULK, poisson=0.25, density=1200.0, horizon=3.05 * SPACING, viscosity=8.0, name="grain"
)
PLATES = 0.08  # m/s: the largest strain takes ten periods of a grain
LID, PRESS, PARTS = 0.1, 3e-3, 20
CONTACT = f"radius {REACH:g} modulus {BULK:g} restitution 0.7 friction 0.3 form bulk"


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
pair_coeff * * peridem/lps {SOLID.pair_coeff(2)}
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


def single_grains(lmp: Path, quick: bool) -> list[Row]:
    """Forces of deformable over rigid grains, at several strains."""
    rows: list[Row] = []
    for make in GRAINS[:1] if quick else GRAINS:
        one = cloud.mesh(make(RADIUS), SPACING)
        with tempfile.TemporaryDirectory() as folder:
            approach, force = deformable(lmp, one, Path(folder))
        at = 2 * RADIUS * np.array(STRAINS)
        ratio = np.interp(at, approach, force) / rigid(one, at)
        words = {f"f at strain {e:g}": float(r) for e, r in zip(STRAINS, ratio, strict=True)}
        computed = series.pressed_factor(one, SOLID, (0.0, 1.0), ALPHA, STRAINS[1])
        rows.append({"grains": f"one {make.__name__}", **words, "f computed": computed})
    return rows


def _pressed(text: str, motion: str, wall: float, pair: float, duration: float) -> str:
    text = text.replace("{perturb}", "").replace("{motion}", motion)
    text = text.replace("form bulk 4", f"form bulk {ALPHA * pair:.4g}")
    lines = [
        f"{line} {CONTACT} {ALPHA * wall:.4g}" if "peridem/wall" in line else line
        for line in text.splitlines()
    ]
    text = "\n".join(lines)
    return f"""{text}
variable now equal time
fix record all ave/time 20 1 20 v_now f_lid[2] file lid.dat
fix over all halt 20 v_now > {duration} error continue message no
thermo_modify lost error
run 10000000
"""


def pressed(lmp: Path, quick: bool) -> list[Row]:
    """The force on a lid that sinks on fifteen grains, in twenty parts of its way."""
    clouds = [cloud.mesh(make(RADIUS), SPACING) for make in GRAINS]
    soft = series.factors(clouds, SOLID, ALPHA)
    duration = 0.1 * PRESS if quick else PRESS
    ways = {
        "deformable": ("nve", 1.0, 1.0),
        "rigid": ("peridem/adapt eta 1e9", 1.0, 1.0),
        f"rigid, springs times {soft.wall:.2g} at walls, {soft.pair:.2g} between grains": (
            "peridem/adapt eta 1e9",
            soft.wall,
            soft.pair,
        ),
    }
    rows: list[Row] = []
    edges, whole = np.linspace(0.0, duration, PARTS + 1), np.zeros(PARTS)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        fall = 1e-3 if quick else 40e-3
        text = heap(folder, 15, 4, LID, duration, 300.0, settled_by=lmp, fall=fall)
        for name, (motion, *factors) in ways.items():
            timed = timing.run(lmp, _pressed(text, motion, *factors, duration), folder)
            data = averages(folder / "lid.dat")
            which = np.clip(np.digitize(data["v_now"], edges) - 1, 0, PARTS - 1)
            count = np.maximum(np.bincount(which, minlength=PARTS), 1)
            force = np.bincount(which, data["f_lid[2]"], minlength=PARTS) / count
            whole = force if motion == "nve" else whole
            difference = np.sqrt(np.sum((force - whole) ** 2) / max(np.sum(whole**2), 1e-300))
            rows.append(
                {
                    "grains": f"fifteen, {name}",
                    "force at the end, N/m": float(force[-1]),
                    "difference": float(difference),
                    "s": timed.seconds,
                    f"{COURSE}the force": " ".join(f"{one:.4g}" for one in force),
                }
            )
    return rows


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """Rows of single grains, then of the packing."""
    return single_grains(lmp, quick) + pressed(lmp, quick)


def comment(rows: list[Row], machine: Machine) -> str:
    """What the columns mean."""
    return f"""\
f is the force of the deformable grain between plates over that of the rigid one with the same
springs (`form bulk {ALPHA:g}`), so the factor by which springs of a rigid grain at a wall have to
be softer, from slow simulations; computed: by `peridem.series` (between two rigid grains it is
f / (2 - f)). The packing is settled, then pressed by a lid
at {LID:g} m/s over {1e3 * LID * PRESS:g} mm; the difference is that of the force on the lid, root
mean square over its way."""


def plot(rows: list[Row], file: Path) -> None:
    """The force on the lid over its way."""
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots(figsize=(6.0, 3.6))
    for row in rows:
        if f"{COURSE}the force" not in row:
            continue
        force = np.array(str(row[f"{COURSE}the force"]).split(), dtype=float)
        moved = (np.arange(len(force)) + 0.5) / len(force) * LID * PRESS
        ax.plot(1e6 * moved, force, label=str(row["grains"]).removeprefix("fifteen, "))
    ax.set(xlabel="way of the lid, um", ylabel="force on the lid, N/m")
    low, high = ax.get_ylim()
    soft = float(str(rows[-1]["force at the end, N/m"]))
    ax.set_ylim(min(low, 0.0), min(high, 6.0 * max(soft, 1e-9)))
    ax.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(file, dpi=150)
    plt.close(figure)
