"""Own builds of LAMMPS with the package, as people make them: for any processor, kept in build/."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
BUILD = REPOSITORY / "build"
INJECT = REPOSITORY / "cmake" / "PERIDEM-inject.cmake"


def run_checked(command: list[str | Path], cwd: Path, what: str) -> str:
    """Output of a command; fails the test with its last lines."""
    done = subprocess.run(
        list(map(str, command)),
        cwd=cwd,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    if done.returncode:
        tail = "\n".join(done.stdout.splitlines()[-30:])
        pytest.fail(f"{what} failed:\n{tail}", pytrace=False)
    return done.stdout


def tree(version: str) -> Path:
    """A LAMMPS tree of that version, fetched once and kept in build/."""
    folder = BUILD / ("lammps-src" if version == "4Jul2026" else f"lammps-{version}")
    fetch = [REPOSITORY / "cmake" / "fetch-lammps.sh", folder, version]
    done = subprocess.run(list(map(str, fetch)), text=True, capture_output=True)
    if done.returncode:
        reason = f"LAMMPS {version} is not here and could not be fetched:\n{done.stderr}"
        if os.environ.get("PERIDEM_TESTS_MUST_RUN"):
            pytest.fail(reason, pytrace=False)
        pytest.skip(reason)
    return folder


def built(version: str) -> Path:
    """The lmp that an own build of that version makes; built again only where sources changed."""
    folder = BUILD / f"own-{version}"
    configure: list[str | Path] = [
        "cmake", "-S", tree(version) / "cmake", "-B", folder,
        "-D", f"CMAKE_PROJECT_lammps_INCLUDE={INJECT}",
        "-D", "PERIDEM_PCH=on", "-D", "BUILD_MPI=on", "-D", "BUILD_SHARED_LIBS=on",
        "-D", "CMAKE_BUILD_TYPE=Release", "-D", "PKG_RIGID=on",
    ]  # fmt: skip
    if not (folder / "CMakeCache.txt").exists() and shutil.which("ninja"):
        configure += ["-G", "Ninja"]
    run_checked(configure, REPOSITORY, f"configuring LAMMPS {version} with PERIDEM-inject.cmake")
    cores = str(os.cpu_count() or 1)
    build: list[str | Path] = ["cmake", "--build", folder, "--parallel", cores]
    run_checked(build, REPOSITORY, f"building LAMMPS {version}")
    return folder / "lmp"
