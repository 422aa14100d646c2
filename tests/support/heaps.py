"""A heap of grains that touch, move and break, and the input scripts that run it anyhow."""

from __future__ import annotations

import numpy as np

from .clouds import Cloud, deformed, join, ragged
from .oracle import (
    Array,
    Bonds,
    Contact,
    Solid,
    bond_state,
    break_bonds,
    contact_pairs,
    contact_state,
    families,
)
from .runs import contact_words, header, lps_words

SOLIDS = {
    2: Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, s0=0.05, viscosity=0.3),
    3: Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=3, s0=0.05, viscosity=0.3),
}
LAW = Contact(radius=0.95, stiffness=5.0, damping=0.4, friction=0.3, tangential=2.0)
REBUILD = "neigh_modify every 1 delay 0 check yes"
SPRINGS = f"radius {LAW.radius} stiffness {LAW.stiffness} damping 0.4 friction 0.3"
RESTITUTION = (
    f"radius {LAW.radius} stiffness {LAW.stiffness} onset 0.1 restitution 0.6 friction 0.3"
)
WRITE = "id mol x y z vx vy vz fx fy fz c_node[1] c_node[2]"


def heap(rng: np.random.Generator, dimension: int) -> Cloud:
    """Grains that overlap a little, each deformed enough to lose some bonds."""
    parts = []
    places = np.array([[0, 0, 0], [4.6, 0.4, 0.2], [0.3, 4.7, 0.1], [4.9, 5.0, 0.3]])
    for k, place in enumerate(places):
        part = ragged(rng, (5, 5) if dimension == 2 else (5, 5, 4), molecule=k + 1)
        part.reference[:, :dimension] += place[:dimension]
        part.x = part.reference.copy()
        parts.append(part)
    one = join(*parts, margin=2.0)
    x = deformed(rng, one, 0.07, dimension)
    v = np.zeros_like(x)
    v[:, :dimension] = rng.normal(size=(one.n, dimension))
    return one.moved(x, v)


def tumbling(rng: np.random.Generator, dimension: int = 2) -> Cloud:
    """Grains that fly through the box, hit each other and break."""
    one = heap(rng, dimension)
    one = one.moved(one.reference)
    centre = one.x.mean(axis=0)
    one.v[:] = -0.25 * (one.x - centre)
    one.v[:, 0] += 0.8
    one.v[one.molecule == 2] += (-1.0, 0.3, 0.0)
    one.box[:2] = [[-8.0, 24.0], [-12.0, 16.0]]
    if dimension == 3:
        one.box[2] = [-12.0, 16.0]
    return one


def heap_script(
    one: Cloud,
    dimension: int,
    grid: str,
    newton: str,
    name: str,
    steps: int = 0,
    tiled: bool = False,
    extra: str = "",
    dt: float = 0.01,
    contact: str | None = None,
) -> str:
    """Input for one run of the heap; its states go to NAME.dump (first) and NAME.last."""
    balance = "comm_style tiled\nbalance 1.0 rcb" if tiled else ""
    text = header(
        one,
        "heap.data",
        dimension=dimension,
        newton=newton,
        extra="" if tiled else f"processors {grid}",
    )
    return (
        f"clear\n{text}\n"
        + f"""
        {balance}
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(SOLIDS[dimension])}
        pair_coeff * * peridem/contact {contact or contact_words(LAW)}
        compute node all peridem/atom damage bonds
        fix motion all nve
        timestep {dt}
        thermo_style custom step pe press
        thermo_modify norm no format float %.17g
        thermo 1000000
        dump state all custom 1000000 {name}.dump {WRITE}
        dump_modify state format float %.17g
        variable energy equal pe
        variable pressure equal press
        {extra}
        run {steps} post no
        print "${{energy}} ${{pressure}}" file {name}.thermo
        write_dump all custom {name}.last {WRITE} modify format float %.17g
        """.replace("\n        ", "\n")
    )


def heap_model(one: Cloud, dimension: int) -> tuple[Array, float, Bonds]:
    """Forces, energy and bonds of the numpy model: enough contacts and broken bonds to count."""
    bonds = families(one.reference, one.volume, one.molecule, SOLIDS[dimension])
    break_bonds(bonds, one.x)
    pairs = contact_pairs(one.molecule, one.reference, LAW.radius, bonds)
    contact = contact_state(LAW, *pairs, one.x, one.v, one.volume)
    assert (contact.normal > 0).sum() > 5
    assert 10 < (~bonds.intact).sum() < 0.9 * bonds.count
    state = bond_state(bonds, one.x, one.v)
    return state.force + contact.force, state.energy.sum() + contact.energy.sum(), bonds
