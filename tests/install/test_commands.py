"""Every command that a page shows can be typed: programs, files, targets and options exist.

The blocks of howtos are run (``test_howtos.py``), and those of some other pages (``test_cli.py``,
``test_readme.py``); here all of them are looked at, those in running text too.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from support import commands
from support.commands import ROOT, Command

PAGES = sorted({str(one.page.relative_to(ROOT)) for one in commands.commands()})


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES)
def test_the_commands_of_a_page_exist(page: str) -> None:
    asked = [one for one in commands.commands() if one.page == ROOT / page]
    assert asked
    told = {one.text: commands.wrong(one) for one in asked}
    assert {text: why for text, why in told.items() if why} == {}


def test_the_commands_are_found() -> None:
    texts = {one.text for one in commands.commands()}
    assert len(texts) > 80
    assert len(PAGES) > 25
    assert {
        "make demo",
        "cmake --build ../lammps/build",
        "peridem plot out/demo --fragments",
        ".venv/bin/peridem convert two.yaml -o out/two",
        "python compaction.py --small",
        "python -m bench memory",
        "build/lmp -in in.discs",
    } <= texts


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("make tests", "no target tests"),
        ("BENCH_ARG=kernels make bench", "no BENCH_ARG"),
        ("BENCH_ARGS=kernel make bench", "no part kernel"),
        ("peridem rendr out/demo", "invalid choice"),
        ("peridem render out/demo --feild speed", "unrecognized arguments"),
        ("python doc/howto.py", "howto.py is not there"),
        ("python doc/howtos.py --kep out", "no option --kep"),
        ("python -m bench levls", "no part levls"),
        ("python -m support.strips", "no module"),
        ("mpirun -n 2 lmp -in in.x", "-np"),
        ("mpirun -np 2 lmp -in in.x", "in.x is not there"),
        ("cmake -S . -B build -D PERIDEM_NATVE=ON", "PERIDEM_NATVE"),
        ("cmake/setup-pythn.sh .venv", "nobody knows"),
        ("lamps -in in.grains", "nobody knows"),
    ],
)
def test_mistakes_are_found(text: str, why: str) -> None:
    assert why in commands.wrong(Command(ROOT / "README.md", text, whole=True))


def test_make_knows_how_to_do_every_target() -> None:
    """``make -n`` prints what it would do; a target of a missing file would end it."""
    listed = re.search(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(), re.M)
    assert listed
    for target in set(listed[1].split()) - {"FORCE"}:
        done = subprocess.run(["make", "-n", target], cwd=ROOT, text=True, capture_output=True)
        assert done.returncode == 0, f"{target}: {done.stderr}"


def test_a_page_is_read_as_its_reader_does(tmp_path: Path) -> None:
    page = tmp_path / "README.md"
    page.write_text("Do\n\n    make demo    # a box\n    python x.py      later\n\n    a = b\n")
    assert commands.blocks(page) == ["    make demo    # a box\n    python x.py      later\n"]
    assert commands.pieces("    python x.py --small    9 coarser") == ["python x.py --small"]
    assert commands.pieces("(cd out && ../lmp -in a -screen none) &") == [
        "cd out",
        "../lmp -in a -screen none",
    ]
