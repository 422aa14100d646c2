"""Packings: nothing overlaps by brute force, seeds repeat, bad tables are refused."""

import numpy as np
import pytest
from peridem import packing, shapes

OUTLINES = [
    make(radius)
    for radius in (1.0, 0.7)
    for make in (shapes.circle, shapes.hexagon, shapes.triangle, shapes.drum)
]
KINDS = np.arange(16) % len(OUTLINES)
BOX = (0.0, 10.0, 0.0, 12.0)
PADDING = 0.14

MAKERS = {
    "grid": lambda seed: packing.grid(OUTLINES, KINDS, BOX, PADDING, jitter=1.0, seed=seed),
    "random": lambda seed: packing.random_sequential(OUTLINES, KINDS, BOX, PADDING, seed=seed),
    "deposited": lambda seed: packing.deposited(
        OUTLINES, KINDS, BOX, PADDING, seed=seed, trials=10
    ),
}


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_no_two_grains_are_closer_than_the_padding(make):
    made = make(3)
    step = 0.01
    points = [made.outline(i).boundary(step) for i in range(len(made))]
    for i in range(len(made)):
        low, high = points[i].min(axis=0), points[i].max(axis=0)
        # points of the outline lie on it, or (circles) step^2/(8 radius) inside: 2e-5
        assert (low >= np.array([BOX[0], BOX[2]]) + PADDING - 1e-9).all()
        assert (high <= np.array([BOX[1], BOX[3]]) - PADDING + 1e-9).all()
        for j in range(i):
            if np.hypot(*(made.position[i] - made.position[j])) > 2.2:
                continue  # circles of radius 1 around both are further apart than the padding
            gaps = points[i][:, None] - points[j][None]
            assert np.sqrt((gaps**2).sum(axis=2)).min() >= PADDING * (1.0 - 1e-9)
            assert not made.outline(i).contains(points[j]).any()
    # the packing's own measure agrees
    assert made.smallest_gap()[0] >= PADDING * (1.0 - 1e-9)


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_a_seed_repeats_and_another_differs(make):
    one, same, other = make(3), make(3), make(4)
    assert (one.position == same.position).all() and (one.angle == same.angle).all()
    assert (one.position != other.position).any()
    assert (one.kind == KINDS).all()


def test_deposited_grains_rest_on_something():
    made = MAKERS["deposited"](3)
    for i in range(len(made)):
        outline = made.outline(i)
        floor = outline.bounds[2] - BOX[2]
        under = [made.outline(j) for j in range(i)]
        support = min([floor, *(outline.distance(other) for other in under)])
        # it stops within a thousandth of the padding
        assert support <= PADDING * 1.0011
    # denser than what was thrown in at random
    assert max(made.outline(i).bounds[3] for i in range(len(made))) < 0.75 * BOX[3]


def test_area_counts_scale():
    rows = [(0, 2.0, 3.0, 1.0, 0.0), (0, 7.0, 3.0, 2.0, 0.0)]
    made = packing.table(OUTLINES, rows, PADDING, BOX)
    assert made.area == pytest.approx(5.0 * np.pi, rel=1e-14)
    assert made.smallest_gap()[0] == pytest.approx(2.0, rel=1e-14)


def test_table_from_a_file(tmp_path):
    (tmp_path / "table.csv").write_text("kind,x,y,scale,angle\n1,2,3,1,0.5\n3,6,3,0.5,0\n")
    made = packing.table(OUTLINES, tmp_path / "table.csv", PADDING)
    assert made.kind.tolist() == [1, 3]
    assert made.position.tolist() == [[2.0, 3.0], [6.0, 3.0]]
    assert made.scale.tolist() == [1.0, 0.5] and made.angle.tolist() == [0.5, 0.0]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: packing.table(OUTLINES, [(0, 2, 2, 1, 0), (0, 4.1, 2, 1, 0)], PADDING),
            "grains 1 and 2 are 0.1 apart",
        ),
        (lambda: packing.table(OUTLINES, [(0, 1.1, 2, 1, 0)], PADDING, BOX), "inside the box"),
        (lambda: packing.table(OUTLINES, [(0, 1, 1)], PADDING), "columns"),
        (lambda: packing.table(OUTLINES, [(9, 1, 1, 1, 0)], PADDING), "8 outlines"),
        (lambda: packing.grid(OUTLINES, np.zeros(60, int), BOX, PADDING), "20 fit"),
        (
            lambda: packing.random_sequential(
                OUTLINES, np.zeros(40, int), BOX, PADDING, attempts=50
            ),
            "no place for grain",
        ),
        (
            lambda: packing.deposited(OUTLINES, np.zeros(40, int), BOX, PADDING, trials=5),
            "is full after",
        ),
        (lambda: packing.grid(OUTLINES, [0], BOX, 0.0), "padding"),
        (lambda: packing.grid(OUTLINES, [0], (1.0, 0.0, 0.0, 1.0), PADDING), "x_low"),
        (lambda: packing.grid(OUTLINES, [8], BOX, PADDING), "kinds"),
    ],
)
def test_bad_packings_are_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()
