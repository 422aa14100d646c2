"""The example of 502 grains at its small size: a bed settles, then a lid breaks it.

The published scene needs PeriDEM's deck and three quarters of an hour (see the README there).
"""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from peridem import results, scene

EXAMPLE = Path(__file__).resolve().parents[2] / "examples/compression_502/compression_502.py"


@pytest.fixture(scope="module")
def module():
    """The example's script."""
    spec = importlib.util.spec_from_file_location("compression_502", EXAMPLE)
    found = importlib.util.module_from_spec(spec)
    sys.modules["compression_502"] = found  # where dataclasses look for names
    spec.loader.exec_module(found)
    return found


@pytest.fixture(scope="module")
def pressed(tmp_path_factory, lmp, module):
    """The module, and the folder of its small run."""
    folder = tmp_path_factory.mktemp("compression_502")
    words = ["--small", "-np", "1", "--lmp", str(lmp), "--output", str(folder)]
    assert module.main(words) == 0
    return module, folder


@pytest.mark.slow
def test_the_bed_rests_before_the_lid_comes(pressed):
    module, folder = pressed
    case = module.packed(9, 0.25e-3)
    settled = results.Output(folder / "settled")
    last = settled.frame(-1)
    assert np.sqrt((last.velocity**2).sum(axis=1).mean()) < module.AT_REST
    assert settled.field("damage", -1).max() == 0.0  # they fall as rigid bodies
    # the upper row of three came down by half the room that it had
    assert last.position[:, 1].max() < 0.95 * settled.frame(0).position[:, 1].max()
    # rigid: the first grain's nodes keep their distances but for the dump's nine digits
    mine = last["mol"] == 1
    apart = np.linalg.norm(last.position[mine] - last.position[mine][0], axis=1)
    cloud = case.scene.grains[0].cloud.nodes
    assert apart == pytest.approx(np.linalg.norm(cloud - cloud[0], axis=1), abs=1e-10)
    # the pressed run starts where the settled one ended: up to what the nodes move in one frame
    start = results.Output(folder / "pressed").frame(0)
    assert np.abs(start.position - last.position).max() < 1e-10


@pytest.mark.slow
def test_the_lid_breaks_grains_and_the_numbers_are_those_of_the_files(pressed):
    module, folder = pressed
    found = json.loads((folder / "numbers.json").read_text())
    # 9 grains are chaotic: the range of several runs is 60 to 150 kPa, 5 to 9 grains
    assert 30.0 < found["largest pressure, kPa"] < 300.0
    assert 3 <= found["grains with broken bonds"] <= 9
    assert 0.0 < found["mean damage"] < 0.05
    case = module.packed(9, 0.25e-3)
    travel, pressure = module.stress(folder / "pressed", case)
    assert (pressure[travel < -0.02e-3] < 0.01 * pressure.max()).all()
    assert travel[-1] == pytest.approx(1e-3 * found["deepest penetration, mm"])
    # the pressure is the mean force on the lid over its width
    record = results.averages(folder / "pressed" / scene.WALLS)
    width = 2.3e-3 * 4 + 0.25e-3
    assert pressure == pytest.approx(record["f_lid[2]"] / width, rel=1e-6)
    for picture in ("stress.png", "grains.png"):
        assert (folder / picture).stat().st_size > 10_000


@pytest.mark.slow
def test_the_drift_is_that_of_the_step_and_of_contacts_without_onset(pressed, lmp):
    """From the same state; a fourth power between steps of 0.8 and 0.24 of the largest is 100."""

    def drift(*words: str) -> np.ndarray:
        command = [sys.executable, str(EXAMPLE.parent / "drift.py"), str(pressed[1] / "pressed")]
        done = subprocess.run(
            [*command, "--time", "2e-4", *words, "--lmp", str(lmp)],
            check=True,
            capture_output=True,
            text=True,
        )
        return np.array([line.split() for line in done.stdout.splitlines()[1:]], dtype=float)

    long, short = drift("--onset", "0", "--part", "1.0", "0.3")
    assert [long[0], short[0]] == [1.0, 0.3]
    assert long[1] == pytest.approx(short[1], rel=0.05)  # the same way of the same lid
    assert abs(short[3]) < 0.2 * abs(long[3])
    (smooth,) = drift("--part", "1.0")
    assert abs(smooth[3]) < 0.2 * abs(long[3])


def test_moving_means_keep_straight_lines(module):
    """Away from the ends the mean of a straight line around a point is its value there."""
    travel = np.linspace(0.0, 1.0, 101)
    mean = module.smooth(travel, 3.0 * travel, 0.1)
    inside = (travel > 0.06) & (travel < 0.94)
    assert mean[inside] == pytest.approx(3.0 * travel[inside], abs=0.016)  # half a record's step
    assert module.smooth(travel, np.ones(101), 0.2) == pytest.approx(1.0)
