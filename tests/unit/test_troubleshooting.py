"""Scenes that go wrong as users' scenes do: what is seen is on the page of troubleshooting.

The scene is the README's, with one thing spoilt. Nothing fails silently: each of these ends with an
error or a warning, and the page has the words.
"""

from __future__ import annotations

import os
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LMP = Path(os.environ.get("LAMMPS_LMP", ROOT / "build" / "lmp")).resolve()


def scene() -> str:
    block = re.search(r"^```\n(units .*?)^```$", (ROOT / "README.md").read_text(), re.M | re.S)
    assert block
    return block[1]


@dataclass(frozen=True)
class Symptom:
    """A change of the scene, what is then printed, and what the page says to do.

    Attributes:
        changes: words of the script and what stands in their place.
        seen: on the screen, and on the page.
        remedy: on the page.
        fails: the run ends with an error.
    """

    changes: dict[str, str]
    seen: tuple[str, ...]
    remedy: str
    fails: bool = False


STEPS = {"run            36000": "run 200"}
SMALL = """create_atoms   1 region high
lattice        sq 0.02e-3
region         small cylinder z 40 60 9 -1 1
create_atoms   2 region small"""
SYMPTOMS = {
    "step ten times too long": Symptom(
        {"timestep       5.0e-8": "timestep 2.0e-6", "run            36000": "run 9000"},
        ("is longer than the largest stable one", "Too many neighbor bins"),
        "The time step is too long",
        fails=True,
    ),
    "small grains between large nodes": Symptom(
        {
            "create_box     1 box": "create_box 2 box",
            "create_atoms   1 region high": SMALL,
            "mol 2": "mol 2\nset region small mol 3",
            "pair_style     hybrid": "set type 2 volume 4e-10\npair_style     hybrid",
            "pair_coeff     * * peridem/lps": "pair_coeff 2 2 peridem/lps bulk 21.6e6 "
            "shear 12.96e6 gc 5 horizon 0.06e-3\npair_coeff 1 1 peridem/lps",
            "timestep       5.0e-8": "timestep 5.0e-9",
            **STEPS,
        },
        ("other nodes fit through between them",),
        "*radius auto* goes by the smallest spacing",
    ),
    "a grain flies out of the box": Symptom(
        {
            "s s p": "f f p",
            "fix            left": "velocity all set -100 0 0 units box # ",
            **STEPS,
        },
        ("bonded nodes have left the box through a fixed boundary",),
        "A grain flew out of a face of type f",
        fails=True,
    ),
    "a skin of metres": Symptom(
        {"lattice        sq": "neighbor 2e-3 bin\nlattice sq", **STEPS},
        ("Proc sub-domain size < neighbor skin", "Communication cutoff adjusted"),
        "The skin: 1.25 times the contact radius is the default",
    ),
    "grains that overlap": Symptom(
        {"peridem/contact restitution": "peridem/contact radius 0.25e-3 restitution", **STEPS},
        ("of the contact distance: they will be pushed apart",),
        "Pack grains at least one contact radius apart",
    ),
    "a lid at the outline": Symptom(
        {"0 2.05e-3 0": "0 1.97e-3 0", **STEPS},
        ("nodes overlap the wall at the start",),
        "Put the wall a contact radius away from the grains",
    ),
    "velocities of ghosts switched off": Symptom(
        {"atom_style     peridem": "atom_style peridem\ncomm_modify vel no", **STEPS},
        (),  # contact asks for them by itself
        "",
    ),
}


@pytest.mark.parametrize("name", SYMPTOMS)
def test_what_is_seen_is_on_the_page(name: str, tmp_path: Path) -> None:
    if not LMP.is_file():
        pytest.skip(f"{LMP} is not there: make build")
    symptom = SYMPTOMS[name]
    script = scene()
    for words, others in symptom.changes.items():
        assert words in script, words
        script = script.replace(words, others)
    (tmp_path / "in.scene").write_text(script)
    command = [LMP, "-in", "in.scene", "-nocite"]
    done = subprocess.run(command, cwd=tmp_path, text=True, capture_output=True)
    assert (done.returncode != 0) == symptom.fails, done.stdout[-2000:]
    page = " ".join((ROOT / "doc" / "troubleshooting.rst").read_text().split())
    page = page.replace("``", "")
    for words in symptom.seen:
        assert words in done.stdout
        assert words in page
    if not symptom.seen:
        assert "WARNING" not in done.stdout
    assert symptom.remedy in page


@pytest.mark.slow
def test_velocities_of_ghosts_do_not_depend_on_the_script(tmp_path: Path) -> None:
    """Restitution and friction with *comm_modify vel no* are those without it, to the last digit.

    The upper disc comes down on the lower one, which another rank has.
    """
    if not LMP.is_file():
        pytest.skip(f"{LMP} is not there: make build")
    meeting = "group top molecule 2\nvelocity top set 0.5 -4 0 units box\npair_style "
    changed = scene().replace("pair_style ", meeting, 1).replace("run            36000", "run 1000")
    changed = changed.replace("custom 1000 grains.dump id", "custom 200 grains.dump id vx vy")
    ends = []
    for words in ("", "\ncomm_modify vel no"):
        script = changed.replace("atom_style     peridem", f"atom_style peridem{words}")
        (tmp_path / "in.scene").write_text(script)
        command = ["mpirun", "-np", "2", LMP, "-in", "in.scene", "-nocite"]
        # ranks that wait give way: the machine may be busy
        environment = {**os.environ, "OMPI_MCA_mpi_yield_when_idle": "1"}
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, env=environment)
        ends.append((tmp_path / "grains.dump").read_text())
    frames = ends[0].split("ITEM: ATOMS")
    speeds = [
        [float(line.split()[2]) for line in frame.splitlines()[1:139]] for frame in frames[1:]
    ]
    assert min(speeds[0]) == -4.0 and sum(speeds[-1]) > 0.9 * sum(speeds[0])  # they have met
    assert ends[0] == ends[1]
