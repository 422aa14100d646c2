"""Equilibrium of a solid at small displacements: LAMMPS computes forces, scipy solves.

LAMMPS is asked for forces at positions that conjugate gradients choose; nothing moves by itself.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import LinearOperator, cg

from support.clouds import Cloud
from support.oracle import Array, Solid
from support.runs import Simulation, lps_words

from .base import Lab

STEP = 1.0e-5  # largest displacement, over the spacing, of the states that LAMMPS sees


class Statics:
    """A solid at rest, and its linear response.  Displacements and forces are (n, 3)."""

    def __init__(self, lab: Lab, one: Cloud, solid: Solid, spacing: float, extra: str = "") -> None:
        self.dimension, self.step = solid.dimension, STEP * spacing
        sim = lab.simulation().load(one, dimension=solid.dimension, skin=0.3 * spacing)
        # no integrator; lists are built once, and forces at new positions cost one force evaluation
        sim.commands(
            f"""
            pair_style peridem/lps
            pair_coeff * * {lps_words(solid)}
            neigh_modify every 1000000 delay 1000000 check no
            {extra}
            thermo_modify lost ignore
            run 0 post no
            """
        )
        self.sim, self.order, self.reference = sim, sim.order, one.reference
        self.evaluations = 0

    def state(self, u: Array) -> Simulation:
        """LAMMPS at the reference positions plus ``u``, forces and computes up to date."""
        count = len(self.order)
        self.sim.lmp.numpy.extract_atom("x")[:count][self.order] = self.reference + u
        self.sim.lmp.command("run 1 pre no post no")
        self.evaluations += 1
        return self.sim

    def forces(self, u: Array) -> Array:
        """Linear response to ``u``: central difference of two small states."""
        largest = np.abs(u).max()
        if largest == 0.0:
            return np.zeros_like(u)
        scale = self.step / largest
        sides = []
        for sign in (scale, -scale):
            self.state(sign * u)
            sides.append(self.sim.lmp.numpy.extract_atom("f")[: len(self.order)][self.order].copy())
        return (sides[0] - sides[1]) / (2 * scale)

    def solve(self, load: Array, fixed: Array, u: Array, tolerance: float = 1e-8) -> Array:
        """Displacements in equilibrium with ``load``, as given by ``u`` where ``fixed``."""
        d, free = self.dimension, ~fixed
        shape = (int(free.sum()), d)
        held = np.where(fixed[:, None], u, 0.0)

        def apply(flat: Array) -> Array:
            trial = np.zeros_like(u)
            trial[free, :d] = flat.reshape(shape)
            return -self.forces(trial)[free, :d].ravel()

        size = shape[0] * d
        right = (load + self.forces(held))[free, :d].ravel()
        start = u[free, :d].ravel()
        found, failed = cg(
            LinearOperator((size, size), matvec=apply, dtype=float),
            right,
            x0=start,
            rtol=tolerance,
            maxiter=5000,
        )
        if failed:
            raise RuntimeError("conjugate gradients have not converged in 5000 iterations")
        whole = held.copy()
        whole[free, :d] = found.reshape(shape)
        return whole

    def compute(self, name: str, u: Array) -> Array:
        """A per-atom compute in the state ``u``, made small and scaled back: what is linear."""
        scale = self.step / np.abs(u).max()
        return (self.state(scale * u).compute(name) - self.state(-scale * u).compute(name)) / (
            2 * scale
        )
