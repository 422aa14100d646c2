"""The sections of a deck as plain data, close to how the deck says it.

Every reader takes the block of its section; keys that have no meaning here are named in the report.
Zones, sets and pairs are counted from 1, particles from 0, as decks do.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from peridem.deck.geometry import Shape, shape
from peridem.deck.source import Block, Report

TIME_FUNCTIONS = {
    "Displacement_BC": {"constant": 1, "linear": 1, "quadratic": 2, "sin": 2, "rotation": 4},
    "Force_BC": {"constant": 1, "linear": 1, "linear_step": 3, "linear_slow_fast": 4, "sin": 2},
}
SPACE_FUNCTIONS = {
    **{"constant": 0, "rotation": 0},
    **{f"{name}_{axis}": 1 for name in ("hat", "sin", "linear") for axis in "xy"},
}


# ---- model ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Model:
    """Dimension and time.

    Attributes:
        dimension: 2 or 3.
        single: whether there is one particle only (``Single_Particle``).
        leapfrog: whether time goes in steps of symplectic Euler.
        final_time, steps: the end, and how many steps lead to it.
        seed: of random orientations.
    """

    dimension: int
    single: bool
    leapfrog: bool
    final_time: float
    steps: int
    seed: int

    @property
    def dt(self) -> float:
        """The time step."""
        return self.final_time / self.steps


def model(root: Block, report: Report) -> Model:
    """The section ``Model``."""
    block = root.block("Model")
    if "Model" not in root:
        raise root.missing("Model", "dimension and time are there")
    dimension = block.whole("Dimension")
    if dimension not in (2, 3):
        raise block.error("Dimension", f"2 or 3 needed, not {dimension}")
    discretisation = block.block("Discretization_Type")
    rule = discretisation.choice(
        "Time", ("central_difference", "velocity_verlet"), "velocity_verlet"
    )
    spatial = discretisation.text("Spatial", "finite_difference")
    if spatial != "finite_difference":
        report.add(
            discretisation.place("Spatial"), f"'{spatial}' is not known: nodes carry lumped volumes"
        )
    fallback = "Multi_Particle" if "Particle" in root else None
    kind = block.choice("Particle_Sim_Type", ("Multi_Particle", "Single_Particle"), fallback)
    for key in block.skip("Populate_ElementNodeConnectivity", "Quad_Approximation_Order"):
        report.add(block.place(key), "no counterpart: it concerns quadrature points of elements")
    for key in block.skip("Mesh_Size", "Horizon", "Horizon_h_Ratio"):
        report.add(block.place(key), "not used: horizons are those of the materials")
    steps = block.whole("Time_Steps")
    if steps < 1:
        raise block.error("Time_Steps", "at least 1 needed")
    return Model(
        dimension,
        kind == "Single_Particle",
        rule == "central_difference",
        block.positive("Final_Time"),
        steps,
        block.whole("Seed", 1),
    )


# ---- zones ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Zone:
    """One zone: what its particles look like.

    Attributes:
        number: from 1.
        wall: whether its particles are walls.
        constrained: whether no force moves them.
        own: whether its mesh is one particle where it is, rather than the shape of those in the
            particle table.
        shape: geometry, or None.
        block: of the particle, for messages.
        mesh: block of the mesh.
    """

    number: int
    wall: bool
    constrained: bool
    own: bool
    shape: Shape | None
    block: Block
    mesh: Block

    @property
    def name(self) -> str:
        """Of its material."""
        return f"zone_{self.number}"


def zones(root: Block, model: Model, report: Report) -> list[Zone]:
    """The sections ``Zone``, ``Particle``, ``Wall`` (old syntax) and ``Mesh``, zone by zone."""
    section = root.block("Zone")
    if "Zone" not in root and not model.single:
        raise root.missing("Zone", "the number of zones is there")
    count = section.whole("Zones", 1)
    if count < 1:
        raise section.error("Zones", "at least 1 needed")
    particles, walls, meshes = (root.block(key) for key in ("Particle", "Wall", "Mesh"))
    whole = model.single and count == 1  # such decks may have no zones
    found = []
    for number in range(1, count + 1):
        key = f"Zone_{number}"
        about = section.block(key)
        wall = about.flag("Is_Wall")
        about.skip("Type", "Parameters", "Vec_Type", "Vec_Flag")  # never used by PeriDEM either
        old = key not in particles and key in walls
        block = walls.block(key) if old else particles.part(key, whole and "Type" in particles)
        if not (key in particles or key in walls or model.single):
            raise particles.missing(key, f"the particles of zone {number} are described there")
        mesh = meshes.part(key, whole)
        if key not in meshes and mesh is not meshes:
            raise meshes.missing(key, f"the mesh of zone {number} is named there")
        found.append(_zone(number, wall, old, block, mesh, model, report))
    return found


def _zone(
    number: int,
    wall: bool,
    old: bool,
    block: Block,
    mesh: Block,
    model: Model,
    report: Report,
) -> Zone:
    if old:
        kind = block.text("Type", "flexible")
        block.skip("Mesh")
        if kind not in ("flexible", "rigid"):
            raise block.error("Type", f"flexible or rigid needed, not '{kind}'")
        geometry = None
    else:
        block.skip("Is_Wall")  # said by the zone
        geometry = shape(block) if "Type" in block else None
    if block.skip("Near_Bd_Nodes_Tol"):
        report.add(block.place("Near_Bd_Nodes_Tol"), "no counterpart: it marks nodes for output")
    reference = mesh.block("Reference_Particle")
    if "Type" in reference:
        shape(reference)
        report.add(reference.place(), "not used, as in PeriDEM: sizes follow from Particle")
    own = block.flag("Create_Particle_Using_ParticleZone_GeomObject") or model.single or old
    constrained = block.flag("All_Dofs_Constrained")
    return Zone(number, wall, constrained, own, geometry, block, mesh)


# ---- contact -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ContactPair:
    """Contact of two zones.

    Attributes:
        radius: absolute contact radius, or None.
        factor: else, times a node spacing.
        stiffness: K_n with its factor, or None.
        restitution: 1 without damping.
        friction: 0 without friction.
        block: for messages.
    """

    radius: float | None
    factor: float
    stiffness: float | None
    restitution: float
    friction: float
    block: Block


def contacts(
    root: Block, count: int, single: bool, report: Report
) -> dict[tuple[int, int], ContactPair]:
    """The section ``Contact``: zone pairs (a, b), a <= b, counted from 1."""
    section = root.block("Contact")
    found: dict[tuple[int, int], ContactPair] = {}
    for a in range(1, count + 1):
        for b in range(a, count + 1):
            key = f"Zone_{a}{b}"
            if key in section:
                block = section.block(key)
                found[a, b] = _copied(block, found) or contact(block, report)
            elif not single:
                report.add(
                    section.place(), f"{key} is missing: radius 0.95 node spacings, no losses"
                )
    return found


def _copied(block: Block, known: dict[tuple[int, int], ContactPair]) -> ContactPair | None:
    pair = block.wholes("Copy_Contact_Data")
    if not pair:
        return None
    if len(pair) != 2 or (min(pair), max(pair)) not in known:
        raise block.error("Copy_Contact_Data", f"no zone pair {pair} before it")
    return known[min(pair), max(pair)]


def contact(block: Block, report: Report) -> ContactPair:
    """One zone pair."""
    radius = block.positive("Contact_Radius") if "Contact_Radius" in block else None
    factor = block.positive("Contact_Radius_Factor", 0.95)
    if "Contact_Radius_Factor" in block:
        radius = None  # it counts before the radius
    elif radius is None:
        report.add(block.place(), "neither Contact_Radius nor its factor: 0.95 node spacings")
    stiffness = None
    if "Kn" in block:
        stiffness = block.number("Kn") * block.number("Kn_Factor", 1.0)
        for key in block.skip("V_Max", "Delta_Max"):
            report.add(block.place(key), "not used: Kn is given")
    else:
        block.skip("Kn_Factor")
        for key in block.skip("V_Max", "Delta_Max"):
            report.add(
                block.place(key), "PeriDEM makes no contact of it (K_n stays 0); form bulk here"
            )
    restitution, friction = 1.0, 0.0
    if block.flag("Damping_On", True) and block.number("Beta_n_Factor", 1.0) >= 1e-8:
        restitution = block.number("Epsilon")
        if not 0.0 < restitution <= 1.0:
            raise block.error("Epsilon", f"must lie in (0, 1], not {restitution:g}")
    if block.flag("Friction_On", True):
        friction = block.number("Friction_Coeff")
        if friction < 0.0:
            raise block.error("Friction_Coeff", f"must be at least 0, not {friction:g}")
    block.skip("Epsilon", "Friction_Coeff", "Beta_n_Factor")
    return ContactPair(radius, factor, stiffness, restitution, friction, block)


# ---- loads ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class LoadSet:
    """One set of ``Displacement_BC`` or ``Force_BC``.

    Attributes:
        particles: numbers from 0, or None for all.
        excluded: not these.
        region: nodes inside it only, or None.
        directions: from 0.
        time, time_values: time function and its parameters.
        space, space_values: space function and its parameters.
        zero: whether nothing moves.
        block: for messages.
    """

    particles: tuple[int, ...] | None
    excluded: tuple[int, ...]
    region: Shape | None
    directions: tuple[int, ...]
    time: str
    time_values: tuple[float, ...]
    space: str
    space_values: tuple[float, ...]
    zero: bool
    block: Block

    @property
    def number(self) -> str:
        """Of the set."""
        return self.block.keys[-1].removeprefix("Set_")

    @property
    def still(self) -> bool:
        """Whether nothing moves."""
        return self.zero or (self.time == "constant" and not any(self.time_values[:1]))


def load_sets(
    root: Block, name: str, model: Model, walls: list[int], report: Report
) -> list[LoadSet]:
    """The sets of ``Displacement_BC`` or ``Force_BC``.

    Args:
        root: of the deck.
        name: of the section.
        model: of the deck.
        walls: numbers of the particles that are walls, for ``Wall_List`` of the old syntax.
        report: where it is said what has no meaning.
    """
    section = root.block(name)
    count = section.whole("Sets", 0)
    sets = []
    for number in range(1, count + 1):
        key = f"Set_{number}"
        if key not in section:
            raise section.missing(key, f"Sets is {count}")
        sets.append(_load_set(section.block(key), name, model, walls, report))
    return sets


def _load_set(block: Block, name: str, model: Model, walls: list[int], report: Report) -> LoadSet:
    block.skip("Selection_Type")  # follows from what is given
    particles: tuple[int, ...] | None = tuple(block.wholes("Particle_List"))
    for number in block.wholes("Wall_List"):
        if number >= len(walls):
            raise block.error("Wall_List", f"wall {number} of {len(walls)} (counted from 0)")
        particles = (*(particles or ()), walls[number])
    region = None
    if "Region" in block:
        region = shape(block.block("Region").block("Geometry"))
    if not particles:
        particles = None
        if region is None and not model.single:
            raise block.missing("Particle_List", "particles, or a Region, are needed")
    directions = _directions(block, model, report)
    zero = name == "Displacement_BC" and block.flag("Zero_Displacement")
    function, values = _function(block, "Time_Function", TIME_FUNCTIONS[name], zero)
    space, space_values = _function(block, "Spatial_Function", SPACE_FUNCTIONS, True)
    if function == "rotation" and model.dimension == 3 and len(set(directions)) < 2:
        raise block.error("Direction", "a rotation needs at least directions 1 and 2")
    return LoadSet(
        particles,
        tuple(block.wholes("Particle_Exclude_List")),
        region,
        directions,
        function,
        values,
        space,
        space_values,
        zero,
        block,
    )


def _directions(block: Block, model: Model, report: Report) -> tuple[int, ...]:
    """Directions from 0; in 2D without the third one."""
    given = block.wholes("Direction")
    known = tuple(d - 1 for d in given if 1 <= d <= model.dimension)
    if not known or not all(1 <= d <= 3 for d in given):
        wanted = "1 or 2" if model.dimension == 2 else "1, 2 or 3"
        raise block.error(
            "Direction",
            f"directions {wanted} needed, not {', '.join(map(str, given)) or 'none'}",
        )
    if len(known) < len(given):
        report.add(block.place("Direction"), "3 means nothing in 2D")
    return known


def _function(
    block: Block, key: str, known: dict[str, int], optional: bool
) -> tuple[str, tuple[float, ...]]:
    if key not in block:
        if not optional:
            raise block.missing(key, "how it depends on time")
        return "constant", (0.0,) * known["constant"]
    part = block.block(key)
    name = part.choice("Type", tuple(known))
    values = tuple(part.numbers("Parameters"))
    if len(values) < known[name] and not (optional and key == "Time_Function"):
        raise part.error("Parameters", f"{name} has {known[name]} of them, not {len(values)}")
    return name, values


# ---- output --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Output:
    """What is written.

    Attributes:
        interval: steps between two outputs, or None.
        records: steps between two records of forces, or None.
        tags: names of the fields.
        block: for messages.
    """

    interval: int | None
    records: int | None
    tags: list[str] = field(default_factory=list)
    block: Block | None = None


def output(root: Block, report: Report) -> Output:
    """The section ``Output``."""
    block = root.block("Output")
    interval = block.whole("Output_Interval", 0) or None
    records = block.whole("Test_Output_Interval", 0) or None
    if "Output_Interval" in block and interval is None:
        report.add(block.place("Output_Interval"), "0: the first and the last state are written")
    reasons = {
        "Path": "outputs go to the folder of the run",
        "File_Format": "dumps are text; peridem render writes .vtu for ParaView",
        "Compress_Type": "dumps are text; name the dump *.gz in the script to compress it",
        "Debug": "no counterpart: LAMMPS's log says what happens",
        "Tag_PP": "no counterpart: file names are fixed",
        "Perform_FE_Out": "mesh.vtu holds the cells always",
        "Output_Criteria": "no counterpart: output does not depend on the state",
    }
    for key, reason in reasons.items():
        for here in block.skip(key):
            report.add(block.place(here), reason)
    if not block.flag("Perform_Out", True):
        report.add(block.place("Perform_Out"), "the first and the last state are written still")
        interval = None
    return Output(interval, records, block.words("Tags"), block)
