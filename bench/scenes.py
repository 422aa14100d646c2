"""What a node and a step of whole scenes cost, and which part of the program takes it."""

from __future__ import annotations

from pathlib import Path

from bench import scripts, timing
from bench.machine import Machine
from bench.table import Row

TITLE = "Scenes: ns per node and step, one core"
CONTACTS = {
    "friction": "friction 0.3",
    "no friction": "",
    "friction and restitution": "friction 0.3 restitution 0.9",
}


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """One row for each scene and engine."""
    count, steps = (64, 100) if quick else (502, 500)
    data = scripts.packed_grains(count, folder)
    cases = {
        f"{count} grains pressed, {engine}, {name}": scripts.compression(
            data, steps, engine, contact=words
        )
        for engine, name, words in [
            ("general", "friction", CONTACTS["friction"]),
            *(("batched", name, words) for name, words in CONTACTS.items()),
        ]
    }
    runs = timing.in_turns(lmp, cases, folder / "scenes", repeats=1 if quick else 3)
    return [_row(name, timing.median(timings)) for name, timings in runs.items()]


def _row(name: str, one: timing.Timing) -> Row:
    parts = {
        section: 1e9 * seconds / (one.steps * one.nodes)
        for section, seconds in one.sections.items()
    }
    return {
        "scene": name,
        "nodes": one.nodes,
        "ms per step": 1e3 * one.seconds / one.steps,
        "ns per node and step": one.per_node,
        **{f"{section}, ns": value for section, value in parts.items()},
        "list builds": one.builds,
    }


def comment(rows: list[Row], machine: Machine) -> str:
    """What the columns mean."""
    return """\
Pair holds bonds and contact, Modify the time integration, gravity, the walls and the search for the
time step, Neigh the lists that are built anew, Comm what ghosts need, Output thermo with its
energies, Other the clearing of forces."""
