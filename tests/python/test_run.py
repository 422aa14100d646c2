"""Runs: scenes through LAMMPS and back, failures, stops."""

import importlib.util
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import scenes
from peridem import results, run, run_failure, run_progress, run_script, scene

REFUSED = """\
# a script with a mistake
units si
dimension 2

pair_style no_such_style 1.0   # line 5
"""


def test_scene_goes_through_lammps_and_comes_back(tmp_path, lmp):
    made = scenes.two_grains()
    report = run.run(made.write(tmp_path), ranks=2, lmp=lmp, quiet=True)
    assert not report.stopped
    total = run_script.total_steps((tmp_path / scene.SCRIPT).read_text())
    assert report.steps == total
    dump = results.Dump(tmp_path / scene.DUMP)
    assert dump.steps[0] == 0 and dump.steps[-1] == total
    # the first frame is the data file, to the six digits of a dump
    nodes = np.vstack([grain.cloud.nodes for grain in made.grains])
    assert dump[0].position == pytest.approx(nodes, rel=1e-5, abs=1e-12)
    grains = np.concatenate([np.full(len(g.cloud.nodes), k) for k, g in enumerate(made.grains, 1)])
    assert (dump[0]["mol"] == grains).all()
    assert (dump[0]["c_node[1]"] == 0.0).all()
    # until the lid comes, both fall freely: by g t^2/2 whatever happens inside them
    table = results.thermo(tmp_path / run.LOG)
    assert table["Step"][-1] == total
    averages = results.averages(tmp_path / scene.WALLS)
    assert len(averages["TimeStep"]) == pytest.approx(made.records, abs=2)
    assert (tmp_path / scene.RESTART).is_file()
    assert not (tmp_path / "screen.txt").exists()


@pytest.mark.parametrize(("end_time", "done"), [(None, 40), (2e-4, 40), (None, 100)])
def test_the_line_of_progress_ends_with_the_time_taken(end_time, done, capsys):
    """Also where a run ends before its bar does: halted, stopped."""
    state = run_progress.State(step=done, time=1e-6 * done, broken=3)
    with run_progress.bar(100, quiet=False, end_time=end_time) as shown:
        shown.show(state)
        shown.end(state, "ended")
    last = capsys.readouterr().err.splitlines()[-1]
    assert f"ended, step {done}" in last and "3 broken 0:00:00 taken" in last


def test_time_and_drift_are_shown_with_their_units(tmp_path):
    """Of LAMMPS's table of units; lj has none."""
    log, reports = tmp_path / "log", tmp_path / "reports"
    log.write_text("   Step   c_books[8]\n 40 -1.25e-7\n")
    reports.write_text("40 2.5e-06 12\n")
    shown = {}
    for units in ("si", "lj", "micro"):
        follower = run_progress.Follower(log, reports, ("c_books[8]",), units)
        shown[units] = str(follower.update())
    assert shown["si"] == "t 2.5e-06 s, 12 broken, drift -1.2e-07 J"
    assert shown["lj"] == "t 2.5e-06, 12 broken, drift -1.2e-07"
    assert shown["micro"] == "t 2.5e-06 us, 12 broken, drift -1.2e-07 pg um^2/us^2"


def test_the_units_of_a_script(tmp_path):
    """Also in an included file; of a restart file that is not there they are not known."""
    (tmp_path / "head").write_text("units cgs\n")
    for text, units in (
        ("units si # units lj\nrun 1\n", "si"),
        ("include head\nrun 1\n", "cgs"),
        ("run 1\n", "lj"),
        ("read_restart settled.restart\nrun 1\n", ""),
    ):
        assert run_script.units(text, tmp_path) == units


def test_grains_without_walls_fall_freely(tmp_path, lmp):
    made = scenes.two_grains(walls=(), duration=2e-4)
    run.run(made.write(tmp_path), lmp=lmp, quiet=True)
    dump = results.Dump(tmp_path / scene.DUMP)
    time_passed = dump.steps[-1] * made._timestep()[0]
    volumes = np.concatenate([grain.cloud.volumes for grain in made.grains])
    fallen = volumes @ (dump[0]["y"] - dump[-1]["y"]) / volumes.sum()
    speed = volumes @ dump[-1]["vy"] / volumes.sum()
    # velocity Verlet is exact here; speeds have the six digits of a dump, positions of 4e-3 too,
    # which leaves 4e-9 of 2e-7
    assert speed == pytest.approx(-10.0 * time_passed, rel=1e-5)
    assert fallen == pytest.approx(5.0 * time_passed**2, abs=4e-9)


def test_mass_and_its_centre_are_what_the_scene_says(tmp_path, lmp):
    made = scenes.two_grains(walls=())
    script = made.write(tmp_path)
    text = script.read_text().split("# ---- output")[0]
    text += "variable m equal mass(all)\nvariable y equal xcm(all,y)\n"
    text += "thermo_style custom step v_m v_y\nrun 0\n"
    (tmp_path / "in.check").write_text(text)
    run.run(tmp_path / "in.check", lmp=lmp, quiet=True)
    table = results.thermo(tmp_path / run.LOG)
    clouds = [grain.cloud for grain in made.grains]
    volume = sum(cloud.volumes.sum() for cloud in clouds)
    height = sum(cloud.volumes @ cloud.nodes[:, 1] for cloud in clouds) / volume
    # thermo output has about eight digits
    assert table["v_m"][0] == pytest.approx(1200.0 * volume, rel=1e-6)
    assert table["v_y"][0] == pytest.approx(height, rel=1e-6)


@pytest.mark.seconds
def test_the_lammps_module_gives_the_same_run(tmp_path, lmp):
    if importlib.util.find_spec("lammps") is None and not os.environ.get("PERIDEM_TESTS_MUST_RUN"):
        pytest.skip("no lammps module")
    for name in ("program", "module"):
        scenes.two_grains().write(tmp_path / name)
    run.run(tmp_path / "program", lmp=lmp, quiet=True)
    code = f"from peridem.run import run_in_process as go; print(go({str(tmp_path / 'module')!r}))"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert ended.returncode == 0, ended.stderr
    assert "stopped=False" in ended.stdout
    one, two = (results.Dump(tmp_path / name / scene.DUMP) for name in ("program", "module"))
    # the same library on one rank: the same numbers
    assert one.steps.tolist() == two.steps.tolist()
    assert (one[-1].position == two[-1].position).all()


def test_failure_says_what_lammps_said_and_where(tmp_path, lmp):
    (tmp_path / "in.wrong").write_text(REFUSED)
    for ranks in (1, 2):
        with pytest.raises(run.RunError) as failed:
            run.run(tmp_path, ranks=ranks, lmp=lmp, quiet=True)
        message = str(failed.value)
        assert "nrecognized pair style 'no_such_style'" in message
        assert f"at line 5 of {tmp_path / 'in.wrong'}" in message


def test_a_crash_is_told_from_a_message(tmp_path):
    (tmp_path / "in.a").write_text("run 1\n")
    said = (
        "Section |  min time\n" + 63 * "-" + "\nPair |\n" + "\n".join("abcde")
    )  # of a piece before
    crash = "exited on signal 11 (Segmentation fault).\n"
    for end in (f"{74 * '-'}\nmpirun: process rank 0 {crash}{74 * '-'}\n", f"lmp {crash}"):
        message = run_failure.failure(f"{said}\n{end}", tmp_path / "in.a")
        assert "ended by signal 11 (Segmentation fault), after\na\nb\nc\nd\ne\nin " in message
    assert "without a message, after\none" in run_failure.failure("one\n", tmp_path / "in.a")


@pytest.mark.seconds
def test_a_stop_leaves_a_restart(tmp_path, lmp):
    """SIGINT to the process that runs it, as Ctrl-C does; the run would take an hour."""
    script = scenes.two_grains(duration=1.0, walls=(), gravity=(0.0, 0.0)).write(tmp_path)
    text = script.read_text()
    script.write_text(text.replace("fix halt all halt", "fix halt all halt 100 v_halted > 0 #"))
    code = (
        f"from peridem import run\nprint(run.run({str(script)!r}, lmp={str(lmp)!r}, quiet=True))\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as job:
        guard = threading.Timer(40.0, job.kill)
        guard.start()
        while job.poll() is None and not (tmp_path / scene.DUMP).exists():
            time.sleep(0.1)
        time.sleep(0.5)
        os.kill(job.pid, signal.SIGINT)
        output = job.communicate()[0]
        guard.cancel()
    assert "stopped=True" in output
    assert (tmp_path / scene.RESTART).stat().st_size > 1000
    assert not (tmp_path / scene.STOP).exists()


def test_what_cannot_be_started_is_refused(tmp_path, monkeypatch):
    monkeypatch.delenv("LAMMPS_LMP", raising=False)
    with pytest.raises(run.RunError, match="no program /no/such/lmp"):
        run.find_lmp("/no/such/lmp")
    with pytest.raises(FileNotFoundError, match="no input script"):
        run.find_script(tmp_path)
    for name in ("in.a", "in.b"):
        (tmp_path / name).write_text("run 1\n")
    with pytest.raises(ValueError, match=r"several input scripts .* in\.a, in\.b"):
        run.find_script(tmp_path)
    with pytest.raises(ValueError, match="ranks must be at least 1"):
        run.run(tmp_path / "in.a", ranks=0)


def test_steps_are_added_up(tmp_path):
    text = "run 100\n  run 250 # more\n# run 7\nprint run\nrun_style x\n"
    assert run_script.total_steps(text) == 350


def test_lammps_finds_the_same_step_for_the_bonds(tmp_path, lmp):
    """``compute peridem/dt`` and :mod:`peridem.timestep` are written apart from each other."""
    made = scenes.two_grains()
    script = made.write(tmp_path)
    text = script.read_text().split("# ---- output")[0]
    text += "compute limit all peridem/dt\nthermo_style custom step c_limit[1] c_limit[2]\nrun 0\n"
    (tmp_path / "in.check").write_text(text)
    run.run(tmp_path / "in.check", lmp=lmp, quiet=True)
    table = results.thermo(tmp_path / run.LOG)
    # both iterate to about 1e-3, and neither may be far above the true limit
    assert table["c_limit[1]"][0] == pytest.approx(made.stable_step().bonds, rel=5e-3)
