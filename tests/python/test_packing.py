"""Packings: nothing overlaps by brute force, seeds repeat, bad tables are refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as draw
from peridem import cloud, packing, placing, settle, shapes
from peridem.placing import Sizes
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

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


# ---- any packing, in the plane and in space ------------------------------------------------------

FLAT = [shapes.named(name, 1.0) for name in ("circle", "ellipse", "star", "drum", "irregular")]
SOLID = [
    shapes.named(name, 1.0)
    for name in ("sphere", "cuboid", "ellipsoid", "cylinder", "irregular_solid")
]


def points_of(shape):
    """Points on the boundary of a shape, some 0.1 apart."""
    if shape.dimension == 2:
        return shape.boundary(0.03)
    vertices, triangles = shape.surface(outside=False)
    n = max(1, round(np.sqrt(2000 / len(triangles))))
    i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1))
    u, v = i[i + j <= n] / n, j[i + j <= n] / n
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    return (a[:, None] + u[:, None] * (b - a)[:, None] + v[:, None] * (c - a)[:, None]).reshape(
        -1, 3
    )


def assert_apart(made, padding):
    """No point of a grain, or of its images, is nearer to another than the padding, or inside."""
    within = made.container
    points = [points_of(made.outline(i)) for i in range(len(made))]
    fixed = ~np.array(within.periodic)
    for i in range(len(made)):
        assert (points[i].min(axis=0) - within.low)[fixed].min(initial=9.0) >= padding - 1e-9
        assert (within.high - points[i].max(axis=0))[fixed].min(initial=9.0) >= padding - 1e-9
        for shift in within.shifts():
            moved = points[i] + shift
            near = cKDTree(moved)
            for j in range(i):
                # points lie on the boundary, so their distance is that of the shapes or more
                assert near.query(points[j])[0].min() >= padding * (1.0 - 1e-9)
                assert not made.outline(j).contains(moved).any()


@pytest.mark.seconds
@settings(max_examples=8, deadline=None)
@given(
    seed=draw.integers(0, 1000),
    flat=draw.booleans(),
    periodic=draw.booleans(),
    orientation=draw.sampled_from(["random", "fixed", 0.2]),
    padding=draw.floats(0.02, 0.3),
)
def test_filled_boxes_never_overlap(seed, flat, periodic, orientation, padding):
    d = 2 if flat else 3
    size = 9.0 if flat else 5.0
    box = packing.Container(np.zeros(d), np.full(d, size), (periodic,) * d)
    made = packing.fill(
        FLAT if flat else SOLID,
        0.2 if flat else 0.05,
        box,
        padding,
        seed,
        sizes=Sizes.uniform(0.5, 1.0),
        orientation=orientation,
    )
    assert_apart(made, padding)
    assert made.smallest_gap()[0] >= padding * (1.0 - 1e-9)
    # whole grains: within half of the largest, of area pi or volume 4.19
    assert abs(made.area - made.fraction * size**d) < 1e-9
    assert abs(made.fraction - (0.2 if flat else 0.05)) * size**d <= 0.5 * (np.pi if flat else 4.19)
    again = packing.fill(
        FLAT if flat else SOLID,
        0.2 if flat else 0.05,
        box,
        padding,
        seed,
        sizes=Sizes.uniform(0.5, 1.0),
        orientation=orientation,
    )
    assert (again.position == made.position).all() and (again.angle == made.angle).all()


@pytest.mark.seconds
@pytest.mark.parametrize(
    "make",
    [
        lambda: packing.grid(SOLID, np.arange(20) % 5, (0, 7, 0, 7, 0, 12), 0.1, jitter=1.0),
        lambda: packing.grid(
            FLAT, np.arange(9) % 5, (0, 7, 0, 9), 0.1, 0.5, sizes=Sizes.uniform(0.5, 1)
        ),
        lambda: packing.deposited(SOLID, np.arange(10) % 5, (0, 4, 0, 4, 0, 12), 0.1, trials=8),
        lambda: packing.deposited(
            FLAT,
            np.arange(10) % 5,
            packing.Container([0, 0], [6, 20], (True, False)),
            0.1,
            trials=20,
        ),
        lambda: packing.layered(
            FLAT,
            [
                packing.Layer(4.0, [0, 1, 2]),
                packing.Layer(5.0, fraction=0.2, shares=[0, 0, 0, 1, 0]),
            ],
            (0, 10, 0, 9),
            0.1,
        ),
        lambda: packing.layered(
            SOLID,
            [packing.Layer(3.0, [0, 1]), packing.Layer(4.0, [2, 3, 4])],
            (0, 5, 0, 5, 0, 7),
            0.1,
        ),
    ],
    ids=["grid 3D", "grid sizes", "deposited 3D", "deposited periodic", "layered", "layered 3D"],
)
def test_other_packings_never_overlap(make):
    made = make()
    assert_apart(made, 0.1)
    assert (make().position == made.position).all()


def test_layers_keep_their_grains():
    made = packing.layered(
        FLAT,
        [packing.Layer(4.0, [0, 1, 2]), packing.Layer(5.0, fraction=0.2, shares=[0, 0, 0, 1, 0])],
        (0, 10, 0, 9),
        0.1,
    )
    assert made.kind[:3].tolist() == [0, 1, 2] and (made.kind[3:] == 3).all() and len(made) > 6
    assert (made.position[:3, 1] < 4.0).all() and (made.position[3:, 1] > 4.0).all()


def test_grains_fill_the_hole_of_a_drum():
    wall = shapes.annulus(5.0, 6.0, (1.5, 0.6))
    made = packing.fill(
        FLAT, 0.25, packing.container_inside(wall), 0.1, sizes=Sizes.uniform(0.4, 0.7)
    )
    for i in range(len(made)):
        assert wall.distance(made.outline(i)) >= 0.1 * (1.0 - 1e-9)
        assert np.hypot(*made.position[i]) < 5.0
    # the fin takes some of the circle's area
    assert made.container.measure == pytest.approx(wall.holes[0].area)
    assert made.container.measure < np.pi * 25.0 - 0.8
    assert made.fraction == pytest.approx(0.25, abs=0.5 * np.pi * 0.49 / 70.0)


def test_sizes_are_drawn_as_asked():
    random = np.random.default_rng(1)
    n = 20_000
    # means and deviations of n draws are off by 1/sqrt(n) of the deviation: four of these
    off = 4.0 / np.sqrt(n)
    drawn = Sizes.uniform(0.5, 1.5).draw(n, random)
    assert drawn.mean() == pytest.approx(1.0, abs=off * 0.29) and np.ptp(drawn) < 1.0
    drawn = Sizes.normal(2.0, 0.1).draw(n, random)
    assert (drawn.mean(), drawn.std()) == (
        pytest.approx(2.0, abs=off * 0.1),
        pytest.approx(0.1, abs=off * 0.1),
    )
    drawn = Sizes.lognormal(2.0, 0.3).draw(n, random)
    assert np.log(drawn).mean() == pytest.approx(np.log(2.0), abs=off * 0.3)
    assert np.log(drawn).std() == pytest.approx(0.3, abs=off * 0.3)
    cut = Sizes.normal(1.0, 0.5, 0.8, 1.1).draw(n, random)
    assert cut.min() >= 0.8 and cut.max() <= 1.1
    drawn = Sizes.table([1.0, 2.0], [3.0, 1.0]).draw(n, random)
    assert (drawn == 1.0).mean() == pytest.approx(0.75, abs=off * 0.44)
    assert set(drawn) == {1.0, 2.0}


def test_random_orientations_in_space_have_no_direction():
    made = packing.grid([shapes.sphere(0.1)], np.zeros(2000, int), (0, 9, 0, 9, 0, 9), 0.1)
    turned = Rotation.from_rotvec(made.angle).apply([0.0, 0.0, 1.0])
    # each component has the mean 0 and the variance 1/3; four deviations of 2000 draws
    assert np.abs(turned.mean(axis=0)).max() < 4.0 * np.sqrt(1.0 / 3.0 / 2000)
    assert np.abs((turned**2).mean(axis=0) - 1.0 / 3.0).max() < 4.0 * 0.3 / np.sqrt(2000)


# ---- settled by gravity --------------------------------------------------------------------------


def test_rigid_motion_is_found_again():
    random = np.random.default_rng(1)
    for d in (2, 3):
        points = random.normal(size=(9, d))
        turn = np.linalg.qr(random.normal(size=(d, d)))[0]
        turn[:, 0] *= np.linalg.det(turn)
        found, shift = settle.rigid_motion(points, points @ turn.T + 2.0)
        # rounding of sums over the points, of order 1
        assert found == pytest.approx(turn, abs=1e-14) and shift == pytest.approx(2.0, abs=1e-13)


@pytest.mark.seconds
@pytest.mark.parametrize("flat", [True, False], ids=["2D", "3D"])
def test_settled_grains_rest_on_each_other(lmp, flat):
    # lengths of millimetres: the run knows no unit
    kinds = [shapes.hexagon(1e-3), shapes.star(1e-3)] if flat else [shapes.cuboid(1e-3, 1e-3, 1e-3)]
    box = (0, 5e-3, 0, 14e-3) if flat else (0, 3.4e-3, 0, 3.4e-3, 0, 7e-3)
    start = packing.random_sequential(kinds, np.arange(8) % len(kinds), box, 2e-4, attempts=20_000)
    made = packing.settled(start, 2e-4, lmp=lmp)
    assert_apart(made, 2e-4)
    assert made.position[:, -1].mean() < 0.75 * start.position[:, -1].mean()
    # at rest each grain is near the floor or another: contact keeps nodes about 1.2 of the spacing
    # apart, and shapes at most so far
    for i in range(len(made)):
        others = [made.outline(i).distance(made.outline(j)) for j in range(len(made)) if j != i]
        assert min(*others, made.container.gap(made.outline(i))) < 1.5 * 2e-4
    # what it stands for: the clouds placed there keep their distance too
    clouds = [cloud.mesh(shape, 2e-4) for shape in kinds]
    nodes = [
        clouds[k].placed(p, a, s).nodes
        for k, p, a, s in zip(made.kind, made.position, made.angle, made.scale, strict=True)
    ]
    for i in range(len(made)):
        rest = np.vstack([n for j, n in enumerate(nodes) if j != i])
        assert cKDTree(rest).query(nodes[i])[0].min() >= 2e-4 * (1.0 - 1e-9)


@pytest.mark.seconds
@pytest.mark.parametrize("flat", [True, False])
def test_dropped_grains_keep_their_gap_and_only_sink(flat):
    kinds = FLAT if flat else SOLID
    box = (0, 9, 0, 40) if flat else (0, 6, 0, 6, 0, 30)
    # as many concave ones as others, thrown in anyhow
    start = packing.random_sequential(kinds, np.arange(15) % 5, box, 0.2, attempts=20_000)
    made = packing.dropped(start, 0.2)
    assert_apart(made, 0.2 * (1.0 - 1e-9))
    sunk = start.position - made.position
    assert (sunk[:, :-1] == 0.0).all() and (sunk[:, -1] >= 0.0).all()
    assert sunk[:, -1].mean() > 2.0
    assert (made.angle == start.angle).all() and (made.scale == start.scale).all()
    # each lies above the floor or another grain, to a thousandth of the gap
    for i in range(len(made)):
        mine = made.outline(i)
        others = [mine.distance(made.outline(j)) for j in range(len(made)) if j != i]
        floor = mine.extent[0][-1] - made.container.low[-1]
        assert min(*others, floor) <= 0.2 * 1.0011


def test_dropping_needs_a_floor_and_room():
    with pytest.raises(ValueError, match="a packing in a box with a floor"):
        packing.dropped(packing.table([shapes.circle(1.0)], [(0, 0, 0, 1, 0)], 0.1), 0.1)


@pytest.mark.seconds
def test_settling_does_not_simulate_the_fall(lmp, monkeypatch):
    """A box seven times as high costs no more steps, but for those of chance."""
    steps = []
    from peridem import run

    plain = run.run
    monkeypatch.setattr(run, "run", lambda *a, **k: steps.append(plain(*a, **k).steps))
    kinds = [shapes.hexagon(1e-3), shapes.star(1e-3)]
    for high in (14e-3, 100e-3):
        box = (0, 5e-3, 0, high)
        start = packing.random_sequential(kinds, np.arange(8) % 2, box, 2e-4, attempts=20_000)
        packing.settled(start, 2e-4, lmp=lmp)
    # twice the steps would be half of what falling through seven times the height takes
    assert steps[1] < 2 * steps[0]


def test_grains_that_start_closer_than_they_rest_are_not_blown_apart(lmp):
    """Nodes that stand for touching shapes overlap at the start: that is no energy to fly with."""
    disc = shapes.circle(1e-3)
    pitch = 2e-3 + 2.0001e-4  # shapes a padding apart; nodes want up to 1.2 of it
    places = [(1.2e-3 + pitch * i, 1.2e-3 + pitch * j) for i in range(3) for j in range(3)]
    box = (0, 3 * pitch + 6e-4, 0, 20e-3)  # some room at the right
    start = packing.table([disc], [(0, x, y, 1, 0) for x, y in places], 2e-4, box)
    made = packing.settled(start, 2e-4, lmp=lmp)
    # they take the room at the right, and what their nodes lack: less than a padding for three
    moved = np.abs(made.position - start.position)
    assert moved[:, 0].max() < 4e-4 + 2e-4 and moved[:, 1].max() < 2e-4


def test_overlapping_grains_do_not_settle():
    start = packing.Packing(
        (shapes.circle(1e-3),),
        np.zeros(2, dtype=np.int64),
        np.array([[2e-3, 2e-3], [3e-3, 2e-3]]),
        np.zeros(2),
        np.ones(2),
        placing.container((0, 5e-3, 0, 5e-3)),
    )
    with pytest.raises(ValueError, match="grains that are apart from each other needed"):
        packing.settled(start, 2e-4)


def test_settling_needs_a_box_with_a_floor():
    round_box = packing.container_inside(shapes.circle(5.0))
    made = packing.random_sequential(FLAT, [0], round_box, 0.1)
    with pytest.raises(ValueError, match="box with a floor"):
        packing.settled(made, 0.1)
    made = packing.random_sequential(FLAT, [0], (0, 5, 0, 5), 0.1)
    with pytest.raises(ValueError, match="friction"):
        packing.settled(made, 0.1, friction=-1.0)


def test_table_in_space():
    rows = [(1, 2, 2, 2, 1.0, 0, 0, 0.5), (0, 5, 2, 2, 0.5, 0, 0, 0)]
    made = packing.table(SOLID, rows, 0.1, (0, 8, 0, 4, 0, 4))
    assert made.angle.tolist() == [[0, 0, 0.5], [0, 0, 0]]
    assert made.area == pytest.approx((2.0 / 3.0**0.5) ** 3 + 4.0 / 3.0 * np.pi / 8.0)


def test_area_counts_scale():
    rows = [(0, 2.0, 3.0, 1.0, 0.0), (0, 7.0, 3.0, 2.0, 0.0)]
    made = packing.table(OUTLINES, rows, PADDING, BOX)
    # rounding: circles are exact
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
        (lambda: packing.table(SOLID, [(0, 1, 1, 1, 0)], PADDING), "kind x y z scale ax ay az"),
        (lambda: packing.grid(OUTLINES, [0], (0, 1, 0), PADDING), "x_low"),
        (lambda: packing.grid(OUTLINES, [0], (0, 9, 0, 9, 0, 9), PADDING), "two and of three"),
        (lambda: packing.fill(OUTLINES, 0.9, BOX, PADDING, attempts=50), r"fill \d+% of the box"),
        (lambda: packing.fill(OUTLINES, 1.5, BOX, PADDING), "between 0 and 1"),
        (lambda: packing.fill(OUTLINES, 1e-4, BOX, PADDING), "no grain is small enough"),
        (lambda: packing.fill(OUTLINES, 0.2, BOX, PADDING, shares=[1.0]), "a share for each of 8"),
        (lambda: packing.grid(OUTLINES, [0], BOX, PADDING, orientation="up"), "'random', 'fixed'"),
        (lambda: packing.random_sequential(OUTLINES, [0], BOX, PADDING, sizes=[-1.0]), "above 0"),
        (
            lambda: packing.random_sequential(
                OUTLINES, [0], packing.Container([0, 0], [1.9, 9], (True, False)), PADDING
            ),
            "meets itself across the periodic side x",
        ),
        (lambda: packing.layered(OUTLINES, [packing.Layer(13.0, [0])], BOX, PADDING), "12 high"),
        (
            lambda: packing.layered(OUTLINES, [packing.Layer(2.0, [0, 1])], BOX, PADDING),
            "layer 1: random sequential",
        ),
        (
            lambda: packing.deposited(
                OUTLINES, [0], packing.container_inside(shapes.circle(9.0)), PADDING
            ),
            "floor",
        ),
        (
            lambda: packing.Container([0, 0], [9, 9], (True, False), shapes.circle(1.0)),
            "no periodic",
        ),
        (lambda: Sizes.uniform(0.0, 1.0), "above 0"),
        (lambda: Sizes.table([1.0], [0.5, 0.5]), "a share for each"),
        (
            lambda: Sizes.normal(1.0, 0.01, 5.0, 6.0).draw(1, np.random.default_rng(1)),
            "hardly ever",
        ),
        (lambda: packing.grid(OUTLINES, [0], (1.0, 0.0, 0.0, 1.0), PADDING), "x_low"),
        (lambda: packing.grid(OUTLINES, [8], BOX, PADDING), "kinds"),
    ],
)
def test_bad_packings_are_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()
