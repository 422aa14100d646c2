"""Clouds: volumes, spacing, surface, repeatability, files, refused meshes."""

import warnings

import meshio
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as draw
from peridem import cloud, lattice, shapes
from peridem.gmsh_mesh import facet_loops
from scipy.spatial import cKDTree

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
    # gmsh places nodes to some 1e-12 of the size
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
    # rounding: of one product, of distances, of sums over the nodes
    assert moved.volumes == pytest.approx(4.0 * made.volumes, rel=1e-15)
    assert moved.spacing == pytest.approx(2.0 * made.spacing, rel=1e-12)
    assert moved.centroid == pytest.approx((2.0, -1.0), abs=1e-12)


def test_tetrahedra_share_their_volume_among_four_nodes():
    unit = cloud.from_cells(np.vstack([np.zeros(3), np.eye(3)]), [(0, 1, 2, 3)])
    assert unit.dimension == 3
    # rounding of one division
    assert unit.volumes == pytest.approx(np.full(4, 1.0 / 24.0), rel=1e-15)
    assert unit.surface.all()


@pytest.mark.parametrize("ending", [".msh", ".vtu"])
def test_a_mesh_file_comes_back(tmp_path, ending, capfd):
    made = cloud.mesh(shapes.triangle(1e-3), 2e-4)
    made.write(tmp_path / f"grain{ending}")
    back = cloud.read(tmp_path / f"grain{ending}")
    # files hold 16 digits; coordinates that are zero but for rounding
    assert back.nodes == pytest.approx(made.nodes, rel=1e-12, abs=1e-18)
    assert (back.cells == made.cells).all()
    assert back.name == "grain"
    captured = capfd.readouterr()
    assert captured.out == "" and captured.err == ""


# ---- all shapes, in the plane and in space -------------------------------------------------------

SHAPES = [shapes.named(name, 1e-3) for name in shapes.NAMED]
POLYTOPES = ("hexagon", "triangle", "drum", "star", "rectangle", "irregular", "cuboid")
FLAT = (*POLYTOPES, "irregular_solid")  # what a mesh fills without a gap


def spacing_of(shape):
    """A spacing at which a mesh of the shape has a hundred to four hundred nodes."""
    return {"annulus": 0.8e-4}.get(shape.name, 1.5e-4 if shape.dimension == 2 else 2.5e-4)


@pytest.mark.parametrize("volumes", ["lumped", pytest.param("voronoi", marks=pytest.mark.seconds)])
@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: s.name)
def test_volumes_of_every_shape_add_up(shape, volumes):
    made = cloud.mesh(shape, spacing_of(shape), volumes)
    assert made.volumes.min() > 0.0
    size = made.measure / shape.measure
    if shape.name in FLAT:
        # sums of a few thousand volumes, each rounded
        assert size == pytest.approx(1.0, rel=1e-12)
    else:
        # a mesh with sides h lies up to h^2/(8 r) inside a curve of the radius r: at h = r/4 this
        # is 0.8 % of r, three times that of the volume; 6 % at the ellipsoid's ends (r = 0.36)
        assert 0.94 < size <= 1.0 + 1e-12
    assert cloud.mesh(shape, spacing_of(shape), volumes, exact=True).measure == pytest.approx(
        shape.measure, rel=1e-13
    )
    # meshes are nearly even: their centres differ by a few hundredths of the spacing
    assert made.centroid == pytest.approx(shape.centroid, abs=0.05 * spacing_of(shape))
    if shape.name in FLAT:
        assert moments_of_cells(made) == pytest.approx(
            shape.moments, abs=1e-12 * np.trace(shape.moments)
        )


def moments_of_cells(made):
    """Second moments of filled cells about their centroid, from those of a simplex."""
    d, corners = made.dimension, made.nodes[made.cells]
    size = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / (2.0 if d == 2 else 6.0)
    total = corners.sum(axis=1)
    pairs = np.einsum("mci,mcj->mij", corners, corners) + np.einsum("mi,mj->mij", total, total)
    second = (size[:, None, None] * pairs).sum(axis=0) / ((d + 1) * (d + 2))
    first = (size[:, None] * total).sum(axis=0) / (d + 1)
    return second - np.outer(first, first) / size.sum()


@pytest.mark.seconds
@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: s.name)
def test_moments_converge_with_the_spacing(shape):
    if shape.dimension == 3:
        coarse, fine = 2.5e-4, 1.5e-4
    else:
        coarse, fine = spacing_of(shape), 0.5 * spacing_of(shape)
    off = []
    for spacing in (coarse, fine):
        made = cloud.mesh(shape, spacing, exact=True)
        off.append(np.abs(made.moments - shape.moments).max() / np.trace(shape.moments))
    # of second order: a quarter in the plane, a third in space; half leaves room for uneven meshes
    assert off[1] < 0.6 * off[0] or off[1] < 2e-3


@pytest.mark.seconds
def test_voronoi_volumes_are_those_of_many_points():
    for shape, count in ((shapes.star(1.0), 200_000), (shapes.irregular_solid(1.0), 200_000)):
        made = cloud.mesh(shape, 0.3, "voronoi")
        low, high = shape.extent
        points = np.random.default_rng(1).uniform(low, high, (count, shape.dimension))
        points = points[shape.contains(points)]
        nearest = cKDTree(made.nodes).query(points)[1]
        share = np.bincount(nearest, minlength=len(made.nodes)) / len(points)
        expected = made.volumes / made.measure
        # counts of n points have a standard deviation of sqrt(p/n); five of them
        assert (np.abs(share - expected) < 5.0 * np.sqrt((expected + 1e-5) / len(points))).all()


def test_voronoi_volumes_of_a_lattice_are_its_cells():
    x, y = np.meshgrid(np.arange(5.0), np.arange(4.0))
    nodes = np.column_stack([x.ravel(), y.ravel()])
    corner = np.array([5 * j + i for j in range(3) for i in range(4)])
    cells = np.vstack(
        [
            np.column_stack([corner, corner + 1, corner + 6]),
            np.column_stack([corner, corner + 6, corner + 5]),
        ]
    )
    made = cloud.from_cells(nodes, cells, volumes="voronoi")
    half = np.outer([0.5, 1, 1, 0.5], [0.5, 1, 1, 1, 0.5]).ravel()
    # rounding of the corners of the cells
    assert made.volumes == pytest.approx(half, rel=1e-14)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: s.name)
def test_surface_nodes_of_every_shape_are_the_outer_ones(shape):
    made = cloud.mesh(shape, spacing_of(shape))
    grown = made.nodes[made.surface] - made.centroid
    # a hair inside the boundary, surface nodes are inside; a hair outside they are not (star-shaped
    # shapes only, to which the annulus does not belong)
    if shape.name != "annulus":
        centre = made.centroid
        assert shape.contains(centre + 0.999 * grown).all()
        assert not shape.contains(centre + 1.001 * grown).any()
    assert shape.contains(made.nodes[~made.surface]).all()


@pytest.mark.parametrize("kind", lattice.KINDS)
def test_lattices_are_regular_and_share_the_volume(kind):
    flat = kind in ("square", "hexagonal")
    shape = shapes.circle(1.0) if flat else shapes.sphere(1.0)
    made = cloud.lattice(shape, 0.2, kind)
    assert made.measure == pytest.approx(shape.measure, rel=1e-13)
    assert np.ptp(made.volumes) == 0.0
    assert made.spacing == pytest.approx(0.2, rel=1e-12)
    # the share is the lattice's own cell, up to what its sites miss at the boundary
    cell = {"square": 1.0, "hexagonal": 0.75**0.5, "cubic": 1.0, "fcc": 0.5**0.5}[kind]
    assert made.volumes[0] == pytest.approx(cell * 0.2**made.dimension, rel=0.1)
    assert made.centroid == pytest.approx(np.zeros(made.dimension), abs=1e-12)
    # nodes with all neighbours are inside, the others at most a spacing from the boundary
    away = np.linalg.norm(made.nodes, axis=1)
    assert (away[made.surface] > 1.0 - 0.2 * 1.01).all()
    assert made.cells.max() == len(made.nodes) - 1 and 0.0 < lattice_volume(made) < shape.measure


def lattice_volume(made):
    corners = made.nodes[made.cells]
    sizes = np.linalg.det(corners[:, 1:] - corners[:, :1])
    assert (sizes > 0.0).all()
    return sizes.sum() / (2.0 if made.dimension == 2 else 6.0)


def test_a_lattice_fills_a_rectangle_without_a_gap():
    made = cloud.lattice(shapes.rectangle(1.0, 0.6), 0.1)
    assert len(made.nodes) == 60
    # rounding of the area over the number of nodes
    assert made.volumes == pytest.approx(np.full(60, 0.01), rel=1e-14)
    low, high = made.nodes.min(axis=0), made.nodes.max(axis=0)
    assert (low, high) == (pytest.approx((-0.45, -0.25)), pytest.approx((0.45, 0.25)))
    assert made.surface.sum() == 28
    for bad, words in (
        ((0.1, "fcc"), "square, hexagonal"),
        ((0.0, ""), "spacing"),
        ((9.0, ""), "sites"),
    ):
        with pytest.raises(ValueError, match=words):
            cloud.lattice(shapes.rectangle(1.0, 0.6), *bad)


# ---- turned, stretched, mirrored -----------------------------------------------------------------


@settings(max_examples=30, deadline=None)
@given(
    angle=draw.tuples(*[draw.floats(-3.0, 3.0)] * 3),
    factor=draw.tuples(*[draw.floats(0.2, 5.0)] * 3),
    shift=draw.tuples(*[draw.floats(-2.0, 2.0)] * 3),
    axis=draw.integers(0, 2),
)
def test_moved_clouds_are_still_sound(angle, factor, shift, axis):
    made = SOUND.rotated(angle).scaled(factor).mirrored(axis).moved(shift)
    # from_cells finds all cells positive and the same volumes, to rounding
    again = cloud.from_cells(made.nodes, made.cells)
    assert (again.cells == made.cells).all() and (again.surface == made.surface).all()
    assert made.volumes == pytest.approx(np.prod(factor) * SOUND.volumes, rel=1e-12)
    assert again.measure == pytest.approx(made.measure, rel=1e-10)


SOUND = cloud.mesh(shapes.cuboid(1.0, 1.2, 0.8), 0.4)


def test_bad_moves_are_refused():
    for make, words in (
        (lambda: SOUND.scaled(0.0), "above 0"),
        (lambda: SOUND.scaled((1.0, -1.0, 1.0)), "above 0"),
        (lambda: SOUND.mirrored(3), "below 3"),
        (lambda: SOUND.with_measure(0.0), "above 0"),
        (lambda: cloud.mesh(shapes.circle(1.0), 0.3).rotated((0.0, 0.0, 1.0)), "rotation"),
    ):
        with pytest.raises(ValueError, match=words):
            make()


# ---- files ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [SHAPES[0], shapes.cylinder(1.0, 1.0)], ids=lambda s: s.name)
@pytest.mark.parametrize("ending", [".msh", ".vtu", ".vtk", ".inp", "4.msh"])
def test_meshes_of_every_kind_of_file_come_back(tmp_path, shape, ending):
    made = cloud.mesh(shape, 0.3 * float(shape.extent[1][0]))
    path = tmp_path / f"grain{ending}"
    if ending == "4.msh":
        points = np.pad(made.nodes, ((0, 0), (0, 3 - made.dimension)))
        kind = "triangle" if made.dimension == 2 else "tetra"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of missing entities
            meshio.write(path, meshio.Mesh(points, [(kind, made.cells)]), file_format="gmsh")
        assert "4.1" in path.read_bytes()[:40].decode(errors="replace")
    else:
        made.write(path)
    back = cloud.read(path)
    assert back.nodes == pytest.approx(made.nodes, rel=1e-12, abs=1e-18)
    assert (back.cells == made.cells).all() and (back.surface == made.surface).all()
    assert back.volumes == pytest.approx(made.volumes, rel=1e-9)


def test_volumes_come_back_from_a_file_that_holds_them(tmp_path):
    made = cloud.mesh(shapes.hexagon(1.0), 0.3, "voronoi")
    made.write(tmp_path / "grain.vtu")
    back = cloud.read(tmp_path / "grain.vtu", volumes="file")
    assert (back.volumes == made.volumes).all()
    made.write(tmp_path / "grain.msh")
    with pytest.raises(ValueError, match="no point data named 'volume'"):
        cloud.read(tmp_path / "grain.msh", volumes="file")


def test_a_closed_surface_is_filled_with_tetrahedra(tmp_path):
    rock = shapes.irregular_solid(1.0, seed=4)
    vertices, triangles = rock.surface()
    meshio.write(
        tmp_path / "rock.stl", meshio.Mesh(vertices, [("triangle", triangles)]), binary=True
    )
    with pytest.raises(ValueError, match="give a spacing"):
        cloud.read(tmp_path / "rock.stl")
    made = cloud.read(tmp_path / "rock.stl", spacing=0.4)
    # seven digits in the file
    assert made.measure == pytest.approx(rock.volume, rel=1e-5) and made.name == "rock"


def test_a_finely_triangulated_surface_is_meshed_at_the_wanted_spacing(tmp_path):
    ball = shapes.ellipsoid(1.0, 0.9, 0.7)
    vertices, triangles = ball.surface(outside=False)  # 512 corners, some 0.15 apart
    meshio.write(tmp_path / "ball.stl", meshio.Mesh(vertices, [("triangle", triangles)]))
    made = cloud.read(tmp_path / "ball.stl", spacing=0.4)
    assert made.surface.sum() < 200
    # chords of 0.4 on a radius of 0.5 to 1.4 lose up to 4 % in each of three directions
    assert 0.88 < made.measure / ball.volume < 1.0


def test_flat_faces_of_many_triangles_are_one_face():
    vertices, triangles = shapes.cuboid(1.0, 1.0, 1.0).surface()
    for _ in range(2):  # each triangle into four
        middle = 0.5 * (vertices[triangles] + vertices[np.roll(triangles, -1, axis=1)])
        new = len(vertices) + np.arange(3 * len(triangles)).reshape(-1, 3)
        vertices = np.vstack([vertices, middle.reshape(-1, 3)])
        (a, b, c), (i, j, k) = triangles.T, new.T
        triangles = np.vstack(
            [np.column_stack(t) for t in ((a, i, k), (b, j, i), (c, k, j), (i, j, k))]
        )
        vertices, first = np.unique(vertices.round(9), axis=0, return_inverse=True)
        triangles = first.ravel()[triangles]
    faces = facet_loops(vertices, triangles)
    assert [[len(loop) for loop in loops] for loops in faces] == [[4]] * 6
    made = cloud.mesh(shapes.polyhedron(vertices, triangles), 0.5)
    assert made.measure == pytest.approx(1.0, rel=1e-12)
    assert made.spacing > 0.25  # not the 0.25 and less that the many triangles would ask for


def test_quadrilaterals_and_hexahedra_are_divided(tmp_path):
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    meshio.write(tmp_path / "quad.vtu", meshio.Mesh(square, [("quad", [(0, 1, 2, 3)])]))
    assert cloud.read(tmp_path / "quad.vtu").measure == pytest.approx(1.0)
    cube = np.vstack([square, square + np.array([0, 0, 2])])
    meshio.write(tmp_path / "hex.inp", meshio.Mesh(cube, [("hexahedron", [range(8)])]))
    made = cloud.read(tmp_path / "hex.inp")
    assert made.measure == pytest.approx(2.0) and len(made.cells) == 6 and made.surface.all()
    curved = np.vstack([square, square + np.array([0.5, 0, 0])])[:6]
    meshio.write(tmp_path / "curved.vtu", meshio.Mesh(curved, [("triangle6", [range(6)])]))
    with pytest.raises(ValueError, match=r"triangle6.*first order"):
        cloud.read(tmp_path / "curved.vtu")


def test_mesh_files_that_lack_nodes_are_refused(tmp_path):
    points = np.pad(SQUARE, ((0, 0), (0, 1)))
    cells = np.vstack([HALVES, [(0, 1, 99)]])
    meshio.write(tmp_path / "far.vtu", meshio.Mesh(points, [("triangle", cells)]))
    with pytest.raises(
        ValueError, match=r"far.vtu: cell 3 is of the nodes 1, 2, 100; there are 4$"
    ):
        cloud.read(tmp_path / "far.vtu")
    (tmp_path / "empty.stl").write_text("")
    with pytest.raises(ValueError, match=r"empty.stl has no nodes: it is empty or cut off"):
        cloud.read(tmp_path / "empty.stl", spacing=0.1)
    meshio.write(
        tmp_path / "upright.vtu", meshio.Mesh(points[:, [0, 2, 1]], [("triangle", HALVES)])
    )
    with pytest.raises(ValueError, match="does not lie in a plane z = constant"):
        cloud.read(tmp_path / "upright.vtu")


def test_groups_of_a_mesh_file_are_kept(tmp_path):
    points = np.pad(SQUARE, ((0, 0), (0, 1)))
    tags = [np.array([7, 9])]
    mesh = meshio.Mesh(
        points, [("triangle", HALVES)], cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags}
    )
    meshio.write(tmp_path / "two.msh", mesh, file_format="gmsh22", binary=False)
    assert cloud.read(tmp_path / "two.msh").tags.tolist() == [7, 9]


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
    with pytest.raises(ValueError, match="cannot be written"):
        SOUND.write(tmp_path / "grain.unknown")
    SOUND.write(tmp_path / "grain.vtu")
    with pytest.raises(ValueError, match="spacing is what it is"):
        cloud.read(tmp_path / "grain.vtu", spacing=0.1)
    with pytest.raises(ValueError, match="lumped or voronoi"):
        cloud.from_cells(SQUARE, HALVES, volumes="equal")
    with pytest.raises(ValueError, match="node 2 is without a volume above 0"):
        cloud.from_cells(SQUARE, HALVES, volumes=[1.0, 0.0, 1.0, 1.0])
    for spacing in (0.0, 1.5, float("nan")):
        with pytest.raises(ValueError, match="spacing"):
            cloud.mesh(shapes.circle(1.0), spacing)


def test_clouds_are_made_by_name_or_from_a_file(tmp_path):
    assert cloud.make("hexagon").spacing == cloud.mesh(shapes.hexagon(1e-3), 2e-4).spacing
    assert np.ptp(cloud.make("circle", 1.0, 0.2, kind="hexagonal").volumes) == 0.0
    cloud.make("star", 1.0, 0.2, "voronoi").write(tmp_path / "star.vtu")
    kept = cloud.make(str(tmp_path / "star.vtu"), volumes="file")
    # files hold 16 digits
    assert kept.volumes == pytest.approx(cloud.make("star", 1.0, 0.2, "voronoi").volumes, rel=1e-12)
    with pytest.raises(ValueError, match="lattice fills named shapes only"):
        cloud.make(str(tmp_path / "star.vtu"), kind="square")
    with pytest.raises(ValueError, match="no shape 'blob'"):
        cloud.make("blob")
