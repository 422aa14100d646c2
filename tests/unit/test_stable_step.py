"""The largest stable step against the eigenvalues of the numpy model, and against motion itself."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from support.clouds import cloud, deformed, disc, join, lattice, ragged
from support.oracle import Solid, bond_state, families
from support.runs import Simulation, header, lps_words

SOLIDS = {
    "3D": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=3),
    "plane strain": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, plane="strain"),
    "plane stress": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, plane="stress"),
    "jha": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, plane="jha"),
    "nearly incompressible": Solid(bulk=30.0, shear=0.6, horizon=2.3, dimension=3),
    "without lateral strain": Solid(bulk=1.0, shear=1.5, horizon=2.3, dimension=2),
}
NO_LIMIT = 0.0


def dt_vector(sim: Simulation) -> np.ndarray:
    """Stable steps of bonds, contacts and dashpots; the step of speeds."""
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR

    return sim.lmp.numpy.extract_compute("step", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR).copy()


def dt_scalar(sim: Simulation) -> float:
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR

    return sim.lmp.extract_compute("step", LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR)


def largest_frequency(one, solid) -> float:
    """Square root of the largest eigenvalue of M^-1/2 K M^-1/2; K by differences of the force.

    The force is linear in displacements of 1e-6 up to 1e-6 of itself.
    """
    bonds = families(one.reference, one.volume, one.molecule, solid)
    d, n, step = solid.dimension, one.n, 1e-6
    stiffness = np.zeros((n * d, n * d))
    for k in range(n):
        for axis in range(d):
            push = np.zeros((n, 3))
            push[k, axis] = step
            up, down = (bond_state(bonds, one.reference + s * push).force for s in (1, -1))
            stiffness[:, k * d + axis] = -((up - down) / (2 * step))[:, :d].ravel()
    root = np.sqrt(np.repeat(one.mass, d))
    scaled = 0.5 * (stiffness + stiffness.T) / np.outer(root, root)
    return float(np.sqrt(np.linalg.eigvalsh(scaled)[-1]))


@pytest.mark.parametrize("name", SOLIDS)
def test_step_of_the_bonds_is_two_over_the_largest_frequency(name, simulation, rng):
    """From below by at most 5 %, never above: an estimate on the unsafe side is no use.

    1e-4 above allows for the differences in the numpy stiffness and the convergence of both.
    """
    solid = SOLIDS[name]
    one = ragged(rng, (4, 4, 3) if solid.dimension == 3 else (6, 6))
    sim = simulation().load(one, dimension=solid.dimension)
    sim.commands(
        f"""
        pair_style peridem/lps
        pair_coeff * * {lps_words(solid)}
        compute step all peridem/dt
        fix motion all nve
        run 0 post no
        """
    )
    exact = 2.0 / largest_frequency(one, solid)
    bonds, contacts, dashpots, speeds = dt_vector(sim)
    assert 0.95 * exact < bonds < (1 + 1e-4) * exact
    assert (contacts, dashpots, speeds) == (NO_LIMIT, NO_LIMIT, NO_LIMIT)
    assert dt_scalar(sim) == bonds


@pytest.mark.parametrize(("factor", "stable"), [(0.98, True), (1.06, False)])
def test_motion_is_bounded_below_that_step_and_explodes_above(factor, stable, simulation, rng):
    """A whole grain, shaken a little: the step is within 5 % below the limit (test above)."""
    solid = SOLIDS["plane strain"]
    one = ragged(rng, (6, 6))
    x = deformed(rng, one, 1e-4, 2)
    sim = simulation().load(one.moved(x), dimension=2)
    sim.commands(
        f"""
        pair_style peridem/lps
        pair_coeff * * {lps_words(solid)}
        compute step all peridem/dt
        fix motion all nve
        run 0 post no
        """
    )
    start = sim.thermo("pe")
    sim.commands(f"timestep {factor * dt_scalar(sim):.15g}\nthermo_modify lost ignore norm no")
    if stable:
        sim.commands("run 3000 post no")
        assert sim.thermo("pe") + sim.thermo("ke") < 100 * start
        return
    try:
        sim.commands("run 300 post no")
    except Exception:
        return  # blown out of the box or apart: exploded
    assert not sim.thermo("pe") + sim.thermo("ke") < 1e3 * start


def test_a_step_chosen_too_long_by_hand_is_warned_about(simulation, rng):
    one = ragged(rng, (6, 6))
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"pair_style peridem/lps\npair_coeff * * {lps_words(SOLIDS['plane strain'])}\n"
        "fix motion all nve\ntimestep 5.0\nrun 0 post no"
    )
    assert "The time step 5 is longer than the largest stable one" in sim.printed()


def test_step_of_two_touching_nodes_is_not_above_the_exact_one(simulation):
    """omega^2 = k (1/m1 + 1/m2) for the pair; a limit that holds for crowds is lower."""
    one = cloud([[0, 0], [0.9, 0]], molecule=[1, 2], dimension=2, density=[1.0, 4.0])
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            "pair_style peridem/contact\npair_coeff * * radius 1.0 stiffness 5.0\n"
            "compute step all peridem/dt\nfix motion all nve\nrun 0 post no"
        )
    )
    exact = 2.0 / np.sqrt(5.0 * (1.0 + 0.25))
    contacts = dt_vector(sim)[1]
    assert 0.2 * exact < contacts <= exact


def test_step_holds_for_a_crowd_of_touching_nodes(simulation):
    """Square lattice of single-node grains pressed together: 4 neighbours push each node."""
    one = cloud(lattice((6, 6), 0.95), molecule=np.arange(36) + 1, dimension=2)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            "pair_style peridem/contact\npair_coeff * * radius 1.0 stiffness 5.0\n"
            "compute step all peridem/dt\nfix motion all nve\nrun 0 post no"
        )
    )
    # springs along the lattice lines: omega^2 = 4 k / m (neighbours in antiphase)
    assert dt_vector(sim)[1] <= 2.0 / np.sqrt(4 * 5.0)


def star(mass_ratio: float = 9.0):
    """A light node pressed by six heavy ones around it, which touch nothing else."""
    angle = np.arange(6) * np.pi / 3
    x = np.zeros((7, 2))
    x[1:] = 0.9 * np.column_stack([np.cos(angle), np.sin(angle)])
    density = np.append(1.0, np.full(6, mass_ratio))
    one = cloud(x, molecule=np.arange(7) + 1, dimension=2, density=density)
    return one


STAR = (
    # contact distance 0.95: the heavy nodes are 0.9 apart and touch their two neighbours too
    "pair_style peridem/contact\npair_coeff * * radius 0.95 stiffness 5.0\n"
    "compute step all peridem/dt\nfix motion all nve\n"
)


def test_bound_of_contacts_is_that_of_the_worst_contact(simulation):
    """Six springs at the light node, three at each heavy one; nodes alone would give 2 * 6 k/m."""
    sim = simulation().load(star(), dimension=2).commands(STAR + "run 0 post no")
    bound = 5.0 * (6.0 / 1.0 + 3.0 / 9.0)
    # larger than that of three springs at the lightest node, 2 * 3 k/m
    assert dt_vector(sim)[1] == pytest.approx(2.0 / np.sqrt(bound), rel=1e-12)


def test_bound_of_contacts_holds(simulation):
    """Below the largest frequency of the linear problem, which numpy finds."""
    one = star()
    k, mass = 5.0, one.mass
    stiffness = np.zeros((14, 14))
    for i in range(7):
        for j in range(i):
            d = one.x[j, :2] - one.x[i, :2]
            if np.linalg.norm(d) < 0.95:
                n = np.outer(d, d) / (d @ d)
                for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                    stiffness[2 * a : 2 * a + 2, 2 * b : 2 * b + 2] += sign * k * n
    scale = np.repeat(1.0 / np.sqrt(mass), 2)
    largest = np.linalg.eigvalsh(scale[:, None] * stiffness * scale)[-1]
    sim = simulation().load(one, dimension=2).commands(STAR + "run 0 post no")
    # not above the exact one, and no further below than directions can make it
    exact = 2.0 / np.sqrt(largest)
    assert 0.6 * exact < dt_vector(sim)[1] <= exact


@pytest.mark.parametrize("ranks", [2, 4])
def test_bound_of_contacts_is_the_same_on_any_number_of_ranks(ranks, mpi):
    one = star()
    one.write(mpi.folder / "star.data")
    found = []
    for count in (1, ranks):
        mpi(
            header(one, "star.data", dimension=2)
            + STAR
            + 'run 0 post no\nprint "$(c_step[2]:%.17g)" file step.txt\n',
            count,
        )
        found.append(float((mpi.folder / "step.txt").read_text()))
    assert found[0] == pytest.approx(found[1], rel=1e-14)  # order of sums


def test_fix_timestep_takes_the_safe_fraction_of_the_stable_step(simulation, rng):
    one = ragged(rng, (6, 6))
    steps = {}
    for words in ("", "safety 0.5"):
        sim = (
            simulation()
            .load(one, dimension=2)
            .commands(
                f"""
            pair_style peridem/lps
            pair_coeff * * {lps_words(SOLIDS["plane strain"])}
            compute step all peridem/dt
            fix motion all nve
            fix step all peridem/timestep {words}
            run 1 post no
            """
            )
        )
        steps[words] = sim.thermo("dt") / dt_scalar(sim)
    # rounding of a quotient: the step is found once
    assert steps[""] == pytest.approx(0.8, rel=1e-12)
    assert steps["safety 0.5"] == pytest.approx(0.5, rel=1e-12)


def test_two_discs_collide_at_the_step_of_fix_timestep_and_keep_their_energy(simulation):
    """No losses, nothing breaks: at 0.8 of the limit the energy stays bounded through contact.

    Velocity Verlet keeps a shadow energy that differs from the true one by up to (omega dt)^2/8 of
    what vibrates at omega: at omega dt = 1.6 a third of the little that does; 2 % of all is asked.
    """
    solid = replace(SOLIDS["plane strain"], bulk=30.0, shear=15.0)
    left = cloud(disc(4.3, centre=(-5.0, 0.0)), dimension=2)
    right = cloud(disc(4.3, centre=(5.0, 0.7)), dimension=2, molecule=2)
    left.v[:, 0], right.v[:, 0] = 0.4, -0.4
    one = join(left, right, margin=40)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(solid)}
        pair_coeff * * peridem/contact radius 0.95
        fix motion all nve
        fix step all peridem/timestep
        run 0 post no
        """
        )
    )
    energy = [sim.thermo("pe") + sim.thermo("ke")]
    for _ in range(80):
        sim.commands("run 10 post no")
        energy.append(sim.thermo("pe") + sim.thermo("ke"))
    assert sim.atoms("v")[0, 0] < 0.2  # they did collide
    assert np.abs(np.array(energy) / energy[0] - 1.0).max() < 0.02


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("safety 1.5", "safety 1.5: must be > 0 and <= 1"),
        ("safety 0", "safety 0: must be > 0 and <= 1"),
        ("every 0", "every 0: must be >= 1"),
        ("colour red", "Unknown fix peridem/timestep keyword colour: known are safety, every"),
        ("safety", "safety needs a value"),
    ],
)
def test_bad_words_for_fix_timestep(words, message, simulation, rng):
    sim = simulation().load(ragged(rng, (4, 4)), dimension=2)
    with pytest.raises(Exception, match=message):
        sim.commands(f"fix step all peridem/timestep {words}")


def test_dashpots_shorten_the_step(simulation, rng):
    """Viscosity of the bonds and damping of contacts each make the stable step smaller."""
    one = ragged(rng, (6, 6))
    found = []
    for viscosity, damping in itertools.product((0.0, 0.5), (0.0, 2.0)):
        words = lps_words(replace(SOLIDS["plane strain"], viscosity=viscosity))
        sim = (
            simulation()
            .load(one, dimension=2)
            .commands(
                f"""
            pair_style hybrid/overlay peridem/lps peridem/contact
            pair_coeff * * peridem/lps {words}
            pair_coeff * * peridem/contact radius 0.9 stiffness 5.0 damping {damping}
            compute step all peridem/dt
            fix motion all nve
            run 0 post no
            """
            )
        )
        found.append(dt_scalar(sim))
    plain, damped, viscous, both = found
    assert damped < plain
    assert viscous < plain
    assert both <= min(damped, viscous)


def test_contacts_know_the_mass_of_created_nodes_in_the_first_run(simulation):
    """``set density`` writes the density where the mass is kept: it must not be taken for one."""
    sim = simulation().commands(
        """
        units si
        dimension 2
        atom_style peridem
        boundary s s p
        lattice sq 0.1e-3
        region box block 0 6 0 6 -0.5 0.5
        create_box 1 box
        create_atoms 1 box
        set group all mol 1
        set group all volume 1.0e-8
        set group all density 1200.0
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps bulk 21.6e6 shear 12.96e6 gc 5 horizon 0.3e-3
        pair_coeff * * peridem/contact friction 0.3
        neighbor 0.05e-3 bin
        compute step all peridem/dt
        fix motion all nve
        timestep 1e-9
        run 0 post no
        """
    )
    first = dt_vector(sim)
    sim.commands("run 0 post no")
    assert first.tolist() == dt_vector(sim).tolist()
    # ten bulk moduli of stiffness, up to three springs at a node of mass 1200 * 1e-8; to rounding
    assert first[1] == pytest.approx(2.0 / np.sqrt(2 * 3 * 10 * 21.6e6 / 1.2e-5), rel=1e-12)


def flying(simulation, speed: float):
    """Two nodes that come together with ``speed`` each."""
    one = cloud([[0, 0], [5, 0]], molecule=[1, 2], dimension=2, margin=20)
    one.v[:, 0] = (speed, -speed)
    sim = simulation().load(one, dimension=2)
    return sim.commands(
        """
        pair_style peridem/contact
        pair_coeff * * radius 0.8 stiffness 100.0
        compute step all peridem/dt
        thermo_style custom step dt c_step c_step[4]
        fix motion all nve
        """
    )


def test_the_step_of_speeds_is_a_tenth_of_the_contact_distance_over_the_fastest_node(simulation):
    sim = flying(simulation, 3.0).commands("run 0 post no")
    # rounding of a formula of few terms
    assert dt_vector(sim)[3] == pytest.approx(0.1 * 0.8 / 3.0, rel=1e-14)
    assert dt_scalar(sim) > 2.0 * dt_vector(sim)[3]


def test_fast_nodes_shorten_the_step_that_fix_timestep_sets(simulation):
    """The collision gives the speed back, which the step of stability alone would not."""
    sim = flying(simulation, 3.0).commands("fix step all peridem/timestep\nrun 0 post no")
    assert sim.thermo("dt") == pytest.approx(0.8 * 0.1 * 0.8 / 3.0, rel=1e-14)
    sim.commands("run 120 post no")
    # (omega dt)^2 / 8 of the energy: omega = sqrt(200), dt = 0.02
    assert sim.atoms("v")[:, 0] == pytest.approx([-3.0, 3.0], rel=0.01)
    assert "speeds limit it" in sim.printed()
    slow = flying(simulation, 1e-3).commands("fix step all peridem/timestep\nrun 0 post no")
    assert slow.thermo("dt") == pytest.approx(0.8 * dt_scalar(slow), rel=1e-14)


def test_a_timestep_by_hand_that_is_too_long_for_the_speeds_gives_a_warning(simulation, rng):
    for speed, warned in ((0.02, False), (2.0, True)):
        one = ragged(rng, (4, 4))
        one.v[:, 0] = speed
        sim = simulation().load(one, dimension=2)
        sim.commands(
            f"""
            pair_style hybrid/overlay peridem/lps peridem/contact
            pair_coeff * * peridem/lps {lps_words(SOLIDS["without lateral strain"])}
            pair_coeff * * peridem/contact radius 0.8 stiffness 0.1
            fix motion all nve
            timestep 0.1
            run 0 post no
            """
        )
        said = "The fastest node moves 0.25 of the contact distance in one step" in sim.printed()
        assert said == warned
