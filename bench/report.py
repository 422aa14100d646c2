"""``doc/performance.md`` from the files in ``bench/results``."""

from __future__ import annotations

import json
import os
from pathlib import Path

from bench import table
from bench.pareto import defaults

HEAD = """\
# Performance

Written by `make bench` and `make pareto` from the files in `bench/results/`; change nothing here by
hand.  Times of one rank are processor time, medians of runs in turns.
"""
# all parts that there are, as they follow each other on the page
ORDER = (
    *("kernels", "scenes", "levels", "grains", "ranks", "memory", "setup"),
    *("waves", "hole", "contact", "cracks", "compression"),
    *("adapt", "series"),
)


def write(results: Path, page: Path) -> None:
    """All parts that were measured, one after another."""
    sections = [HEAD]
    machines: list[str] = []
    found: list[defaults.Case] = []
    for name in ORDER:
        if not (results / f"{name}.json").is_file():
            continue
        note = json.loads((results / f"{name}.json").read_text())
        words = "; ".join(
            f"{key.replace('_', ' ')} {value}" for key, value in note["machine"].items()
        )
        if words not in machines:
            machines.append(words)
        rows = [table.Row(row) for row in table.read(results / f"{name}.csv")]
        if "default" in note:
            found += defaults.cases(name, rows, note["default"], note["size"], note["present"])
        text = f"## {note['title']}\n\n{table.markdown(rows)}\n\n{note['text']}\n"
        picture = results / f"{name}.png"
        if picture.is_file():
            text += f"\n![{note['title']}]({os.path.relpath(picture, page.parent)})\n"
        number = machines.index(words) + 1
        text += f"\nMeasured with `{note['command']}` on machine {number}.\n"
        sections.append(text)
    if found:
        sections.append(f"## {defaults.TITLE}\n\n{defaults.text(found)}\n")
    listed = "\n".join(f"{number}. {words}" for number, words in enumerate(machines, 1))
    sections.append(f"## Machines\n\n{listed}\n")
    page.write_text("\n".join(sections))
