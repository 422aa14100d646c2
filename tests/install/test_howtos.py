"""The howtos of the manual, followed command by command (doc/howtos.py)."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "doc"))

import howtos  # noqa: E402

LMP = Path(os.environ.get("LAMMPS_LMP", REPOSITORY / "build" / "lmp")).resolve()
# what a page says that it makes
MADE = {
    "howto_first_script": ["out/first/grains.dump", "out/first/grains.png"],
    "howto_first_python": [
        "out/nine/grains.png",
        "out/nine/grains.pvd",
        "out/lifted/grains.dump",
        "out/ball/grains.dump",
    ],
    "howto_peridem_deck": [
        "out/two/in.grains",
        "out/published/grains.dump",
        "out/damped/in.grains",
    ],
    "howto_from_lammps": ["log.peri", "log.peridem"],
    "howto_cracks": ["out/weak/in.grains"],
    "howto_results": ["out/first/grains.pvd", "out/first/three.png", "out/first/lid.png"],
    "howto_cluster": ["grains.restart"],
}


@pytest.mark.slow
@pytest.mark.parametrize("page", howtos.pages())
def test_the_page_does_what_it_says(page: str, tmp_path: Path) -> None:
    if not LMP.is_file():
        pytest.skip(f"{LMP} is not there: make build")
    howtos.follow(page, tmp_path, LMP)
    for name in MADE.get(page, []):
        assert (tmp_path / name).stat().st_size > 0, name
    if page == "howto_from_lammps":
        _forces_agree(tmp_path)


def _forces_agree(folder: Path) -> None:
    """PERI's forces are densities: 1e-9, the volume of a node, makes them ours to 12 digits."""
    norms = {}
    for name in ("peri", "peridem"):
        lines = (folder / f"log.{name}").read_text().splitlines()
        rows = [lines[i + 1].split() for i, line in enumerate(lines) if "PotEng" in line]
        norms[name] = float(rows[-1][2])
    # twelve digits are printed, and the two add up in different orders
    assert abs(norms["peri"] * 1e-9 / norms["peridem"] - 1.0) < 2e-12
    page = (REPOSITORY / "doc" / "howto_from_lammps.rst").read_text()
    said = re.search(r"norm of the forces is ([\d.]+) N here, and ([\d.]+) there", page)
    assert said
    # another compiler rounds otherwise: sums of 10^5 terms
    assert abs(float(said[1]) / norms["peridem"] - 1.0) < 1e-10
    assert abs(float(said[2]) / norms["peri"] - 1.0) < 1e-10
