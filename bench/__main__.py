"""``python -m bench``: measure, write csv files, pictures and the page.

python -m bench                    all parts, into bench/results and doc/performance.md
python -m bench kernels scenes     these parts anew, the others as they were measured before
python -m bench --quick --output out/bench     small sizes, to try it (a minute)
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path
from types import ModuleType

from peridem.run import RunError, find_lmp

from bench import grains, kernels, machine, memory, ranks, report, scenes, setup, table

PARTS: dict[str, ModuleType] = {
    "kernels": kernels,
    "scenes": scenes,
    "grains": grains,
    "ranks": ranks,
    "memory": memory,
    "setup": setup,
}
ROOT = Path(__file__).resolve().parents[1]


def main() -> int:
    """Parse the command line and run."""
    options = argparse.ArgumentParser(
        prog="python -m bench",
        description=(__doc__ or "").split("\n\n")[0],
        epilog=(__doc__ or "").split("\n\n", 1)[1],
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    options.add_argument("parts", nargs="*", metavar="part", help=f"any of {', '.join(PARTS)}")
    options.add_argument("--quick", action="store_true", help="small sizes, one repeat")
    options.add_argument("--output", type=Path, help="folder of the results (bench/results)")
    options.add_argument("--lmp", type=Path, help="the lmp program")
    chosen = options.parse_args()
    unknown = [part for part in chosen.parts if part not in PARTS]
    if unknown:
        options.error(f"no part {unknown[0]}; there are {', '.join(PARTS)}")
    try:
        lmp = find_lmp(chosen.lmp)
    except RunError as error:
        print(error, file=sys.stderr)
        return 1
    results = chosen.output or ROOT / "bench" / "results"
    results.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        measure(chosen.parts or list(PARTS), lmp, results, Path(folder), chosen.quick)
    page = (ROOT / "doc" / "performance.md") if chosen.output is None else results / "report.md"
    report.write(results, page, list(PARTS))
    print(f"{page} is written from {results}")
    return 0


def measure(parts: list[str], lmp: Path, results: Path, folder: Path, quick: bool) -> None:
    """Measure some parts; each leaves a csv file, a text and perhaps a picture."""
    this = machine.describe(lmp, folder)
    for name in parts:
        part = PARTS[name]
        start = time.monotonic()
        rows = part.measure(lmp, folder, this, quick)
        table.write(rows, results / f"{name}.csv")
        note = {"title": part.TITLE, "text": part.comment(rows, this), "machine": asdict(this)}
        (results / f"{name}.json").write_text(json.dumps(note, indent=1) + "\n")
        if hasattr(part, "plot"):
            part.plot(rows, results / f"{name}.png")
        print(f"{name}: {time.monotonic() - start:.0f} s\n{table.markdown(rows)}\n", flush=True)


if __name__ == "__main__":
    sys.exit(main())
