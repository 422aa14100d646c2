"""The command line that `python -m bench` and `python -m bench.pareto` share."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from types import ModuleType

from peridem.run import RunError, find_lmp

from bench import machine, report, table

ROOT = Path(__file__).resolve().parents[1]


def main(
    parts: Mapping[str, ModuleType], program: str, words: str, named_only: Sequence[str] = ()
) -> int:
    """Parse the command line and run.

    Args:
        parts: what can be measured here, by name.
        program: how it is called.
        words: the help text.
        named_only: parts that run only where they are named.
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
    options.add_argument("--lmp", type=Path, help="the lmp program")
    chosen = options.parse_args()
    unknown = [part for part in chosen.parts if part not in parts]
    if unknown:
        options.error(f"no part {unknown[0]}; there are {', '.join(parts)}")
    try:
        lmp = find_lmp(chosen.lmp)
    except RunError as error:
        print(error, file=sys.stderr)
        return 1
    results = chosen.output or ROOT / "bench" / "results"
    results.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        usual = [name for name in parts if name not in named_only]
        wanted = {name: parts[name] for name in chosen.parts or usual}
        measure(wanted, lmp, results, Path(folder), chosen.quick, program)
    page = (ROOT / "doc" / "performance.md") if chosen.output is None else results / "report.md"
    report.write(results, page)
    print(f"{page} is written from {results}")
    return 0


def measure(
    parts: Mapping[str, ModuleType],
    lmp: Path,
    results: Path,
    folder: Path,
    quick: bool,
    program: str,
) -> None:
    """Measure some parts; each leaves a csv file, a text and perhaps a picture."""
    this = machine.describe(lmp, folder)
    for name, part in parts.items():
        start = time.monotonic()
        rows = part.measure(lmp, folder, this, quick)
        table.write(rows, results / f"{name}.csv")
        note = {
            "title": part.TITLE,
            "text": part.comment(rows, this),
            "machine": asdict(this),
            "command": f"{program} {name}{' --quick' if quick else ''}",
        }
        (results / f"{name}.json").write_text(json.dumps(note, indent=1) + "\n")
        if hasattr(part, "plot"):
            part.plot(rows, results / f"{name}.png")
        print(f"{name}: {time.monotonic() - start:.0f} s\n{table.markdown(rows)}\n", flush=True)
