"""Nodes that rattle gain energy with the fourth power of the step; the manual says how much.

A contact opens and closes within a step.  Velocity Verlet keeps a shadow energy while it is closed,
which is less than that with which the nodes meet by (omega dt)^2 s (1 - s) of it (at most a quarter
of (omega dt)^2), where s is the part of the step in which the contact was closed when it was
first seen; as much comes back, with another s, when it ends.  The difference is zero on average,
and its square, which the energy gains, goes with dt^4.  A contact that gets stiff little by little
has no such kink (``doc/theory.rst``, "Contacts that open and close").
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from support.rattling import OVERLAP, SAFETIES, gain

PAGE = Path(__file__).resolve().parents[2] / "doc" / "fix_peridem_timestep.rst"


@pytest.fixture
def gains(_lammps_has_styles: None, tmp_path: Path) -> dict[float, float]:
    return {safety: gain(tmp_path, safety) for safety in SAFETIES}


def test_energy_grows_with_the_fourth_power_of_the_step(gains):
    """Between 0.2 and 0.6; above, nodes with several contacts come near their limit and gain more.

    The factor of 3^4 = 81 within 1.5: chaotic motion of 480 nodes over 900 times of a contact.
    """
    assert 81.0 / 1.5 < gains[0.6] / gains[0.2] < 81.0 * 1.5
    assert gains[0.8] > (0.8 / 0.6) ** 4 * gains[0.6]


@pytest.mark.parametrize("safety", [0.9, 0.8, 0.5])
def test_contacts_that_get_stiff_little_by_little_give_no_energy(
    safety, _lammps_has_styles, tmp_path
):
    """3e-5: a sixtieth of what linear springs give at 0.8.

    A crowd whose energy was all motion lends 1 % of it to the shadow energy of its contacts as they
    close: 1e-5 of it in the time of one contact.
    """
    assert abs(gain(tmp_path, safety, 4.0 * OVERLAP)) < 3e-5


def test_the_manual_has_these_gains(gains):
    """To one digit and a half: runs of other processors and compilers are other chaotic runs."""
    text = PAGE.read_text()
    for name, wanted in (("safety", SAFETIES), ("energy gained", gains.values())):
        (row,) = re.findall(rf"^{name} +([-\d. e]+)$", text, re.MULTILINE)
        assert [float(word) for word in row.split()] == pytest.approx(list(wanted), rel=0.3)
