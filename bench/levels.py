"""What bonds at an outer level of ``run_style respa`` save."""

from __future__ import annotations

from pathlib import Path

from bench import scripts, timing
from bench.machine import Machine
from bench.table import Row

TITLE = "Contacts inside, bonds outside: run_style respa against verlet"
STYLES = {
    "verlet": "",
    **{f"respa, {k} contact steps": f"run_style respa 2 {k} hybrid 2 1" for k in (2, 3, 4)},
}


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """One row for each engine and run style, on the same scene with the step that is stable."""
    count, steps = (16, 100) if quick else (64, 1000)
    data = scripts.packed_grains(count, folder)
    cases = {
        f"{engine}, {name}": scripts.compression(data, steps, engine, extra=style)
        for engine in ("general", "batched")
        for name, style in STYLES.items()
    }
    runs = timing.in_turns(lmp, cases, folder / "levels", repeats=1 if quick else 3)
    rows: list[Row] = []
    for name, timings in runs.items():
        one = timing.median(timings)
        simulated = 1e6 * one.number(rf"\n +{one.steps} +(\S+)")
        row: Row = {
            "engine, run style": name,
            "step, ns": 1e3 * simulated / one.steps,
            "ms per step": 1e3 * one.seconds / one.steps,
            "ms per simulated us": 1e3 * one.seconds / simulated,
        }
        verlet = rows[len(rows) // len(STYLES) * len(STYLES)] if len(rows) % len(STYLES) else row
        ratio = float(str(row["ms per simulated us"])) / float(str(verlet["ms per simulated us"]))
        rows.append({**row, "over verlet": ratio})
    return rows


def comment(rows: list[Row], machine: Machine) -> str:
    """Where it pays."""
    return """\
Each run has the step that *fix peridem/timestep* finds for it, 0.8 of the largest stable one. Kicks
of the bonds resonate with the contacts where they are half a period of these apart
(doc/theory.rst), so bonds are evaluated at most 1.4 times less often with two contact steps in
each, 1.5 times with three. That pays where bonds take most of the time: with the general engine.
With the batched one contacts, integration and the forces that LAMMPS keeps for each level cost more
than the bonds that are saved."""
