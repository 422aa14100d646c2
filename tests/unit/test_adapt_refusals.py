"""What ``fix peridem/adapt`` does not do, and says so before anything runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.clouds import Cloud, cloud, disc, join
from support.oracle import Contact, Solid
from support.runs import contact_words, lps_words

SOLID = Solid(bulk=3.0, shear=1.2, horizon=3.05, dimension=2, s0=0.02)
LAW = Contact(radius=0.95, stiffness=2.0, damping=0.0, friction=0.0, tangential=0.0)
STYLES = f"""
    pair_style hybrid/overlay peridem/lps peridem/contact
    pair_coeff * * peridem/lps {lps_words(SOLID)}
    pair_coeff * * peridem/contact {contact_words(LAW)}
    timestep 0.02
    """
ADAPT = "fix motion all peridem/adapt\n"


def discs() -> Cloud:
    """Two, apart from each other."""
    right = cloud(disc(4.0, centre=(12.0, 0.0)), dimension=2, molecule=2)
    return join(cloud(disc(4.0), dimension=2), right, margin=10)


def test_minimize_is_refused_and_works_once_the_fix_is_gone(simulation):
    sim = simulation().load(discs(), dimension=2)
    sim.commands(STYLES + ADAPT + "run 5 post no")
    before = sim.atoms("x")
    with pytest.raises(Exception, match=r"no minimization.*unfix it before minimize and define it"):
        sim.commands("min_style fire\nminimize 0 1e-8 10 10")
    assert (sim.atoms("x") == before).all()
    # as the message says
    sim = simulation().load(discs(), dimension=2)
    sim.commands(STYLES + ADAPT + "run 5 post no\nunfix motion\nmin_style fire")
    sim.commands("minimize 0 1e-8 10 10\n" + ADAPT + "run 5 post no")
    assert sim.fix_vector("motion", 3).tolist() == [0, 2, 0]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (ADAPT + "run_style respa 2 2", "needs run_style verlet, not respa"),
        (ADAPT + "fix other all rigid/small molecule", "both move rigid grains"),
        (ADAPT + "fix other all peridem/adapt", "More than one fix peridem/adapt"),
        (ADAPT + "change_box all triclinic", "does not work in triclinic boxes"),
    ],
)
def test_what_it_cannot_share_a_run_with(words, message, simulation):
    sim = simulation().load(discs(), dimension=2)
    with pytest.raises(Exception, match=message):
        sim.commands(STYLES + words + "\nrun 1")


# --- restart files -------------------------------------------------------------------------------


def written(simulation, folder: Path) -> Path:
    sim = simulation().load(discs(), dimension=2)
    sim.commands(STYLES + ADAPT + f"run 5 post no\nwrite_restart {folder}/one.restart")
    return folder / "one.restart"


def read(simulation, file: Path, extra: str = ""):
    sim = simulation()
    sim.commands(f"atom_style peridem\nread_restart {file}\n{STYLES}{ADAPT}{extra}run 5 post no")
    return sim


def test_grains_deleted_after_a_restart_are_not_looked_for(simulation, tmp_path):
    """What is left is taken stock of anew: it deforms until it is found to be quiet."""
    file = written(simulation, tmp_path)
    # LAMMPS hands out what a restart file holds of nodes when the fix is made
    extra = "fix bonds all peridem/bonds\ngroup gone molecule 2\n"
    sim = read(simulation, file, extra + "delete_atoms group gone compress no\n")
    assert sim.fix_vector("motion", 3).tolist() == [1, 0, 0]
    sim.commands("run 400 post no")
    assert sim.fix_vector("motion", 3).tolist() == [0, 1, 0]
