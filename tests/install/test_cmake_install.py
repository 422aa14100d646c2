"""`cmake --install`: what was built works where it is put."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("LAMMPS_LMP", REPOSITORY / "build" / "lmp")).parent


def test_an_installed_program_and_library_find_each_other(tmp_path: Path) -> None:
    if not (BUILD / "cmake_install.cmake").is_file():
        pytest.skip(f"{BUILD} is no folder that CMake built in: make build")
    prefix = tmp_path / "prefix"
    command = ["cmake", "--install", BUILD, "--prefix", prefix]
    done = subprocess.run(command, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    moved = prefix.rename(tmp_path / "elsewhere")

    alone = {name: value for name, value in os.environ.items() if name != "LD_LIBRARY_PATH"}
    said = subprocess.run(
        [moved / "bin" / "lmp", "-h"], text=True, capture_output=True, env=alone, check=True
    ).stdout
    assert all(style in said for style in ("peridem/lps", "peridem/contact", "peridem/wall"))
    listed = subprocess.run(
        ["ldd", moved / "bin" / "lmp"], text=True, capture_output=True, env=alone, check=True
    ).stdout
    [library] = [line.split()[2] for line in listed.splitlines() if "liblammps" in line]
    assert Path(library).resolve().is_relative_to(moved.resolve())
    assert (moved / "include" / "lammps" / "library.h").is_file()
    assert (moved / "lib" / "cmake" / "LAMMPS" / "LAMMPSConfig.cmake").is_file()
