"""Commands that change boxes, positions, IDs or attributes under a solid: right, or refused."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from support.clouds import cloud, disc, lattice, ragged
from support.oracle import Solid, bond_state, break_bonds, families
from support.runs import header, lps_words, number, read_dump, solid_script

SOLID = Solid(bulk=3.0, shear=1.2, horizon=3.015, dimension=2)
BRITTLE = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, s0=0.04)
STRETCH = 1e-3


def slab(nx=12, ny=10):
    """One grain that fills a periodic box."""
    one = cloud(lattice((nx, ny)), dimension=2)
    one.box = np.array([[-nx / 2, nx / 2], [-ny / 2, ny / 2], [-0.5, 0.5]])
    one.periodic = (True, True, False)
    return one


STRETCHED = {
    "fix deform": (
        f"fix box all deform 1 x scale {1 + STRETCH} remap x\ntimestep 1e-6\nrun 10 post no\n"
        "unfix box\nrun 0 post no"
    ),
    "change_box": f"change_box all x scale {1 + STRETCH} remap\nrun 0 post no",
}


@pytest.mark.parametrize("how", STRETCHED)
def test_a_box_that_is_stretched_strains_the_grain_in_it(how, simulation):
    """Positions follow the box, references do not: uniform strain across the boundaries."""
    sim = simulation().load(slab(), dimension=2)
    sim.commands(
        f"pair_style peridem/lps\npair_coeff * * {lps_words(SOLID)}\n"
        "compute s all peridem/atom dilatation sxx syy sxy\nrun 0 post no"
    )
    assert np.abs(sim.compute("s")).max() < 1e-12
    sim.commands(STRETCHED[how])
    got = sim.compute("s")
    lame = SOLID.lame
    stress = [(lame + 2 * SOLID.shear) * STRETCH, lame * STRETCH, 0.0]
    # theta of strain xx alone is exact to its square; a lattice's stress within 3 % at 3 spacings
    # (unit/test_fragments_compute.py), and the same at every node
    np.testing.assert_allclose(got[:, 0], STRETCH, rtol=2e-3)
    np.testing.assert_allclose(got[:, 1:3], np.tile(stress[:2], (120, 1)), rtol=0.08)
    assert np.ptp(got, axis=0).max() < 1e-12
    assert np.abs(got[:, 3]).max() < 1e-12


def scatter_ids(data: Path) -> None:
    """Give the nodes of a data file, in their order, IDs with gaps."""
    rng = np.random.default_rng(2)
    ids = np.cumsum(rng.choice([1, 1, 1, 7, 1000], 10000))
    numbered = re.compile(r"^(\d+)(?= \S+ \S+ \S)(?!.* [xyz]lo)", re.M)
    data.write_text(numbered.sub(lambda one: str(ids[int(one[1]) - 1]), data.read_text()))


def test_ranks_agree_in_a_box_that_changes(mpi):
    """And so do an array of all IDs and the hash table that LAMMPS has for large systems."""
    slab(24, 20).write(mpi.folder / "slab.data")
    scatter_ids(mpi.folder / "slab.data")
    states = []
    for ranks, kind in ((1, "array"), (4, "array"), (1, "hash"), (4, "hash")):
        script = header(slab(24, 20), "slab.data", dimension=2)
        script = script.replace("\nread_data", f"\natom_modify map {kind}\nread_data")
        script += f"pair_style peridem/lps\npair_coeff * * {lps_words(SOLID)}\n"
        script += (
            "fix box all deform 1 x erate 0.5 remap x\nfix motion all nve\ntimestep 0.01\n"
            "run 40 post no\nwrite_dump all custom state id x y fx fy modify sort id "
            "format float %.15g\n"
        )
        mpi(script, ranks)
        (frame,) = read_dump(mpi.folder / "state")
        assert frame["id"].max() > 10000  # of 480 nodes
        states.append(frame["x y fx fy"])
    # positions grow to 14; rounding of steps of 40
    for other in states[1:]:
        np.testing.assert_allclose(other, states[0], rtol=0, atol=1e-11)


@pytest.mark.parametrize("solid", [SOLID, BRITTLE], ids=["unbreakable", "brittle"])
def test_rerun_gives_the_forces_of_snapshots(solid, simulation, rng, tmp_path):
    """And breaks what they show beyond the critical stretch, with a warning that says so."""
    one = ragged(rng, (6, 6))
    one.v[:, :2] = 0.15 * one.reference[:, :2] + 0.02 * rng.normal(size=(36, 2))
    setting = f"pair_style peridem/lps\npair_coeff * * {lps_words(solid)}\n"
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"{setting}fix motion all nve\ntimestep 0.02\n"
        f"dump d all custom 10 {tmp_path}/run.dump id x y z fx fy\n"
        "dump_modify d sort id format float %.17g\nrun 30 post no\nundump d"
    )
    again = simulation().load(one, dimension=2)
    again.commands(
        f"{setting}dump d all custom 10 {tmp_path}/rerun.dump id x y z fx fy\n"
        "dump_modify d sort id format float %.17g\n"
        f"rerun {tmp_path}/run.dump dump x y\nundump d"
    )
    frames, found = read_dump(tmp_path / "run.dump"), read_dump(tmp_path / "rerun.dump")
    assert len(found) == len(frames) == 4
    bonds = families(one.reference, one.volume, one.molecule, solid)
    broken = 0
    for frame, other in zip(frames, found, strict=True):
        x = frame["x y z"]
        broken += break_bonds(bonds, x)
        force = bond_state(bonds, x).force[:, :2]
        np.testing.assert_allclose(other["fx fy"], force, rtol=0, atol=1e-12)
        if solid is SOLID:
            np.testing.assert_allclose(other["fx fy"], frame["fx fy"], rtol=0, atol=1e-12)
    assert (broken > 10) == (solid is BRITTLE)
    assert again.printed().count("Rerun: bonds break where") == (solid is BRITTLE)
    sim.commands("run 1 post no\nrun 1 post no\nrun 1 pre no post no")
    assert "Rerun" not in sim.printed()


def built(simulation):
    one = cloud(disc(4.3), dimension=2)
    return simulation().load(one, dimension=2).commands(solid_script(SOLID) + "run 0 post no")


REFUSED = {
    "reset_atoms id": "Cannot use reset_atoms id",
    "group one id 7\nset group one mol 2": "are bonded, but now they are of grains",
    "group one id 7\nset group one volume 1.5": "have changed since the families were built",
}


@pytest.mark.parametrize("command", REFUSED)
def test_what_bonds_do_not_survive_is_refused(command, simulation):
    sim = built(simulation)
    with pytest.raises(Exception, match=re.escape(REFUSED[command])):
        sim.commands(f"{command}\nrun 0")


def test_bonds_made_anew_take_new_volumes_and_grains(simulation):
    sim = built(simulation)
    sim.commands(
        "region left block INF 0.5 INF INF INF INF\ngroup left region left\n"
        "set group left mol 2\nset group all volume 1.1\nunfix peridem_bonds\nrun 0 post no"
    )
    # the engine's roots are right to the last place but one: a stretch of 1e-16 of each bond
    assert np.abs(sim.atoms("f")).max() < 1e-14
    assert sim.lmp.get_natoms() > 50


def test_moving_nodes_by_hand_strains_the_grain_and_velocities_stay(simulation):
    sim = built(simulation)
    sim.commands(
        f"displace_atoms all ramp x 0 {number(8 * STRETCH)} x -4 4\n"
        "velocity all create 1e-4 1234 dist gaussian\ncompute s all peridem/atom dilatation\n"
        "run 0 post no"
    )
    whole = np.linalg.norm(sim.atoms("x"), axis=1) < 1.2  # whole families
    assert whole.sum() == 5
    np.testing.assert_allclose(sim.compute("s")[whole], STRETCH, rtol=2e-3)
    assert np.abs(sim.atoms("v")).max() > 0.0
    assert sim.fix_vector("peridem_bonds", 2)[1] == 0.0
