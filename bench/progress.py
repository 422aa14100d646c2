"""How far a part has come, for parts of minutes."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from typing import TypeVar

One = TypeVar("One")


def counted(items: Sequence[One], name: str) -> Iterator[One]:
    """The items, one after another; every tenth of them is reported on stderr."""
    tenths = 0
    for k, item in enumerate(items):
        if 10 * k // len(items) > tenths:
            tenths = 10 * k // len(items)
            print(f"{name}: {k} of {len(items)} done", file=sys.stderr, flush=True)
        yield item
