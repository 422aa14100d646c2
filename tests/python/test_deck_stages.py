"""Second stages: decks that begin where the run of another one has ended."""

import math
from pathlib import Path

import decks
import numpy as np
import pytest
from decks import COLLISION, changed
from peridem import deck, results, run, scene
from peridem.cli import main
from peridem.deck.bodies import lattice
from peridem.deck.source import DeckError
from test_deck import drum_deck

pytestmark = pytest.mark.seconds

LID, SPEED, END = 5.2e-3, -2.0, 2e-4  # lower edge at first, speed, end of the first run
FIRST = changed(
    COLLISION,
    {
        "Zone.Zones": 4,
        "Zone.Zone_4": {"Is_Wall": True},
        "Particle.Zone_4": {
            "Is_Wall": True,
            "Type": "rectangle",
            "Parameters": [-2e-3, LID, 0, 2e-3, LID + 3e-4, 0],
            "Create_Particle_Using_ParticleZone_GeomObject": True,
        },
        "Mesh.Zone_4": {"File": "lid.msh"},
        "Material.Zone_4": {"Copy_Material_Data": 1},
        **{f"Contact.Zone_{k}4": {"Copy_Contact_Data": [1, 1]} for k in (1, 2, 3, 4)},
        "Model.Final_Time": END,
        "Model.Time_Steps": 2000,
        "Output.Output_Interval": 500,
        "Displacement_BC.Sets": 2,
        "Displacement_BC.Set_2": {
            "Particle_List": [3],
            "Direction": [1, 2],
            "Time_Function": {"Type": "linear", "Parameters": [SPEED]},
            "Spatial_Function": {"Type": "constant"},
        },
        "Displacement_BC.Set_2.Direction": [2],
    },
)
GOES_ON = {
    "Restart": {"File": "../out/output_4.vtu", "Step": 2000},
    "Model.Final_Time": 3e-4,
    "Model.Time_Steps": 3000,
}
OWN_TIME = {"Model.Final_Time": 1e-4, "Model.Time_Steps": 1000}


def write(folder: Path, changes: dict, lid: float = LID, data: dict = FIRST) -> Path:
    """A deck whose lid has its lower edge at some height."""
    path = decks.write(folder, changed(data, changes))
    low, high = np.array([-2e-3, lid]), np.array([2e-3, lid + 3e-4])
    lattice(low, high, np.array([16, 2]), "lid").write(folder / "lid.msh")
    return path


def ran(made: scene.Scene, folder: Path, lmp: Path) -> results.Output:
    run.run(made.write(folder), lmp=lmp, quiet=True)
    return results.Output(folder)


@pytest.fixture(scope="module", params=[False, True], ids=["right", "published"])
def first(request, tmp_path_factory, lmp):
    """Whether as published, and the folder of the first run."""
    folder = tmp_path_factory.mktemp("first")
    made = deck.load(write(folder, {}), request.param).scene
    ran(made, folder / "out", lmp)
    return request.param, folder / "out"


def edge(output: results.Output, i: int) -> float:
    """Height of the lid's lower edge in a frame, whatever the lid is made of."""
    planes = {wall.name: wall for wall in output.walls(output.time(i))}
    if "lid" in planes:
        return float(planes["lid"].point[1])
    frame = output.frame(i)
    return float(frame.position[frame["mol"] == 4][:, 1].min())


def test_the_same_deck_goes_on_as_one_run(first, tmp_path, lmp):
    as_published, before = first
    loaded = deck.load(write(tmp_path, GOES_ON), as_published, after=before)
    assert loaded.report[0].startswith(f"input.yaml: begins with the end of the run in {before} (")
    second = ran(loaded.scene, tmp_path / "out", lmp)
    one_deck = {key: value for key, value in GOES_ON.items() if key != "Restart"}
    single = deck.load(write(tmp_path / "single", one_deck), as_published).scene
    whole = ran(single, tmp_path / "whole", lmp)
    one, two = whole.frame(-1), second.frame(-1)
    # fixed steps: to the nine digits of the dumps; where steps are found, a run ends up to ten of
    # them, 2 us, late, and nodes move at up to 4 m/s
    off = 1e-11 if as_published else 1e-5
    assert two.position == pytest.approx(one.position, rel=0.0, abs=off)
    for output, i in ((second, 0), (second, -1), (whole, -1)):
        expected = LID + SPEED * output.time(i)
        assert edge(output, i) == pytest.approx(expected, rel=0.0, abs=1e-9)


@pytest.mark.parametrize("timed", [True, False], ids=["restart", "own"])
def test_a_wall_is_put_where_the_deck_has_it(first, timed, tmp_path, lmp):
    as_published, before = first
    start = 5.3e-3  # higher than it was left, at 4.8 mm
    changes, mesh = (GOES_ON, start - SPEED * END) if timed else (OWN_TIME, start)
    loaded = deck.load(write(tmp_path, changes, mesh), as_published, after=before)
    (line,) = [line for line in loaded.report if "lies elsewhere" in line]
    assert ": Particle.Zone_4: its mesh lies elsewhere than in" in line
    assert "put at (-0.002, 0.0053" in line or "put at (-0.002, 0.00529" in line
    assert "m from where it had come" in line
    assert ("has moved for 0.0002" in line) == timed
    second, old = ran(loaded.scene, tmp_path / "out", lmp), results.Output(before)
    # the first run ends up to ten steps of 0.2 us after 0.2 ms; nine digits in dumps
    assert edge(second, 0) == pytest.approx(start, rel=0.0, abs=1e-11 if as_published else 5e-6)
    assert edge(second, -1) - edge(second, 0) == pytest.approx(SPEED * 1e-4, rel=0.03)
    grains = old.frame(-1)["mol"] < 3  # everything else comes from the first run
    here, there = second.frame(0), old.frame(-1)
    assert (here.position[grains] == there.position[grains]).all()
    assert (here.velocity[grains] == there.velocity[grains]).all()
    # and a third one goes on from there
    third = {**changes, "Restart": {"Step": 3000}, "Model.Final_Time": 4e-4}
    third["Model.Time_Steps"] = 4000
    made = deck.load(write(tmp_path / "third", third, mesh), as_published, after=tmp_path / "out")
    last = ran(made.scene, tmp_path / "third" / "out", lmp)
    assert edge(last, 0) == pytest.approx(edge(second, -1), rel=0.0, abs=1e-9)
    assert edge(last, -1) - edge(last, 0) == pytest.approx(SPEED * 1e-4, rel=0.03)


def test_in_lammps_the_wall_is_where_the_scene_says(tmp_path, lmp):
    """A floor that has sunk is put back under the grains, and they feel it there at once."""
    data = changed(FIRST, {"Displacement_BC.Set_2.Particle_List": [2, 3]})
    made = deck.load(write(tmp_path, {}, data=data)).scene
    before = ran(made, tmp_path / "one", lmp)
    lowest = before.frame(-1).position[:, 1].min()
    names = [wall.name for wall in made.walls]
    floor = made.walls[names.index("floor")]
    assert floor.velocity == (0.0, SPEED)
    assert before.walls(before.time(-1))[names.index("floor")].point[1] < -3.9e-4
    # a tenth of a contact radius too high: pressed from the first step on
    high = lowest - 0.9 * made.contact_radius
    put = scene.Wall("floor", (floor.point[0], high), (0.0, 1.0))
    walls = [put if wall.name == "floor" else wall for wall in made.walls]
    short = {"timestep": 1e-8, "duration": 2e-7}  # a pressed node needs 1e-6 to get away
    second = made.after(tmp_path / "one", put=["floor"], walls=walls, **short)
    ran(second, tmp_path / "two", lmp)
    force = results.averages(tmp_path / "two" / scene.WALLS)["f_floor[2]"]
    assert (force < 0.0).all()  # it is pushed down
    # the next stage has it where it is, at its own point
    third = ran(second.after(tmp_path / "two"), tmp_path / "three", lmp)
    after = results.averages(tmp_path / "three" / scene.WALLS)["f_floor[2]"]
    assert after[0] == pytest.approx(force[-1], rel=0.1)
    assert third.walls(1.0)[names.index("floor")].point[1] == pytest.approx(high)
    with pytest.raises(ValueError, match="put it elsewhere with put="):
        made.after(tmp_path / "one", walls=walls)
    with pytest.raises(ValueError, match="no wall 'roof' to put anywhere; there are"):
        made.after(tmp_path / "one", put=["roof"])
    with pytest.raises(ValueError, match="the scene begins with the run there"):
        second.write(tmp_path / "one")


def test_bodies_that_cannot_be_put(first, tmp_path):
    as_published, before = first
    made = deck.load(write(tmp_path, {}), as_published).scene
    for bodies, words in (
        ({9: (0.0, 0.0)}, "no grain 9 to put anywhere, of"),
        ({1: (0.0, 0.0)}, "grain 1 has bonds: only bodies without bonds"),
        *([({4: (0.0,)}, "grain 4 is put elsewhere by 2 numbers")] if as_published else []),
    ):
        with pytest.raises(ValueError, match=words):
            made.after(before, bodies=bodies)


def test_formulas_count_from_the_deck_s_own_time(first, tmp_path, lmp):
    """... and from where the body is: it swings about the place that the first run left it at."""
    as_published, before = first
    swing = {
        **OWN_TIME,
        "Displacement_BC.Set_2.Time_Function": {"Type": "sin", "Parameters": [1e-5, 5000.0]},
    }
    path = write(tmp_path, swing)
    if not as_published:
        with pytest.raises(DeckError, match="surface lid, which can move at constant velocity"):
            deck.load(path, after=before)
        return
    output = ran(deck.load(path, True, after=before).scene, tmp_path / "out", lmp)
    start = edge(results.Output(before), -1)
    for i in range(len(output.dump)):
        now = output.time(i) - END
        expected = start + 1e-5 * math.sin(math.pi * 5000.0 * now)
        assert edge(output, i) == pytest.approx(expected, rel=0.0, abs=1e-10)
    # ... again, from the swing: its fix is not taken for the one before
    again = deck.load(path, True, after=tmp_path / "out").scene
    last = ran(again, tmp_path / "again", lmp)
    assert "fix wall_3_move_2 wall_3 move variable" in last.script
    assert edge(last, 0) == pytest.approx(edge(output, -1), rel=0.0, abs=1e-10)


def test_a_drum_turns_on(tmp_path, lmp):
    """Its fin is where the first run has turned it to, and grains are checked against that."""
    turning = {"Model.Final_Time": 4e-3, "Model.Time_Steps": 40000, "Output.Output_Interval": 20000}
    light = {"Force_BC.Gravity": [0.0, 0.0, 0.0], "IC": None, **turning}
    path = decks.write(tmp_path, drum_deck(**light))
    one = ran(deck.load(path).scene, tmp_path / "one", lmp)
    angle = one.regions(one.time(-1))[0].angle
    assert angle == pytest.approx(-0.4, rel=1e-3)  # to one step
    second = deck.load(path, after=tmp_path / "one")
    assert any("the surface drum of" in line for line in second.report)
    two = ran(second.scene, tmp_path / "two", lmp)
    assert two.regions(two.time(0))[0].angle == pytest.approx(angle, rel=1e-6)
    assert two.regions(two.time(-1))[0].angle == pytest.approx(2 * angle, rel=1e-3)


def test_other_particles_are_refused_in_one_line(first, tmp_path):
    as_published, before = first
    moved = "i, x, y, z, r, o\n0, 0.0, 0.0015, 0.0, 0.001, 0.3\n1, 0.0, 0.0039, 0.0, 0.0011, 1.2\n"
    turned = decks.TABLE.replace("1.2", "1.3")
    three = moved + "1, 0.0, 0.0, 0.0, 0.001, 0\n"

    def refused(changes, *words, table=decks.TABLE, lid=LID, how=as_published, after=before):
        path = write(tmp_path, changes, lid)
        (tmp_path / "table.csv").write_text(table)
        with pytest.raises(DeckError) as error:
            deck.load(path, how, after=after)
        text = str(error.value)
        assert "\n" not in text and text.startswith(str(path))
        for word in words:
            assert word in text, text

    refused(GOES_ON, "particle 1 lies 0.0001 m from where the deck of", table=moved)
    refused(GOES_ON, "particle 1 of 77 nodes is of another shape, size or angle", table=turned)
    refused(GOES_ON, "5 particles, where the deck of the run in", "had 4", table=three)
    refused(GOES_ON, "no folder or restart file", after=tmp_path / "nowhere")
    how = "with --as" if as_published else "without --as"
    refused(GOES_ON, f"was read {how}", how=not as_published)
    late = GOES_ON | {"Model.Final_Time": 2e-4, "Model.Time_Steps": 2000}
    refused(late, "Model.Final_Time: 0.0002 s is not after")
    inside = 3e-3 - SPEED * END
    words = "half the contact radius" if as_published else "it has grains on both sides"
    refused(GOES_ON, "Particle.Zone_4: put at", words, "it has moved by (0, -0.0004", lid=inside)


def test_times_that_do_not_agree_are_said(first, tmp_path):
    as_published, before = first
    changes = GOES_ON | {"Restart": {"File": "output_2", "Step": 1000}}
    loaded = deck.load(write(tmp_path, changes), as_published, after=before)
    assert loaded.scene.duration == pytest.approx(2e-4)  # from 0.1 ms to 0.3 ms in the deck
    text = "\n".join(loaded.report)
    assert "Restart.Step: 0.0001 s in the deck, though that run has ended at 0.0002" in text
    assert "Restart.File: not read" in text
    assert "IC.Constant_Velocity: not used" in text


def test_the_command_line(first, tmp_path, lmp, capsys):
    as_published, before = first
    path = write(tmp_path, GOES_ON)
    how = ["--as-published"] if as_published else []
    words = [str(path), "--after", str(before), *how]
    assert main(["run", *words, "-o", str(tmp_path / "two"), "--lmp", str(lmp), "-q"]) == 0
    said = capsys.readouterr()
    assert "begins with the end of the run in" in said.err and "reached step" in said.out
    assert main(["convert", *words, "-o", str(tmp_path / "conv")]) == 0
    text = (tmp_path / "conv" / scene.SCRIPT).read_text()
    assert "read_restart    start.restart" in text
    capsys.readouterr()
    for arguments, wanted in (
        (["convert", *words, "-o", str(before)], "holds the run to go on from: say another folder"),
        (["run", str(before / scene.SCRIPT), "--after", "x"], "--after is for scenes and decks"),
        (["convert", str(path), "--after", str(path), *how], "is no restart file of LAMMPS"),
    ):
        assert main(arguments) == 1
        shown = capsys.readouterr().err
        assert wanted in shown and len(shown.splitlines()) == 1, shown


def test_a_scene_in_python_goes_on_too(tmp_path, lmp):
    """The second one sinks its lid faster, from where the first one has left it."""
    for name, speed in (("one", -2.0), ("two", -4.0)):
        (tmp_path / f"{name}.py").write_text(
            f"import scenes\n\n\ndef make_scene():\n"
            f"    walls = scenes.scene.box_walls((0.0, 0.0), (2e-3, 3.9e-3), {speed})\n"
            "    return scenes.two_grains(walls=walls, duration=2e-5)\n"
        )
    words = ["--lmp", str(lmp), "-q", "-o"]
    assert main(["run", str(tmp_path / "one.py"), *words, str(tmp_path / "a")]) == 0
    after = ["--after", str(tmp_path / "a")]
    assert main(["run", str(tmp_path / "two.py"), *after, *words, str(tmp_path / "b")]) == 0
    first, second = results.Output(tmp_path / "a"), results.Output(tmp_path / "b")
    assert (second.frame(0).position == first.frame(-1).position).all()
    # 80 steps of 0.25 us in each
    assert edge(second, -1) == pytest.approx(3.9e-3 - 2e-5 * (2.0 + 4.0), rel=1e-9)
