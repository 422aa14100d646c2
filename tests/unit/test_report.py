"""The rows of the verification report, and the page made from them."""

from __future__ import annotations

import json
from dataclasses import asdict

import pytest

from verification import report
from verification.cases import all_cases, case_named
from verification.cases.base import Row, above, below, is_so, near, shown, within

NAN = float("nan")


@pytest.mark.parametrize(
    ("row", "holds"),
    [
        (near("q", 1.01, 1.0, rel=0.02, why="w"), True),
        (near("q", 1.03, 1.0, rel=0.02, why="w"), False),
        (near("q", 0.0, 0.0, abs=0.0, why="w"), True),
        (near("q", -1.01, -1.0, rel=0.02, why="w"), True),
        (near("q", NAN, 1.0, abs=9.0, why="w"), False),
        (below("q", 1.0, 1.0, why="w"), True),
        (below("q", NAN, 1.0, why="w"), False),
        (above("q", 0.9, 1.0, why="w"), False),
        (above("q", NAN, 1.0, why="w"), False),
        (within("q", 1.0, 0.9, 1.1, why="w"), True),
        (within("q", NAN, 0.9, 1.1, why="w"), False),
        (is_so("q", "three", False, "four", why="w"), False),
        (shown("q", NAN, why="w"), None),
    ],
)
def test_a_row_knows_whether_it_holds(row: Row, holds: bool | None) -> None:
    assert row.holds is holds
    assert row.fails is (holds is False)


def test_one_tolerance_is_needed() -> None:
    with pytest.raises(ValueError, match="one of rel and abs"):
        near("q", 1.0, 1.0, why="w")
    with pytest.raises(ValueError, match="one of rel and abs"):
        near("q", 1.0, 1.0, rel=0.1, abs=0.1, why="w")


def test_a_target_known_to_be_missed_does_not_fail_and_says_why() -> None:
    row = below("q", 2.0, 1.0, why="w", missed="too coarse")
    assert not row.fails
    assert not row.stale
    assert "too coarse" in report.row_line(row)
    assert below("q", 0.5, 1.0, why="w", missed="too coarse").stale


def test_names_of_cases_are_known_once_each() -> None:
    names = [case.name for case in all_cases()]
    assert len(set(names)) == len(names)
    with pytest.raises(KeyError, match="patch"):
        case_named("no such case")


def test_the_page_has_what_is_stored_and_names_what_is_not(tmp_path) -> None:
    rows = [below("a | b", 2.0, 1.0, why="w"), shown("c", 3.0, why="w")]
    result = {
        "name": "patch",
        "size": "small",
        "seconds": 2.4,
        "parameters": report.parameters_text({"sizes": (2.0, 3.015), "m": 3}),
        "rows": [asdict(row) for row in rows],
        "notes": ["A remark."],
        "plot": False,
        "lammps": "1",
        "processor": "p",
    }
    (tmp_path / "patch.json").write_text(json.dumps(result))
    page = report.page(tmp_path, "plots")
    assert "| a \\| b | ≤ 1 | 2 | bound | w | **NOT MET** |" in page
    assert "A remark." in page
    assert "small size" in page
    assert "sizes = 2, 3.015; m = 3. 2 s." in page
    missing = page.split("Not run: ")[1].split(".**")[0]
    assert "surface" in missing
    assert "patch" not in missing
