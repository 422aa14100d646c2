"""The time step against its limit, a million steps, and things that have to come to rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from support.clouds import Cloud, cloud, disc, join, ragged
from support.runs import Simulation

from .base import Case, Lab, Outcome, Row, above, below, is_so, near, shown
from .hard_common import (
    CONTACT,
    DRIFT,
    KINETIC,
    REACH,
    STRAIN,
    books,
    limit,
    loaded,
    lps,
    refusal,
    total,
)
from .plots import panels

# --- at the limit --------------------------------------------------------------------------------


def clouds() -> dict[str, Cloud]:
    rng = np.random.default_rng(3)
    found = {
        "disc": cloud(disc(5.1), dimension=2),
        "jittered square": ragged(rng, (8, 8)),
        "jittered cube": ragged(rng, (5, 5, 5)),
    }
    for name, one in found.items():
        one.box *= 20 if name == "jittered cube" else np.array([[20], [20], [1]])
        one.v[:, : 3 if name == "jittered cube" else 2] = 1e-6 * rng.normal(
            size=(one.n, 3 if name == "jittered cube" else 2)
        )
    return found


def growth(lab: Lab, one: Cloud, dimension: int, part: float, steps: int) -> tuple[float, bool]:
    """Largest energy over the first, with ``part`` of the reported step; whether it warned."""
    sim = loaded(lab, one, lps(), dimension=dimension).commands("run 0 post no")
    sim.commands(f"timestep {part * limit(sim):.17g}")
    start, largest = total(sim), 0.0
    for _ in range(10):
        if refusal(sim, f"run {steps // 10} post no"):
            largest = np.inf
            break
        largest = max(largest, total(sim) / start)
    warned = "longer than the largest stable one" in sim.printed()
    lab.close()
    return largest, warned


def sharpness(lab: Lab, parts: tuple[float, ...], steps: int) -> Outcome:
    rows: list[Row] = []
    found: dict[str, list[float]] = {}
    for name, one in clouds().items():
        dimension = 3 if name == "jittered cube" else 2
        grown = [growth(lab, one, dimension, part, steps) for part in parts]
        found[name] = [value for value, _ in grown]
        for part, (value, warned) in zip(parts, grown, strict=True):
            what = f"{name}, {part:g} of the stable step"
            if part < 1:
                bound = 1.0 / (1.0 - part**2) + 1.0
                rows.append(
                    below(
                        f"{what}: largest energy / energy at the start",
                        value,
                        bound,
                        why=(
                            "what velocity Verlet conserves differs from the energy by 1/(1 - (ω "
                            "dt/2)²) at most"
                        ),
                    )
                )
            else:
                rows.append(
                    above(
                        f"{what}: largest energy / energy at the start",
                        value,
                        1e3,
                        why="the fastest mode grows by a factor in each step",
                    )
                )
            rows.append(
                is_so(
                    f"{what}: warning",
                    "yes" if warned else "no",
                    warned == (part > 1),
                    "yes" if part > 1 else "no",
                    why="the estimate is sharp to 1 %",
                )
            )

    def draw() -> Figure:
        figure, (ax,) = panels(1)
        for name, values in found.items():
            ax.semilogy(parts, np.minimum(values, 1e12), "o-", label=name)
        ax.set(xlabel="step / reported stable step", ylabel="largest energy / first (≤ 1e12 shown)")
        ax.legend()
        return figure

    return Outcome(rows, draw)


# --- a million steps -----------------------------------------------------------------------------


def spinning(lab: Lab) -> tuple[Cloud, Simulation]:
    """Nine nodes that spin and ring."""
    rng = np.random.default_rng(11)
    one = cloud(disc(1.5), dimension=2, margin=40)
    x = one.x.copy()
    x[:, :2] += 1e-2 * rng.normal(size=(one.n, 2))
    one.v[:, :2] = 1e-3 * rng.normal(size=(one.n, 2))
    one.v[:, :2] += 1e-2 * np.column_stack([-one.x[:, 1], one.x[:, 0]])
    one.v -= one.v.mean(axis=0)
    one = one.moved(x)
    sim = loaded(lab, one, lps(horizon=2.1)).commands("run 0 post no")
    return one, sim.commands(f"timestep {0.5 * limit(sim):.17g}\nrun 0 post no")


def long_run(lab: Lab, steps: int, pieces: int) -> Outcome:
    """The energy swings within a band that must not move."""
    one, sim = spinning(lab)
    start, spin = total(sim), np.cross(one.x, one.v).sum(axis=0)[2]
    band: list[tuple[float, float]] = []
    for _ in range(pieces):
        energies = []
        for _ in range(50):
            sim.commands(f"run {steps // pieces // 50} post no")
            energies.append(total(sim) / start)
        band.append((min(energies), max(energies)))
    table = np.array(band)
    half, means = len(table) // 2, table.mean(axis=1)
    rows = [
        near(
            f"middle of the energy's band, second half / first half of {steps} steps",
            means[half:].mean() / means[:half].mean(),
            1.0,
            abs=0.02,
            why="50 samples of each piece of a band that is 0.15 wide at half the stable step",
        ),
        near(
            "width of the band, second half / first half",
            np.ptp(table, axis=1)[half:].mean() / np.ptp(table, axis=1)[:half].mean(),
            1.0,
            abs=0.15,
            why="the same samples",
        ),
        below(
            "change of angular momentum / itself",
            abs(np.cross(sim.atoms("x"), sim.atoms("v")).sum(axis=0)[2] / spin - 1),
            1e-10,
            why=f"1e-16 in each of {steps} steps, by chance: its root times 1e-16, at most 1e-10",
        ),
        below(
            "speed of the centre / of a node",
            np.abs(sim.atoms("v").mean(axis=0)).max() / 1e-2,
            1e-10,
            why="as above",
        ),
    ]
    return Outcome(rows, lambda: draw_band(table, steps))


def draw_band(table: np.ndarray, steps: int) -> Figure:
    figure, (ax,) = panels(1)
    at = (np.arange(len(table)) + 0.5) * steps / len(table)
    ax.fill_between(at, table[:, 0], table[:, 1], alpha=0.4, label="least to largest")
    ax.plot(at, table.mean(axis=1), label="middle")
    ax.set(xlabel="step", ylabel="energy / energy at the start")
    ax.legend()
    return figure


# --- at rest -------------------------------------------------------------------------------------


def heap_of_discs(radius: float, columns: int, layers: int) -> Cloud:
    parts = []
    pitch = 2 * radius + 1.1
    for layer in range(layers):
        for column in range(columns):
            x = (column - 0.5 * (columns - 1)) * pitch + 0.3 * (layer % 2)
            place = np.array([x, radius + 1 + layer * pitch, 0])
            parts.append(cloud(disc(radius) + place, dimension=2, molecule=len(parts) + 1))
    return join(*parts, margin=60)


def box(lab: Lab, one: Cloud, contact: str, solid: str, extra: str = "") -> Simulation:
    """Grains in an open box under gravity."""
    wide = np.abs(one.x[:, 0]).max() + 1.3
    sim = lab.simulation().load(one, dimension=2)
    return sim.commands(
        f"""
        {extra}
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {solid}
        pair_coeff * * peridem/contact radius {REACH} {contact}
        fix low all peridem/wall plane 0 0 0 0 1 0
        fix left all peridem/wall plane {-wide} 0 0 1 0 0
        fix right all peridem/wall plane {wide} 0 0 -1 0 0
        fix weight all gravity 0.01 vector 0 -1 0
        fix motion all nve
        fix step all peridem/timestep
        compute books all peridem/energy
        compute node all peridem/atom damage bonds
        thermo_style custom step time pe ke c_books[1] c_books[8]
        thermo_modify norm no
        thermo 1000000
        """
    )


COLD = "what is lost is lost in contacts; it never grows again"
CREEP = (
    "friction without memory creeps, here at 2 Δt g = 5e-4 and more, so by a spacing or two in "
    "this time: now and then a node falls off another, by at most a spacing"
)
WARM = "friction alone does not slow normal motion: such dust stays warm, but does not heat up"
CUT_ALL = (
    "region everywhere block INF INF INF INF INF INF\n"
    "fix peridem_bonds all peridem/bonds cut region everywhere"
)


@dataclass(frozen=True)
class Settled:
    """What a heap of discs, or its dust, has come to under a law of contact.

    Energies are over weight times height at the start.
    """

    law: str
    dust: bool
    one: Cloud
    sim: Simulation
    fall: float  # weight times height at the start
    times: list[float]
    kinetic: list[float]
    whole: list[float]  # gravity's, strain, contact and kinetic energy

    @property
    def quiet(self) -> bool:
        """Something takes the energy: damping, or what rings inside the discs."""
        return "restitution" in self.law or "damping" in self.law or not self.dust

    @property
    def creeps(self) -> bool:
        return self.dust and "regularised" in self.law


def settled(lab: Lab, dust: bool, law: str, columns: int, layers: int, steps: int) -> Settled:
    one = heap_of_discs(2.1, columns, layers)
    fall = 0.01 * float((one.mass * one.x[:, 1]).sum())
    solid = lps(horizon=2.1) + ("" if dust else " viscosity 0.5")
    sim = box(lab, one, law, solid, CUT_ALL if dust else "")
    found = Settled(law, dust, one, sim, fall, [], [], [])
    for _ in range(20):
        sim.commands(f"run {steps // 20} post no")
        found.times.append(sim.thermo("time"))
        found.kinetic.append(books(sim)[KINETIC] / fall)
        height = 0.01 * float((one.mass * sim.atoms("x")[:, 1]).sum()) / fall
        stored = books(sim)[[STRAIN, CONTACT]].sum() / fall
        found.whole.append(height + found.kinetic[-1] + stored)
    return found


def energy_rows(heap: Settled) -> list[Row]:
    law, late = heap.law, heap.whole[len(heap.whole) // 2 :]
    rest, why = (1e-7, COLD) if heap.quiet else (1e-2, WARM)
    if heap.creeps:  # one node falls by a spacing
        rest, why = 0.01 * float(heap.one.mass.max()) / heap.fall, CREEP
    return [
        below(
            f"{law}: kinetic energy in the end / weight x height at the start",
            max(heap.kinetic[-3:]),
            rest,
            why=why,
        ),
        below(
            f"{law}: drift / weight x height at the start",
            abs(books(heap.sim)[DRIFT]) / heap.fall,
            0.05 if heap.dust else 0.01,
            why="contacts that open and close within few steps give a little more than they got",
        ),
        below(
            f"{law}: largest rise of gravity's, strain, contact and kinetic energy in the "
            "second half / weight x height at the start",
            max(np.diff(late)),
            1e-8 if heap.quiet else 1e-3,
            why=(
                "nothing gives energy to what has come to rest"
                if heap.quiet
                else "nodes that go on bouncing: contacts of few steps, see drift"
            ),
        ),
    ]


def place_rows(heap: Settled) -> list[Row]:
    law, one, sim = heap.law, heap.one, heap.sim
    x, top = sim.atoms("x"), one.x[:, 1].max() + 1
    inside = bool(np.isfinite(x).all() and x[:, 1].min() > 0 and x[:, 1].max() < top)
    rows = [
        is_so(
            f"{law}: nodes in the box",
            f"lowest at {x[:, 1].min():.2f}, highest at {x[:, 1].max():.2f}",
            inside,
            "above the floor, none thrown out",
            why="no NaN, no blow-up",
        ),
        near(
            f"{law}: damage",
            float(sim.compute("node")[:, 0].mean()),
            float(heap.dust),
            abs=0.0,
            why="all bonds cut" if heap.dust else "unbreakable",
        ),
    ]
    if heap.quiet:
        rows.append(carried_row(heap))
    contact = shown(
        f"{law}: energy of contact in the end / at the start's weight x height",
        books(sim)[CONTACT] / heap.fall,
        why="the heap's own weight",
    )
    return [*rows, contact]


def carried_row(heap: Settled) -> Row:
    walls = -sum(heap.sim.fix_vector(name, 2)[1] for name in ("low", "left", "right"))
    return near(
        f"{heap.law}: what floor and walls carry / weight",
        walls / (0.01 * heap.one.mass.sum()),
        1.0,
        abs=2 / heap.one.n if heap.creeps else 0.01,
        why=(
            "nodes that fall are not carried, here at most two at a time"
            if heap.creeps
            else "at rest: what moves still is 1e-7 of the energy, so 1e-3 of the fall's forces"
        ),
    )


def at_rest(
    lab: Lab, dust: bool, laws: tuple[str, ...], columns: int, layers: int, steps: int
) -> Outcome:
    rows: list[Row] = []
    curves: dict[str, tuple[list[float], list[float]]] = {}
    for law in laws:
        heap = settled(lab, dust, law, columns, layers, steps)
        curves[law] = (heap.times, heap.kinetic)
        rows += energy_rows(heap) + place_rows(heap)
        lab.close()

    def draw() -> Figure:
        figure, (ax,) = panels(1)
        for law, (times, kinetic) in curves.items():
            ax.semilogy(times, np.maximum(kinetic, 1e-32), label=law)
        ax.set(xlabel="time", ylabel="kinetic energy / (weight x height)")
        ax.legend(fontsize=6)
        return figure

    return Outcome(rows, draw)


LAWS = (
    "restitution 0.5 friction 0.5",
    "damping 1 friction 0.5",
    "friction 0.5",
    "restitution 0.5 friction 0.5 tangential regularised",
)

CASES = [
    Case(
        "hard-step",
        "The time step at its limit",
        (
            "Random small velocities in three grains, at parts of the step that compute "
            "peridem/dt reports."
        ),
        "velocity Verlet: stable below 2/ω",
        sharpness,
        small={"parts": (0.5, 0.9, 0.99, 1.01, 1.1), "steps": 2000},
        full={"parts": (0.5, 0.9, 0.95, 0.99, 0.995, 1.005, 1.01, 1.05, 1.1), "steps": 10000},
    ),
    Case(
        "hard-million",
        "A million steps",
        "A grain of nine nodes spins and rings at half the stable step.",
        "a symplectic integrator: energy within a fixed band, momenta kept",
        long_run,
        small={"steps": 50000, "pieces": 10},
        full={"steps": 1000000, "pieces": 20},
    ),
    Case(
        "hard-dust",
        "Dust at rest",
        "Discs whose bonds are all cut, under gravity in a box.",
        "rest: no energy appears",
        at_rest,
        small={"dust": True, "laws": LAWS[:3], "columns": 2, "layers": 2, "steps": 30000},
        full={"dust": True, "laws": LAWS, "columns": 3, "layers": 3, "steps": 80000},
    ),
    Case(
        "hard-heap",
        "A settled heap",
        "Discs fall into a box and come to rest.",
        "rest: kinetic energy decays to zero",
        at_rest,
        small={"dust": False, "laws": LAWS[:1], "columns": 2, "layers": 2, "steps": 30000},
        full={"dust": False, "laws": LAWS, "columns": 3, "layers": 3, "steps": 80000},
    ),
]
