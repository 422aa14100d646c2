"""The set-up scripts: what they refuse, what they print, and that what is pinned agrees."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

REPOSITORY = Path(__file__).resolve().parents[2]
SCRIPTS = REPOSITORY / "cmake"


def _call(
    *command: str | Path, cwd: Path = REPOSITORY, **environment: str
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        list(map(str, command)), cwd=cwd, env={**os.environ, **environment}, text=True,
        capture_output=True,
    )  # fmt: skip


def _programs(folder: Path, leave_out: set[str]) -> Path:
    """A folder of links to every program of PATH except some: a machine that lacks them."""
    folder.mkdir()
    for place in os.environ["PATH"].split(os.pathsep):
        for program in Path(place).glob("*") if Path(place).is_dir() else ():
            link = folder / program.name
            if program.name not in leave_out and not link.is_symlink():
                link.symlink_to(program)
    return folder


# ---- pins ----------------------------------------------------------------------------------------


def test_the_lock_file_holds_every_pinned_dependency() -> None:
    """requirements.txt was made from the pyproject.toml that lies beside it (else: make lock)."""
    project = tomllib.loads((REPOSITORY / "python" / "pyproject.toml").read_text())
    wanted = [
        *project["build-system"]["requires"],
        *project["project"]["dependencies"],
        *project["project"]["optional-dependencies"]["test"],
    ]
    locked = re.findall(
        r"^([\w.-]+==[\w.]+)", (REPOSITORY / "requirements.txt").read_text(), re.MULTILINE
    )
    assert len(wanted) > 5
    for requirement in wanted:
        pin = requirement.split(";")[0].strip()
        assert re.fullmatch(r"[\w.-]+==[\w.]+", pin), f"{requirement} is not pinned by =="
        assert pin in locked


def test_every_locked_package_has_hashes() -> None:
    text = (REPOSITORY / "requirements.txt").read_text().replace("\\\n", " ")
    entries = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    assert len(entries) > 10
    for entry in entries:
        assert re.search(r"--hash=sha256:[0-9a-f]{64}\b", entry), entry


# ---- fetching LAMMPS -----------------------------------------------------------------------------


def test_fetch_refuses_an_unknown_version(tmp_path: Path) -> None:
    done = _call(SCRIPTS / "fetch-lammps.sh", tmp_path / "lammps", "1Jan1970")
    assert done.returncode == 1
    assert "VERSION '1Jan1970' is not known; allowed: 4Jul2026, 4Feb2025" in done.stderr


def test_fetch_leaves_a_folder_with_other_files_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("keep")
    done = _call(SCRIPTS / "fetch-lammps.sh", tmp_path)
    assert done.returncode == 1
    assert "is not empty and no LAMMPS tree" in done.stderr
    assert (tmp_path / "mine.txt").read_text() == "keep"


def test_fetch_leaves_a_tree_of_the_wanted_version_alone(tmp_path: Path) -> None:
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "version.h").write_text('#define LAMMPS_VERSION "4 Feb 2025"\n')
    done = _call(SCRIPTS / "fetch-lammps.sh", tmp_path, "4Feb2025")
    assert done.returncode == 0, done.stderr
    assert "4Feb2025 is in" in done.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["src"]


@pytest.fixture
def offline(tmp_path: Path) -> dict[str, str]:
    """A PATH whose curl and wget hand out a file that nobody pinned, and without apt."""
    folder = _programs(tmp_path / "bin", {"curl", "wget", "apt-get"})
    for name, option in ("curl", "-o"), ("wget", "-O"):
        script = folder / name
        script.write_text(
            "#!/bin/bash\nwhile [ $# -gt 0 ]; do\n"
            f'  if [ "$1" = {option} ]; then echo tampered >"$2"; fi; shift\ndone\n'
        )
        script.chmod(0o755)
    return {
        "PATH": str(folder),
        "PERIDEM_APT_HELPER": "/nowhere",
        "PERIDEM_DEBIAN_MIRROR": "http://mirror.invalid/debian",
    }


def test_fetch_refuses_what_has_another_checksum(tmp_path: Path, offline: dict[str, str]) -> None:
    done = _call(SCRIPTS / "fetch-lammps.sh", tmp_path / "lammps", **offline)
    assert done.returncode == 1
    assert done.stdout.count("refused: its sha256 is not the pinned") == 2  # both sources
    assert "LAMMPS_DIR=/path/to/lammps" in done.stderr  # says what to do instead
    assert not (tmp_path / "lammps").exists()
    assert list((tmp_path / "downloads").iterdir()) == []  # nothing unchecked stays


def _release(folder: Path, top: str) -> Path:
    """A tarball with what an unpacked LAMMPS 4Jul2026 is recognised by."""
    for name in ("cmake/CMakeLists.txt", "python/lammps/core.py", "README", "LICENSE", "doc/rest"):
        (folder / top / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / top / name).write_text("")
    (folder / top / "src").mkdir()
    (folder / top / "src" / "version.h").write_text('#define LAMMPS_VERSION "4 Jul 2026"\n')
    tarball = folder / "made.tar.gz"
    with tarfile.open(tarball, "w:gz") as archive:
        for path in sorted((folder / top).iterdir()) if top == "." else [folder / top]:
            if path != tarball:
                archive.add(path, path.relative_to(folder))
    return tarball


@pytest.mark.parametrize("top", [".", "lammps-patch_4Jul2026"])
def test_fetch_takes_a_file_put_there_by_hand(
    tmp_path: Path, offline: dict[str, str], top: str
) -> None:
    """With and without a top folder in the tarball; the pinned sums are put in a copy's place."""
    made = tmp_path / "made"
    made.mkdir()
    tarball = _release(made, top)
    text = (SCRIPTS / "fetch-lammps.sh").read_text()
    pinned = re.findall(r"_sha=([0-9a-f]{64})", text)
    assert len(set(pinned)) == 4
    script = tmp_path / "fetch-lammps.sh"
    script.write_text(text.replace(pinned[0], hashlib.sha256(tarball.read_bytes()).hexdigest()))
    script.chmod(0o755)
    downloads = tmp_path / "downloads"
    downloads.mkdir()
    file = re.search(r"debian_file=(\S+)", text)
    assert file
    shutil.copy(tarball, downloads / file[1])

    done = _call(script, tmp_path / "lammps", **offline)

    assert done.returncode == 0, done.stderr
    assert (tmp_path / "lammps" / "src" / "version.h").is_file()
    assert not (tmp_path / "lammps" / "doc" / "rest").exists()  # only what a build needs


# ---- system packages -----------------------------------------------------------------------------


def test_without_root_the_apt_line_is_printed(tmp_path: Path) -> None:
    """A user without sudo, on a machine without CMake and MPI, learns the one line to have run."""
    programs = _programs(tmp_path / "bin", {"cmake", "mpirun", "mpicxx", "sudo", "id"})
    for name, text in {"id": "echo 1000", "apt-get": "echo apt-get was called >&2; exit 1"}.items():
        (programs / name).unlink(missing_ok=True)
        (programs / name).write_text(f"#!/bin/bash\n{text}\n")
        (programs / name).chmod(0o755)
    done = _call(SCRIPTS / "setup-system.sh", PATH=str(programs))
    assert done.returncode == 1
    lines = [line.strip() for line in done.stderr.splitlines() if "apt-get install" in line]
    assert len(lines) == 1
    assert lines[0].startswith("apt-get update && apt-get install -y")
    assert {"cmake", "libopenmpi-dev", "openmpi-bin"} <= set(lines[0].split())
    assert "g++" not in lines[0].split()  # what is there is not asked for
    assert "apt-get was called" not in done.stderr


def test_an_old_cmake_counts_as_missing(tmp_path: Path) -> None:
    programs = _programs(tmp_path / "bin", {"cmake"})
    (programs / "cmake").write_text("#!/bin/bash\necho cmake version 3.19.8\n")
    (programs / "cmake").chmod(0o755)
    done = _call(SCRIPTS / "setup-system.sh", "--check", PATH=str(programs))
    assert done.returncode == 1
    assert "missing: CMake 3.20 or later" in done.stdout


def test_a_machine_that_has_everything_is_left_alone(tmp_path: Path) -> None:
    programs = _programs(tmp_path / "bin", {"apt-get"})
    (programs / "apt-get").write_text("#!/bin/bash\necho apt-get was called >&2; exit 1\n")
    (programs / "apt-get").chmod(0o755)
    done = _call(SCRIPTS / "setup-system.sh", PATH=str(programs))
    assert (done.returncode, done.stdout, done.stderr) == (0, "system: all there\n", "")


# ---- Python --------------------------------------------------------------------------------------


def test_the_python_that_is_found_can_make_environments() -> None:
    done = _call(SCRIPTS / "setup-python.sh", "--find")
    assert done.returncode == 0, done.stderr
    script = "import sys, venv, ensurepip, ssl; print(*sys.version_info[:2])"
    major, minor = _call(done.stdout.strip(), "-c", script).stdout.split()
    assert (3, 10) <= (int(major), int(minor)) <= (3, 13)


def test_a_python_that_cannot_be_used_is_named(tmp_path: Path) -> None:
    old = tmp_path / "python3"
    old.write_text("#!/bin/bash\nexit 1\n")
    old.chmod(0o755)
    done = _call(SCRIPTS / "setup-python.sh", "--find", PYTHON=str(old))
    assert done.returncode == 1
    assert f"PYTHON={old} cannot be used: a Python 3.10 to 3.13" in done.stderr


# ---- the entry for automatic checks ------------------------------------------------------------


@pytest.mark.parametrize(
    ("printed", "status", "expected", "last"),
    [
        ("= 7 passed, 1 skipped in 2.50s =", 0, 0, "= 7 passed, 1 skipped in 2.50s ="),
        ("= 1 failed, 7 passed in 2.50s =", 2, 2, "= 1 failed, 7 passed in 2.50s ="),
        ("= 7 skipped in 0.10s =", 0, 1, "= 7 skipped in 0.10s ="),
        ("= no tests ran in 0.01s =", 0, 1, "= no tests ran in 0.01s ="),
        ("", 0, 1, "ci: pytest did not get as far as a closing line"),
        ("error: no compiler", 2, 2, "ci: pytest did not get as far as a closing line"),
    ],
)
def test_ci_ends_with_the_closing_line_and_an_honest_status(
    tmp_path: Path, printed: str, status: int, expected: int, last: str
) -> None:
    make = tmp_path / "make"
    make.write_text(f"#!/bin/bash\necho 'building'\necho '{printed}'\nexit {status}\n")
    make.chmod(0o755)
    done = _call(REPOSITORY / ".ci" / "run", PATH=f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    assert done.returncode == expected
    assert done.stdout.splitlines()[-1] == last


def test_help_is_the_default_and_lists_the_targets() -> None:
    done = _call("make", "--no-print-directory")
    assert done.returncode == 0, done.stderr
    for target in ("demo", "test", "quick", "build", "clean"):
        assert re.search(rf"^  make {target} +\w", done.stdout, re.MULTILINE)
