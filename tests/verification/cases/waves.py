"""Plane waves on lattices, a pulse in a bar, and a spherical pulse in a cube."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import erf

from support.clouds import Cloud, cloud, lattice
from support.oracle import Array, Solid
from support.runs import Simulation, number, solid_script

from .base import Case, Lab, Outcome, Row, below, near, shown, within
from .lattices import frequency

# --- dispersion -------------------------------------------------------------------------------

TINY = 1.0e-6
NAMES = {0: "longitudinal", 1: "transverse"}


def periodic_bar(lab: Lab, solid: Solid, count: int) -> tuple[Simulation, Array]:
    """``count`` nodes along x, 8 across, endless in all directions; unit mass and spacing."""
    d = solid.dimension
    shape = (count, *(8,) * (d - 1))
    one = cloud(lattice(shape), dimension=d, margin=0.0)
    for axis, nodes in enumerate(shape):
        one.box[axis] = (-0.5 * nodes, 0.5 * nodes)
    one.periodic = (True, True, d == 3)
    sim = lab.simulation().load(one, dimension=d)
    sim.commands(solid_script(solid) + "run 0 post no")
    return sim, one.reference


def measured_frequency(sim: Simulation, x: Array, waves: int, count: int, along: int) -> float:
    """From the forces of a small displacement in the shape of the wave."""
    shape = np.cos(2 * np.pi * waves * x[:, 0] / count + 0.25 * np.pi)  # no wave is 0 at all nodes
    moved = x.copy()
    moved[:, along] += TINY * shape
    force = sim.at(moved).atoms("f")[:, along]
    sim.at(x)
    return float(np.sqrt(-(force @ shape) / (TINY * shape @ shape)))


def run_dispersion(lab: Lab, counts: tuple[int, ...], m: float) -> Outcome:
    rows, curves = [], {}
    count = max(counts)
    numbers = list(range(1, count // 2 + 1))
    for d in (2, 3):
        for influence in ("linear", "constant"):
            solid = Solid(5 / 3, 1.0, m, d, influence=influence)
            sim, x = periodic_bar(lab, solid, count)
            speed = [np.sqrt(solid.lame + 2 * solid.shear), np.sqrt(solid.shear)]
            for along, kind in NAMES.items():
                worst, ratio = 0.0, []
                for waves in numbers:
                    k = 2 * np.pi * waves / count
                    exact = frequency(solid, np.array([k, 0, 0])[:d], along)
                    got = measured_frequency(sim, x, waves, count, along)
                    worst = max(worst, abs(got / exact - 1))
                    ratio.append(got / (k * speed[along]))
                curves[(d, influence, kind)] = (count / np.array(numbers), np.array(ratio))
                rows.append(
                    below(
                        f"{d}D, {influence}, {kind}: largest relative difference from the "
                        f"lattice's "
                        f"dispersion relation, wavelengths 2 h to {count} h",
                        worst,
                        1e-6,
                        why=(
                            "rounding: positions of 40 and displacements of 1e-6; second order "
                            "of these"
                        ),
                    )
                )
                text = ", ".join(f"{ratio[numbers.index(count // wave)]:.3f}" for wave in counts)
                lengths = ", ".join(str(wave) for wave in counts)
                rows.append(
                    shown(
                        f"{d}D, {influence}, {kind}: phase speed over the classical, λ/h = "
                        f"{lengths}",
                        text,
                        expected=BY_HAND.get((d, influence, kind), ""),
                        why="short waves are slower than classical ones, as in any lattice",
                    )
                )
            lab.close()
    rows += [standing_wave(lab, m, along) for along in NAMES]
    return Outcome(rows, lambda: draw_dispersion(curves))


# phase speeds at λ/h = 10, 20, 40 computed apart from the code here
BY_HAND = {
    (3, "constant", "longitudinal"): "0.909, 0.955, 0.967",
    (3, "constant", "transverse"): "0.995, 1.030, 1.039",
    (3, "linear", "longitudinal"): "0.950, 0.988, 0.998",
    (3, "linear", "transverse"): "0.966, 0.990, 0.996",
    (2, "constant", "longitudinal"): "0.921, 0.977, 0.991",
    (2, "constant", "transverse"): "0.965, 1.000, 1.009",
    (2, "linear", "longitudinal"): "0.947, 0.985, 0.994",
    (2, "linear", "transverse"): "0.973, 0.998, 1.005",
}


def standing_wave(lab: Lab, m: float, along: int, count: int = 20, dt: float = 0.2) -> Row:
    """Two periods of a standing wave in 2D; velocity Verlet has sin(ω' dt/2) = ω dt/2."""
    solid = Solid(5 / 3, 1.0, m, 2)
    sim, x = periodic_bar(lab, solid, count)
    shape = np.cos(2 * np.pi * x[:, 0] / count)
    omega = frequency(solid, np.array([2 * np.pi / count, 0.0]), along)
    moved = x.copy()
    moved[:, along] += TINY * shape
    sim.commands(f"timestep {number(dt)}").at(moved)
    stride = round(0.2 / omega / dt) or 1
    amplitude = [1.0]
    for _ in range(round(4 * np.pi / omega / dt / stride)):
        sim.commands(f"run {stride} post no")
        u = (sim.atoms("x") - x)[:, along]
        amplitude.append(u @ shape / (TINY * shape @ shape))
    lab.close()
    a = np.array(amplitude)
    middle, sides = a[1:-1], 0.5 * (a[2:] + a[:-2])  # sides = cos(ω dt stride) middle
    got = np.arccos(sides @ middle / (middle @ middle)) / (dt * stride)
    expected = 2 / dt * np.arcsin(0.5 * omega * dt)
    return near(
        f"2D, linear, {NAMES[along]}: frequency of a standing wave of 20 h over two periods",
        got,
        expected,
        rel=1e-6,
        digits=8,
        why="displacements of 1e-6 h with rounding of 1e-15, second order of the displacement",
    )


def draw_dispersion(curves):
    from .plots import panels, plain_log

    figure, axes = panels(2)
    for ax, d in zip(axes, (2, 3), strict=True):
        for (dimension, influence, kind), (length, ratio) in curves.items():
            if dimension == d:
                colour = "C0" if kind == "longitudinal" else "C1"
                style = "-" if influence == "linear" else "--"
                ax.plot(length, ratio, style, color=colour, label=f"{kind}, {influence}")
        ax.axhline(1.0, color="0.4", lw=0.8)
        ax.set(
            xscale="log",
            xlabel="wavelength / h",
            ylabel="phase speed / classical",
            title=f"{d}D, m = 3.015",
        )
        plain_log(ax.xaxis)
    axes[0].legend()
    return figure


# --- a pulse in a bar -------------------------------------------------------------------------

STEEL = {"young": 210e9, "poisson": 0.25, "density": 7850.0}
WIDTH, LENGTH, PERIOD, TOP_SPEED = 2e-3, 0.13, 1e-5, 2.0
BAR_SPEED = np.sqrt(STEEL["young"] / STEEL["density"])


def bar_speed(
    lab: Lab, across: int, times: tuple[float, float]
) -> tuple[float, Array, list[Array]]:
    """Speed of the pulse between two times, and its velocity profiles along the bar."""
    h = WIDTH / across
    count = round(LENGTH / h)
    x = lattice((count, across, across), h) + np.array([0.5 * LENGTH, 0, 0])
    one = cloud(x, volume=h**3, density=STEEL["density"], margin=5 * h)
    k, g = STEEL["young"] / 1.5, STEEL["young"] / 2.5
    solid = Solid(k, g, 3.015 * h)
    sim = lab.simulation().load(one, units="si", skin=0.5 * h)
    sim.commands(solid_script(solid).replace("fix motion all nve", ""))
    dt = 0.5 * h / np.sqrt((k + 4 * g / 3) / STEEL["density"])
    steps = [round(time / dt) for time in (PERIOD, *times)]
    sim.commands(
        f"""
        region end block INF {number(h)} INF INF INF INF units box
        group end region end
        group free subtract all end
        timestep {number(dt)}
        variable w equal {number(2 * np.pi / PERIOD)}
        variable u equal {TOP_SPEED}*(1-cos(v_w*time))/v_w
        variable v equal {TOP_SPEED}*sin(v_w*time)
        variable none equal 0
        fix motion free nve
        fix drive end move variable v_u v_none v_none v_v v_none v_none
        run {steps[0]} post no
        unfix drive
        unfix motion
        fix motion all nve
        """
    )
    profiles, at = [], steps[0]
    for step in steps[1:]:
        sim.commands(f"run {step - at} post no")
        at = step
        profiles.append(sim.atoms("v")[:, 0].reshape(count, -1).mean(axis=1))
    lab.close()
    along = x[:, 0].reshape(count, -1)[:, 0]
    place = [zero_crossing(along, v) for v in profiles]
    return (place[1] - place[0]) / ((steps[2] - steps[1]) * dt), along, profiles


def zero_crossing(x: Array, v: Array) -> float:
    """Where the pulse changes sign, between its negative and its positive half."""
    top, bottom = int(np.argmax(v)), int(np.argmin(v))
    low, high = sorted((top, bottom))
    k = low + int(np.flatnonzero(np.diff(np.sign(v[low : high + 1])))[0])
    return float(x[k] - v[k] * (x[k + 1] - x[k]) / (v[k + 1] - v[k]))


def run_bar(lab: Lab, across: tuple[int, ...]) -> Outcome:
    times = (1.3e-5, 2.1e-5)
    found = {n: bar_speed(lab, n, times) for n in across}
    error = np.array([found[n][0] / BAR_SPEED - 1 for n in across])
    rows: list[Row] = [
        near(
            f"speed of the pulse, {n} nodes across (δ = {3.015 / n:.2f} of the width)",
            found[n][0],
            BAR_SPEED,
            rel=0.25,
            why=(
                "the tolerance of Peridynamics.jl's test for a coarse bar; all nodes are at a "
                "surface"
            ),
        )
        for n in across
    ]
    rows.append(
        below(
            "error with most nodes across, over δ/width",
            abs(error[-1]) * across[-1] / 3.015,
            0.25,
            why="layers a horizon deep at each side are 17, 13 and 0 % too stiff along the bar "
            "(case above), corners more so",
        )
    )
    if len(across) > 2:
        order = -np.polyfit(np.log(across), np.log(np.abs(error)), 1)[0]
        rows.append(
            within(
                "order of the error in δ",
                order,
                0.7,
                2.0,
                why="surface effects go with δ over the width: first order",
            )
        )
    return Outcome(rows, lambda: draw_bar(across, error, found))


def draw_bar(across, error, found):
    from .plots import panels, plain_log

    figure, axes = panels(2)
    _, x, profiles = found[across[-1]]
    for v in profiles:
        axes[0].plot(1e3 * x, v)
    axes[0].set(xlabel="x (mm)", ylabel="velocity (m/s)", title=f"{across[-1]} nodes across")
    axes[1].loglog(across, np.abs(error), "o-")
    axes[1].loglog(across, abs(error[0]) * across[0] / np.array(across), "k:", label="first order")
    axes[1].set(xlabel="nodes across", ylabel="error of the speed")
    plain_log(axes[1].xaxis)
    plain_log(axes[1].yaxis)
    axes[1].legend()
    return figure


# --- a spherical pulse in a cube --------------------------------------------------------------

CENTRE, SPREAD, PEAK, END = 0.25, 0.07, 1e-3, 0.6
CUBE = {"bulk": 1.0, "shear": 0.5, "density": 100.0}
CUBE_SPEED = np.sqrt((CUBE["bulk"] + 4 * CUBE["shear"] / 3) / CUBE["density"])


def start_of_pulse(r: Array) -> Array:
    return PEAK * np.exp(-(((r - CENTRE) / SPREAD) ** 2))


def classical_pulse(r: Array, time: float) -> Array:
    """Radial displacement of u = grad φ, r φ a sum of waves in r + ct and r - ct; at rest at 0."""

    def potential(s: Array) -> Array:
        return PEAK * SPREAD * 0.5 * np.sqrt(np.pi) * (erf((s - CENTRE) / SPREAD) - 1)

    total, slope = 0.0, 0.0
    for s in (r + CUBE_SPEED * time, r - CUBE_SPEED * time):
        total = total + 0.5 * s * potential(np.abs(s))
        slope = slope + 0.5 * (potential(np.abs(s)) + np.abs(s) * start_of_pulse(np.abs(s)))
    return slope / r - total / r**2


def lattice_pulse(r: Array, time: float, solid: Solid, h: float) -> Array:
    """The same with the lattice's own frequencies of longitudinal waves along an axis."""
    count, length = 4096, 4.0  # points and period of the Fourier series of r φ
    s = (np.arange(count) / count - 0.5) * length
    height = np.abs(s)
    start = s * PEAK * SPREAD * 0.5 * np.sqrt(np.pi) * (erf((height - CENTRE) / SPREAD) - 1)
    k = 2 * np.pi * np.fft.rfftfreq(count, length / count)
    inside = k * h < np.pi
    unit = replace(solid, horizon=solid.horizon / h)
    omega = np.array([frequency(unit, np.array([q * h, 0, 0]), 0) for q in k[inside]])
    omega /= h * np.sqrt(CUBE["density"])
    waves = np.zeros(len(k), complex)
    waves[inside] = np.fft.rfft(start)[inside] * np.cos(omega * time)
    total, slope = np.fft.irfft(waves, count), np.fft.irfft(1j * k * waves, count)
    return np.interp(r, s, slope) / r - np.interp(r, s, total) / r**2


def pulse(lab: Lab, count: int, solid: Solid, safety: float | None = None) -> tuple[Array, Array]:
    """Distance from the middle and radial displacement at the end, of all nodes.

    ``safety``: time step over the largest stable one; None: 0.4 h/c, and no fewer than 30 steps.
    """
    h = 1.0 / count
    x = lattice((count,) * 3, h)
    r = np.linalg.norm(x, axis=1)
    outward = x / np.where(r > 0, r, 1.0)[:, None]
    one = cloud(x, volume=h**3, density=CUBE["density"], margin=5 * h)
    one = Cloud(**{**vars(one), "x": x + outward * start_of_pulse(r)[:, None]})
    sim = lab.simulation().load(one, skin=0.5 * h)
    sim.commands(solid_script(solid))
    if safety is None:
        steps = max(30, int(np.ceil(END / (0.4 * h / CUBE_SPEED))))
    else:
        find = f"fix step all peridem/timestep safety {safety} every 1000000"
        sim.commands(f"{find}\nrun 0 post no\nunfix step")
        steps = int(np.ceil(END / sim.thermo("dt")))
    sim.commands(f"timestep {number(END / steps)}\nrun {steps} post no")
    u = np.einsum("na,na->n", sim.atoms("x") - x, outward)
    lab.close()
    return r, u


def run_pulse(lab: Lab, counts: tuple[int, ...]) -> Outcome:
    rows, errors = [], []
    for count in counts:
        solid = Solid(CUBE["bulk"], CUBE["shear"], 3.015 / count)
        r, u = pulse(lab, count, solid)
        keep = (r > 0.1) & (r < 0.45)
        r, u, exact = r[keep], u[keep], classical_pulse(r[keep], END)
        predicted = lattice_pulse(r, END, solid, 1.0 / count)
        errors.append(relative(u, exact))
        rows += [
            shown(
                f"{count}³ nodes: relative L2 difference from the classical solution",
                errors[-1],
                why="δ = 3.015 h; waves of 10 h and shorter are slower than classical ones",
            ),
            below(
                f"{count}³ nodes: the same from the solution with the frequencies of the lattice",
                relative(u, predicted),
                0.05,
                why="frequencies are those along an axis; along diagonals, waves of 10 h are "
                "slower or faster by some 1 %",
            ),
        ]
    peak = float(np.abs(u - exact).max() / np.abs(exact).max())
    rows.append(
        shown(
            f"{counts[-1]}³ nodes: largest difference from the classical solution over the peak",
            peak,
            expected="≤ 0.035",
            why="CabanaPD's tolerance, of a run with 41³ nodes from its own with 81³, not from "
            "the "
            "classical solution",
        )
    )
    order = float(np.log(errors[-2] / errors[-1]) / np.log(counts[-1] / counts[-2]))
    rows.append(
        within(
            f"order of the L2 difference from the classical solution, {counts[-2]}³ to "
            f"{counts[-1]}³",
            order,
            1.5,
            2.5,
            why="second order in δ for smooth fields inside (Bobaru et al. 2009, IJNME 77:852), "
            "less the lattice's own error of the wave speed, 1e-3, which stays at fixed m",
        )
    )
    last = (counts[-1], r, u, predicted)
    return Outcome(rows, lambda: draw_pulse(counts, errors, last))


def relative(got: Array, expected: Array) -> float:
    return float(np.linalg.norm(got - expected) / np.linalg.norm(expected))


def draw_pulse(counts, errors, last):
    from .plots import panels, plain_log

    figure, axes = panels(2)
    count, r, u, predicted = last
    order = np.argsort(r)
    fine = np.linspace(0.1, 0.45, 300)
    axes[0].plot(r, u, ".", ms=1, color="C1", label=f"nodes, {count}³", rasterized=True)
    axes[0].plot(fine, classical_pulse(fine, END), color="C0", label="classical")
    axes[0].plot(
        r[order], predicted[order], "--", color="C2", label="with the lattice's frequencies"
    )
    axes[0].plot(fine, start_of_pulse(fine), ":", color="0.4", label="start")
    axes[0].set(xlabel="r", ylabel="radial displacement")
    axes[0].legend()
    axes[1].loglog(counts, errors, "o-")
    axes[1].loglog(
        counts, errors[0] * (counts[0] / np.array(counts)) ** 2, "k:", label="second order"
    )
    axes[1].set(xlabel="nodes along the cube", ylabel="relative L2 difference")
    plain_log(axes[1].xaxis)
    plain_log(axes[1].yaxis)
    axes[1].legend()
    return figure


CASES = [
    Case(
        name="dispersion",
        title="Dispersion of plane waves along an axis",
        what="Frequencies from the forces of small sinusoidal displacements in endless "
        "lattices, and of a standing wave that "
        "runs for two periods. ν = 1/4.",
        source="`lattices.frequency`: the linearised force of the model summed over one family; "
        "phase speeds beside it were computed "
        "apart from this code. Velocity Verlet: sin(ω'Δt/2) = ωΔt/2.",
        run=run_dispersion,
        small={"counts": (10, 20, 40), "m": 3.015},
        full={"counts": (10, 20, 40), "m": 3.015},
    ),
    Case(
        name="bar",
        title="A pulse in a bar",
        what="A steel bar 2 mm thick (E = 210 GPa, ν = 1/4, ρ = 7850 kg/m³), one end driven by "
        "one period of 2 m/s sin(2πt/10 µs), then free; speed "
        "of the zero between the two halves of the pulse from 13 to 21 µs.",
        source="√(E/ρ); the set-up of Peridynamics.jl's wave_in_bar, whose tolerance is 25 %.",
        run=run_bar,
        small={"across": (3, 4)},
        full={"across": (4, 6, 9)},
    ),
    Case(
        name="pulse",
        title="A spherical pulse in a cube",
        what="A unit cube (K = 1, G = 0.5, ρ = 100) is released with the radial displacement "
        "10⁻³ exp(−((r−0.25)/0.07)²) and compared "
        "with the classical solution at t = 0.6, before waves reach the faces.",
        source=(
            "Spherical waves: u = ∂φ/∂r, rφ = ½[(r+ct)φ₀(r+ct) + (r−ct)φ₀(|r−ct|)], c² = "
            "(K+4G/3)/ρ; the set-up of CabanaPD's elastic wave, whose tolerance is 3.5 %."
        ),
        run=run_pulse,
        small={"counts": (16, 24)},
        full={"counts": (20, 30, 40, 60)},
    ),
]
