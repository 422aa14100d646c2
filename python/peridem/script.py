"""The input script of a scene: as a person would have written it, and where its numbers come from.

Each function returns one section as lines. The order matters to LAMMPS: forces come before the
fixes that take them away from nodes with a prescribed motion.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from peridem import __version__
from peridem.loads import NODE_VALUES, Nodes, ranges
from peridem.material import AnyMaterial, Contact, Inert, bulk_of, law_of
from peridem.regions import numbers
from peridem.stages import START, Beginning, changes_at_start, emptied
from peridem.walls import AnyWall, RegionWall, Wall, group_of

if TYPE_CHECKING:
    from peridem.scene import Scene

SKIN = 1.25  # of the smallest contact radius, as pair style peridem/contact has it
LOOKS = 20  # at the walls, that one of their records has at least, where it has so many steps
EVERY = 5  # steps between two looks at most: some in each vibration of a contact
HALT_EVERY = 10  # steps between two looks at the time
IN_CACHE = 1000  # nodes: together they take less than the fast memory of a processor
ROOM = 2  # steps allowed, over those that the first time step needs


def script(scene: Scene) -> str:
    """The whole script."""
    step, _ = scene._timestep()
    total = math.ceil(scene.duration / step * (1.0 - 1e-12))
    frame = max(1, round(total / scene.frames))
    record = max(1, round(total / scene.records))
    if not scene.adaptive and scene.timestep is None:
        total = math.ceil(total / frame) * frame
    sections = [
        _head(scene),
        _solids(scene),
        _contact(scene),
        _bonds(scene),
        _walls(scene),
        _loads(scene),
        [*_motion(scene), *changes_at_start(scene)],
        _output(scene, frame, record),
        _run(scene, total, frame),
    ]
    return "\n".join("\n".join(lines) + "\n" for lines in sections if lines)


def _head(scene: Scene) -> list[str]:
    from peridem.scene import SCRIPT

    d, count = scene.dimension, len(scene.reference)
    plane = " 2D with unit thickness: volumes are areas, forces are N per m of thickness."
    lines = [
        f"# {scene.title}",
        "#",
        f"# {len(scene.grains)} grains of together {count} nodes. Made by peridem {__version__};",
        "# edit it as you like, nothing reads it back. Run it in this folder with",
        f"#     mpirun -np 2 lmp -in {SCRIPT}",
        f"# SI units: m, kg, s, N, Pa.{plane if d == 2 else ''}",
        *(f"# {note}" for note in scene.notes),
        "",
    ]
    lines += _nodes(scene) if scene.begin is None else _state(scene, scene.begin)
    return lines + _order(scene)


def _order(scene: Scene) -> list[str]:
    """How nodes lie in memory: those of a small grain together, as they are used.

    LAMMPS sorts by bins of half the cutoff, each with a node or two, row by row through all grains.
    """
    clouds = [cloud for cloud, material in scene._kinds() if not isinstance(material, Inert)]
    if len(scene.grains) == 1 or not clouds or max(len(c.nodes) for c in clouds) > IN_CACHE:
        return []
    size = max(float(np.ptp(cloud.nodes, axis=0).max()) for cloud in clouds)
    sort = f"atom_modify     sort 1000 {size:.3g}"
    return [f"{sort:<40}# nodes of a grain lie together in memory"]


def _nodes(scene: Scene) -> list[str]:
    """Box and nodes, from the data file."""
    from peridem.scene import DATA

    lost = "# f: a node that leaves the box is an error; s: the box follows the nodes"
    positions = ", reference position" if scene.displaced else ""
    style = "peridem reference" if scene.displaced else "peridem"
    lines = [
        "units           si",
        f"dimension       {scene.dimension}",
        f"boundary        {' '.join(scene.sides):<24}{lost}",
        f"atom_style      {style}",
        f"read_data       {DATA:<24}# columns: node, grain, material, volume, density, x, y, z"
        f"{positions}",
    ]
    if scene.start_time:
        lines.append(f"reset_timestep  0 time {scene.start_time:.12g}")
    return lines


def _state(scene: Scene, begin: Beginning) -> list[str]:
    """Box and nodes, from a restart file."""
    return [
        f"# goes on where '{begin.title}' has ended: at step {begin.step}, time "
        f"{scene.start_time:.9g}; the file",
        "# holds units, dimension, atom style, the nodes with their velocities, bonds and what",
        "# contacts remember; coefficients and fixes are said again, and may be other ones",
        f"read_restart    {START}",
    ]


# ---- what grains are made of ---------------------------------------------------------------------


def _solids(scene: Scene) -> list[str]:
    styles = dict.fromkeys(m.style for m in scene.materials if m.style)
    if scene.engine is not None and "peridem/lps" in styles:
        styles = {
            f"{style} engine {scene.engine}" if style == "peridem/lps" else style: None
            for style in styles
        }
    lines = [
        "# ---- solids: one atom type for each material",
        "",
        f"pair_style      hybrid/overlay {' '.join(styles)}{' ' if styles else ''}peridem/contact",
    ]
    for kind, m in enumerate(scene.materials, 1):
        if isinstance(m, Inert):
            lines.append(f"# {m.name} (type {kind}): nodes without bonds")
            continue
        lines += _solid(scene, kind, m)
    lines += _strangers(scene)
    for interface in scene.interfaces:
        lines += _interface(scene, *interface.between, interface.keywords)
    return lines


def _solid(scene: Scene, kind: int, m: AnyMaterial) -> list[str]:
    from peridem.scene import spacings

    assert not isinstance(m, Inert)
    d = scene.dimension
    cloud = next(c for c, other in scene._kinds() if other.name == m.name)
    spacing = float(np.median(spacings(cloud)))
    first = all(other.name != m.name for other in scene.materials[: kind - 1])
    lines = []
    if first:
        lines += [
            f"# {m.name}: waves travel at {m.wave_speed(d):.3g} m/s; density {m.density:g}",
            f"# horizon = {m.horizon / spacing:.2g} node spacings (median {spacing:.3g} m)",
            f"# {m.describe(d)}",
        ]
    return [*lines, f"pair_coeff      {kind} {kind} {m.style} {m.pair_coeff(d)}"]


def _strangers(scene: Scene) -> list[str]:
    """Bonds of materials that LAMMPS cannot mix, and that no grain has both of."""
    said = [set(interface.between) for interface in scene.interfaces]
    alike: dict[tuple[str, ...], list[int]] = {}
    for kind, m in enumerate(scene.materials, 1):
        if not isinstance(m, Inert):
            alike.setdefault((m.name, *law_of(m)), []).append(kind)
    lines = []
    for (first, mine), (second, theirs) in combinations(alike.items(), 2):
        (a, style, *law), (b, other, *another) = first, second
        if style != other or law == another or {a, b} in said:
            continue
        words = scene.materials[mine[0] - 1].pair_coeff(scene.dimension)  # type: ignore[union-attr]
        pairs = [sorted((i, j)) for i in mine for j in theirs]
        lines += [f"pair_coeff      {i} {j} {style} {words}" for i, j in pairs]
    why = (
        "# materials that cannot be mixed: no grain is of both, so this says of no bond what it is"
    )
    return [why, *lines] if lines else []


def _interface(scene: Scene, a: str, b: str, keywords: str) -> list[str]:
    lines = [f"# bonds between {a} and {b}"]
    kinds = list(enumerate(scene.materials, 1))
    for i, one in kinds:
        for j, other in kinds:
            if i < j and {one.name, other.name} == {a, b} and one.style:
                lines.append(f"pair_coeff      {i} {j} {one.style} {keywords}")
    return lines


def _contact(scene: Scene) -> list[str]:
    where = "as given" if scene.contact.radius is not None else "0.95 of the smallest spacing"
    lines = [
        "# ---- contact between nodes of different grains and of fragments",
        f"# radius: {where} of boundary nodes" if where != "as given" else "# radius: as given",
        "# modulus: bulk modulus, the harmonic mean of two materials",
        *(f"# {text}" for text in _forms(scene)),
        "",
    ]
    groups: dict[tuple[str, float | None], list[int]] = {}
    for kind, material in enumerate(scene.materials, 1):
        groups.setdefault(scene.contact_group(material), []).append(kind)
    kinds = list(groups.values())
    found = {}
    for i, mine in enumerate(kinds):
        for theirs in kinds[i:]:
            a, b = scene.materials[mine[0] - 1], scene.materials[theirs[0] - 1]
            contact = scene.contact_of(a, b)
            words = contact.keywords(scene.radius_of(contact), scene.modulus_of(a, b))
            found[f"{_span(mine)} {_span(theirs)}"] = words
    if len(set(found.values())) == 1:  # all alike, whatever the materials are called
        found = {"* *": words}
    lines += [f"pair_coeff      {pair} peridem/contact {words}" for pair, words in found.items()]
    skin = SKIN * scene.radii[0]
    lines += [
        f"neighbor        {skin:.3g} bin".ljust(40)
        + f"# skin: {SKIN} contact radii (the default in si units is 1 mm)",
        "neigh_modify    every 1 delay 0 check yes",
    ]
    bodies = [k for k, m in enumerate(scene.materials, 1) if isinstance(m, Inert)]
    if bodies:
        lines += [
            *emptied(scene, "bodies"),
            f"group           bodies type {' '.join(ranges(np.array(bodies)))}",
            "neigh_modify    exclude group bodies bodies   # bodies do not touch each other",
            *emptied(scene, "solids"),
            "group           solids subtract all bodies",
        ]
    return lines


def _forms(scene: Scene) -> list[str]:
    """What the stiffness of the contacts means."""
    texts = {}
    for contact in (scene.contact, *scene.pairs.values()):
        if contact.stiffness is not None:
            texts["stiffness"] = "stiffness k_N: the spring of two nodes is k_N times their volumes"
        elif contact.jha_horizon is not None:
            texts["jha"] = "form jha2021: k_N = 18 modulus/(pi horizon^5), times their volumes"
        else:
            size = " (times their size)" if scene.dimension == 3 else ""
            texts["bulk"] = (
                f"form bulk: the spring of two nodes is {contact.stiff:g} times the modulus{size}"
            )
        if contact.onset > 0.0:
            texts["onset"] = "onset: contacts get as stiff as that over this part of their distance"
    return list(texts.values())


def _span(kinds: list[int]) -> str:
    return f"{kinds[0]}" if len(kinds) == 1 else f"{kinds[0]}*{kinds[-1]}"


def _bonds(scene: Scene) -> list[str]:
    if not scene.cuts and scene.unbroken is None:
        return []
    lines = ["# ---- bonds: initial cracks, and nodes whose bonds never break", ""]
    words = ""
    for number, cut in enumerate(scene.cuts, 1):
        if cut.region is not None:
            lines += cut.region.commands(f"crack_{number}")
            words += f" cut region crack_{number}"
        else:
            words += f" cut {cut.words}"
    if scene.unbroken is not None:
        lines += _group(scene, "protected", scene.unbroken)
        words += " unbroken protected"
    return [*lines, f"fix bonds all peridem/bonds{words}"]


def _bonded(scene: Scene) -> str:
    """The group of all nodes but those of bodies without bonds."""
    return "solids" if any(isinstance(m, Inert) for m in scene.materials) else "all"


def _group(scene: Scene, name: str, nodes: Nodes) -> list[str]:
    """The commands that make a group: of whole grains, or by the numbers of their nodes."""
    empty = emptied(scene, name)
    if nodes.inside is None and nodes.grains is not None:
        words, kind = ranges(np.array(nodes.grains)), "molecule"
    elif nodes.inside is None:
        return [*empty, f"group           {name} union all"]
    else:
        mask = nodes.mask(scene.grain_of_node, scene.reference)
        words, kind = ranges(np.flatnonzero(mask) + 1), "id"
    return empty + [
        f"group           {name} {kind} {' '.join(words[k : k + 12])}"
        for k in range(0, len(words), 12)
    ]


# ---- walls and loads -----------------------------------------------------------------------------


def _walls(scene: Scene) -> list[str]:
    if not scene.walls:
        return ["# ---- no walls"]
    lines = [
        "# ---- walls: a point, the normal towards the grains, a velocity;",
        "# contact as of each node's own material with itself",
        "",
    ]
    for wall in scene.walls:
        if wall.nodes is not None:
            lines += _group(scene, group_of(wall), wall.nodes)
        said = wall if scene.begin is None else scene.begin.said(wall)
        lines += said.commands(_wall_contact(scene, wall.contact))
    return lines


def _wall_contact(scene: Scene, contact: Contact | None) -> str:
    if contact is None:
        return ""
    bulks = [k for m in scene.materials if (k := bulk_of(m, scene.dimension))]
    modulus = bulks[0] if len(set(bulks)) == 1 else None
    words = contact.keywords(scene.radius_of(contact), modulus)
    return "  " + words.removesuffix(" fragments no")


def _loads(scene: Scene) -> list[str]:
    lines = ["# ---- loads", ""]
    strength = float(np.linalg.norm(scene.gravity))
    if strength:
        towards = numbers([g / strength for g in scene.gravity])
        lines.append(f"fix weight {_bonded(scene)} gravity {strength:.8g} vector {towards}")
    formulas = [str(v) for f in scene.forces for v in f.density]
    formulas += [v for m in scene.motions for v in (*m.displacement, *m.rate) if v]
    if scene.forces or any(key in text for text in formulas for key in NODE_VALUES):
        lines += [
            "# reference position and volume of each node",
            "compute nodes all property/atom xref yref zref volume",
        ]
    for force in scene.forces:
        lines += _group(scene, force.name, force.nodes)
        lines += force.commands(scene.dimension)
    if scene.motions:
        lines += [
            "# prescribed motion; f_NAME[1] ... is the force that the nodes of NAME would feel",
        ]
    for motion in scene.motions:
        lines += _group(scene, motion.name, motion.nodes)
        lines += motion.commands(scene.dimension, _mover(scene, motion.name))
    return lines if len(lines) > 2 else []


def _mover(scene: Scene, name: str) -> str:
    """ID of the fix that moves nodes by formulas: one that no restart file knows, if it is to begin
    with where they are."""
    known = frozenset() if scene.begin is None else scene.begin.movers
    mover, number = f"{name}_move", 2
    while mover in known:
        mover, number = f"{name}_move_{number}", number + 1
    return mover


def _motion(scene: Scene) -> list[str]:
    step, stable = scene._timestep()
    driven = [motion.name for motion in scene.motions if not motion.steady]
    lines = ["# ---- motion and time step", ""]
    if driven:
        lines += [
            *emptied(scene, "free"),
            f"group           free subtract all {' '.join(driven)}",
        ]
    mover = "nve" if scene.adapt is None else f"peridem/adapt {scene.adapt}".rstrip()
    lines.append(f"fix motion {'free' if driven else 'all'} {mover}")
    limits = [
        f"# stable at the start up to {stable.bonds:.3g} s for bonds alone (highest frequency of a"
        " grain),",
        f"# {stable.contacts:.3g} s for contacts (the lightest node pressed by "
        f"{scene.dimension + 1} at once),",
        f"# {stable.together:.3g} s for both, with viscosity",
    ]
    if scene.adaptive:
        return [
            *lines,
            f"# the step: {scene.safety:g} of the largest stable one, as contacts come and go",
            *limits,
            f"fix step all peridem/timestep safety {scene.safety:g}",
        ]
    why = "the deck's or yours" if scene.timestep is not None else f"{scene.safety:g} of that"
    if scene.timestep is None:
        why += "; constant, since fix move wants it so"
    return [*lines, *limits, f"# taken: {why}", f"timestep        {step:.12g}"]


# ---- output --------------------------------------------------------------------------------------


def _output(scene: Scene, frame: int, record: int) -> list[str]:
    from peridem.scene import DUMP

    attributes = scene.dumped()
    columns = [f"c_node[{i}]" for i in range(1, len(attributes) + 1)]
    place, speed = ("x y", "vx vy") if scene.dimension == 2 else ("x y z", "vx vy vz")
    labelled, first = "fragment" in attributes and bool(columns), 4 + 2 * scene.dimension
    timed = scene.adaptive and scene.adapt is not None  # steps of rigid grains are longer
    lines = ["# ---- output", ""]
    if any(m.style for m in scene.materials):
        lines += [
            f"# columns of c_node: {', '.join(attributes)}",
            f"compute node all peridem/atom {' '.join(attributes)}",
        ]
    else:
        columns = []
    more = "".join(f" {column}" for column in scene.columns)
    lines += [
        f"dump grains all custom {1 if timed else frame} {DUMP} id mol type {place} {speed} "
        f"{' '.join(columns)}{more}",
        "# nine digits for positions: overlaps of nodes are small differences of them",
        "dump_modify grains sort id time yes "
        + " ".join(f"format {k} %.9g" for k in range(4, 4 + scene.dimension))
        + (f" format {first + attributes.index('fragment')} %.0f" if labelled else "")
        + (" first yes" if scene.begin is not None else ""),
        *([f"dump_modify grains every/time {scene.duration / scene.frames:.9g}"] if timed else []),
    ]
    shown = "step time"
    if columns:
        lines.append(f"compute damage {_bonded(scene)} reduce ave c_node[1]")
        shown += " c_damage"
    shown += " pe ke" if not scene.adaptive else " dt pe ke"
    forces, moving = _recorded(scene)
    lines += moving
    for wall in scene.walls:
        if wall.moves and isinstance(wall, Wall):
            shown += f" v_{wall.name}_travel v_{wall.name}_force"
    if scene.energies:
        lines += [
            "# 1 strain 2 contact 3 broken bonds 4 friction 5 damping 6 walls 7 kinetic 8 drift",
            "compute books all peridem/energy",
        ]
        shown += "".join(f" c_books[{k}]" for k in range(1, 9))
    lines += _averages(forces, record)
    return [
        *lines,
        f"thermo          {frame}",
        f"thermo_style    custom {shown}",
        "thermo_modify   flush yes norm no",
    ]


def _recorded(scene: Scene) -> tuple[list[str], list[str]]:
    """Columns of the file of wall forces; variables that they and the thermo output need."""
    d, names, lines = scene.dimension, [], []
    for wall in scene.walls:
        if wall.moves and isinstance(wall, Wall):
            names.append(f"v_{wall.name}_travel")
            lines += _travel(scene, wall)
    for thing in (*scene.walls, *scene.motions):
        names += [f"f_{thing.name}[{k}]" for k in range(1, d + 1)]
        if isinstance(thing, RegionWall) and thing.rotation is not None:
            names.append(f"f_{thing.name}[6]")  # torque about the axis z
    if names:
        names.insert(0, "v_now")
        lines.insert(0, "variable now equal time")
    return names, lines


def _travel(scene: Scene, wall: AnyWall) -> list[str]:
    assert isinstance(wall, Wall)
    speed = float(np.linalg.norm(wall.velocity))
    since = f"(time-{scene.start_time:.12g})" if scene.start_time else "time"
    force = "+".join(
        f"({-n:.8g})*f_{wall.name}[{k}]" for k, n in enumerate(wall.unit_normal, 1) if n
    )
    return [
        f"# how far the wall '{wall.name}' has gone, and the force that pushes it back",
        f"variable {wall.name}_travel equal {speed:.8g}*{since}",
        f"variable {wall.name}_force equal {force}",
    ]


def _averages(names: Sequence[str], record: int) -> list[str]:
    from peridem.scene import WALLS

    if not names:
        return []
    # each look makes all ranks wait for each other, and LAMMPS sum up all energies in that step
    each = min(EVERY, max(1, record // LOOKS))
    looks = record // each
    return [
        f"# forces on the walls, averaged over {looks} looks in {looks * each} steps",
        f"fix walls all ave/time {each} {looks} {looks * each} {' '.join(names)} "
        f'file {WALLS} format " %.10g"',
    ]


def _run(scene: Scene, total: int, frame: int) -> list[str]:
    from peridem.scene import RESTART, STOP

    step, _ = scene._timestep()
    every = max(1, total // 10 // frame) * frame
    lines = [f"# ---- run; a file named '{STOP}' in this folder ends it early", ""]
    if scene.leapfrog and scene.begin is None:
        lines += _half_a_step(scene)
    lines += [
        f"variable halted equal is_file({STOP})",
        f"fix halt all halt {max(1, frame // 4)} v_halted > 0 error soft",
        f"restart         {every} {RESTART}.1 {RESTART}.2",
        *(_until_rest(scene, total) if scene.rest is not None else []),
    ]
    if scene.adaptive:
        end = scene.start_time + scene.duration
        lines += [
            f"# about {total} steps of {step:g} s; the time ends it, so more are allowed",
            f"variable duration equal time>={end:.12g}",
            f"fix duration all halt {HALT_EVERY} v_duration > 0 error continue message no",
            f"run             {ROOM * total}",
        ]
    else:
        lines += [f"# {total} steps of {step:g} s", f"run             {total}"]
    if scene.adaptive or scene.rest is not None:
        lines += [
            "# whatever step that was: a frame and a line of thermo output of it",
            "dump_modify     grains every 1",
            "run             0 post no",
        ]
    return [*lines, f"write_restart   {RESTART}"]


def _until_rest(scene: Scene, total: int) -> list[str]:
    """Ends the run when the nodes are slow."""
    density = np.array([m.density for m in scene.materials])[scene.type_of_node - 1]
    mass = float((np.concatenate([g.cloud.volumes for g in scene.grains]) * density).sum())
    since = scene.start_time + 0.1 * scene.duration
    every = HALT_EVERY if scene.adaptive else max(1, total // 1000)
    return [
        f"# at rest: a speed of {scene.rest:g} m/s in the root mean square of all nodes",
        f"variable rested equal time>{since:.9g}&&ke<{0.5 * mass * (scene.rest or 0.0) ** 2:.9g}",
        f"fix rested all halt {every} v_rested > 0 error continue message no",
    ]


def _half_a_step(scene: Scene) -> list[str]:
    axes = "xyz"[: scene.dimension]
    words = " ".join([*(f"v_kick_{k}" for k in axes), "NULL"][:3])
    return [
        "# symplectic Euler (v += dt f/m, then x += dt v) is velocity Verlet with velocities that",
        "# start half a step ahead; where the motion is prescribed there is no force",
        *(f"variable kick_{k} atom v{k}+0.5*dt*f{k}/mass" for k in axes),
        "run             0",
        f"velocity        all set {words}",
    ]
