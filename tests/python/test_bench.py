"""``python -m bench`` at its small sizes: what it writes, not how fast this machine is."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def _bench(program: str, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", program, *words],
        cwd=ROOT,
        env=dict(os.environ, MPLBACKEND="Agg"),
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )


def _rows(results: Path, part: str) -> list[dict[str, str]]:
    with (results / f"{part}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def measured(lmp: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    results = tmp_path_factory.mktemp("bench")
    words = ["kernels", "scenes", "memory", "--quick", "--output", str(results), "--lmp", str(lmp)]
    done = _bench("bench", *words)
    assert done.returncode == 0, done.stdout + done.stderr
    return results


@pytest.mark.slow
def test_kernels_compare_the_same_families(measured: Path) -> None:
    rows = _rows(measured, "kernels")
    block = {row["style"]: row for row in rows if row["scene"] == "block"}
    assert set(block) == {"peri/lps", "peridem/lps engine general", "peri/pmb", "peridem/pmb"}
    assert len({row["directed bonds"] for row in block.values()}) == 1
    grains = [row for row in rows if row["scene"] == "grains"]
    assert [row["style"].split()[-1] for row in grains] == ["general", "batched"]
    assert len({row["directed bonds"] for row in grains}) == 1
    assert all(float(row["ns per directed bond"]) > 0 for row in rows)


@pytest.mark.slow
def test_the_parts_of_a_scene_add_up(measured: Path) -> None:
    for row in _rows(measured, "scenes"):
        parts = sum(float(value) for key, value in row.items() if key.endswith(", ns"))
        # LAMMPS leaves nothing out of its breakdown; the csv file has four digits of each
        assert parts == pytest.approx(float(row["ns per node and step"]), rel=0.01)


@pytest.mark.slow
def test_memory_is_that_of_lammps_alone(measured: Path) -> None:
    """A block has 105 directed bonds per node here; each is a few numbers."""
    for row in _rows(measured, "memory"):
        # an index at least; at these sizes peri/lps takes some 40 bytes; ours 29, and 12 more if
        # families held what follows from their lengths
        most = 35 if row["style"].startswith("peridem") else 60
        assert 4 < float(row["for each directed bond"]) < most, row
        all_in = float(row["of them for the node itself"])
        all_in += float(row["directed bonds per node"]) * float(row["for each directed bond"])
        # a line through two points: both lie on it, but for the four digits of the file
        assert float(row["bytes per node, all in"]) == pytest.approx(all_in, rel=0.01)


@pytest.mark.slow
def test_the_page_says_how_and_on_what(measured: Path) -> None:
    page = (measured / "report.md").read_text()
    assert "`python -m bench kernels --quick`" in page
    note = json.loads((measured / "kernels.json").read_text())
    assert note["machine"]["processor"] in page
    for row in _rows(measured, "scenes"):
        assert row["scene"] in page


def test_what_is_not_there_is_refused() -> None:
    done = _bench("bench", "speed")
    assert done.returncode == 2
    assert "no part speed; there are kernels, scenes" in done.stderr


@pytest.mark.slow
def test_levels_take_longer_steps_than_verlet(lmp: Path, tmp_path: Path) -> None:
    done = _bench("bench", "levels", "--quick", "--output", str(tmp_path), "--lmp", str(lmp))
    assert done.returncode == 0, done.stdout + done.stderr
    rows = _rows(tmp_path, "levels")
    steps = [float(row["step, ns"]) for row in rows]
    assert len(rows) == 8
    for first in (
        0,
        4,
    ):  # verlet, then 2, 3, 4 contact steps: a bound of theory, whatever the clock
        assert float(rows[first]["over verlet"]) == 1.0
        assert steps[first] < steps[first + 1] < steps[first + 2] < steps[first + 3]
        assert steps[first + 3] < 3.1416 / 2 * 1.05 * steps[first]  # 1.05: verlet counts bonds too


@pytest.mark.slow
def test_adaptive_grains_are_compared_with_deformable_ones(
    lmp: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    results = tmp_path_factory.mktemp("adapt")
    words = ["adapt", "series", "--quick", "--output", str(results), "--lmp", str(lmp)]
    done = _bench("bench", *words)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = _rows(results, "adapt")
    assert len({row["scene"] for row in rows}) == 5
    for row in rows:
        whole = row["eta"].startswith("0 (all")
        assert (float(row["gain"]) == 1.0) == whole
        assert (float(row["awake"]) == 1.0) == whole
        # so short that nothing breaks
        assert row["fragments"] == ("0" if whole else "+0.000 ± 0.000")
    page = (results / "report.md").read_text()
    assert "The largest eta up to which differences" in page and "| all of them |" in page
    assert "course of" not in page
    assert (results / "adapt.png").stat().st_size > 10_000
    pressed = _rows(results, "series")
    simulated = float(pressed[0]["f at strain 0.003"])
    # linear elastic, against a slow simulation with a little inertia: measured 0.5 %
    assert simulated == pytest.approx(float(pressed[0]["f computed"]), rel=0.03)
    assert [row["grains"].split(",")[1].strip() for row in pressed[1:]] == [
        "deformable",
        "rigid",
        "rigid",
    ]
