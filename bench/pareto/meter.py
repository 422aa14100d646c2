"""The cases of ``tests/verification`` with a meter: processor time of LAMMPS's steps.

Left out are what Python does between LAMMPS's commands (meshing, files, conjugate gradients) and
what LAMMPS does before the first step of a run, families included: ``run 0`` does that first.
"""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Callable
from pathlib import Path
from textwrap import dedent

# the cases live with the tests, which are no installed package
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

from support.runs import Simulation
from verification.cases.base import Lab

STEPS = re.compile(r"\s*run\s+[1-9]")
NO_STEP = "run 0 post no"


class Meter(Lab):
    """A lab that adds up the processor seconds of the steps of its LAMMPS instances."""

    seconds: float = 0.0

    def simulation(self, *arguments: str) -> Simulation:
        """A LAMMPS whose runs are timed."""
        sim = super().simulation(*arguments)
        command = sim.lmp.command

        def run(line: str) -> None:
            if not STEPS.match(line):
                command(line)
            elif "pre no" in line:
                self.seconds += _seconds(command, line)
            else:
                command(NO_STEP)
                self.seconds += _seconds(command, f"{line} pre no")

        whole = sim.lmp.commands_string

        def run_all(text: str) -> None:
            lines = dedent(text).splitlines()
            if not any(STEPS.match(line) for line in lines):
                whole(text)
                return
            for line in lines:
                if line.strip():
                    run(line)

        sim.lmp.command, sim.lmp.commands_string = run, run_all
        return sim


def _seconds(command: Callable[[str], None], line: str) -> float:
    start = time.process_time()
    command(line)
    return time.process_time() - start
