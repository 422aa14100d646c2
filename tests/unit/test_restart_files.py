"""Restart files of another version of the package, cut ones, and those of contact alone.

Every record begins with a stamp that says how it is laid out (``src/PERIDEM/peridem_stamp.h``): a
million for each layout, and the bytes of a struct where one follows.  After the name of a fix
LAMMPS writes the length of its record; after that of a pair style comes what the style writes.
"""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
import pytest

from support.clouds import Cloud, cloud, disc, join
from support.oracle import Solid
from support.runs import Simulation, lps_words

SOLID = Solid(bulk=3.0, shear=1.2, horizon=3.05, dimension=2, s0=0.02)
LPS = f"pair_coeff * * {lps_words(SOLID)}\n"
CONTACT = (
    "pair_coeff * * radius 0.95 stiffness 5.0 onset 0.2 restitution 0.7 friction 0.4 "
    "tangential history 0.6\n"
)
BOTH = f"""
    pair_coeff * * peridem/lps {lps_words(SOLID)}
    pair_coeff * * peridem/contact radius 0.95 stiffness 2.0 friction 0.3
    """
HYBRID = "pair_style hybrid/overlay peridem/lps peridem/contact\n"
FIXES = """
    compute books all peridem/energy
    fix floor all peridem/wall plane 0 -5 0 0 1 0 radius 0.95 stiffness 2.0
    fix motion all peridem/adapt
    timestep 0.02
    """


def discs() -> Cloud:
    """Two, apart from each other."""
    right = cloud(disc(4.0, centre=(12.0, 0.0)), dimension=2, molecule=2)
    return join(cloud(disc(4.0), dimension=2), right, margin=10)


def write(simulation, folder: Path, styles: str) -> Path:
    sim = simulation().load(discs(), dimension=2)
    sim.commands(styles + f"run 5 post no\nwrite_restart {folder}/one.restart")
    return folder / "one.restart"


def read(simulation, file: Path, styles: str = "") -> Simulation:
    return simulation().commands(f"atom_style peridem\nread_restart {file}\n{styles}run 1 post no")


PMB = "pair_coeff * * bulk 3 s0 0.02 horizon 3.05\n"
# name in the file: styles that write it, those that read it, bytes from the name to the stamp, and
# how the message begins
SCENE = HYBRID + BOTH + FIXES, BOTH + FIXES
RECORDS = {
    "peridem/adapt": (*SCENE, 4, "Fix peridem/adapt"),
    "peridem/wall": (*SCENE, 4, "Fix peridem/wall"),
    "peridem/bonds": (*SCENE, 4, "Fix peridem/bonds"),
    "PERIDEM_HISTORY": (*SCENE, 4, "Pair style peridem/contact"),
    "PERIDEM_LEDGER": (*SCENE, 4, "Compute peridem/energy"),
} | {
    name: (f"pair_style {name}\n{words}", "", 0, f"Pair style {name}")
    for name, words in (("peridem/contact", CONTACT), ("peridem/lps", LPS), ("peridem/pmb", PMB))
}
# what a stamp may be: one of few layouts, of a struct of hundreds of bytes at most
STAMPS = {1e6 * layout + size for layout in (1, 2, 3) for size in range(1000)}


@pytest.mark.parametrize("more", [1.0, 1e6], ids=["size", "layout"])
@pytest.mark.parametrize("name", RECORDS)
def test_a_record_of_another_version_is_refused(name, more, simulation, tmp_path):
    styles, again, away, beginning = RECORDS[name]
    file = write(simulation, tmp_path, styles)
    read(simulation, file, again)  # as it is, it is taken
    data = bytearray(file.read_bytes())
    # the name of a fix may be its ID too, and comes once more with what belongs to nodes
    places = [found.end() + away for found in re.finditer(name.encode() + b"\0", data)]
    stamps = {at: struct.unpack_from("=d", data, at)[0] for at in places}
    ((at, number),) = ((at, one) for at, one in stamps.items() if one in STAMPS)
    struct.pack_into("=d", data, at, number + more)
    file.write_bytes(data)
    message = "written by another version of the package: go on with that one, or start from a data"
    with pytest.raises(Exception, match=f"{beginning}.*: the restart file was {message}"):
        read(simulation, file, again)


@pytest.mark.parametrize("style", ["peridem/lps", "peridem/pmb", "peridem/contact"])
def test_coefficients_of_another_size_or_without_a_stamp_are_refused(style, simulation, tmp_path):
    """Files of early versions have no stamps, and those of contact a shorter struct.

    Solids have settings (the ID of the fix that keeps bonds; the engine) before coefficients.
    """
    file = write(simulation, tmp_path, RECORDS[style][0])
    whole = file.read_bytes()
    key = style.encode() + b"\0"
    at = whole.index(key) + len(key)
    if style == "peridem/contact":
        (stamp,) = struct.unpack_from("=d", whole, at)
        size = int(stamp % 1e6)
        assert struct.unpack_from("=i", whole, at + 8) == (1,)  # types 1 1 have coefficients
        shorter = whole[:at] + whole[at + 8 : at + 4 + size] + whole[at + 12 + size :]
        assert len(shorter) == len(whole) - 16
        changed = [shorter]
    else:
        (letters,) = struct.unpack_from("=i", whole, at + 8)
        assert whole[at + 12 : at + 12 + letters] == b"peridem_bonds"
        second = at + 12 + letters + (4 if style == "peridem/lps" else 0)
        changed = [whole[:at] + whole[at + 8 :]]
        patched = bytearray(whole)
        struct.pack_into("=d", patched, second, struct.unpack_from("=d", whole, second)[0] - 8.0)
        changed.append(bytes(patched))
    for data in changed:
        file.write_bytes(data)
        with pytest.raises(Exception, match=f"Pair style {style}: the restart file was written by"):
            read(simulation, file)


@pytest.mark.parametrize("style", ["peridem/lps", "peridem/contact"])
def test_a_file_cut_within_the_coefficients_is_refused(style, simulation, tmp_path):
    file = write(simulation, tmp_path, RECORDS[style][0])
    data = file.read_bytes()
    file.write_bytes(data[: data.index(style.encode() + b"\0") + len(style) + 60])
    with pytest.raises(Exception, match=r"[Ii]ncomplete|[Uu]nexpected end of file"):
        read(simulation, file)


# --- contact alone -------------------------------------------------------------------------------


def marbles(rng: np.random.Generator) -> Cloud:
    """Single nodes of two types that rattle between walls, many of them touching at any time."""
    x = 0.93 * np.stack(np.meshgrid(np.arange(5.0), np.arange(5.0)), -1).reshape(-1, 2)
    return cloud(
        x + rng.uniform(-0.02, 0.02, x.shape),
        molecule=1 + np.arange(25),
        types=1 + np.arange(25) % 2,
        dimension=2,
        v=np.column_stack([rng.uniform(-1, 1, (25, 2)), np.zeros(25)]),
        margin=5,
    )


def test_contact_alone_goes_on_from_a_restart_with_all_its_coefficients(simulation, rng):
    """Without pair_coeff lines: as a run that starts anew at the same step, to rounding, which
    collisions multiply over 300 steps.  Types 1 2 are mixed again from lines of their own.
    """
    walls = "\n".join(
        f"fix {name} all peridem/wall plane {p} {p} 0 {n} restitution 0.8 friction 0.3"
        for name, p, n in (
            ("w", -0.9, "1 0 0"),
            ("e", 4.6, "-1 0 0"),
            ("s", -0.9, "0 1 0"),
            ("n", 4.6, "0 -1 0"),
        )
    )
    motion = f"{walls}\nfix motion all nve\ntimestep 0.01\nneigh_modify delay 0 every 1\n"
    lines = CONTACT.replace("* *", "1 1") + CONTACT.replace("* *", "2 2").replace("0.2", "0.35")
    sim = simulation().load(marbles(rng), dimension=2)
    sim.commands(f"pair_style peridem/contact\n{lines}{motion}run 200 post no")
    file = sim.folder / "contact.restart"
    sim.commands(f"write_restart {file}")
    again = simulation().commands(f"read_restart {file}\nneighbor 0.3 bin\n{motion}")
    for one in (sim, again):
        one.commands("run 0 post no")
    # forces of one state; without onset, friction or springs they would differ in all digits
    scale = np.abs(sim.atoms("f")).max()
    assert scale > 0.1
    np.testing.assert_allclose(again.atoms("f"), sim.atoms("f"), rtol=0, atol=1e-13 * scale)
    for one in (sim, again):
        one.commands("run 300 post no")
    for name in ("x", "v"):
        np.testing.assert_allclose(again.atoms(name), sim.atoms(name), rtol=0, atol=1e-9)
    laws = [set(re.findall(r"contact of types .*", one.printed())) for one in (sim, again)]
    assert len(laws[0]) == 3 and all("onset over" in law for law in laws[0])
    assert laws[1] == laws[0]
