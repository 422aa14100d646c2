"""What a case is: it runs, and hands back rows (expected, got, tolerance and its reason) and a "
"plot.

A case is one function ``run(lab, **parameters) -> Outcome`` with two sets of parameters: ``small``
ones for the tests, ``full`` ones for the report.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from support.runs import Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Row:
    """One line of the report.

    ``holds``: whether the target is met; None for what is reported without a target.
    ``missed``: why a target is known not to be met.  Such a row does not fail, and says so.
    ``used``: how much of its room a number takes, 1 at the edge; None for what is no number.
    """

    quantity: str
    expected: str
    got: str
    tolerance: str
    why: str
    holds: bool | None
    missed: str = ""
    used: float | None = None

    @property
    def fails(self) -> bool:
        return self.holds is False and not self.missed

    @property
    def stale(self) -> bool:
        """Said to be missed, and met."""
        return bool(self.missed) and self.holds is True

    @property
    def text(self) -> str:
        return f"{self.quantity}: {self.got}, expected {self.expected} ({self.tolerance})"


def near(
    quantity: str,
    got: float,
    expected: float,
    *,
    why: str,
    rel: float | None = None,
    abs: float | None = None,
    missed: str = "",
    digits: int = 4,
) -> Row:
    """``got`` equals ``expected`` within ``rel`` of it, or within ``abs``; one of the two."""
    if (rel is None) == (abs is None):
        raise ValueError(f"{quantity}: one of rel and abs is needed")
    room = abs if rel is None else rel * np.abs(expected)
    shown = f"±{number(abs, 2)}" if rel is None else f"±{number(rel, 2)} of it"
    off = float(np.abs(got - expected))
    texts = number(expected, digits), number(got, digits)
    used = off / float(room) if room else None
    return Row(quantity, *texts, shown, why, bool(off <= room), missed, used)


def below(quantity: str, got: float, bound: float, *, why: str, missed: str = "") -> Row:
    """``got`` is at most ``bound`` (and not NaN)."""
    holds = bool(got <= bound)
    used = float(abs(got)) / bound if bound > 0 else None
    return Row(quantity, f"≤ {number(bound)}", number(got), "bound", why, holds, missed, used)


def above(quantity: str, got: float, bound: float, *, why: str, missed: str = "") -> Row:
    """``got`` is at least ``bound`` (and not NaN)."""
    holds = bool(got >= bound)
    used = float(bound / got) if got > 0 else None
    return Row(quantity, f"≥ {number(bound)}", number(got), "bound", why, holds, missed, used)


def within(
    quantity: str, got: float, low: float, high: float, *, why: str, missed: str = ""
) -> Row:
    """``got`` lies between two bounds."""
    holds = bool(low <= got <= high)
    expected = f"{number(low)} to {number(high)}"
    return Row(quantity, expected, number(got), "range", why, holds, missed)


def is_so(
    quantity: str, got: str, holds: bool, expected: str, *, why: str, missed: str = ""
) -> Row:
    """Something that is no number: ``got`` is shown as it is."""
    return Row(quantity, expected, got, "as it is", why, bool(holds), missed)


def shown(quantity: str, got: float | str, *, why: str, expected: float | str = "") -> Row:
    """Reported without a target; ``expected`` is what others say."""
    got = got if isinstance(got, str) else number(got)
    expected = expected if isinstance(expected, str) else number(expected)
    return Row(quantity, expected or "–", got, "none", why, None)


def number(value: float, digits: int = 4) -> str:
    """As a person would write it; integers whole, very small and large ones with an exponent."""
    if value == 0 or (float(value).is_integer() and np.abs(value) < 1e6):
        return str(int(value))
    return f"{value:.{digits}g}"


@dataclass
class Outcome:
    """What a case found.

    ``draw`` makes its plot (only the report calls it); ``notes`` are paragraphs for the report.
    """

    rows: Sequence[Row]
    draw: Callable[[], Figure] | None = None
    notes: Sequence[str] = ()


@dataclass
class Lab:
    """Where a case runs: a folder, and LAMMPS instances that are closed at the end."""

    folder: Path
    _opened: list[Simulation] = field(default_factory=list)

    def simulation(self, *arguments: str) -> Simulation:
        """A LAMMPS in this process, as the fixture of this name makes."""
        self._opened.append(Simulation(self.folder, *arguments))
        return self._opened[-1]

    def close(self) -> None:
        """Close all; may be called between the parts of a case to give memory back."""
        for one in self._opened:
            one.close()
        self._opened.clear()


@dataclass(frozen=True)
class Case:
    """A case of the report.

    Attributes:
        name: short, for files and the command line.
        title: heading in the report.
        what: what is done, in a paragraph.
        source: where the expected numbers come from, with the equation.
        run: ``run(lab, **parameters)``.
        small, full: parameters of the test and of the report.
    """

    name: str
    title: str
    what: str
    source: str
    run: Callable[..., Outcome]
    small: Mapping[str, Any] = field(default_factory=dict)
    full: Mapping[str, Any] = field(default_factory=dict)

    def parameters(self, size: str) -> Mapping[str, Any]:
        return {"small": self.small, "full": self.full}[size]
