"""Error against cost: which runs nobody beats, what to use for a wanted error, and the picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from bench import table
from bench.table import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GOALS = (0.10, 0.03, 0.01)
KIND, ERROR, COST, FRONT = "quantity", "error", "s", "front"
NOTE = "note"  # of rows that are no runs to choose from, but tell how far chance goes


def mark(rows: Sequence[Row]) -> list[Row]:
    """The rows, cheapest first, with a star at those that no other is cheaper and better than."""
    marked, best = [], float("inf")
    for row in sorted(rows, key=_cost):
        better = _error(row) < best
        best = min(best, _error(row))
        marked.append({**row, FRONT: "*" if better else ""})
    return marked


def advice(rows: Sequence[Row], size: str) -> list[Row]:
    """For each goal the cheapest row that reaches it, and not by chance.

    Args:
        rows: of one quantity.
        size: column of the resolution; a row counts only where all dearer rows that differ from it
            in nothing else reach the goal too.
    """
    found: list[Row] = []
    for goal in GOALS:
        good = [row for row in rows if _error(row) <= goal and _lasts(row, rows, size, goal)]
        if good:
            found.append({"for": f"{100 * goal:g} %", **_settings(min(good, key=_cost))})
        else:
            nearest = min(rows, key=_error)
            found.append({"for": f"{100 * goal:g} %: none; the best", **_settings(nearest)})
    return found


def _lasts(row: Row, rows: Sequence[Row], size: str, goal: float) -> bool:
    return all(
        _error(other) <= goal
        for other in rows
        if _differing(other, row) == [size] and _cost(other) > _cost(row)
    )


def _differing(one: Row, other: Row) -> list[str]:
    """Settings in which two rows differ."""
    return [key for key in one if key not in (ERROR, COST, FRONT) and one[key] != other[key]]


def text(rows: Sequence[Row], kind: str, size: str) -> str:
    """The tables of advice, one for each value of the column ``kind``."""
    parts = []
    for name, mine in _by_kind(rows, kind).items():
        head = f"For an error of the {name} of 10 %, 3 %, 1 % use (cheapest, and not by chance: "
        head += "finer nodes reach it too)"
        parts.append(f"{head}\n\n{table.markdown(advice(mine, size))}")
    return "\n\n".join(parts)


def changes(rows: Sequence[Row], default: Row) -> list[Row]:
    """What one other setting makes of error and cost; the default first."""
    base = next((row for row in rows if not _differing(default, row)), None)
    if base is None:
        return []
    found: list[Row] = [{"instead": "the default", "error": _error(base), "cost": 1.0}]
    for row in rows:
        other = _differing(default, row)
        if len(other) == 1:
            words = f"{other[0]} {row[other[0]]}, not {default[other[0]]}"
            cost = _cost(row) / max(_cost(base), 1e-9)
            found.append({"instead": words, "error": _error(row), "cost": cost})
    return found


def changes_text(rows: Sequence[Row], kind: str, default: Row) -> str:
    """The tables of single changes, for each value of the column ``kind``."""
    parts = []
    for name, mine in _by_kind(rows, kind).items():
        found = changes(mine, default)
        if found:
            head = f"One thing changed, and what it does to the {name} (cost over the default's)"
            parts.append(f"{head}\n\n{table.markdown(found)}")
    return "\n\n".join(parts)


def _by_kind(rows: Sequence[Row], kind: str) -> dict[str, list[Row]]:
    names = dict.fromkeys(str(row[kind]) for row in rows)
    return {
        name: [{k: v for k, v in row.items() if k != kind} for row in rows if row[kind] == name]
        for name in names
    }


def plot(rows: Sequence[Row], path: Path, kind: str, colour: str) -> None:
    """A panel for each value of the column ``kind``; points coloured by another; the front."""
    import matplotlib.pyplot as plt

    kinds = list(dict.fromkeys(str(row[kind]) for row in rows))
    width = 5.2 * len(kinds)
    figure, axes = plt.subplots(1, len(kinds), figsize=(width, 4.2), layout="constrained")
    for ax, one in zip([axes] if len(kinds) == 1 else axes, kinds, strict=True):
        _panel(ax, [row for row in rows if row[kind] == one], colour)
        ax.set(xlabel="processor time, s", ylabel="error, %", title=one)
    figure.savefig(path, dpi=130)
    plt.close(figure)


def _panel(ax: Axes, rows: Sequence[Row], colour: str) -> None:
    """Runs by cost and error, the front as a stair: nothing that was run lies below it."""
    from matplotlib.ticker import FuncFormatter

    for k, name in enumerate(sorted({str(row[colour]) for row in rows}, key=_as_number)):
        points = [row for row in rows if str(row[colour]) == name]
        x, y = [_cost(row) for row in points], [100 * _error(row) for row in points]
        marker = "os^Dv*"[k % 6]
        ax.loglog(x, y, marker, color=f"C{k}", ms=5, label=f"{colour} {name}", zorder=3)
    best = [row for row in rows if row[FRONT]]
    ends = [*best, {**best[-1], COST: max(_cost(row) for row in rows)}]
    x, y = [_cost(row) for row in ends], [100 * _error(row) for row in ends]
    ax.step(x, y, "k-", where="post", lw=0.9, label="front")
    errors = [_error(row) for row in rows]
    for goal in GOALS:
        if min(errors) < 2 * goal and goal < max(errors):
            ax.axhline(100 * goal, color="0.75", lw=0.7, ls=":")
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(FuncFormatter(_minor))
    ax.tick_params(which="minor", labelsize="small")
    ax.legend(fontsize="small")


def _minor(value: float, _: int | None) -> str:
    """2, 3 and 5 between powers of ten, nothing at the other marks."""
    words = f"{value:g}"
    return words if words.strip("0.") in ("2", "3", "5") else ""


def _as_number(name: str) -> tuple[float, str]:
    try:
        return float(name), ""
    except ValueError:
        return float("inf"), name


def _settings(row: Row) -> Row:
    return {key: value for key, value in row.items() if key != FRONT}


def _error(row: Row) -> float:
    return float(str(row[ERROR]))


def _cost(row: Row) -> float:
    return float(str(row[COST]))
