"""Two ranks under valgrind: no wrong memory, nothing of ours lost.  ``make memcheck`` runs it.

One scene breaks, rubs, is sheared by a wall across a periodic boundary, remembers springs and
restitution, is written to a restart and read again; another has grains in batches, and adaptive.
The program is the own build for any processor that ``test_own_lammps.py`` makes.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from support.clouds import cloud, deformed, join, ragged
from support.invariance import SHEAR, Way, first_half, script, second_half
from support.oracle import Solid
from support.own_build import built
from support.runs import header, lps_words, read_dump

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
    scene = replace(SHEAR, steps=40)
    one = scene.grains()
    one.write(tmp_path / "grains.data")
    text = script(scene, one, Way(2, "2 1 1"), "run").replace("clear\n", "", 1)
    text += first_half(scene, one, "half") + second_half(scene, one, "half", "back")
    check_memory(tmp_path, text)


@pytest.mark.slow
def test_grains_of_one_shape_are_clean_in_batches_and_as_rigid_bodies(tmp_path):
    """Nine copies of one grain drift, meet and break; then those that are not loaded are rigid."""
    rng = np.random.default_rng(5)
    model = ragged(rng, (5, 4))
    place = 6.5 * np.array([[k % 3, k // 3, 0.0] for k in range(9)])
    one = join(
        *(cloud(model.reference + place[k], model.volume, k + 1, dimension=2) for k in range(9)),
        margin=6.0,
    )
    towards = (place.mean(axis=0) - place)[one.molecule - 1]
    one = one.moved(deformed(rng, one, 0.03, 2), 0.3 * towards)
    one.write(tmp_path / "swarm.data")
    solid = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, s0=0.06, viscosity=0.1)
    text = f"""{header(one, "swarm.data", dimension=2, extra="processors 2 1 1")}
        pair_style hybrid/overlay peridem/lps engine batched peridem/contact
        pair_coeff * * peridem/lps {lps_words(solid)}
        pair_coeff * * peridem/contact radius 0.95 restitution 0.5 friction 0.4
        neigh_modify every 5 delay 0 check no
        compute node all peridem/atom damage bonds
        fix motion all nve
        timestep 0.01
        run 100 post no
        unfix motion
        fix motion all peridem/adapt eta 0.2 back 0.5 every 10 hold 2
        run 100 post no
        write_dump all custom end.last id x y c_node[*]
    """
    printed = check_memory(tmp_path, text)
    assert "9 grains computed" in printed
    (end,) = read_dump(tmp_path / "end.last")
    assert end["c_node[1]"].max() > 0.0  # the scene is about breaking, too


def check_memory(folder: Path, text: str) -> str:
    """Run a script on two ranks under valgrind; what LAMMPS printed."""
    valgrind = shutil.which("valgrind")
    if not valgrind:
        pytest.skip("valgrind is not here, and cmake/setup-system.sh could not install it")
    # valgrind does not know the vector instructions of all processors
    executable = os.environ.get("PERIDEM_MEMCHECK") or built("4Jul2026")
    (folder / "in.memcheck").write_text(text)
    words = ["-in", "in.memcheck", "-log", "none", "-nocite"]
    done = subprocess.run(
        ["mpirun", "-np", "2", valgrind, *OPTIONS, executable, *words],
        cwd=folder,
        check=False,
        capture_output=True,
        text=True,
        timeout=1200,
        env=dict(os.environ) | {"OMPI_MCA_btl_vader_single_copy_mechanism": "none"},
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    logs = [path.read_text() for path in folder.glob("memcheck.*")]
    assert len(logs) == 2
    for log in logs:
        found = re.search(r"ERROR SUMMARY: (\d+) errors", log)
        assert found and found[1] == "0", log
        # what MPI keeps for itself is not ours to free
        lost = [part for part in re.split(r"==\d+== \n", log) if "definitely lost in" in part]
        assert not [part for part in lost if "LAMMPS_NS" in part], log
    return done.stdout
