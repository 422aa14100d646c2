"""A disc falls on a held one: node by node through the contact against the PeriDEM library.

Time stepping: see test_stretched_disc.  PeriDEM's velocity v at a dump is LAMMPS's velocity minus
half a kick, so a run that starts from a dump adds dt f/2m with the forces of ``run 0``.
The held disc is not moved at all and the contact has neither friction nor damping.

One difference between the models shows.  PeriDEM compares lengths with a relative tolerance of
1e-5: nodes touch only when they overlap by more than 1e-5 R_c = 1.3e-9 m, half of what the disc
falls in a step.  Where contact starts and ends, its force is missing for a step or two, which is a
kick of k_N V 1.3e-9 dt / rho = 1.3e-3 m/s to a node that falls at 0.09 m/s.  So the tests below

- compare to rounding where no contact starts or ends: the fall, and step 141000 to 142000;
- go through the whole contact with the numpy model twice: with that tolerance it must equal PeriDEM
  to rounding, and without it LAMMPS to rounding;
- compare the motion of the whole disc with PeriDEM's through to the end.
"""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import cloud
from support.oracle import Contact, bond_state, contact_state, families
from support.peridem_data import Recording, jha_solid
from support.runs import contact_words, lps_words, number

DT, GRAVITY, DENSITY = 3e-8, 10.0, 1200.0


@pytest.fixture
def recording() -> Recording:
    return Recording("twop_circ_nodamp_fine")


def started(simulation, recording, step):
    """LAMMPS in the recorded state of ``step``, with velocities half a kick ahead."""
    state, particles = recording.at(step), recording.particles
    one = cloud(
        state.reference,
        volume=state.volume,
        molecule=state.particle + 1,
        density=float(particles[0]["density"]),
        types=state.particle + 1,
        dimension=2,
        margin=2e-3,
    )
    # both discs have one h, horizon and material, to the last digits of h
    law = Contact(
        radius=float(recording.contacts[1]["contactR"]),
        stiffness=float(recording.contacts[1]["Kn"]),
    )
    sim = simulation().load(
        one.moved(state.reference + state.u, state.v), dimension=2, units="si", skin=3e-4
    )
    sim.commands(
        f"""
        group falling type 2
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff 1 1 peridem/lps {lps_words(jha_solid(particles[0]))}
        pair_coeff 2 2 peridem/lps {lps_words(jha_solid(particles[1]))}
        pair_coeff * * peridem/contact {contact_words(law)}
        fix weight falling gravity {GRAVITY} vector 0 -1 0
        fix motion falling nve
        timestep {number(DT)}
        run 0 post no
        """
    )
    sim.kick = lambda: 0.5 * DT * sim.atoms("f") / sim.atoms("rmass")[:, None]
    count, order = sim.lmp.extract_global("nlocal"), sim.order
    falling = state.particle == 1
    ahead = state.v + np.where(falling[:, None], sim.kick(), 0.0)
    sim.lmp.numpy.extract_atom("v")[:count][order] = ahead
    return sim, falling


def displacement(sim, falling):
    return (sim.atoms("x") - sim.atoms("x0"))[falling]


def speed(sim, falling):
    return (sim.atoms("v") - sim.kick())[falling]


def assert_same(u, v, other_u, other_v, accuracy):
    """Displacements to ``accuracy`` of the deformation, velocities to that of the largest."""
    deformation = np.abs(other_u - other_u.mean(axis=0)).max()
    assert np.abs(u - other_u).max() < accuracy * deformation
    assert np.abs(v - other_v).max() < accuracy * np.abs(other_v).max()


def test_state_in_the_middle_of_the_contact(simulation, recording):
    """A thousand steps in contact.

    Coordinates of 4e-3 are rounded to 4e-19 at each step; k_N V = 4e16 turns that into 2e-2 of the
    7e8 of contact force, so 1e-10 of the motion at once and 1e-9 in the end.
    """
    sim, falling = started(simulation, recording, 141000)
    force = sim.atoms("f")[falling] / recording.at(141000).volume[falling][:, None]
    expected = recording.at(141000).force_density[falling]
    assert np.abs(force - expected).max() < 1e-9 * np.abs(expected).max()
    sim.commands("run 1000 post no")
    end = recording.at(142000)
    assert_same(
        displacement(sim, falling),
        speed(sim, falling),
        end.u[falling],
        end.v[falling],
        accuracy=1e-8,
    )
    assert np.all((sim.atoms("x") - sim.atoms("x0"))[~falling] == 0.0)


class SymplecticEuler:
    """The falling disc in numpy: v += dt f/rho, u += dt v, f(u), as PeriDEM steps.

    ``tolerance``: contact counts where the overlap exceeds this fraction of the contact radius.
    """

    def __init__(self, recording: Recording, step: int, tolerance: float) -> None:
        state, self.step, self.tolerance = recording.at(step), step, tolerance
        falling = state.particle == 1
        held, mine = np.flatnonzero(~falling), np.flatnonzero(falling)
        self.falling, self.reference, self.volume = falling, state.reference, state.volume
        self.u, self.v = state.u.copy(), state.v.copy()
        self.bonds = families(
            state.reference, state.volume, falling.astype(int), jha_solid(recording.particles[1])
        )  # the held disc: molecule 0
        pair = recording.contacts[1]
        self.law = Contact(radius=float(pair["contactR"]), stiffness=float(pair["Kn"]))
        i, j = (side.ravel() for side in np.meshgrid(held, mine, indexing="ij"))
        x = state.reference + state.u
        near = np.linalg.norm(x[j] - x[i], axis=1) < 4 * self.law.radius
        self.i, self.j = i[near], j[near]
        self.acceleration = self._acceleration()

    def _acceleration(self):
        x = self.reference + self.u
        force = bond_state(self.bonds, x).force
        r = np.linalg.norm(x[self.j] - x[self.i], axis=1)
        on = self.law.radius - r > self.tolerance * self.law.radius
        if on.any():
            i, j = self.i[on], self.j[on]
            reach = np.full(len(i), self.law.radius)
            force += contact_state(self.law, i, j, reach, x, self.v, self.volume).force
        acceleration = force / (DENSITY * self.volume)[:, None]
        acceleration[:, 1] -= GRAVITY
        acceleration[~self.falling] = 0.0
        return acceleration

    def advance_to(self, step: int) -> None:
        while self.step < step:
            self.v += DT * self.acceleration
            self.u += DT * self.v
            self.acceleration = self._acceleration()
            self.step += 1


@pytest.mark.slow
def test_through_the_whole_contact_with_and_without_the_tolerance(simulation, recording):
    """From the fall at step 140000 through touch and release (140577-142186) to step 144000.

    Rounding as in the middle of the contact, and 4000 steps instead of 1000: 1e-8.
    """
    theirs = SymplecticEuler(recording, 140000, tolerance=1e-5)
    ours = SymplecticEuler(recording, 140000, tolerance=0.0)
    sim, falling = started(simulation, recording, 140000)
    for step in (141000, 142000, 143000, 144000):
        recorded = recording.at(step)
        theirs.advance_to(step)
        assert_same(
            theirs.u[falling],
            theirs.v[falling],
            recorded.u[falling],
            recorded.v[falling],
            accuracy=1e-8,
        )
        ours.advance_to(step)
        sim.commands("run 1000 post no")
        assert_same(
            displacement(sim, falling),
            speed(sim, falling),
            ours.u[falling],
            ours.v[falling],
            accuracy=1e-8,
        )


@pytest.mark.slow
def test_motion_of_the_disc_from_the_start_to_the_end(simulation, recording):
    """All 160000 steps: fall, contact, rebound."""
    sim, falling = started(simulation, recording, 0)
    sim.commands("run 140000 post no")
    fallen = recording.at(140000)
    # 140000 additions to x = 3e-3, each rounded by up to 2e-19: 3e-14 at most, 1e-16 by chance
    assert np.abs(displacement(sim, falling) - fallen.u[falling]).max() < 3e-14
    sim.commands("run 20000 post no")
    end = recording.at(160000)
    rebound = speed(sim, falling).mean(axis=0)
    expected = end.v[falling].mean(axis=0)
    assert expected[1] > 0.05  # it bounced
    # the missing steps of contact kick one node of 123 by 1.3e-3 m/s, some ten times: 1e-4 m/s
    assert np.abs(rebound - expected).max() < 2e-4
