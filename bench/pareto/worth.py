"""What a choice is worth: the default's processor time for the same error over that of the choice.

Error and cost of a choice alone say little where it changes both: finer nodes do so too.  So each
run is held against the *series*, the default at all resolutions: how long would the default, with
nodes as fine as it takes, have run for that error?  Between two resolutions of the series the
logarithm of cost is taken as linear in that of error; outside of it all that is known is a bound.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench import table
from bench.pareto import front
from bench.table import Row

Array = NDArray[np.float64]
CLEAR = 1.25  # processor times repeat within some 10 %; twice that, both ways
BOUNDS = {-1: "< ", 0: "", 1: "> "}


@dataclass(frozen=True)
class Worth:
    """Of one other value of one setting, in one quantity.

    Attributes:
        setting, value: what is chosen instead of the default.
        times: the default's cost for the same error over the choice's; above 1 the choice is
            better. The geometric mean over all resolutions that were run.
        bound: 1 if ``times`` is at least that, as the default reaches the error at no resolution;
            -1 if at most, as its coarsest nodes are better; 0 otherwise.
    """

    setting: str
    value: str
    times: float
    bound: int = 0

    def __str__(self) -> str:
        return f"{BOUNDS[self.bound]}{self.times:.2g}"


def of_settings(
    rows: Sequence[Row], default: Mapping[str, object], size: str, floor: float = 0.0
) -> list[Worth]:
    """What each single change of a setting is worth.

    Args:
        rows: of one quantity, with settings, error and cost.
        default: the settings; that of ``size`` is not looked at.
        size: column of the resolution.
        floor: errors below it are chance, and count as it.
    """
    settings = without(default, size)
    usual = series(rows, default, size)
    if not usual:
        return []
    cost, error = _lower_edge(usual, floor)
    found: dict[tuple[str, str], list[tuple[float, int]]] = {}
    for row in rows:
        changed = _changed(row, settings)
        if len(changed) == 1:
            key = (changed[0], str(table.shown(row[changed[0]])))
            mine = max(_number(row, front.ERROR), floor)
            same, bound = _cost_of(mine, cost, error)
            found.setdefault(key, []).append((same / _number(row, front.COST), bound))
    return [Worth(*key, *_together(pairs)) for key, pairs in found.items()]


def series(rows: Sequence[Row], default: Mapping[str, object], size: str) -> list[Row]:
    """The runs with all defaults, whatever their resolution."""
    settings = without(default, size)
    return [row for row in rows if not _changed(row, settings)]


def without(default: Mapping[str, object], size: str) -> dict[str, str]:
    """All settings but the resolution, as tables show them."""
    return {key: str(table.shown(value)) for key, value in default.items() if key != size}


def _changed(row: Row, settings: Mapping[str, str]) -> list[str]:
    return [key for key, value in settings.items() if str(table.shown(row[key])) != value]


def _number(row: Row, key: str) -> float:
    return float(str(row[key]))


def _lower_edge(usual: Sequence[Row], floor: float) -> tuple[Array, Array]:
    """Cost and error of the runs of a series that no cheaper one of it beats, cheapest first."""
    edge = [row for row in front.mark(usual) if row[front.FRONT]]
    errors = np.maximum([_number(row, front.ERROR) for row in edge], floor)
    costs = np.array([_number(row, front.COST) for row in edge])
    first = np.unique(errors, return_index=True)[1][::-1]  # of those at the floor the cheapest
    return costs[first], errors[first]


def _cost_of(wanted: float, cost: Array, error: Array) -> tuple[float, int]:
    """Cost of the series for an error; 1 (at least) or -1 (at most) where it does not reach it."""
    if wanted < error[-1]:
        return float(cost[-1]), 1
    if wanted > error[0]:
        return float(cost[0]), -1
    # np.interp wants rising numbers: from the smallest error to the largest
    return float(np.exp(np.interp(np.log(wanted), np.log(error[::-1]), np.log(cost[::-1])))), 0


def _together(pairs: Sequence[tuple[float, int]]) -> tuple[float, int]:
    """Geometric mean; a bound only where all that is known points one way."""
    times = float(np.exp(np.mean([np.log(time) for time, _ in pairs])))
    bounds = {bound for _, bound in pairs} - {0}
    return times, bounds.pop() if len(bounds) == 1 else 0


def verdict(values: Sequence[Worth]) -> str:
    """What the worth of one choice in several cases says of it, in a word or two."""
    better = [one for one in values if one.times >= CLEAR and one.bound >= 0]
    worse = [one for one in values if one.times <= 1 / CLEAR and one.bound <= 0]
    if better and worse:
        return "depends on the case"
    if better:
        return "better"
    return "worse" if worse else "no clear difference"
