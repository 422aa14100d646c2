"""Contact of a deck as that of a scene."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from peridem.deck.bodies import Body
from peridem.deck.sections import ContactPair
from peridem.deck.source import Report
from peridem.material import Contact
from peridem.walls import AnyWall, Wall

Array = NDArray[np.float64]
Pairs = dict[tuple[int, int], ContactPair]

DEEP = 1e-3  # of the contact radius: overlaps at the start that matter


@dataclass
class Touch:
    """Contact of a scene.

    Attributes:
        default: where no pair says otherwise.
        pairs: by names of materials.
        walls: by numbers of the particles that became surfaces, where it is not that of grains.
    """

    default: Contact
    pairs: dict[tuple[str, str], Contact] = field(default_factory=dict)
    walls: dict[int, Contact] = field(default_factory=dict)


def touch(
    pairs: Pairs,
    bodies: list[Body],
    names: dict[int, set[str]],
    walls: dict[int, list[AnyWall]],
    planes: list[Wall],
    as_published: bool,
    report: Report,
) -> Touch:
    """The contact of all pairs of zones.

    Args:
        pairs: what the deck says, by numbers of zones.
        bodies: all particles.
        names: of the materials of the zones that have nodes.
        walls: surfaces that particles have become.
        planes: those of them that are flat, where they were as grains were where their clouds are.
        as_published: PeriDEM's radius and stiffness.
        report: where the differences are said.
    """
    spacing = {
        z: min(b.spacing for b in bodies if b.zone.number == z)
        for z in {b.zone.number for b in bodies}
    }
    smallest = min(spacing.values())
    nodes = [k for k in range(len(bodies)) if k not in walls]
    zones = sorted(names)
    known = {pair: pairs.get(pair) for a in zones for b in zones if (pair := (a, b)) and a <= b}
    radius = {
        (a, b): _radius(pair, smallest if as_published else min(spacing[a], spacing[b]))
        for (a, b), pair in known.items()
    }
    if not as_published:
        radius = _clear(radius, known, smallest, bodies, nodes, planes, report)
    made = {
        pair: _contact(given, radius[pair], as_published, report) for pair, given in known.items()
    }
    default = made[zones[0], zones[0]]
    _say(pairs, as_published, report)
    other = {
        (one, two): contact
        for (a, b), contact in made.items()
        if contact != default
        for one in sorted(names[a])
        for two in sorted(names[b])
    }
    return Touch(default, other, _walls(pairs, bodies, walls, made))


def _radius(pair: ContactPair | None, spacing: float) -> float:
    if pair is None:
        return 0.95 * spacing
    return pair.factor * spacing if pair.radius is None else pair.radius


def _contact(
    pair: ContactPair | None, radius: float, as_published: bool, report: Report
) -> Contact:
    if pair is None:
        return Contact(radius=radius)
    contact = Contact(radius=radius, restitution=pair.restitution, friction=pair.friction)
    if not as_published or pair.stiffness is None:
        return contact
    if pair.stiffness > 0.0:
        return replace(contact, stiffness=pair.stiffness)
    report.add(pair.block.place("Kn"), "no contact at K_n = 0; here form bulk 10")
    return contact


def _clear(
    radius: dict[tuple[int, int], float],
    known: dict[tuple[int, int], ContactPair | None],
    smallest: float,
    bodies: list[Body],
    nodes: list[int],
    planes: list[Wall],
    report: Report,
) -> dict[tuple[int, int], float]:
    """Radii of the pairs' own spacings, or those of the smallest one of all where grains would
    overlap at the start."""
    given = next((pair.block for pair in known.values() if pair is not None), None)
    place = given.place("Contact_Radius_Factor") if given is not None else (0, "Contact")
    if not _overlaps(radius, bodies, nodes, planes):
        report.add(
            place,
            "times the smallest node spacing of the two zones; in PeriDEM that of all particles "
            f"and walls ({smallest:.4g})",
        )
        return radius
    report.add(
        place,
        f"times the smallest node spacing of all particles and walls ({smallest:.4g}), as in "
        "PeriDEM: grains would overlap at the start with their own",
    )
    return {pair: _radius(which, smallest) for pair, which in known.items()}


def _overlaps(
    radius: dict[tuple[int, int], float],
    bodies: list[Body],
    nodes: list[int],
    planes: list[Wall],
) -> bool:
    """Whether nodes of two particles, or nodes and planes, are closer than their radius."""
    clouds = [bodies[k].cloud for k in nodes]
    x = np.vstack([c.nodes for c in clouds])
    owner = np.repeat(np.arange(len(clouds)), [len(c.nodes) for c in clouds])
    zone = np.array([bodies[k].zone.number for k in nodes])[owner]
    table = np.zeros((zone.max() + 1, zone.max() + 1))
    for (a, b), value in radius.items():
        table[a, b] = table[b, a] = value
    still = np.array([bodies[k].zone.constrained for k in nodes])[owner]
    i, j = cKDTree(x).query_pairs(float(table.max()), output_type="ndarray").T
    other = (owner[i] != owner[j]) & ~(still[i] & still[j])
    i, j = i[other], j[other]
    gap = np.linalg.norm(x[i] - x[j], axis=1)
    if (gap < (1.0 - DEEP) * table[zone[i], zone[j]]).any():
        return True
    own = table[zone, zone]
    for wall in planes:
        away = (x - np.asarray(wall.point)) @ wall.unit_normal
        if (away < (1.0 - DEEP) * own).any():
            return True
    return False


def _walls(
    pairs: Pairs,
    bodies: list[Body],
    walls: dict[int, list[AnyWall]],
    made: dict[tuple[int, int], Contact],
) -> dict[int, Contact]:
    """Contact of surfaces whose losses are not those of the grains with themselves."""
    found: dict[int, Contact] = {}
    own = [contact for (a, b), contact in made.items() if a == b]
    for k in walls:
        zone = bodies[k].zone.number
        with_wall = [pair for (a, b), pair in pairs.items() if zone in (a, b) and a != b]
        losses = {(pair.restitution, pair.friction) for pair in with_wall}
        if losses and losses != {(c.restitution, c.friction) for c in own}:
            restitution = min(value for value, _ in losses)
            friction = max(value for _, value in losses)
            radius = min(c.radius for c in own if c.radius is not None)
            found[k] = Contact(radius=radius, restitution=restitution, friction=friction)
    return found


def _say(pairs: Pairs, as_published: bool, report: Report) -> None:
    """How stiffness, damping and friction are taken."""
    for pair in pairs.values():
        if pair.stiffness is not None:
            how = "as published (stiffness)" if as_published else "not used: form bulk 10"
            report.add(pair.block.place("Kn"), how)
        if pair.restitution < 1.0:
            report.add(
                pair.block.place("Epsilon"),
                "the restitution of grains; PeriDEM damps between centres by Beta_n_Factor, and "
                "what comes out is another one",
            )
        if pair.friction > 0.0:
            report.add(
                pair.block.place("Friction_Coeff"),
                "friction opposes sliding, with tangential springs; in PeriDEM it acts along it",
            )
