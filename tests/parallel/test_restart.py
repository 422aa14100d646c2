"""Stopping and going on: restart files on any number of ranks, runs in pieces, ``clear``.

Velocity Verlet evaluates forces between its two half kicks, and at the start of every run LAMMPS
evaluates them anew with full-step velocities.  Forces that depend on velocity (damping, friction,
viscosity) therefore differ by O(dt) at the step where a run starts, with any LAMMPS style.  So a
run that goes on from a restart is compared with one that also starts a new run there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.heaps import LAW, REBUILD, RESTITUTION, SOLIDS, SPRINGS, WRITE, heap_script, tumbling
from support.runs import contact_words, lps_words, read_dump

FIRST, SECOND = 150, 250


def go_on(name: str, steps: int, contact: str) -> str:
    """Read the restart, write the state as read, run on, write the end.

    LAMMPS keeps ``pair_style hybrid`` in a restart file, but not the coefficients under it.
    """
    return f"""
clear
atom_style peridem
read_restart half.restart
pair_coeff * * peridem/lps {lps_words(SOLIDS[2])}
pair_coeff * * peridem/contact {contact}
neighbor 0.3 bin
{REBUILD}
compute node all peridem/atom damage bonds
fix motion all nve
timestep 0.01
thermo 100000
dump state all custom 1000000 {name}.dump {WRITE}
dump_modify state format float %.17g first yes
run 0 post no
undump state
run {steps} post no
write_dump all custom {name}.last {WRITE} modify format float %.17g
"""


@pytest.mark.parametrize(
    "contact",
    [contact_words(LAW), SPRINGS, RESTITUTION],
    ids=["regularised friction", "springs", "restitution"],
)
@pytest.mark.parametrize("writers", [1, 2])
def test_a_restart_in_the_middle_continues_on_any_number_of_ranks(writers, contact, mpi, rng):
    one = tumbling(rng)
    one.write(mpi.folder / "heap.data")
    whole = heap_script(one, 2, "1 1 1", "on", "whole", steps=FIRST, extra=REBUILD, contact=contact)
    whole += (
        f"\nrun {SECOND} post no\nwrite_dump all custom end.state {WRITE} "
        "modify format float %.17g\n"
    )
    mpi(whole, 1)
    grid = "1 1 1" if writers == 1 else "2 1 1"
    half = heap_script(one, 2, grid, "on", "half", steps=FIRST, extra=REBUILD, contact=contact)
    half += (
        f"\nwrite_restart half.restart\nwrite_dump all custom half.state {WRITE} "
        "modify format float %.17g\n"
    )
    mpi(half, writers)
    (written,) = read_dump(mpi.folder / "half.state")
    (end,) = read_dump(mpi.folder / "end.state")
    assert 0.0 < written["c_node[1]"].mean() < end["c_node[1]"].mean()  # broken before and after
    for readers in (1, 2, 4):
        mpi(go_on(f"read{readers}", SECOND, contact), readers)
        (read,) = read_dump(mpi.folder / f"read{readers}.dump")
        for name in ("mol", "x y z", "vx vy vz", "c_node[1]", "c_node[2]"):
            np.testing.assert_array_equal(read[name], written[name], err_msg=name)
        (last,) = read_dump(mpi.folder / f"read{readers}.last")
        assert last["c_node[2]"].tolist() == end["c_node[2]"].tolist(), readers
        # as between rank counts: rounding, grown by collisions, over 400 steps
        np.testing.assert_allclose(last["x y z"], end["x y z"], rtol=0, atol=1e-9)


def test_runs_in_pieces_end_where_one_run_ends(simulation, rng):
    """Without forces that depend on velocity, see above."""
    solid, law = replace(SOLIDS[2], viscosity=0.0), replace(LAW, damping=0.0, friction=0.0)
    one = tumbling(rng)
    ends = []
    for pieces in (1, 40):
        sim = (
            simulation()
            .load(one, dimension=2)
            .commands(
                f"""
            pair_style hybrid/overlay peridem/lps peridem/contact
            pair_coeff * * peridem/lps {lps_words(solid)}
            pair_coeff * * peridem/contact {contact_words(law)}
            compute node all peridem/atom damage bonds
            fix motion all nve
            timestep 0.01
            """
            )
        )
        for _ in range(pieces):
            sim.commands(f"run {400 // pieces} post no")
        ends.append((sim.atoms("x"), sim.compute("node")))
    assert ends[0][1][:, 0].mean() > 0.02
    assert ends[0][1][:, 1].tolist() == ends[1][1][:, 1].tolist()
    # each run starts with new neighbour lists, so sums come in another order: rounding
    np.testing.assert_allclose(ends[1][0], ends[0][0], rtol=0, atol=1e-9)


def test_clear_forgets_everything_of_the_simulation_before(simulation, rng):
    one = tumbling(rng)
    setup = f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(SOLIDS[2])}
        pair_coeff * * peridem/contact {contact_words(LAW)}
        compute node all peridem/atom damage bonds
        fix motion all nve
        timestep 0.01
        run 400 post no
        """
    sim = simulation().load(one, dimension=2).commands(setup)
    first, node = sim.atoms("x"), sim.compute("node")
    assert node[:, 0].mean() > 0.02
    sim.commands("clear").load(one, dimension=2).commands(setup)
    np.testing.assert_array_equal(sim.atoms("x"), first)
    np.testing.assert_array_equal(sim.compute("node"), node)


def test_a_restart_without_hybrid_needs_no_pair_coeff(simulation, rng):
    """Materials and contact coefficients come back from the file with the style itself."""
    one = tumbling(rng)
    for style, words in (
        ("peridem/lps", lps_words(replace(SOLIDS[2], viscosity=0.0))),
        ("peridem/contact", contact_words(replace(LAW, damping=0.0, friction=0.0))),
    ):
        first = (
            simulation()
            .load(one, dimension=2)
            .commands(
                f"pair_style {style}\npair_coeff * * {words}\nfix motion all nve\n"
                "timestep 0.01\nrun 100 post no"
            )
        )
        restart = first.folder / "plain.restart"
        first.commands(f"write_restart {restart}\nrun 0 post no")
        second = simulation().commands(f"read_restart {restart}\nfix motion all nve\nrun 0 post no")
        assert np.abs(first.atoms("f")).max() > 0.01
        np.testing.assert_array_equal(second.atoms("f"), first.atoms("f"))


def test_broken_bonds_stay_broken_through_a_restart_that_relaxes_the_grain(simulation, rng):
    """Break, restart, put every node back: the stress-free whole grain is not whole."""
    one = tumbling(rng)
    x = one.reference + rng.uniform(-0.07, 0.07, one.x.shape) * (1, 1, 0)
    script = "compute node all peridem/atom damage bonds stretch\nfix motion all nve\n"
    first = (
        simulation()
        .load(one.moved(x), dimension=2)
        .commands(
            f"pair_style peridem/lps\npair_coeff * * {lps_words(SOLIDS[2])}\n{script}run 0 post no"
        )
    )
    restart = first.folder / "broken.restart"
    first.commands(f"write_restart {restart}")
    broken = first.compute("node")
    assert 0.02 < broken[:, 0].mean() < 0.9
    second = simulation().commands(f"read_restart {restart}\n{script}run 0 post no")
    np.testing.assert_array_equal(second.compute("node"), broken)
    np.testing.assert_array_equal(second.at(one.reference).compute("node"), broken)


def test_minimisation_finds_the_unstrained_grain(simulation, rng):
    """min_style runs through the same forces and neighbour lists: it must end without energy."""
    one = tumbling(rng)
    x = one.reference + rng.uniform(-0.02, 0.02, one.x.shape) * (1, 1, 0)
    solid = replace(SOLIDS[2], viscosity=0.0, s0=np.inf)
    sim = (
        simulation()
        .load(one.moved(x, 0 * x), dimension=2)
        .commands(
            f"""
        pair_style peridem/lps
        pair_coeff * * {lps_words(solid)}
        min_style cg
        run 0 post no
        """
        )
    )
    start = sim.thermo("pe")
    sim.commands("minimize 0.0 1e-10 2000 20000")
    assert sim.thermo("pe") < 1e-12 * start
