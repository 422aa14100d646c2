"""What a choice is worth over the default, and what the page says of the defaults."""

from __future__ import annotations

import pytest
from bench.pareto import defaults, worth


def _row(size: int, kind: str, s: float, error: float, note: str = "") -> dict[str, object]:
    return {
        "quantity": "drift",
        "size": size,
        "kind": kind,
        "s": s,
        "error": error,
        "front": "",
        "note": note,
    }


# the default, a: error like 1/s; 9 nodes are worse than 8, and beaten
SERIES = [
    _row(8, "a", 1.0, 0.16),
    _row(9, "a", 1.5, 0.20),
    _row(16, "a", 4.0, 0.04),
    _row(32, "a", 16.0, 0.01),
]
DEFAULT = {"size": 16, "kind": "a"}


def _times(*rows: dict[str, object], floor: float = 0.0) -> worth.Worth:
    (one,) = worth.of_settings([*SERIES, *rows], DEFAULT, "size", floor)
    return one


def test_worth_is_the_cost_of_the_default_for_the_same_error() -> None:
    # an error of 0.02 takes the default 8 s by its line of 1/s; b needs 2
    assert _times(_row(16, "b", 2.0, 0.02)).times == pytest.approx(4.0)
    # of two resolutions, 4 and 1 times: the geometric mean
    both = _times(_row(16, "b", 2.0, 0.02), _row(8, "b", 2.0, 0.08))
    assert both.times == pytest.approx(2.0)
    assert str(both) == "2"


def test_beyond_the_series_there_are_bounds_only() -> None:
    finer = _times(_row(32, "b", 2.0, 0.001))
    assert (finer.bound, str(finer)) == (1, "> 8")
    coarser = _times(_row(8, "b", 2.0, 0.5))
    assert (coarser.bound, str(coarser)) == (-1, "< 0.5")
    # one bound upwards, one downwards: nothing is known of their mean
    assert _times(_row(32, "b", 2.0, 0.001), _row(8, "b", 2.0, 0.5)).bound == 0


def test_errors_below_chance_count_as_chance() -> None:
    # with a floor of 0.05 the default needs the 4 s that reach it, and b's 0.001 is no better
    assert _times(_row(32, "b", 2.0, 0.001), floor=0.05).times == pytest.approx(2.0)
    assert _times(_row(32, "b", 2.0, 0.001), floor=0.05).bound == 0


def test_verdicts() -> None:
    def said(*pairs: tuple[float, int]) -> str:
        return worth.verdict([worth.Worth("kind", "b", *pair) for pair in pairs])

    assert said((2.0, 0), (1.0, 0)) == "better"
    assert said((0.5, 0), (1.0, 0)) == "worse"
    assert said((2.0, 0), (0.5, 0)) == "depends on the case"
    assert said((1.1, 0), (0.9, 0)) == "no clear difference"
    # at most 2, at least 0.5: neither tells anything
    assert said((2.0, -1), (0.5, 1)) == "no clear difference"


def _page(*rows: dict[str, object], present: dict[str, object] | None = None) -> str:
    cases = defaults.cases("drifting", [*SERIES, *rows], DEFAULT, "size", present or {})
    assert [case.name for case in cases] == ["drifting"]
    return defaults.text(cases)


def test_a_default_that_is_beaten_is_said_to_be() -> None:
    page = _page(_row(16, "b", 2.0, 0.02))
    assert "**kind** a is beaten: b is better (drifting 4)." in page
    assert "| kind | a | b | 4 | better |" in page
    # of the default's four runs 9 nodes are beaten by 8 (1.5 times), 16 by b (2 times)
    assert "| drifting | 4 | 2 | 2 |" in page


def test_a_default_that_nothing_beats_stays() -> None:
    page = _page(_row(16, "b", 2.0, 0.16), _row(16, "c", 1.0, 0.16))
    assert "**kind** a stays: nothing else is clearly better for anything here." in page


def test_chance_is_no_gain() -> None:
    """Rows with a note are no choices; they say how far chance goes."""
    chance = _row(16, "a", 4.0, 0.2, note="scatter")
    page = _page(_row(16, "b", 1.0, 0.001), chance)
    assert "| kind | a | b | 1 | no clear difference |" in page


def test_what_the_package_has_may_be_the_worse() -> None:
    page = _page(_row(16, "b", 8.0, 0.16), present={"kind": "b"})
    assert "a, with which the other runs are made: b, which the package has, is worse" in page


def test_nothing_measured_nothing_said() -> None:
    assert defaults.text([]) == ""
