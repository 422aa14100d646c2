"""Contacts at the edge of what contacts can do: hard on soft, large on small, fast, "
"overlapping."""

from __future__ import annotations

import numpy as np

from support.clouds import cloud, disc, join
from support.runs import Simulation

from .base import Case, Lab, Outcome, Row, above, below, is_so, near, within
from .hard_common import (
    BROKEN,
    BULK,
    CONTACT,
    DRIFT,
    HORIZON,
    KINETIC,
    REACH,
    SHEAR,
    WAVE,
    books,
    finite_row,
    loaded,
    lps,
    momentum_row,
    run_for,
    two_discs,
)

STEP = "fix step all peridem/timestep"


def motion(sim: Simulation, molecule: int) -> tuple[float, float]:
    """Mean x and its speed for one grain; all nodes have one mass."""
    mine = sim.atoms("molecule") == molecule
    return float(sim.atoms("x")[mine, 0].mean()), float(sim.atoms("v")[mine, 0].mean())


def parting_speed(sim: Simulation) -> float:
    return motion(sim, 2)[1] - motion(sim, 1)[1]


# --- 1:1000 --------------------------------------------------------------------------------------


def stiffness(lab: Lab, ratio: float, radius: float, speed: float) -> Outcome:
    one = two_discs((radius, radius), speed)
    solids = (
        f"pair_coeff 1 1 peridem/lps {lps()}\n"
        f"pair_coeff 2 2 peridem/lps {lps(BULK / ratio, SHEAR / ratio)}"
    )
    sim = loaded(lab, one, solids, f"radius {REACH}", STEP)
    soft = WAVE / np.sqrt(ratio)
    rows, deepest = [], 0.0
    for _ in range(20):
        run_for(sim, 8 * radius / soft / 20)
        x, mol = sim.atoms("x"), sim.atoms("molecule")
        a, b = x[mol == 1], x[mol == 2]
        nearest = np.linalg.norm(a[:, None] - b[None], axis=2).min()
        deepest = max(deepest, 1 - nearest / REACH)
    energy = 0.25 * speed**2 * 0.5 * one.n
    rows += [
        momentum_row(f"1:{ratio:g}", one, sim),
        below(
            "drift of the energy balance / kinetic energy at the start",
            abs(books(sim)[DRIFT]) / energy,
            1e-3,
            why=(
                "velocity Verlet at 0.8 of the stable step: (ω dt)² of modes that hold little "
                "energy"
            ),
        ),
        below(
            "deepest overlap of nodes / R_c",
            deepest,
            0.3,
            why="the stiffer spring decides: no node slips in",
        ),
        above(
            "speed of parting / speed of approach",
            parting_speed(sim) / speed,
            0.3,
            why="the soft disc keeps part of the energy as vibration; it does not stick",
        ),
    ]
    return Outcome(rows)


# --- 1:30 ----------------------------------------------------------------------------------------


def sizes(lab: Lab, ratio: float, speed: float) -> Outcome:
    one = two_discs((ratio, 1.1), speed)
    sim = loaded(lab, one, lps(), f"radius {REACH}", STEP)
    run_for(sim, 20.0 / speed)
    energy = 0.5 * np.sum(one.mass[:, None] * one.v**2)
    rows = [
        momentum_row("one spacing", one, sim),
        below(
            "drift of the energy balance / kinetic energy at the start",
            abs(books(sim)[DRIFT]) / energy,
            5e-3,
            why=(
                "velocity Verlet at 0.8 of the stable step: waves of the node spacing, (ω dt)² "
                "of order 1"
            ),
        ),
        within(
            "speed of parting / speed of approach",
            parting_speed(sim) / speed,
            0.3,
            1.0,
            why="part of the blow stays as waves in both; it does not stick, and gains nothing",
        ),
    ]
    rows += [sieve(lab, 30.0, speed)]
    return Outcome(rows)


def sieve(lab: Lab, ratio: float, speed: float) -> Row:
    """Scaled copies of one mesh: the large grain's nodes are ``ratio / 6`` apart."""
    spacing = ratio / 6.0
    one = two_discs((ratio, 1.0), speed, (spacing, spacing / ratio), offset=0.5 * spacing)
    solids = (
        f"pair_coeff 1 1 peridem/lps {lps(horizon=HORIZON * spacing)}\n"
        f"pair_coeff 2 2 peridem/lps {lps(horizon=HORIZON * spacing / ratio)}"
    )
    sim = loaded(lab, one, solids, "radius auto", STEP)
    start = motion(sim, 2)[0]
    run_for(sim, 3 * spacing / speed)
    through = motion(sim, 2)[0] < start - spacing
    warned = "fit through between them" in sim.printed()
    got = ("passes" if through else "is stopped") + (", with a warning" if warned else ", silently")
    return is_so(
        "scaled copies: a small grain between two nodes of a large one",
        got,
        not through or warned,
        "stopped, or a warning",
        why=(
            "`radius auto` is 0.95 of the smaller spacing; gaps of the large grain are wider "
            "than the small one"
        ),
    )


# --- fast ----------------------------------------------------------------------------------------


def fast(lab: Lab, mach: tuple[float, ...], radius: float, safety: float) -> Outcome:
    rows: list[Row] = []
    for part in mach:
        for what, words in (("breaking", "s0 0.05"), ("unbreakable", "unbreakable")):
            speed = part * WAVE
            one = two_discs((radius, radius), speed)
            sim = loaded(lab, one, lps(more=words), f"radius {REACH}", f"{STEP} safety {safety}")
            run_for(sim, 8 * radius / speed)
            got = books(sim)
            name = f"{part:g} c, {what}"
            gap = motion(sim, 2)[0] - motion(sim, 1)[0]
            parting = parting_speed(sim)
            rows += [
                finite_row(f"{name}: positions, velocities, forces", sim, "no blow-up"),
                momentum_row(name, one, sim),
                below(
                    f"{name}: drift / kinetic energy at the start",
                    abs(got[DRIFT]) / (0.125 * speed**2 * one.n),
                    0.02 * safety / 0.8,
                    why=(
                        "strains of order 1 within few steps; a breaking bond is booked at the "
                        "step that finds it broken, so of first order in the step"
                    ),
                ),
                is_so(
                    f"{name}: they part",
                    (
                        f"centres {gap / (2 * radius):.2g} of the sum of radii apart, "
                        f"{parting / speed:.2g} of the speed"
                    ),
                    gap > 0 and parting > 0,
                    "on their own sides",
                    why="grains do not pass through each other",
                ),
            ]
            if words == "unbreakable":
                rows.append(below(f"{name}: broken energy", got[BROKEN], 0.0, why="nothing breaks"))
            else:
                rows.append(above(f"{name}: broken energy", got[BROKEN], 1e-3, why="they do break"))
            lab.close()
    return Outcome(rows)


# --- overlaps ------------------------------------------------------------------------------------


def overlaps(lab: Lab, depths: tuple[float, ...], radius: float, steps: int) -> Outcome:
    rows: list[Row] = []
    for depth in depths:
        one = two_discs((radius, radius), 0.0, distance=REACH * (1 - depth))
        sim = loaded(lab, one, lps(), f"radius {REACH}", f"{STEP} safety 0.1")
        sim.commands("run 0 post no")
        stored = books(sim)[CONTACT]
        sim.commands(f"run {steps} post no")
        got, name = books(sim), f"{depth:g} R_c"
        warned = "overlap at the start" in sim.printed()
        rows += [
            below(
                f"{name}: drift / energy of the overlap",
                abs(got[DRIFT]) / stored,
                0.005,
                why="velocity Verlet at 0.1 of the stable step, (ω dt)² / 8",
            ),
            below(
                f"{name}: kinetic energy / energy of the overlap",
                got[KINETIC] / stored,
                1.0,
                why="pushed off by what the overlap holds, no more",
            ),
            below(
                f"{name}: energy of contact left / at the start",
                got[CONTACT] / stored,
                1e-9,
                why="they have parted",
            ),
            is_so(
                f"{name}: warning",
                "yes" if warned else "no",
                warned == (depth > 0.01),
                "above 1 % of R_c",
                why="less is what packing codes leave",
            ),
        ]
        lab.close()
    rows += wall_overlap(lab, radius, 0.3)
    return Outcome(rows)


def wall_overlap(lab: Lab, radius: float, depth: float) -> list[Row]:
    """A disc whose lowest nodes are within the contact distance of a floor."""
    one = cloud(disc(radius), dimension=2, margin=400)
    floor = one.x[:, 1].min() - REACH * (1 - depth)
    wall = f"fix floor all peridem/wall plane 0 {floor} 0 0 1 0"
    sim = loaded(lab, one, lps(), f"radius {REACH}", f"{wall}\n{STEP} safety 0.1")
    sim.commands("run 0 post no")
    stored = books(sim)[CONTACT]
    run_for(sim, 20.0)
    got, name = books(sim), f"{depth:g} R_c with a wall"
    warned = "overlap the wall at the start" in sim.printed()
    return [
        below(
            f"{name}: drift / energy of the overlap",
            abs(got[DRIFT]) / stored,
            0.005,
            why="velocity Verlet at 0.1 of the stable step, (ω dt)² / 8",
        ),
        below(
            f"{name}: kinetic energy / energy of the overlap",
            got[KINETIC] / stored,
            1.0,
            why="pushed off by what the overlap holds, no more",
        ),
        is_so(
            f"{name}: warning",
            "yes" if warned else "no",
            warned,
            "yes",
            why="the usual mistake: a wall at the outline of the grain instead of R_c away",
        ),
    ]


# --- the same place ------------------------------------------------------------------------------


def same_place(lab: Lab, steps: int) -> Outcome:
    laws = (
        "",
        "friction 0.5",
        "damping 1 friction 0.5",
        "restitution 0.5",
        "friction 0.5 tangential regularised",
    )
    rows = [row for law in laws for row in two_free_nodes(lab, law, steps)]
    return Outcome(rows + two_bonded_nodes(lab, steps) + twin_grains(lab, steps))


def two_free_nodes(lab: Lab, law: str, steps: int) -> list[Row]:
    one = cloud([[0.0, 0.0], [0.0, 0.0]], molecule=[1, 2], dimension=2, margin=400)
    sim = lab.simulation().load(one, dimension=2)
    sim.commands(
        f"pair_style peridem/contact\npair_coeff * * radius 1 stiffness 4 {law}\n"
        f"fix motion all nve\ntimestep 0.05\nrun 0 post no"
    )
    stored, push = sim.thermo("pe"), sim.atoms("f")
    sim.commands(f"run {steps} post no")
    x, name = sim.atoms("x"), law or "spring"
    return [
        near(
            f"{name}: energy of two free nodes at one place", stored, 2.0, rel=1e-14, why="k R_c²/2"
        ),
        is_so(
            f"{name}: force",
            f"{push[0, 0]:g}, {push[1, 0]:g}",
            bool(push[0, 0] == -4 and push[1, 0] == 4),
            "-4, 4 along x",
            why="the lower ID to the left, so that all ranks choose alike",
        ),
        above(f"{name}: distance after", float(x[1, 0] - x[0, 0]), 1.0, why="pushed apart"),
    ]


def two_bonded_nodes(lab: Lab, steps: int) -> list[Row]:
    x = disc(3.1)
    moved = x.copy()
    moved[5] = moved[6]
    sim = loaded(lab, cloud(x, dimension=2).moved(moved), lps(), extra="timestep 0.05")
    sim.commands("run 0 post no")
    force, start = sim.atoms("f"), sim.thermo("pe")
    rows = [
        finite_row(
            "two bonded nodes at one place: forces",
            sim,
            "a bond without direction pulls nowhere",
        ),
        below(
            "... sum of forces / largest",
            np.abs(force.sum(axis=0)).max() / np.abs(force).max(),
            1e-13,
            why="rounding",
        ),
    ]
    sim.commands(f"run {steps} post no")
    after = near(
        "... energy after / before",
        (sim.thermo("pe") + sim.thermo("ke")) / start,
        1.0,
        abs=0.2,
        why="the force jumps where the two nodes meet",
    )
    return [*rows, after]


def twin_grains(lab: Lab, steps: int) -> list[Row]:
    twice = join(
        cloud(disc(3.1), dimension=2), cloud(disc(3.1), dimension=2, molecule=2), margin=200
    )
    sim = loaded(lab, twice, lps(), f"radius {REACH}", STEP)
    sim.commands("run 0 post no")
    start = books(sim)[CONTACT]
    sim.commands(f"run {steps} post no")
    warned = "overlap at the start" in sim.printed()
    return [
        finite_row("two grains at one place", sim, "every node has a twin at distance 0"),
        is_so("... warning", "yes" if warned else "no", warned, "yes", why="the deepest by 100 %"),
        below(
            "... drift / energy of the overlap",
            abs(books(sim)[DRIFT]) / start,
            0.15,
            why="until the step is found anew, ten steps are at 0.8 of the stable one, and fast",
        ),
        below(
            "... kinetic energy / energy of the overlap",
            books(sim)[KINETIC] / start,
            1.0,
            why="no more than there was",
        ),
    ]


CASES = [
    Case(
        "hard-stiffness",
        "Grains whose stiffness differs by 1000",
        (
            "Two discs of one size meet at rest-of-the-soft-one's wave speed; the step is found "
            "by fix peridem/timestep."
        ),
        "conservation",
        stiffness,
        small={"ratio": 1000.0, "radius": 4.1, "speed": 0.05},
        full={"ratio": 1000.0, "radius": 6.1, "speed": 0.05},
    ),
    Case(
        "hard-sizes",
        "Grains whose size differs by 30",
        "A small disc hits a large one: with one node spacing, and as scaled copies of one mesh.",
        "conservation; a small grain must not slip between nodes unseen",
        sizes,
        small={"ratio": 12.0, "speed": 0.5},
        full={"ratio": 30.0, "speed": 0.5},
    ),
    Case(
        "hard-impact",
        "Impact at 0.3 and at 1.0 of the wave speed",
        "Two discs meet head-on, with a critical stretch of 0.05 and unbreakable.",
        "conservation",
        fast,
        small={"mach": (0.3, 1.0), "radius": 4.1, "safety": 0.8},
        full={"mach": (0.1, 0.3, 1.0), "radius": 8.1, "safety": 0.4},
    ),
    Case(
        "hard-overlaps",
        "Overlaps at the start",
        "Two discs at rest whose nearest nodes overlap by a part of the contact distance.",
        "energy of the overlap, k Δ²/2 for each pair of nodes",
        overlaps,
        small={"depths": (1e-6, 1e-3, 0.02, 0.5), "radius": 4.1, "steps": 4000},
        full={"depths": (1e-6, 1e-4, 1e-2, 0.02, 0.1, 0.3, 0.5), "radius": 6.1, "steps": 16000},
    ),
    Case(
        "hard-zero-distance",
        "Nodes at the same place",
        "Two free nodes, two bonded nodes, and two whole grains at zero distance.",
        "no direction, no division by zero",
        same_place,
        small={"steps": 400},
        full={"steps": 800},
    ),
]
