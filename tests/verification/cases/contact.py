"""Grains that touch: Hertz, impact, restitution, slopes, spin, a chain of discs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from support.clouds import Cloud, cloud, join, lattice
from support.oracle import Array, Solid
from support.runs import Simulation, lps_words, number

from .base import Case, Lab, Outcome, Row, above, below, near, shown, within
from .meshes import ball

REACH = 0.95  # contact distance, in node spacings
FLAT = Solid(5 / 3, 1.0, 3.015, 2)  # lambda = G = 1, E = 2.5, nu = 1/4, density 1
BALL = Solid(5 / 3, 1.0, 3.015, 3)
SPEED = float(np.sqrt(3.0))  # of longitudinal waves
PLATE = 2.5 / (1 - 0.25**2)  # E/(1 - nu^2): a grain on a rigid plane
DRAG = 0.6  # times speed of shear waves over the radius: twice the slowest frequency, about
SAFETY = 0.5  # of the largest stable step


def disc(radius: float, centre: tuple[float, float] = (0.0, 0.0), molecule: int = 1) -> Cloud:
    """A gmsh disc with nodes a unit apart, a node at its left and right end."""
    from peridem.cloud import mesh
    from peridem.shapes import circle

    made = mesh(circle(radius), 1.0)
    x = np.asarray(made.nodes) + np.asarray(centre)
    return cloud(x, volume=np.asarray(made.volumes), molecule=molecule, dimension=2)


def even_radius(radius: float) -> float:
    """Near ``radius``, with a multiple of four nodes a unit apart around it."""
    return 4 * round(2 * np.pi * radius / 4) / (2 * np.pi)


def sphere(radius: float) -> Cloud:
    """A gmsh ball with nodes about a unit apart, on its surface too."""
    x, volume = ball(radius, 1.15)
    return cloud(x, volume=volume)


def scene(
    lab: Lab, one: Cloud, solid: Solid, contact: str, lines: str = "", safety: float = SAFETY
) -> Simulation:
    sim = lab.simulation().load(one, dimension=solid.dimension)
    sim.commands(
        f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(solid)}
        pair_coeff * * peridem/contact radius {REACH} {contact}
        neigh_modify every 1 delay 0 check yes
        {lines}
        fix step all peridem/timestep safety {safety} every 1000000
        run 0 post no
        unfix step
        fix motion all nve
        """
    )
    return sim


def advance(sim: Simulation, time: float) -> None:
    """Run for a time, with the step that is set."""
    sim.commands(f"run {max(1, round(time / sim.thermo('dt')))} post no")


# --- Hertz ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Pressed:
    """Force of two plates against how much each grain is shortened; what is beside it.

    ``overlap``: of the contacts with both plates; ``unbalance``: difference of the forces on lid
    and floor over their mean, which is 0 at rest.
    """

    shortened: Array
    force: Array
    overlap: Array
    unbalance: Array


STAGES = 8  # states of rest while grains are pressed


def pressed(
    lab: Lab,
    one: Cloud,
    solid: Solid,
    path: float,
    time: float,
    grains: int,
    contact: str = "",
    safety: float = SAFETY,
) -> Pressed:
    """Grains in a column between a floor and a lid that sinks by ``path`` in stages.

    In each stage the lid moves gently, and stands while a drag slows down what swings: grains
    between plates are a heavy mass on soft springs of contact, and their waves die no sooner.
    """
    low, high = one.x[:, 1].min() - REACH, one.x[:, 1].max() + REACH
    drag = DRAG * 4 * grains / np.ptp(one.x[:, 1])
    sim = scene(
        lab,
        one,
        solid,
        f"friction 0.5 {contact}",  # without friction a column of two discs slips aside
        f"""
        variable down equal 0
        fix floor all peridem/wall plane 0 {number(low)} 0 0 1 0
        fix lid all peridem/wall plane 0 {number(high)} 0 0 -1 0 move NULL v_down NULL
        variable drag atom {number(-drag)}*mass*vy
        fix drag all addforce 0 v_drag 0
        """,
        safety,
    )
    rows, stage, depth = [], time / STAGES, path / STAGES
    for k in range(STAGES):
        now = sim.thermo("time")
        part = f"(1-cos({np.pi / (0.4 * stage)}*(time-{now})))"
        sim.commands(f"variable down equal {-k * depth}-{0.5 * depth}*{part}")
        advance(sim, 0.4 * stage)
        sim.commands(f"variable down equal {-(k + 1) * depth}")
        advance(sim, 0.6 * stage)
        floor, lid = sim.fix_vector("floor", 8), sim.fix_vector("lid", 8)
        overlap, force = floor[6] + lid[6], 0.5 * (lid[1] - floor[1])
        rows.append(((k + 1) * depth, force, overlap, abs(lid[1] + floor[1]) / force))
    lab.close()
    table = np.array(rows)
    # discs touch each other with the overlap of two nodes, about that at one plate
    gaps = table[:, 2] * (grains + 1) / 2
    return Pressed((table[:, 0] - gaps) / grains, *table[:, 1:].T)


def disc_approach(force: Array, radius: float) -> Array:
    """How much a disc between two rigid plates is shortened (Johnson 1985, eq. 5.57)."""
    width = np.sqrt(4 * force * radius / (np.pi * PLATE))
    return 2 * force / (np.pi * PLATE) * (2 * np.log(4 * radius / width) - 1)


def sphere_force(shortened: Array, radius: float) -> Array:
    """Hertz: a sphere between two rigid plates, each pressed in by half."""
    return 4 / 3 * PLATE * np.sqrt(radius) * (0.5 * shortened) ** 1.5


def disc_on_disc(radius: float) -> Cloud:
    """Two discs that just touch, one the mirror of the other."""
    upper = disc(radius, molecule=2)
    upper.x = upper.x * (1, -1, 1) + (0, 2 * radius + REACH, 0)
    upper.reference = upper.x.copy()
    return join(disc(radius), upper)


def run_hertz_discs(lab: Lab, radius: float, time: float) -> Outcome:
    r = even_radius(radius)
    rows, found = [], {}
    for name, one, grains in (
        ("disc between plates", disc(r), 1),
        ("disc on disc between plates", disc_on_disc(r), 2),
    ):
        one.box[:2] += np.array([[-10.0, 10.0]])
        got = pressed(lab, one, FLAT, 0.05 * r * grains, time, grains)
        found[name] = got
        width = np.sqrt(4 * got.force * r / (np.pi * PLATE))
        for k in (3, 5, 7):
            rows.append(
                near(
                    f"{name}: shortening of a disc at a force with a/h = {width[k]:.1f}, over 2R",
                    got.shortened[k] / (2 * r),
                    float(disc_approach(got.force[k], r)) / (2 * r),
                    rel=0.05 + 0.2 / width[k],
                    why="5 % for the surface's own stiffness (δ/R) and strains of a few per cent, "
                    "and half a spacing of an edge of the touching length 2a",
                )
            )
        rows.append(
            below(
                f"{name}: lid against floor, largest difference in the second half / force",
                float(got.unbalance[4:].max()),
                0.2 * (0.05 + 0.2 / width[7]),
                why="at rest: what still swings is a fifth of the tolerance above",
            )
        )
    return Outcome(rows, lambda: draw_hertz_discs(found, r))


def draw_hertz_discs(found, r):
    from .plots import panels

    figure, (ax,) = panels(1, width=5.0)
    top = max(p.force.max() for p in found.values())
    force = np.linspace(1e-3, top, 200)
    ax.plot(disc_approach(force, r) / (2 * r), force, "k", label="Hertz, Johnson (5.57)")
    for (name, p), marker in zip(found.items(), "os", strict=True):
        ax.plot(p.shortened / (2 * r), p.force, marker, label=name)
    ax.set(xlabel="shortening of a disc / 2R", ylabel="force (G h)")
    ax.legend()
    return figure


def run_hertz_sphere(lab: Lab, radius: float, time: float) -> Outcome:
    one = sphere(radius)
    one.box += np.array([[-5.0, 5.0]])
    got = pressed(lab, one, BALL, 0.16 * radius, time, 1)
    width = np.sqrt(0.5 * radius * got.shortened)
    rows: list[Row] = []
    for k in (3, 5, 7):
        rows.append(
            near(
                f"force on a sphere at a/h = {width[k]:.1f}, a/R = {width[k] / radius:.2f}",
                got.force[k],
                float(sphere_force(got.shortened[k], radius)),
                rel=0.10 + 0.2 / width[k],
                why="10 % for a/R of a quarter (Hertz holds for small a/R) and surface layers "
                "of δ/R, "
                "and half a spacing of an edge of the touching circle",
            )
        )
    slope = np.polyfit(np.log(got.shortened[2:]), np.log(got.force[2:]), 1)[0]
    rows.append(
        near(
            "exponent of the force, fitted from the third state on",
            float(slope),
            1.5,
            abs=1.2 / radius,
            why="the touching circle grows node by node: h/R",
        )
    )
    hit = impact(lab, one, radius, 0.01 * SPEED)
    rows += impact_rows(hit, radius, 0.01 * SPEED, float(one.volume.sum()))
    return Outcome(rows, lambda: draw_hertz_sphere(got, hit, radius))


@dataclass(frozen=True)
class Impact:
    time: Array
    force: Array
    speed_after: float
    speed_before: float


def impact(lab: Lab, one: Cloud, radius: float, speed: float) -> Impact:
    """A sphere flies at a plane: its force over time."""
    flying = one.moved(one.x)
    flying.v[:, 1] = -speed
    low = one.x[:, 1].min() - REACH - 0.01
    sim = scene(lab, flying, BALL, "", f"fix floor all peridem/wall plane 0 {number(low)} 0 0 1 0")
    span = 1.6 * hertz_time(one.volume.sum(), radius, speed)
    rows = []
    for _ in range(150):
        advance(sim, span / 150)
        rows.append((sim.thermo("time"), -sim.fix_vector("floor", 2)[1]))
    after = float(sim.atoms("v")[:, 1] @ one.volume / one.volume.sum())
    lab.close()
    table = np.array(rows)
    return Impact(table[:, 0], table[:, 1], after, speed)


def hertz_time(mass: float, radius: float, speed: float) -> float:
    return float(2.868 * (mass**2 / (radius * PLATE**2 * speed)) ** 0.2)


def impact_rows(hit: Impact, radius: float, speed: float, mass: float) -> list[Row]:
    touching = hit.time[hit.force > 0]
    depth = (15 * mass * speed**2 / (16 * PLATE * np.sqrt(radius))) ** 0.4
    peak = 4 / 3 * PLATE * np.sqrt(radius) * depth**1.5
    room = 0.1 + 0.2 / np.sqrt(radius * depth)
    return [
        near(
            "impact at 0.01 of the wave speed: time of contact",
            float(touching[-1] - touching[0]),
            hertz_time(mass, radius, speed),
            rel=room,
            why="as the force at rest; waves cross the sphere five times meanwhile; the gap's "
            "spring",
        ),
        near(
            "impact: largest force",
            float(hit.force.max()),
            float(peak),
            rel=room,
            why="the same",
        ),
        within(
            "impact: speed after over speed before, no loss in the law",
            hit.speed_after / hit.speed_before,
            0.95,
            1.0,
            why="what waves keep inside: a few per cent",
        ),
    ]


def draw_hertz_sphere(got, hit, radius):
    from .plots import panels

    figure, axes = panels(2)
    fine = np.linspace(0, got.shortened.max(), 200)
    axes[0].plot(fine / (2 * radius), sphere_force(fine, radius), "k", label="Hertz")
    axes[0].plot(got.shortened / (2 * radius), got.force, "o", label="LAMMPS")
    axes[0].set(xlabel="shortening / 2R", ylabel="force (G h²)", title=f"R = {radius:g} h")
    axes[0].legend()
    axes[1].plot(hit.time, hit.force)
    axes[1].set(xlabel="time (h √(ρ/G))", ylabel="force of the plane", title="impact")
    return figure


# --- collisions -------------------------------------------------------------------------------


def collision(
    lab: Lab,
    radius: float,
    contact: str,
    v1: tuple,
    v2: tuple,
    spin: float = 0.0,
    offset: float = 0.0,
    solid: Solid = FLAT,
    safety: float = SAFETY,
) -> tuple[Cloud, Simulation]:
    """Two discs side by side fly at each other; the second is the mirror of the first."""
    left = disc(radius)
    right = disc(radius, molecule=2)
    right.x = right.x * (-1, 1, 1) + (2 * radius + REACH + 0.02, offset, 0)
    right.reference = right.x.copy()
    for part, v in ((left, v1), (right, v2)):
        arm = part.x - part.x.mean(axis=0)
        part.v[:, :2] = v
        part.v[:, 0] -= spin * arm[:, 1]
        part.v[:, 1] += spin * arm[:, 0]
    one = join(left, right, margin=12 * radius)
    return one, scene(lab, one, solid, contact, safety=safety)


def momentum(one: Cloud, sim: Simulation) -> Array:
    return one.mass @ sim.atoms("v")


def angular_momentum(one: Cloud, sim: Simulation) -> float:
    return float(one.mass @ np.cross(sim.atoms("x"), sim.atoms("v"))[:, 2])


def centre_velocity(one: Cloud, sim: Simulation, molecule: int) -> Array:
    mine = one.molecule == molecule
    return one.mass[mine] @ sim.atoms("v")[mine] / one.mass[mine].sum()


def run_restitution(lab: Lab, radius: float, speeds: tuple[float, ...]) -> Outcome:
    asked, table = (1.0, 0.9, 0.7, 0.5), {}
    r = even_radius(radius)
    rows: list[Row] = []
    for e in asked:
        for speed in speeds:
            half = 0.5 * speed * SPEED
            one, sim = collision(lab, r, f"restitution {e}", (half, 0), (-half, 0))
            before = momentum(one, sim)
            advance(sim, 0.6 / (speed * SPEED) + 8 * r)
            parting = (centre_velocity(one, sim, 2) - centre_velocity(one, sim, 1))[0]
            table[(e, speed)] = parting / (speed * SPEED)
            drift = np.abs(momentum(one, sim) - before).max() / (half * one.mass.sum())
            lab.close()
        got = [table[(e, speed)] for speed in speeds]
        worst = got[int(np.argmax(np.abs(np.array(got) - e)))]
        rows.append(
            near(
                f"restitution {e}: speed of parting over approach, worst of "
                f"{', '.join(f'{s:g}' for s in speeds)} of the wave speed",
                worst,
                e,
                abs=0.05,
                why="a few per cent stay as vibration",
            )
        )
    rows.append(
        below(
            "change of momentum over that of one disc",
            float(drift),
            1e-11,
            why="rounding of some thousand steps",
        )
    )
    return Outcome(rows, lambda: draw_restitution(asked, speeds, table))


def draw_restitution(asked, speeds, table):
    from .plots import panels

    figure, (ax,) = panels(1)
    for speed, marker in zip(speeds, "os^D", strict=False):
        ax.plot(
            asked, [table[(e, speed)] for e in asked], marker, label=f"{speed:g} of the wave speed"
        )
    ax.plot([0.4, 1], [0.4, 1], "k", lw=0.8)
    ax.set(xlabel="restitution asked for", ylabel="speed of parting / approach")
    ax.legend()
    return figure


FRICTION_OF_SPIN = 0.2


def run_spin(lab: Lab, radius: float) -> Outcome:
    r = even_radius(radius)
    half, spin, friction = 0.01, 0.004, FRICTION_OF_SPIN
    rows, after = [], {}
    for mu in (0.0, friction):
        one, sim = collision(lab, r, f"friction {mu}", (half, 0), (-half, 0), spin=spin)
        sim.commands("run 0 post no")
        before = (momentum(one, sim), angular_momentum(one, sim), energy_of(sim))
        advance(sim, 0.6 / half + 8 * r)
        change = (
            float(np.abs(momentum(one, sim) - before[0]).max() / (0.5 * one.mass.sum() * half)),
            angular_momentum(one, sim) / before[1] - 1,
            energy_of(sim) / before[2] - 1,
        )
        after[mu] = centre_velocity(one, sim, 2)
        lab.close()
        couple = -2 * mu * REACH * 2 * half / (2 * spin * 0.5 * r**2)
        rows += kept_rows(mu, change, couple)
    more, pages = on_a_plane(lab, r, half, spin, friction)
    rows += more
    # friction slides all the way: each disc is pushed sideways by mu times what stops it
    smooth, rough = after[0.0], after[friction]
    rows += [
        shown(
            "sideways over normal change of velocity that friction adds, both sliding",
            abs(float((rough[1] - smooth[1]) / (smooth[0] + half))),
            expected=friction,
            why="Coulomb's friction of rigid smooth discs; discs of nodes are cogwheels",
        ),
        shown(
            "the same without friction",
            abs(float(smooth[1] / (smooth[0] + half))),
            expected=0.0,
            why="the shape of the surface alone: nodes of one disc roll over those of the other",
        ),
    ]
    return Outcome(rows, lambda: draw_spin(pages))


def kept_rows(mu: float, change: tuple[float, float, float], couple: float) -> list[Row]:
    """Relative changes of momentum, angular momentum and energy in a collision; couple: what forces
    at nodes R_c apart could do to the second.
    """
    kind = f"friction {mu:g}"
    if mu == 0.0:
        angular = below(
            f"{kind}: relative change of angular momentum",
            abs(change[1]),
            1e-10,
            why="forces along the line of two nodes; rounding of some thousand steps",
        )
    else:
        angular = shown(
            f"{kind}: relative change of angular momentum",
            change[1],
            expected=f"about {couple:.2g} or 0",
            why="two opposite forces of friction at nodes R_c apart turn the pair by "
            "friction times R_c, unless the law acts at one point",
        )
    return [
        below(
            f"{kind}: change of linear momentum over that of one disc",
            change[0],
            1e-11,
            why="rounding of some thousand steps",
        ),
        angular,
        below(
            f"{kind}: relative gain of energy",
            change[2],
            1e-4,
            why="nothing gives energy; the integrator's error is of second order",
        ),
    ]


def draw_spin(pages):
    from .plots import panels

    figure, (ax,) = panels(1, width=5.0)
    names = (
        "along the plane / speed of fall",
        "away from the plane / speed of fall",
        "spin / start",
    )
    for k, name in enumerate(names, 1):
        ax.plot(pages[:, 0], pages[:, k], label=name)
    ax.axhline(-FRICTION_OF_SPIN * (pages[-1, 2] + 1), color="0.4", ls=":", lw=0.8, label="−μ Δv")
    ax.set(xlabel="time (h √(ρ/G))", title="A spinning disc on a plane")
    ax.legend(loc="center right", fontsize=7)
    return figure


def on_a_plane(
    lab: Lab, r: float, speed: float, spin: float, friction: float
) -> tuple[list[Row], Array]:
    """A spinning disc hits a plane, which is smooth: its nodes slide all the way."""
    one = disc(r)
    one.box[:2] += np.array([[-12 * r, 12 * r]])
    one.v[:, 0], one.v[:, 1] = -spin * one.x[:, 1], -speed + spin * one.x[:, 0]
    low = number(one.x[:, 1].min() - REACH - 0.02)
    wall = f"fix floor all peridem/wall plane 0 {low} 0 0 1 0 friction {friction}"
    sim = scene(lab, one, FLAT, "", wall)
    turned, mass, pages = angular_momentum(one, sim), one.mass.sum(), []
    for _ in range(60):
        advance(sim, (0.3 / speed + 8 * r) / 60)
        v = momentum(one, sim) / mass
        centre = one.mass @ sim.atoms("x") / mass
        after = angular_momentum(one, sim) - mass * (centre[0] * v[1] - centre[1] * v[0])
        pages.append((sim.thermo("time"), v[0] / speed, v[1] / speed, after / turned))
    lab.close()
    rows = [
        near(
            "on a plane, friction 0.2: sideways over normal change of velocity",
            abs(float(v[0] / (v[1] + speed))),
            friction,
            rel=0.01,
            why="every node that touches slides: Coulomb's friction of the whole force, but for "
            "the "
            "tangential springs that load at first",
        ),
        near(
            "on a plane: loss of spin over R times the sideways change of momentum",
            float((turned - after) / (r * mass * abs(v[0]))),
            1.0,
            rel=0.05,
            why="the force acts at the lowest nodes, whose distance from the centre the contact "
            "shortens",
        ),
    ]
    return rows, np.array(pages)


def energy_of(sim: Simulation) -> float:
    return sim.thermo("ke") + sim.thermo("pe")


def run_cradle(lab: Lab, radius: float, count: int) -> Outcome:
    r, speed = even_radius(radius), 0.01 * SPEED
    one, sim = collision(lab, r, "", (speed, 0), (0, 0))
    advance(sim, 0.5 / speed + 10 * r)
    passed = float(centre_velocity(one, sim, 2)[0]) / speed
    lab.close()
    final, rows = {}, []
    for name, gap in (("a gap apart", 1.0), ("touching", 1e-3)):
        final[name], more = row_of_discs(lab, r, speed, count, gap, name)
        rows += more
    rows += [
        within(
            "one disc hits one: speed handed on",
            passed,
            0.97,
            1.0,
            why="(1 + e)/2 with an e of 0.95 to 1, as waves stay inside",
        ),
        near(
            f"a gap apart: speed of the last of {count} discs over that of the first",
            final["a gap apart"][-1],
            passed ** (count - 1),
            abs=0.03,
            why="one collision after the other; discs that vibrate hit a little differently",
        ),
        above(
            "touching: speed of the last disc",
            final["touching"][-1],
            0.8,
            why="a chain of elastic spheres hands on 0.99, the rest move a little too; elastic "
            "discs pass a wave that is longer than a disc",
        ),
    ]
    return Outcome(rows, lambda: draw_cradle(final, count))


def row_of_discs(
    lab: Lab, r: float, speed: float, count: int, gap: float, name: str
) -> tuple[list[float], list[Row]]:
    """Speeds of all discs over that of the one which hit the others."""
    parts = [disc(r, centre=(k * (2 * r + REACH + gap), 0.0), molecule=k + 1) for k in range(count)]
    parts[0].v[:, 0] = speed
    one = join(*parts, margin=20 * r)
    sim = scene(lab, one, FLAT, "", safety=0.25)
    before = momentum(one, sim)
    sim.commands("run 0 post no")
    energy = energy_of(sim)
    advance(sim, gap * count / speed + 30 * r)
    speeds = [float(centre_velocity(one, sim, k + 1)[0]) / speed for k in range(count)]
    rows = [
        below(
            f"{name}: relative change of momentum",
            float(np.abs(momentum(one, sim) - before).max() / before[0]),
            1e-11,
            why="rounding of some thousand steps",
        ),
        near(
            f"{name}: relative change of energy",
            energy_of(sim) / energy - 1,
            0.0,
            abs=1e-3,
            why="second order in the step: (ωΔt)²/8 of the stiffest vibrations, which hold little",
        ),
    ]
    lab.close()
    return speeds, rows


def draw_cradle(final, count):
    from .plots import panels

    figure, (ax,) = panels(1)
    for k, (name, values) in enumerate(final.items()):
        ax.bar(np.arange(1, count + 1) + 0.35 * k - 0.17, values, 0.33, label=name)
    ax.set(xlabel="disc", ylabel="speed after / of the first before", xticks=range(1, count + 1))
    ax.legend(loc="upper left")
    return figure


# --- slopes -----------------------------------------------------------------------------------

FRICTION, WEIGHT = 0.4, 0.02


def slope(
    lab: Lab, share: float, tangential: str, settle: float, watch: float
) -> tuple[float, float]:
    """Way and change of speed along the slope of a block, while watched."""
    angle = share * np.arctan(FRICTION)
    x = lattice((8, 4))
    x[:, 1] += 0.94 - x[:, 1].min()
    one = cloud(x, dimension=2, margin=200)
    solid = Solid(30.0, 15.0, 2.3, 2, viscosity=3.0)
    sim = lab.simulation().load(one, dimension=2)
    sim.commands(
        f"""
        pair_style hybrid/overlay peridem/lps peridem/contact
        pair_coeff * * peridem/lps {lps_words(solid)}
        pair_coeff * * peridem/contact radius {REACH}
        fix floor all peridem/wall plane 0 0 0 0 1 0 friction {FRICTION} damping 1.0 &
            tangential {tangential}
        fix weight all gravity {WEIGHT} vector {number(np.sin(angle))} {number(-np.cos(angle))} 0
        fix motion all nve
        timestep 0.02
        run {round(settle / 0.02)} post no
        """
    )
    x0, v0 = (float(sim.atoms(name)[:, 0].mean()) for name in "xv")
    sim.commands(f"run {round(watch / 0.02)} post no")
    x1, v1 = (float(sim.atoms(name)[:, 0].mean()) for name in "xv")
    lab.close()
    return x1 - x0, (v1 - v0) / watch


def run_incline(lab: Lab, shares: tuple[float, ...], settle: float, watch: float) -> Outcome:
    critical, rows, points = np.arctan(FRICTION), [], []
    for share in shares:
        angle = share * critical
        fall = WEIGHT * np.sin(angle)
        expected = max(0.0, fall - WEIGHT * FRICTION * np.cos(angle))
        way, gained = slope(lab, share, "history", settle, watch)
        points.append((share, gained / WEIGHT, expected / WEIGHT))
        if share < 1:
            rows.append(
                below(
                    f"{share:g} of the angle of friction: way, over that of free sliding",
                    abs(way) / (0.5 * fall * watch**2),
                    1e-5,
                    why="at rest; what is left of the vibration of its fall",
                )
            )
        else:
            rows.append(
                near(
                    f"{share:g} of the angle of friction: acceleration over g",
                    gained / WEIGHT,
                    expected / WEIGHT,
                    rel=1e-3,
                    why="all nodes of the sole slip; what is left of the vibration of its fall",
                )
            )
    way, _ = slope(lab, 0.5, "regularised 5", settle, watch)
    creep = WEIGHT * 32 * np.sin(0.5 * critical) / (8 * 5.0)
    rows.append(
        near(
            "regularised friction, half the angle: speed of creep",
            way / watch,
            creep,
            rel=0.02,
            why="weight along the slope over γ of 8 nodes; it is still slowing down at first",
        )
    )
    return Outcome(rows, lambda: draw_incline(points))


def draw_incline(points):
    from .plots import panels

    figure, (ax,) = panels(1)
    share, got, _ = np.array(points).T
    fine = np.linspace(0, max(share), 200)
    angle = fine * np.arctan(FRICTION)
    ax.plot(
        fine,
        np.maximum(0, np.sin(angle) - FRICTION * np.cos(angle)),
        "k",
        label="g (sin θ − μ cos θ)",
    )
    ax.plot(share, got, "o", label="LAMMPS")
    ax.set(xlabel="angle / angle of friction", ylabel="acceleration / g")
    ax.legend()
    return figure


CASES = [
    Case(
        name="hertz-discs",
        title="Discs between plates, and a disc on a disc",
        what="gmsh discs between a floor and a lid that sinks in eight stages, and stands in each "
        "until they are at rest; each is shortened by up to 2.5 % of its diameter. Plane strain, "
        "E = 2.5, ν = 1/4, h = 1; plates without friction. The overlap of the springs of contact "
        "is taken off.",
        source="Johnson 1985, Contact Mechanics, eq. 5.57: 2P/(πE*) (2 ln(4R/a) − 1), a² = "
        "4PR/(πE*), E* = E/(1−ν²); the contact of two equal discs is that of each with a plate.",
        run=run_hertz_discs,
        small={"radius": 10.0, "time": 670.0},
        full={"radius": 24.0, "time": 1600.0},
    ),
    Case(
        name="hertz-sphere",
        title="A sphere between plates, and one that hits a plane",
        what="A gmsh ball (h about 1) pressed by two planes, and flying at one. E = 2.5, ν = "
        "1/4, ρ = 1.",
        source="Hertz: F = 4/3 E* √R (shortening/2)^1.5; time of contact 2.868 (m²/(R E*² "
        "v))^(1/5), largest force from the energy (Johnson 1985, ch. 4, 11).",
        run=run_hertz_sphere,
        small={"radius": 6.0, "time": 100.0},
        full={"radius": 14.0, "time": 250.0},
    ),
    Case(
        name="restitution",
        title="Restitution of colliding discs",
        what="Two gmsh discs hit each other tip to tip at several speeds.",
        source="The coefficient asked for; see pair_style peridem/contact.",
        run=run_restitution,
        small={"radius": 6.0, "speeds": (0.01,)},
        full={"radius": 6.0, "speeds": (0.003, 0.01, 0.05)},
    ),
    Case(
        name="spin",
        title="Spinning discs collide",
        what="Two discs that spin the same way hit each other head-on, without and with "
        "friction of 0.2: their surfaces slide past each other.",
        source="Momentum and angular momentum are kept by internal forces; rigid discs: "
        "sideways over normal change of velocity is μ.",
        run=run_spin,
        small={"radius": 6.0},
        full={"radius": 12.0},
    ),
    Case(
        name="cradle",
        title="Newton's cradle of five discs",
        what="A disc hits a row of discs at rest, a node spacing apart or just touching, "
        "without losses.",
        source="Momentum and energy; one collision after the other hands on ((1+e)/2)^4 of the "
        "speed, with the e of one collision.",
        run=run_cradle,
        small={"radius": 5.0, "count": 5},
        full={"radius": 10.0, "count": 5},
    ),
    Case(
        name="incline",
        title="A block on a slope",
        what="A block of 8 × 4 nodes settles on a plane with friction 0.4; gravity is tilted by "
        "a part of the angle of friction.",
        source="Coulomb: rest below atan μ, g (sin θ − μ cos θ) above.",
        run=run_incline,
        small={"shares": (0.9, 1.2), "settle": 40.0, "watch": 40.0},
        full={"shares": (0.3, 0.6, 0.9, 0.98, 1.02, 1.1, 1.5), "settle": 200.0, "watch": 60.0},
    ),
]
