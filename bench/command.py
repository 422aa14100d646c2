"""The command line that `python -m bench` and `python -m bench.pareto` share."""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
import tempfile
import time
import traceback
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType

from peridem.run import RunError, find_lmp

from bench import machine, report, table
from bench.machine import Machine

ROOT = Path(__file__).resolve().parents[1]


def main(
    parts: Mapping[str, ModuleType],
    program: str,
    words: str,
    jobs: int = 1,
) -> int:
    """Parse the command line and run.

    Args:
        parts: what can be measured here, by name.
        program: how it is called.
        words: the help text.
        jobs: parts that are measured at the same time, unless the command line says.
    """
    options = argparse.ArgumentParser(
        prog=program,
        description=words.split("\n\n")[0],
        epilog=words.split("\n\n", 1)[1],
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    options.add_argument("parts", nargs="*", metavar="part", help=f"any of {', '.join(parts)}")
    options.add_argument("--quick", action="store_true", help="small sizes, one repeat")
    options.add_argument("--output", type=Path, help="folder of the results (bench/results)")
    options.add_argument("--jobs", type=int, default=jobs, help=f"parts side by side ({jobs})")
    options.add_argument("--lmp", type=Path, help="the lmp program")
    chosen = options.parse_args()
    unknown = [part for part in chosen.parts if part not in parts]
    if unknown:
        options.error(f"no part {unknown[0]}; there are {', '.join(parts)}")
    if chosen.jobs < 1:
        options.error(f"--jobs must be at least 1, not {chosen.jobs}")
    try:
        lmp = find_lmp(chosen.lmp).absolute()  # it runs in other folders
    except RunError as error:
        print(error, file=sys.stderr)
        return 1
    results = chosen.output or ROOT / "bench" / "results"
    results.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        wanted = {name: parts[name] for name in chosen.parts or parts}
        this = machine.describe(lmp, Path(folder))
        job = Job(lmp, results, Path(folder), this, chosen.quick, program)
        failed = measure(wanted, job, chosen.jobs)
    page = (ROOT / "doc" / "performance.md") if chosen.output is None else results / "report.md"
    report.write(results, page)
    print(f"{page} is written from {results}")
    if failed:
        print(f"not measured: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


def choice_of(part: ModuleType) -> dict[str, object]:
    """Of parts that compare choices: the package's own, and the column of the resolution."""
    if not hasattr(part, "DEFAULT"):
        return {}
    present = getattr(part, "PRESENT", {})
    return {"default": part.DEFAULT, "size": part.SIZE, "present": present}


@dataclass(frozen=True)
class Job:
    """What all parts of one call share."""

    lmp: Path
    results: Path
    folder: Path
    machine: Machine
    quick: bool
    program: str


def measure(parts: Mapping[str, ModuleType], job: Job, side_by_side: int) -> list[str]:
    """Measure some parts, and say which of them failed; the others stand."""
    if side_by_side == 1:
        done = {name: _attempt(part.__name__, name, job) for name, part in parts.items()}
    else:
        spawn = multiprocessing.get_context("spawn")  # a fork would share MPI and gmsh
        with ProcessPoolExecutor(side_by_side, spawn) as pool:
            names = [part.__name__ for part in parts.values()]
            ended = pool.map(_attempt, names, parts, [job] * len(parts))
            done = dict(zip(parts, ended, strict=True))
    return [name for name, well in done.items() if not well]


def _attempt(module: str, name: str, job: Job) -> bool:
    start = time.monotonic()
    try:
        rows = _measure(import_module(module), name, job)
    except Exception:
        print(f"{name} failed:\n{traceback.format_exc()}", file=sys.stderr, flush=True)
        return False
    print(f"{name}: {time.monotonic() - start:.0f} s\n{table.markdown(rows)}\n", flush=True)
    return True


def _measure(part: ModuleType, name: str, job: Job) -> list[table.Row]:
    """One part; it leaves a csv file, a text and perhaps a picture."""
    folder = job.folder / name
    folder.mkdir()
    rows: list[table.Row] = part.measure(job.lmp, folder, job.machine, job.quick)
    table.write(rows, job.results / f"{name}.csv")
    note = {
        "title": part.TITLE,
        **choice_of(part),
        "text": part.comment(rows, job.machine),
        "machine": asdict(job.machine),
        "command": f"{job.program} {name}{' --quick' if job.quick else ''}",
    }
    (job.results / f"{name}.json").write_text(json.dumps(note, indent=1) + "\n")
    if hasattr(part, "plot"):
        part.plot(rows, job.results / f"{name}.png")
    return rows
