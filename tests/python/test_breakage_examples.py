"""Examples whose grains break, run by their scripts at the small size: the numbers they promise."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def made(name, folder, lmp, *words):
    """Run an example at its small size into a folder; its output."""
    command = [sys.executable, EXAMPLES / name / f"{name}.py", "--small", "--output", folder]
    ended = subprocess.run(
        [*command, "--lmp", lmp, *words],
        capture_output=True,
        text=True,
        timeout=600,
        env={**os.environ, "MPLBACKEND": "Agg"},
    )
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def test_single_grains_break_at_the_strengths_of_the_readme(tmp_path, lmp):
    made("crushing_strength", tmp_path, lmp, "-np", "2")
    rows = {row["series"]: row for row in json.loads((tmp_path / "strengths.json").read_text())}
    # kPa, as the README of the example; breaking is chaotic where a grain breaks in several places,
    # so another machine's rounding moves the peak: by less than 10 % in the runs seen
    expected = {"circle": 820, "hexagon": 1173, "triangle": 465, "drum": 836, "cracked disc": 242}
    for series, strength in expected.items():
        assert rows[series]["strength"] == pytest.approx(1e3 * strength, rel=0.1), series
    # the formula of a cracked disc holds to 21 % for a crack of 1.6 horizons, from below
    assert 0.7 < rows["cracked disc"]["strength"] / rows["cracked disc"]["theory"] < 1.0
    assert (tmp_path / "grains.png").stat().st_size > 10_000
    assert (tmp_path / "strength.png").is_file()
