"""Cracks: what they cost, where they run, how bodies fall to pieces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from support.clouds import Cloud, cloud, lattice
from support.oracle import Array
from support.runs import Simulation, number
from support.strip import SMALL, STEADY, Strip, run_fast, run_slowly

from .base import Case, Lab, Outcome, Row, above, below, is_so, near, shown, within
from .contact import FLAT, REACH, advance, disc, even_radius
from .statics import Statics

CRACKED = 0.35  # damage of a node beside a crack: it has lost one side, 3/8 to 1/2 of its bonds
MM, US = 1e-3, 1e-6


def commands(sim: Simulation, one: Cloud, text: str) -> Simulation:
    return sim.commands("neigh_modify every 1 delay 0 check yes\n" + text)


def cells(shape: tuple[int, ...], h: float) -> Array:
    """Middles of cells of a box whose corner is the origin, (n, 3)."""
    x = lattice(shape, h)
    return x - x.min(axis=0) + 0.5 * h * np.array([k < len(shape) for k in range(3)])


# --- what a crack costs -----------------------------------------------------------------------


def run_strip(lab: Lab, kinds: tuple[tuple[float, str], ...], loads: tuple[float, ...]) -> Outcome:
    rows: list[Row] = []
    curves = {}
    for horizon, words in kinds:
        strip = Strip(horizon=horizon, words=words, **SMALL)
        slow = run_slowly(lab.simulation(), strip)
        lab.close()
        name = f"δ = {horizon:g} h, {words}"
        curves[name] = (slow.tip, slow.spent)
        rows.append(
            near(
                f"slow crack, {name}: energy in broken bonds per length over Gc",
                slow.spent_per_length(*STEADY),
                1.0,
                abs=0.05,
                why="Gc as the lattice counts it, within 3 %; a crack that changes rows breaks "
                "some "
                "bonds of both, 2 %",
            )
        )
    for load in loads:
        fast = run_fast(lab.simulation(), Strip(**SMALL), load)
        lab.close()
        rows.append(
            within(
                f"load {load:g} Gc: energy in broken bonds per length over Gc",
                fast.spent_per_length(*STEADY),
                1.0,
                load,
                why="no less than Gc, no more than what is there",
            )
        )
        rows.append(
            within(
                f"load {load:g} Gc: speed of the crack over that of shear waves",
                fast.speed(*STEADY),
                0.05,
                0.918,
                why="below Rayleigh's, (0.862 + 1.14 ν)/(1 + ν) = 0.918 of it",
            )
        )
    return Outcome(rows, lambda: draw_strip(curves))


def draw_strip(curves):
    from support.strip import GC

    from .plots import panels

    figure, (ax,) = panels(1, width=5.0)
    for name, (tip, spent) in curves.items():
        ax.plot(tip, spent / GC, label=name)
    ax.plot([0, 70], [0, 70], "k:", label="Gc")
    ax.set(xlabel="length of the crack / h", ylabel="energy in broken bonds / Gc h")
    ax.legend()
    return figure


# --- Kalthoff and Winkler ---------------------------------------------------------------------


@dataclass(frozen=True)
class Cracked:
    """Reference positions, damage at the end, and the tip of the crack over time."""

    x: Array
    damage: Array
    time: Array
    tip: Array


def run_kalthoff(lab: Lab, sizes: tuple[float, ...], speed: float) -> Outcome:
    rows, last = [], None
    for h in sizes:
        last = impacted(lab, h * MM, speed)
        for side, name in ((1, "upper"), (-1, "lower")):
            angle, top = crack_angle(last, side)
            rows.append(
                within(
                    f"h = {h:g} mm: angle of the {name} crack with the notch",
                    angle,
                    60.0,
                    75.0,
                    why="about 70° in experiments (Kalthoff 2000), 63° to 70° in peridynamics "
                    "(Silling 2003); fitted through damaged nodes ahead of the notch",
                )
            )
        got = tip_speed(last)
        rows.append(
            below(
                f"h = {h:g} mm: speed of the tips over Rayleigh's",
                got / 2800.0,
                1.0,
                why="c_R is about 2800 m/s in this steel; slope of the tip's way along the crack",
            )
        )
        rows.append(
            shown(f"h = {h:g} mm: height that the cracks reach (mm)", top / MM, why="at 80 µs")
        )
        lower, upper = crack_angle(last, -1)[0], crack_angle(last, 1)[0]
        rows.append(
            near(
                f"h = {h:g} mm: difference of the two angles",
                upper - lower,
                0.0,
                abs=1.0,
                why="the plate is symmetric; rounding decides which of two equal bonds breaks "
                "first",
            )
        )
    return Outcome(rows, lambda: draw_plate(last, "angle 68°", kalthoff_line))


def impacted(lab: Lab, h: float, speed: float) -> Cracked:
    """Steel, 100 by 200 mm, two notches of 50 mm; the edge between them is driven."""
    x = cells((round(0.1 / h), round(0.2 / h)), h) - np.array([0.0, 0.1, 0.0])
    one = cloud(x, volume=h * h, density=8000.0, dimension=2, margin=20 * MM)
    sim = lab.simulation().load(one, dimension=2, units="si", skin=0.5 * h)
    commands(
        sim,
        one,
        f"""
        region edge block INF {number(h)} -25e-3 25e-3 INF INF units box
        group edge region edge
        fix glue all peridem/bonds cut segment 0 25e-3 50e-3 25e-3 cut segment 0 -25e-3 50e-3 -25e-3
        pair_style peridem/lps
        pair_coeff * * young 191e9 poisson 0.25 gc 42408 {number(h)} horizon {number(3.015 * h)}
        compute damage all peridem/atom damage
        fix push edge setforce 0 NULL NULL
        velocity edge set {number(speed)} NULL NULL
        fix motion all nve
        fix step all peridem/timestep safety 0.6 every 1000000
        """,
    )
    return watch(sim, x, 80 * US, 20, lambda x: x[:, 1])


def watch(sim: Simulation, x: Array, time: float, looks: int, along) -> Cracked:
    """Run and note how far damaged nodes reach along some direction."""
    way, tips = along(x), []
    sim.commands("run 0 post no\nunfix step")
    for _ in range(looks):
        advance(sim, time / looks)
        damage = sim.compute("damage")
        gone = damage > CRACKED
        tips.append((sim.thermo("time"), float(way[gone].max()) if gone.any() else np.nan))
    return Cracked(x, damage, *np.array(tips).T)


def crack_angle(found: Cracked, side: int) -> tuple[float, float]:
    """Angle with the x axis of the line through damaged nodes beyond a notch, and its height."""
    x = found.x * np.array([1, side, 1])
    part = (found.damage > CRACKED) & (x[:, 1] > 27 * MM) & (x[:, 0] > 45 * MM)
    slope = np.polyfit(x[part, 1], x[part, 0], 1)[0]
    return float(90 - np.degrees(np.arctan(slope))), float(x[part, 1].max())


def tip_speed(found: Cracked) -> float:
    """Along the crack, from its height: between the first and the last look that saw it grow."""
    grown = found.tip > 28 * MM
    grown &= found.tip < found.tip[-1]
    angle = np.radians(crack_angle(found, 1)[0])
    return float(np.polyfit(found.time[grown], found.tip[grown], 1)[0] / np.sin(angle))


def kalthoff_line(ax) -> None:
    for side in (1, -1):
        end = np.array([50 + 75 / np.tan(np.radians(68)), side * 100])
        ax.plot([50, end[0]], [side * 25, end[1]], "w:", lw=1)


def draw_plate(found: Cracked, label, lines):
    from .plots import cloud as dots
    from .plots import panels

    figure, (ax,) = panels(1, width=4.6, height=5.0)
    dots(ax, found.x, found.damage, "damage", unit=MM, cmap="inferno", vmin=0, vmax=0.7)
    lines(ax)
    ax.set(xlabel="x (mm)", ylabel="y (mm)", title=f"dotted: {label}")
    return figure


# --- branching --------------------------------------------------------------------------------

RAYLEIGH = (0.862 + 1.14 * 0.25) / 1.25 * np.sqrt(72e9 / 2.5 / 2440)


def run_branching(lab: Lab, h: float, stress: float) -> Outcome:
    found = pulled_glass(lab, h * MM, stress)
    x, gone = found.x, found.damage > CRACKED
    fork = first_fork(x, gone, h * MM)
    ends = branches(x, gone, 0.9 * x[gone, 0].max(), h * MM)
    mirrored = found.damage[mirror(x)]
    steady = (found.tip > 52 * MM) & (found.tip < 0.98 * np.nanmax(found.tip))
    speeds = np.diff(found.tip[steady]) / np.diff(found.time[steady])
    rows = [
        is_so(
            "branches near the tips",
            str(ends),
            ends >= 2,
            "2 or more",
            why="the load is above that for branching (Bobaru and Zhang 2015)",
        ),
        within(
            "where it forks: x (mm)",
            fork / MM,
            55.0,
            85.0,
            why="in the right half, some millimetres and more from the notch's tip at 50 mm",
        ),
        within(
            "largest speed of the tip over Rayleigh's, looks of 1 µs",
            float(speeds.max() / RAYLEIGH),
            0.4,
            1.0,
            why=f"cracks branch at half of it and more and stay below it; c_R = {RAYLEIGH:.0f} m/s",
        ),
        below(
            "nodes whose damage differs from that of their mirror image, part of all damaged ones",
            float(np.mean(np.abs(found.damage - mirrored)[gone] > 0.1)),
            0.2,
            why="the plate is symmetric but for rounding, which a fork makes grow",
        ),
    ]
    return Outcome(rows, lambda: draw_glass(found, fork))


def pulled_glass(lab: Lab, h: float, stress: float) -> Cracked:
    """Soda-lime glass, 100 by 40 mm, notch of 50 mm, constant traction on both long sides."""
    x = cells((round(0.1 / h), round(0.04 / h)), h) - np.array([0.0, 0.02, 0.0])
    one = cloud(x, volume=h * h, density=2440.0, dimension=2, margin=20 * MM)
    sim = lab.simulation().load(one, dimension=2, units="si", skin=0.5 * h)
    commands(
        sim,
        one,
        f"""
        region top block INF INF {number(0.02 - h)} INF INF INF units box
        region bottom block INF INF INF {number(h - 0.02)} INF INF units box
        group top region top
        group bottom region bottom
        group ends union top bottom
        fix glue all peridem/bonds cut segment -1e-3 0 50e-3 0 unbroken ends
        pair_style peridem/lps
        pair_coeff * * young 72e9 poisson 0.25 gc 3.8 {number(h)} horizon {number(4 * h)} &
            plane stress
        compute damage all peridem/atom damage
        fix up top addforce 0 {number(stress * h)} 0
        fix down bottom addforce 0 {number(-stress * h)} 0
        fix motion all nve
        fix step all peridem/timestep safety 0.6 every 1000000
        """,
    )
    return watch(sim, x, 43 * US, 43, lambda x: x[:, 0])


def mirror(x: Array) -> Array:
    """For each node the number of its mirror image in y."""
    keys = np.lexsort((np.round(x[:, 1], 9), np.round(x[:, 0], 9)))
    other = np.lexsort((np.round(-x[:, 1], 9), np.round(x[:, 0], 9)))
    image = np.empty(len(x), int)
    image[keys] = other
    return image


def branches(x: Array, gone: Array, at: float, h: float) -> int:
    """Cracks that cross the line x = ``at``: runs of damaged nodes, apart by more than 3 h."""
    here = gone & (np.abs(x[:, 0] - at) < 1.01 * h)
    y = np.sort(x[here, 1])
    return int(len(y) > 0) + int(np.sum(np.diff(y) > 3 * h))


def first_fork(x: Array, gone: Array, h: float) -> float:
    """Smallest x from which on at least two cracks are seen for 3 mm."""
    for at in np.arange(0.052, 0.1, h):
        if all(branches(x, gone, at + step, h) > 1 for step in (0, 1.5 * MM, 3 * MM)):
            return float(at)
    return float("nan")


def draw_glass(found: Cracked, fork):
    from .plots import cloud as dots
    from .plots import panels

    figure, axes = panels(2, width=5.4)
    dots(axes[0], found.x, found.damage, "damage", unit=MM, cmap="inferno", vmin=0, vmax=0.7, s=1)
    axes[0].set(xlabel="x (mm)", ylabel="y (mm)")
    axes[1].plot(found.time / US, found.tip / MM, "-", label="furthest damaged node")
    start = np.nanmin(found.time[found.tip > 52 * MM])
    line = start + np.array([0.0, 12 * US])
    axes[1].plot(line / US, 52 + (line - start) * RAYLEIGH / MM, "k:", label="Rayleigh")
    axes[1].axhline(fork / MM, color="0.5", lw=0.8, label="fork")
    axes[1].set(xlabel="time (µs)", ylabel="x (mm)")
    axes[1].legend()
    return figure


# --- a disc between plates --------------------------------------------------------------------


def run_brazilian(lab: Lab, radii: tuple[float, ...], half_angle: float) -> Outcome:
    """Stresses in the middle of an elastic disc that is pressed over two small arcs."""
    rows, last = [], None
    for radius in radii:
        r = even_radius(radius)
        one = disc(r)
        one.box[:2] += np.array([[-5.0, 5.0]])
        angle = np.arctan2(one.x[:, 0], np.abs(one.x[:, 1]))
        edge = (np.hypot(*one.x[:, :2].T) > r - 0.01) & (np.abs(angle) < half_angle)
        load = np.zeros_like(one.x)
        load[edge] = -one.x[edge] / r  # towards the middle, evenly along the arcs
        statics = Statics(lab, one, FLAT, 1.0, extra="compute node all peridem/atom sxx syy")
        u = statics.solve(load, np.zeros(one.n, bool), np.zeros_like(one.x), 1e-7)
        stress = statics.compute("node", u)
        lab.close()
        middle = np.hypot(*one.x[:, :2].T) < 0.1 * r
        got = np.average(stress[middle], axis=0, weights=one.volume[middle])
        half = edge & (one.x[:, 1] > 0)
        alpha = 0.5 * half.sum() / r  # each node carries the arc of a spacing
        pressure = 1.0  # a unit force per unit length
        tension = 2 * pressure / np.pi * (np.sin(2 * alpha) - alpha)
        squeeze = -2 * pressure / np.pi * (np.sin(2 * alpha) + alpha)
        last = (one.x, stress / tension, r)
        for name, value, expected in (
            ("across the load", got[0], tension),
            ("along it", got[1], squeeze),
        ):
            rows.append(
                near(
                    f"R = {r:.1f} h: stress {name} in the middle over that of a disc",
                    value / expected,
                    1.0,
                    abs=0.02 + 0.5 / radius,
                    why="mean over a tenth of the radius, where it changes by 2 %; surface "
                    "layers of δ/R",
                )
            )
    return Outcome(rows, lambda: draw_brazilian(last))


def draw_brazilian(last):
    from .plots import panels

    x, stress, r = last
    figure, axes = panels(2)
    for ax, axis, name in (
        (axes[0], 0, "across the load (y = 0)"),
        (axes[1], 1, "along it (x = 0)"),
    ):
        line = np.abs(x[:, 1 - axis]) < 0.75
        at = x[line, axis] / r
        order = np.argsort(at)
        for k, label in ((0, "σxx"), (1, "σyy")):
            ax.plot(at[order], stress[line, k][order], ".-", ms=3, lw=0.8, label=label)
        if axis == 0:
            fine = np.linspace(-0.95, 0.95, 200) ** 1
            ax.plot(fine, ((1 - fine**2) / (1 + fine**2)) ** 2, "k:", label="point loads")
            ax.plot(fine, 1 - 4 / (1 + fine**2) ** 2, "k:")
        ax.set(xlabel="x / R" if axis == 0 else "y / R", title=name, ylim=(-6, 2))
        ax.set_ylabel("stress / (2P/πD)")
    axes[0].legend()
    return figure


def run_splitting(lab: Lab, radius: float, stretch: float, speed: float) -> Outcome:
    """A disc between a floor and a lid that comes down slowly, until it has split."""
    r = even_radius(radius)
    one = disc(r)
    one.box[:2] += np.array([[-20.0, 20.0]])
    low, high = one.x[:, 1].min() - REACH, one.x[:, 1].max() + REACH
    sim = lab.simulation().load(one, dimension=2)
    commands(
        sim,
        one,
        f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps bulk {number(FLAT.bulk)} shear 1 horizon {FLAT.horizon} &
            s0 {stretch}
        pair_coeff * * peridem/contact radius {REACH} friction 0.3
        compute damage all peridem/atom damage
        compute part all peridem/atom fragment
        fix floor all peridem/wall plane 0 {number(low)} 0 0 1 0
        fix lid all peridem/wall plane 0 {number(high)} 0 0 -1 0 velocity 0 {-speed} 0
        fix motion all nve
        fix step all peridem/timestep safety 0.5 every 1000000
        run 0 post no
        unfix step
        compute books all peridem/energy
        thermo_style custom step c_books[*]
        """,
    )
    history, damage = [], None
    looks, after = 200, 0
    for _ in range(looks):
        advance(sim, 0.06 * 2 * r / speed / looks)
        force = 0.5 * (sim.fix_vector("lid", 2)[1] - sim.fix_vector("floor", 2)[1])
        damage = sim.compute("damage")
        history.append((speed * sim.thermo("time"), force, float(np.max(damage))))
        peak = max(f for _, f, _ in history)
        after += peak > 0.1 and force < 0.3 * peak
        if after > 30:
            break
    fragment = sim.compute("part")
    lab.close()
    return Outcome(*splitting_rows(one, r, stretch, np.array(history), damage, fragment))


def splitting_rows(one: Cloud, r, stretch, history: Array, damage: Array, fragment: Array):
    gone = damage > CRACKED
    inner = gone & (np.hypot(*one.x[:, :2].T) < 0.75 * r)
    _, which = np.unique(fragment, return_inverse=True)
    mass = np.sort(np.bincount(which, one.mass))[::-1] / one.mass.sum()
    peak = float(history[:, 1].max())
    spread = float(np.sqrt(np.mean(one.x[inner, 0] ** 2)) / r) if inner.any() else float("nan")
    reach = float(np.ptp(one.x[inner, 1]) / r) if inner.any() else 0.0
    strength = 2 * peak / (np.pi * 2 * r)
    # strain across the load in the middle: plane strain, sigma_c = -3 sigma_t
    strain = strength * (1 - 0.25**2 + 3 * 0.25 * 1.25) / 2.5
    rows: list[Row] = [
        below(
            "distance of damaged inner nodes from the loaded diameter, root mean square over R",
            spread,
            0.15,
            why="a disc splits along the loaded diameter; a crack and its branches are a few δ "
            "wide",
        ),
        above(
            "length of the damaged inner part along the load over R",
            reach,
            1.0,
            why="it goes through: 1.5 would be all that is looked at (inside 0.75 R)",
        ),
        shown(
            "masses of the largest fragments, part of the disc",
            ", ".join(f"{m:.2f}" for m in mass[:4]),
            expected="two of nearly 0.5",
            why="wedges break off under the plates, and single nodes from the sides of the crack",
        ),
        within(
            "strain across the load in the middle at the largest force, over s₀",
            strain / stretch,
            0.5,
            1.5,
            why="strength is no input: bonds break at s₀, all along the diameter alike but for "
            "the "
            "ends; (1 − ν² + 3ν(1+ν)) 2P/(πDE) there",
        ),
    ]
    draw = lambda: draw_splitting(one, r, history, damage)  # noqa: E731
    return rows, draw


def draw_splitting(one, r, history, damage):
    from .plots import cloud as dots
    from .plots import panels

    figure, axes = panels(2)
    dots(axes[0], one.x, damage, "damage", cmap="inferno", vmin=0, vmax=0.7, s=5)
    axes[0].set(xlabel="x / h (reference)", ylabel="y / h")
    axes[1].plot(history[:, 0] / (2 * r), history[:, 1])
    axes[1].set(xlabel="way of the lid / 2R", ylabel="force (G h)")
    return figure


# --- a cylinder that flies apart --------------------------------------------------------------


def expanding_cylinder(h: float) -> Cloud:
    """Nodes h mm apart, flying outwards fastest at half the height."""
    size, count = h * MM, round(50 / h)
    x = lattice((count, count, round(100 / h)), size)
    ring = np.hypot(x[:, 0], x[:, 1])
    x = x[(ring >= 20 * MM) & (ring <= 25 * MM)]
    one = cloud(x, volume=size**3, density=7800.0, margin=120 * MM)
    ring, along = np.hypot(x[:, 0], x[:, 1]), x[:, 2] / (50 * MM)
    outward = 200 - 50 * along**2
    one.v[:, :2] = outward[:, None] * x[:, :2] / ring[:, None]
    one.v[:, 2] = 100 * along
    return one


def run_cylinder(lab: Lab, h: float, time: float, stretch: float) -> Outcome:
    size, one = h * MM, expanding_cylinder(h)
    sim = lab.simulation().load(one, units="si", skin=0.5 * size)
    commands(
        sim,
        one,
        f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps bulk 130e9 shear 78e9 s0 {number(stretch)} &
            horizon {number(3.015 * size)}
        pair_coeff * * peridem/contact radius {number(0.9 * size)} form bulk 1
        compute damage all peridem/atom damage
        compute part all peridem/atom fragment
        compute books all peridem/energy
        fix motion all nve
        fix step all peridem/timestep safety 0.5 every 10
        variable now equal time
        fix stop all halt 1 v_now >= {number(time * US)} error continue
        thermo_style custom step time ke pe c_books[*]
        """,
    )
    sim.commands("run 0 post no")
    energy = sim.thermo("ke")
    sim.commands("run 100000 post no\nunfix stop\nrun 0 post no")
    _, which = np.unique(sim.compute("part"), return_inverse=True)
    sizes = np.sort(np.bincount(which))[::-1]
    rows = account_rows(one, sim, energy) + fragment_rows(sizes, one.n)
    broken = float(book_page(sim)[2] / energy)
    rows.append(
        shown(
            "energy in broken bonds over the kinetic energy at the start", broken, why="no target"
        )
    )
    moved, damage = sim.atoms("x"), sim.compute("damage")
    lab.close()
    note = (
        "The fragments mirror each other as the lattice does, with which everything starts "
        "alike; a cloud without symmetry would break elsewhere."
    )
    return Outcome(rows, lambda: draw_cylinder(moved, which, damage, sizes), [note])


def account_rows(one: Cloud, sim: Simulation, energy: float) -> list[Row]:
    change = one.mass @ sim.atoms("v") - one.mass @ one.v
    scale = one.mass @ np.linalg.norm(one.v, axis=1)
    return [
        below(
            "change of momentum over the sum of all |m v|",
            float(np.abs(change).max() / scale),
            1e-13,
            why="internal forces are equal and opposite; rounding",
        ),
        below(
            "drift of the energy books over the kinetic energy at the start",
            abs(float(book_page(sim)[7])) / energy,
            1e-3,
            why="second order in the step; breaking bonds at the middle of a step",
        ),
    ]


def fragment_rows(sizes: Array, n: int) -> list[Row]:
    """Of fragments with so many nodes, the largest first."""
    big = sizes[sizes >= 20]
    return [
        is_so(
            "fragments of 20 nodes and more",
            str(len(big)),
            len(big) > 4,
            "more than 4",
            why="it breaks all round; no published count was found for this case",
        ),
        shown("largest fragment, part of all nodes", float(sizes[0] / n), why="no target"),
        shown(
            "median fragment of 20 nodes and more, nodes", float(np.median(big)), why="no target"
        ),
        shown("nodes in fragments of fewer than 20", float(1 - big.sum() / n), why="part of all"),
    ]


def book_page(sim: Simulation) -> Array:
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR

    return np.array(sim.lmp.numpy.extract_compute("books", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR))


def draw_cylinder(x, which, damage, sizes):
    from .plots import panels

    figure, axes = panels(2, width=4.6, height=4.0)
    order = np.argsort(x[:, 1])[::-1]
    shuffled = np.random.default_rng(3).permutation(which.max() + 1)[which]
    front = order[x[order, 1] < 0]
    axes[0].scatter(
        x[front, 0] / MM,
        x[front, 2] / MM,
        c=shuffled[front],
        s=4,
        cmap="tab20",
        linewidths=0,
        rasterized=True,
    )
    axes[0].set_aspect("equal")
    axes[0].set(xlabel="x (mm)", ylabel="z (mm)", title="fragments, seen from the side")
    axes[1].step(np.sort(sizes)[::-1], np.arange(1, len(sizes) + 1), where="post")
    axes[1].set(
        xscale="log", yscale="log", xlabel="nodes", ylabel="fragments of that size or larger"
    )
    return figure


CASES = [
    Case(
        name="strip",
        title="What a crack costs",
        what="A notched strip between clamps: a crack that grows slowly in a wedge-like "
        "opening, and fast ones. G = 1, ν = 1/4, Gc = 10⁻⁴, h = 1.",
        source="Griffith: Gc per length; see the theory page.",
        run=run_strip,
        small={"kinds": ((3.015, "influence linear"),), "loads": ()},
        full={
            "kinds": (
                (3.015, "influence linear"),
                (4.0, "influence linear"),
                (4.0, "influence constant"),
            ),
            "loads": (1.2, 1.5),
        },
    ),
    Case(
        name="kalthoff",
        title="Kalthoff and Winkler's plate",
        what="Maraging steel (E = 191 GPa, ν = 1/4, ρ = 8000 kg/m³, Gc = 42408 J/m²), 100 × 200 "
        "mm, two notches of 50 mm; the edge between them moves at 16 m/s. "
        "Plane strain, δ = 3.015 h, 80 µs.",
        source="Kalthoff 2000, Int. J. Fracture 105:27; Silling 2003 (peridynamics); geometry "
        "and material as in CabanaPD's example.",
        run=run_kalthoff,
        small={"sizes": (2.5,), "speed": 16.0},
        full={"sizes": (1.0, 0.5), "speed": 16.0},
    ),
    Case(
        name="branching",
        title="A crack that branches",
        what="Soda-lime glass (E = 72 GPa, ν = 1/4, ρ = 2440 kg/m³, Gc = 3.8 J/m²), 100 × 40 "
        "mm, notch of 50 mm, 2 MPa on the long sides from the start. "
        "Plane stress, δ = 4 h, 43 µs.",
        source="Bobaru and Zhang 2015, Int. J. Fracture 196:59; c_R = (0.862 + 1.14 ν)/(1 + ν) "
        "c_T.",
        run=run_branching,
        small={"h": 0.8, "stress": 2e6},
        full={"h": 0.25, "stress": 2e6},
    ),
    Case(
        name="brazilian",
        title="Brazilian disc: stresses",
        what="An elastic gmsh disc pressed over two opposite small arcs; forces by LAMMPS, "
        "equilibrium by conjugate gradients. Plane strain, ν = 1/4.",
        source="Hondros 1959: 2p/π (sin 2α − α) and −2p/π (sin 2α + α) in the middle of a disc "
        "under the pressure p on two arcs of 2α; 2P/πD and −6P/πD for small α.",
        run=run_brazilian,
        small={"radii": (15.0,), "half_angle": 0.15},
        full={"radii": (15.0, 30.0, 60.0), "half_angle": 0.15},
    ),
    Case(
        name="splitting",
        title="A disc between plates splits",
        what="A gmsh disc between a floor and a lid that comes down slowly; bonds break at s₀. "
        "Plane strain, E = 2.5, ν = 1/4, ρ = 1, h = 1.",
        source="The disc splits along the loaded diameter, when the strain in its middle is "
        "near s₀.",
        run=run_splitting,
        small={"radius": 15.0, "stretch": 0.01, "speed": 0.004},
        full={"radius": 30.0, "stretch": 0.01, "speed": 0.002},
    ),
    Case(
        name="cylinder",
        title="A cylinder that flies apart",
        what="A hollow cylinder (radii 20 and 25 mm, 100 mm long, K = 130 GPa, G = 78 GPa, ρ = "
        "7800 kg/m³, bonds break at the stretch given), all of it moving "
        "outwards at "
        "200 − 50 z'² m/s and along at 100 z' m/s; z' from −1 to 1.",
        source="Momentum; the set-up of CabanaPD's fragmenting cylinder, for which no fragment "
        "count is published.",
        run=run_cylinder,
        small={"h": 2.5, "time": 60.0, "stretch": 0.005},
        full={"h": 1.25, "time": 150.0, "stretch": 0.02},
    ),
]
