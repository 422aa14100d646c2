"""What benchmarks work out without running anything: ranks on paper, cracks in a mesh,
differences of sets of runs."""

from __future__ import annotations

import numpy as np
import pytest
from bench import adapt, ranks
from bench.pareto import cracks
from peridem import cloud, shapes


def test_a_step_on_paper() -> None:
    network = (1e-6, 1e9)  # latency, bandwidth
    assert ranks._step(1e-7, 1e6, 1, 0.0, network) == pytest.approx(0.1)
    # computation of a half, 1000 ghosts, messages to neighbours, one level of sums
    expected = 0.05 + 1000 * ranks.GHOST_BYTES / 1e9 + (ranks.MESSAGES + ranks.SUMS) * 1e-6
    assert ranks._step(1e-7, 1e6, 2, 1000.0, network) == pytest.approx(expected)


def test_ghosts_are_those_of_a_frame() -> None:
    # 4 ranks of a square of 100 x 100 nodes, frames 3 wide: (50 + 6)^2 - 50^2 inside of many,
    # two of four sides where there are but four: 2 x 50 x 3 + 3^2
    assert ranks._frame(1e4, 4, 3.0, 1.0, outer=False) == pytest.approx(56**2 - 50**2)
    assert ranks._frame(1e4, 4, 3.0, 1.0, outer=True) == pytest.approx(2 * 50 * 3 + 9)


def test_a_crack_takes_gc_where_families_are_large() -> None:
    disc = cloud.mesh(shapes.circle(12.0), 1.0)
    linear = {m: cracks._row(disc, m, "linear", 40)[cracks.ENERGY] for m in (2.05, 5.05)}
    # sums over 78 bonds against integrals, the weight 0 at the horizon: quadrature of 1/m^2, 4 %,
    # halved by the mean over 40 directions
    assert linear[5.05] == pytest.approx(1.0, abs=0.02)
    # with 16 bonds a tenth is missing: what the page says of short horizons is measured
    assert abs(linear[2.05] - 1.0) > 2 * abs(linear[5.05] - 1.0)


def test_a_difference_of_two_sets_of_runs() -> None:
    whole, mine = np.array([1.0, 2.0, 3.0]), np.array([3.0, 3.0, 3.0])
    assert adapt.scatter(whole) == pytest.approx(0.5)
    # means 3 and 2; the standard error of the latter 1 / sqrt(3)
    assert adapt.difference(mine, whole) == "+0.500 ± 0.289"
    assert adapt.difference(-mine, -whole) == "-0.500 ± 0.289"
    nothing = np.zeros(3)
    assert adapt.difference(nothing, nothing) == "0 ± 0" and adapt.scatter(nothing) == 0.0
    assert adapt.difference(mine, nothing) == "inf ± inf"


def test_the_largest_eta_within_the_scatter() -> None:
    def row(eta: str, force: object, work: object, gain: float) -> dict[str, object]:
        known = {"scene": "one", "eta": eta, "s": 1.0, "gain": gain, "awake": 0.5}
        return {**known, "force": force, "work": work}

    rows = [row(adapt.ALL, 0.1, 0.001, 1.0)]
    rows += [row("0.1", "-0.099 ± 0.2", "+0.019 ± 0.2", 2.0)]
    rows += [row("0.3", "+0.101 ± 0.2", "-0.020 ± 0.2", 3.0)]
    # what is right by chance beyond one that is wrong does not count
    rows += [row("1", "+0.000 ± 0.2", "inf ± inf", 4.0)]
    assert adapt.largest(rows, "force")["eta"] == "0.1"
    assert adapt.largest(rows, "work")["eta"] == "0.3"  # 2 % is none
    (found,) = adapt.recommended(rows)
    assert found["force"] == "0.1" and found["work"] == "0.3"
    assert found["all of them"] == "0.1" and found["gain"] == 2.0
    rows[1] = row("0.1", "-0.2 ± 0.1", "+0 ± 0", 2.0)
    (found,) = adapt.recommended(rows)
    assert found["all of them"] == "0" and found["gain"] == 1.0
