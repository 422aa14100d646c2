"""Contacts: which nodes touch, with what force, and the network of forces between grains.

LAMMPS does not write contacts: ``compute pair/local`` would give the sum of the solid's and the
contact's forces. They follow from positions instead: the elastic part of the normal force of two
nodes is their spring times their overlap, exactly, with the numbers that the log tells. What
friction, damping and restitution add is not known from positions and is left out.

Overlaps are small differences of positions, so the dump needs more than LAMMPS's six digits
(``dump_modify ID format float %.10g``); a warning tells when it has too few.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from peridem.results_dump import Frame
from peridem.results_output import Output

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_LAW = r"radius ([\d.eE+-]+), spring ([\d.eE+-]+)( h| V_i V_j)?"


@dataclass(frozen=True)
class Law:
    """Contact of two types, as LAMMPS prints it at the start of a run.

    Attributes:
        radius: distance at which two nodes touch.
        spring: of two nodes, in the unit that ``times`` makes a force over length.
        times: '' (2D), 'h' (the mean of the nodes' sizes) or 'VV' (the product of their volumes).
    """

    radius: float
    spring: float
    times: str

    def springs(self, one: Array, two: Array) -> Array:
        """Springs of pairs of nodes of given volumes."""
        if self.times == "h":
            return np.asarray(self.spring * 0.5 * (np.cbrt(one) + np.cbrt(two)))
        return self.spring * one * two if self.times else np.full(len(one), self.spring)


def laws(output: Output) -> dict[tuple[int, int], Law]:
    """Contact laws of pairs of atom types, both ways round, from the log.

    Raises:
        ValueError: the log has none.
    """
    found: dict[tuple[int, int], Law] = {}
    for i, j, *numbers in re.findall(
        rf"^PERIDEM: contact of types (\d+) (\d+): {_LAW}", *_log(output)
    ):
        found[int(i), int(j)] = found[int(j), int(i)] = _law(numbers)
    if not found:
        raise ValueError(f"the log in {output.folder} tells of no contacts ('PERIDEM: contact of')")
    return found


def wall_laws(output: Output) -> dict[tuple[str, int], Law]:
    """Contact laws of walls, by their names, with atom types."""
    found: dict[tuple[str, int], Law] = {}
    pattern = rf"^PERIDEM: wall (\S+) and types ([\d ]+): {_LAW}"
    for name, kinds, *numbers in re.findall(pattern, *_log(output)):
        found |= {(name, int(kind)): _law(numbers) for kind in kinds.split()}
    return found


def _log(output: Output) -> tuple[str, int]:
    return output.log, int(re.MULTILINE)


def _law(numbers: list[str]) -> Law:
    return Law(
        float(numbers[0]), float(numbers[1]), {" h": "h", " V_i V_j": "VV"}.get(numbers[2], "")
    )


@dataclass(frozen=True, eq=False)
class Contacts:
    """Pairs of touching nodes.

    Attributes:
        nodes: (c, 2) numbers of nodes from 0, in the order of atom-IDs.
        bodies: (c, 2) the grains or fragments that they belong to.
        overlap: (c,) contact distance less distance.
        force: (c, d) elastic normal force on the second node.
        point: (c, d) where they touch.
    """

    nodes: Ints
    bodies: Ints
    overlap: Array
    force: Array
    point: Array

    def __len__(self) -> int:
        return len(self.overlap)


def contacts(output: Output, i: int, bodies: Ints | None = None) -> Contacts:
    """Contacts between grains at frame i.

    Args:
        output: the folder.
        i: number of the frame.
        bodies: (n,) what counts as one body, such as :func:`peridem.results.labels` of fragments;
            None: grains.
    """
    from scipy.spatial import cKDTree

    frame, law = output.frame(i), laws(output)
    x = frame.position[:, : output.dimension]
    grain = frame["mol"].astype(np.int64)
    body = grain if bodies is None else np.asarray(bodies)
    box = frame.box[: output.dimension]
    size = np.where(frame.periodic[: output.dimension], box[:, 1] - box[:, 0], 0.0)
    start = np.where(size > 0.0, box[:, 0], x.min(axis=0) - 1.0)
    inside = x - start
    inside = np.where(size > 0.0, np.mod(inside, np.where(size > 0.0, size, 1.0)), inside)
    tree = cKDTree(inside, boxsize=size if size.any() else None)
    largest = max(one.radius for one in law.values())
    pairs = tree.query_pairs(largest, output_type="ndarray")
    pairs = pairs[body[pairs[:, 0]] != body[pairs[:, 1]]]
    apart = x[pairs[:, 1]] - x[pairs[:, 0]]
    apart -= np.where(size > 0.0, size * np.round(apart / np.where(size > 0.0, size, 1.0)), 0.0)
    distance = np.linalg.norm(apart, axis=1)
    reach, spring = _pair_laws(output, law, pairs)
    same = grain[pairs[:, 0]] == grain[pairs[:, 1]]  # fragments of one grain
    ends = output.reference[pairs[same]]
    reach[same] = np.minimum(reach[same], np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))
    touch = distance < reach
    pairs, apart, distance = pairs[touch], apart[touch], distance[touch]
    overlap = reach[touch] - distance
    _check_digits(frame, overlap)
    force = (spring[touch] * overlap / distance)[:, None] * apart
    point = x[pairs[:, 0]] + 0.5 * apart
    return Contacts(pairs.astype(np.int64), body[pairs], overlap, force, point)


def _pair_laws(output: Output, law: dict[tuple[int, int], Law], pairs: Ints) -> tuple[Array, Array]:
    """Contact distance and spring of pairs of nodes."""
    kind = output.frame(0)["type"].astype(np.int64)[pairs]
    reach, spring = np.zeros(len(pairs)), np.zeros(len(pairs))
    for (a, b), one in law.items():
        mine = (kind[:, 0] == a) & (kind[:, 1] == b)
        if mine.any():
            reach[mine] = one.radius
            ends = pairs[mine]
            volume = output.volumes if one.times else np.ones(len(output.reference))
            spring[mine] = one.springs(volume[ends[:, 0]], volume[ends[:, 1]])
    return reach, spring


def _check_digits(frame: Frame, overlap: Array) -> None:
    """Warn if positions are too coarse for the overlaps."""
    x = frame.position
    largest = float(np.abs(x).max())
    unit = 10.0 ** (np.floor(np.log10(largest)) - 5) if largest else 0.0
    six_digits = unit and np.abs(x / unit - np.round(x / unit)).max() < 1e-3
    if six_digits and len(overlap) and unit > 0.05 * float(np.median(overlap)):
        warnings.warn(
            f"positions have six digits, to {unit:.1g}, overlaps are about "
            f"{float(np.median(overlap)):.1g}: forces of contacts are uncertain; write the dump "
            "with 'dump_modify ID format float %.10g'",
            stacklevel=3,
        )


@dataclass(frozen=True, eq=False)
class Network:
    """Forces between bodies: one entry for each pair that touches.

    Attributes:
        bodies: (m, 2) names of the bodies.
        force: (m, d) on the second one.
        point: (m, d) where they touch: the mean, weighted by force.
        count: (m,) pairs of nodes that touch.
    """

    bodies: Ints
    force: Array
    point: Array
    count: Ints

    @property
    def strength(self) -> Array:
        """Size of the forces, (m,)."""
        return np.asarray(np.linalg.norm(self.force, axis=1))

    def coordination(self, bodies: Ints) -> Ints:
        """How many others each of the named bodies touches, (b,)."""
        names, count = np.unique(self.bodies, return_counts=True)
        found = dict(zip(names.tolist(), count.tolist(), strict=True))
        return np.array([found.get(int(name), 0) for name in bodies], dtype=np.int64)


def network(found: Contacts) -> Network:
    """The network of forces between the bodies of contacts."""
    turned = found.bodies[:, 0] > found.bodies[:, 1]
    bodies = np.sort(found.bodies, axis=1)
    force = np.where(turned[:, None], -found.force, found.force)
    pairs, member, count = np.unique(bodies, axis=0, return_inverse=True, return_counts=True)
    member = member.reshape(-1)
    weight = np.linalg.norm(force, axis=1) + 1e-300
    total, point = np.zeros((len(pairs), force.shape[1])), np.zeros((len(pairs), force.shape[1]))
    np.add.at(total, member, force)
    np.add.at(point, member, found.point * weight[:, None])
    point /= np.bincount(member, weight, len(pairs))[:, None]
    return Network(pairs, total, point, count.astype(np.int64))


def wall_forces(
    output: Output, i: int, bodies: Ints | None = None
) -> dict[str, tuple[Ints, Array]]:
    """Elastic forces of plane walls at frame i: name → (bodies (m,), forces on them (m, d)).

    Args:
        output, i, bodies: as of :func:`contacts`.
    """
    frame, law = output.frame(i), wall_laws(output)
    x = frame.position[:, : output.dimension]
    kind = frame["type"].astype(np.int64)
    body = frame["mol"].astype(np.int64) if bodies is None else np.asarray(bodies)
    result = {}
    for wall in output.walls(output.time(i)):
        gap = (x - wall.point) @ wall.normal
        pushed = np.zeros(len(x))
        for k in np.unique(kind):
            if (wall.name, int(k)) in law:
                one = law[wall.name, int(k)]
                mine = (kind == k) & (gap < one.radius)
                volume = output.volumes[mine]
                pushed[mine] = one.springs(volume, volume) * (one.radius - gap[mine])
        names, member = np.unique(body[pushed > 0.0], return_inverse=True)
        total = np.bincount(member, pushed[pushed > 0.0], len(names))
        result[wall.name] = (names, total[:, None] * wall.normal)
    return result
