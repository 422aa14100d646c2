"""Scenes: what the data file and the script say, and what is refused."""

import itertools
import re

import meshio
import numpy as np
import pytest
import scenes
from peridem import packing, scene, shapes
from peridem.material import Contact, Material


def lines(text, command):
    """The arguments of all lines of a script that start with a command."""
    found = [line.split("#")[0].split() for line in text.splitlines()]
    return [words[1:] for words in found if words[:1] == [command]]


def atoms(text):
    """Rows of the Atoms section of a data file."""
    body = text.split("Atoms # peridem\n\n")[1]
    return np.array([[float(word) for word in line.split()] for line in body.splitlines()])


def test_data_file_holds_every_node_once():
    made = scenes.two_grains()
    rows = atoms(made.data())
    clouds = [grain.cloud for grain in made.grains]
    assert rows.shape == (sum(len(c.nodes) for c in clouds), 8)
    assert rows[:, 0].tolist() == list(range(1, len(rows) + 1))
    for number, cloud in enumerate(clouds, 1):
        mine = rows[rows[:, 1] == number]
        # written with twelve digits
        assert mine[:, 3] == pytest.approx(cloud.volumes, rel=1e-11)
        assert mine[:, 5:7] == pytest.approx(cloud.nodes, rel=1e-11, abs=1e-15)
    assert (rows[:, 4] == 1200.0).all() and (rows[:, 7] == 0.0).all()


def test_box_holds_grains_and_walls_to_the_end():
    made = scenes.two_grains(duration=5e-4)  # the lid sinks by 1 mm
    text = made.data()
    bounds = {k: re.search(rf"(\S+) (\S+) {k}lo {k}hi", text).groups() for k in "xyz"}
    x, y = (tuple(map(float, bounds[k])) for k in "xy")
    rows = atoms(text)
    assert x[0] < rows[:, 5].min() and rows[:, 5].max() < x[1]
    assert y[0] < 0.0 and y[1] > 3.9e-3
    assert bounds["z"] == ("-0.5", "0.5")


def test_script_says_what_the_scene_says():
    made = scenes.two_grains()
    text = made.script()
    (solid,) = [words for words in lines(text, "pair_coeff") if "peridem/lps" in words]
    assert solid[:3] == ["1", "1", "peridem/lps"]
    said = dict(zip(solid[3::2], solid[4::2], strict=True))
    assert float(said["bulk"]) == 21.6e6 and float(said["poisson"]) == 0.25
    assert float(said["horizon"]) == pytest.approx(6e-4) and float(said["gc"]) == 3.0
    (contact,) = [words for words in lines(text, "pair_coeff") if "peridem/contact" in words]
    said = {key: value for key, value in itertools.pairwise(contact)}
    assert float(said["radius"]) == pytest.approx(made.contact_radius, rel=1e-7)
    assert float(said["friction"]) == 0.3
    fixes = {words[0]: " ".join(words[1:]) for words in lines(text, "fix")}
    assert fixes["lid"] == "all peridem/wall plane 0 0.0039 0 0 -1 0 velocity 0 -2 0"
    assert fixes["weight"] == "all gravity 10 vector 0 -1 0"
    assert "velocity" not in fixes["floor"]
    ((skin, _),) = lines(text, "neighbor")
    assert float(skin) < made.contact_radius


def test_a_given_time_step_is_taken_and_divides_the_run():
    made = scenes.two_grains()
    text = made.script()
    assert lines(text, "timestep") == [["2.5e-07"]]
    assert not any("peridem/timestep" in words for words in lines(text, "fix"))
    (total,), every = lines(text, "run")[0], lines(text, "dump")[0][3]
    assert int(total) * 2.5e-7 == pytest.approx(made.duration)
    assert int(total) // int(every) == pytest.approx(made.frames, abs=1)


def test_without_one_lammps_finds_it_and_the_time_ends_the_run():
    made = scenes.two_grains(timestep=None)
    text = made.script()
    assert not lines(text, "timestep")
    fixes = {words[0]: " ".join(words[1:]) for words in lines(text, "fix")}
    assert fixes["step"] == "all peridem/timestep safety 0.8"
    assert fixes["duration"].startswith("all halt 10 v_duration > 0")
    assert ["duration", "equal", "time>=0.0001"] in lines(text, "variable")
    ((most,),) = lines(text, "run")
    assert int(most) * made._timestep()[0] > made.duration


def test_script_is_readable():
    text = scenes.two_grains().script()
    comments = [line for line in text.splitlines() if line.startswith("#")]
    assert text.startswith("# A hexagon on a disc\n")
    assert len(comments) >= 15
    for line in text.splitlines():
        assert len(line) <= 200 and line == line.rstrip()


def test_two_materials_are_two_types_with_their_mean_in_contact():
    soft, hard = scenes.SOLID, Material(43.2e6, 0.25, 2000.0, 6e-4, name="hard")
    made = scenes.two_grains()
    grains = [scene.Grain(made.grains[0].cloud, soft), scene.Grain(made.grains[1].cloud, hard)]
    text = scenes.two_grains(grains=grains).script()
    said = {tuple(words[:3]): words for words in lines(text, "pair_coeff")}
    assert "unbreakable" in said["2", "2", "peridem/lps"]
    mixed = said["1", "2", "peridem/contact"]
    assert float(mixed[mixed.index("modulus") + 1]) == pytest.approx(28.8e6)
    rows = atoms(scenes.two_grains(grains=grains).data())
    assert set(zip(rows[:, 1], rows[:, 2], rows[:, 4], strict=True)) == {
        (1.0, 1.0, 1200.0),
        (2.0, 2.0, 2000.0),
    }


def test_contact_radius_left_out_follows_the_boundary_spacing():
    made = scenes.two_grains()
    spacing = []
    for grain in made.grains:
        surface = grain.cloud.nodes[grain.cloud.surface]
        gaps = np.sqrt(((surface[:, None] - surface[None]) ** 2).sum(axis=2))
        spacing.append(gaps[gaps > 0.0].min())
    assert made.contact_radius == pytest.approx(0.95 * min(spacing), rel=1e-9)
    assert scenes.two_grains(contact=Contact(radius=1e-4)).contact_radius == 1e-4


def test_written_folder_is_complete(tmp_path):
    made = scenes.two_grains()
    script = made.write(tmp_path / "new" / "folder")
    assert script.read_text() == made.script()
    assert (script.parent / scene.DATA).read_text() == made.data()
    mesh = meshio.read(script.parent / scene.MESH)
    rows = atoms(made.data())
    # node i of the mesh is the atom with ID i + 1
    assert mesh.points[:, :2] == pytest.approx(rows[:, 5:7], rel=1e-11, abs=1e-15)
    assert (mesh.point_data["grain"] == rows[:, 1]).all()
    assert len(mesh.cells[0].data) == sum(len(grain.cloud.cells) for grain in made.grains)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"grains": []}, "no grains"),
        ({"duration": 0.0}, "duration"),
        ({"safety": float("nan")}, "safety"),
        ({"frames": 0}, "frames"),
        ({"gravity": (0.0, 0.0, -10.0)}, "gravity needs 2 components"),
        ({"walls": [scene.Wall("floor", (0, 2e-3), (0, 1))]}, "through the wall 'floor'"),
        ({"walls": [scene.Wall("a", (0, 0), (0, 1))] * 2}, "different names"),
    ],
)
def test_bad_scenes_are_refused(changes, words):
    with pytest.raises(ValueError, match=words):
        scenes.two_grains(**changes)


def test_bad_walls_and_mismatched_clouds_are_refused():
    for name, normal in (("a b", (0, 1)), ("motion", (0, 1)), ("lid", (0, 0))):
        with pytest.raises(ValueError, match=name):
            scene.Wall(name, (0.0, 0.0), normal)
    made = scenes.two_grains()
    placed = packing.table([shapes.circle(1.0)], [(0, 0, 0, 1, 0)], 0.1)
    with pytest.raises(ValueError, match="1 outlines with 2 clouds"):
        scene.grains_of(placed, [grain.cloud for grain in made.grains], scenes.SOLID)


def test_horizon_below_the_spacing_is_refused_before_anything_is_written(tmp_path):
    thin = Material(21.6e6, 0.25, 1200.0, 1e-4)
    made = scenes.two_grains()
    lonely = scenes.two_grains(grains=[scene.Grain(g.cloud, thin) for g in made.grains])
    with pytest.raises(ValueError, match="no other within the horizon"):
        lonely.write(tmp_path)
    assert not list(tmp_path.iterdir())
