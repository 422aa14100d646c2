"""Rows of numbers: to and from csv, and as a table in Markdown."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

Row = dict[str, object]


def write(rows: Sequence[Row], path: Path) -> None:
    """Rows with the same keys as a csv file."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows({key: _shown(value) for key, value in row.items()} for row in rows)


def read(path: Path) -> list[dict[str, str]]:
    """What :func:`write` wrote, as text."""
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def markdown(rows: Sequence[Row]) -> str:
    """A table; the keys are its head."""
    head = list(rows[0])
    lines = ["| " + " | ".join(head) + " |", "| " + " | ".join("---" for _ in head) + " |"]
    lines += ["| " + " | ".join(str(_shown(row[key])) for key in head) + " |" for row in rows]
    return "\n".join(lines)


def _shown(value: object) -> object:
    return f"{value:.4g}" if isinstance(value, float) else value
