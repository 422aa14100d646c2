"""The time step where all contacts have an onset: they are counted one by one, ahead of time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from support.clouds import Cloud, cloud
from support.oracle import Array
from support.runs import Simulation, header

STIFFNESS, RADIUS, EVERY = 5.0, 1.0, 10
SPARE = 0.05  # of the contact distance: gaps that count as closed
CONTACTS = 1  # place of the step of contacts in the vector of fix peridem/timestep


@dataclass(frozen=True)
class Held:
    """What contacts hold nodes by, as in numpy: pairs (or a node and a wall), directions."""

    i: np.ndarray
    j: np.ndarray  # -1: the wall
    normal: Array


def crowd(rng: np.random.Generator, dimension: int, speed: float = 0.0) -> Cloud:
    """Nodes of different masses that are grains of their own and overlap."""
    n = 40
    x = np.zeros((n, 3))
    x[:, :dimension] = rng.uniform(0.0, 0.5 * n ** (1 / dimension) + 1.0, (n, dimension))
    density = rng.uniform(1.0, 3.0, n)
    one = cloud(x, molecule=np.arange(n) + 1, dimension=dimension, density=density, margin=20)
    one.v[:, :dimension] = speed * rng.normal(size=(n, dimension))
    return one


def single(one: Cloud) -> float:
    """Frequency squared of two nodes that touch, the lightest there are."""
    return 2.0 * STIFFNESS / one.mass.min()


def near(one: Cloud, floor: float | None = None) -> Held:
    """Contacts that there may be before the next look: a plain loop over all pairs."""
    time = EVERY * 2.0 / np.sqrt(single(one))
    found = []
    for i in range(one.n):
        for j in range(i):
            d = one.x[j] - one.x[i]
            closing = time * np.linalg.norm(one.v[j] - one.v[i])
            if np.linalg.norm(d) < (1.0 + SPARE) * RADIUS + closing:
                found.append((i, j, d / np.linalg.norm(d)))
        if floor is not None:
            gap = one.x[i, 1] - floor
            if gap < (1.0 + SPARE) * RADIUS + time * np.linalg.norm(one.v[i]):
                found.append((i, -1, np.array([0.0, 1.0, 0.0])))
    return Held(
        np.array([f[0] for f in found]),
        np.array([f[1] for f in found]),
        np.array([f[2] for f in found]),
    )


def bound(one: Cloud, held: Held, across: float = 0.0) -> float:
    """Largest eigenvalue over nodes of sum k n n / (m s), s the node's share of a contact.

    Shares are in proportion to the same without shares. across: of the tangential springs over the
    normal ones.
    """
    dimension = 3 if np.ptp(one.x[:, 2]) > 0.0 else 2

    def most(share: Array) -> Array:
        tensors = np.zeros((one.n, 3, 3))
        for i, j, n, s in zip(held.i, held.j, held.normal, share, strict=True):
            here = STIFFNESS * ((1.0 - across) * np.outer(n, n) + across * np.eye(3))
            tensors[i] += here / s
            if j >= 0:
                tensors[j] += here / (1.0 - s) if s < 1.0 else here
        return np.linalg.eigvalsh(tensors[:, :dimension, :dimension])[:, -1] / one.mass

    whole = most(np.ones(len(held.i)))
    other = np.where(held.j < 0, 0.0, whole[held.j])
    return float(max(most(whole[held.i] / (whole[held.i] + other)).max(), single(one)))


def script(words: str = "onset 0.1", step: str = "safety 0.8", wall: str = "") -> str:
    return f"""
        pair_style peridem/contact
        pair_coeff * * radius {RADIUS} stiffness {STIFFNESS} {words}
        {wall}
        compute limit all peridem/dt
        fix motion all nve
        fix step all peridem/timestep {step}
        thermo_style custom step dt pe ke
        run 0 post no
        """


def contact_step(sim: Simulation) -> float:
    return float(sim.fix_vector("step", 5)[CONTACTS])


def limit(sim: Simulation) -> float:
    """What compute peridem/dt says of contacts."""
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR

    return sim.lmp.numpy.extract_compute("limit", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR)[CONTACTS]


@pytest.mark.parametrize("speed", [0.0, 0.01])
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_bound_is_that_of_numpy(dimension, speed, simulation, rng):
    one = crowd(rng, dimension, speed)
    sim = simulation().load(one, dimension=dimension, skin=1.0).commands(script())
    held = near(one)
    assert len(held.i) > len(near(crowd(rng, dimension)).i) / 4  # it is a crowd
    # rounding: sums in another order, and the cubic of three dimensions near double eigenvalues
    assert contact_step(sim) == pytest.approx(2.0 / np.sqrt(bound(one, held)), rel=1e-10)


def test_speeds_and_small_gaps_count(rng):
    """What the test above compares with is not the same with and without them."""
    one = crowd(rng, 2)
    still, moving = near(one), near(one.moved(one.x, crowd(rng, 2, 0.01).v))
    touching = sum(
        np.linalg.norm(one.x[j] - one.x[i]) < RADIUS for i in range(one.n) for j in range(i)
    )
    assert touching < len(still.i) < len(moving.i)


@pytest.mark.parametrize("dimension", [2, 3])
def test_friction_holds_across(dimension, simulation, rng):
    one = crowd(rng, dimension)
    sim = simulation().load(one, dimension=dimension, skin=1.0)
    sim.commands(script("onset 0.1 friction 0.3 tangential history 0.4"))
    expected = 2.0 / np.sqrt(bound(one, near(one), 0.4))
    assert contact_step(sim) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_bound_holds(dimension, simulation, rng):
    """The largest frequency of the contacts that touch, as stiff as they get, is not above it."""
    one = crowd(rng, dimension)
    d = dimension
    stiffness = np.zeros((d * one.n, d * one.n))
    for i in range(one.n):
        for j in range(i):
            r = one.x[j, :d] - one.x[i, :d]
            if np.linalg.norm(r) < RADIUS:
                n = np.outer(r, r) / (r @ r)
                for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                    stiffness[d * a : d * a + d, d * b : d * b + d] += sign * STIFFNESS * n
    scale = np.repeat(1.0 / np.sqrt(one.mass), d)
    exact = 2.0 / np.sqrt(np.linalg.eigvalsh(scale[:, None] * stiffness * scale)[-1])
    sim = simulation().load(one, dimension=dimension, skin=1.0).commands(script())
    # directions, and gaps that count, make it smaller than the exact one
    assert 0.7 * exact < contact_step(sim) <= exact


def test_walls_hold_nodes_too(simulation, rng):
    one = crowd(rng, 2, 0.01)
    floor = float(one.x[:, 1].min()) - 0.9
    wall = f"fix floor all peridem/wall plane 0 {floor:.17g} 0 0 1 0"
    sim = simulation().load(one, dimension=2, skin=1.0).commands(script(wall=wall))
    held = near(one, floor)
    assert (held.j < 0).sum() > 1
    assert contact_step(sim) == pytest.approx(2.0 / np.sqrt(bound(one, held)), rel=1e-10)


def test_a_node_between_wall_and_node_counts_both(simulation):
    """In a row with the wall: 2 k/m + k/m; the pair alone has k/m + k/m."""
    one = cloud([[0, 0.9], [0, 1.8]], molecule=[1, 2], dimension=2, margin=20)
    wall = "fix floor all peridem/wall plane 0 0 0 0 1 0"
    with_wall = simulation().load(one, dimension=2).commands(script(wall=wall))
    alone = simulation().load(one, dimension=2).commands(script())
    assert contact_step(with_wall) == pytest.approx(2.0 / np.sqrt(3.0 * STIFFNESS), rel=1e-12)
    assert contact_step(alone) == pytest.approx(2.0 / np.sqrt(2.0 * STIFFNESS), rel=1e-12)


def test_apart_the_step_is_that_of_one_contact(simulation):
    """Nodes far from each other: not longer, since one contact may come at any time."""
    one = cloud([[0, 0], [4, 0]], molecule=[1, 2], dimension=2, margin=20)
    sim = simulation().load(one, dimension=2).commands(script())
    assert contact_step(sim) == pytest.approx(2.0 / np.sqrt(single(one)), rel=1e-12)


@pytest.mark.parametrize(
    ("words", "step", "wall"),
    [
        ("onset 0", "every 10", ""),
        ("onset 0.1", "every 10", "onset 0"),
        ("onset 0.1", "every 101", ""),
    ],
    ids=["no onset", "a wall without", "looks are rare"],
)
def test_otherwise_contacts_are_expected_everywhere(words, step, wall, simulation):
    """The step of compute peridem/dt: three springs at two nodes, whatever there is."""
    one = cloud([[0, 0], [4, 0]], molecule=[1, 2], dimension=2, margin=20)
    line = f"fix floor all peridem/wall plane 0 -9 0 0 1 0 {wall}" if wall else ""
    sim = simulation().load(one, dimension=2).commands(script(words, step, line))
    assert contact_step(sim) == pytest.approx(2.0 / np.sqrt(3.0 * single(one)), rel=1e-12)
    assert limit(sim) == contact_step(sim)


def test_compute_dt_expects_contacts_everywhere(simulation):
    """Whoever sets a step by hand sets it for long."""
    one = cloud([[0, 0], [4, 0]], molecule=[1, 2], dimension=2, margin=20)
    sim = simulation().load(one, dimension=2).commands(script())
    assert limit(sim) == pytest.approx(2.0 / np.sqrt(3.0 * single(one)), rel=1e-12)


@pytest.mark.parametrize("ranks", [2, 4])
def test_any_number_of_ranks_finds_the_same(ranks, mpi, rng):
    one = crowd(rng, 2, 0.01)
    one.write(mpi.folder / "crowd.data")
    found = []
    for count in (1, ranks):
        mpi(
            header(one, "crowd.data", dimension=2, skin=1.0)
            + script(wall=f"fix floor all peridem/wall plane 0 {one.x[:, 1].min() - 0.9} 0 0 1 0")
            + 'print "$(f_step[2]:%.17g)" file step.txt\n',
            count,
        )
        found.append(float((mpi.folder / "step.txt").read_text()))
    assert found[0] == pytest.approx(found[1], rel=1e-14)  # order of sums


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_crowd_keeps_its_energy(dimension, simulation, rng):
    """Nodes that fly about in a box for 300 times of a contact, at the default step.

    Velocity Verlet keeps the energy less (omega dt)^2/4 of what contacts store: 0.64 at most. All
    was motion at the start, so that much may be lacking. 3 % is for contacts that open and close:
    runs of other seeds strayed by up to 1.5 %, with linear springs by up to 31 %. Beyond the limit
    the gas would blow up.
    """
    side = 6
    x = np.zeros((side**dimension, 3))
    x[:, :dimension] = 1.15 * np.argwhere(np.ones((side,) * dimension))
    n = len(x)
    one = cloud(x, molecule=np.arange(n) + 1, dimension=dimension, density=rng.uniform(1, 3, n))
    one.v[:, :dimension] = 0.02 * rng.normal(size=(n, dimension))
    walls = "\n".join(
        f"fix w{k} all peridem/wall plane {' '.join(map(str, point))} {' '.join(map(str, n))}\n"
        f"fix_modify w{k} energy yes"
        for k, (point, n) in enumerate(
            (end * axis, np.sign(-end) * axis)
            for axis in np.eye(3)[:dimension]
            for end in (-1.0, 1.15 * side)
        )
    )
    sim = simulation().load(one, dimension=dimension, skin=1.0)
    sim.commands(script("onset 0.05", "", walls))
    start = sim.thermo("pe") + sim.thermo("ke")
    sim.commands("run 1500 post no")
    assert sim.thermo("time") > 300 * np.pi / np.sqrt(single(one))
    stored, gained = sim.thermo("pe") / start, (sim.thermo("pe") + sim.thermo("ke")) / start - 1.0
    assert -0.64 * stored - 0.03 < gained < 0.03
