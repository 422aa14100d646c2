"""Pictures and time series, drawn from a scene and a dump made by hand: no LAMMPS needed."""

import re
import xml.etree.ElementTree as xml
from dataclasses import replace

import meshio
import numpy as np
import pytest
import scenes
from matplotlib import image
from peridem import render, render_3d
from peridem.render_style import style_of
from peridem.scene import DUMP, NODE_COLUMNS, WALLS

COLUMNS = "id mol type x y vx vy " + " ".join(f"c_node[{i}]" for i in range(1, 6))
STEPS = (0, 100, 200)


def rows_of(made, shift=0.0, split=0.0, damage=0.0):
    """Rows of a dump: all moved down by ``shift``, grain 1 torn open at its middle by ``split``."""
    rows = []
    for number, grain in enumerate(made.grains, 1):
        x = grain.cloud.nodes.copy()
        x[:, 1] -= shift
        right = x[:, 0] > grain.cloud.centroid[0]
        if number == 1:
            x[right, 0] += split
        for node in range(len(x)):
            near = number == 1 and abs(x[node, 0] - grain.cloud.centroid[0]) < 6e-4
            value = damage if near else 0.0
            rows.append([len(rows) + 1, number, 1, *x[node], 0, -2, value, 0, 0, 0, 20])
    return rows


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A finished run of three frames: still, torn open by half a spacing, closed again."""
    where = tmp_path_factory.mktemp("run")
    made = scenes.two_grains()
    made.write(where)
    frames = [
        rows_of(made),
        rows_of(made, 1e-5, 0.5 * scenes.SPACING, 0.5),
        rows_of(made, 2e-5, 0.0, 0.5),
    ]
    scenes.write_dump(where / DUMP, list(zip(STEPS, frames, strict=True)), COLUMNS)
    step = made._timestep()[0]
    names = [f"f_{w.name}[{k}]" for w in made.walls for k in (1, 2)]
    with (where / WALLS).open("w") as file:
        file.write("# Time-averaged data for fix walls\n")
        file.write(f"# TimeStep v_lid_travel {' '.join(names)}\n")
        for n in range(1, 101):
            travel = 2.0 * (2 * n) * step
            file.write(f"{2 * n} {travel:.9g} 0 {-n} 0 0 0 0 0 {n}\n")
    return where


def test_a_torn_grain_is_in_two_pieces_and_stays_so(folder):
    output = render.Output(folder)
    whole, torn, closed = (output.intact_cells(i) for i in range(3))
    assert len(whole) == len(output.cells)
    assert 0 < len(torn) < len(whole)
    assert (closed == torn).all()  # bonds that broke do not come back when the crack closes
    # no cell bridges the middle of grain 1, all cells away from it are there
    middle = 1e-3
    x = output.reference[:, 0]
    first = output.cells[(output.cells < output.cells[-1].min()).all(axis=1)]
    assert len(first) > 0
    for cell in torn:
        if cell.max() < 60 and output.reference[cell, 1].max() < 1.9e-3:
            assert (x[cell] <= middle).all() or (x[cell] > middle).all()
    spared = np.abs(x[whole] - middle).min(axis=1) > 1.01 * scenes.SPACING
    kept = {tuple(cell) for cell in torn}
    assert all(tuple(cell) in kept for cell in whole[spared])


def test_picture_shows_the_grains(folder, tmp_path):
    path = render.grains_png(folder, tmp_path / "grains.png")
    pixels = image.imread(path)[..., :3]
    assert pixels.shape[0] > 500 and pixels.shape[1] > 1000
    assert share(pixels, render.INTACT) > 0.1 and share(pixels, render.WALL) > 0.02
    whole, torn = (
        image.imread(render.grains_png(folder, tmp_path / f"{i}.png", frames=[i]))[..., :3]
        for i in (0, 1)
    )
    # half the nodes of one of two grains are damaged in the second frame
    assert share(torn, render.INTACT) < 0.85 * share(whole, render.INTACT)


def test_mean_damage_is_that_of_nodes_with_bonds(folder, tmp_path):
    output = render.Output(folder)
    assert output.mean_damage(1) == output.field("damage", 1).mean() > 0.0
    frame = rows_of(scenes.two_grains(), damage=1.0)
    for row in frame:
        if row[1] == 2 or row[-5] == 1.0:  # like a node of a body, or with all bonds broken
            row[-1] = 0
    scenes.two_grains().write(tmp_path)
    scenes.write_dump(tmp_path / DUMP, [(0, frame)], COLUMNS)
    first = [row[-5] for row in frame if row[1] == 1]
    assert render.Output(tmp_path).mean_damage(0) == pytest.approx(np.mean(first), rel=1e-15)


def share(pixels, colour):
    """Part of the pixels that have a colour, each channel within two of 255 steps."""
    wanted = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    return (np.abs(pixels - wanted).max(axis=2) < 2.5 / 255).mean()


def test_wall_pressure_is_force_over_width(folder, tmp_path):
    travel, pressure = render.wall_stress(folder)
    # the box is 2 mm wide; the record holds 1 .. 100 N per m of thickness
    assert pressure == pytest.approx(np.arange(1, 101) / 2e-3)
    assert (np.diff(travel) > 0.0).all()
    path = render.stress_png(folder, tmp_path / "stress.png")
    assert image.imread(path)[..., :3].std() > 0.05
    with pytest.raises(ValueError, match="no moving wall 'floor'; there are lid"):
        render.wall_stress(folder, "floor")


def test_pvd_lists_frames_that_hold_the_grains(folder, tmp_path):
    path = render.pvd(folder, tmp_path / "grains.pvd")
    entries = xml.parse(path).getroot().findall("./Collection/DataSet")
    output = render.Output(folder)
    grains = [entry for entry in entries if entry.get("part") == "0"]
    assert [float(e.get("timestep")) for e in grains] == pytest.approx(
        [step * output.summary["timestep"] for step in STEPS]
    )
    assert len(entries) == 2 * len(grains)
    for i, entry in enumerate(grains):
        mesh = meshio.read(tmp_path / entry.get("file"))
        frame = output.dump[i]
        assert mesh.points[:, :2] == pytest.approx(frame.position)
        assert len(mesh.cells_dict["triangle"]) == len(output.intact_cells(i))
        assert mesh.point_data["damage"] == pytest.approx(frame["c_node[1]"])
        fields = {"grain", "type", "velocity", "displacement", *NODE_COLUMNS}
        assert set(mesh.point_data) == fields
        # every point is seen: in a cell, or as a point of its own
        seen = np.concatenate([block.data.ravel() for block in mesh.cells])
        assert len(np.unique(seen)) == len(mesh.points)


def test_missing_and_foreign_files_are_refused(folder, tmp_path):
    with pytest.raises(FileNotFoundError, match="no folder"):
        render.Output(tmp_path / "none")
    made = scenes.two_grains()
    made.write(tmp_path)
    with pytest.raises(FileNotFoundError, match=re.escape(DUMP)):
        render.grains_png(tmp_path, tmp_path / "x.png")
    scenes.write_dump(tmp_path / DUMP, [(0, rows_of(made)[:-1])], COLUMNS)
    with pytest.raises(ValueError, match="atoms at step 0"):
        render.Output(tmp_path).intact_cells(0)
    with pytest.raises(ValueError, match=r"walls\.dat: scripts of scenes with walls"):
        render.wall_stress(tmp_path)
    away = rows_of(made)
    away[3][4] = 100.0  # m, where the box is 2 mm wide
    scenes.write_dump(tmp_path / DUMP, [(0, away)], COLUMNS)
    with pytest.raises(ValueError, match="has something flown away"):
        render.grains_png(tmp_path, tmp_path / "x.png")


def test_colours_follow_the_field(folder, tmp_path):
    output = render.Output(folder)
    assert {"damage", "stretch", "grain", "speed", "displacement", "type"} <= set(output.fields())
    assert output.field("speed", 0) == pytest.approx(2.0)
    assert output.field("displacement", -1).max() == pytest.approx(2e-5, rel=1e-6)
    style = style_of(output, [0, 1], "displacement")
    assert abs(style.low) < 1e-12 and 0.0 < style.high <= 0.5 * scenes.SPACING + 1e-5
    assert style_of(output, [0], "damage").high == 0.6
    with pytest.raises(ValueError, match="from 2 to 1"):
        style_of(output, [0], "speed", 2.0, 1.0)
    path = render.grains_png(folder, tmp_path / "g.png", [0], field="grain")
    pixels = image.imread(path)[..., :3]
    colours = style_of(output, [0], "grain").map()
    for grain in (1, 2):  # each in its colour of its own
        colour = colours((grain * 7) % 20 / 19.999)[:3]
        assert (np.abs(pixels - colour).max(axis=2) < 2.5 / 255).mean() > 0.05


@pytest.mark.parametrize("kind", ["gif", "mp4"])
def test_films_have_all_frames(folder, tmp_path, kind):
    import imageio.v3 as iio

    path = render.animation(folder, tmp_path / f"a.{kind}", width=200, rate=4)
    words = {"plugin": "FFMPEG"} if kind == "mp4" else {}
    frames = list(iio.imiter(path, **words))
    assert len(frames) == len(STEPS)
    assert frames[0].shape[1] == 200
    first, last = (np.asarray(frame, dtype=float)[..., :3] for frame in (frames[0], frames[1]))
    assert np.abs(first - last).max() > 60.0  # it shows that a grain is torn open
    assert [p.name for p in tmp_path.iterdir()] == [path.name]  # no half-made file is left


def test_plots_show_numbers(folder, tmp_path):
    (folder / "log.lammps").write_text(" Step Time E F\n0 0 1 2\n200 1e-5 2 3\nLoop time\n")
    path = render.thermo_png(folder, tmp_path / "t.png", ["E", "F"])
    assert image.imread(path)[..., :3].std() > 0.05
    with pytest.raises(KeyError, match="no column 'G' in the log; it has Step, Time, E, F"):
        render.thermo_png(folder, tmp_path / "t.png", ["G"])
    path = render.fragments_png(folder, tmp_path / "f.png")
    assert image.imread(path)[..., :3].std() > 0.05
    (folder / "log.lammps").unlink()


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    """A 3D run of two frames: a ball whole, and pulled apart at its equator."""
    from peridem import cloud, scene, shapes

    where = tmp_path_factory.mktemp("ball")
    made = cloud.mesh(shapes.sphere(1e-3), 4e-4).placed((0.0, 0.0, 1.5e-3))
    wall = scene.Wall("lid", (0.0, 0.0, 3e-3), (0.0, 0.0, -1.0), (0.0, 0.0, -1.0))
    floor = scene.Wall("floor", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    scene.Scene(
        title="A ball",
        grains=[scene.Grain(made, replace(scenes.SOLID, horizon=1e-3))],
        contact=scenes.two_grains().contact,
        walls=[wall, floor],
        gravity=(0.0, 0.0, 0.0),
        duration=1e-4,
    ).write(where)
    rows = []
    for shift in (0.0, 1e-3):
        x = made.nodes.copy()
        x[x[:, 2] > 1.5e-3, 2] += shift
        damage = np.where(np.abs(made.nodes[:, 2] - 1.5e-3) < 4e-4, shift / 2e-3, 0.0)
        both = enumerate(zip(x, damage, strict=True))
        rows.append([[k + 1, 1, 1, *p, 0, 0, 0, d] for k, (p, d) in both])
    columns = "id mol type x y z vx vy vz c_node[1]"
    scenes.write_dump(where / DUMP, list(zip((0, 100), rows, strict=True)), columns)
    return where


@pytest.mark.seconds
def test_a_ball_is_drawn_without_a_display(ball, tmp_path, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    output = render.Output(ball)
    style = style_of(output, [0, 1])
    bounds = render_3d.bounds_of(output, [0, 1])
    shots = [render_3d.image(output, i, style, bounds, (300, 300)) for i in (0, 1)]
    drawn = [(np.abs(shot.astype(int) - 255).max(axis=2) > 60).mean() for shot in shots]
    assert 0.05 < drawn[0] < 0.6
    red = [((s[..., 0] > 100) & (s[..., 1] < 60) & (s[..., 2] < 60)).mean() for s in shots]
    assert red[0] == 0.0 and red[1] > 0.005  # damage shows at the tear
    half = render.Camera(cut=((0.0, 0.0, 1.5e-3), (0.0, 0.0, 1.0)))
    x, triangles, _ = render_3d.surface(output, 0, half)
    assert 0 < len(triangles) < len(render_3d.surface(output, 0)[1])
    assert x[triangles].mean(axis=1)[:, 2].max() < 1.8e-3
    path = render.grains_png(ball, tmp_path / "ball.png", camera=half)
    assert image.imread(path)[..., :3].std() > 0.05
    with pytest.raises(ValueError, match="2D scenes only"):
        render.grains_png(ball, tmp_path / "x.png", chains=True)


def test_without_a_library_to_draw_with_it_says_what_to_install(ball, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(render_3d, "LIBRARIES", ("libNoSuch.so.1",))
    output = render.Output(ball)
    with pytest.raises(RuntimeError, match="install libegl1"):
        render_3d.image(output, 0, style_of(output, [0]), render_3d.bounds_of(output, [0]))


def test_3d_cells_are_in_the_paraview_files(ball, tmp_path):
    render.pvd(ball, tmp_path / "b.pvd")
    meshes = [meshio.read(tmp_path / "b" / f"grains_{i:04d}.vtu") for i in (0, 1)]
    whole, torn = (len(mesh.cells_dict["tetra"]) for mesh in meshes)
    assert whole == len(render.Output(ball).cells) > torn > 0
    assert (meshes[0].cell_data["grain"][0] == 1).all()
