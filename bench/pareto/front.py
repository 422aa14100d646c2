"""Error against cost: which runs nobody beats, what to use for a wanted error, and the picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from bench import table
from bench.table import Row

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
    names = list(dict.fromkeys(str(row[colour]) for row in rows))
    width = 5.2 * len(kinds)
    figure, axes = plt.subplots(1, len(kinds), figsize=(width, 4.2), layout="constrained")
    for ax, one in zip([axes] if len(kinds) == 1 else axes, kinds, strict=True):
        mine = [row for row in rows if row[kind] == one]
        front = [row for row in mine if row[FRONT]]
        for k, name in enumerate(names):
            points = [row for row in mine if str(row[colour]) == name]
            if points:
                x, y = [_cost(row) for row in points], [_error(row) for row in points]
                ax.loglog(x, y, "os^Dv*"[k % 6], color=f"C{k}", label=f"{colour} {name}")
        ax.loglog([_cost(row) for row in front], [_error(row) for row in front], "k-", lw=0.8)
        low = min(_error(row) for row in mine)
        for goal in GOALS:
            if low < 2 * goal:
                ax.axhline(goal, color="0.7", lw=0.7)
        ax.set(xlabel="processor time, s", ylabel=f"error of {one}")
        ax.legend(fontsize="small")
    figure.savefig(path, dpi=130)
    plt.close(figure)


def _settings(row: Row) -> Row:
    return {key: value for key, value in row.items() if key != FRONT}


def _error(row: Row) -> float:
    return float(str(row[ERROR]))


def _cost(row: Row) -> float:
    return float(str(row[COST]))
