"""Two ranks under valgrind: no wrong memory, nothing of ours lost.  ``make memcheck`` runs it.

The scene breaks, rubs, is sheared by a wall across a periodic boundary, remembers springs and
restitution, is written to a restart and read again.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from support.invariance import SHEAR, Way, first_half, script, second_half

HERE = Path(__file__).resolve().parent
OPTIONS = [
    "--leak-check=full",
    "--show-leak-kinds=definite",
    "--errors-for-leak-kinds=none",
    f"--suppressions={HERE.parent / 'memcheck.supp'}",
    "--log-file=memcheck.%p",
]


@pytest.mark.slow
def test_a_small_scene_on_two_ranks_is_clean(tmp_path):
    executable, valgrind = os.environ.get("PERIDEM_MEMCHECK"), shutil.which("valgrind")
    if not executable or not valgrind:
        pytest.skip("needs valgrind and PERIDEM_MEMCHECK=/path/to/lmp without vector instructions")
    scene = replace(SHEAR, steps=40)
    one = scene.grains()
    one.write(tmp_path / "grains.data")
    text = script(scene, one, Way(2, "2 1 1"), "run").replace("clear\n", "", 1)
    text += first_half(scene, one, "half") + second_half(scene, one, "half", "back")
    (tmp_path / "in.memcheck").write_text(text)
    words = ["-in", "in.memcheck", "-log", "none", "-nocite"]
    done = subprocess.run(
        ["mpirun", "-np", "2", valgrind, *OPTIONS, executable, *words],
        cwd=tmp_path,
        check=False,
        capture_output=True,
        text=True,
        timeout=1200,
        env=dict(os.environ) | {"OMPI_MCA_btl_vader_single_copy_mechanism": "none"},
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    logs = [path.read_text() for path in tmp_path.glob("memcheck.*")]
    assert len(logs) == 2
    for log in logs:
        found = re.search(r"ERROR SUMMARY: (\d+) errors", log)
        assert found and found[1] == "0", log
        # what MPI keeps for itself is not ours to free
        lost = [part for part in re.split(r"==\d+== \n", log) if "definitely lost in" in part]
        assert not [part for part in lost if "LAMMPS_NS" in part], log
