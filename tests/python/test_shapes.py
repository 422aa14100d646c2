"""Outlines: areas and centres against closed forms, distances, refused input."""

import math

import numpy as np
import pytest
from peridem import shapes
from peridem.shapes import Outline
from scipy.spatial import cKDTree

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
        # a perimeter of 4 a E(e^2): 9.688448220547675 for the semi-axes 2 and 1 (Abramowitz 17.3.3)
        (shapes.ellipse(2.0, 1.0), 2.0 * math.pi, 9.688448220547675),
        # ten triangles with the sides 2 and 1 and the angle pi/5 between them
        (
            shapes.star(2.0, 5, 0.5),
            10.0 * math.sin(math.pi / 5.0),
            10.0 * math.sqrt(5.0 - 4.0 * math.cos(math.pi / 5.0)),
        ),
        (shapes.annulus(1.0, 2.0), 3.0 * math.pi, 6.0 * math.pi),
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


ALL = [(name, shapes.named(name, 0.7)) for name in shapes.NAMED]
PLANE = [shape for _, shape in ALL if shape.dimension == 2]
SPACE = [shape for _, shape in ALL if shape.dimension == 3]


@pytest.mark.seconds
@pytest.mark.parametrize("shape", PLANE + SPACE, ids=lambda s: s.name)
def test_moments_are_those_of_many_points_inside(shape):
    """Area or volume, centroid and second moments against a fine grid of points."""
    low, high = shape.extent
    assert (high - low).max() <= 1.4 * (1.0 + ROUNDING)
    n = 500 if shape.dimension == 2 else 60
    axes = [a + (b - a) * (np.arange(n) + 0.5) / n for a, b in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, shape.dimension)
    inside = points[shape.contains(points)]
    cell = np.prod(high - low) / n**shape.dimension
    # a grid misjudges about half a layer of cells at the boundary at random: over 60 cells in space
    # and 500 in the plane this leaves less than 1 %
    assert cell * len(inside) == pytest.approx(shape.measure, rel=0.01)
    assert inside.mean(axis=0) == pytest.approx(shape.centroid, abs=3e-3)
    arm = inside - inside.mean(axis=0)
    scale = np.trace(shape.moments)
    assert cell * arm.T @ arm == pytest.approx(shape.moments, abs=0.01 * scale)


@pytest.mark.parametrize(
    ("shape", "volume", "moments"),
    [
        (shapes.sphere(2.0), 32.0 * math.pi / 3.0, [128.0 * math.pi / 15.0] * 3),
        (shapes.cuboid(1.0, 2.0, 3.0), 6.0, [0.5, 2.0, 4.5]),
        (
            shapes.cylinder(2.0, 3.0),
            12.0 * math.pi,
            [12.0 * math.pi, 12.0 * math.pi, 9.0 * math.pi],
        ),
        (shapes.ellipsoid(1.0, 2.0, 5.0), 40.0 * math.pi / 3.0, None),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_solids_have_their_closed_forms(shape, volume, moments):
    assert shape.volume == pytest.approx(volume, rel=ROUNDING)
    if moments is not None:
        assert shape.moments == pytest.approx(np.diag(moments), rel=ROUNDING, abs=1e-13)
        turned = shape.placed((1.0, 2.0, 3.0), (0.3, -0.4, 0.5), 2.0)
        # similar matrices: the same eigenvalues, 2^5 times larger
        found = np.linalg.eigvalsh(turned.moments)
        assert found == pytest.approx(32.0 * np.sort(moments), rel=1e-13)
        assert turned.centroid == pytest.approx((1.0, 2.0, 3.0), abs=1e-13)
        assert np.trace(turned.inertia) == pytest.approx(2.0 * found.sum(), rel=1e-13)


@pytest.mark.parametrize("shape", PLANE + SPACE, ids=lambda s: s.name)
def test_mirror_image_twice_is_the_shape_and_once_has_its_moments(shape):
    image = shape.mirrored(1)
    sign = np.ones(shape.dimension)
    sign[1] = -1.0
    # sums of some hundred products: a few hundred rounding errors
    assert image.measure == pytest.approx(shape.measure, rel=1e-12)
    assert image.centroid == pytest.approx(shape.centroid * sign, abs=1e-13)
    assert image.moments == pytest.approx(shape.moments * np.outer(sign, sign), abs=1e-13)
    points = np.random.default_rng(2).uniform(-0.7, 0.7, (500, shape.dimension))
    assert (image.contains(points * sign) == shape.contains(points)).all()
    again = image.mirrored(1)
    assert (again.contains(points) == shape.contains(points)).all()


def points_of(solid):
    """Points of the surface of the polyhedron that stands for a solid in distances."""
    vertices, triangles = solid.surface()
    n = max(2, round(math.sqrt(8000 / len(triangles))))
    i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1))
    u, v = i[i + j <= n] / n, j[i + j <= n] / n
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    return (a[:, None] + u[:, None] * (b - a)[:, None] + v[:, None] * (c - a)[:, None]).reshape(
        -1, 3
    )


@pytest.mark.parametrize("one", SPACE, ids=lambda s: s.name)
@pytest.mark.parametrize("two", SPACE, ids=lambda s: s.name)
def test_distance_of_solids_equals_brute_force(one, two):
    other = two.placed((1.5, 0.6, 0.3), (0.4, 1.2, -0.7), 0.8)
    brute = cKDTree(points_of(one)).query(points_of(other))[0].min()
    distance = one.distance(other)
    # the points are at most 0.06 off the nearest ones, which lengthens the gap of over 0.3 by at
    # most 0.06^2/(2 0.3) each; a sphere lies up to 0.8 % of 0.7 inside the polyhedron that the
    # brute force sees
    assert brute - 2.0 * 0.06**2 / 0.6 <= distance <= brute + 2.0 * 0.008 * 0.7
    assert distance > 0.3
    assert other.distance(one) == pytest.approx(distance, rel=1e-9)
    # and nothing is left of it when they overlap, or one is inside the other
    assert one.distance(two.placed((0.5, 0.0, 0.0))) == 0.0
    assert one.distance(two.placed(scale=0.1)) == 0.0
    assert two.placed(scale=0.1).distance(one) == 0.0


def test_distance_counts_what_lies_in_the_hole_of_an_annulus():
    wall, bead = shapes.annulus(1.0, 1.2, (0.4, 0.2)), shapes.circle(0.1)
    # the hole is a polygon of 720 sides, up to 1e-5 inside the circle
    assert wall.distance(bead.placed((0.5, 0.0))) == pytest.approx(0.4, abs=2e-5)
    assert wall.distance(bead.placed((0.0, -0.4))) == pytest.approx(0.1, abs=1e-12)  # above the fin
    assert wall.distance(bead.placed((0.0, -0.55))) == 0.0
    assert wall.distance(bead.placed((2.0, 0.0))) == pytest.approx(0.7, abs=1.2e-4)  # 240 sides


def test_room_inside_a_shape():
    assert shapes.rectangle(4.0, 2.0).room_for(shapes.circle(0.5)) == pytest.approx(0.5)
    assert shapes.rectangle(4.0, 2.0).room_for(shapes.circle(1.5)) == 0.0
    # inside a circle the room is that of the polygon of 240 sides in it, 1e-4 smaller
    assert shapes.circle(1.0).room_for(shapes.circle(0.5)) == pytest.approx(0.5, abs=1e-4)
    assert shapes.cuboid(2.0, 2.0, 2.0).room_for(shapes.sphere(0.4)) == pytest.approx(0.6)
    assert shapes.cuboid(2.0, 2.0, 2.0).room_for(shapes.cuboid(1.0, 1.0, 1.0)) == pytest.approx(0.5)
    assert shapes.cuboid(2.0, 2.0, 2.0).room_for(shapes.sphere(0.4).placed((1.0, 0.0, 0.0))) == 0.0


@pytest.mark.parametrize("make", [shapes.irregular, shapes.irregular_solid])
def test_irregular_grains_differ_by_seed_and_are_centred(make):
    one, same, other = make(0.5, seed=1), make(0.5, seed=1), make(0.5, seed=2)
    assert one.measure == same.measure != other.measure
    for grain in (one, other):
        assert grain.reach == pytest.approx(0.5, rel=ROUNDING)
        # rounding of a sum over the corners, of order 1
        assert np.abs(grain.centroid).max() < 1e-14


def test_a_surface_file_is_a_solid(tmp_path):
    import meshio

    rock = shapes.irregular_solid(1.0, seed=3)
    vertices, triangles = rock.surface()
    for name, binary in (("a.stl", False), ("b.stl", True)):
        meshio.write(
            tmp_path / name, meshio.Mesh(vertices, [("triangle", triangles)]), binary=binary
        )
        back = shapes.stl(tmp_path / name)
        assert len(back.form.vertices) == len(vertices)  # corners of single triangles are joined
        # .stl holds seven digits
        assert back.volume == pytest.approx(rock.volume, rel=1e-5)
        assert back.name == name[0]
    meshio.write(tmp_path / "open.stl", meshio.Mesh(vertices, [("triangle", triangles[1:])]))
    with pytest.raises(ValueError, match="not closed: 3 sides"):
        shapes.stl(tmp_path / "open.stl")


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


@pytest.mark.seconds
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
        (lambda: shapes.ellipse(1.0, 0.0), "semi_axis_y"),
        (lambda: shapes.star(1.0, 2), "at least 3"),
        (lambda: shapes.star(1.0, 5, 0.9), "inner"),
        (lambda: shapes.annulus(1.0, 0.9), "larger than inner"),
        (lambda: shapes.annulus(1.0, 1.2, (1.5, 0.1)), "fin"),
        (lambda: shapes.irregular(1.0, 2), "corners"),
        (lambda: shapes.irregular(1.0, roughness=1.0), "roughness"),
        (lambda: shapes.irregular_solid(1.0, 5), "corners"),
        (lambda: shapes.irregular_solid(1.0, elongation=0.5), "elongation"),
        (lambda: shapes.sphere(-1.0), "radius"),
        (lambda: shapes.ellipsoid(1.0, 1.0, 0.0), "semi_axis_z"),
        (lambda: shapes.cuboid(1.0, -1.0, 1.0), "depth"),
        (lambda: shapes.cylinder(1.0, 0.0), "height"),
        (lambda: shapes.sphere(1.0).placed(scale=-1.0), "scale"),
        (lambda: shapes.sphere(1.0).placed(angle=(1.0, 2.0)), "rotation"),
        (lambda: shapes.polyhedron(np.eye(3), [(0, 1, 2)]), "4 or more"),
        (
            lambda: shapes.polyhedron(
                np.eye(4)[:, :3], [(0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)]
            ),
            "used twice in one direction",
        ),
        (lambda: shapes.named("blob", 1.0), "circle, ellipse"),
        (
            lambda: Outline("o", [(0, 0), (1, 0), (0, 1)], holes=(shapes.circle(2.0),)),
            "hole 1 is not inside",
        ),
        (lambda: shapes.circle(1.0).boundary(-1.0), "spacing"),
    ],
)
def test_bad_outlines_are_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()
