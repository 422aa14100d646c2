"""The examples that the Python package makes: what they promise, short of their full runs."""

import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from peridem import results, run, scene

pytestmark = pytest.mark.seconds

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture(scope="module")
def compression():
    """The module of the compression example."""
    path = EXAMPLES / "compression" / "compression.py"
    spec = importlib.util.spec_from_file_location("compression", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def made(compression):
    """Its scene, at the speed of the full run."""
    return compression.make_scene(0.3)


def test_compression_has_many_grains_of_four_shapes_and_two_sizes(made):
    kinds = [(grain.cloud.name, f"{grain.cloud.volumes.sum():.3g}") for grain in made.grains]
    assert len(kinds) >= 15
    assert {name for name, _ in kinds} == {"circle", "hexagon", "triangle", "drum"}
    assert len(set(kinds)) == 8  # two sizes of each


def test_compression_starts_without_contact(made):
    nodes = np.vstack([grain.cloud.nodes for grain in made.grains])
    grain = np.concatenate([np.full(len(g.cloud.nodes), k) for k, g in enumerate(made.grains)])
    gaps = np.sqrt(((nodes[:, None] - nodes[None]) ** 2).sum(axis=2))
    assert gaps[grain[:, None] != grain[None]].min() > made.contact_radius
    for wall in made.walls:
        assert ((nodes - wall.point) @ wall.unit_normal).min() > made.contact_radius


def test_compression_runs_on_two_ranks(made, tmp_path, lmp):
    script = made.write(tmp_path)
    text = re.sub(r"^run .*", "run 400", script.read_text(), count=1, flags=re.MULTILINE)
    script.write_text(re.sub(r"( ave/time) \d+ \d+ \d+", r"\1 1 40 40", text))
    run.run(script, ranks=2, lmp=lmp, quiet=True)
    table = results.thermo(tmp_path / run.LOG)
    assert table["Step"][-1] == 400
    assert (table["c_damage"] == 0.0).all()
    record = results.averages(tmp_path / scene.WALLS)
    # the lid moves at its speed, whatever the time step
    assert record["v_lid_travel"][-1] == pytest.approx(0.3 * record["v_now"][-1], rel=1e-6)
    # the step is that of the script's comment, to its two digits, until grains press each other
    assert table["Time"][-1] == pytest.approx(400 * made._timestep()[0], rel=0.05)


def test_compression_only_writes_when_asked_to(tmp_path):
    command = [sys.executable, EXAMPLES / "compression" / "compression.py", "--no-run"]
    ended = subprocess.run(
        [*command, "--output", tmp_path], capture_output=True, text=True, timeout=60
    )
    assert ended.returncode == 0, ended.stderr
    assert {path.name for path in tmp_path.iterdir()} == {
        scene.DATA,
        scene.SCRIPT,
        scene.MESH,
        scene.SUMMARY,
    }
    assert "peridem run" in ended.stdout


def test_first_script_breaks_discs(tmp_path, lmp):
    text = (EXAMPLES / "first_script" / "in.grains").read_text()
    (tmp_path / "in.grains").write_text(re.sub(r"(?m)^run .*", "run 7000", text))
    run.run(tmp_path, lmp=lmp, quiet=True)
    table = results.thermo(tmp_path / run.LOG)
    force, damage = table["f_lid[2]"], table["c_damage"]
    assert force[0] == 0.0 and damage[0] == 0.0
    # its README says that bonds break from 1440 N on and that the most is 2140 N; the thermo output
    # sees only every thousandth step, so the maximum may be passed by
    assert 1400.0 < force.max() < 2200.0
    assert (force[damage == 0.0] < 1600.0).all()
    assert 0.01 < damage[-1] < 0.4
    dump = results.Dump(tmp_path / "grains.dump")
    assert set(dump[0]["mol"]) == {1.0, 2.0, 3.0}
    assert np.isfinite(dump[-1].position).all()
