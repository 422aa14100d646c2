"""Clouds: volumes, spacing, surface, repeatability, files, refused meshes."""

import numpy as np
import pytest
from peridem import cloud, shapes

OUTLINES = [shapes.circle(1e-3), shapes.hexagon(1e-3), shapes.triangle(7e-4), shapes.drum(7e-4)]
SPACING = 1.4e-4

# Two triangles of a unit square; node 3 is opposite to node 0.
SQUARE = np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)])
HALVES = np.array([(0, 1, 2), (1, 3, 2)])


@pytest.mark.parametrize("outline", OUTLINES, ids=lambda o: o.name)
def test_lumped_volumes_add_up_to_the_area(outline):
    made = cloud.mesh(outline, SPACING)
    boundary = shapes.polygon(outline.boundary(SPACING))  # for the circle: the polygon inside it
    # sums of a few hundred areas, each rounded
    assert made.volumes.sum() == pytest.approx(boundary.area, rel=1e-12)
    assert made.volumes.min() > 0.0
    # a polygon of n corners has 1 - (2/3) (pi/n)^2 of the circle's area: 0.5 % less for n = 36
    assert made.volumes.sum() == pytest.approx(outline.area, rel=0.01)
    assert made.centroid == pytest.approx(outline.centroid, abs=0.02 * SPACING)


@pytest.mark.parametrize("outline", OUTLINES, ids=lambda o: o.name)
def test_mesh_has_the_spacing_asked_for(outline):
    made = cloud.mesh(outline, SPACING)
    ends = made.nodes[made.edges]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    # gmsh promises a mean size, and no sliver of half the size after smoothing
    assert 0.9 * SPACING < np.median(length) < 1.1 * SPACING
    assert made.spacing > 0.6 * SPACING
    assert length.max() < 1.7 * SPACING


@pytest.mark.parametrize("outline", OUTLINES, ids=lambda o: o.name)
def test_surface_nodes_are_those_on_the_outline(outline):
    made = cloud.mesh(outline, SPACING)
    boundary = outline.boundary(SPACING)
    away = np.sqrt(((made.nodes[:, None] - boundary[None]) ** 2).sum(axis=2)).min(axis=1)
    assert (away[made.surface] < 1e-9 * SPACING).all()
    assert made.surface.sum() == len(boundary)
    assert (away[~made.surface] > 0.4 * SPACING).all()


def test_the_same_mesh_comes_out_each_time():
    one, two = (cloud.mesh(shapes.drum(1e-3), SPACING) for _ in range(2))
    assert (one.nodes == two.nodes).all()
    assert (one.cells == two.cells).all()


def test_cells_are_positively_oriented_and_edges_unique():
    made = cloud.mesh(shapes.circle(1.0), 0.2)
    a, b, c = np.moveaxis(made.nodes[made.cells], 1, 0)
    u, v = b - a, c - a
    assert (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] > 0.0).all()
    # Euler's formula for a disc: nodes - edges + cells = 1
    assert len(made.nodes) - len(made.edges) + len(made.cells) == 1


def test_placing_scales_volumes_with_the_dimension():
    made = cloud.mesh(shapes.hexagon(1.0), 0.3)
    moved = made.placed((2.0, -1.0), 0.3, 2.0)
    assert moved.volumes == pytest.approx(4.0 * made.volumes, rel=1e-15)
    assert moved.spacing == pytest.approx(2.0 * made.spacing, rel=1e-12)
    assert moved.centroid == pytest.approx((2.0, -1.0), abs=1e-12)


def test_tetrahedra_share_their_volume_among_four_nodes():
    unit = cloud.from_cells(np.vstack([np.zeros(3), np.eye(3)]), [(0, 1, 2, 3)])
    assert unit.dimension == 3
    assert unit.volumes == pytest.approx(np.full(4, 1.0 / 24.0), rel=1e-15)
    assert unit.surface.all()


@pytest.mark.parametrize("ending", [".msh", ".vtu"])
def test_a_mesh_file_comes_back(tmp_path, ending, capfd):
    made = cloud.mesh(shapes.triangle(1e-3), 2e-4)
    made.write(tmp_path / f"grain{ending}")
    back = cloud.read(tmp_path / f"grain{ending}")
    assert back.nodes == pytest.approx(made.nodes, rel=1e-12, abs=1e-18)
    assert (back.cells == made.cells).all()
    assert back.name == "grain"
    captured = capfd.readouterr()
    assert captured.out == "" and captured.err == ""


def test_clockwise_meshes_are_turned_round_as_a_whole():
    made = cloud.from_cells(SQUARE, HALVES[:, ::-1])
    assert made.volumes.sum() == pytest.approx(1.0)


def test_nodes_without_a_cell_are_left_out_with_a_warning():
    nodes = np.vstack([SQUARE[:1], [(9.0, 9.0)], SQUARE[1:]])
    with pytest.warns(UserWarning, match="node 2 is in no cell"):
        made = cloud.from_cells(nodes, [(0, 2, 3), (2, 4, 3)])
    assert made.nodes == pytest.approx(SQUARE)
    assert (made.cells == HALVES).all()


@pytest.mark.parametrize(
    ("nodes", "cells", "words"),
    [
        (SQUARE, [(0, 1, 2), (1, 3, 2), (2, 0, 1)], "cell 3 is given twice"),
        (np.vstack([SQUARE, [(0.5, 0.0)]]), [*HALVES, (0, 1, 4)], "cell 3 is empty"),
        (
            np.vstack([SQUARE, [(2.0, 0.0)]]),
            [*HALVES, (1, 3, 4)],
            "cell 3 is inverted",
        ),
        ([*SQUARE[:3], (np.nan, 1.0)], HALVES, "node 4 is not finite"),
        (SQUARE, [(0, 1, 4)], "not among the 4"),
        (SQUARE, np.empty((0, 3), dtype=int), "no cells"),
        (SQUARE, [(0, 1, 2, 3)], "d = 2 or 3"),
        (
            np.vstack([SQUARE, SQUARE[1:] + 1e-12]),
            [*HALVES, (4, 6, 5)],
            "at the place of another",
        ),
    ],
)
def test_bad_meshes_are_refused_by_number(nodes, cells, words):
    with pytest.raises(ValueError, match=words):
        cloud.from_cells(nodes, cells)


def test_bad_files_and_spacings_are_refused(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"none\.msh"):
        cloud.read(tmp_path / "none.msh")
    (tmp_path / "text.msh").write_text("no mesh\n")
    with pytest.raises(ValueError, match="cannot be read as a mesh"):
        cloud.read(tmp_path / "text.msh")
    for spacing in (0.0, 1.5, float("nan")):
        with pytest.raises(ValueError, match="spacing"):
            cloud.mesh(shapes.circle(1.0), spacing)
