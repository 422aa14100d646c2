"""Fifteen grains pressed until they break, against a fine reference and the scatter of chaos."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from bench import histories
from bench.histories import Array
from bench.machine import Machine
from bench.pareto import defaults, front
from bench.pareto.pressed import CRACK, DURATION, JITTER, LID, MM, QUICK, RADIUS, Choice, run
from bench.progress import counted
from bench.table import Row

SIZE = "h"
TITLE = "Speed against error: fifteen grains pressed until they break"
KIND = front.KIND
REPEATS, COARSE = 3, 0.2  # starts that chaos parts; spacings from which on runs cost little
Found = tuple[float, dict[str, Array]]  # processor time and histories of a run

# runs are held against those with inset outlines: where grains touch is what they are to have alike
DEFAULT: dict[str, object] = asdict(Choice())
PRESENT = {"outline": "drawn"}  # what the package does where that is something else


def choices(quick: bool) -> list[Choice]:
    """Resolutions with horizons, then one thing at a time, then what does well together."""
    one = Choice()
    if quick:
        return [one, replace(one, spring=1.0), replace(one, walls="nodes")]
    sizes = [(0.28, 2), (0.28, 3), (0.2, 2), (0.2, 4), (0.14, 2), (0.14, 3), (0.14, 4)]
    found = [one, *(replace(one, h=h, m=m) for h, m in sizes)]
    changes: list[dict[str, object]] = [
        {"m": 2.5},
        {"influence": "constant"},
        {"influence": "inverse"},
        {"volume": "full"},
        *({"spring": alpha} for alpha in (1.0, 3.0, 30.0)),
        *({"spring": alpha, "h": 0.14} for alpha in (1.0, 3.0)),
        {"tangential": "regularised"},
        *({"safety": safety} for safety in (0.4, 0.95)),
        {"walls": "nodes"},
        {"reach": 0.7},
        {"outline": "drawn", "h": 0.1},  # coarser nodes would overlap at the start
        *({"engine": engine} for engine in ("general", "batched")),
        *({"m": 2, "spring": 3.0, "h": h} for h in (0.2, 0.14)),
    ]
    return found + [replace(one, **change) for change in changes]  # type: ignore[arg-type]


def reference(quick: bool) -> Choice:
    """What the others are compared with."""
    return replace(Choice(), h=0.14 if quick else 0.1)


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """Rows of all quantities, each cheapest first."""
    duration = QUICK if quick else DURATION
    rows: list[Row] = []
    with tempfile.TemporaryDirectory(dir=folder) as name:
        place = Path(name)

        def repeated(one: Choice, count: int) -> list[Found]:
            return [run(lmp, one, place, seed, duration) for seed in range(1, count + 1)]

        repeats = 2 if quick else REPEATS
        known = {one: repeated(one, repeats) for one in (reference(quick), Choice())}
        fine = known[reference(quick)]
        truth = histories.mean([found for _, found in fine])
        for one in counted(choices(quick), "compression"):
            runs = known[one] if one in known else repeated(one, 2 if one.h >= COARSE else 1)
            rows += _rows("", one, runs, [histories.difference(found, truth) for _, found in runs])
        for one, runs in known.items():
            scatter = histories.scatter([found for _, found in runs])
            rows += _rows("scatter", one, runs, [scatter])
    return _ordered(rows)


def _rows(
    note: str, one: Choice, runs: Sequence[Found], errors: Sequence[dict[str, float]]
) -> list[Row]:
    """A row for each quantity, with the median of the costs and the mean of the errors."""
    cost = float(np.median([seconds for seconds, _ in runs]))
    return [
        {
            KIND: kind,
            **asdict(one),
            front.COST: cost,
            front.ERROR: float(np.mean([error[kind] for error in errors])),
            front.NOTE: note,
        }
        for kind in errors[0]
    ]


def _ordered(rows: list[Row]) -> list[Row]:
    """Runs with their fronts, the scatter of repeats after them."""
    found: list[Row] = []
    for kind in dict.fromkeys(row[KIND] for row in rows):
        of_kind = [row for row in rows if row[KIND] == kind]
        found += front.mark([row for row in of_kind if not row[front.NOTE]])
        found += [{**row, front.FRONT: ""} for row in of_kind if row[front.NOTE]]
    return found


def comment(rows: list[Row], machine: Machine) -> str:
    """What is compared, what chaos alone gives, what to use."""
    runs = [
        {k: v for k, v in row.items() if k != front.NOTE} for row in rows if not row[front.NOTE]
    ]
    chance = [row for row in rows if row[front.NOTE]]
    size = min(float(str(row["h"])) for row in chance)
    chaos = "; ".join(
        f"{row[KIND]}, h = {row['h']} mm: {100 * float(str(row[front.ERROR])):.0f} %"
        for row in chance
    )
    return f"""\
Grains of three shapes (radius {RADIUS / MM:g} mm) are pressed by a lid that sinks at {LID} m/s
until they break. Compared are the stress on the lid, the impulse it has given so far (what is left
when the stress no longer shows which moment a grain broke in), and the length of all cracks (broken
bonds by volume over {CRACK:.2f} horizons, which a straight crack has per length, whatever the
horizon).
Histories are averaged over {histories.BINS}ths of the run; the error is the root mean square of the
difference from the mean of runs with nodes {size:g} mm apart, over the root mean square of that
mean. With nodes {COARSE:g} mm apart and more it is the mean over two starts.

Starts whose grains are moved by up to {JITTER / MM:g} mm differ from the mean of the others by
({chaos}). Differences no larger than that mean nothing, and count as that in "{defaults.TITLE}".

{front.text(runs, KIND, SIZE)}

{front.changes_text(runs, KIND, DEFAULT)}"""


def plot(rows: list[Row], path: Path) -> None:
    """Error against cost, coloured by the spacing."""
    front.plot([row for row in rows if not row[front.NOTE]], path, KIND, SIZE)
