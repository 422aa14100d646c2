"""Many runs side by side, each on one process: series of scenes that differ by a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from pathlib import Path

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from peridem.run import RunReport, find_lmp, find_script, run, stop_requests
from peridem.run_script import STOP

__all__ = ["run_many"]

LOOK = 0.2  # seconds between two looks at what was asked for


def run_many(
    scripts: Sequence[str | Path],
    at_once: int = 2,
    lmp: str | Path | None = None,
    quiet: bool = False,
) -> list[RunReport]:
    """Run scripts on one process each, some of them at a time.

    Ctrl-C and SIGTERM stop those that run, with a restart file each, and start no more.

    Args:
        scripts: input scripts or their folders, each in a folder of its own.
        at_once: how many run at a time.
        lmp: the program (see :func:`peridem.run.find_lmp`).
        quiet: no progress bar.

    Returns:
        Their reports, in the same order; one that was not started counts as stopped at step 0.

    Raises:
        peridem.run.RunError: a run failed, the first of those that did; the others are stopped.
        FileNotFoundError, ValueError: a script is missing, two share a folder, or ``at_once`` is
            below 1.
    """
    found = [find_script(script).resolve() for script in scripts]
    folders = [script.parent for script in found]
    if len(set(folders)) < len(folders):
        twice = next(folder for folder in folders if folders.count(folder) > 1)
        raise ValueError(f"run_many: several scripts in {twice}; each needs a folder of its own")
    if at_once < 1:
        raise ValueError(f"run_many: at_once must be at least 1, not {at_once}")
    program = find_lmp(lmp)
    with stop_requests() as requests, ThreadPoolExecutor(at_once) as pool:
        futures = [pool.submit(run, script, 1, program, quiet=True) for script in found]
        _watch(futures, folders, requests, quiet)
    reports = []
    for future in futures:
        stopped = future.cancelled()
        reports.append(RunReport(0, 0.0, True) if stopped else future.result())
    return reports


def _watch(
    futures: list[Future[RunReport]], folders: list[Path], requests: list[int], quiet: bool
) -> None:
    """Wait for all; once a stop is asked for or one fails, stop the others."""
    columns = (TextColumn("runs"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, disable=quiet) as progress:
        task = progress.add_task("runs", total=len(futures))
        left = set(futures)
        while left:
            over, left = wait(left, LOOK, FIRST_COMPLETED)
            progress.advance(task, len(over))
            failed = any(not f.cancelled() and f.exception() for f in set(futures) - left)
            if requests or failed:
                _stop(futures, folders)


def _stop(futures: list[Future[RunReport]], folders: list[Path]) -> None:
    for future, folder in zip(futures, folders, strict=True):
        future.cancel()
        if future.running():
            (folder / STOP).touch()
