"""What a node and a bond hold in memory, from the growth of a process between two sizes."""

from __future__ import annotations

from pathlib import Path

from bench import kernels, scripts, timing
from bench.machine import Machine
from bench.table import Row

TITLE = "Memory"
STYLES = ("peri/lps", "peridem/lps engine general")


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """One row for each style: bytes per node and per directed bond of a block."""
    rows: list[Row] = []
    for style in STYLES:
        small, large = (
            timing.run(lmp, scripts.block(style, side, 1), folder / "memory")
            for side in ((12, 20) if quick else (20, 37))
        )
        ours = style.startswith("peridem")
        nodes = large.nodes - small.nodes
        bonds = kernels._bonds(large, ours) - kernels._bonds(small, ours)
        grown = large.memory - small.memory
        rows.append(
            {
                "style": style,
                "bytes per node": grown / nodes,
                "directed bonds per node": bonds / nodes,
                "bytes per directed bond, all in": grown / bonds,
            }
        )
    return rows


def comment(rows: list[Row], machine: Machine) -> str:
    """What is counted."""
    return """\
The growth of the largest resident size between a small and a large block, so all that a node brings
along is in it: its own numbers, neighbour lists, what the families were built with."""
