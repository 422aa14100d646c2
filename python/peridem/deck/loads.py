"""Displacements and forces of a deck as motions and forces of a scene."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from peridem.deck.sections import LoadSet
from peridem.deck.source import Report
from peridem.loads import Force, Motion, Nodes
from peridem.regions import Rotation

Array = NDArray[np.float64]
Bounds = tuple[Array, Array]


def particles_of(load: LoadSet, count: int) -> list[int]:
    """Numbers of the particles that a set speaks of, from 0.

    Raises:
        DeckError: there is no such particle.
    """
    for key, numbers in (
        ("Particle_List", load.particles),
        ("Particle_Exclude_List", load.excluded),
    ):
        for number in numbers or ():
            if number >= count:
                raise load.block.error(key, f"particle {number} of {count} (counted from 0)")
    chosen = range(count) if load.particles is None else sorted(set(load.particles))
    return [k for k in chosen if k not in load.excluded]


def velocity(load: LoadSet, dimension: int) -> tuple[float | None, ...] | None:
    """The constant velocity of a set, None for free directions; or None if it is not constant."""
    if load.still or (load.time == "rotation" and not load.time_values[0]):
        speed = 0.0
    elif load.time == "linear" and load.space == "constant":
        speed = load.time_values[0]
    else:
        return None
    return tuple(speed if k in load.directions else None for k in range(dimension))


def rotation(load: LoadSet) -> Rotation | None:
    """The rotation of a set about the z axis, if it is one and not of rate 0."""
    if load.zero or load.time != "rotation" or not load.time_values[0]:
        return None
    return Rotation(load.time_values[0], load.time_values[1:4])


def motion(
    load: LoadSet,
    name: str,
    nodes: Nodes,
    bounds: Bounds,
    dimension: int,
    as_published: bool,
    report: Report,
    start: float = 0.0,
) -> Motion:
    """The motion of some nodes that a set of displacements prescribes.

    Args:
        load: the set.
        name: of the motion.
        nodes: which ones.
        bounds: box of the region or particle, for hat functions.
        dimension: 2 or 3.
        as_published: whether the speed of a quadratic displacement lacks its factor 2.
        report: where this is said.
        start: time at the start, when nodes have moved so far already.
    """
    constant = velocity(load, dimension)
    if constant is not None:
        return Motion.constant(name, nodes, constant)
    turn = rotation(load)
    if turn is not None and set(load.directions) == set(range(dimension)):
        return Motion.turning(name, nodes, turn)
    known = formulas(load, bounds, as_published, report, start)
    every = [known.get(k, (None, None)) for k in range(dimension)]
    return Motion.following(name, nodes, [pair[0] for pair in every], [pair[1] for pair in every])


def formulas(
    load: LoadSet, bounds: Bounds, as_published: bool, report: Report, start: float = 0.0
) -> dict[int, tuple[str, str]]:
    """Displacement since the start and velocity for each direction of a set."""
    turn = rotation(load)
    if load.still or (load.time == "rotation" and turn is None):
        return dict.fromkeys(load.directions, ("0", "0"))
    if turn is not None:
        found = _turning(load, turn)
    else:
        far = space_factor(load, bounds, load.time_values[0])
        found = dict.fromkeys(load.directions, _time_displacement(load, far, as_published, report))
    if not start:
        return found
    return {
        k: (f"{moved}-({moved.replace('time', repr(start))})", rate)
        for k, (moved, rate) in found.items()
    }


def _turning(load: LoadSet, turn: Rotation) -> dict[int, tuple[str, str]]:
    """A rotation about the z axis, direction by direction."""
    (x0, y0), angle = turn.point[:2], f"({turn.rate!r}*time)"
    x, y = f"({{X}}-({x0!r}))", f"({{Y}}-({y0!r}))"
    moved = {
        0: (
            f"{x}*cos{angle}-{y}*sin{angle}-{x}",
            f"({turn.rate!r})*(-{x}*sin{angle}-{y}*cos{angle})",
        ),
        1: (
            f"{x}*sin{angle}+{y}*cos{angle}-{y}",
            f"({turn.rate!r})*({x}*cos{angle}-{y}*sin{angle})",
        ),
        2: ("0", "0"),
    }
    return {k: moved[k] for k in load.directions}


def space_factor(load: LoadSet, bounds: Bounds, amplitude: float) -> str:
    """The amplitude at a node, as a formula of its place."""
    kind, values = load.space, load.space_values
    if kind in ("constant", "rotation"):
        return f"({amplitude!r})"
    axis = "xy".index(kind[-1])
    place, a = "{" + "XY"[axis] + "}", values[0]
    if kind.startswith("hat"):
        return f"({a!r})*{_hat(place, float(bounds[0][axis]), float(bounds[1][axis]))}"
    if kind.startswith("sin"):
        return f"({amplitude!r})*sin({math.pi * a!r}*{place})"
    return f"({amplitude * a!r})*{place}"


def _hat(place: str, low: float, high: float) -> str:
    """1 in the middle, 0 at both ends and beyond."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    if half < 1e-12:
        return "1"
    up = f"({place}>={low!r})*({place}<{middle!r})*({place}-({low!r}))"
    down = f"({place}>={middle!r})*({place}<={high!r})*({high!r}-{place})"
    return f"(({up}+{down})/{half!r})"


def _time_displacement(
    load: LoadSet, far: str, as_published: bool, report: Report
) -> tuple[str, str]:
    """Displacement and velocity."""
    values = load.time_values
    if load.time == "constant":
        return far, "0"
    if load.time == "linear":
        return f"{far}*time", far
    if load.time == "quadratic":
        factor = 1.0 if as_published else 2.0
        what = "kept" if as_published else "put right"
        report.add(
            load.block.place("Time_Function"),
            f"quadratic: PeriDEM's velocity lacks the factor 2 of the square; {what}",
        )
        b = values[1]
        return f"{far}*time+({b!r})*time*time", f"{far}+({factor * b!r})*time"
    omega = math.pi * values[1]
    return f"{far}*sin({omega!r}*time)", f"{far}*({omega!r})*cos({omega!r}*time)"


# ---- forces --------------------------------------------------------------------------------------


def force(
    load: LoadSet,
    name: str,
    nodes: Nodes,
    bounds: Bounds,
    dimension: int,
    as_published: bool,
    report: Report,
) -> Force:
    """The force per volume that a set of forces puts on some nodes."""
    amplitude = 1.0
    if load.space.startswith(("sin", "linear")):
        if as_published:
            amplitude = load.space_values[0]
        what = "kept" if as_published else "taken once"
        report.add(
            load.block.place("Spatial_Function"),
            f"{load.space}: PeriDEM multiplies by the parameter twice; {what}",
        )
    far = space_factor(load, bounds, amplitude)
    formula = f"{far}*{_time_force(load)}*({load.time_values[0]!r})"
    return Force(
        name, nodes, tuple(formula if k in load.directions else 0.0 for k in range(dimension))
    )


def _time_force(load: LoadSet) -> str:
    """How a force goes with time, but for its first parameter."""
    v: Sequence[float] = load.time_values
    if load.time == "constant":
        return "1"
    if load.time == "linear":
        return "time"
    if load.time == "linear_step":
        period = f"floor(time/{v[1] + v[2]!r})"
        grows = f"(time<({period}*{v[1] + v[2]!r}+{v[1]!r}))"
        return f"({grows}*(time-{period}*{v[2]!r})+(1-{grows})*({period}+1)*{v[1]!r})"
    if load.time == "linear_slow_fast":
        return f"((time>{v[1]!r})*({v[3]!r})*time+(time<={v[1]!r})*({v[2]!r})*time)"
    return f"sin({math.pi * v[1]!r}*time)"
