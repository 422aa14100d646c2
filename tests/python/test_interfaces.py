"""Weak interfaces inside grains: what a scene says of them, and what results make of it."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from peridem import cloud, scene, shapes
from peridem.material import Contact, Interface, Material
from peridem.results import Output

LEFT = Material(bulk=2e7, poisson=0.25, density=1000.0, horizon=0.35e-3, gc=8.0, name="left")
RIGHT = replace(LEFT, name="right")


def two_halves(interface):
    """A square whose halves are of two materials."""
    square = cloud.mesh(shapes.rectangle(2e-3, 2e-3), 0.2e-3)
    grain = scene.Grain(square, LEFT, ((square.nodes[:, 0] > 0.0, RIGHT),))
    return scene.Scene("halves", [grain], Contact(), 1e-5, interfaces=[interface])


def test_a_summary_has_the_critical_stretch_of_an_interface():
    given = two_halves(Interface(("left", "right"), "s0 0.004"))._summary()["interfaces"]
    assert given == [(1, 2, 0.004)]
    # Gc of a sixteenth: a quarter of the stretch, which goes with its root; exact but for rounding
    [(_, _, stretch)] = two_halves(Interface(("right", "left"), "gc 0.5"))._summary()["interfaces"]
    assert stretch == pytest.approx(LEFT.critical_stretch(2) / 4.0, rel=1e-12)


def test_an_interface_with_moduli_of_its_own_is_left_out():
    own = Interface(("left", "right"), "gc 0.5 bulk 1e7 poisson 0.25")
    assert own.critical_stretch(LEFT, RIGHT, 2) is None
    stiffer = replace(RIGHT, bulk=4e7)
    assert Interface(("left", "right"), "gc 0.5").critical_stretch(LEFT, stiffer, 2) is None


def test_materials_that_cannot_be_mixed_need_an_interface_in_a_grain_only():
    """The pair is written where no grain is of both, and asked for where one is."""
    square = cloud.mesh(shapes.rectangle(2e-3, 2e-3), 0.2e-3)
    other = replace(RIGHT, influence="constant")
    apart = [scene.Grain(square, LEFT), scene.Grain(square.moved((3e-3, 0.0)), other)]
    text = scene.Scene("apart", apart, Contact(), 1e-5).script()
    assert f"pair_coeff      1 2 peridem/lps {LEFT.pair_coeff(2)}" in text
    alike = [scene.Grain(square, LEFT), scene.Grain(square.moved((3e-3, 0.0)), RIGHT)]
    assert "1 2 peridem/lps" not in scene.Scene("alike", alike, Contact(), 1e-5).script()
    both = scene.Grain(square, LEFT, ((square.nodes[:, 0] > 0.0, other),))
    with pytest.raises(ValueError, match="grain 1 is of 'left' and 'right', which differ in infl"):
        scene.Scene("both", [both], Contact(), 1e-5)
    words = "bulk 2e7 poisson 0.25 horizon 0.35e-3 gc 1 influence constant"
    said = scene.Scene(
        "said", [both], Contact(), 1e-5, interfaces=[Interface(("left", "right"), words)]
    )
    assert said.script().count("pair_coeff      1 2 peridem/lps") == 1


def test_materials_of_two_planes_are_refused():
    square = cloud.mesh(shapes.rectangle(2e-3, 2e-3), 0.2e-3)
    flat = replace(RIGHT, plane="stress")
    grains = [scene.Grain(square, LEFT), scene.Grain(square.moved((3e-3, 0.0)), flat)]
    with pytest.raises(ValueError, match="same plane, not strain of 'left', stress of 'right'"):
        scene.Scene("two planes", grains, Contact(), 1e-5)


def test_sides_of_cells_across_an_interface_break_at_its_stretch(tmp_path):
    """A frame stretched by 1 % along x: between 0.4 % of the interface and 2 % of the halves."""
    made = two_halves(Interface(("left", "right"), "s0 0.004"))
    made.write(tmp_path)
    assert 0.012 < LEFT.critical_stretch(2) < math.inf
    kind = made.type_of_node
    lines = []
    for step, stretch in ((0, 0.0), (10, 0.01)):
        lines += ["ITEM: TIMESTEP", str(step), "ITEM: NUMBER OF ATOMS", str(len(kind))]
        lines += ["ITEM: BOX BOUNDS ff ff pp", "-1 1", "-1 1", "-0.5 0.5"]
        lines += ["ITEM: ATOMS id mol type x y vx vy"]
        for k, (x, y) in enumerate(made.reference, 1):
            lines.append(f"{k} 1 {kind[k - 1]} {x * (1.0 + stretch):.12g} {y:.12g} 0 0")
    (tmp_path / scene.DUMP).write_text("\n".join(lines) + "\n")
    output = Output(tmp_path)
    across = kind[output.edges[:, 0]] != kind[output.edges[:, 1]]
    # a stretch along x of 1 % stretches a side by 1 % of the square of its direction's cosine
    side = output.reference[output.edges[:, 1]] - output.reference[output.edges[:, 0]]
    along = side[:, 0] ** 2 / (side**2).sum(axis=1)
    wanted = across & (0.01 * along > 0.0041)
    assert wanted.sum() > 5
    broken = output.broken_edges(1)
    assert broken[wanted].all()
    assert not broken[~across].any()
    assert not output.broken_edges(0).any()
    assert json.loads((tmp_path / scene.SUMMARY).read_text())["interfaces"] == [[1, 2, 0.004]]
    assert np.array_equal(np.unique(kind), [1, 2])
