"""A crowd of nodes that collide with their six neighbours: what energy contacts gain by the step.

``python -m support.rattling`` (from ``tests/``) prints the table of the manual's page of fix
peridem/timestep.

Each node is a grain of its own, on a hexagonal lattice whose spacing is the contact distance, in a
periodic box: nothing takes energy away, so whatever comes beyond what there was is of the time
step.  Contacts are linear springs, so the speed of the nodes does not matter while overlaps are
small; of those with an onset its depth over that of the overlaps does.
"""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

from .runs import Simulation

# of two nodes of mass 1 whose spring is 1: half the period of their vibration
CONTACT = math.pi / math.sqrt(2.0)
SAFETIES = (0.9, 0.8, 0.6, 0.5, 0.4, 0.2)
PARTS = (0, 1, 2, 3, 4)  # onsets, over the overlap
OVERLAP = 0.01  # of two nodes, at their mean square speed, over the contact distance

CROWD = f"""
    units lj
    dimension 2
    atom_style peridem
    lattice hex {2.0 / math.sqrt(3.0):.17g}
    region box block 0 20 0 12 -0.5 0.5
    create_box 1 box
    create_atoms 1 box
    set group all density 1.0
    set group all volume 1.0
    variable grain atom id
    set group all mol v_grain
    pair_style peridem/contact
    pair_coeff * * radius 1.0 stiffness 1.0 onset {{onset}}
    neighbor 1.0 bin
    velocity all create {OVERLAP**2} 4711 mom yes
    fix motion all nve
    fix plane all enforce2d
    thermo_modify norm no
    variable now equal time
"""


def gain(
    folder: Path, safety: float, onset: float = 0.0, duration: float = 900.0 * CONTACT
) -> float:
    """Logarithm of the energy over that at the start, per time of one contact."""
    sim = Simulation(folder).commands(CROWD.format(onset=onset))
    sim.commands(f"fix step all peridem/timestep safety {safety}\nrun 0 post no")
    start = sim.thermo("pe") + sim.thermo("ke")
    sim.commands(f"fix end all halt 10 v_now > {duration} error continue\nrun 1000000 post no")
    sim.commands("unfix end\nrun 0 post no")
    end = sim.thermo("pe") + sim.thermo("ke")
    time = sim.thermo("time")
    sim.close()
    return math.log(end / start) * CONTACT / time


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        print("energy gained in the time of one contact, by the onset over the overlaps")
        print("safety  " + "".join(f"{part:<10}" for part in PARTS))
        for safety in SAFETIES:
            found = [gain(Path(folder), safety, part * OVERLAP) for part in PARTS]
            print(f"{safety:<6}  " + "".join(f"{one:<10.1e}" for one in found))
