"""What a program that makes scenes, runs them and looks at the results needs besides.

Its options, and its end when there is nothing to look at: only the scene was wanted, LAMMPS failed,
or somebody stopped it. The examples are such programs::

    chosen = program.options(__doc__, "out/heap", small="fewer grains: seconds").parse_args()
    program.run(make_scene(chosen.small).write(chosen.output), chosen)
    print(measure(chosen.output))
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from peridem import run as _run
from peridem.run import RunError, RunReport
from peridem.run_many import run_many

__all__ = ["STOPPED", "options", "run"]

STOPPED = 130  # exit status after Ctrl-C, as shells have it


def options(
    about: str | None, output: str, small: str = "", side_by_side: bool = False
) -> argparse.ArgumentParser:
    """The usual options; a program may add its own.

    Args:
        about: its first line says what the program does: its ``__doc__``.
        output: folder that ``--output`` replaces.
        small: what ``--small`` makes smaller; empty: there is no such option.
        side_by_side: ``-np`` is how many runs go at a time, on one rank each, and not the number of
            ranks of a run.
    """
    parser = argparse.ArgumentParser(description=(about or "").partition("\n")[0])
    if small:
        parser.add_argument("--small", action="store_true", help=small)
    parser.add_argument("--output", type=Path, default=Path(output), help=f"folder ({output})")
    if side_by_side:
        parser.add_argument("-np", "--at-once", type=int, default=2, help="runs at a time (2)")
    else:
        parser.add_argument("-np", "--ranks", type=int, default=2, help="MPI processes (2)")
    parser.add_argument("--lmp", type=Path, help="the lmp program")
    parser.add_argument("--no-run", action="store_true", help="only write what LAMMPS reads")
    return parser


def run(scripts: Path | Sequence[Path], chosen: argparse.Namespace) -> list[RunReport]:
    """Run scripts as the options of :func:`options` say, one after the other or side by side.

    Returns:
        A report of each.

    Raises:
        SystemExit: the program ends here: with status 0 after ``--no-run``, 1 and LAMMPS's message
            if a run failed, 130 if one was stopped.
    """
    every = [scripts] if isinstance(scripts, Path) else list(scripts)
    if chosen.no_run:
        ranks = "" if "at_once" in chosen else f" -np {chosen.ranks}"
        for script in every:
            print(f"{script} is ready; run it with: peridem run {script.parent}{ranks}")
        raise SystemExit(0)
    try:
        if "at_once" in chosen:
            reports = run_many(every, chosen.at_once, chosen.lmp)
        else:
            reports = _in_turn(every, chosen)
    except RunError as error:
        message = str(error)
        if error.restart:
            message += f"\nonce the cause is gone, go on with: {_again(error.restart)}"
        raise SystemExit(message) from error
    for script, report in zip(every, reports, strict=False):
        if report.stopped:
            print(f"stopped at step {report.steps}; go on with: {_again(script)}", file=sys.stderr)
            raise SystemExit(STOPPED)
    return reports


def _again(inside: Path) -> str:
    """The command that goes on with the run in the folder of a file."""
    return f"peridem run {inside.parent} --resume"


def _in_turn(scripts: Sequence[Path], chosen: argparse.Namespace) -> list[RunReport]:
    """Up to the first that is stopped."""
    reports: list[RunReport] = []
    for script in scripts:
        reports.append(_run.run(script, chosen.ranks, chosen.lmp))
        if reports[-1].stopped:
            break
    return reports
