"""Breaking, rubbing, wall-driven scenes: one end, however they are run.

Ranks 1, 2 and 4, every processor grid, newton on and off, tiled communication, balancing on the
way, restarts between any numbers of ranks.  ``support/invariance.py`` has the scenes and the ways.
"""

from __future__ import annotations

import numpy as np
import pytest

from support.invariance import BLOCKS, CRUSH, SCENES, SHEAR, Way, differences, ways


def few(dimension: int) -> list[Way]:
    """One way of each kind."""
    return [
        Way(newton="off"),
        Way(2, "2 1 1"),
        Way(4, "2 2 1", "off"),
        Way(2, tiled=True, balance=True),
        Way(4, restart=2),
        Way(1, restart=4),
    ]


def check(scene, mpi, choose):
    found, damage = differences(scene, mpi, choose)
    # bonds break before and after the restart, and not all of them
    assert 0.0 < damage[2] < damage[4] < 0.5
    for one in found:
        name = one.way.name
        # the same sums in another order
        assert not one.force[0] > 1e-12, name
        assert not one.energy[0] > 1e-12, name
        assert not one.walls[0] > 1e-12, name
        # every bond of every node, in every record
        assert np.nanmax(one.bonds) == 0, name
        # up to 200 steps in which collisions multiply rounding: 1e-14 to 1e-13 here; a stale ghost
        # or a lost bond or spring would show as 1e-4 and more
        for values in (one.force, one.motion, one.energy, one.walls):
            assert np.nanmax(values) < 1e-10, name
        if one.way.restart:
            assert one.motion[2] < 1e-12, name


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_one_way_of_each_kind(scene, mpi):
    check(scene, mpi, few)


@pytest.mark.slow
@pytest.mark.parametrize("scene", [CRUSH, SHEAR, BLOCKS], ids=lambda scene: scene.name)
def test_every_way(scene, mpi):
    check(scene, mpi, ways)


def test_a_restart_gives_positions_velocities_and_bonds_back_bit_for_bit(mpi):
    """Written by any number of ranks, read by any other: equal to what its writers had."""
    from support.invariance import PIECES, first_half, second_half
    from support.runs import read_dump

    one = CRUSH.grains()
    one.write(mpi.folder / "grains.data")
    for writers in (1, 2):
        mpi(first_half(CRUSH, one, f"half{writers}"), writers)
        (written,) = read_dump(mpi.folder / f"half{writers}.{PIECES // 2}")
        assert written["c_node[1]"].max() > 0.0
        for readers in (1, 4):
            mpi(second_half(CRUSH, one, f"half{writers}", "read"), readers)
            (read,) = read_dump(mpi.folder / f"read.{PIECES // 2}")
            for name in ("mol", "x y z", "vx vy vz", "c_node[1]", "c_node[2]"):
                np.testing.assert_array_equal(read[name], written[name], err_msg=name)
