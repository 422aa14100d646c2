"""``peridem.series``: a grain as an elastic matrix, and how soft rigid grains have to touch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from peridem import cloud, series, shapes
from peridem.material import Material

from support import clouds
from support.runs import Simulation

SOLID = Material(bulk=3.0, poisson=0.3, density=1.0, horizon=0.65)


def disc() -> cloud.Cloud:
    return cloud.mesh(shapes.circle(1.0), 0.2)


def ball() -> cloud.Cloud:
    return cloud.lattice(shapes.sphere(1.0), 0.45)


GRAINS: dict[str, tuple[Callable[[], cloud.Cloud], Material]] = {
    "disc, linear": (disc, SOLID),
    "disc, constant, full": (disc, replace(SOLID, influence="constant", volume="full")),
    "disc, plane stress": (disc, replace(SOLID, plane="stress")),
    "disc, gaussian": (disc, replace(SOLID, influence="gaussian", width=0.3)),
    "ball, inverse": (ball, replace(SOLID, influence="inverse", horizon=1.0)),
}


@pytest.mark.parametrize("name", GRAINS)
def test_the_matrix_gives_the_forces_of_lammps(name: str, tmp_path: Path) -> None:
    make, solid = GRAINS[name]
    one = make()
    x, d = one.nodes, one.dimension
    rng = np.random.default_rng(3)
    u = 1e-6 * rng.standard_normal(x.shape)
    start = clouds.cloud(x, volume=one.volumes, dimension=d)
    moved = start.x.copy()
    moved[:, :d] += u
    sim = Simulation(tmp_path).load(start.moved(moved), dimension=d)
    sim.commands(
        f"pair_style peridem/lps\npair_coeff * * {solid.pair_coeff(d)}\nfix m all nve\nrun 0"
    )
    force = -series.elastic(one, solid).stiffness @ u.ravel()
    # geometry changes by a millionth of the spacing
    got = sim.atoms("f")[:, :d].ravel()
    sim.close()
    np.testing.assert_allclose(got, force, rtol=0, atol=1e-4 * np.abs(force).max())


def test_rigid_motion_has_no_stiffness() -> None:
    one = disc()
    solid = series.elastic(one, SOLID)
    x = one.nodes
    turning = np.column_stack([-x[:, 1], x[:, 0]]).ravel()
    shift = np.tile((1.0, 2.0), len(x))
    scale = np.abs(solid.stiffness).max()
    for motion in (turning, shift):  # rounding of sums over a row
        assert np.abs(solid.stiffness @ motion).max() < 1e-14 * scale * len(x)


def test_soft_springs_need_no_factor_and_stiff_ones_a_small_one() -> None:
    found = [series.factors([disc()], SOLID, stiff) for stiff in (1e-4, 1.0, 10.0, 100.0)]
    walls = [one.wall for one in found]
    assert walls[0] == pytest.approx(1.0, abs=1e-3)
    assert all(b < a for a, b in pairwise(walls))
    # where the spring is all but rigid, the grain alone gives way: stiff times factor stays
    assert 100.0 * walls[3] == pytest.approx(10.0 * walls[2], rel=0.2)
    for one in found:
        assert one.pair == pytest.approx(one.wall / (2.0 - one.wall))


def test_compliances_of_shapes_add_up() -> None:
    parts = [disc(), cloud.mesh(shapes.hexagon(1.0), 0.2)]
    alone = [series.factors([one], SOLID).wall for one in parts]
    both = series.factors(parts, SOLID).wall
    assert 2.0 / both == pytest.approx(1.0 / alone[0] + 1.0 / alone[1])


def test_a_ball_is_pressed_from_all_sides() -> None:
    solid = replace(SOLID, horizon=1.0)
    one = ball()
    assert 0.01 < series.factors([one], solid, directions=5).pair < 0.9


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"stiff": 0.0}, "stiff > 0"),
        ({"strain": 0.2}, "strain 0.2"),
        ({"directions": 0}, "directions 0"),
    ],
)
def test_bad_values(words: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        series.factors([disc()], SOLID, **words)


def test_constants_of_another_dimension_are_refused() -> None:
    with pytest.raises(ValueError, match="not jha"):
        series.elastic(disc(), replace(SOLID, plane="jha"))
