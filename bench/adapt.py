"""Adaptive grains: speed against error over eta, beside the scatter of repeated runs.

Grains that fly, slide and hit each other are chaotic: two runs that differ by nothing one could
know of the start soon differ in where each grain is, and a comparison moment by moment tells of
that alone.  So each scene runs several times from starts in which the grains have random velocities
of 30 mm/s more, as if they had fallen from a quarter of a node spacing higher: with all grains
deformable (``fix nve``), and from the same starts with ``fix peridem/adapt`` at several eta.  What
is compared are numbers that a user would quote of a run: means over time, what has broken at the
end, fragments.  The difference is that of the means of both sets, with its sign, over the
deformable one, beside its standard error; the scatter is the standard deviation of single
deformable runs.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from peridem.results_tables import averages

from bench import histories, table, timing
from bench.adapt_scenes import CASES, FORCE, Case, from_scene
from bench.machine import Machine
from bench.table import COURSE, Row

__all__ = ["TITLE", "comment", "from_scene", "measure", "plot"]

Array = NDArray[np.float64]
TITLE = "Adaptive grains: speed against error"
ALL = "0 (all deformable)"
ETAS = (0.1, 0.3, 1.0, np.inf)
KICK = 0.03  # m/s
# with this a difference counts as none though repeats scatter less: what is seen in no plot
NEGLIGIBLE = 0.02
KNOWN = ("scene", "eta", "s", "gain", "awake")  # columns that are no quantities


@dataclass(frozen=True)
class Run:
    """One run: its time, numbers by name, the part of the grains awake in bins of time."""

    seconds: float
    numbers: dict[str, float]
    awake: Array


def _kicks(grains: int, seed: int) -> str:
    """Commands that give the grains random velocities."""
    velocities = KICK * np.random.default_rng(seed).standard_normal((grains, 2))
    return "\n".join(
        f"group kicked molecule {k}\n"
        f"velocity kicked set {u:.6g} {v:.6g} NULL sum yes units box\n"
        "group kicked delete"
        for k, (u, v) in enumerate(velocities, 1)
    )


def _complete(case: Case, motion: str, seed: int) -> str:
    """A script that records, for one motion."""
    names = " ".join(case.records.values())
    awake = "f_motion[1]" if "adapt" in motion else "v_all"
    body = case.script.replace("{perturb}", _kicks(case.grains, seed)).replace("{motion}", motion)
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
    numbers: dict[str, float] = {}
    for name, value in found.items():
        numbers[name] = float(value[-1] if name in case.at_end else value.mean())
        if name == FORCE or name.startswith("torque"):
            numbers[f"{name}, root mean square"] = float(np.sqrt(np.mean(value**2)))
    numbers["fragments"] = timed.number(r"FRAGMENTS (\S+)")
    return Run(timed.seconds, numbers, part)


def measure(lmp: Path, folder: Path, machine: Machine, quick: bool) -> list[Row]:
    """Rows of every scene: the deformable runs, then each eta."""
    rows: list[Row] = []
    for name, make in CASES.items():
        with tempfile.TemporaryDirectory(dir=folder) as place:
            case = make(lmp, Path(place), quick)
            if quick:
                case = replace(case, repeats=2)
            rows += _one_case(lmp, name, case, Path(place), ETAS[-2:] if quick else ETAS)
    return rows


def _one_case(lmp: Path, name: str, case: Case, folder: Path, etas: Sequence[float]) -> list[Row]:
    """All motions in turns, so that the machine's moods fall on all alike."""
    motions = {ALL: "nve"}
    for eta in etas:
        motions[f"{eta:g}"] = f"peridem/adapt eta {'1e9' if np.isinf(eta) else f'{eta:g}'}"
    runs: dict[str, list[Run]] = {eta: [] for eta in motions}
    for seed in range(1, case.repeats + 1):
        for eta, motion in motions.items():
            runs[eta].append(_run(lmp, case, folder, motion, seed))
    return [_row(name, eta, runs[eta], runs[ALL]) for eta in motions]


def _row(name: str, eta: str, runs: Sequence[Run], whole: Sequence[Run]) -> Row:
    seconds, slow = (float(np.median([run.seconds for run in some])) for some in (runs, whole))
    awake = np.mean([run.awake for run in runs], axis=0)
    row: Row = {
        "scene": name,
        "eta": eta,
        "s": seconds,
        "gain": slow / seconds,
        "awake": float(awake.mean()),
    }
    for key in whole[0].numbers:
        mine, all_of = (np.array([run.numbers[key] for run in some]) for some in (runs, whole))
        row[key] = scatter(all_of) if eta == ALL else difference(mine, all_of)
    row[f"{COURSE}awake"] = " ".join(f"{part:.2f}" for part in awake)
    return row


def scatter(whole: Array) -> float:
    """Standard deviation of single runs over the size of their mean; 0 where all are 0."""
    size = abs(float(whole.mean()))
    return float(whole.std(ddof=1)) / size if size > 0.0 else 0.0


def difference(mine: Array, whole: Array) -> str:
    """Of the means, over the size of the latter, and its standard error, as text."""
    size = abs(float(whole.mean()))
    if size == 0.0:
        return "0 ± 0" if not mine.any() else "inf ± inf"
    error = np.sqrt(mine.var(ddof=1) / len(mine) + whole.var(ddof=1) / len(whole)) / size
    return f"{(mine.mean() - whole.mean()) / size:+.3f} ± {error:.3f}"


def _quantities(row: Row) -> list[str]:
    return [
        key for key in row if key not in KNOWN and not key.startswith(COURSE) and row[key] != ""
    ]


def _number(row: Row, key: str) -> float:
    """The difference, without its standard error."""
    return float(str(row[key]).split()[0])


def largest(rows: Sequence[Row], key: str) -> Row:
    """Of the rows of one scene, that of the largest eta up to which all differences of a quantity
    lie within the scatter; the row of deformable grains where none does."""
    best, most = rows[0], max(_number(rows[0], key), NEGLIGIBLE)
    for row in rows[1:]:
        if abs(_number(row, key)) > most:
            break
        best = row
    return best


def recommended(rows: Sequence[Row]) -> list[Row]:
    """For each scene: the largest eta of each quantity, that of all, and the gain there."""
    found: list[Row] = []
    for scene in dict.fromkeys(str(row["scene"]) for row in rows):
        mine = [row for row in rows if row["scene"] == scene]
        each = {key: largest(mine, key) for key in _quantities(mine[0])}
        best = min(each.values(), key=mine.index)
        found.append(
            {
                "scene": scene,
                **{key: _eta(row) for key, row in each.items()},
                "all of them": _eta(best),
                "gain": _number(best, "gain"),
                "awake": _number(best, "awake"),
            }
        )
    return found


def _eta(row: Row) -> str:
    return "0" if row["eta"] == ALL else str(row["eta"])


def comment(rows: list[Row], machine: Machine) -> str:
    """How to read it, and what to choose."""
    return f"""\
Rows of deformable grains hold the scatter: the standard deviation of single runs, over the mean,
where grains start with random velocities of {1e3 * KICK:g} mm/s more than what the scene says, as
if they had fallen from a quarter of a node spacing higher. The other rows hold the difference of
the mean of as many runs with `fix peridem/adapt` from the same starts, and its standard error.
Force, height and kinetic energy are means over time, damage and the work of the lid what it has
come to at the end. The gain is in processor time on one core; `awake` is the part of the grains
that deform, averaged over time.

The largest eta up to which differences are no larger than the scatter (or {NEGLIGIBLE:.0%}); with 0
only deformable grains will do, and the gain is 1:

{table.markdown(recommended(rows))}"""


def plot(rows: list[Row], file: Path) -> None:
    """The part of the grains that deform over time, and differences over scatter, by scene."""
    import matplotlib.pyplot as plt

    names = list(dict.fromkeys(str(row["scene"]) for row in rows))
    figure, axes = plt.subplots(2, len(names), figsize=(3.2 * len(names), 5.4), sharey="row")
    for name, over, under in zip(names, *axes, strict=True):
        mine = [row for row in rows if row["scene"] == name]
        for row in mine[1:]:
            part = np.array(str(row[COURSE + "awake"]).split(), dtype=float)
            label = f"eta {row['eta']} ({_number(row, 'gain'):.2g} times as fast)"
            over.plot((np.arange(len(part)) + 0.5) / len(part), part, label=label)
        over.set(title=name, xlabel="time / duration", ylim=(-0.03, 1.03))
        over.legend(fontsize=6)
        at = np.arange(len(mine) - 1)
        for key in _quantities(mine[0]):
            unit = max(_number(mine[0], key), NEGLIGIBLE)
            values = [np.clip(_number(row, key) / unit, -5.0, 5.0) for row in mine[1:]]
            under.plot(at, values, "o-", ms=3, lw=1, label=key)
        under.axhspan(-1.0, 1.0, color="0.9", zorder=0)
        under.set(xlabel="eta", xticks=at, xticklabels=[str(row["eta"]) for row in mine[1:]])
        under.legend(fontsize=6)
    axes[0][0].set_ylabel("part of the grains awake")
    axes[1][0].set_ylabel("difference / scatter of one run")
    figure.tight_layout()
    figure.savefig(file, dpi=150)
    plt.close(figure)
