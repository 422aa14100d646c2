"""Adaptive grains: speed against error over eta, beside the scatter that chaos alone gives.

Four scenes run with all grains deformable (``fix nve``), several times from starts that differ by
a billionth of the node spacing, and with ``fix peridem/adapt`` at several eta.  Each run records a
few histories; the error of a run is the root mean square of its difference from the mean of the
deformable runs, over the size of that mean; of fragments, their number at the end counts.  The
scatter is what one deformable run differs from the mean of the others.  An error no larger than the
scatter is none.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from peridem.results_tables import averages

from bench import histories, timing
from bench.adapt_scenes import CASES, MM, Case, from_scene
from bench.machine import Machine
from bench.table import COURSE, Row

__all__ = ["TITLE", "comment", "from_scene", "measure", "plot"]

Array = NDArray[np.float64]
TITLE = "Adaptive grains: speed against error"
ALL = "0 (all deformable)"
ETAS = (0.1, 0.3, 1.0, np.inf)
REPEATS = 3
# with this the error counts as none though repeats scatter less: what is seen in no plot
NEGLIGIBLE = 0.02
ERROR = "error: "


@dataclass(frozen=True)
class Run:
    """One run: its times, its histories in bins of time, fragments at the end, part awake."""

    timed: timing.Timing
    found: dict[str, Array]
    fragments: float
    awake: Array

    @property
    def seconds(self) -> float:
        return self.timed.seconds


def _complete(case: Case, motion: str, seed: int) -> str:
    """A script that records, for one motion."""
    spread = 1e-9 * 0.2 * MM
    names = " ".join(case.records.values())
    awake = "f_motion[1]" if "adapt" in motion else "v_all"
    perturb = f"displace_atoms all random {spread} {spread} 0 {seed}"
    body = case.script.replace("{perturb}", perturb).replace("{motion}", motion)
    return f"""{body}
compute height all com
compute node all peridem/atom damage
compute broken all reduce ave c_node
compute moving all ke
variable now equal time
variable all equal {case.grains}
fix record all ave/time 20 1 20 v_now {names} {awake} file record.dat
thermo_style custom step time dt c_broken
thermo_modify norm no lost error
thermo 100000
variable over equal time>={case.duration}
fix over all halt 20 v_over > 0 error continue message no
run 100000000
compute piece all peridem/atom fragment
variable first atom c_piece==id
compute pieces all reduce sum v_first
thermo_style custom step c_pieces
run 0 post no
variable pieces equal c_pieces
print "FRAGMENTS ${{pieces}}"
"""


def _run(lmp: Path, case: Case, folder: Path, motion: str, seed: int) -> Run:
    timed = timing.run(lmp, _complete(case, motion, seed), folder, loop=0)
    data = averages(folder / "record.dat")
    now = data["v_now"]
    records = {name: data[column] for name, column in case.records.items()}
    awake = data["f_motion[1]" if "f_motion[1]" in data else "v_all"] / case.grains
    found = histories.binned(now, {**records, "awake": awake}, case.duration)
    part = found.pop("awake")
    return Run(timed, found, timed.number(r"FRAGMENTS (\S+)"), part)


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """Rows of every scene: the deformable runs, then each eta."""
    rows: list[Row] = []
    for name, make in CASES.items():
        with tempfile.TemporaryDirectory(dir=folder) as place:
            rows += _one_case(lmp, name, make(lmp, Path(place), quick), Path(place))
    return rows


def _one_case(lmp: Path, name: str, case: Case, folder: Path) -> list[Row]:
    whole = [_run(lmp, case, folder, "nve", seed) for seed in range(1, REPEATS + 1)]
    mean = histories.mean([run.found for run in whole])
    scatter = histories.scatter([run.found for run in whole])
    pieces = np.array([run.fragments for run in whole])
    others = (pieces.sum() - pieces) / (len(pieces) - 1)
    scatter["fragments"] = float(np.mean(np.abs(pieces - others) / others))
    seconds = float(np.median([run.seconds for run in whole]))
    rows = [_row(name, ALL, seconds, 1.0, np.ones(1), scatter)]
    for eta in ETAS:
        words = "1e9" if np.isinf(eta) else f"{eta:g}"
        run = _run(lmp, case, folder, f"peridem/adapt eta {words}", 1)
        errors = histories.difference(run.found, mean)
        errors["fragments"] = float(abs(run.fragments - pieces.mean()) / pieces.mean())
        gain = seconds / run.seconds
        rows.append(_row(name, f"{eta:g}", run.seconds, gain, run.awake, errors))
    return rows


def _row(
    name: str, eta: str, seconds: float, gain: float, awake: Array, errors: dict[str, float]
) -> Row:
    return {
        "scene": name,
        "eta": eta,
        "s": seconds,
        "gain": gain,
        "awake": float(awake.mean()),
        **{f"{ERROR}{key}": value for key, value in errors.items()},
        f"{COURSE}awake": " ".join(f"{part:.2f}" for part in awake),
    }


def _within_scatter(row: Row, scatter: Row) -> bool:
    keys = [key for key in scatter if key.startswith(ERROR)]
    return all(_number(row, k) <= max(_number(scatter, k), NEGLIGIBLE) for k in keys)


def _number(row: Row, key: str) -> float:
    return float(str(row[key]))


def recommended(rows: list[Row]) -> dict[str, Row | None]:
    """For each scene, the row with the largest gain among those whose errors are all no larger
    than the scatter; None where there is none."""
    found: dict[str, Row | None] = {}
    for scatter in (row for row in rows if row["eta"] == ALL):
        good = [row for row in rows if row["scene"] == scatter["scene"] and row is not scatter]
        good = [row for row in good if _within_scatter(row, scatter)]
        found[str(scatter["scene"])] = max(good, key=lambda row: _number(row, "gain"), default=None)
    return found


def comment(rows: list[Row], machine: Machine) -> str:
    """How to read it, and what to choose."""
    lines = [
        f"- {name}: no eta that was tried"
        if row is None
        else f"- {name}: eta {row['eta']}, {_number(row, 'gain'):.2g} times as fast, "
        f"{_number(row, 'awake'):.0%} of the grains awake on average"
        for name, row in recommended(rows).items()
    ]
    shares = "\n".join(lines)
    return f"""\
In the rows of deformable grains the errors are the scatter between repeats that differ by a
billionth of the node spacing at the start. The gain is in processor time on one core; `awake` is
the part of the grains that deform, averaged over time. Energy is the
work of the lid, or the kinetic energy where nothing presses. The largest gain at errors no larger
than the scatter (or {NEGLIGIBLE:.0%}):

{shares}"""


def plot(rows: list[Row], file: Path) -> None:
    """The part of the grains that deform over time, a panel for each scene."""
    import matplotlib.pyplot as plt

    names = list(dict.fromkeys(str(row["scene"]) for row in rows))
    figure, axes = plt.subplots(1, len(names), figsize=(3.2 * len(names), 2.8), sharey=True)
    for name, ax in zip(names, axes, strict=True):
        for row in rows:
            if row["scene"] != name or row["eta"] == ALL:
                continue
            part = np.array(str(row[COURSE + "awake"]).split(), dtype=float)
            label = f"eta {row['eta']} ({_number(row, 'gain'):.2g} times as fast)"
            ax.plot((np.arange(len(part)) + 0.5) / len(part), part, label=label)
        ax.set(title=name, xlabel="time / duration", ylim=(-0.03, 1.03))
        ax.legend(fontsize=6)
    axes[0].set_ylabel("part of the grains awake")
    figure.tight_layout()
    figure.savefig(file, dpi=150)
    plt.close(figure)
