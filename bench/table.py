"""Rows of numbers: to and from csv, and as a table in Markdown."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

Row = dict[str, object]
COURSE = "course of "  # columns of it hold many numbers, for pictures


def write(rows: Sequence[Row], path: Path) -> None:
    """Rows as a csv file; what a row has not stays empty."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=_head(rows))
        writer.writeheader()
        writer.writerows({key: shown(value) for key, value in row.items()} for row in rows)


def read(path: Path) -> list[dict[str, str]]:
    """What :func:`write` wrote, as text."""
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def markdown(rows: Sequence[Row]) -> str:
    """A table; the keys are its head, and what a row has not stays empty.  Courses are left out."""
    head = [key for key in _head(rows) if not key.startswith(COURSE)]
    lines = ["| " + " | ".join(head) + " |", "| " + " | ".join("---" for _ in head) + " |"]
    lines += [
        "| " + " | ".join(str(shown(row.get(key, ""))) for key in head) + " |" for row in rows
    ]
    return "\n".join(lines)


def _head(rows: Sequence[Row]) -> list[str]:
    """All keys, in the order of their first row."""
    return list(dict.fromkeys(key for row in rows for key in row))


def shown(value: object) -> object:
    """As it stands in a table: four digits of what is no whole number."""
    return f"{value:.4g}" if isinstance(value, float) else value
