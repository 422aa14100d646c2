"""Series of runs side by side: all end, one fails, all are stopped, one is killed."""

import os
import signal
import stat
import subprocess
import sys
import threading
import time

import pytest
import scenes
from peridem import run, scene
from peridem.run_many import run_many

pytestmark = pytest.mark.seconds


def falling(folder, **changes):
    """A short scene in a folder of its own."""
    return scenes.two_grains(walls=(), **changes).write(folder)


def test_all_runs_end_and_reports_keep_their_order(tmp_path, lmp):
    durations = (3e-5, 1e-5, 2e-5)
    scripts = [falling(tmp_path / f"{k}", duration=t) for k, t in enumerate(durations)]
    reports = run_many(scripts, 2, lmp, quiet=True)
    assert not any(report.stopped for report in reports)
    first, second, third = (report.steps for report in reports)
    assert first > third > second
    assert all((script.parent / scene.RESTART).is_file() for script in scripts)


def test_a_failure_is_told_and_stops_the_others(tmp_path, lmp):
    scripts = [falling(tmp_path / f"{k}", duration=1.0) for k in range(3)]
    bad = tmp_path / "bad" / "in.bad"
    bad.parent.mkdir()
    bad.write_text("units si\npair_style no_such_style\n")
    begin = time.monotonic()
    with pytest.raises(run.RunError, match="no_such_style"):
        run_many([bad, *scripts], 2, lmp, quiet=True)
    assert time.monotonic() - begin < 60.0  # each of the others would take an hour
    # the last one has never started
    assert not (tmp_path / "2" / run.LOG).exists()


def test_a_request_to_stop_reaches_all(tmp_path, lmp):
    scripts = [str(falling(tmp_path / f"{k}", duration=1.0)) for k in range(3)]
    code = (
        "from peridem.run_many import run_many\n"
        f"for report in run_many({scripts!r}, 2, {str(lmp)!r}, quiet=True):\n"
        "    print(report.stopped, report.steps > 0)\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as job:
        guard = threading.Timer(60.0, job.kill)
        guard.start()
        begun = [tmp_path / f"{k}" / scene.DUMP for k in range(2)]
        while job.poll() is None and not all(path.exists() for path in begun):
            time.sleep(0.1)
        time.sleep(0.5)
        os.kill(job.pid, signal.SIGTERM)
        output = job.communicate()[0]
        guard.cancel()
    assert output.splitlines() == ["True True", "True True", "True False"]
    assert all((tmp_path / f"{k}" / scene.RESTART).stat().st_size > 1000 for k in range(2))


def test_wrong_series_are_refused(tmp_path, lmp):
    script = falling(tmp_path, duration=1e-5)
    with pytest.raises(ValueError, match="each needs a folder of its own"):
        run_many([script, script], lmp=lmp)
    with pytest.raises(ValueError, match="at_once must be at least 1, not 0"):
        run_many([script], 0, lmp)
    assert run_many([], lmp=lmp, quiet=True) == []


def test_a_program_that_is_killed_is_told_with_its_signal(tmp_path):
    script = falling(tmp_path, duration=1e-5)
    program = tmp_path / "lmp"
    program.write_text("#!/bin/sh\nkill -9 $$\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    with pytest.raises(run.RunError, match="ended by signal 9"):
        run.run(script, lmp=program, quiet=True)
