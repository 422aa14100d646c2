"""People with their own LAMMPS: one CMake option adds the package to either supported version."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from support.own_build import BUILD, INJECT, REPOSITORY, built, run_checked

VERSIONS = ("4Feb2025", "4Jul2026")

SPACING = 1.0e-4

# Two square grains: the upper one hits the lower one, which hits the floor; bonds break.
CASE = """
units        si
dimension    2
boundary     f f p
newton       on
atom_style   peridem
neighbor     1e-4 bin
read_data    grains.data

pair_style   hybrid/overlay peridem/lps peridem/contact
pair_coeff   1 1 peridem/lps bulk 2.16e7 shear 1.296e7 horizon 3.015e-4 gc 5 plane strain
pair_coeff   1 1 peridem/contact radius 0.95e-4 modulus 2.16e7 damping 1.0 friction 0.3

fix          floor all peridem/wall plane 0 -1.03e-3 0 0 1 0 radius 0.95e-4 modulus 2.16e7
fix          motion all nve
compute      node all peridem/atom damage energy
timestep     2e-8
thermo       100
run          1500
write_dump   all custom final.dump id x y vx vy fx fy c_node[1] c_node[2] modify format float %.17g
"""


def _square(grain: int, centre: tuple[float, float], velocity: float) -> tuple[list, list]:
    """Rows of the Atoms and Velocities sections of a 7 by 7 square, atom-IDs left out."""
    across = SPACING * np.arange(-3, 4)
    points = [(centre[0] + x, centre[1] + y) for x in across for y in across]
    atoms = [f"{grain} 1 {SPACING**2} 1200.0 {x:.17g} {y:.17g} 0.0" for x, y in points]
    return atoms, [f"0.0 {velocity} 0.0"] * len(atoms)


def _write_case(folder: Path) -> None:
    low, low_speed = _square(1, (0.0, -0.6e-3), -2.0)
    high, high_speed = _square(2, (0.15e-3, 0.15e-3), -8.0)
    atoms, speeds = low + high, low_speed + high_speed
    box = "-2e-3 2e-3 xlo xhi\n-2e-3 2e-3 ylo yhi\n-5e-5 5e-5 zlo zhi"
    data = f"two grains\n\n{len(atoms)} atoms\n1 atom types\n\n{box}\n\nAtoms\n\n"
    data += "\n".join(f"{k} {row}" for k, row in enumerate(atoms, 1)) + "\n\nVelocities\n\n"
    data += "\n".join(f"{k} {row}" for k, row in enumerate(speeds, 1)) + "\n"
    (folder / "grains.data").write_text(data)
    (folder / "in.case").write_text(CASE)


def _final(dump: Path) -> np.ndarray:
    rows = np.loadtxt(dump, skiprows=9)
    return rows[np.argsort(rows[:, 0])]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[str, np.ndarray]:
    """The final state of the case from an own build of each version."""
    final = {}
    for version in VERSIONS:
        lmp = built(version)
        folder = tmp_path_factory.mktemp(f"own-{version}")
        _write_case(folder)
        run_checked([lmp, "-in", "in.case", "-nocite"], folder, f"the case with LAMMPS {version}")
        final[version] = _final(folder / "final.dump")
    return final


@pytest.mark.slow
@pytest.mark.parametrize("version", VERSIONS)
def test_an_own_build_has_the_styles(version: str, results: dict[str, np.ndarray]) -> None:
    listed = run_checked([BUILD / f"own-{version}" / "lmp", "-help"], BUILD, "lmp -help").split()
    for style in ("peridem", "peridem/lps", "peridem/contact", "peridem/bonds", "peridem/wall",
                  "peridem/atom"):  # fmt: skip
        assert style in listed


@pytest.mark.slow
def test_the_case_does_something(results: dict[str, np.ndarray]) -> None:
    """Guards the comparison below: the grains must have met each other and the floor."""
    for final in results.values():
        assert final.shape == (98, 9)
        assert np.isfinite(final).all()
        low, high = final[:49], final[49:]
        assert high[:, 4].mean() > -8.0 + 1.0, "the lower grain did not slow the upper one"
        assert low[:7, 2].min() > -1.03e-3, "the floor did not hold"
        momentum = final[:, 4].sum() / 49
        assert momentum > -10.0 + 1.0, "the floor pushed nobody"
        assert np.abs(final[:, 5:7]).max() > 0.0
        assert final[:, 7].max() > 0.0, "no bond broke"
        assert final[:, 8].max() > 0.0, "no node stores energy"


@pytest.mark.slow
def test_both_versions_give_the_same_result(results: dict[str, np.ndarray]) -> None:
    """Same sources and flags, so only LAMMPS's own order of sums may differ: rounding.

    1500 steps that each round at 1e-16 add up to 1e-13; contacts and breaking multiply a difference
    by a few orders of magnitude in this time, not by more: 1e-9 of the largest value of a column.
    """
    old, new = (results[version] for version in VERSIONS)
    scale = np.abs(new).max(axis=0)
    scale[scale == 0.0] = 1.0
    assert np.abs(old - new).max(axis=0) / scale == pytest.approx(0.0, abs=1e-9)


def test_a_tree_that_is_none_is_refused(tmp_path: Path) -> None:
    done = subprocess.run(
        ["cmake", "-S", REPOSITORY, "-B", tmp_path / "build", "-D", f"LAMMPS_DIR={tmp_path}"],
        text=True, capture_output=True,
    )  # fmt: skip
    assert done.returncode != 0
    assert f"LAMMPS_DIR={tmp_path} is not a LAMMPS source tree" in " ".join(done.stderr.split())


@pytest.mark.parametrize(
    ("stated", "complaint"),
    [("29 Aug 2024", "LAMMPS 29Aug2024"), ("soon", "states no LAMMPS version")],
)
def test_a_tree_that_is_too_old_is_refused(tmp_path: Path, stated: str, complaint: str) -> None:
    tree = tmp_path / "lammps"
    for name, text in {
        "cmake/CMakeLists.txt": "project(lammps CXX)",
        "src/version.h": f'#define LAMMPS_VERSION "{stated}"\n',
    }.items():
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        (tree / name).write_text(text)
    done = subprocess.run(
        ["cmake", "-S", tree / "cmake", "-B", tmp_path / "build",
         "-D", f"CMAKE_PROJECT_lammps_INCLUDE={INJECT}"],
        text=True, capture_output=True,
    )  # fmt: skip
    assert done.returncode != 0
    assert complaint in " ".join(done.stderr.split())
