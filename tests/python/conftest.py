"""The lmp program for the tests that run scenes."""

import os
import subprocess

import pytest
from peridem.run import RunError, find_lmp


@pytest.fixture(scope="session")
def lmp():
    """Path of an lmp with PERIDEM; without one the test is skipped, or fails where it must run."""
    try:
        program = find_lmp()
        known = subprocess.run(
            [program, "-h"], capture_output=True, text=True, timeout=60, check=True
        ).stdout
        styles = ("peridem/lps", "peridem/contact", "peridem/wall", "peridem/atom")
        missing = [style for style in styles if style not in known]
        reason = f"{program} was built without {', '.join(missing)}" if missing else ""
    except (RunError, OSError, subprocess.SubprocessError) as error:
        reason = str(error)
    if reason:
        if os.environ.get("PERIDEM_TESTS_MUST_RUN"):
            pytest.fail(reason, pytrace=False)
        pytest.skip(reason)
    return program
