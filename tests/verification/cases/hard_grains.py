"""Grains at the edge of what a peridynamic solid is: thin, tiny, uneven, nearly incompressible."""

from __future__ import annotations

import numpy as np

from support.clouds import Cloud, cloud, disc, lattice, ragged
from support.runs import Simulation

from .base import Case, Lab, Outcome, Row, below, is_so, near, shown
from .hard_common import (
    BROKEN,
    BULK,
    DRIFT,
    HORIZON,
    REACH,
    SHEAR,
    books,
    finite_row,
    limit,
    loaded,
    lps,
    momentum_row,
    refusal,
    total,
)

HALF = 0.5  # of the stable step


def at_half_the_step(lab: Lab, one: Cloud, words: str, dimension: int = 2) -> Simulation:
    sim = loaded(lab, one, words, dimension=dimension)
    sim.commands("run 0 post no")
    return sim.commands(f"timestep {HALF * limit(sim):.17g}\nrun 0 post no")


def ringing(one: Cloud, size: float, rng: np.random.Generator, dimension: int = 2) -> Cloud:
    """Random velocities without momentum."""
    one.v[:, :dimension] = size * rng.normal(size=(one.n, dimension))
    one.v -= (one.mass[:, None] * one.v).sum(axis=0) / one.mass.sum()
    return one


# --- thin ----------------------------------------------------------------------------------------


def thin(lab: Lab, length: int, periods: float) -> Outcome:
    """A free bar two nodes thick, bent; and the family that does not make it a solid."""
    rows: list[Row] = []
    for horizon in (1.5, 2.1, HORIZON):
        one = cloud(lattice((length, 2)), dimension=2, margin=60)
        shape = np.cos(4.73 * (one.x[:, 0] / length)) - 0.13  # about that of the first mode
        one.v[:, 1] = 0.02 * (shape - shape.mean())
        sim = at_half_the_step(lab, one, lps(horizon=horizon))
        start = total(sim)
        sim.commands(f"run {int(periods * 4 * length / HALF)} post no")
        name = f"horizon {horizon:g}"
        x = sim.atoms("x")
        rows += [
            below(
                f"{name}: change of energy / energy",
                abs(total(sim) / start - 1),
                0.02,
                why="velocity Verlet at half the stable step; the bent bar rings slowly",
            ),
            momentum_row(name, one, sim),
            near(
                f"{name}: length after / before",
                float(np.ptp(x[:, 0])) / (length - 1),
                1.0,
                abs=0.05,
                why="it bends, and stays a bar",
            ),
        ]
        lab.close()
    square = cloud(lattice((4, 4)), dimension=2)
    for horizon in (1.2, 1.5, 2.1):
        sheared = square.x.copy()
        sheared[:, 0] += 1e-3 * square.x[:, 1]
        sim = loaded(lab, square, lps(horizon=horizon)).commands("run 0 post no")
        energy = sim.at(sheared).thermo("pe") / (0.5 * SHEAR * 1e-6 * 16)
        rows.append(
            shown(
                f"horizon {horizon:g}: energy in shear / G γ²/2 V",
                energy,
                why=(
                    "nearest neighbours alone resist no shear: the horizon must reach the "
                    "diagonals, better two spacings"
                ),
            )
        )
        lab.close()
    return Outcome(rows)


# --- one bond ------------------------------------------------------------------------------------


def pair_frequency_sq(d: int, lame: float, shear: float) -> float:
    """(ω R)² of two nodes of unit volume and density: the weights cancel.

    Both bonds' states act, t = w e d (d λ' + 2 G) / m with m = w R² v V, and both masses.
    """
    return 2.0 * 2.0 * d * (d * lame + 2.0 * shear)


def one_bond(lab: Lab, steps: int) -> Outcome:
    rows = [row for d in (2, 3) for row in two_nodes(lab, d)]
    return Outcome(rows + pulled_off(lab, steps))


def two_nodes(lab: Lab, d: int) -> list[Row]:
    """They swing at the end of their bond."""
    one = cloud([[0.0, 0, 0], [1.0, 0, 0]], dimension=d, margin=30)
    one.v[:, 0] = (-1e-3, 1e-3)
    sim = loaded(lab, one, lps(horizon=1.5), dimension=d).commands("run 0 post no")
    expected = 2.0 / np.sqrt(pair_frequency_sq(d, BULK - 2 * SHEAR / 3, SHEAR))
    step = limit(sim)
    omega, dt = 2.0 / expected, 0.01 * expected
    sim.commands(f"timestep {dt:.17g}\nrun {round(0.5 * np.pi / omega / dt)} post no")
    stretch = sim.atoms("x")[1, 0] - sim.atoms("x")[0, 0] - 1.0
    lab.close()
    return [
        near(
            f"two nodes, {d}D: stable step",
            step,
            expected,
            rel=1e-6,
            why="2/ω, ω² = 4 d (d λ' + 2 G)/(ρ R²); the eigenvalue is found to 1e-7",
        ),
        near(
            f"two nodes, {d}D: amplitude",
            stretch,
            2e-3 / omega,
            rel=1e-4,
            why="v/ω after a quarter of a period; velocity Verlet at 0.01 of the stable step",
        ),
    ]


def pulled_off(lab: Lab, steps: int) -> list[Row]:
    """A node that hangs on a disc by one bond."""
    x = np.concatenate([disc(3.1), [[4.2, 0.0, 0.0]]])
    one = cloud(x, dimension=2, margin=60)
    one.v[-1] = (1.0, 0.5, 0.0)
    sim = loaded(lab, one, lps(horizon=1.3, more="s0 0.05"), f"radius {REACH}", "timestep 0.01")
    sim.commands("run 0 post no")
    bonds = sim.compute("node")[-1, 1]
    sim.commands(f"run {steps} post no")
    v = sim.atoms("v")[-1]
    sim.commands(f"run {steps} post no")
    return [
        near(
            "node that hangs on a disc by one bond: bonds before", bonds, 1, abs=0, why="as built"
        ),
        near(
            "... after it has been pulled off", sim.compute("node")[-1, 1], 0, abs=0, why="s > s0"
        ),
        below(
            "... change of its velocity from then on",
            np.abs(sim.atoms("v")[-1] - v).max(),
            0.0,
            why="a free node: no force at all",
        ),
        finite_row("... all numbers", sim, "no division by its bonds"),
        below(
            "... drift of the energy balance / energy of the broken bond",
            abs(books(sim)[DRIFT]) / books(sim)[BROKEN],
            0.1,
            why="a bond breaks between two steps: v dt / (s0 R) = 0.17 of its stretch is not known",
        ),
    ]


# --- uneven volumes ------------------------------------------------------------------------------


def volumes(lab: Lab, ratios: tuple[float, ...], side: int, steps: int) -> Outcome:
    rows: list[Row] = []
    for ratio in ratios:
        rng = np.random.default_rng(5)
        one = ragged(rng, (side, side), density=1.0)
        one.volume[:] = np.where(rng.random(one.n) < 0.5, 1.0, 1.0 / ratio)
        one.box[:2] *= 5
        ringing(one, 1e-4, rng)
        sim = at_half_the_step(lab, one, lps())
        start = total(sim)
        f = sim.at(one.reference + 0.01 * rng.uniform(-1, 1, one.x.shape) * (1, 1, 0)).atoms("f")
        sim.at(one.x, one.v)
        energies = []
        for _ in range(10):
            sim.commands(f"run {steps // 10} post no")
            energies.append(total(sim) / start - 1)
        name = f"1:{ratio:g}"
        rows += [
            below(
                f"{name}: sum of forces / sum of their sizes",
                np.abs(f.sum(axis=0)).max() / np.abs(f).sum(),
                1e-14,
                why="equal and opposite, bond by bond",
            ),
            momentum_row(name, one, sim),
            below(
                f"{name}: largest change of energy / energy",
                float(np.abs(energies).max()),
                0.15,
                why=(
                    "velocity Verlet at half the stable step: (ω dt)²/8 of the fastest modes, "
                    "bounded"
                ),
            ),
        ]
        lab.close()
    return Outcome(rows)


# --- Poisson's ratio and horizon -----------------------------------------------------------------


def materials(
    lab: Lab, ratios: tuple[float, ...], horizons: tuple[float, ...], radius: float, steps: int
) -> Outcome:
    rows = [row for nu in ratios for row in ratio_rows(lab, nu, horizons, radius, steps)]
    return Outcome(rows + refused_ratios(lab))


def ratio_rows(
    lab: Lab, nu: float, horizons: tuple[float, ...], radius: float, steps: int
) -> list[Row]:
    """A disc dilated, and ringing, for one ratio of Poisson."""
    small = 1e-3
    shear = 3 * BULK * (1 - 2 * nu) / (2 * (1 + nu))
    lame = BULK - 2 * shear / 3
    worst, drift, steps_c = 0.0, 0.0, []
    for m in horizons:
        one = cloud(disc(radius), dimension=2, margin=60)
        sim = at_half_the_step(lab, one, lps(BULK, shear, m + 0.015))
        steps_c.append(limit(sim) * np.sqrt(BULK + 4 * shear / 3))
        energy = sim.at(one.reference * (1 + small, 1 + small, 1)).thermo("pe")
        exact = 2 * (lame + shear) * small**2 * one.n
        worst = max(worst, abs(energy / exact - 1))
        one = ringing(one, 1e-4, np.random.default_rng(7))
        sim.at(one.x, one.v)
        start = total(sim)
        for _ in range(5):
            sim.commands(f"run {steps // 5} post no")
            drift = max(drift, abs(total(sim) / start - 1))
        lab.close()
    name = f"ν = {nu:g}, horizons {', '.join(f'{m:g}' for m in horizons)}"
    return [
        below(
            f"{name}: energy of a 0.1 % dilation against 2 (λ + G) ε² V",
            worst,
            1e-11,
            why="exact at every node, free surface or not: m and θ are sums over the same family",
        ),
        below(
            f"{name}: largest change of energy / energy",
            drift,
            0.15,
            why="velocity Verlet at half the stable step, random velocities: bounded by (ω dt)²/8 "
            "of the fastest modes",
        ),
        shown(
            f"{name}: stable step c/h",
            ", ".join(f"{value:.2f}" for value in steps_c),
            why="grows with the horizon",
        ),
    ]


def refused_ratios(lab: Lab) -> list[Row]:
    sim = lab.simulation().load(cloud(disc(3.1), dimension=2), dimension=2)
    rows = []
    for nu, fine in ((0.5, False), (-1.0, False), (0.6, False), (0.499, True)):
        said = refusal(
            sim,
            f"pair_style peridem/lps\npair_coeff * * bulk 30 poisson {nu} horizon 3 unbreakable",
        )
        good = ("must be > -1 and < 0.5" in said) != fine and (fine == (said == ""))
        rows.append(
            is_so(
                f"ν = {nu:g}",
                said.splitlines()[0][:90] if said else "accepted",
                good,
                "accepted" if fine else "refused",
                why="a solid must resist both shear and compression",
            )
        )
    return rows


# --- squeezed ------------------------------------------------------------------------------------


def squeezed(lab: Lab, side: int, parts: tuple[float, ...], speed: float) -> Outcome:
    rows: list[Row] = []
    for part in parts:
        one = cloud(lattice((side, side)), dimension=2, margin=60)
        low, high = one.x[:, 1].min() - 0.951, one.x[:, 1].max() + 0.951
        sim = loaded(
            lab,
            one,
            lps() + " viscosity 0.5",
            f"radius {REACH} friction 0.3",
            f"fix low all peridem/wall plane 0 {low} 0 0 1 0\n"
            f"fix high all peridem/wall plane 0 {high} 0 0 -1 0 velocity 0 -{speed} 0\n"
            "fix step all peridem/timestep",
        )
        sim.commands("run 0 post no")
        steps = round(part * (high - low) / speed / sim.thermo("dt"))
        sim.commands(f"run {steps} post no")
        x = sim.atoms("x")
        columns = np.round(one.x[:, 0] - one.x[:, 0].min()).astype(int)
        swapped = 0
        for k in range(side):
            mine = np.flatnonzero(columns == k)
            mine = mine[np.argsort(one.x[mine, 1])]
            swapped += int((np.diff(x[mine, 1]) < 0).sum())
        got, name = books(sim), f"to {100 * (1 - part):g} % of its height"
        warned = "compressed" in sim.printed()
        rows += [
            finite_row(f"{name}: all numbers", sim, "no blow-up"),
            below(
                f"{name}: drift / work of the walls",
                abs(got[DRIFT]) / got[5],
                0.02,
                why=(
                    "velocity Verlet at 0.8 of the stable step; rows snap through each other at "
                    "large strain"
                ),
            ),
            is_so(
                f"{name}: rows of nodes",
                (
                    f"{swapped} pairs of neighbours have changed places, "
                    f"{'with a' if warned else 'no'} warning"
                ),
                swapped == 0 or warned,
                "in order, or a warning",
                why="a bond has a finite force at zero length, and bonded nodes do not touch",
            ),
        ]
        lab.close()
    return Outcome(rows)


CASES = [
    Case(
        "hard-thin",
        "A grain two nodes thick",
        "A free bar of 2 x n nodes, bent and let go, and how its family resists shear.",
        "conservation",
        thin,
        small={"length": 12, "periods": 5.0},
        full={"length": 20, "periods": 50.0},
    ),
    Case(
        "hard-one-bond",
        "Two nodes, and one bond",
        "Two bonded nodes oscillate; a node that hangs on a disc by one bond is pulled off.",
        "the formula of the solid for one bond",
        one_bond,
        small={"steps": 400},
        full={"steps": 4000},
    ),
    Case(
        "hard-volumes",
        "Nodes of very different volume in one grain",
        "Half the nodes of a grain have a small part of the others' volume.",
        "conservation",
        volumes,
        small={"ratios": (30.0, 1e3), "side": 5, "steps": 2000},
        full={"ratios": (10.0, 1e3, 1e6), "side": 8, "steps": 20000},
    ),
    Case(
        "hard-materials",
        "Poisson's ratio from -0.3 to 0.49, horizons from 2 to 5 spacings",
        "A disc is dilated, and rings; the limits of Poisson's ratio are refused.",
        "W = 2 (λ + G) ε² per volume in plane strain",
        materials,
        small={
            "ratios": (-0.3, 0.0, 0.25, 0.45),
            "horizons": (2.0, 3.0, 4.0, 5.0),
            "radius": 5.1,
            "steps": 500,
        },
        full={
            "ratios": (-0.3, 0.0, 0.25, 0.45, 0.49),
            "horizons": (2.0, 3.0, 4.0, 5.0),
            "radius": 10.1,
            "steps": 10000,
        },
    ),
    Case(
        "hard-compression",
        "Compression beyond half the height",
        "An unbreakable block between two walls.",
        "conservation; rows of nodes in order",
        squeezed,
        small={"side": 6, "parts": (0.25, 0.55), "speed": 0.1},
        full={"side": 10, "parts": (0.2, 0.3, 0.5, 0.7), "speed": 0.02},
    ),
]
