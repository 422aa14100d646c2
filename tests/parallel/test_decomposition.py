"""One state, many ways to spread it over ranks: forces to 1e-12, broken bonds exactly.

Each mpirun goes through all processor grids of its rank count in one input script with ``clear``
between them, and writes the state of every node at full precision.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.clouds import cloud, disc, join, ragged, rotated
from support.heaps import (
    REBUILD,
    RESTITUTION,
    SOLIDS,
    SPRINGS,
    heap,
    heap_model,
    heap_script,
    tumbling,
)
from support.oracle import bond_state, families, intact_bonds
from support.runs import header, lps_words, read_dump

GRIDS = {
    1: ["1 1 1"],
    2: ["2 1 1", "1 2 1", "1 1 2"],
    4: ["4 1 1", "2 2 1", "1 4 1", "1 2 2"],
}


@pytest.mark.parametrize("ranks", [1, 2, 4])
@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_energy_and_broken_bonds_on_any_processor_grid_with_newton_on_and_off(
    dimension, ranks, mpi, rng
):
    one = heap(rng, dimension)
    one.write(mpi.folder / "heap.data")
    grids = [grid for grid in GRIDS[ranks] if dimension == 3 or grid.endswith("1")]
    cases = [(grid, newton) for grid in grids for newton in ("on", "off")]
    mpi(
        "\n".join(
            heap_script(one, dimension, grid, newton, f"case{k}")
            for k, (grid, newton) in enumerate(cases)
        ),
        ranks,
    )
    force, energy, bonds = heap_model(one, dimension)
    pressure = None
    for k, case in enumerate(cases):
        (frame,) = read_dump(mpi.folder / f"case{k}.dump")
        # another order of the same sums: rounding
        np.testing.assert_allclose(
            frame["fx fy fz"], force, rtol=0, atol=1e-12 * np.abs(force).max(), err_msg=str(case)
        )
        assert frame["c_node[2]"].astype(int).tolist() == intact_bonds(bonds).tolist(), case
        printed = (mpi.folder / f"case{k}.thermo").read_text().split()
        assert float(printed[0]) == pytest.approx(energy, rel=1e-12), case
        pressure = float(printed[1]) if pressure is None else pressure
        assert float(printed[1]) == pytest.approx(pressure, rel=1e-11), case


@pytest.mark.parametrize("ranks", [1, 2, 4])
def test_grains_across_periodic_boundaries(ranks, mpi, rng):
    """The heap shifted so that every boundary cuts grains, in a box that it nearly fills."""
    one = heap(rng, 3)
    force, _, bonds = heap_model(one, 3)
    low = one.x.min(axis=0)
    shift = np.array([5.0, 8.0, 3.0])
    one.box = np.stack([low, low + np.ptp(one.x, axis=0) + 3.0], axis=1)
    one.periodic = (True, True, True)
    one.x, one.reference = one.x + shift, one.reference + shift
    one.write(mpi.folder / "heap.data")
    cases = [(grid, newton) for grid in GRIDS[ranks] for newton in ("on", "off")]
    mpi(
        "\n".join(
            heap_script(one, 3, grid, newton, f"case{k}") for k, (grid, newton) in enumerate(cases)
        ),
        ranks,
    )
    for k, case in enumerate(cases):
        (frame,) = read_dump(mpi.folder / f"case{k}.dump")
        # differences of coordinates up to 15 wrap around: rounding of 2e-15 over extensions of 0.05
        np.testing.assert_allclose(
            frame["fx fy fz"], force, rtol=0, atol=1e-12 * np.abs(force).max(), err_msg=str(case)
        )
        assert frame["c_node[2]"].astype(int).tolist() == intact_bonds(bonds).tolist(), case


@pytest.mark.parametrize("ranks", [2, 4])
def test_tiled_communication_after_load_balancing(ranks, mpi, rng):
    one = heap(rng, 2)
    one.write(mpi.folder / "heap.data")
    mpi(
        heap_script(one, 2, "", "on", "tiled", tiled=True)
        + heap_script(one, 2, "", "off", "tiledoff", tiled=True),
        ranks,
    )
    force, _, bonds = heap_model(one, 2)
    for name in ("tiled", "tiledoff"):
        (frame,) = read_dump(mpi.folder / f"{name}.dump")
        np.testing.assert_allclose(
            frame["fx fy fz"], force, rtol=0, atol=1e-12 * np.abs(force).max()
        )
        assert frame["c_node[2]"].astype(int).tolist() == intact_bonds(bonds).tolist()


def test_bonds_of_a_grain_read_far_from_its_reference_are_complete_on_every_rank(mpi, rng):
    """Reference and position in one data file, bonds stretched to four times the horizon.

    Partners are then further apart than the horizon: a rank that looks for them only as far as
    that loses bonds.
    """
    solid = replace(SOLIDS[2], s0=np.inf, viscosity=0.0)
    one = ragged(rng, (6, 6))
    x = one.reference * 4.0
    one = one.moved(x)
    one.box[:2] = [[-20.0, 20.0], [-20.0, 20.0]]
    one.write(mpi.folder / "far.data")
    for ranks, grid in ((1, "1 1 1"), (4, "2 2 1")):
        mpi(
            header(one, "far.data", dimension=2, extra=f"processors {grid}")
            + f"""
pair_style peridem/lps
pair_coeff * * {lps_words(solid)}
compute node all peridem/atom bonds
dump state all custom 1 far{ranks}.dump id fx fy fz c_node
dump_modify state format float %.17g
run 0 post no
""",
            ranks,
        )
    bonds = families(one.reference, one.volume, one.molecule, solid)
    force = bond_state(bonds, x).force
    for ranks in (1, 4):
        (frame,) = read_dump(mpi.folder / f"far{ranks}.dump")
        assert frame["c_node"].astype(int).tolist() == intact_bonds(bonds).tolist(), ranks
        np.testing.assert_allclose(
            frame["fx fy fz"], force, rtol=0, atol=1e-12 * np.abs(force).max()
        )


@pytest.mark.parametrize(
    "contact", [None, SPRINGS, RESTITUTION], ids=["regularised friction", "springs", "restitution"]
)
@pytest.mark.parametrize("tiled", [False, True], ids=["brick", "tiled, balanced on the way"])
def test_many_steps_with_migration_end_in_the_same_state(tiled, contact, mpi, rng):
    """400 steps: grains cross rank boundaries while their bonds break.

    Rounding differences of 1e-16 grow by collisions; over this time they stay below 1e-9, far from
    what one lost bond or a stale ghost would do (1e-3).
    """
    one = tumbling(rng)
    one.write(mpi.folder / "heap.data")
    extra = REBUILD + ("\nfix even all balance 50 1.05 rcb" if tiled else "")
    mpi(heap_script(one, 2, "1 1 1", "on", "alone", steps=400, extra=REBUILD, contact=contact), 1)
    for ranks, grid in ((2, "2 1 1"), (4, "2 2 1")):
        run = dict(steps=400, tiled=tiled, extra=extra, contact=contact)
        mpi(
            heap_script(one, 2, grid, "on", f"on{ranks}", **run)
            + heap_script(one, 2, grid, "off", f"off{ranks}", **run),
            ranks,
        )
    (alone,) = read_dump(mpi.folder / "alone.last")
    assert np.abs(alone["x y z"] - one.x).max() > 3.0  # they did travel
    assert alone["c_node[1]"].mean() > 0.02  # and break
    for name in ("on2", "off2", "on4", "off4"):
        (frame,) = read_dump(mpi.folder / f"{name}.last")
        assert frame["c_node[2]"].tolist() == alone["c_node[2]"].tolist(), name
        np.testing.assert_allclose(frame["x y z"], alone["x y z"], rtol=0, atol=1e-9)


def test_a_grain_larger_than_a_rank_spins_through_all_of_them(mpi, rng):
    """Four ranks meet inside one unbreakable spinning grain, periodic in both directions."""
    solid = replace(SOLIDS[2], s0=np.inf, viscosity=0.0)
    one = ragged(rng, (12, 12))
    one.v[:, :2] = 0.3 * np.column_stack([-one.x[:, 1], one.x[:, 0]]) + (2.0, 1.0)
    one.box[:2] = [[-8.0, 11.0], [-9.0, 10.0]]
    one.periodic = (True, True, False)
    one.write(mpi.folder / "spin.data")
    for ranks, grid in ((1, "1 1 1"), (4, "2 2 1")):
        mpi(
            header(one, "spin.data", dimension=2, extra=f"processors {grid}")
            + f"""
pair_style peridem/lps
pair_coeff * * {lps_words(solid)}
fix motion all nve
timestep 0.02
thermo 1000
run 600 post no
write_dump all custom spin{ranks}.last id xu yu zu fx fy fz modify format float %.17g
""",
            ranks,
        )
    (alone,), (four,) = (read_dump(mpi.folder / f"spin{ranks}.last") for ranks in (1, 4))
    assert np.abs(alone["xu yu zu"] - one.x).max() > 19.0  # through the whole box
    # 600 steps of rounding, at coordinates of 20 that wrap: no collisions to magnify it
    np.testing.assert_allclose(four["xu yu zu"], alone["xu yu zu"], rtol=0, atol=1e-10)


def test_bonds_that_outgrow_the_ghost_cutoff_on_the_way_are_followed(mpi, rng):
    """An unbreakable bar pulled to four times its length: bonds of 2 horizons and more."""
    solid = replace(SOLIDS[2], s0=np.inf, viscosity=0.0)
    one = ragged(rng, (10, 4), density=1.0)
    one.v[:, 0] = 0.3 * one.x[:, 0]
    one.box[:2] = [[-30.0, 30.0], [-12.0, 12.0]]
    one.write(mpi.folder / "bar.data")
    for ranks, grid in ((1, "1 1 1"), (4, "4 1 1")):
        mpi(
            header(one, "bar.data", dimension=2, extra=f"processors {grid}")
            + f"""
pair_style peridem/lps
pair_coeff * * {lps_words(solid)}
compute node all peridem/atom bonds
group ends id {" ".join(str(k + 1) for k in range(one.n) if abs(one.x[k, 0]) > 3.7)}
fix motion all nve
fix hold ends setforce 0.0 0.0 0.0
timestep 0.01
run 1000 post no
write_dump all custom bar{ranks}.last id x y z c_node modify format float %.17g
""",
            ranks,
        )
    (alone,), (four,) = (read_dump(mpi.folder / f"bar{ranks}.last") for ranks in (1, 4))
    assert np.ptp(alone["x"]) > 3.5 * np.ptp(one.x[:, 0])
    assert four["c_node"].tolist() == alone["c_node"].tolist()
    # 1000 steps of rounding in a vibrating bar
    np.testing.assert_allclose(four["x y z"], alone["x y z"], rtol=0, atol=1e-9)


@pytest.mark.parametrize("style", ["shift x 10 1.05", "rcb"])
def test_fix_balance_moves_nodes_between_ranks_at_any_time(style, mpi, rng):
    """Balancing exchanges nodes outside the usual moment of reneighbouring."""
    one = tumbling(rng)
    one.write(mpi.folder / "heap.data")
    heap = dict(steps=100, contact=SPRINGS)
    mpi(heap_script(one, 2, "1 1 1", "on", "alone", extra=REBUILD, **heap), 1)
    tiled = style == "rcb"
    extra = f"{REBUILD}\nfix even all balance 10 1.0 {style}"
    mpi(heap_script(one, 2, "2 1 1", "on", "even", tiled=tiled, extra=extra, **heap), 2)
    (alone,), (even,) = (read_dump(mpi.folder / f"{name}.last") for name in ("alone", "even"))
    assert even["c_node[2]"].tolist() == alone["c_node[2]"].tolist()
    # 100 steps of rounding
    np.testing.assert_allclose(even["x y z"], alone["x y z"], rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    "words", ["friction 0.3 damping 0.2", "onset 0.1 friction 0.3 restitution 0.5"]
)
def test_walls_push_and_report_the_same_on_any_number_of_ranks(words, mpi, rng):
    """A moving floor lifts the heap: its reaction, torque, deepest overlap and work."""
    one = tumbling(rng)
    one.v[:] = 0.0
    floor = one.x[:, 1].min() - 0.5
    one.write(mpi.folder / "heap.data")
    report = " ".join(f"$(f_floor[{k}]:%.17g)" for k in range(1, 9))
    extra = (
        f"{REBUILD}\nfix floor all peridem/wall plane 0 {floor} 0 0 1 0 radius 0.95 "
        f"stiffness 5.0 {words} velocity 0.2 0.5 0"
    )
    ends = {}
    for ranks, grid in ((1, "1 1 1"), (2, "2 1 1"), (4, "2 2 1"), (4, "4 1 1")):
        for newton in ("on", "off"):
            script = heap_script(
                one, 2, grid, newton, "lift", steps=150, extra=extra, contact=SPRINGS
            )
            mpi(script + f'\nprint "{report}" file lift.wall\n', ranks)
            (frame,) = read_dump(mpi.folder / "lift.last")
            wall = np.array((mpi.folder / "lift.wall").read_text().split(), dtype=float)
            ends[ranks, grid, newton] = frame["x y z"], wall
    x, wall = ends.pop((1, "1 1 1", "on"))
    assert wall[1] < -0.1 and wall[7] > 0.1  # the heap presses down, the floor works
    for key, (other, reported) in ends.items():
        # 150 steps of rounding
        np.testing.assert_allclose(other, x, rtol=0, atol=1e-10, err_msg=str(key))
        np.testing.assert_allclose(
            reported, wall, rtol=0, atol=1e-9 * np.abs(wall).max(), err_msg=str(key)
        )


@pytest.mark.parametrize("cut", ["", "cut plane 0.0 0.2 0 0.3 1 0 cut plane 9.6 1.7 0 1 0.2 0"])
def test_a_collision_is_the_same_on_any_number_of_ranks(cut, mpi):
    """Whole grains, or two pieces of each; faces of the ranks between and through them."""
    solid = replace(SOLIDS[2], s0=np.inf)
    parts = [
        cloud(rotated(disc(4.2), 0.1 + 0.3 * k) + np.array([9.6 * k, 1.5 * k, 0]), dimension=2)
        for k in (0, 1)
    ]
    parts[1].molecule[:] = 2
    for part, speed in zip(parts, (0.1, -0.1), strict=True):
        part.v[:, 0] = speed
    one = join(*parts, margin=20)
    one.write(mpi.folder / "discs.data")
    ends = {}
    for ranks, grid in ((1, "1 1 1"), (2, "2 1 1"), (4, "2 2 1"), (4, "4 1 1")):
        script = header(one, "discs.data", dimension=2, extra=f"processors {grid}")
        script += f"""
            pair_style hybrid/overlay peridem/lps peridem/contact
            pair_coeff * * peridem/lps {lps_words(solid)}
            pair_coeff * * peridem/contact radius 0.95 modulus 3 restitution 0.5
            {"fix glue all peridem/bonds " + cut if cut else ""}
            fix floor all peridem/wall plane 0 -5.3 0 0 1 0 restitution 0.5
            fix weight all gravity 0.001 vector 0 -1 0
            fix motion all nve
            timestep 0.05
            run 1200 post no
            write_dump all custom end.last id x y z vx vy vz modify format float %.17g
            """
        mpi(script, ranks)
        (frame,) = read_dump(mpi.folder / "end.last")
        ends[ranks, grid] = frame["x y z"], frame["vx vy vz"]
    x, v = ends.pop((1, "1 1 1"))
    right = one.molecule == 2
    assert v[right].mean(axis=0)[0] > -0.02  # they have met
    for key, (other, velocity) in ends.items():
        # 1200 steps of rounding
        np.testing.assert_allclose(other, x, rtol=0, atol=1e-10, err_msg=str(key))
        np.testing.assert_allclose(velocity, v, rtol=0, atol=1e-10, err_msg=str(key))
