"""Scenes in which everything happens at once, run in every way that must not matter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from support.invariance import PIECES, SCENES, SHEAR, Difference, Scene, Way, differences, ways

from .base import Case, Lab, Outcome, Row, below, shown
from .hard_faults import runner

KINDS = {
    "newton off": lambda way: way == Way(newton="off"),
    "2 ranks, processor grids": lambda way: way.ranks == 2 and plain(way),
    "4 ranks, processor grids": lambda way: way.ranks == 4 and plain(way),
    "tiled": lambda way: way.tiled and not way.balance,
    "balanced on the way": lambda way: way.balance,
    "restarts of 1, 2, 4 ranks read by 1, 2, 4": lambda way: way.restart > 0,
}


def plain(way: Way) -> bool:
    return not (way.tiled or way.balance or way.restart)


def few(dimension: int) -> list[Way]:
    """One way of each kind."""
    return [
        Way(newton="off"),
        Way(2, "2 1 1"),
        Way(4, "2 2 1", "off"),
        Way(2, tiled=True),
        Way(2, tiled=True, balance=True),
        Way(4, restart=2),
    ]


def table(scene: Scene, found: list[Difference]) -> str:
    """All ways of one scene, at the end of the run."""
    lines = [f"*{scene.name}*, largest differences from one rank after {scene.steps} steps:", ""]
    lines += ["| way | force | motion | nodes with other bonds | energy | walls |"]
    lines += ["| --- | --- | --- | --- | --- | --- |"]
    for one in found:
        numbers = [one.force[-1], one.motion[-1], one.energy[-1], one.walls[-1]]
        text = [f"{value:.1e}" if value else "0" for value in numbers]
        text.insert(2, f"{int(np.nanmax(one.bonds))}")
        lines.append(f"| {one.way.name} | " + " | ".join(text) + " |")
    return "\n".join(lines)


def how_long(lab: Lab, steps: int) -> list[Row]:
    """Grains sheared on and on: rounding grows by collisions until two runs are two samples."""
    scene = replace(SHEAR, sink=0.0, steps=steps)
    found, damage = differences(scene, runner(lab), lambda _: [Way(2, "2 1 1")])
    at = [round(steps * k / PIECES) for k in range(1, PIECES + 1)]
    text = "; ".join(
        f"{n}: {motion:.1e}, {int(bonds)}"
        for n, motion, bonds in zip(at, found[0].motion[1:], found[0].bonds[1:], strict=True)
    )
    return [
        shown(
            f"sheared for {steps} steps, damage {damage[-1]:.2g}: difference of motion on 2 ranks, "
            "nodes with other bonds",
            text,
            why="after so many steps; a difference of 1 is another sample of the same physics",
        )
    ]


def invariance(lab: Lab, every: bool, longer: tuple[int, ...] = ()) -> Outcome:
    rows: list[Row] = []
    notes = []
    for scene in SCENES:
        mpi = runner(lab)
        found, damage = differences(scene, mpi, ways if every else few)
        broken = f"{damage[1]:.2g}, {damage[2]:.2g}, {damage[4]:.2g}"
        rows.append(
            shown(
                f"{scene.name}: mean damage after a quarter, half, all of {scene.steps} steps",
                broken,
                why="bonds break all the while",
            )
        )
        for kind, belongs in KINDS.items():
            group = [one for one in found if belongs(one.way)]
            name = f"{scene.name}, {kind}"
            if not group[0].way.restart:
                first = max(max(one.force[0], one.energy[0], one.walls[0]) for one in group)
                rows.append(
                    below(
                        (
                            f"{name}: first state, largest relative difference of forces, energy, "
                            "walls"
                        ),
                        first,
                        1e-12,
                        why="the same sums in another order",
                    )
                )
            bonds = max(np.nanmax(one.bonds) for one in group)
            rows.append(below(f"{name}: nodes with other bonds, ever", bonds, 0, why="exactly"))
            last = max(np.nanmax([one.force, one.motion, one.energy, one.walls]) for one in group)
            rows.append(
                below(
                    f"{name}: whole run, largest difference",
                    last,
                    1e-10,
                    why="rounding, multiplied by collisions; a lost bond or a stale ghost is 1e-4",
                )
            )
        notes.append(table(scene, found))
    for steps in longer:
        rows += how_long(lab, steps)
    return Outcome(rows, notes=notes)


CASES = [
    Case(
        "invariance",
        "One end, however it is run",
        "Three scenes that break, rub and are driven by walls: ranks, processor grids, newton, "
        "tiled communication, balancing on the way, restarts. Forces are compared over the "
        "largest "
        "force, motion (positions and velocities) in units of spacing and wave speed, which are "
        "of order 1, energy and walls (reaction, torque, work) over the largest.",
        "one rank",
        invariance,
        small={"every": False},
        full={"every": True, "longer": (4000,)},
    ),
]
