"""Fragments and forces between grains, from what LAMMPS wrote."""

import re

import numpy as np
import pytest
import scenes
from peridem import results, run, scene
from peridem.material import Contact


@pytest.fixture(scope="module")
def pressed(tmp_path_factory, lmp):
    """Two grains pressed together by the lid; no force but springs, so positions tell all."""
    folder = tmp_path_factory.mktemp("pressed")
    made = scenes.two_grains(
        contact=Contact(stiff=2.0), duration=3e-4, frames=6, attributes=("fragment",)
    )
    script = made.write(folder)
    text = script.read_text().replace("vx vy", "vx vy fx fy", 1)
    # each wall force of its own step instead of an average
    text = re.sub(r"ave/time \d+ \d+ \d+", "ave/time 1 1 1", text)
    script.write_text(text)
    run.run(script, lmp=lmp, quiet=True)
    return results.Output(folder)


def test_forces_from_positions_are_those_of_lammps(pressed):
    """Nodes of the walls: their forces are also in the record of LAMMPS."""
    record = results.averages(pressed.folder / scene.WALLS)
    names = [wall.name for wall in pressed.walls(0.0)]
    largest = 0.0
    for i in range(len(pressed.dump)):
        step = int(pressed.dump.steps[i])
        row = int(np.searchsorted(record["TimeStep"], step))
        if row >= len(record["TimeStep"]) or record["TimeStep"][row] != step:
            continue
        found = results.wall_forces(pressed, i)
        for name in names:
            total = found[name][1].sum(axis=0)
            on_wall = np.array([record[f"f_{name}[{k}]"][row] for k in (1, 2)])
            # positions have nine digits, of overlaps of 1e-6 in 4e-3: 1e-5 at worst; the log prints
            # the spring with six; friction is absent
            assert total == pytest.approx(-on_wall, rel=1e-3, abs=1e-3 * (1.0 + largest))
            largest = max(largest, float(np.abs(total).max()))
    assert largest > 10.0


def test_momentum_of_a_grain_tells_the_force_between_grains(pressed):
    """Newton: forces on the nodes of a grain add up to contacts, walls and weight."""
    i = len(pressed.dump) - 1
    frame = pressed.frame(i)
    found = results.network(results.contacts(pressed, i))
    assert found.bodies.tolist() == [[1, 2]]
    walls = results.wall_forces(pressed, i)
    for grain, sign in ((1, -1.0), (2, 1.0)):
        mine = frame["mol"] == grain
        total = np.array([frame["fx"][mine].sum(), frame["fy"][mine].sum()])
        expected = sign * found.force[0] + 1200.0 * pressed.volumes[mine].sum() * np.array([0, -10])
        for names, forces in walls.values():
            expected = expected + forces[names == grain].sum(axis=0)
        # as above, and forces have six digits
        assert total == pytest.approx(expected, rel=1e-3, abs=1e-3 * found.strength[0])
    assert found.strength[0] > 10.0
    assert found.coordination(np.array([1, 2, 3])).tolist() == [1, 1, 0]
    upper, lower = (frame.position[frame["mol"] == grain][:, 1] for grain in (2, 1))
    reach = pressed.contact_radius
    assert upper.min() - reach < found.point[0, 1] < lower.max() + reach


def test_fragments_add_up_to_the_grains(pressed):
    for i in (0, len(pressed.dump) - 1):
        pieces = results.fragments(pressed, i)
        assert pieces.nodes.sum() == len(pressed.reference)
        assert pieces.volume.sum() == pytest.approx(pressed.volumes.sum())
        assert (np.diff(pieces.volume) <= 0.0).all()
        assert pieces.finer(pieces.size.max()) == pytest.approx(1.0)
        assert pieces.finer(0.0) == 0.0
    whole = results.fragments(pressed, 0)
    assert len(whole) == 2 and sorted(whole.grain.tolist()) == [1, 2]
    # the diameter of the circle of the same area
    assert np.pi / 4.0 * whole.size**2 == pytest.approx(whole.volume)


def written(folder, x, mol, extra=(), columns="", box="ff ff pp"):
    """A run by hand: a dump with positions and a log that tells the contact law."""
    rows = [
        (k + 1, m, 1, *p, *e)
        for k, (m, p, e) in enumerate(zip(mol, x, extra or [()] * len(x), strict=True))
    ]
    scenes.write_dump(folder / "a.dump", [(0, rows)], f"id mol type x y {columns}".strip())
    path = folder / "a.dump"
    path.write_text(path.read_text().replace("ff ff pp", box))
    (folder / "in.a").write_text(
        "dimension 2\ncompute q all peridem/atom fragment\ndump d all custom 1 a.dump id\n"
    )
    law = "PERIDEM: contact of types 1 1: radius 0.1, spring 50, friction 0\n"
    (folder / "log.lammps").write_text(law)
    return results.Output(folder)


def test_overlap_times_spring(tmp_path):
    output = written(tmp_path, [(0.5, 0.5), (0.58, 0.5), (0.75, 0.5)], [1, 2, 3])
    found = results.contacts(output, 0)
    assert found.nodes.tolist() == [[0, 1]]
    assert found.overlap == pytest.approx([0.02])
    assert found.force == pytest.approx(np.array([[1.0, 0.0]]))
    assert found.point == pytest.approx(np.array([[0.54, 0.5]]))


def test_contacts_reach_across_a_periodic_side(tmp_path):
    output = written(tmp_path, [(0.03, 0.5), (0.97, 0.5)], [1, 2], box="pp ff pp")
    found = results.contacts(output, 0)
    assert found.overlap == pytest.approx([0.04])
    assert found.force == pytest.approx(np.array([[-2.0, 0.0]]))


def test_fragments_of_a_grain_touch_within_their_first_distance(tmp_path):
    """Inside one grain nodes touch below min(R_c, R)."""
    x = [(0.5, 0.5), (0.58, 0.5)]
    output = written(tmp_path, x, [1, 1], [(1,), (2,)], "c_q")
    assert results.labels(output, 0).tolist() == [1, 2]
    assert len(results.contacts(output, 0, results.labels(output, 0))) == 0
    assert len(results.contacts(output, 0)) == 0


def test_too_few_digits_are_said(tmp_path):
    output = written(tmp_path, [(100.5, 0.5), (100.599, 0.5)], [1, 2])
    with pytest.warns(UserWarning, match="six digits, to 0.001, overlaps are about 0.001"):
        results.contacts(output, 0)


def test_a_run_without_contacts_is_said(tmp_path):
    output = written(tmp_path, [(0.5, 0.5), (0.58, 0.5)], [1, 2])
    (tmp_path / "log.lammps").write_text("nothing\n")
    output = results.Output(tmp_path)
    with pytest.raises(ValueError, match="tells of no contacts"):
        results.contacts(output, 0)


def test_stress_from_the_first_lasting_contact():
    travel = np.arange(20.0)
    stress = np.where(travel >= 8, travel - 7.0, 0.0)
    stress[2] = 5.0  # a grain that bounces
    assert results.from_contact(travel, stress, lasting=5)[8] == 0.0
    with pytest.raises(ValueError, match="no contact that lasts for 15"):
        results.from_contact(travel, stress, lasting=15)


def test_a_folder_of_plain_lammps_has_cells_and_walls(tmp_path, lmp):
    """No mesh, no summary: from the script and the first frame."""
    from pathlib import Path

    example = Path(__file__).resolve().parents[2] / "examples" / "first_script" / "in.grains"
    text = re.sub(r"(?m)^run .*", "run 200", example.read_text())
    (tmp_path / "in.grains").write_text(re.sub("all custom 500", "all custom 100", text))
    run.run(tmp_path, lmp=lmp, quiet=True)
    output = results.Output(tmp_path)
    assert output.dimension == 2
    assert [wall.name for wall in output.walls(0.0)] == ["floor", "west", "east", "lid"]
    assert output.walls(1e-3)[3].point[1] == pytest.approx(4e-3 - 0.25e-3)
    assert output.contact_radius == pytest.approx(0.95 * 1.4e-4, rel=1e-5)
    # each lattice disc of 168, 168, 163 nodes is one fragment, and cells fill nearly all of it
    pieces = results.fragments(output, -1)
    assert sorted(pieces.nodes.tolist()) == [163, 168, 168]
    disc = np.pi * 0.95e-3**2
    assert (0.8 * disc < pieces.volume).all() and (pieces.volume < disc).all()
    assert output.field("damage", 0).max() == 0.0
