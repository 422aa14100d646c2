"""The howtos of the manual, followed command by command (doc/howtos.py)."""

from __future__ import annotations

import os
import re
import subprocess
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
        "out/mine/grains.png",
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
    shown = _shown(page)
    assert bool(shown) == (page in ("howto_first_script", "howto_peridem_deck"))
    printed = (tmp_path / howtos.PRINTED).read_text().splitlines() if shown else []
    for line in shown:
        assert any(_alike(line, other) for other in printed), f"{page} shows '{line}'"


NUMBER = re.compile(r"\b\d+(?:\.\d+)?(?:e[-+]\d+)?\b")


def _shown(page: str) -> list[str]:
    """What a page says that programs print."""
    blocks = howtos.blocks((REPOSITORY / "doc" / f"{page}.rst").read_text())
    lines = [line for one in blocks if one.language == "text" and not one.caption
             for line in one.text.splitlines()]  # fmt: skip
    return [line.strip() for line in lines if re.match(r"\s*(PERIDEM:|\w+\.yaml:\d+:)", line)]


def _alike(line: str, other: str) -> bool:
    """The same words, and numbers to 1 %: meshes differ a little between versions of gmsh.

    How many grains go side by side depends on the processor.
    """
    line, other = (re.sub(r"\b\d at a time", "some at a time", one) for one in (line, other))
    if NUMBER.sub("#", line) != NUMBER.sub("#", other):
        return False
    pairs = zip(NUMBER.findall(line), NUMBER.findall(other), strict=True)
    return all(float(one) == pytest.approx(float(two), rel=0.01) for one, two in pairs)


def test_lines_are_compared() -> None:
    assert _alike("a 1.00e-5, 3 b", "a 1.001e-5, 3 b")
    assert not _alike("a 1.00e-5, 3 b", "a 1.1e-5, 3 b")
    assert not _alike("a 1, 3 b", "a 1, 3 c")
    assert len(_shown("howto_first_script")) > 5


def _printed(log: Path) -> tuple[float, float]:
    """Energy and norm of the forces, of the last line of thermo output."""
    lines = log.read_text().splitlines()
    _, energy, norm = [lines[i + 1] for i, line in enumerate(lines) if "PotEng" in line][-1].split()
    return float(energy), float(norm)


def _forces_agree(folder: Path) -> None:
    """PERI's are densities: 1e-9, the volume of a node, makes its forces ours to 12 digits."""
    theirs, ours = (_printed(folder / f"log.{name}") for name in ("peri", "peridem"))
    # twelve digits are printed, and the two add up in different orders
    assert abs(theirs[1] * 1e-9 / ours[1] - 1.0) < 2e-12
    page = (REPOSITORY / "doc" / "howto_from_lammps.rst").read_text()
    said = re.search(r"norm of the forces is ([\d.]+) N here, and ([\d.]+) there", page)
    assert said
    # another compiler rounds otherwise: sums of 10^5 terms
    assert abs(float(said[1]) / ours[1] - 1.0) < 1e-10
    assert abs(float(said[2]) / theirs[1] - 1.0) < 1e-10
    said = re.search(
        r"= ([\de.-]+) J; PERIDEM says ([\de.-]+) J .*PERI's tally ([\de.-]+) J", page, re.DOTALL
    )
    assert said
    exact = 0.5 * (2.0e9 + 4.0 / 3.0 * 1.2e9) * 1e-3**2 * 8**3 * 1e-9  # 512 cells, all of it
    for number, value in zip(said.groups(), (exact, ours[0], theirs[0] * 1e-9), strict=True):
        assert float(number) == pytest.approx(value, rel=1e-3)  # three digits are said


def test_bond_based_solids_agree_in_forces_and_energies(tmp_path: Path) -> None:
    """As the page says of peri/pmb and peridem/pmb: its two scripts with these styles."""
    if not LMP.is_file():
        pytest.skip(f"{LMP} is not there: make build")
    page = (REPOSITORY / "doc" / "howto_from_lammps.rst").read_text()
    solid = {
        "in.peri": ("peri/pmb", "1.0e20 3.1e-3 0.01 0.0"),
        "in.peridem": ("peridem/pmb", "c 1.0e20 horizon 3.1e-3 s0 0.01 influence constant"),
    }
    found = []
    for block in howtos.blocks(page):
        if block.caption in solid:
            style, numbers = solid[block.caption]
            script = re.sub(r"(pair_style +)\S+", rf"\1{style}", block.text)
            script = re.sub(r"(pair_coeff +\* \*) .*", rf"\1 {numbers}", script)
            (tmp_path / block.caption).write_text(script)
            command = [LMP, "-in", block.caption, "-log", f"log.{block.caption}", "-screen", "none"]
            subprocess.run(command, cwd=tmp_path, check=True)
            found.append(_printed(tmp_path / f"log.{block.caption}"))
    theirs, ours = found
    assert ours[0] > 0.0
    # twelve digits are printed, and the two add up in different orders
    assert theirs[0] * 1e-9 == pytest.approx(ours[0], rel=2e-12)
    assert theirs[1] * 1e-9 == pytest.approx(ours[1], rel=2e-12)
