"""Every region style as a wall, inside and outside, against nearest points found by hand.

Spheres, cylinders and blocks are in ``test_wall_region.py``.  LAMMPS itself lets the ends of cones
along y push along z, finds no outside of cones that end in a point, none of ellipsoids in 2D whose
third axis is short, and misses ellipsoids near the cutoff.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from support.clouds import cloud
from support.oracle import Array

SPRING, RADIUS = 5.0, 1.0
ACCURACY = 1e-10  # rounding of gaps of 1e-3 and more at coordinates of order 10, times the spring
MOTION = (
    "variable turn equal 0.7\nvariable way equal 0.4\n",
    "move v_way NULL NULL rotate v_turn 1 2 0 0 3 4",
)


def forces(simulation, x: Array, region: str, dimension: int = 3, before: str = "") -> Array:
    one = cloud(x, molecule=np.arange(len(x)) + 1, dimension=dimension, margin=30)
    sim = simulation().load(one, dimension=dimension)
    sim.commands(
        f"""
        pair_style zero 2.0
        pair_coeff * *
        {before}
        region shape {region} units box
        fix wall all peridem/wall region shape radius {RADIUS} stiffness {SPRING}
        run 0 post no
        """
    )
    return sim.atoms("f")


def pushes(x: Array, nearest: Array) -> Array:
    """Of a face with these nearest points; a face that is not there has nan."""
    away = x - nearest
    gap = np.linalg.norm(away, axis=1)[:, None]
    return np.nan_to_num(SPRING * np.maximum(RADIUS - gap, 0.0) * away / gap)


def moved(x: Array) -> Array:
    """Where ``MOTION`` takes points: turned about an axis by Rodrigues' formula, then shifted."""
    axis, point = np.array([0, 0.6, 0.8]), np.array([1.0, 2.0, 0.0])
    d, c, s = x - point, np.cos(0.7), np.sin(0.7)
    turned = c * d + s * np.cross(axis, d) + (1 - c) * (d @ axis)[:, None] * axis
    return turned + point + np.array([0.4, 0, 0])


# --- cones ---------------------------------------------------------------------------------------

LOW, HIGH, CENTRE = -3.0, 4.0, (0.5, -0.3)
CONES = [(5.0, 2.0), (2.0, 5.0), (0.0, 4.0), (4.0, 0.0), (3.0, 3.0)]


def on_segment(p: Array, start: Array, end: Array) -> Array:
    along = np.clip((p - start) @ (end - start) / ((end - start) @ (end - start)), 0, 1)
    return start + along[:, None] * (end - start)


class Cone:
    """In the half plane of axis and point: distance from the axis, and height."""

    def __init__(self, axis: int, radii: tuple[float, float], x: Array) -> None:
        self.axis, self.radii = axis, radii
        self.others = [m for m in range(3) if m != axis]
        d = x[:, self.others] - CENTRE
        r = np.linalg.norm(d, axis=1)
        self.way = d / r[:, None]
        self.flat = np.column_stack([r, x[:, axis]])
        radius = np.interp(x[:, axis], [LOW, HIGH], radii)
        self.inside = (abs(x[:, axis] - 0.5) < 3.5) & (r < radius)

    def mantle(self) -> Array:
        low, high = np.array([self.radii[0], LOW]), np.array([self.radii[1], HIGH])
        return self.space(on_segment(self.flat, low, high))

    def end(self, k: int, whole: bool = False) -> Array:
        """An end; ``whole``: the plane that it lies in."""
        if self.radii[k] == 0.0:
            return np.full((len(self.way), 3), np.nan)
        h = (LOW, HIGH)[k]
        far = 100.0 if whole else self.radii[k]
        return self.space(on_segment(self.flat, np.array([0.0, h]), np.array([far, h])))

    def space(self, flat: Array) -> Array:
        x = np.empty((len(flat), 3))
        x[:, self.axis] = flat[:, 1]
        x[:, self.others] = CENTRE + self.way * flat[:, :1]
        return x


@pytest.mark.parametrize("motion", [False, True], ids=["still", "moved"])
@pytest.mark.parametrize("side", ["in", "out"])
@pytest.mark.parametrize("axis", [0, 1, 2], ids=["x", "y", "z"])
def test_cone(axis, side, motion, simulation, rng):
    before, words = MOTION if motion else ("", "")
    for radii in CONES:
        x = rng.uniform(-7, 7, (1500, 3))
        cone = Cone(axis, radii, x)
        faces = [cone.mantle(), cone.end(0, side == "in"), cone.end(1, side == "in")]
        gaps = np.nan_to_num([np.linalg.norm(x - face, axis=1) for face in faces], nan=np.inf)
        if side == "in":  # each face by itself
            expected = sum(pushes(x, face) for face in faces)
        else:  # the nearest
            nearest = np.choose(np.argmin(gaps, axis=0)[:, None], faces)
            expected = pushes(x, nearest)
        which = (cone.inside == (side == "in")) & (gaps.min(axis=0) > 1e-3)
        assert np.count_nonzero(np.any(expected[which] != 0, axis=1)) > 20
        there = moved(x[which]) if motion else x[which]
        expected = moved(expected[which]) - moved(np.zeros((1, 3))) if motion else expected[which]
        shape = f"cone {'xyz'[axis]} {CENTRE[0]} {CENTRE[1]} {radii[0]} {radii[1]} {LOW} {HIGH}"
        got = forces(simulation, there, f"{shape} side {side} {words}", before=before)
        np.testing.assert_allclose(got, expected, rtol=0, atol=ACCURACY)


def test_a_node_on_the_axis_of_a_funnel_does_not_fall_through_its_tip(simulation):
    """All directions are as near there; one of them must count."""
    got = forces(simulation, np.array([[0, 0.5, 0]]), "cone y 0 0 0 10 0 10")[0]
    foot = 0.5 / np.sqrt(2)
    assert np.linalg.norm(got) == pytest.approx(SPRING * (RADIUS - foot), rel=1e-12)
    assert got[1] == pytest.approx(SPRING * (RADIUS - foot) / np.sqrt(2), rel=1e-12)


def test_open_faces_of_a_cone_do_not_push(simulation):
    x = np.array([[0.5, 0.4, 0.2], [0.4, 9.7, 0.1], [0.2, -0.4, 0.3], [6.0, 2.0, 0.0]])
    got = forces(simulation, x, "cone y 0 0 5 5 0 10 open 1 open 3")
    np.testing.assert_allclose(got, SPRING * np.array([[0, 0, 0], [0, -0.7, 0]] + [[0] * 3] * 2))


# --- ellipsoids ----------------------------------------------------------------------------------


def on_ellipsoid(axes: Array, dimension: int) -> Array:
    """Many points of it."""
    angle = np.linspace(0, 2 * np.pi, 4001 if dimension == 2 else 241)
    if dimension == 2:
        return axes * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    height, angle = np.meshgrid(np.linspace(0, np.pi, 121), angle)
    height, angle = height.ravel(), angle.ravel()
    unit = [np.sin(height) * np.cos(angle), np.sin(height) * np.sin(angle), np.cos(height)]
    return axes * np.column_stack(unit)


@pytest.mark.parametrize("side", ["in", "out"])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(
    "axes", [(6, 5, 4), (2.5, 5, 5), (5, 5, 2), (6, 5, 0.5), (4, 4, 4)], ids=lambda axes: str(axes)
)
def test_ellipsoid(axes, dimension, side, simulation, rng):
    """The force points from a place of the ellipsoid, along its normal, and none is nearer."""
    axes, centre = np.array(axes, float), np.array([1.0, 2.0, 0.0])
    x = rng.uniform(-7, 7, (400, 3))
    x[:100, rng.integers(3)] = 0.0  # planes of symmetry
    x[100:110, :2] = 0.0
    if dimension == 2:
        x[:, 2] = 0.0
    size = np.linalg.norm(x / axes, axis=1)
    x = x[(size < 0.99) if side == "in" else (size > 1.01)]
    shape = "ellipsoid 1 2 0 " + " ".join(str(a) for a in axes)
    got = forces(simulation, x + centre, f"{shape} side {side}", dimension)
    push = np.linalg.norm(got, axis=1)
    touch = push > 0.0
    assert np.count_nonzero(touch) > 10  # a thin one holds few
    gap = RADIUS - push[touch] / SPRING
    foot = x[touch] - gap[:, None] * got[touch] / push[touch, None]
    np.testing.assert_allclose(np.linalg.norm(foot / axes, axis=1), 1.0, rtol=0, atol=ACCURACY)
    normal = foot / axes**2
    normal *= (-1.0 if side == "in" else 1.0) / np.linalg.norm(normal, axis=1)[:, None]
    np.testing.assert_allclose(got[touch], push[touch, None] * normal, rtol=0, atol=1e-8)
    surface = on_ellipsoid(axes, dimension)
    closest = np.array([np.linalg.norm(surface - p, axis=1).min() for p in x])
    # places are up to 0.16 apart in 3D: 0.16^2/8 of the distance beside the nearest one, over it
    missed = 1e-4 if dimension == 2 else 0.02
    assert np.all(closest[touch] > gap - ACCURACY)
    assert np.all(closest[touch] < gap + missed / np.minimum(gap, 1.0))
    assert np.all(closest[~touch] > RADIUS - ACCURACY)


def test_nodes_at_the_centre_of_an_ellipsoid_are_pushed_from_its_nearest_pole(simulation):
    got = forces(simulation, np.zeros((1, 3)), "ellipsoid 0 0 0 3 0.8 2")
    np.testing.assert_allclose(np.abs(got[0]), [0, SPRING * 0.2, 0], rtol=0, atol=ACCURACY)


# --- prisms and planes ---------------------------------------------------------------------------


@pytest.mark.parametrize("side", ["in", "out"])
@pytest.mark.parametrize("tilt", [(0, 0, 0), (-2, 1, 1.5), (3, -2, 2)], ids=lambda tilt: str(tilt))
def test_prism(tilt, side, simulation, rng):
    edges = np.array([[8.0, 0, 0], [tilt[0], 8, 0], [tilt[1], tilt[2], 8]])
    corner = np.array([-4.0, -4, -4])
    normals = np.cross(edges[[1, 2, 0]], edges[[2, 0, 1]])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    x = rng.uniform(-7, 7, (900, 3))
    low = (x - corner) @ normals.T
    gaps = np.hstack([low, np.sum(edges * normals, axis=1) - low])
    if side == "in":
        x, gaps = x[np.all(gaps > 0.01, axis=1)], gaps[np.all(gaps > 0.01, axis=1)]
        expected = SPRING * np.maximum(RADIUS - gaps, 0.0) @ np.vstack([normals, -normals])
    else:
        x = x[np.any(gaps < -0.01, axis=1) & np.all(gaps > -RADIUS, axis=1)][:60]
        inside = [lsq_linear(edges.T, p - corner, bounds=(0, 1), tol=1e-14).x for p in x]
        expected = pushes(x, corner + np.array(inside) @ edges)
    got = forces(simulation, x, f"prism -4 4 -4 4 -4 4 {tilt[0]} {tilt[1]} {tilt[2]} side {side}")
    # outside, nearest points are those of an iteration that ends at 1e-8 or so
    np.testing.assert_allclose(got, expected, rtol=0, atol=ACCURACY if side == "in" else 1e-6)
    assert np.count_nonzero(np.any(got != 0, axis=1)) > 20


@pytest.mark.parametrize("side", ["in", "out"])
def test_plane(side, simulation, rng):
    """A plane as a region may move and rotate; grains are where its normal points."""
    normal = np.array([1, 2, -1]) / np.sqrt(6)
    x = rng.uniform(-7, 7, (400, 3))
    gap = (x - (1, 0, 1)) @ normal * (1 if side == "in" else -1)
    x, gap = x[gap > 0.01], gap[gap > 0.01]
    push = SPRING * np.maximum(RADIUS - gap, 0.0) * (1 if side == "in" else -1)
    got = forces(simulation, x, f"plane 1 0 1 1 2 -1 side {side}")
    np.testing.assert_allclose(got, push[:, None] * normal, rtol=0, atol=ACCURACY)
    assert np.count_nonzero(push) > 20
