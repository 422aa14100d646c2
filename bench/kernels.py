"""What one bond costs: our engines and LAMMPS's own PERI on the same nodes and families.

A directed bond is one node's view of a bond: each bond counts twice.  A force evaluation passes
over all bonds twice, once for the dilatation, once for the forces.
"""

from __future__ import annotations

from pathlib import Path

from bench import scripts, timing
from bench.machine import Machine
from bench.table import Row

TITLE = "Kernels: ns per directed bond and step"
# partner, length and weight of a bond in both passes; a directed bond is half of one
GENERAL_BYTES = 2 * (4 + 8 + 8) / 2


def _bonds(one: timing.Timing, ours: bool) -> float:
    """Directed bonds of a run."""
    if ours:
        return 2.0 * one.number(r"grains?, (\d+) bonds")
    return one.number(r"total # of bonds = (\d+)")  # PERI counts each from both ends


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """One row for each engine and scene."""
    side, flat, count, steps = (17, 60, 64, 10) if quick else (37, 225, 500, 40)
    data = scripts.packed_grains(count, folder)
    cases = {
        "block": {
            style: scripts.block(style, side, steps)
            for style in ("peri/lps", "peridem/lps engine general", "peri/pmb", "peridem/pmb")
        },
        "square": {"peridem/lps engine general": scripts.block("peridem/lps", flat, steps, 2)},
        "grains": {
            f"peridem/lps engine {engine}": scripts.free_grains(data, engine, 2 * steps)
            for engine in ("general", "batched")
        },
    }
    rows: list[Row] = []
    for scene, styles in cases.items():
        runs = timing.in_turns(lmp, styles, folder / scene, repeats=1 if quick else 3)
        for style, timings in runs.items():
            rows.append(_row(scene, style, timing.median(timings), machine))
    return rows


def _row(scene: str, style: str, one: timing.Timing, machine: Machine) -> Row:
    bonds = _bonds(one, style.startswith("peridem"))
    pair = one.sections["Pair"]
    general = "general" in style
    return {
        "scene": scene,
        "style": style,
        "nodes": one.nodes,
        "directed bonds": int(bonds),
        "ns per directed bond": 1e9 * pair / (bonds * one.steps),
        "whole step, ns per node": one.per_node,
        "limit by memory, ns": GENERAL_BYTES / machine.bandwidth if general else "",
        "limit by roots and divisions, ns": machine.root_and_division if general else "",
    }


def comment(rows: list[Row], machine: Machine) -> str:
    """The arithmetic under the table."""
    cost = {(row["scene"], row["style"]): float(str(row["ns per directed bond"])) for row in rows}
    ours, peri = cost["block", "peridem/lps engine general"], cost["block", "peri/lps"]
    batched = cost["grains", "peridem/lps engine batched"]
    general = cost["grains", "peridem/lps engine general"]
    limit = max(GENERAL_BYTES / machine.bandwidth, machine.root_and_division)
    return f"""\
On the block `peridem/lps` is **{peri / ours:.1f} times** as fast as `peri/lps`, and the batched
engine on grains {general / batched:.1f} times as fast as the general one on the same grains.

The general engine visits each bond once in each of its two passes and reads 20 bytes of it (the
partner's number, length, weight), so {GENERAL_BYTES:.0f} bytes of a directed bond in a step: at
{machine.bandwidth} GB/s of one core that is {GENERAL_BYTES / machine.bandwidth:.2f} ns. A square
root and a division for each visit, as the processor makes them at
{machine.root_and_division} ns, would be {machine.root_and_division:.2f} ns. It reaches
{100 * limit / ours:.0f} % of the larger; the rest is the way of eight partners' numbers into
vectors and of eight forces back. The list costs 10 bytes of a directed bond beside the 12 of the
families (with 4-byte IDs), which decide what breaks: passing over the halves of the families' own
rows instead takes no memory, but was slower: the processor fetches what lies between."""
