"""Fixtures for every test: LAMMPS in this process, LAMMPS under mpirun, and random numbers.

Environment:

- ``LAMMPS_LMP``: the ``lmp`` executable (default ``build/lmp`` of this repository);
- ``PERIDEM_TESTS_MUST_RUN``: when set, a missing LAMMPS or style is a failure instead of a skip;
- ``PERIDEM_SHARED``: where recorded states for node-by-node comparison lie (optional).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from support.runs import MpiRunner, Simulation

REPOSITORY = Path(__file__).resolve().parent.parent


def _missing(reason: str) -> None:
    if os.environ.get("PERIDEM_TESTS_MUST_RUN"):
        pytest.fail(reason, pytrace=False)
    pytest.skip(reason)


@pytest.fixture(scope="session")
def _lammps_has_styles() -> None:
    """Skips (or fails, see above) unless the lammps module knows the PERIDEM styles."""
    try:
        import lammps
    except ImportError as error:
        _missing(f"the lammps Python module cannot be imported: {error}")
        return
    try:
        probe = lammps.lammps(cmdargs=["-screen", "none", "-log", "none", "-nocite"])
    except OSError as error:
        _missing(f"liblammps cannot be loaded: {error}")
        return
    known = probe.has_style("atom", "peridem")
    probe.close()
    if not known:
        _missing("this LAMMPS was built without the PERIDEM package (no atom_style peridem)")


@pytest.fixture
def simulation(_lammps_has_styles: None, tmp_path: Path) -> Iterator[Callable[..., Simulation]]:
    """Factory of LAMMPS instances in this process; they are closed when the test ends."""
    opened: list[Simulation] = []

    def make(*arguments: str) -> Simulation:
        opened.append(Simulation(tmp_path, *arguments))
        return opened[-1]

    yield make
    for one in opened:
        one.close()


@pytest.fixture
def mpi(_lammps_has_styles: None, tmp_path: Path) -> MpiRunner:
    """Runs input scripts with ``mpirun -np N lmp`` in the test's own folder."""
    executable = Path(os.environ.get("LAMMPS_LMP", REPOSITORY / "build" / "lmp"))
    if not executable.is_file():
        _missing(f"no LAMMPS executable at {executable} (set LAMMPS_LMP)")
    return MpiRunner(executable, tmp_path)


@pytest.fixture
def rng() -> np.random.Generator:
    """Seeded random numbers: the same clouds in every run."""
    return np.random.default_rng(20100718)
