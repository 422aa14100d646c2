"""Recorded states of the PeriDEM library, for node-by-node comparison.

They live outside the repository: in the folder named by the environment variable PERIDEM_SHARED, or
in ``shared`` beside the repository.  Tests that need them are skipped where they are missing.
"""

from __future__ import annotations

import csv
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from .oracle import Array, Ints, Solid


def reference_folder(case: str) -> Path:
    """Folder of one recorded case; skips the calling test when it is not there."""
    named = os.environ.get("PERIDEM_SHARED")
    beside = Path(__file__).resolve().parents[3] / "shared"
    folder = (Path(named) if named else beside) / "reference" / case
    if not (folder / "nodes.npz").is_file():
        pytest.skip(f"recorded states of {case} are not there (looked in {folder})")
    return folder


@dataclass
class Recorded:
    """One dump: u after the step, the velocity used for it, force per volume at (u, v)."""

    particle: Ints
    reference: Array
    volume: Array
    u: Array
    v: Array
    force_density: Array
    theta: Array
    m: Array


class Recording:
    """All dumps of a case and the constants it ran with."""

    def __init__(self, case: str) -> None:
        self.folder = reference_folder(case)
        self._data = np.load(self.folder / "nodes.npz")
        self._columns = {str(name): k for k, name in enumerate(self._data["columns"])}
        with (self.folder / "particle_meta.csv").open() as file:
            self.particles = list(csv.DictReader(file))
        contacts = self.folder / "contact_meta.csv"
        self.contacts = list(csv.DictReader(contacts.open())) if contacts.is_file() else []

    @property
    def steps(self) -> list[int]:
        return sorted(int(key[4:]) for key in self._data.files if key.startswith("step"))

    def at(self, step: int) -> Recorded:
        table = self._data[f"step{step}"].astype(float)

        def take(*names: str) -> Array:
            return table[:, [self._columns[name] for name in names]]

        return Recorded(
            particle=take("particle")[:, 0].astype(np.int64),
            reference=take("x0", "y0", "z0"),
            volume=take("vol")[:, 0],
            u=take("ux", "uy", "uz"),
            v=take("vx", "vy", "vz"),
            force_density=take("fx", "fy", "fz"),
            theta=take("theta")[:, 0],
            m=take("mx")[:, 0],
        )


def jha_solid(particle: dict[str, str]) -> Solid:
    """The solid a recorded particle is made of: constants of 3D in 2D, taper with its smallest
    node spacing, linear influence, breaking in tension and compression."""
    return Solid(
        bulk=float(particle["K"]),
        shear=float(particle["G"]),
        horizon=float(particle["horizon"]),
        dimension=2,
        plane="jha",
        taper_length=float(particle["h"]),
        s0=float(particle["s0"]),
        break_both=True,
    )
