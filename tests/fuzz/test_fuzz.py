"""Whatever the input: an error message, or a run with finite numbers; no crash, no endless loop.

``scripts.py`` makes the input from a number, so that what fails can be repeated:

    FUZZ_FIRST=20000 FUZZ_COUNT=5000 pytest tests/fuzz -m slow

``make sanitize`` runs the same where wrong memory and undefined behaviour stop a run.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import pytest

from fuzz.scripts import Attempt, attempt, run

# a run takes a second where memory is checked and cores are shared: what runs on, runs for ever
SECONDS = 60.0
CHUNK = 40


def faults(mpi, attempts: list[Attempt]) -> list[str]:
    """What went wrong, with the input that did it."""

    def one(what: Attempt) -> str:
        folder = mpi.folder / str(what.seed)
        folder.mkdir()
        (folder / "nodes.data").write_text(what.data)
        wrong, output = run(mpi.executable, what.script, folder, SECONDS)
        if wrong:
            return f"attempt({what.seed}) {wrong}\n{what.script}\n{output[-3000:]}"
        return ""

    with ThreadPoolExecutor(2) as pool:
        return [text for text in pool.map(one, attempts) if text]


@pytest.mark.parametrize("first", range(0, 120, CHUNK))
def test_random_scripts_and_data_files(first, mpi):
    assert not faults(mpi, [attempt(seed) for seed in range(first, first + CHUNK)])


@pytest.mark.slow
def test_many_more(mpi):
    first = int(os.environ.get("FUZZ_FIRST", "10000"))
    count = int(os.environ.get("FUZZ_COUNT", "80"))
    found: list[str] = []
    for start in range(first, first + count, CHUNK):
        seeds = range(start, min(start + CHUNK, first + count))
        found += faults(mpi, [attempt(seed) for seed in seeds])
    assert not found


def test_the_attempts_are_not_all_refused(mpi):
    """Or the rest would say little: some run, and most messages name a word or number."""
    ran = 0
    for seed in range(30):
        what = attempt(seed)
        folder = mpi.folder / str(seed)
        folder.mkdir()
        (folder / "nodes.data").write_text(what.data)
        _, output = run(mpi.executable, what.script, folder, SECONDS)
        ran += output.count("Loop time") == 2
    assert 2 <= ran <= 25


RESTART = """
atom_style peridem
read_restart {name}
pair_coeff * * peridem/lps bulk 30 shear 18 horizon 2.1 s0 0.05
pair_coeff * * peridem/contact radius 0.95 stiffness 300 friction 0.3
fix floor all peridem/wall plane 0 -3 0 0 1 0
fix motion all nve
thermo 5
run 10
"""


def test_restart_files_cut_short(mpi):
    """At forty places, from the first bytes to the last: a message each time."""
    what = attempt(0)
    head = what.script.split("\n")
    script = "\n".join(head[: head.index("read_data nodes.data") + 1])
    script = script.replace(" reference", "").replace("dimension 3", "dimension 2")
    script = "\n".join(
        "boundary f f p" if line.startswith("boundary") else line for line in script.split("\n")
    )
    rows = [f"{k + 1} 1 1 1.0 1.5 {k % 4} {k // 4} 0" for k in range(16)]
    (mpi.folder / "nodes.data").write_text(
        "nodes\n\n16 atoms\n1 atom types\n-20 20 xlo xhi\n-20 20 ylo yhi\n-0.5 0.5 zlo zhi\n\n"
        "Atoms # peridem\n\n" + "\n".join(rows) + "\n"
    )
    script += "\npair_style hybrid/overlay peridem/lps peridem/contact" + RESTART.split("{name}")[
        1
    ].replace("run 10", "run 10\nwrite_restart whole.restart")
    wrong, output = run(mpi.executable, script, mpi.folder, SECONDS)
    assert not wrong and "ERROR" not in output, output[-2000:]
    whole = (mpi.folder / "whole.restart").read_bytes()
    for k in range(40):
        size = (k * len(whole)) // 40
        (mpi.folder / "short.restart").write_bytes(whole[:size])
        wrong, output = run(
            mpi.executable, RESTART.format(name="short.restart"), mpi.folder, SECONDS
        )
        assert not wrong, f"{size} of {len(whole)} bytes: {wrong}\n{output[-2000:]}"
        assert "ERROR" in output, f"{size} of {len(whole)} bytes were taken for a whole file"
    wrong, output = run(mpi.executable, RESTART.format(name="whole.restart"), mpi.folder, SECONDS)
    assert not wrong and "ERROR" not in output
