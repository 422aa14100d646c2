"""The README tells the truth: its script runs and breaks grains, its links lead somewhere."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
README = (REPOSITORY / "README.md").read_text()
LMP = Path(os.environ.get("LAMMPS_LMP", REPOSITORY / "build" / "lmp"))


def _script() -> str:
    block = re.search(r"^```\n(units .*?)^```$", README, re.MULTILINE | re.DOTALL)
    assert block, "README.md has no block that starts with a units command"
    return block[1]


@pytest.fixture(scope="module")
def course(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[float], list[np.ndarray]]:
    """Times, and rows ``id mol x y damage`` sorted by id, of every dump of the README's script."""
    if not LMP.exists():
        pytest.skip(f"{LMP} is not there: make build")
    folder = tmp_path_factory.mktemp("readme")
    (folder / "in.discs").write_text(_script())
    command = [LMP, "-in", "in.discs", "-nocite"]
    done = subprocess.run(command, cwd=folder, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    thermo = re.findall(
        r"^ +(\d+) +([0-9.eE+-]+) ", (folder / "log.lammps").read_text(), re.MULTILINE
    )
    times = [float(time) for step, time in thermo if int(step) % 1000 == 0]
    lines = (folder / "grains.dump").read_text().splitlines()
    tables = []
    for start in (k for k, line in enumerate(lines) if line.startswith("ITEM: ATOMS")):
        count = int(lines[start - 5])
        rows = [line.split() for line in lines[start + 1 : start + 1 + count]]
        table = np.array(rows, dtype=float)
        tables.append(table[np.argsort(table[:, 0])])
    return times, tables


def test_the_script_writes_what_it_says(course: tuple[list[float], list[np.ndarray]]) -> None:
    times, tables = course
    assert len(times) == len(tables) == 37  # every 1000 of 36000 steps, and the first
    assert times == sorted(times)
    assert all(table.shape == (138, 5) for table in tables)  # two discs of 69 nodes; none is lost
    assert set(tables[0][:, 1]) == {1.0, 2.0}


def test_the_script_breaks_grains(course: tuple[list[float], list[np.ndarray]]) -> None:
    _, tables = course
    assert (tables[0][:, 4] == 0.0).all()
    assert tables[-1][:, 4].max() > 0.3, "no grain broke"


def test_the_script_keeps_nodes_between_the_walls(
    course: tuple[list[float], list[np.ndarray]],
) -> None:
    """The lid is at 2.05 mm - 0.5 m/s t. Walls reach 0.095 mm, and no node may pass one."""
    for time, table in zip(*course, strict=True):
        assert table[:, 3].min() > 0.0
        assert table[:, 3].max() < 2.05e-3 - 0.5 * time
        assert np.abs(table[:, 2]).max() < 0.8e-3


def test_links_lead_to_files() -> None:
    links = re.findall(r"\]\(([^)#]+)\)", README)
    assert len(links) >= 5
    missing = [link for link in links if "://" not in link and not (REPOSITORY / link).exists()]
    assert missing == []


def test_it_counts_the_cases_of_the_report() -> None:
    said = re.search(r"(\d+) cases with known answers", README)
    assert said
    report = (REPOSITORY / "doc" / "verification.md").read_text()
    rows = re.findall(r"^\| \[[^]]+\]\(#[\w-]+\) \|", report, re.MULTILINE)
    assert int(said[1]) == len(rows)
    cases = REPOSITORY / "tests" / "verification" / "cases"
    assert len(rows) >= len(list(cases.glob("[!_]*.py")))


def test_its_script_is_short_and_it_has_two_screens() -> None:
    """A screen has some 55 lines; the picture takes those that comments and markup do not show."""
    shown = re.sub(r"<!--.*?-->\n", "", README, flags=re.DOTALL).splitlines()
    assert len(shown) < 110
    assert len([line for line in _script().splitlines() if line.strip()]) < 30
