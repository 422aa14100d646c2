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
# grains that cannot touch: what the pair styles take then, bonds take. The step is that which
# contacts would allow, so that the nodes move as little as with contacts.
APART = """
pair_coeff * * peridem/contact radius 1e-9
unfix step
timestep 1e-7
"""
ALONE = "bonds alone"


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
    for engine in ("general", "batched"):
        cases[f"{engine}, {ALONE}"] = scripts.compression(
            data, steps, engine, contact="friction 0.3", extra=APART
        )
    runs = timing.in_turns(lmp, cases, folder / "scenes", repeats=1 if quick else 3)
    medians = {name: timing.median(timings) for name, timings in runs.items()}
    bonds = {
        engine: _per_node(medians.pop(f"{engine}, {ALONE}"))["Pair"]
        for engine in ("general", "batched")
    }
    return [_row(name, one, bonds[name.split(", ")[1]]) for name, one in medians.items()]


def _per_node(one: timing.Timing) -> dict[str, float]:
    """LAMMPS's sections, ns per node and step."""
    return {
        section: 1e9 * seconds / (one.steps * one.nodes)
        for section, seconds in one.sections.items()
    }


def _row(name: str, one: timing.Timing, bonds: float) -> Row:
    parts = _per_node(one)
    contact = parts.pop("Pair") - bonds
    return {
        "scene": name,
        "nodes": one.nodes,
        "ms per step": 1e3 * one.seconds / one.steps,
        "ns per node and step": one.per_node,
        "bonds, ns": bonds,
        "contact, ns": contact,
        **{f"{section}, ns": value for section, value in parts.items()},
        "list builds": one.builds,
    }


def comment(rows: list[Row], machine: Machine) -> str:
    """What the columns mean."""
    return """\
Bonds and contact are LAMMPS's Pair: bonds is what Pair takes where the same grains cannot touch,
contact the rest. Modify holds the time integration, gravity, the walls and the search for the time
step, Neigh the lists that are built anew, Comm what ghosts need, Output thermo with its energies,
Other the clearing of forces."""
