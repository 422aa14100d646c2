"""Scenes in stages: a run that begins with the state that another one has left."""

import re
from dataclasses import replace

import numpy as np
import pytest
import scenes
from peridem import cloud, results, run, scene, shapes, stages
from peridem.loads import Cut, Motion, Nodes
from peridem.material import Contact
from peridem.regions import Block, Cylinder, Rotation

pytestmark = pytest.mark.seconds

DT = 2.5e-7
PLAIN = replace(scenes.SOLID, viscosity=0.0)


def bed(**changes):
    """A hexagon above a disc under a sinking lid, without forces that depend on velocity."""
    grains = [replace(grain, material=PLAIN) for grain in scenes.two_grains().grains]
    words = {"grains": grains, "contact": Contact(stiff=2.0), "duration": 160 * DT}
    return scenes.two_grains(**(words | changes))


def ended(made, folder):
    run.run(made.write(folder), quiet=True)
    return results.Output(folder)


def test_two_stages_are_one_run(tmp_path):
    first = bed()
    ended(first, tmp_path / "first")
    second = ended(first.after(tmp_path / "first", title="on"), tmp_path / "second")
    whole = ended(replace(first, duration=320 * DT), tmp_path / "whole")
    assert second.dump.steps[0] == 160 and second.dump.steps[-1] == whole.dump.steps[-1] == 320
    assert second.time(-1) == pytest.approx(320 * DT, rel=1e-9)  # nine digits in the dump
    # bit for bit but for the order of sums; dumps hold nine digits of lengths of some mm
    one, two = whole.frame(-1), second.frame(-1)
    assert two.position == pytest.approx(one.position, rel=0.0, abs=5e-12)
    # the lid has gone on from where it was, in LAMMPS and in pictures
    assert two.velocity == pytest.approx(one.velocity, rel=0.0, abs=1e-7)
    lids = [output.walls(output.time(-1))[-1].point[1] for output in (whole, second)]
    assert lids[1] == pytest.approx(lids[0], rel=1e-9)
    assert lids[1] == pytest.approx(3.9e-3 - 2.0 * 320 * DT, rel=1e-9)


def test_pressed_and_released(tmp_path):
    """Broken bonds and overlaps are there in the second stage; its lid goes back."""
    first = bed(duration=900 * DT, walls=scene.box_walls((0, 0), (2e-3, 3.7e-3), -4.0))
    before = ended(first, tmp_path / "first")
    down = first.walls[-1]
    second = first.after(
        tmp_path / "first", walls=[*first.walls[:-1], replace(down, velocity=(0, 4.0))]
    )
    assert second.shift_of(down) == pytest.approx([0.0, -4.0 * 900 * DT], rel=1e-9)
    left = stages.grains_after(first, tmp_path / "first")
    ends = np.vstack([grain.cloud.nodes + grain.displacement for grain in left])
    assert ends == pytest.approx(before.frame(-1).position[:, :2], rel=0.0, abs=1e-18)
    assert (np.vstack([grain.velocity for grain in left]) == before.frame(-1).velocity[:, :2]).all()
    after = ended(second, tmp_path / "second")
    assert before.field("damage", -1).max() > 0.0  # something is broken
    assert (after.field("damage", 0) == before.field("damage", -1)).all()
    assert after.frame(0).position == pytest.approx(before.frame(-1).position, abs=1e-15)
    points = [after.walls(after.time(i))[-1].point[1] for i in (0, -1)]
    start = 3.7e-3 - 4.0 * 900 * DT
    assert points == pytest.approx([start, start + 4.0 * 900 * DT], rel=1e-9)
    force = results.averages(tmp_path / "second" / scene.WALLS)["f_lid[2]"]
    assert force[-1] < 0.5 * force[0]  # pressed, then let go (it springs back after the lid)


def test_settled_rigid_then_deformable(tmp_path):
    """Grains settle as rigid bodies, in long steps, until they rest; then a lid comes."""
    box = scene.box_walls((0.0, 0.0), (2e-3, 3.9e-3))[:-1]
    settling = bed(
        walls=box,
        contact=Contact(stiff=2.0, restitution=0.2, friction=0.3),
        duration=0.2,
        timestep=None,
        adapt="eta 1e9",
        rest=2e-3,
        frames=20,
    )
    output = ended(settling, tmp_path / "bed")
    assert output.time(-1) < 0.1  # it ended early
    moving = output.thermo["KinEng"][-1]
    mass = 1200.0 * output.volumes.sum()
    assert moving < 0.5 * mass * 2e-3**2
    top = output.frame(-1).position[:, 1].max()
    lid = scene.Wall("lid", (0.0, top + 2e-4), (0.0, -1.0), (0.0, -1.0))
    press = settling.after(
        tmp_path / "bed", walls=[*box, lid], adapt=None, rest=None, duration=2e-4, title="Pressing"
    )
    assert press.start_time == output.thermo["Time"][-1]
    pressed = ended(press, tmp_path / "press")
    assert "peridem/adapt" not in pressed.script
    assert pressed.field("stretch", -1).max() > 10.0 * pressed.field("stretch", 0).max()
    travel = pressed.thermo["v_lid_travel"]
    # counted from here, whose time the log has in eight digits; the end is looked for every ten
    # steps of less than a microsecond
    assert abs(travel[0]) < 1e-9 and 2e-4 <= travel[-1] < 2.1e-4
    assert pressed.time(-1) == pytest.approx(pressed.thermo["Time"][-1], rel=1e-7)


def test_a_drum_turns_after_its_grains_have_settled(tmp_path):
    """... and goes on, faster, and stops, without a jump."""
    drum = scene.RegionWall("drum", Cylinder((0.0, 0.0), 3e-3))
    disc = cloud.mesh(shapes.circle(8e-4), 2e-4)
    turn = Rotation(2.0, (0.0, 0.0))
    made = scene.Scene(
        title="A drum",
        grains=[scene.Grain(disc, PLAIN)],
        contact=Contact(stiff=2.0),
        walls=[drum],
        duration=100 * DT,
        timestep=DT,
        frames=1,
        records=10,
    )
    angles = []
    for stage, rotation in enumerate([None, turn, Rotation(5.0, (0.0, 0.0)), None]):
        folder = tmp_path / f"{stage}"
        if stage:
            walls = [replace(drum, rotation=rotation)]
            made = made.after(tmp_path / f"{stage - 1}", walls=walls)
        output = ended(made, folder)
        angles += [output.regions(output.time(i))[0].angle for i in (0, -1)]
    w = 100 * DT
    expected = [0, 0, 0, 2 * w, 2 * w, 7 * w, 7 * w, 7 * w]
    assert angles == pytest.approx(expected, rel=1e-6, abs=1e-15)  # times have nine digits


def test_a_box_that_must_grow(tmp_path):
    """A floor that was the end of the box is taken away: nodes that fall through are not lost."""
    first = bed()
    ended(first, tmp_path / "first")
    assert "change_box" not in first.after(tmp_path / "first").script()
    fall = first.after(tmp_path / "first", walls=first.walls[1:3], gravity=(0.0, -1e6))
    assert re.search(r"change_box +all boundary f s p", fall.script())
    output = ended(fall, tmp_path / "fall")
    assert output.frame(-1).position[:, 1].min() < -5e-4


def test_groups_are_made_anew(tmp_path):
    """The nodes held in the second stage are not those of the first."""
    first = bed(motions=[Motion.held("held", Nodes((1,)))], walls=())
    ended(first, tmp_path / "first")
    second = first.after(tmp_path / "first", motions=[Motion.held("held", Nodes((2,)))])
    output = ended(second, tmp_path / "second")
    disc = output.frame(0)["mol"] == 1
    moved = np.abs(output.frame(-1).position - output.frame(0).position).max(axis=1)
    assert (moved[~disc] == 0.0).all() and (moved[disc] > 0.0).all()


def test_what_a_second_stage_cannot_be(tmp_path):
    first = bed()
    with pytest.raises(FileNotFoundError, match="no folder or restart file"):
        first.after(tmp_path / "nothing")
    first.write(tmp_path / "first")
    with pytest.raises(FileNotFoundError, match=r"no grains.restart in .*: has its run ended\?"):
        first.after(tmp_path / "first")
    ended(first, tmp_path / "first")
    with pytest.raises(ValueError, match="its grains are those of the run"):
        first.after(tmp_path / "first", grains=first.grains)
    other = bed(grains=first.grains[:1])
    with pytest.raises(ValueError, match=r"its 1 grains of .* nodes are not those of"):
        other.after(tmp_path / "first")
    lid = replace(first.walls[-1], point=(0.0, 3.8e-3))
    with pytest.raises(ValueError, match="wall 'lid' goes on from where it is"):
        first.after(tmp_path / "first", walls=[lid])
    with pytest.raises(ValueError, match="must be said in the first stage already"):
        cut = Cut.within(Block((0.0, 0.0), (1e-3, 1e-3)))
        first.after(tmp_path / "first", cuts=[cut])
    with pytest.raises(ValueError, match=r"reaches .* through the wall 'low'"):
        low = scene.Wall("low", (0.0, 1e-3), (0.0, -1.0))
        first.after(tmp_path / "first", walls=[low])
    with pytest.raises(ValueError, match="scene: rest must be above 0"):
        bed(rest=0.0)
