"""The time step of contacts, where one rank's nodes touch more others than the other rank's.

The bound of what touches is found with messages between ranks; each must ask as often as the other.
"""

from __future__ import annotations

import re

import numpy as np

NODES = [(-5.0, 0.0)] + [
    (-5.0 + 0.8 * np.cos(a), 0.8 * np.sin(a)) for a in np.arange(6) * np.pi / 3.0
]
SCRIPT = """
    units lj
    dimension 2
    boundary f f p
    processors 2 1 1
    atom_style peridem
    read_data nodes.data
    pair_style peridem/contact
    pair_coeff * * radius 1 stiffness 1
    fix step all peridem/timestep safety 0.5 every 1
    fix motion all nve
    thermo 1
    thermo_style custom step dt
    thermo_modify format float %.12g
    run 3
"""


def steps(mpi, ranks):
    """Time steps of a few steps, as the thermo output has them."""
    lines = [f"{k} {k} 1 1.0 1.0 {x:.17g} {y:.17g} 0" for k, (x, y) in enumerate(NODES, 1)]
    n = len(lines)
    lines += [f"{n + 1} {n + 1} 1 1.0 1.0 4.6 0 0", f"{n + 2} {n + 2} 1 1.0 1.0 5.4 0 0"]
    box = "-10 10 xlo xhi\n-10 10 ylo yhi\n-0.5 0.5 zlo zhi"
    (mpi.folder / "nodes.data").write_text(
        f"nodes\n\n{n + 2} atoms\n1 atom types\n\n{box}\n\nAtoms # peridem\n\n"
        + "\n".join(lines)
        + "\n"
    )
    script = SCRIPT if ranks == 2 else SCRIPT.replace("processors 2 1 1", "")
    found = re.findall(r"^ +\d+ +([\d.e-]+) *$", mpi(script, ranks).stdout, re.MULTILINE)
    return [float(step) for step in found]


def test_a_crowded_rank_does_not_wait_for_the_other(mpi):
    one, two = steps(mpi, 1), steps(mpi, 2)
    assert len(one) == 4
    # sums of six springs in another order
    assert np.allclose(one, two, rtol=1e-12, atol=0.0)
    # the node in the middle touches six, its neighbours three each: more than the three and three
    # that count for all nodes; at a spring and a mass of 1, half of 2/sqrt(6 + 3)
    assert abs(two[0] - 1.0 / 3.0) < 1e-12  # rounding
