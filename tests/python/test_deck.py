"""Decks of PeriDEM: what a scene makes of them, what the report says, what is refused."""

import itertools
import math
import re
import time

import decks
import meshio
import numpy as np
import pytest
import pyvista
import yaml
from decks import COLLISION, SOLID, SQUARE, changed, write
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from peridem import cloud, deck, results, run, scene
from peridem.deck import loads as deck_loads
from peridem.deck.geometry import Shape, shape
from peridem.deck.sections import LoadSet
from peridem.deck.source import Block, DeckError, Report, read
from peridem.material import BondMaterial, Inert, Material
from peridem.walls import RegionWall, Wall


def script_lines(text, *start):
    """The words of all lines of a script that start with these, without them."""
    found = [line.split("#")[0].split() for line in text.splitlines()]
    return [words[len(start) :] for words in found if words[: len(start)] == list(start)]


def keywords(words):
    return dict(itertools.pairwise(words))


# ---- a whole deck --------------------------------------------------------------------------------


def test_particles_lie_where_the_table_says(tmp_path):
    made = deck.load(write(tmp_path, COLLISION)).scene
    mesh = cloud.read(tmp_path / "disc.msh")
    for grain, (x, y, r, o) in zip(
        made.grains, [(0.0, 1.5e-3, 1e-3, 0.3), (0.0, 3.8e-3, 1.1e-3, 1.2)], strict=True
    ):
        turn = np.array([[math.cos(o), -math.sin(o)], [math.sin(o), math.cos(o)]])
        expected = (x, y) + r / 1e-3 * mesh.nodes @ turn.T
        # rounding of a product and two sums
        assert grain.cloud.nodes == pytest.approx(expected, rel=1e-14, abs=1e-18)
        assert grain.cloud.volumes == pytest.approx((r / 1e-3) ** 2 * mesh.volumes, rel=1e-14)
    assert [grain.material.name for grain in made.grains] == ["zone_1", "zone_2"]
    assert [grain.material.density for grain in made.grains] == [1200.0, 2400.0]


def test_right_physics_is_the_default(tmp_path):
    loaded = deck.load(write(tmp_path, COLLISION))
    made = loaded.scene
    solid = made.grains[0].material
    assert isinstance(solid, Material)
    assert (solid.bulk, solid.gc, solid.horizon, solid.plane) == (2.16e7, 50.0, 6e-4, "strain")
    assert solid.shear == pytest.approx(1.296e7, rel=1e-12)
    assert solid.breaking == "tension" and solid.taper is None
    assert made.timestep is None and made.adaptive and not made.leapfrog
    assert made.contact.stiffness is None and made.contact.stiff == 10.0
    # the box of nodes is three planes; its top is open
    assert {wall.name for wall in made.walls} == {"floor", "left", "right"}
    places = {wall.name: wall for wall in made.walls}
    assert places["floor"].point[1] == pytest.approx(0.0, abs=1e-18)
    assert places["left"].point[0] == pytest.approx(-2e-3) and places["left"].normal == (1.0, 0.0)
    assert places["right"].point[0] == pytest.approx(2e-3)
    assert loaded.grains == [1, 2, None]
    text = "\n".join(loaded.report)
    for words in ("surfaces", "form bulk 10", "restitution of grains", "opposes sliding"):
        assert words in text


def test_published_behaviour_on_request(tmp_path):
    loaded = deck.load(write(tmp_path, COLLISION), as_published=True)
    made = loaded.scene
    solid, wall = made.grains[0].material, made.grains[2].material
    assert solid.plane == "jha" and solid.breaking == "both"
    # the jha form of the critical stretch, and the smallest node spacing for the taper
    factor = 3 * 1.296e7 + 0.75**4 * (2.16e7 - 5 * 1.296e7 / 3)
    assert solid.critical_stretch(2) == pytest.approx(math.sqrt(50 / (factor * 6e-4)), rel=1e-12)
    mesh = cloud.read(tmp_path / "disc.msh")
    assert solid.taper == pytest.approx(mesh.spacing, rel=1e-14)
    assert isinstance(wall, Inert) and not made.walls
    assert made.timestep == pytest.approx(1e-7) and made.leapfrog
    # the radius follows from the smallest spacing of all, here that of the wall
    assert made.contact.stiffness == 1.59e24
    assert made.contact.radius == pytest.approx(0.95e-4, rel=1e-9)
    mixed = made.pairs["zone_1", "zone_2"]
    assert (mixed.stiffness, mixed.friction, mixed.restitution) == (0.5 * 1.59e24, 0.5, 0.9)
    assert loaded.grains == [1, 2, 3]
    assert any("as published" in line for line in loaded.report)


def test_output_gravity_and_initial_velocity(tmp_path):
    made = deck.load(write(tmp_path, COLLISION)).scene
    assert made.gravity == (0.0, -10.0)
    assert made.grains[0].velocity is None and made.grains[1].velocity == (0.0, -0.5)
    assert (made.frames, made.records) == (10, 20)
    assert made.attributes == ("surface",) and made.columns == ("fx", "fy")
    assert made.duration == 1e-5


def test_report_names_every_key_that_is_not_known(tmp_path):
    path = write(
        tmp_path,
        COLLISION,
        Material__Zone_1__Horizn=3.0,
        Flags={"a": 1},
        Contact__Zone_12__Kn_Facto=2.0,
    )
    report = deck.load(path).report
    numbers = {key: n for n, line in enumerate(path.read_text().splitlines(), 1) for key in [line]}
    assert numbers
    (unknown,) = [line for line in report if "Horizn" in line]
    assert "unknown key" in unknown and "did you mean Horizon" in unknown
    assert re.match(r"input\.yaml:\d+: Material\.Zone_1\.Horizn", unknown)
    line = int(unknown.split(":")[1])
    assert "Horizn" in path.read_text().splitlines()[line - 1]
    assert any("Flags" in line and "unknown key" in line for line in report)
    assert any("Kn_Facto" in line and "unknown key" in line for line in report)


def test_every_key_of_a_deck_is_used_or_in_the_report(tmp_path):
    """Nothing is dropped silently: change any value to nonsense, or find it in the report."""
    path = write(tmp_path, COLLISION)
    quiet = deck.load(path).report
    dropped = []
    for key in ("Neighbor.Search_Factor", "Output.Path", "Container.Geometry", "Output.Tags"):
        words = key.split(".")
        if not any(words[0] in line for line in quiet):
            dropped.append(key)
    assert not dropped
    assert any("Fixity" in line for line in quiet)


def test_repeated_keys_are_named(tmp_path):
    path = write(tmp_path, COLLISION)
    path.write_text(path.read_text().replace("Final_Time:", "Final_Time: 1.0e-5\n  Final_Time:"))
    assert any("Model.Final_Time: given twice" in line for line in deck.load(path).report)


def test_same_particles_in_the_old_syntax(tmp_path):
    new = deck.load(write(tmp_path, COLLISION)).scene
    old = changed(
        COLLISION,
        {
            "Particle.Zone_3": None,
            "Wall.Zone_3": {"Type": "flexible", "All_Dofs_Constrained": True, "Mesh": True},
            "Zone.Zone_3.Type": "rectangle",
            "Zone.Zone_3.Parameters": [-2.3e-3, -3e-4, 0, 2.3e-3, 6e-3, 0],
            "Displacement_BC.Set_1.Particle_List": None,
            "Displacement_BC.Set_1.Wall_List": [0],
            "HPX.Partitions": 1,
        },
    )
    loaded = deck.load(write(tmp_path, old))
    assert loaded.scene.data().splitlines()[1:] == new.data().splitlines()[1:]
    assert [wall.name for wall in loaded.scene.walls] == [wall.name for wall in new.walls]
    assert not any("unknown" in line for line in loaded.report)


@pytest.mark.parametrize("as_published", [False, True])
def test_a_deck_runs(tmp_path, lmp, as_published):
    made = deck.load(write(tmp_path, COLLISION), as_published).scene
    folder = tmp_path / "run"
    run.run(made.write(folder), lmp=lmp, quiet=True)
    table = results.thermo(folder / run.LOG)
    assert table["Time"][-1] == pytest.approx(1e-5, rel=0.1)
    dump = results.Dump(folder / scene.DUMP)
    upper = dump[-1]["mol"] == 2
    time = np.interp(dump.steps[-1], table["Step"], table["Time"])
    # nothing touches yet: free flight
    fall = 0.5 * time + 5.0 * time**2 + (5.0 * time * 1e-7 if as_published else 0.0)
    volumes = made.grains[1].cloud.volumes
    moved = (dump[0]["y"] - dump[-1]["y"])[upper]
    # six digits of positions of 4 mm
    assert volumes @ moved / volumes.sum() == pytest.approx(fall, abs=5e-9)


# ---- round trips ---------------------------------------------------------------------------------

NUMBER = st.floats(0.1, 10.0)


@pytest.mark.seconds
@settings(
    max_examples=25,
    deadline=None,
    phases=[Phase.explicit, Phase.generate],  # a failing case is small enough to read
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    rows=st.lists(
        st.tuples(st.integers(0, 1), NUMBER, NUMBER, st.floats(0.0, 6.3)), min_size=1, max_size=6
    ),
    bulk=NUMBER,
    ratio=st.floats(0.4, 1.2),
    toughness=NUMBER,
    stiffness=NUMBER,
    gravity=st.sampled_from([-20.0, -0.3, 0.0, 9.81]),
    horizon=st.floats(2.0, 4.0),
    published=st.booleans(),
)
def test_what_a_deck_says_is_what_the_script_says(
    tmp_path, rows, bulk, ratio, toughness, stiffness, gravity, horizon, published
):
    """From numbers to YAML, to a scene, to the files of LAMMPS, and back to the numbers."""
    table = "i, x, y, z, r, o\n"
    for n, (zone, factor, _, angle) in enumerate(rows):
        table += f"{zone}, {6e-3 * n!r}, {3e-3!r}, 0.0, {1e-3 * (1 + 0.02 * factor)!r}, {angle!r}\n"
    made = changed(
        COLLISION,
        {
            "Material.Zone_1.K": 1e7 * bulk,
            "Material.Zone_1.G": 1e7 * bulk * ratio,
            "Material.Zone_1.Gc": toughness,
            "Material.Zone_1.Horizon_Mesh_Ratio": horizon,
            "Material.Zone_1.Horizon": None,
            "Contact.Zone_11.Kn": 1e24 * stiffness,
            "Force_BC.Gravity": [0.0, gravity, 0.0],
            "IC": None,
            "Zone.Zones": 2,
            "Displacement_BC": None,
        },
    )
    loaded = deck.load(write(tmp_path, made, table), published)
    text = loaded.scene.script()
    order = sorted(range(len(rows)), key=lambda n: rows[n][0])  # zone by zone
    body = loaded.scene.data().split("Atoms # peridem\n\n")[1].split("\n\n")[0]
    atoms = np.array([[float(w) for w in line.split()] for line in body.splitlines()])
    mesh = cloud.read(tmp_path / "disc.msh")
    for grain, n in enumerate(order, 1):
        scale, mine = 1 + 0.02 * rows[n][1], atoms[:, 1] == grain
        assert atoms[mine, 3].sum() == pytest.approx(scale**2 * mesh.volumes.sum(), rel=1e-12)
        centre = atoms[mine, 3] @ atoms[mine, 5:7] / atoms[mine, 3].sum()
        c, s = math.cos(rows[n][3]), math.sin(rows[n][3])
        middle = scale * np.array([[c, -s], [s, c]]) @ mesh.centroid
        assert centre == pytest.approx(np.array([6e-3 * n, 3e-3]) + middle, rel=1e-12, abs=1e-15)
    first = [words for words in script_lines(text, "pair_coeff") if "peridem/lps" in words]
    said = keywords(first[0])
    if rows[order[0]][0] == 0:
        assert float(said["bulk"]) == pytest.approx(1e7 * bulk, rel=1e-11)
        nu = (3 - 2 * ratio) / (2 * (3 + ratio))
        assert float(said["poisson"]) == pytest.approx(nu, rel=1e-10, abs=1e-11)
        assert ("s0" if published else "gc") in said
    if gravity:
        (weight,) = script_lines(text, "fix", "weight")
        assert float(weight[2]) == pytest.approx(abs(gravity), rel=1e-7)
    touching = [words for words in script_lines(text, "pair_coeff") if "peridem/contact" in words]
    if published and rows[order[0]][0] == 0:
        assert float(keywords(touching[0])["stiffness"]) == pytest.approx(1e24 * stiffness)
    assert all(("form" in words) != published for words in touching)


def test_data_file_has_every_digit(tmp_path):
    made = deck.load(write(tmp_path, COLLISION)).scene
    body = made.data().split("Atoms # peridem\n\n")[1].split("\n\n")[0]
    atoms = np.array([[float(word) for word in line.split()] for line in body.splitlines()])
    assert (atoms[:, 5:7] == made.reference).all()
    assert (atoms[:, 3] == np.concatenate([g.cloud.volumes for g in made.grains])).all()


# ---- materials -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("moduli", "bulk", "poisson"),
    [
        ({"K": 3e7, "G": 1.2e7}, 3e7, (9 - 2.4) / (2 * (9 + 1.2))),
        ({"E": 3e7, "Poisson_Ratio": 0.2}, 3e7 / 1.8, 0.2),
        ({"E": 3e7, "G": 1.2e7}, 3e7 / (3 * (1 - 0.5)), 0.25),
        ({"E": 3e7, "K": 2e7}, 2e7, (6 - 3) / 12),
        ({"G": 1.2e7, "Poisson_Ratio": 0.25}, 2e7, 0.25),
    ],
)
def test_any_two_moduli(tmp_path, moduli, bulk, poisson):
    changes = {f"Material__Zone_1__{key}": moduli.get(key) for key in ("E", "K", "G")}
    changes["Material__Zone_1__Poisson_Ratio"] = moduli.get("Poisson_Ratio")
    solid = deck.load(write(tmp_path, SQUARE, **changes)).scene.materials[0]
    assert solid.bulk == pytest.approx(bulk) and solid.poisson == pytest.approx(poisson)


def test_stress_intensity_is_energy(tmp_path):
    changes = {"Material__Zone_1__Gc": None, "Material__Zone_1__KIc": 4e4}
    path = write(tmp_path, SQUARE, **changes)
    solid = deck.load(path).scene.materials[0]
    young = 9 * 2.16e7 * 1.296e7 / (3 * 2.16e7 + 1.296e7)
    # rounding of a formula of few terms
    assert solid.gc == pytest.approx(4e4**2 / young * (1 - 0.25**2), rel=1e-9)
    path = write(tmp_path, SQUARE, **changes, Material__Zone_1__Is_Plane_Strain=False)
    solid = deck.load(path).scene.materials[0]
    assert solid.plane == "stress"
    assert solid.gc == pytest.approx(4e4**2 / young, rel=1e-9)


@pytest.mark.parametrize(
    ("function", "name", "width"),
    [
        ({"Type": 0}, "constant", 0.2),
        ({"Type": 1}, "linear", 0.2),
        ({"Type": 2}, "gaussian", 0.2),
        ({"Type": 2, "Parameters": [3.0, 0.4]}, "gaussian", 0.4),
        (None, "constant", 0.2),
    ],
)
def test_influence_functions(tmp_path, function, name, width):
    path = write(tmp_path, SQUARE, Material__Zone_1__Influence_Function=function)
    solid = deck.load(path).scene.materials[0]
    assert (solid.influence, solid.width) == (name, width)


@pytest.mark.seconds
@pytest.mark.parametrize(
    ("kind", "potential"), [("PMBBond", "pmb"), ("PDElasticBond", "elastic"), ("RNPBond", "rnp")]
)
@pytest.mark.parametrize("as_published", [False, True])
def test_bond_materials_run(tmp_path, lmp, kind, potential, as_published):
    path = write(tmp_path, SQUARE, Material__Zone_1__Type=kind, Material__Zone_1__G=None)
    made = deck.load(path, as_published).scene
    solid = made.materials[0]
    assert isinstance(solid, BondMaterial) and solid.potential == potential
    run.run(made.write(tmp_path / "run"), lmp=lmp, quiet=True)


@pytest.mark.seconds
@pytest.mark.parametrize(
    ("first", "second"),
    [
        ({"Influence_Function": {"Type": 0}}, {}),
        ({"Influence_Function": {"Type": 2, "Parameters": [1.0, 0.3]}}, {"Bond_Potential": None}),
        ({"Type": "PMBBond", "G": None}, {"Type": "RNPBond", "G": None}),
        ({"Type": "PDElasticBond", "G": None}, {"Type": "PMBBond", "G": None}),
    ],
)
@pytest.mark.parametrize("as_published", [False, True])
def test_zones_of_unlike_laws_run(tmp_path, lmp, first, second, as_published):
    """LAMMPS must be told what bonds between them are, though no grain has any."""
    changes = {"Material__Zone_1": {**SOLID, **first}, "Material__Zone_2": {**SOLID, **second}}
    made = deck.load(write(tmp_path, COLLISION, **changes), as_published).scene
    run.run(made.write(tmp_path / "run"), lmp=lmp, quiet=True)
    assert len(results.Dump(tmp_path / "run" / scene.DUMP)) > 1


def test_all_zones_have_one_plane(tmp_path):
    """PeriDEM does not use it, so decks may say what cannot be."""
    stress = write(tmp_path, COLLISION, Material__Zone_2__Is_Plane_Strain=False)
    made = deck.load(stress).scene
    assert {m.plane for m in made.materials if isinstance(m, Material)} == {"stress"}
    both = write(
        tmp_path,
        COLLISION,
        Material__Zone_1__Is_Plane_Strain=True,
        Material__Zone_2__Is_Plane_Strain=False,
    )
    read = deck.load(both)
    assert {m.plane for m in read.scene.materials if isinstance(m, Material)} == {"strain"}
    words = "Zone_2.Is_Plane_Strain: not that of zone_1: all zones have one, plane strain"
    assert any(words in line for line in read.report)


def test_published_constants_of_bond_materials(tmp_path):
    """PeriDEM's formulas, with its linear influence 12 (1 - q) in 2D."""
    young, gc, size = 1.5 * 2.16e7, 50.0, 6e-4
    lame = 0.25 * young / (1.25 * 0.5)
    base = {"Material__Zone_1__G": None}

    def solid(kind):
        path = write(tmp_path, SQUARE, Material__Zone_1__Type=kind, **base)
        return deck.load(path, as_published=True).scene.materials[0]

    pmb, elastic, rnp = solid("PMBBond"), solid("PDElasticBond"), solid("RNPBond")
    assert pmb.c == pytest.approx(12 * 24 * young / (0.75 * math.pi * size**3))
    assert pmb.s0 == pytest.approx(math.sqrt(5 * math.pi * gc / (9 * young * size)))
    assert elastic.c == pytest.approx(12 * 24 * lame / (math.pi * size**3))
    moment = 12 * (1 / 3 - 1 / 4)
    depth = math.pi * gc / (4 * moment)
    assert rnp.beta == pytest.approx(4 * lame / (depth * moment))
    # the force there is 4 J s C beta exp(-beta R s^2)/(pi horizon^3); here w 2 C beta s exp(...)
    assert rnp.depth == pytest.approx(2 * 12 * depth / (math.pi * size**3))


# ---- geometries ----------------------------------------------------------------------------------


def block_of(tmp_path, data):
    path = tmp_path / "geometry.yaml"
    path.write_text(yaml.safe_dump(data))
    return read(path)


@pytest.mark.parametrize(
    ("kind", "values", "area"),
    [
        ("circle", [2.0], 4 * math.pi),
        ("circle", [2.0, 1.0, 1.0, 0.0], 4 * math.pi),
        ("ellipse", [2.0, 1.0], 2 * math.pi),
        ("ellipse", [2.0, 1.0, 0.5, 0.0, 0.0, 0.7], 2 * math.pi),
        ("rectangle", [2.0, 3.0], 6.0),
        ("rectangle", [2.0, 3.0, 0.5, 0.5, 0.0], 6.0),
        ("rectangle", [-1.0, -1.0, 0.0, 1.0, 2.0, 0.0], 6.0),
        ("square", [2.0], 4.0),
        ("triangle", [2.0], 3 * math.sqrt(3)),
        ("triangle", [2.0, 0, 0, 0, 0, 1, 0], 3 * math.sqrt(3)),
        ("hexagon", [2.0], 6 * math.sqrt(3)),
        ("hexagon", [2.0, 0, 0, 0, 1, 0, 0], 6 * math.sqrt(3)),
        ("drum2d", [2.0, 0.5], 2 * math.sqrt(3) * (1.0 + 0.5)),
        ("rectangle_minus_rectangle", [-2, -2, 0, 2, 2, 0, -1, -1, 0, 1, 1, 0], 12.0),
        ("angled_rectangle", [0, 0, 0, 2, 1, 0], 2.0),
    ],
)
def test_shapes_hold_the_points_they_should(tmp_path, kind, values, area):
    made = shape(block_of(tmp_path, {"Type": kind, "Parameters": values}))
    low, high = made.bounds
    n = 800
    x = np.linspace(low[0] - 0.01, high[0] + 0.01, n)
    y = np.linspace(low[1] - 0.01, high[1] + 0.01, n)
    points = np.column_stack([g.ravel() for g in np.meshgrid(x, y)])
    cell = (x[1] - x[0]) * (y[1] - y[0])
    # a grid of n x n misses at most a row of cells along the outline
    assert made.contains(points).sum() * cell == pytest.approx(area, rel=8 / n)


@pytest.mark.parametrize(
    ("kind", "values", "volume"),
    [
        ("sphere", [2.0], 32 / 3 * math.pi),
        ("cube", [2.0, 1.0, 1.0, 1.0], 8.0),
        ("cuboid", [1.0, 2.0, 3.0], 6.0),
        ("cuboid_minus_cuboid", [-2, -2, -2, 2, 2, 2, -1, -1, -1, 1, 1, 1], 56.0),
        ("cylinder", [1.0, 0, 0, 0, 0, 0, 3.0], 3 * math.pi),
        ("cylinder", [1.0, 3.0, 0, 0, 0, 0, 0, 2.0], 3 * math.pi),
    ],
)
def test_solids_hold_the_points_they_should(tmp_path, kind, values, volume):
    made = shape(block_of(tmp_path, {"Type": kind, "Parameters": values}))
    low, high = made.bounds
    axes = [np.linspace(a - 0.01, b + 0.01, 90) for a, b in zip(low, high, strict=True)]
    points = np.column_stack([g.ravel() for g in np.meshgrid(*axes)])
    cell = math.prod(axis[1] - axis[0] for axis in axes)
    # of 90 points across, half a layer at the surface is 3 to 7 % of the volume
    assert made.contains(points).sum() * cell == pytest.approx(volume, rel=0.08)
    flat = np.pad(points[:, :2], ((0, 0), (0, 1)))  # in 2D they are what z = 0 cuts of them
    assert (made.contains(points[:, :2]) == made.contains(flat)).all()


def test_complex_shapes_add_and_take_away(tmp_path):
    data = {
        "Type": "complex",
        "Vec_Type": ["circle", "circle", "rectangle"],
        "Vec_Flag": ["plus", "minus", "plus"],
        "Parameters": [1.1, 0, 0, 0, 1.0, 0, 0, 0, 0.5, -0.1, 0, 1.0, 0.1, 0],
    }
    made = shape(block_of(tmp_path, data))
    points = [(1.05, 0), (0.4, 0), (0.7, 0.05), (1.2, 0), (0.7, 0.2)]
    assert made.contains(points).tolist() == [True, False, True, False, False]


# ---- walls ---------------------------------------------------------------------------------------


def drum_deck(**changes):
    return changed(
        COLLISION,
        {
            "Particle.Zone_3.Type": "complex",
            "Particle.Zone_3.Vec_Type": ["circle", "circle", "rectangle"],
            "Particle.Zone_3.Vec_Flag": ["plus", "minus", "plus"],
            "Particle.Zone_3.Parameters": [
                *(6e-3, 0, 3e-3, 0, 5.6e-3, 0, 3e-3, 0),
                *(4.5e-3, 2.9e-3, 0, 5.6e-3, 3.1e-3, 0),
            ],
            "Displacement_BC.Set_1.Zero_Displacement": False,
            "Displacement_BC.Set_1.Time_Function": {
                "Type": "rotation",
                "Parameters": [-100.0, 0.0, 3e-3, 0.0],
            },
            "Displacement_BC.Set_1.Spatial_Function": {"Type": "rotation"},
            **changes,
        },
    )


def test_a_rotating_drum_is_a_region(tmp_path):
    made = deck.load(write(tmp_path, drum_deck())).scene
    (wall,) = made.walls
    assert isinstance(wall, RegionWall) and wall.rotation.rate == -100.0
    lines = wall.commands("")
    assert lines[0] == "variable drum_angle equal -100*time"
    assert any(line.startswith("region drum_shape_1 cylinder z 0 0.003 0.0056") for line in lines)
    assert any("block" in line and "side out" in line for line in lines)
    assert made.adaptive


def test_as_nodes_it_turns_with_fix_move(tmp_path, lmp):
    made = deck.load(write(tmp_path, drum_deck()), as_published=True).scene
    folder = tmp_path / "run"
    run.run(made.write(folder), lmp=lmp, quiet=True)
    dump = results.Dump(folder / scene.DUMP)
    mine = dump[-1]["mol"] == 3
    angle = -100.0 * dump.steps[-1] * 1e-7
    x = dump[0].position[mine] - (0.0, 3e-3)
    c, s = math.cos(angle), math.sin(angle)
    expected = x @ np.array([[c, s], [-s, c]]) + (0.0, 3e-3)
    assert dump[-1].position[mine] == pytest.approx(expected, abs=1e-8)  # six digits of 6 mm


def test_a_wall_that_grains_surround_is_a_block(tmp_path):
    """A peg between two grains cannot be planes."""
    grid = [(x, y) for x in (-3e-4, 0.0, 3e-4) for y in (-3e-4, 0.0, 3e-4)]
    cells = [(0, 3, 4), (0, 4, 1), (1, 4, 5), (1, 5, 2), (3, 6, 7), (3, 7, 4), (4, 7, 8), (4, 8, 5)]
    peg = cloud.from_cells(np.add(grid, (0.0, 2.5e-3)), cells, "peg")
    path = write(
        tmp_path,
        COLLISION,
        "i, x, y, z, r, o\n0, 0, 0.001, 0, 0.001, 0.3\n1, 0, 0.004, 0, 0.001, 0\n",
        Particle__Zone_3__Type="rectangle",
        Particle__Zone_3__Parameters=[-3e-4, 2.2e-3, 0, 3e-4, 2.8e-3, 0],
    )
    peg.write(tmp_path / "box.msh")
    (wall,) = deck.load(path).scene.walls
    assert isinstance(wall, RegionWall) and not wall.region.inside


def test_a_moving_lid_keeps_its_speed(tmp_path):
    path = write(
        tmp_path,
        COLLISION,
        Displacement_BC__Set_1__Zero_Displacement=None,
        Displacement_BC__Set_1__Time_Function={"Type": "linear", "Parameters": [-0.06]},
        Displacement_BC__Set_1__Direction=[2],
    )
    for wall in deck.load(path).scene.walls:
        assert isinstance(wall, Wall) and wall.velocity == (0.0, -0.06)
    text = deck.load(path, as_published=True).scene.script()
    assert "velocity wall_2 set 0 -0.06 0" in text and "fix wall_2 wall_2 setforce 0 0 0" in text


# ---- loads ---------------------------------------------------------------------------------------


def evaluated(formula, x=0.0, y=0.0, now=0.0):
    """The value of a LAMMPS formula."""
    text = formula.replace("{X}", f"({x!r})").replace("{Y}", f"({y!r})")
    text = re.sub(r"\btime\b", f"({now!r})", text)
    names = {"sin": math.sin, "cos": math.cos, "floor": math.floor}
    return float(eval(text, {"__builtins__": {}}, names))


def load_set(tmp_path, time, values, space="constant", space_values=(), directions=(0, 1)):
    place = Block(tmp_path / "d.yaml", ("Displacement_BC", "Set_1"), None, 1)
    return LoadSet(
        (0,), (), None, directions, time, tuple(values), space, tuple(space_values), False, place
    )


def hat(x, low, high):
    middle = 0.5 * (low + high)
    if not low <= x <= high:
        return 0.0
    return (x - low) / (middle - low) if x < middle else (high - x) / (middle - low)


BOUNDS = np.array([-1.0, 0.0, 0.0]), np.array([3.0, 2.0, 0.0])


@pytest.mark.parametrize(
    ("time", "values", "moved", "speed"),
    [
        ("constant", [0.3], lambda a, t: a, lambda a, t: 0.0),
        ("linear", [0.3], lambda a, t: a * t, lambda a, t: a),
        ("quadratic", [0.3, 0.7], lambda a, t: a * t + 0.7 * t * t, lambda a, t: a + 1.4 * t),
        (
            "sin",
            [0.3, 0.7],
            lambda a, t: a * math.sin(math.pi * 0.7 * t),
            lambda a, t: a * math.pi * 0.7 * math.cos(math.pi * 0.7 * t),
        ),
    ],
)
@pytest.mark.parametrize(
    ("space", "space_values", "amplitude"),
    [
        ("constant", [], lambda x, y: 0.3),
        ("hat_x", [0.9], lambda x, y: 0.9 * hat(x, -1.0, 3.0)),
        ("hat_y", [0.9], lambda x, y: 0.9 * hat(y, 0.0, 2.0)),
        ("sin_x", [0.9], lambda x, y: 0.3 * math.sin(math.pi * 0.9 * x)),
        ("sin_y", [0.9], lambda x, y: 0.3 * math.sin(math.pi * 0.9 * y)),
        ("linear_x", [0.9], lambda x, y: 0.27 * x),
        ("linear_y", [0.9], lambda x, y: 0.27 * y),
    ],
)
def test_displacements_follow_their_functions(
    tmp_path, time, values, moved, speed, space, space_values, amplitude
):
    load = load_set(tmp_path, time, values, space, space_values, (1,))
    known = deck_loads.formulas(load, BOUNDS, False, Report(tmp_path))
    assert list(known) == [1]
    for x, y, now in [(0.3, 0.4, 0.2), (1.7, 1.9, 0.9), (-0.8, 0.1, 1.3), (5.0, 5.0, 0.1)]:
        a = amplitude(x, y)
        displacement, rate = (evaluated(text, x, y, now) for text in known[1])
        # rounding of few terms; zero where sines are
        assert displacement == pytest.approx(moved(a, now), rel=1e-12, abs=1e-15)
        assert rate == pytest.approx(speed(a, now), rel=1e-12, abs=1e-15)


def test_a_rotation_of_one_direction_only(tmp_path):
    load = load_set(tmp_path, "rotation", [2.0, 0.5, 0.25, 0.0], "rotation", (), (0,))
    known = deck_loads.formulas(load, BOUNDS, False, Report(tmp_path))
    x, y, t = 1.5, 0.75, 0.3
    c, s = math.cos(0.6), math.sin(0.6)
    displacement, rate = (evaluated(text, x, y, t) for text in known[0])
    # rounding of few terms
    assert displacement == pytest.approx(1.0 * c - 0.5 * s - 1.0, rel=1e-12)
    assert rate == pytest.approx(2.0 * (-1.0 * s - 0.5 * c), rel=1e-12)


def linear_step(t, a, b):
    period = math.floor(t / (a + b))
    return t - period * b if t < period * (a + b) + a else (period + 1) * a


@pytest.mark.parametrize(
    ("time", "values", "factor"),
    [
        ("constant", [2.0], lambda t: 2.0),
        ("linear", [2.0], lambda t: 2.0 * t),
        ("linear_step", [2.0, 0.3, 0.2], lambda t: 2.0 * linear_step(t, 0.3, 0.2)),
        (
            "linear_slow_fast",
            [2.0, 0.5, 3.0, 7.0],
            lambda t: 2.0 * (7.0 * t if t > 0.5 else 3.0 * t),
        ),
        ("sin", [2.0, 0.7], lambda t: 2.0 * math.sin(math.pi * 0.7 * t)),
    ],
)
def test_forces_follow_their_functions(tmp_path, time, values, factor):
    for published, doubled in ((False, 1.0), (True, 0.9)):
        for space, amplitude in [
            ("constant", lambda x: 1.0),
            ("hat_x", lambda x: 0.9 * hat(x, -1.0, 3.0)),
            ("sin_x", lambda x, d=doubled: d * math.sin(math.pi * 0.9 * x)),
            ("linear_x", lambda x, d=doubled: d * 0.9 * x),
        ]:
            load = load_set(tmp_path, time, values, space, [0.9], (0,))
            made = deck_loads.force(load, "push", None, BOUNDS, 2, published, Report(tmp_path))
            assert made.density[1] == 0.0
            for x, now in [(0.3, 0.2), (1.7, 0.35), (-0.8, 0.61), (2.9, 1.3)]:
                # rounding of few terms; zero where sines are
                assert evaluated(made.density[0], x, 0.0, now) == pytest.approx(
                    amplitude(x) * factor(now), rel=1e-12, abs=1e-15
                )


def test_lammps_follows_the_formulas(tmp_path, lmp):
    """The upper side of a square driven as a sine of time and a hat of place; a force on its left
    side, whose acceleration is that of the formula."""
    top = {"Geometry": {"Type": "rectangle", "Parameters": [0, 0.99e-3, 0, 1e-3, 1e-3, 0]}}
    left = {"Geometry": {"Type": "rectangle", "Parameters": [0, 1.5e-4, 0, 1e-6, 8.5e-4, 0]}}
    path = write(
        tmp_path,
        SQUARE,
        Displacement_BC__Sets=2,
        Displacement_BC__Set_2={
            "Region": top,
            "Direction": [2],
            "Time_Function": {"Type": "sin", "Parameters": [1.0, 2e4]},
            "Spatial_Function": {"Type": "hat_x", "Parameters": [2e-6]},
        },
        Force_BC={
            "Sets": 1,
            "Set_1": {
                "Region": left,
                "Direction": [1],
                "Time_Function": {"Type": "constant", "Parameters": [1e9]},
            },
        },
        Model__Final_Time=2e-7,
        Model__Time_Steps=20,
        Output__Output_Interval=20,
        Output__Tags=["Force"],
    )
    made = deck.load(path, as_published=True).scene
    script = made.write(tmp_path / "run")
    text = re.sub(r"sort id.*", "sort id format float %.15g", script.read_text())
    script.write_text(text)
    run.run(script, lmp=lmp, quiet=True)
    dump = results.Dump(tmp_path / "run" / scene.DUMP)
    x0, moved = made.reference, dump[-1].position - made.reference
    upper = x0[:, 1] > 0.99e-3
    assert upper.sum() == 6
    expected = [2e-6 * hat(x, 0.0, 1e-3) * math.sin(math.pi * 2e4 * 2e-7) for x in x0[upper, 0]]
    assert moved[upper, 1] == pytest.approx(expected, rel=1e-9, abs=1e-18)
    assert moved[x0[:, 1] < 1e-5] == pytest.approx(0.0, abs=1e-17)  # 15 digits of 1e-3
    # the bonds are unstretched at first: the force is that of the formula alone
    edge = (x0[:, 0] < 1e-6) & (x0[:, 1] > 1.5e-4) & (x0[:, 1] < 8.5e-4)
    volumes = made.grains[0].cloud.volumes
    assert edge.sum() == 4
    assert dump[0]["fx"][edge] == pytest.approx(1e9 * volumes[edge], rel=1e-12)


# ---- 3D, restarts --------------------------------------------------------------------------------


@pytest.mark.seconds
def test_a_cuboid_in_3d_runs(tmp_path, lmp):
    path = write(
        tmp_path,
        SQUARE,
        Model__Dimension=3,
        Particle__Zone_1={"Type": "cuboid", "Parameters": [0, 0, 0, 1e-3, 8e-4, 6e-4]},
        Displacement_BC__Set_1__Region={
            "Geometry": {"Type": "cuboid", "Parameters": [0, 0, 0, 1e-3, 8e-4, 1e-5]}
        },
        Displacement_BC__Set_1__Direction=[1, 2, 3],
        Force_BC__Gravity=[0, 0, -10.0],
    )
    for as_published in (False, True):
        made = deck.load(path, as_published).scene
        grain = made.grains[0]
        assert made.dimension == 3 and grain.cloud.volumes.sum() == pytest.approx(4.8e-10)
        folder = tmp_path / f"run{as_published}"
        run.run(made.write(folder), lmp=lmp, quiet=True)
        dump = results.Dump(folder / scene.DUMP)
        held = made.reference[:, 2] == 0.0
        assert (dump[-1].position[held] == dump[0].position[held]).all()


def test_a_restart_goes_on_from_the_state_of_a_file(tmp_path):
    start = deck.load(write(tmp_path, COLLISION), as_published=True).scene
    random = np.random.default_rng(3)
    u = 1e-6 * random.standard_normal((len(start.reference), 3))
    v = random.standard_normal((len(start.reference), 3))
    u[:, 2] = v[:, 2] = 0.0
    points = np.pad(start.reference, ((0, 0), (0, 1))) + u
    fields = {"Displacement": u, "Velocity": v}
    meshio.Mesh(points, [("vertex", np.arange(len(u))[:, None])], point_data=fields).write(
        tmp_path / "output_4.vtu"
    )
    back = {"File": "output_4", "Step": 40, "Change_Reference_Free_Dofs": True}
    read = deck.load(write(tmp_path, COLLISION, Restart=back), as_published=True)
    assert any("Change_Reference_Free_Dofs: not used, as in PeriDEM" in w for w in read.report)
    made = read.scene
    assert made.start_time == pytest.approx(4e-6) and made.duration == pytest.approx(6e-6)
    text = made.data()
    body = text.split("Atoms # peridem\n\n")[1].split("\n\n")[0]
    atoms = np.array([[float(word) for word in line.split()] for line in body.splitlines()])
    assert atoms[:, 8:10] == pytest.approx(made.reference, rel=1e-15)
    assert atoms[:, 5:7] - atoms[:, 8:10] == pytest.approx(u[:, :2], abs=1e-18)
    speeds = text.split("Velocities\n\n")[1].split()
    assert float(speeds[1]) == v[0, 0]
    assert "reset_timestep  0 time 4e-06" in made.script()
    with pytest.raises(DeckError, match="output_5"):
        deck.load(write(tmp_path, COLLISION, Restart={"File": "output_5", "Step": 40}))
    # PeriDEM's files have nodes without cells, unless it is asked for them
    bare = pyvista.UnstructuredGrid(np.empty(0, dtype=int), np.empty(0, dtype=np.uint8), points)
    for name, values in fields.items():
        bare.point_data[name] = values
    bare.save(tmp_path / "output_6.vtu")
    again = write(tmp_path, COLLISION, Restart={"File": "output_6", "Step": 40})
    assert deck.load(again, as_published=True).scene.data() == text


def test_what_is_no_restart_file_is_named(tmp_path):
    (tmp_path / "output_7.vtu").write_text("soon")
    path = write(tmp_path, COLLISION, Restart={"File": "output_7", "Step": 40})
    with pytest.raises(DeckError, match=r"input.yaml:\d+: Restart.File: .*output_7.vtu cannot be"):
        deck.load(path)
    (tmp_path / "output_7.vtu").write_text("")
    with pytest.raises(DeckError, match=r"output_7.vtu cannot be read as a VTU file$"):
        deck.load(path)


def test_a_deck_of_one_particle_needs_no_zones(tmp_path):
    """The oldest decks have mesh and material straight under Mesh and Material."""
    deck.load(write(tmp_path, COLLISION))  # its meshes
    changes = {"Mesh": {"File": "disc.msh"}, "Material": SOLID, "Particle": None}
    region = {"Geometry": {"Type": "rectangle", "Parameters": [-1e-3, -1e-3, 0, 1e-3, 0, 0]}}
    path = write(tmp_path, SQUARE, **changes, Displacement_BC__Set_1__Region=region)
    read = deck.load(path)
    assert len(read.scene.grains) == 1 and read.scene.materials[0].gc == SOLID["Gc"]
    assert not any("unknown key" in line for line in read.report)
    with pytest.raises(DeckError, match="Material: Zone_1 is missing"):
        deck.load(write(tmp_path, SQUARE, **changes | {"Material": {"Tipe": "PDState"}}))


# ---- errors --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("Model", None, "Model is missing"),
        ("Model.Dimension", 1, "2 or 3 needed, not 1"),
        ("Model.Final_Time", -1.0, "Model.Final_Time: must be above 0, not -1"),
        ("Model.Final_Time", "soon", "a number needed, not 'soon'"),
        ("Model.Time_Steps", 0, "Model.Time_Steps: at least 1"),
        ("Model.Time_Steps", 2.5, "a whole number"),
        ("Zone.Zones", 4, "Zone_4 is missing"),
        ("Particle.Zone_1.Type", "circel", "did you mean circle"),
        ("Particle.Zone_1.Parameters", [1e-3, 0], "circle has 1 or 4 of them, not 2"),
        ("Particle.Zone_1.Parameters", [0.0], "its size must be above 0"),
        ("Mesh.Zone_1.File", "none.msh", "no file none.msh"),
        ("Mesh.Zone_2", None, "Zone_2 is missing"),
        ("Particle_Generation.From_File", "no.csv", "no file no.csv"),
        ("Particle_Generation.File_Data_Type", "loc", "must be one of loc_rad"),
        ("Material.Zone_1.Type", "PDSTATE", "must be one of PDState"),
        ("Material.Zone_1.K", None, "two of E, K, G, Poisson_Ratio"),
        ("Material.Zone_1", {**SOLID, "G": 7e6, "K": None, "E": 2.2e7}, "ratio would be 0.5714"),
        ("Material.Zone_1.Gc", None, "Gc is missing"),
        ("Material.Zone_1.Density", 0, "must be above 0, not 0"),
        ("Material.Zone_1.Horizon", None, "Horizon is missing"),
        ("Material.Zone_3.Copy_Material_Data", 3, "a zone before 3"),
        ("Material.Zone_1.Influence_Function", {"Type": 7}, "0 constant, 1 linear or 2 gaussian"),
        ("Contact.Zone_13.Copy_Contact_Data", [2, 3], "no zone pair [2, 3] before it"),
        ("Contact.Zone_12.Epsilon", 1.5, r"must lie in (0, 1], not 1.5"),
        ("Contact.Zone_12.Friction_Coeff", None, "Friction_Coeff is missing"),
        ("Displacement_BC.Set_1.Particle_List", [7], "particle 7 of 3"),
        ("Displacement_BC.Set_1.Direction", [4], "directions 1 or 2 needed, not 4"),
        ("Displacement_BC.Set_1.Direction", [3], "directions 1 or 2 needed, not 3"),
        ("Displacement_BC.Sets", 2, "Set_2 is missing: Sets is 2"),
        ("Restart", {"File": "no", "Step": 1}, "--after FOLDER goes on from a run of the first"),
        ("IC.Constant_Velocity.Particle_List", [9], "particle 9 of 3"),
        ("IC.Constant_Velocity.Velocity_Vector", [0, 1, 0, 1], "at most 3 numbers needed, not 4"),
        ("Material.Zone_1.Horizon", 1e-5, "have no other within the horizon"),
    ],
)
def test_bad_decks_are_refused_in_one_line(tmp_path, key, value, words):
    path = write(tmp_path, COLLISION, **{key.replace(".", "__"): value})
    with pytest.raises(DeckError) as caught:
        deck.load(path)
    message = str(caught.value)
    assert words in message and "\n" not in message
    assert message.startswith(str(path))


def test_what_means_nothing_is_said(tmp_path):
    changes = {"Displacement_BC__Set_1__Direction": [1, 2, 3], "Output__Output_Interval": 0}
    text = "\n".join(deck.load(write(tmp_path, COLLISION, **changes)).report)
    assert "Displacement_BC.Set_1.Direction: 3 means nothing in 2D" in text
    assert "Output.Output_Interval: 0: the first and the last state are written" in text
    for key, value, words in (
        ("IC__Constant_Velocity__Particle_List", None, "Particle_List names no particle"),
        ("IC__Constant_Velocity__Particle_List", [2], "particle 2: its motion is prescribed"),
        ("IC__Constant_Velocity__Velocity_Vector", [0, 0, 1], "means nothing in 2D"),
        ("Force_BC__Gravity", [0, 0, -10], "Force_BC.Gravity: its third component means nothing"),
        ("Contact", None, "input.yaml: Contact: times the smallest node spacing"),
    ):
        text = "\n".join(deck.load(write(tmp_path, COLLISION, **{key: value})).report)
        assert words in text, key
    single = deck.load(write(tmp_path, SQUARE)).report
    assert not any("Contact" in line or "node spacing of the two" in line for line in single)
    with pytest.raises(DeckError, match=r"Set_2 is missing: Sets is 2$"):  # Set_1 is not meant
        deck.load(write(tmp_path, COLLISION, Displacement_BC__Sets=2))


def test_the_line_of_an_error_is_right(tmp_path):
    path = write(tmp_path, COLLISION, Material__Zone_2__Density=-3.0)
    with pytest.raises(DeckError) as caught:
        deck.load(path)
    number = int(re.search(r"input\.yaml:(\d+): Material\.Zone_2\.Density", str(caught.value))[1])
    assert path.read_text().splitlines()[number - 1].split() == ["Density:", "-3.0"]


def test_files_that_are_no_decks(tmp_path):
    path = tmp_path / "input.yaml"
    with pytest.raises(FileNotFoundError, match="no deck"):
        deck.load(path)
    for text, words in (
        ("Model: [1, 2\nZone: 3\n", "not YAML"),
        ("- 1\n- 2\n", "a deck has blocks"),
        ("Model: 3\n", "a block with keys"),
        ("", "a deck has blocks"),
    ):
        path.write_text(text)
        with pytest.raises(DeckError, match=words) as caught:
            deck.load(path)
        assert re.match(r".*input\.yaml:\d+: ", str(caught.value))


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("i, x, y, z, r\n0, 0, 0.002, 0, 0.001\n", "lacks the columns o"),
        ("i, x, y, z, r, o\n", "has no particles"),
        ("i, x, y, z, r, o\n0, 0, a, 0, 0.001, 0\n", "table.csv:2: 6 numbers needed"),
        ("i, x, y, z, r, o\n0, 0, 0.002, 0, -0.001, 0\n", "a radius above 0"),
        ("i, x, y, z, r, o\n0, 0, 0.002\n", "table.csv:2: 6 numbers needed"),
    ],
)
def test_bad_tables_are_refused(tmp_path, table, words):
    with pytest.raises(DeckError, match=words):
        deck.load(write(tmp_path, COLLISION, table))


def test_tables_may_have_more_columns_in_any_order(tmp_path):
    first = deck.load(write(tmp_path, COLLISION)).scene
    table = (
        "name, r, o, i, x, y, z\na, 0.001, 0.3, 0, 0, 0.0015, 0\nb, 0.0011, 1.2, 1, 0, 0.0038, 0\n"
    )
    second = deck.load(write(tmp_path, COLLISION, table)).scene
    assert (first.reference == second.reference).all()


def test_without_orientations_they_are_random_and_said_so(tmp_path):
    table = "i, x, y, z, r\n0, 0, 0.0015, 0, 0.001\n1, 0, 0.0038, 0, 0.0011\n"
    path = write(tmp_path, COLLISION, table, Particle_Generation__File_Data_Type="loc_rad")
    loaded, again = deck.load(path), deck.load(path)
    assert any("no orientations" in line for line in loaded.report)
    assert (loaded.scene.reference == again.scene.reference).all()


def test_uniform_meshes_have_the_volumes_of_their_cells(tmp_path):
    made = deck.load(write(tmp_path, SQUARE)).scene.grains[0].cloud
    assert len(made.nodes) == 36 and made.spacing == pytest.approx(2e-4)
    h = 2e-4
    edge = ((made.nodes == 0.0) | np.isclose(made.nodes, 1e-3)).sum(axis=1)
    # rounding of the coordinates of corners
    assert made.volumes == pytest.approx(h * h * 0.5**edge, rel=1e-12)


def test_shapes_of_particles_set_their_scale():
    for kind, values, size in [
        ("circle", (2.0,), 2.0),
        ("drum2d", (3.0, 1.0, 0, 0, 0), 3.0),
        ("ellipse", (2.0, 1.0), 2.0),
        ("rectangle", (-1.0, 0.0, 0.0, 3.0, 1.0, 0.0), 4.0),
        ("cuboid", (1.0, 2.0, 3.0), 1.0),
        ("cylinder", (1.0, 0, 0, 0, 0, 0, 1.0), None),
    ]:
        assert Shape(kind, values).size == size


# ---- decks that were published -------------------------------------------------------------------


@pytest.mark.seconds
@pytest.mark.parametrize("as_published", [False, True])
def test_502_grains_load_in_seconds(as_published, lmp, tmp_path):
    folder = decks_folder("n500_circ_hex")
    begin = time.monotonic()
    loaded = deck.load(folder / "input_current_syntax.yaml", as_published)
    script = loaded.scene.write(tmp_path)
    # 1.5 s on one core of 2024; a machine may be busy
    assert time.monotonic() - begin < 30.0
    made = loaded.scene
    assert len(made.reference) == 57394 + (3870 + 1730 if as_published else 0)
    if as_published:
        assert not made.walls and made.timestep == pytest.approx(1e-7)
    else:
        places = {wall.name: wall for wall in made.walls}
        assert set(places) == {"floor", "left", "right", "lid"}
        assert places["lid"].point[1] == pytest.approx(4.122e-2, rel=1e-9)
        assert places["lid"].velocity == (0.0, -0.06)
        assert places["left"].point[0] == pytest.approx(-2.2e-4, rel=1e-9)
    text = re.sub(r"(?m)^run +[1-9]\d*", "run 3", script.read_text())
    script.write_text(text)
    run.run(script, lmp=lmp, quiet=True)
    assert results.thermo(tmp_path / run.LOG)["Step"][-1] == 3


@pytest.mark.seconds
@pytest.mark.parametrize("as_published", [False, True])
@pytest.mark.parametrize(
    "name",
    [
        "single_particle_circle/inp/input_0.yaml",
        "twop_circ_nodamp_fine/inp/input_0.yaml",
        "compression_small_set/inp/input_0.yaml",
        "attrition_mix_particles_small_set/input_0.yaml",
        "n500_circ_hex/input_old_syntax.yaml",
    ],
)
def test_published_decks_load_without_editing(name, as_published, tmp_path):
    loaded = deck.load(decks_folder(name), as_published)
    assert not [line for line in loaded.report if "unknown" in line]
    loaded.scene.write(tmp_path)


def decks_folder(name):
    """A deck or folder of published ones; skips the test without them."""
    import os
    from pathlib import Path

    named = os.environ.get("PERIDEM_SHARED")
    beside = Path(__file__).resolve().parents[3] / "shared"
    path = (Path(named) if named else beside) / "reference" / name
    if not path.exists():
        pytest.skip(f"published decks are not there (looked for {path})")
    return path


assert decks  # the module of small decks
