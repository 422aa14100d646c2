"""Outlines: areas and centres against closed forms, distances, refused input."""

import math

import numpy as np
import pytest
from peridem import shapes

# Closed forms evaluated in double precision: a few dozen rounding errors of 1e-16.
ROUNDING = 1e-14


@pytest.mark.parametrize(
    ("outline", "area", "perimeter"),
    [
        (shapes.circle(2.0), 4.0 * math.pi, 4.0 * math.pi),
        (shapes.hexagon(2.0), 6.0 * math.sqrt(3.0), 12.0),
        (shapes.triangle(2.0), 3.0 * math.sqrt(3.0), 6.0 * math.sqrt(3.0)),
        # two trapezia of the sides 2 and 0.8 and the height sqrt(3)
        (shapes.drum(2.0), 2.8 * math.sqrt(3.0), 4.0 + 4.0 * math.hypot(0.6, math.sqrt(3.0))),
        (shapes.rectangle(3.0, 0.5), 1.5, 7.0),
        (shapes.regular_polygon(4, 1.0), 2.0, 4.0 * math.sqrt(2.0)),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_area_and_perimeter_are_the_closed_forms(outline, area, perimeter):
    assert outline.area == pytest.approx(area, rel=ROUNDING)
    assert outline.perimeter == pytest.approx(perimeter, rel=ROUNDING)


@pytest.mark.parametrize("make", [shapes.circle, shapes.hexagon, shapes.triangle, shapes.drum])
def test_named_shapes_are_centred_and_sized_by_the_circle_around_them(make):
    outline = make(0.7)
    assert outline.reach == pytest.approx(0.7, rel=ROUNDING)
    assert np.abs(outline.centroid).max() < ROUNDING


def test_placing_scales_turns_and_moves():
    corner = shapes.rectangle(2.0, 1.0).placed((5.0, 6.0), math.pi / 2, 3.0)
    # width and height change places; the area grows with the square of the scale
    assert corner.bounds == pytest.approx((3.5, 6.5, 3.0, 9.0), rel=ROUNDING)
    assert corner.area == pytest.approx(18.0, rel=ROUNDING)
    assert corner.centroid == pytest.approx((5.0, 6.0), rel=ROUNDING)


def test_clockwise_corners_are_turned_round():
    assert shapes.polygon([(0, 0), (0, 1), (1, 1), (1, 0)]).area == pytest.approx(1.0)


def test_boundary_keeps_corners_and_divides_sides_evenly():
    points = shapes.triangle(1.0).boundary(0.3)
    sides = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    assert len(points) == 3 * round(math.sqrt(3.0) / 0.3)
    assert np.ptp(sides) < ROUNDING
    for corner in shapes.triangle(1.0).vertices:
        assert np.abs(points - corner).sum(axis=1).min() < ROUNDING


def test_distance_of_separate_touching_and_overlapping_outlines():
    disc, square = shapes.circle(1.0), shapes.rectangle(2.0, 2.0)
    assert disc.distance(disc.placed((3.0, 4.0))) == pytest.approx(3.0, rel=ROUNDING)
    assert square.distance(disc.placed((4.0, 5.0))) == pytest.approx(4.0, rel=ROUNDING)
    assert square.distance(square.placed((5.0, 0.5))) == pytest.approx(3.0, rel=ROUNDING)
    assert square.distance(square.placed((1.9, 0.0))) == 0.0
    assert square.distance(shapes.circle(0.1)) == 0.0  # one inside the other
    assert shapes.circle(0.1).distance(square) == 0.0
    assert square.distance(square.placed((0.0, 0.0), 0.0, 0.2)) == 0.0
    # crossing without a corner inside: a plus sign
    assert shapes.rectangle(4.0, 1.0).distance(shapes.rectangle(1.0, 4.0)) == 0.0


def test_distance_sees_into_the_waist_of_a_drum():
    drum, bead = shapes.drum(1.0, neck=0.2), shapes.circle(0.1)
    # at the height of the waist, which is a corner at x = 0.1
    assert drum.distance(bead.placed((0.4, 0.0))) < 0.2
    assert drum.distance(bead.placed((0.4, 0.0))) > 0.0
    assert shapes.rectangle(1.0, math.sqrt(3.0)).distance(bead.placed((0.4, 0.0))) == 0.0


def test_distance_equals_brute_force_over_fine_boundaries():
    random = np.random.default_rng(5)
    kinds = [shapes.circle(1.0), shapes.triangle(1.0), shapes.drum(1.0), shapes.hexagon(0.6)]
    spacing = 5e-3
    for one in kinds:
        for two in kinds:
            moved = two.placed(random.uniform(2.1, 3.0, 2), random.uniform(0.0, 6.0))
            a, b = one.boundary(spacing), moved.boundary(spacing)
            brute = np.sqrt(((a[:, None] - b[None]) ** 2).sum(axis=2)).min()
            # points half a spacing off the nearest ones lengthen a gap of over 0.9 by at most
            # spacing^2 / (2 gap) each, and chords of a circle lie spacing^2/8 inside it
            assert one.distance(moved) == pytest.approx(brute, abs=2.0 * spacing**2)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: shapes.circle(0.0), "radius"),
        (lambda: shapes.hexagon(-1.0), "radius"),
        (lambda: shapes.drum(1.0, neck=1.0), "neck"),
        (lambda: shapes.rectangle(1.0, float("nan")), "height"),
        (lambda: shapes.polygon([(0, 0), (1, 0)]), "at least 3"),
        (lambda: shapes.polygon([(0, 0), (1, 1), (1, 0), (0, 1)]), "cross"),
        (lambda: shapes.polygon([(0, 0), (0, 0), (1, 0), (0, 1)]), "coincides"),
        (lambda: shapes.polygon([(0, 0), (np.inf, 0), (0, 1)]), "finite"),
        (lambda: shapes.circle(1.0).placed(scale=0.0), "scale"),
        (lambda: shapes.circle(1.0).boundary(-1.0), "spacing"),
    ],
)
def test_bad_outlines_are_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()
