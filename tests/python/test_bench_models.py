"""What benchmarks work out without running anything: ranks on paper, cracks in a mesh."""

from __future__ import annotations

import pytest
from bench import ranks
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
