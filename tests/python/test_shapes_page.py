"""The manual's page of shapes and packings: its blocks run, and it names what there is."""

import math
import re
import textwrap
from pathlib import Path

import pytest
from peridem import cloud, packing, shapes

PAGE = (Path(__file__).resolve().parents[2] / "doc" / "shapes.rst").read_text()


def test_every_block_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"code-block:: python\n\n((?:   .*\n|\n)+)", PAGE)
    assert len(blocks) == 3
    names: dict[str, object] = {}
    for block in blocks:
        exec(textwrap.dedent(block), names)
    # what the page makes is what it says
    assert names["loose"].smallest_gap()[0] >= 2e-4 * (1.0 - 1e-9)
    assert abs(names["loose"].fraction - 0.3) < 0.02  # half a grain of a box for sixty
    assert len(names["again"].nodes) == len(names["grain"].nodes)
    assert len(capsys.readouterr().out.splitlines()) >= 2


def test_every_shape_and_packing_is_named():
    makers = [n for n in packing.__all__ if n[0].islower() and n != "container_inside"]
    for name in [*shapes.NAMED, "polygon", "polyhedron", "stl", "regular_polygon", *makers]:
        assert f"``{name}``" in PAGE, name


def test_meshes_fall_short_by_what_the_page_says():
    disc, ball = re.findall(r"\(([\d.]+) % for a disc .* ([\d.]+) % for a ball", PAGE)[0]
    short = 1.0 - cloud.mesh(shapes.circle(1.0), 2.0 * math.pi / 30.0).measure / math.pi
    assert short == pytest.approx(float(disc) / 100.0, abs=5e-4)  # one decimal is said
    short = 1.0 - cloud.mesh(shapes.sphere(1.0), 0.25).measure / (4.0 / 3.0 * math.pi)
    # other versions of gmsh mesh the surface otherwise: some per cent of its nodes
    assert short == pytest.approx(float(ball) / 100.0, rel=0.1)


def test_distances_are_too_small_by_what_the_page_says():
    said = re.findall(r"too small by up to ([\d.]+) %, ([\d.]+) % and ([\d.]+) %", PAGE)[0]
    circle, cylinder, _ = (float(one) / 100.0 for one in said)
    # polygons around a circle reach 1/cos(pi/n) of it; one digit is said
    assert 1.0 / math.cos(math.pi / 240) - 1.0 == pytest.approx(circle, rel=0.1)
    assert 1.0 / math.cos(math.pi / 32) - 1.0 == pytest.approx(cylinder, rel=0.1)
    # a ball of the corners of an ellipsoid: the reach of its polyhedron over its radius
    ball = shapes.ellipsoid(1.0, 1.0, 1.0)
    far = ball.distance(shapes.sphere(1.0).placed((3.0, 0.3, 0.2)))
    true = math.dist((0, 0, 0), (3.0, 0.3, 0.2)) - 2.0
    assert true - 0.008 <= far <= true + 1e-12
