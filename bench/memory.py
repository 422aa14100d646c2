"""What a node and a bond hold in memory, from the growth of a process between sizes.

Two horizons on the same nodes part what a bond takes from what a node takes.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bench import kernels, scripts, timing
from bench.machine import Machine
from bench.table import Row

TITLE = "Memory"
STYLES = ("peri/lps", "peridem/lps engine general")
HORIZONS = (2.015, 3.015)  # over the spacing


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """One row for each style: bytes per node and per directed bond of a block."""
    return [_row(lmp, style, folder, (12, 20) if quick else (20, 37)) for style in STYLES]


def _row(lmp: Path, style: str, folder: Path, sides: tuple[int, int]) -> Row:
    ours = style.startswith("peridem")
    bytes_per_node, bonds_per_node = [], []
    for horizon in HORIZONS:
        small, large = (
            timing.run(lmp, scripts.block(style, side, 1, horizon=horizon), folder / "memory")
            for side in sides
        )
        nodes = large.nodes - small.nodes
        bytes_per_node.append((large.memory - small.memory) / nodes)
        bonds_per_node.append((kernels._bonds(large, ours) - kernels._bonds(small, ours)) / nodes)
    bond, node = np.polyfit(bonds_per_node, bytes_per_node, 1)
    return {
        "style": style,
        "directed bonds per node": bonds_per_node[-1],
        "bytes per node, all in": bytes_per_node[-1],
        "of them for the node itself": float(node),
        "for each directed bond": float(bond),
    }


def comment(rows: list[Row], machine: Machine) -> str:
    """What is counted."""
    few, many = (f"{horizon:g}" for horizon in HORIZONS)
    return f"""\
The growth of the largest resident size between a small and a large block, so all that a node brings
along is in it: its own numbers, neighbour lists, what the families were built with. What belongs to
the node and what to its bonds follows from horizons of {few} and {many} spacings. With {many} a
gigabyte holds {_thousands(rows[-1]):.0f} thousand nodes of `{rows[-1]["style"]}`.

A directed bond has 12 bytes in the families, which decide what breaks: the other node's ID (4, or 8
with -DLAMMPS_BIGBIG) and the length (8). Where the other node is and the bond's weight follow from
these, and are found anew where they are needed; solids that look at the families in every step
(`peridem/pmb` with its regularised potential or with several types, and viscous forces while
`compute peridem/energy` books them) have both stored, 12 bytes more. The general engine's list has
each bond once, so 10 of a directed bond: half of an index (4), of a length (8) and of a weight (8).
While families are built they take 16, then at most 20 while they are put in order: less than in the
run."""


def _thousands(row: Row) -> float:
    """Of nodes in a gigabyte."""
    return 1e6 / float(str(row["bytes per node, all in"]))
