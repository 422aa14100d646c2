"""Faults met in other codes that join grains by bonds; each is a row that must stay zero.

Potential energy that jumps when a run is split, atoms are sorted or migrate, or a restart is read;
bonds whose reference length changes when others break; contact energy out of nothing where a bond
breaks; fracture that differs when it happens in the first run, on two ranks.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from support.clouds import Cloud, ragged
from support.oracle import Solid
from support.runs import MpiRunner, Simulation, header, lps_words, read_dump

from .base import Case, Lab, Outcome, Row, above, below, is_so
from .hard_common import BROKEN, CONTACT, STRAIN, books, loaded, total

SOLID = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, s0=0.05)
TOUCH = "radius 0.95 stiffness 5"


def pulled(side: int, rate: float) -> Cloud:
    """A jittered square that is being torn along x."""
    one = ragged(np.random.default_rng(2), (side, side))
    one.box[:2] = [[-60.0, 60.0], [-60.0, 60.0]]
    one.v[:, 0] = rate * one.x[:, 0]
    return one


def runner(lab: Lab) -> MpiRunner:
    """mpirun with the executable that the tests use."""
    here = Path(__file__).resolve().parents[3]
    return MpiRunner(Path(os.environ.get("LAMMPS_LMP", here / "build" / "lmp")), lab.folder)


# --- what must not jump --------------------------------------------------------------------------


def no_jump(lab: Lab, side: int, steps: int) -> Outcome:
    rows: list[Row] = []
    for name, rate in (("before bonds break", 0.002), ("after bonds have broken", 0.05)):
        sim = loaded(lab, pulled(side, rate), lps_words(SOLID), TOUCH, "timestep 0.05")
        sim.commands(f"run {steps} post no")
        damage = sim.compute("node")[:, 0].mean()
        right = damage == 0 if rate < 0.01 else 0.02 < damage < 0.9
        rows.append(
            is_so(
                f"{name}: mean damage",
                f"{damage:.3g}",
                right,
                "as named",
                why="the scene is what it says",
            )
        )
        state = state_of(sim)
        restart = lab.folder / f"jump{rate}.restart"
        sim.commands(f"write_restart {restart}")
        for what, script in SAME_STATE.items():
            sim.commands(f"{script}\nrun 0 post no")
            rows += jump_rows(f"{name}, {what}", state, state_of(sim))
        second = lab.simulation().commands(
            f"read_restart {restart}\npair_coeff * * peridem/lps {lps_words(SOLID)}\n"
            f"pair_coeff * * peridem/contact {TOUCH}\ncompute books all peridem/energy\n"
            "fix motion all nve\nthermo_style custom step pe c_books[1]\nthermo_modify norm no\n"
            "run 0 post no"
        )
        rows += jump_rows(f"{name}, a restart read", state, state_of(second))
        lab.close()
    return Outcome(rows)


SAME_STATE = {
    "a new run": "",
    "atoms sorted": "atom_modify sort 1 0.5\nneigh_modify every 1 delay 0 check no",
    "other ghosts and skin": "comm_modify cutoff 12.0\nneighbor 1.0 bin",
}


def state_of(sim: Simulation) -> tuple[float, float, np.ndarray]:
    """Potential energy, strain energy, forces."""
    return sim.thermo("pe"), float(books(sim)[STRAIN]), sim.atoms("f")


def jump_rows(name: str, before: tuple, after: tuple) -> list[Row]:
    rounding = "the same sums, perhaps in another order"
    force = np.abs(after[2] - before[2]).max() / np.abs(before[2]).max()
    return [
        below(
            f"{name}: jump of the potential energy / itself",
            abs(after[0] / before[0] - 1),
            1e-13,
            why=rounding,
        ),
        below(f"{name}: jump of a force / largest", force, 1e-12, why=rounding),
        below(
            f"{name}: jump of the strain energy / itself",
            abs(after[1] / before[1] - 1),
            1e-13,
            why=rounding,
        ),
    ]


# --- what breaks ---------------------------------------------------------------------------------


def no_memory(lab: Lab, side: int, steps: int) -> Outcome:
    """Bonds that hold keep their length; bonds that break leave no contact energy."""
    one = pulled(side, 0.05)
    sim = loaded(lab, one, lps_words(SOLID), TOUCH, "timestep 0.02")
    sim.commands("run 0 post no")
    most_contact, most_gain, contact_at_break = 0.0, 0.0, 0.0
    before, broken = total(sim), 0.0
    start = before
    for _ in range(steps):
        sim.commands("run 1 pre no post no")
        got, now = books(sim), total(sim)
        if got[BROKEN] > broken:
            contact_at_break = max(contact_at_break, got[CONTACT])
            most_gain = max(most_gain, now - before)
        most_contact = max(most_contact, got[CONTACT])
        before, broken = now, got[BROKEN]
        if sim.compute("node")[:, 0].mean() > 0.3:
            break
    damage = sim.compute("node")[:, 0].mean()
    rows = [
        above("mean damage", damage, 0.05, why="bonds did break"),
        below(
            (
                "energy of contact at a step in which bonds break, while all is pulled apart / "
                "all energy"
            ),
            contact_at_break / start,
            1e-15,
            why="d_c = min(R_c, R): a bond that breaks is longer than R",
        ),
        below(
            "largest gain of potential and kinetic energy in such a step / all energy",
            most_gain / start,
            1e-5,
            why="bonds only take energy with them; velocity Verlet at a tenth of the stable step",
        ),
    ]
    sim.at(one.reference, 0 * one.x)
    return Outcome(rows + back_at_its_reference(sim, start, damage))


def back_at_its_reference(sim: Simulation, start: float, damage: float) -> list[Row]:
    """A grain with broken bonds, put back: nothing but the damage tells of what was."""
    return [
        below(
            "grain put back to its reference: potential energy / all energy",
            sim.thermo("pe") / start,
            1e-24,
            why="lengths of the bonds that hold are the first ones: (1e-16)² of rounding",
        ),
        below(
            "... largest force / stiffness of a bond",
            np.abs(sim.atoms("f")).max() / SOLID.bulk,
            1e-13,
            why="rounding of positions of size 10",
        ),
        below(
            "... change of the damage",
            float(np.abs(sim.compute("node")[:, 0].mean() - damage)),
            0.0,
            why="broken for ever",
        ),
    ]


# --- two ranks -----------------------------------------------------------------------------------


def two_ranks(lab: Lab, side: int, steps: int) -> Outcome:
    one = pulled(side, 0.05)
    mpi = runner(lab)
    one.write(lab.folder / "pulled.data")
    ends = {}
    for ranks, grid in ((1, "1 1 1"), (2, "2 1 1"), (2, "1 2 1")):
        mpi(
            header(one, "pulled.data", dimension=2, extra=f"processors {grid}")
            + f"""
pair_style hybrid/overlay peridem/lps peridem/contact
pair_coeff * * peridem/lps {lps_words(SOLID)}
pair_coeff * * peridem/contact {TOUCH}
compute node all peridem/atom damage bonds
fix motion all nve
timestep 0.05
thermo 1000000
run {steps} post no
write_dump all custom first.last id x y z c_node[1] c_node[2] modify format float %.17g
""",
            ranks,
        )
        (ends[grid],) = read_dump(lab.folder / "first.last")
    alone = ends.pop("1 1 1")
    rows = [above("mean damage in the first run", alone["c_node[1]"].mean(), 0.05, why="it breaks")]
    for grid, other in ends.items():
        differ = int((other["c_node[2]"] != alone["c_node[2]"]).sum())
        rows += [
            below(
                f"grid {grid}: nodes with other bonds than on one rank",
                differ,
                0,
                why="both ends decide alike, on all ranks",
            ),
            below(
                f"grid {grid}: largest difference of a position / spacing",
                np.abs(other["x y z"] - alone["x y z"]).max(),
                1e-11,
                why=f"rounding of {steps} steps, multiplied where fragments touch",
            ),
        ]
    return Outcome(rows)


CASES = [
    Case(
        "fault-jump",
        "Nothing jumps between runs",
        "A grain that is torn; its energies and forces before and after what must not matter.",
        "the state is the same",
        no_jump,
        small={"side": 8, "steps": 120},
        full={"side": 20, "steps": 120},
    ),
    Case(
        "fault-memory",
        "Bonds forget nothing, and leave nothing behind",
        "A grain is torn step by step, then put back to where it came from.",
        "the model",
        no_memory,
        small={"side": 8, "steps": 400},
        full={"side": 16, "steps": 1000},
    ),
    Case(
        "fault-two-ranks",
        "Fracture in the first run on two ranks",
        "The grain is torn at once, on one rank and on two.",
        "one rank",
        two_ranks,
        small={"side": 10, "steps": 100},
        full={"side": 30, "steps": 200},
    ),
]
