"""Walls that are regions: where they are at a time, and in pictures."""

import json
import math
import subprocess

import numpy as np
import pytest
import scenes
from matplotlib import image
from peridem import render, results, scene
from peridem.regions import (
    Block,
    Combined,
    Cone,
    Cylinder,
    OtherRegion,
    Prism,
    Rotation,
    Sphere,
    described_region,
)
from peridem.scene import DUMP, NODE_COLUMNS

DRUM = Combined((Cylinder((1e-3, 2e-3), 5e-3), Block((4e-3, 1.9e-3), (7e-3, 2.1e-3), inside=False)))


@pytest.mark.parametrize(
    "region",
    [
        DRUM,
        Block((0.0, 0.0, 0.0), (1.0, 2.0, 3.0), open=(6,)),
        Cylinder((0.0, 0.5), 1.0, "y", low=0.0, inside=False),
        Sphere((0.0, 0.0, 0.0), 2.0),
        Prism((0.0, 0.0), (1.0, 2.0), (0.5,)),
        Prism((0.0, 0.0, 0.0), (1.0, 2.0, 3.0), (0.5, 0.1, -0.2), inside=False, open=(6,)),
        Cone((0.0, 0.0), (1e-3, 3e-3), 0.0, 5e-3, open=(2,)),
        OtherRegion("ellipsoid 0 0 0 1e-3 2e-3 3e-3", inside=False),
    ],
)
def test_a_region_comes_back_from_its_description(region):
    assert described_region(json.loads(json.dumps(region.described()))) == region


def test_unknown_kinds_of_regions_are_refused():
    with pytest.raises(
        ValueError, match="no region of kind 'Ball': one of Block, Prism, Cone, Cylinder"
    ):
        described_region({"kind": "Ball"})


def written(folder, wall):
    """A folder with two grains, one frame and a wall that is a region."""
    made = scene.Scene(
        title="regions",
        grains=scenes.two_grains().grains,
        contact=scenes.two_grains().contact,
        walls=[wall],
        duration=1e-3,
    )
    made.write(folder)
    columns = "id mol type x y vx vy " + " ".join(f"c_node[{i}]" for i in range(1, 6))
    rows, grain = [], made.grain_of_node
    for node, x in enumerate(made.reference):
        rows.append([node + 1, grain[node], 1, *x, 0, 0, *[0] * len(NODE_COLUMNS)])
    scenes.write_dump(folder / DUMP, [(0, rows)], columns)
    return folder


def test_a_turning_drum_is_where_its_angle_says(tmp_path):
    turn = Rotation(-20.0, (1e-3, 2e-3))
    output = results.Output(written(tmp_path, scene.RegionWall("shell", DRUM, rotation=turn)))
    quarter = 0.5 * math.pi / 20.0
    [placed] = output.regions(quarter)
    # the fin was at the right of the centre (1, 2) mm; clockwise by a quarter it is below
    right, below = np.array([[5e-3, 2e-3]]), np.array([[1e-3, -2e-3]])
    assert placed.contains(right) and not placed.contains(below)
    [start] = output.regions(0.0)
    assert not start.contains(right) and start.contains(below)
    # a picture holds the circle, at any angle (to the sag of a side of the polygon of 48 around it)
    for at in (output.regions(0.1 * quarter)[0], placed):
        assert at.corners.min(axis=0) == pytest.approx([-4e-3, -3e-3], abs=2.2e-5)


def test_a_moving_region_is_where_its_velocity_says(tmp_path):
    wall = scene.RegionWall("cup", Cylinder((1e-3, 2e-3), 5e-3), velocity=(0.0, -2.0))
    [placed] = results.Output(written(tmp_path, wall)).regions(1e-3)
    inside = placed.contains(np.array([[1e-3, 4.9e-3], [1e-3, 5.1e-3], [1e-3, -4.9e-3]]))
    assert inside.tolist() == [True, False, True]


def test_pictures_show_what_is_outside_of_a_region(tmp_path):
    folder = written(tmp_path, scene.RegionWall("shell", DRUM))
    output = results.Output(folder)
    pixels = image.imread(render.grains_png(folder, tmp_path / "drum.png", frames=[0]))[..., :3]
    wanted = np.array([int(render.WALL[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    part = (np.abs(pixels - wanted).max(axis=2) < 2.5 / 255).mean()
    # of the square around the circle and its margin, the part outside of circle and fin
    side = 10e-3 + 6.0 * output.contact_radius
    expected = 1.0 - (math.pi * 25e-6 - 2e-3 * 0.2e-3) / side**2
    # the square fills all of the picture but title and scale, which are a tenth or so
    assert 0.75 * expected < part < expected


def test_shapes_and_motions_that_only_lammps_knows_are_not_drawn(tmp_path):
    wall = scene.RegionWall("cone", OtherRegion("block -1 1 -1 1 INF INF"))
    assert results.Output(written(tmp_path, wall)).regions(0.0) == []
    follows = scene.RegionWall("cup", Cylinder((1e-3, 2e-3), 5e-3), displacement=(None, "time"))
    assert not follows.drawable


@pytest.mark.parametrize("dimension", [2, 3])
def test_regions_hold_what_lammps_says(dimension, tmp_path, lmp):
    """Each shape, of both sides, against the groups that LAMMPS makes of random points."""
    flat = [
        Block((-1.0, -0.5), (0.5, 1.0)),
        Prism((-1.0, -0.7), (0.3, 0.9), (0.8,)),
        Prism((-1.0, -0.7), (0.3, 0.9), (-0.8,), inside=False),
        Cylinder((0.2, 0.1), 0.9),
        Combined((Block((-1.0, -1.0), (0.0, 1.0)), Cylinder((0.2, 0.1), 0.9)), "union"),
    ]
    space = [
        Prism((-1.0, -0.7, -0.8), (0.3, 0.9, 0.7), (0.8, -0.3, 0.4)),
        Prism((-1.0, -0.7, -0.8), (0.3, 0.9, 0.7), (0.8, -0.3, 0.4), inside=False),
        Cone((0.1, -0.2), (0.2, 1.1), -0.9, 0.8),
        Cone((0.1, -0.2), (1.1, 0.0), -0.9, 0.8, axis="x", inside=False),
        Cone((0.1, -0.2), (0.7, 0.3), -0.9, 0.8, axis="y"),
        Cylinder((0.2, 0.1), 0.9, "x", -0.5, 0.7),
        Sphere((0.1, 0.2, 0.3), 0.9),
    ]
    regions = flat if dimension == 2 else space
    x = np.random.default_rng(5).uniform(-1.2, 1.2, (2000, 3))
    x[:, dimension:] = 0.0
    rows = [f"{i} 1 {a:.15g} {b:.15g} {c:.15g}" for i, (a, b, c) in enumerate(x, 1)]
    sides = "".join(f"-1.5 1.5 {k}lo {k}hi\n" for k in "xyz")
    head = f"points\n\n{len(x)} atoms\n1 atom types\n\n{sides}\nAtoms # atomic\n\n"
    (tmp_path / "points.data").write_text(head + "\n".join(rows) + "\n")
    script = [f"dimension {dimension}", "boundary p p p", "atom_style atomic"]
    script += ["read_data points.data", "mass 1 1.0"]
    for k, region in enumerate(regions):
        script += region.commands(f"r{k}")
        script += [f"group g{k} region r{k}", f"write_dump g{k} custom {k}.dump id"]
    (tmp_path / "in.points").write_text("\n".join(script) + "\n")
    done = subprocess.run(
        [lmp, "-in", "in.points", "-screen", "none"], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, (tmp_path / "log.lammps").read_text()[-500:]
    for k, region in enumerate(regions):
        held = set((np.flatnonzero(region.contains(x[:, :dimension])) + 1).tolist())
        lines = (tmp_path / f"{k}.dump").read_text().splitlines()[9:]
        assert held == {int(line) for line in lines}, region
        assert 50 < len(held) < 1950  # the points tell the shape
