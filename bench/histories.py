"""Histories of runs whose steps differ: averages over the same times, and differences of runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
BINS, FINE = 40, 50  # of the time of a run, over which histories are averaged; points in each


def binned(now: Array, values: Mapping[str, Array], duration: float) -> dict[str, Array]:
    """Averages in bins of time.

    Args:
        now: times of the records, (n,), at any distances.
        values: (n,) each.
        duration: the bins end there.

    Returns:
        (BINS,) each.
    """
    times = (np.arange(BINS * FINE) + 0.5) * duration / (BINS * FINE)
    return {
        name: np.interp(times, now, value).reshape(BINS, FINE).mean(axis=1)
        for name, value in values.items()
    }


def difference(one: Mapping[str, Array], other: Mapping[str, Array]) -> dict[str, float]:
    """Root mean square of the difference over that of the other, for each history of the other."""
    return {
        name: float(np.sqrt(np.mean((one[name] - value) ** 2) / max(np.mean(value**2), 1e-300)))
        for name, value in other.items()
    }


def mean(runs: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
    """Of several runs."""
    return {name: np.mean([run[name] for run in runs], axis=0) for name in runs[0]}


def scatter(runs: Sequence[Mapping[str, Array]]) -> dict[str, float]:
    """What one run differs from the mean of the others, on average."""
    each = [difference(one, mean([run for run in runs if run is not one])) for one in runs]
    return {name: float(np.mean([one[name] for one in each])) for name in each[0]}
