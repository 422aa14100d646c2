"""``fix peridem/adapt`` with grains in different states, across ranks, periods and restarts."""

from __future__ import annotations

import numpy as np
import pytest

from support.heaps import REBUILD, SOLIDS, SPRINGS, WRITE, heap_script, tumbling
from support.runs import lps_words, read_dump

ADAPT = "peridem/adapt eta 0.2 back 0.5 every 10 hold 2 sleep 1e-3"
STATE = WRITE + " f_motion"
STEPS = 150
PLACES = "x y z vx vy vz"


def mixed_scene(one, grid: str, name: str, steps: int, dimension: int = 2, extra: str = "") -> str:
    """The tumbling heap with adaptive grains; two of four have met when it ends."""
    text = heap_script(
        one, dimension, grid, "on", name, steps=steps, extra=REBUILD + extra, contact=SPRINGS
    )
    return text.replace("fix motion all nve", f"fix motion all {ADAPT}").replace(WRITE, STATE)


def apart(rng, dimension: int = 2):
    """Two grains on collision course, one far from anything that tumbles, one that rests."""
    one = tumbling(rng, dimension)
    for molecule, shift in ((3, (-6.0, 4.0, 0.0)), (4, (6.0, 5.0, 0.0))):
        nodes = one.molecule == molecule
        one.x[nodes] += shift
        one.v[nodes] = 0.0
        if molecule == 4:
            one.v[nodes, :2] += 0.1 * np.column_stack(
                [-(one.x - one.x[nodes].mean(axis=0))[nodes, 1], np.zeros(nodes.sum())]
            )
    one.reference[:] = one.x
    return one


@pytest.mark.parametrize("dimension", [2, 3])
def test_ranks_see_the_same_states_and_motion(dimension, mpi, rng):
    one = apart(rng, dimension)
    one.write(mpi.folder / "heap.data")
    ends = {}
    for grid in ("1 1 1", "2 1 1", "2 2 1", "1 4 1" if dimension == 2 else "1 2 2"):
        ranks = int(np.prod([int(n) for n in grid.split()]))
        mpi(mixed_scene(one, grid, "end", STEPS, dimension), ranks)
        (ends[grid],) = read_dump(mpi.folder / "end.last")
    whole = ends["1 1 1"]
    assert {1.0, 2.0, 3.0} == set(whole["f_motion"])  # deformable, rigid, asleep
    for grid, end in ends.items():
        assert end["f_motion"].tolist() == whole["f_motion"].tolist(), grid
        assert end["c_node[2]"].tolist() == whole["c_node[2]"].tolist(), grid
        # rounding of sums in another order, grown by a collision over 150 steps
        np.testing.assert_allclose(end[PLACES], whole[PLACES], rtol=0, atol=1e-9)


@pytest.mark.parametrize(("dimension", "readers"), [(2, 1), (2, 2), (2, 4), (3, 1), (3, 4)])
def test_a_restart_brings_back_the_states(dimension, readers, mpi, rng):
    one = apart(rng, dimension)
    one.write(mpi.folder / "heap.data")
    script = mixed_scene(one, "2 1 1", "half", STEPS, dimension)
    script += f"\nwrite_restart half.restart\nrun {STEPS} post no\n"
    script += f"write_dump all custom whole.last {STATE} modify format float %.17g\n"
    mpi(script, 2)
    (half,) = read_dump(mpi.folder / "half.last")
    (whole,) = read_dump(mpi.folder / "whole.last")
    assert {1.0, 2.0, 3.0} == set(half["f_motion"])
    mpi(
        f"""
        atom_style peridem
        read_restart half.restart
        pair_coeff * * peridem/lps {lps_words(SOLIDS[dimension])}
        pair_coeff * * peridem/contact {SPRINGS}
        neighbor 0.3 bin
        {REBUILD}
        compute node all peridem/atom damage bonds
        fix motion all {ADAPT}
        timestep 0.01
        run 0 post no
        write_dump all custom read.last {STATE} modify format float %.17g
        run {STEPS} post no
        write_dump all custom end.last {STATE} modify format float %.17g
        """,
        readers,
    )
    (read,) = read_dump(mpi.folder / "read.last")
    (end,) = read_dump(mpi.folder / "end.last")
    for name in ("x y z", "f_motion", "c_node[2]"):
        np.testing.assert_array_equal(read[name], half[name], err_msg=name)
    # of rigid grains: from the velocity of the centre and the spin, so rounding
    np.testing.assert_allclose(read["vx vy vz"], half["vx vy vz"], rtol=0, atol=1e-14)
    assert end["f_motion"].tolist() == whole["f_motion"].tolist()
    # rounding, grown by a collision
    np.testing.assert_allclose(end[PLACES], whole[PLACES], rtol=0, atol=1e-9)


def test_a_rigid_grain_crosses_a_periodic_boundary(mpi, rng):
    """The same motion in a periodic box as in a wide one, on two ranks."""
    one = apart(rng)
    one = one.moved(one.x)
    lone = one.molecule == 4
    one.v[lone, 0] += 0.9
    one.write(mpi.folder / "heap.data")
    ends = []
    for periodic in (False, True):
        script = mixed_scene(one, "2 1 1", "end", 4 * STEPS)
        if periodic:
            script = script.replace("boundary f f p", "boundary p p p")
        else:
            one.box[:2] = [[-60.0, 60.0], [-60.0, 60.0]]
            one.write(mpi.folder / "heap.data")
        script = script.replace(f"{STATE} ", f"{STATE} xu yu ")
        mpi(script, 2)
        (end,) = read_dump(mpi.folder / "end.last")
        ends.append(end)
        one.box[:2] = [[-13.0, 16.0], [-16.0, 24.0]]
        one.write(mpi.folder / "heap.data")
    wide, wrapped = ends
    assert np.abs(wide["x"] - wrapped["x"])[lone].max() > 10.0  # it did cross
    np.testing.assert_allclose(wrapped["xu yu"], wide["xu yu"], rtol=0, atol=1e-8)
