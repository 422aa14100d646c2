"""Every case of the report at its small size: all rows hold, or say why they do not."""

from __future__ import annotations

import pytest

from verification.cases import all_cases
from verification.cases.base import Case, Lab


@pytest.mark.parametrize("case", all_cases(), ids=lambda case: case.name)
def test_case(case: Case, _lammps_has_styles: None, tmp_path) -> None:
    lab = Lab(tmp_path)
    try:
        outcome = case.run(lab, **case.small)
    finally:
        lab.close()
    assert outcome.rows
    assert not [row.text for row in outcome.rows if row.fails]
