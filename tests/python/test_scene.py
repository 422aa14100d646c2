"""Scenes: what the data file and the script say, and what is refused."""

import itertools
import re
import warnings

import meshio
import numpy as np
import pytest
import scenes
from peridem import packing, results, run, scene, shapes
from peridem.cloud import from_cells, mesh
from peridem.deck.bodies import lattice
from peridem.loads import Cut, Force, Motion, Nodes, ranges
from peridem.material import BondMaterial, Contact, Inert, Interface, Material
from peridem.regions import Block, Cylinder, Rotation, Sphere


def lines(text, command):
    """The arguments of all lines of a script that start with a command."""
    found = [line.split("#")[0].split() for line in text.splitlines()]
    return [words[1:] for words in found if words[:1] == [command]]


def atoms(text):
    """Rows of the Atoms section of a data file."""
    body = text.split("Atoms # peridem\n\n")[1]
    return np.array([[float(word) for word in line.split()] for line in body.splitlines()])


def test_data_file_holds_every_node_once():
    made = scenes.two_grains()
    rows = atoms(made.data())
    clouds = [grain.cloud for grain in made.grains]
    assert rows.shape == (sum(len(c.nodes) for c in clouds), 8)
    assert rows[:, 0].tolist() == list(range(1, len(rows) + 1))
    for number, cloud in enumerate(clouds, 1):
        mine = rows[rows[:, 1] == number]
        # written with twelve digits
        assert mine[:, 3] == pytest.approx(cloud.volumes, rel=1e-11)
        assert mine[:, 5:7] == pytest.approx(cloud.nodes, rel=1e-11, abs=1e-15)
    assert (rows[:, 4] == 1200.0).all() and (rows[:, 7] == 0.0).all()


def test_box_holds_grains_and_walls_to_the_end():
    made = scenes.two_grains(duration=5e-4)  # the lid sinks by 1 mm
    text = made.data()
    bounds = {k: re.search(rf"(\S+) (\S+) {k}lo {k}hi", text).groups() for k in "xyz"}
    x, y = (tuple(map(float, bounds[k])) for k in "xy")
    rows = atoms(text)
    assert x[0] < rows[:, 5].min() and rows[:, 5].max() < x[1]
    assert y[0] < 0.0 and y[1] > 3.9e-3
    assert bounds["z"] == ("-0.5", "0.5")


def test_script_says_what_the_scene_says():
    made = scenes.two_grains()
    text = made.script()
    (solid,) = [words for words in lines(text, "pair_coeff") if "peridem/lps" in words]
    assert solid[:3] == ["1", "1", "peridem/lps"]
    said = dict(zip(solid[3::2], solid[4::2], strict=True))
    assert float(said["bulk"]) == 21.6e6 and float(said["poisson"]) == 0.25
    assert float(said["horizon"]) == pytest.approx(6e-4) and float(said["gc"]) == 3.0
    (contact,) = [words for words in lines(text, "pair_coeff") if "peridem/contact" in words]
    said = {key: value for key, value in itertools.pairwise(contact)}
    # scripts hold eight digits
    assert float(said["radius"]) == pytest.approx(made.contact_radius, rel=1e-7)
    assert float(said["friction"]) == 0.3
    fixes = {words[0]: " ".join(words[1:]) for words in lines(text, "fix")}
    assert fixes["lid"] == "all peridem/wall plane 0 0.0039 0 0 -1 0 velocity 0 -2 0"
    assert fixes["weight"] == "all gravity 10 vector 0 -1 0"
    assert "velocity" not in fixes["floor"]
    ((skin, _),) = lines(text, "neighbor")
    # written with three digits
    assert float(skin) == pytest.approx(1.25 * made.contact_radius, rel=5e-3)


def in_two(gap):
    """A mesh of two discs whose nearest nodes are so far apart."""
    disc = mesh(shapes.circle(8e-4), scenes.SPACING)
    nodes = np.vstack([disc.nodes, disc.nodes + np.array([np.ptp(disc.nodes[:, 0]) + gap, 0.0])])
    cells = np.vstack([disc.cells, disc.cells + len(disc.nodes)])
    return from_cells(nodes, cells, "pair")


def test_grains_of_pieces_that_no_bond_joins_are_named(tmp_path):
    """Not pieces within the horizon of each other, which bonds join, nor bodies without bonds."""
    far, near = in_two(2.0 * scenes.SOLID.horizon), in_two(0.5 * scenes.SOLID.horizon)
    half = len(far.nodes) // 2
    assert far.pieces.tolist() == near.pieces.tolist() == [half, half]
    solids = [scene.Grain(one.placed((0.0, y)), scenes.SOLID) for one, y in ((near, 0), (far, 1))]
    wall = scene.Grain(far.placed((0.0, 2.0)), Inert(density=1200.0))
    again = scene.Grain(far.placed((0.0, 3.0), scale=0.9), scenes.SOLID)
    words = (
        rf"grain 2 \(and 1 more of its mesh\), 'pair', is of 2 pieces, of {half}, {half} nodes, "
        r"that no bond within the horizon 0.0006 joins: .* make a grain of each"
    )
    made = scenes.two_grains(grains=[*solids, wall, again], walls=())
    with pytest.warns(UserWarning, match=words) as caught:
        made.write(tmp_path)
    assert len(caught) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scenes.two_grains(grains=[solids[0], wall], walls=()).write(tmp_path)


def test_a_given_time_step_is_taken_and_divides_the_run():
    made = scenes.two_grains()
    text = made.script()
    assert lines(text, "timestep") == [["2.5e-07"]]
    assert not any("peridem/timestep" in words for words in lines(text, "fix"))
    (total,), every = lines(text, "run")[0], lines(text, "dump")[0][3]
    assert int(total) * 2.5e-7 == pytest.approx(made.duration)
    # whole numbers of steps between frames: one more or less
    assert int(total) // int(every) == pytest.approx(made.frames, abs=1)


def test_without_one_lammps_finds_it_and_the_time_ends_the_run():
    made = scenes.two_grains(timestep=None)
    text = made.script()
    assert not lines(text, "timestep")
    fixes = {words[0]: " ".join(words[1:]) for words in lines(text, "fix")}
    assert fixes["step"] == "all peridem/timestep safety 0.8"
    assert fixes["duration"].startswith("all halt 10 v_duration > 0")
    assert ["duration", "equal", "time>=0.0001"] in lines(text, "variable")
    (most,), last = lines(text, "run")
    assert last == ["0", "post", "no"]  # a frame of the last step, whatever it was
    assert int(most) * made._timestep()[0] > made.duration


def test_script_is_readable():
    text = scenes.two_grains().script()
    comments = [line for line in text.splitlines() if line.startswith("#")]
    assert text.startswith("# A hexagon on a disc\n")
    assert len(comments) >= 15
    for line in text.splitlines():
        assert len(line) <= 200 and line == line.rstrip()


def test_dumps_hold_fragments_where_bonds_may_break():
    breaks = scenes.two_grains()
    assert breaks.dumped()[-1] == "fragment"
    (words,) = [w for w in lines(breaks.script(), "dump_modify") if "sort" in w]
    # its column is the thirteenth: id mol type x y vx vy and six attributes; numbers, not %g
    assert words[words.index("13") - 1 : words.index("13") + 2] == ["format", "13", "%.0f"]
    for_ever = Material(21.6e6, 0.25, 1200.0, 6e-4)
    grains = [scene.Grain(grain.cloud, for_ever) for grain in breaks.grains]
    assert "fragment" not in scenes.two_grains(grains=grains).dumped()


def test_a_sieve_touches_some_grains_only(tmp_path):
    """The disc falls through the plane on which the hexagon lands."""
    made = scenes.two_grains()
    sieve = scene.Wall("sieve", (0.0, 1.9e-3), (0.0, 1.0), nodes=Nodes((2,)))
    side = Nodes((1,), Block((-1.0, -1.0), (1.0, 1.0)))
    floor = scene.RegionWall("rest", Block((-1.0, -3e-4), (1.0, 1.0)), nodes=side)
    falling = scenes.two_grains(
        grains=[scene.Grain(g.cloud, g.material, velocity=(0.0, -2.0)) for g in made.grains],
        walls=[sieve, floor],
        duration=5e-4,
        timestep=None,
    )
    text = falling.script()
    assert ["sieve_nodes", "molecule", "2"] in lines(text, "group")
    assert "fix sieve sieve_nodes peridem/wall plane" in text
    assert "fix rest rest_nodes peridem/wall region" in text
    run.run(falling.write(tmp_path), quiet=True)
    output = results.Output(tmp_path)
    heights = np.array([output.frame(i).position[:, 1] for i in range(len(output.dump))])
    disc = output.frame(0)["mol"] == 1
    assert heights[:, ~disc].min() > 1.9e-3  # a contact radius above the sieve
    assert -3e-4 < heights[:, disc].min() < 0.0  # through it from the start, down to the rest
    assert results.averages(tmp_path / scene.WALLS)["f_sieve[2]"].min() < 0.0
    with pytest.raises(ValueError, match="wall 'sieve' has no nodes"):
        none = scene.Wall("sieve", (0.0, 1.9e-3), (0.0, 1.0), nodes=Nodes((7,)))
        scenes.two_grains(walls=[none])


def test_two_materials_are_two_types_with_their_mean_in_contact():
    soft, hard = scenes.SOLID, Material(43.2e6, 0.25, 2000.0, 6e-4, name="hard")
    made = scenes.two_grains()
    grains = [scene.Grain(made.grains[0].cloud, soft), scene.Grain(made.grains[1].cloud, hard)]
    text = scenes.two_grains(grains=grains).script()
    said = {tuple(words[:3]): words for words in lines(text, "pair_coeff")}
    assert "unbreakable" in said["2", "2", "peridem/lps"]
    mixed = said["1", "2", "peridem/contact"]
    assert float(mixed[mixed.index("modulus") + 1]) == pytest.approx(28.8e6)
    rows = atoms(scenes.two_grains(grains=grains).data())
    assert set(zip(rows[:, 1], rows[:, 2], rows[:, 4], strict=True)) == {
        (1.0, 1.0, 1200.0),
        (2.0, 2.0, 2000.0),
    }


def test_contact_radius_left_out_follows_the_boundary_spacing():
    made = scenes.two_grains()
    spacing = []
    for grain in made.grains:
        surface = grain.cloud.nodes[grain.cloud.surface]
        gaps = np.sqrt(((surface[:, None] - surface[None]) ** 2).sum(axis=2))
        spacing.append(gaps[gaps > 0.0].min())
    # rounding of distances of nodes
    assert made.contact_radius == pytest.approx(0.95 * min(spacing), rel=1e-9)
    assert scenes.two_grains(contact=Contact(radius=1e-4)).contact_radius == 1e-4


def test_written_folder_is_complete(tmp_path):
    made = scenes.two_grains()
    script = made.write(tmp_path / "new" / "folder")
    assert script.read_text() == made.script()
    assert (script.parent / scene.DATA).read_text() == made.data()
    mesh = meshio.read(script.parent / scene.MESH)
    rows = atoms(made.data())
    # node i of the mesh is the atom with ID i + 1
    assert mesh.points[:, :2] == pytest.approx(rows[:, 5:7], rel=1e-11, abs=1e-15)
    assert (mesh.point_data["grain"] == rows[:, 1]).all()
    assert len(mesh.cells[0].data) == sum(len(grain.cloud.cells) for grain in made.grains)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"grains": []}, "no grains"),
        ({"duration": 0.0}, "duration"),
        ({"safety": float("nan")}, "safety"),
        ({"frames": 0}, "frames"),
        ({"gravity": (0.0, 0.0, -10.0)}, "gravity needs 2 components"),
        ({"walls": [scene.Wall("floor", (0, 2e-3), (0, 1))]}, "through the wall 'floor'"),
        ({"walls": [scene.Wall("a", (0, 0), (0, 1))] * 2}, "different names"),
    ],
)
def test_bad_scenes_are_refused(changes, words):
    with pytest.raises(ValueError, match=words):
        scenes.two_grains(**changes)


def test_bad_walls_and_mismatched_clouds_are_refused():
    for name, normal in (("a b", (0, 1)), ("motion", (0, 1)), ("lid", (0, 0))):
        with pytest.raises(ValueError, match=name):
            scene.Wall(name, (0.0, 0.0), normal)
    made = scenes.two_grains()
    placed = packing.table([shapes.circle(1.0)], [(0, 0, 0, 1, 0)], 0.1)
    with pytest.raises(ValueError, match="1 outlines with 2 clouds"):
        scene.grains_of(placed, [grain.cloud for grain in made.grains], scenes.SOLID)


def test_horizon_below_the_spacing_is_refused_before_anything_is_written(tmp_path):
    thin = Material(21.6e6, 0.25, 1200.0, 1e-4)
    made = scenes.two_grains()
    lonely = scenes.two_grains(grains=[scene.Grain(g.cloud, thin) for g in made.grains])
    with pytest.raises(ValueError, match="no other within the horizon"):
        lonely.write(tmp_path)
    assert not list(tmp_path.iterdir())


# ---- walls, loads, materials and output beyond the simplest --------------------------------------


def square(spacing=2e-4, sides=(1e-3, 1e-3), at=(0.0, 0.0)):
    """A rectangle of nodes on a square lattice."""
    counts = np.round(np.divide(sides, spacing)).astype(int)
    made = lattice(np.zeros(2), np.array(sides), counts, "square")
    return made.placed(at)


def run_steps(made, folder, lmp, steps=None):
    """Run a scene, all of it or so many steps; returns its dump with 15 digits."""
    script = made.write(folder)
    text = re.sub(r"sort id.*", "sort id format float %.15g", script.read_text())
    if steps:
        text = re.sub(r"(?m)^run +\d+", f"run {steps}", text)
    script.write_text(text)
    run.run(script, lmp=lmp, quiet=True)
    return results.Dump(folder / scene.DUMP)


BASE = {"title": "t", "contact": Contact(), "duration": 2e-6, "frames": 1, "records": 2}


def test_prescribed_motions_are_what_they_say(tmp_path, lmp):
    """Held, moving, turning and following nodes of four squares."""
    centres = [(0.0, 0.0), (2e-3, 0.0), (0.0, 2e-3), (2e-3, 2e-3)]
    grains = [scene.Grain(square(at=at), scenes.SOLID) for at in centres]
    low = Block((-1.0, -1.0), (1.0, 1e-9))
    motions = [
        Motion.held("foot", Nodes((1,), low), (True, False)),
        Motion.constant("slide", Nodes((2,)), (0.5, -0.25)),
        Motion.turning("wheel", Nodes((3,)), Rotation(2e4, (5e-4, 2.5e-3))),
        Motion.following(
            "wave", Nodes((4,)), ("1e-6*sin(1e6*time)", None), ("cos(1e6*time)", None)
        ),
    ]
    made = scene.Scene(grains=grains, motions=motions, timestep=2e-8, **BASE)
    dump = run_steps(made, tmp_path, lmp)
    first, last = dump[0].position, dump[-1].position
    moved, number = last - first, made.grain_of_node
    foot = (number == 1) & (first[:, 1] < 1e-9)
    assert foot.sum() == 6 and np.abs(moved[foot, 0]).max() == 0.0
    time = dump.steps[-1] * 2e-8
    # positions of 2e-3 have 15 digits, and are sums of a hundred steps
    assert moved[number == 2] == pytest.approx(
        np.tile((0.5 * time, -0.25 * time), (36, 1)), abs=1e-16
    )
    x = first[number == 3] - (5e-4, 2.5e-3)
    c, s = np.cos(2e4 * time), np.sin(2e4 * time)
    turned = x @ np.array([[c, s], [-s, c]]) + (5e-4, 2.5e-3)
    assert last[number == 3] == pytest.approx(turned, abs=1e-16)
    assert moved[number == 4, 0] == pytest.approx(1e-6 * np.sin(1e6 * time), abs=1e-17)
    assert not made.adaptive


def test_forces_push_by_volume_and_place(tmp_path, lmp):
    grains = [scene.Grain(square(), scenes.SOLID)]
    force = Force("push", Nodes((1,)), ("1e9*{X}", 2e5))
    made = scene.Scene(grains=grains, forces=[force], columns=("fx", "fy"), timestep=2e-8, **BASE)
    dump = run_steps(made, tmp_path, lmp, 1)
    volumes = grains[0].cloud.volumes
    # dumps and data files hold 13 digits and more
    assert dump[0]["fx"] == pytest.approx(1e9 * made.reference[:, 0] * volumes, rel=1e-12)
    assert dump[0]["fy"] == pytest.approx(2e5 * volumes, rel=1e-12)


def test_cuts_interfaces_and_protected_nodes(tmp_path, lmp):
    """A square of two materials, weakly joined, with a notch and a protected side."""
    cloud_ = square()
    right = cloud_.nodes[:, 0] > 5e-4
    weak = Material(2e7, 0.25, 1200.0, 6e-4, gc=3.0, name="weak")
    made = scene.Scene(
        grains=[scene.Grain(cloud_, scenes.SOLID, parts=((right, weak),))],
        interfaces=[Interface(("solid", "weak"), "s0 0.001 horizon 6e-4")],
        cuts=[Cut.segment((0.0, 5e-4), (3e-4, 5e-4)), Cut.within(Block((6e-4, 0.0), (7e-4, 1e-4)))],
        unbroken=Nodes((1,), Block((-1.0, 9e-4), (1.0, 1.0))),
        energies=True,
        attributes=("fragment", "sxx"),
        **BASE,
    )
    dump = run_steps(made, tmp_path, lmp)
    assert set(dump[0]["type"]) == {1.0, 2.0}
    assert (dump[0]["type"] == np.where(right, 2.0, 1.0)).all()
    # bonds that the notch cuts count as damage of the nodes beside it
    beside = (cloud_.nodes[:, 0] < 1e-9) & (np.abs(cloud_.nodes[:, 1] - 5e-4) < 2e-4)
    assert (dump[0]["c_node[1]"][beside] > 0.1).all()
    table = results.thermo(tmp_path / run.LOG)
    assert "c_books[8]" in table


def test_pairs_of_materials_touch_in_their_own_way(tmp_path, lmp):
    one, two = (Material(2e7, 0.25, 1200.0, 6e-4, name=name) for name in ("one", "two"))
    grains = [scene.Grain(square(at=(2e-3 * k, 0.0)), m) for k, m in enumerate((one, two, one))]
    pairs = {
        ("two", "one"): Contact(radius=1e-4, friction=0.5, tangential="regularised"),
        ("two", "two"): Contact(radius=1e-4, stiffness=1e24, damping=1e-3, fragments=False),
        ("one", "one"): Contact(onset=0.02),
    }
    made = scene.Scene(grains=grains, pairs=pairs, **BASE)
    said = {
        tuple(w[:2]): " ".join(w[3:])
        for w in lines(made.script(), "pair_coeff")
        if "peridem/contact" in w
    }
    assert "friction 0.5 tangential regularised" in said["1", "2"]
    assert "stiffness 1e+24 damping 0.001" in said["2", "2"] and "fragments no" in said["2", "2"]
    assert "form bulk 10 onset 0.02 restitution 1 friction 0" in said["1", "1"]
    assert "# onset: contacts get as stiff as that over this part" in made.script()
    run_steps(made, tmp_path, lmp)


@pytest.mark.parametrize(
    "solid",
    [
        Material(2e7, 0.2, 1200.0, 6e-4, s0=0.1, influence="gaussian", width=0.4, plane="stress"),
        Material(2e7, 0.2, 1200.0, 6e-4, influence="inverse", volume="full", breaking="both"),
        Material(2e7, 0.2, 1200.0, 6e-4, gc=3.0, taper=1e-4, viscosity=2.0, influence="constant"),
        BondMaterial(1200.0, 6e-4, young=2e7, gc=3.0),
        BondMaterial(1200.0, 6e-4, bulk=2e7, potential="elastic", plane="stress"),
        BondMaterial(1200.0, 6e-4, c=1e16, s0=0.1, viscosity=1.0),
        BondMaterial(1200.0, 6e-4, potential="rnp", depth=1e12, beta=1e4, breaking="both"),
    ],
)
def test_every_solid_is_known_to_lammps_and_its_step_is_lammpss(tmp_path, lmp, solid):
    made = scene.Scene(grains=[scene.Grain(square(), solid)], **BASE)
    run_steps(made, tmp_path, lmp, 2)
    (limits,) = re.findall(r"time step set to .*", (tmp_path / run.LOG).read_text())
    bonds = float(re.search(r"bonds alone (\S+),", limits)[1])
    contacts = float(re.search(r"contacts alone ([^,)]+)", limits)[1])
    _, stable = made._timestep()
    # printed with four digits; the frequency is settled to 1e-4
    assert stable.bonds == pytest.approx(bonds, rel=1e-3)
    assert stable.contacts == pytest.approx(contacts, rel=1e-3)


def test_walls_of_all_kinds_in_3d(tmp_path, lmp):
    cube = lattice(np.zeros(3), np.full(3, 8e-4), np.full(3, 4), "cube")
    solid = Material(2e7, 0.25, 1200.0, 6e-4)
    drum = Cylinder((0.0, 0.0), 5e-3, "z", -5e-3, 5e-3)
    made = scene.Scene(
        grains=[scene.Grain(cube, solid, velocity=(0.0, 0.0, -1.0))],
        walls=[
            *scene.box_walls((-2e-3, -2e-3, -1e-3), (2e-3, 2e-3, 2e-3), -0.5),
            scene.RegionWall("drum", drum, rotation=Rotation(10.0, (0.0, 0.0, 0.0))),
            scene.RegionWall("ball", Sphere((1.8e-3, 1.8e-3, 1.8e-3), 5e-4, inside=False)),
            scene.Wall("shaker", (0, 0, -2e-3), (0, 0, 1), displacement=(None, None, "1e-4*time")),
        ],
        gravity=(0.0, 0.0, -10.0),
        **BASE,
    )
    dump = run_steps(made, tmp_path, lmp)
    falls = cube.volumes @ (dump[-1]["vz"]) / cube.volumes.sum()
    # what gravity adds to 1 m/s in so short a time
    assert falls == pytest.approx(-1.0, abs=1e-3)
    record = results.averages(tmp_path / scene.WALLS)
    assert "f_drum[6]" in record and "v_lid_travel" in record


def test_engine_and_adaptive_grains_are_passed_on(tmp_path, lmp):
    solid = Material(2e7, 0.25, 1200.0, 6e-4, gc=3.0, gc_spacing=2e-4)
    made = scene.Scene(
        grains=[scene.Grain(square(), solid)], engine="general", adapt="eta 0.1", **BASE
    )
    text = made.script()
    assert "hybrid/overlay peridem/lps engine general peridem/contact" in text
    assert "gc 3 0.0002" in text and "fix motion all peridem/adapt eta 0.1" in text
    run_steps(made, tmp_path, lmp, 5)


def test_the_box_is_fixed_where_a_wall_is_and_follows_the_nodes_elsewhere():
    closed = scenes.two_grains()
    assert closed.sides == ["f", "f", "p"]
    assert "boundary        f f p" in closed.script()
    floor = scenes.two_grains(walls=closed.walls[:1])
    assert floor.sides == ["s", "fs", "p"]
    assert scenes.two_grains(walls=(), boundary="m").sides == ["m", "m", "p"]
    box = ((0.0, 0.0), (3e-3, 5e-3))
    assert scenes.two_grains(walls=(), periodic=(0,), box=box).sides == ["p", "s", "p"]


def test_displaced_grains_keep_their_reference(tmp_path, lmp):
    cloud_ = square()
    u = 1e-6 * np.random.default_rng(1).standard_normal(cloud_.nodes.shape)
    made = scene.Scene(
        grains=[scene.Grain(cloud_, scenes.SOLID, displacement=u)], start_time=1.0, **BASE
    )
    dump = run_steps(made, tmp_path, lmp, 1)
    assert dump[0].position == pytest.approx(cloud_.nodes + u, abs=1e-17)
    assert dump[0]["c_node[4]"].sum() > 0.0  # energy: bonds are strained
    assert results.thermo(tmp_path / run.LOG)["Time"][0] == 1.0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"timestep": -1.0}, "timestep must be above 0, not -1"),
        ({"attributes": ("stretc",)}, "attributes must be of damage"),
        ({"boundary": "x"}, "boundary must be f, s or m"),
        ({"periodic": (0,)}, "needs its box"),
        ({"pairs": {("solid", "stone"): Contact()}}, "no material 'stone', there are solid"),
        ({"motions": [Motion.held("a", Nodes((9,)))]}, "motion 'a' has no nodes"),
        ({"motions": [Motion.held("a", Nodes((1,)), (True,))]}, "motion a needs 2 components"),
        ({"forces": [Force("lid", Nodes((1,)), (1.0, 0.0))]}, "different names"),
    ],
)
def test_bad_parts_are_refused(changes, words):
    with pytest.raises(ValueError, match=words):
        scenes.two_grains(**changes)


def test_bad_loads_regions_and_materials_are_refused():
    for make, words in [
        (lambda: Motion("a", Nodes((1,))), "one of velocity, rotation"),
        (lambda: Motion("motion", Nodes((1,)), (0.0,)), "the script needs the names"),
        (lambda: Motion.following("a", Nodes(), ("1", None), (None, None)), "a rate for every"),
        (lambda: Block((0, 0), (0, 1)), "low must be below high"),
        (lambda: Cylinder((0, 0), -1.0), "radius must be above 0"),
        (lambda: Rotation(1.0, (0, 0), (0, 0, 0)), "an axis other than 0"),
        (lambda: BondMaterial(1.0, 1.0), "one of young, bulk and c needed, not none"),
        (lambda: BondMaterial(1.0, 1.0, young=1.0, c=1.0), "not young, c"),
        (lambda: BondMaterial(1.0, 1.0, young=1.0, depth=1.0), "go together, with potential rnp"),
        (lambda: Material(1.0, 0.2, 1.0, 1.0, breaking="up"), "tension, both"),
        (lambda: Contact(onset=1.0), r"onset must lie in \[0, 1\), not 1.0"),
        (lambda: Contact(damping=1.0, restitution=0.5), "one of damping and restitution"),
        (lambda: Inert(-1.0), "density must be finite and above 0"),
    ]:
        with pytest.raises(ValueError, match=words):
            make()


def test_numbers_in_ranges():
    assert ranges(np.array([5, 1, 2, 3, 9, 10])) == ["1:3", "5", "9:10"]
    assert ranges(np.array([4])) == ["4"]
