"""Every C++ file, as compilers see it that the usual build does not show: without MPI, with 64-bit
atom-IDs, with warnings.  Nothing is linked, so this takes seconds; whole builds are in
``test_own_lammps.py``.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from support.own_build import REPOSITORY, tree

SOURCES = sorted((REPOSITORY / "src" / "PERIDEM").glob("*.cpp"))
# as in cmake/PERIDEM-styles.cmake: the loops have pragmas
WORDS = ["-std=c++17", "-fsyntax-only", "-fopenmp-simd", "-Wall", "-Wextra"]


@pytest.mark.slow
@pytest.mark.parametrize("sizes", ["SMALLBIG", "BIGBIG"])
@pytest.mark.parametrize("version", ["4Feb2025", "4Jul2026"])
def test_files_compile_without_mpi_and_without_a_warning(version, sizes):
    """LAMMPS brings its own mpi.h for serial builds, which has a part of MPI and less const."""
    lammps = tree(version) / "src"
    # their headers are not ours to judge
    headers: list[str | Path] = ["-isystem", lammps, "-isystem", lammps / "STUBS"]
    assert len(SOURCES) > 40 and (lammps / "STUBS" / "mpi.h").is_file()
    done = subprocess.run(
        [os.environ.get("CXX", "c++"), *WORDS, f"-DLAMMPS_{sizes}", *headers, *SOURCES],
        text=True,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[:5000]
    assert "warning:" not in done.stderr, done.stderr[:5000]
