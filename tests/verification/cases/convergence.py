"""Equilibrium of solids with known displacements: how the error goes with horizon and spacing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay, Voronoi

from support.clouds import Cloud, cloud
from support.oracle import Array, Solid
from support.runs import solid_script

from .base import Case, Lab, Outcome, Row, below, near, shown, within
from .lattices import classical_moduli, lattice_moduli
from .meshes import cube, plate_with_hole
from .statics import Statics

M = 3.015
UNIT = Solid(5 / 3, 1.0, M, 2)  # lambda = G = 1


# --- displacements with their body forces -----------------------------------------------------


def smooth(x: Array) -> Array:
    """u = (sin πx cos πy, cos πx sin πy / 2)."""
    px, py = np.pi * x[:, 0], np.pi * x[:, 1]
    u = np.zeros_like(x)
    u[:, 0], u[:, 1] = np.sin(px) * np.cos(py), 0.5 * np.cos(px) * np.sin(py)
    return u


def smooth_load(x: Array, moduli: Array) -> Array:
    """The force per volume that holds ``smooth`` in a solid with cubic moduli (C11, C12, C44)."""
    c11, c12, c44 = moduli
    u = smooth(x)
    b = np.zeros_like(x)
    b[:, 0] = np.pi**2 * u[:, 0] * (c11 + 0.5 * c12 + 1.5 * c44)
    b[:, 1] = np.pi**2 * 2 * u[:, 1] * (0.5 * c11 + c12 + 1.5 * c44)
    return b


def quadratic(x: Array) -> Array:
    """u = (x² + y²/2, xy): its force per volume is constant, in peridynamics too."""
    u = np.zeros_like(x)
    u[:, 0], u[:, 1] = x[:, 0] ** 2 + 0.5 * x[:, 1] ** 2, x[:, 0] * x[:, 1]
    return u


def quadratic_load(x: Array, moduli: Array) -> Array:
    c11, c12, c44 = moduli
    b = np.zeros_like(x)
    b[:, 0] = -(2 * c11 + c12 + 2 * c44)
    return b


def linear(x: Array) -> Array:
    u = np.zeros_like(x)
    u[:, 0], u[:, 1] = x[:, 0] + 0.3 * x[:, 1], -0.4 * x[:, 1] + 0.5 * x[:, 0]
    return u


def no_load(x: Array, moduli: Array) -> Array:
    return np.zeros_like(x)


# --- clouds of a square -----------------------------------------------------------------------


@dataclass(frozen=True)
class Square:
    """Nodes of the unit square and of a frame around it, two horizons wide, that is held."""

    one: Cloud
    fixed: Array
    spacing: float


def held_square(x: Array, volume: Array | float, h: float) -> Square:
    one = cloud(x, volume=volume, dimension=2, margin=5 * h)
    inside = np.all((one.x[:, :2] > 0) & (one.x[:, :2] < 1), axis=1)
    return Square(one, ~inside, h)


def lattice_square(h: float, horizon: float) -> Square:
    frame = int(np.ceil(2 * horizon / h))
    count = round(1 / h)
    axis = (np.arange(-frame, count + frame) + 0.5) / count
    x = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    return held_square(x, 1.0 / count**2, h)


def voronoi_volumes(x: Array, otherwise: Array) -> Array:
    """Areas of Voronoi cells; nodes whose cell leaves the cloud keep the area given."""
    cells, volume = Voronoi(x), otherwise.copy()
    low, high = x.min(axis=0), x.max(axis=0)
    for node, region in enumerate(cells.point_region):
        corners = cells.regions[region]
        if -1 in corners or not corners:
            continue
        p = cells.vertices[corners]
        if np.all((p >= low) & (p <= high)):
            a, b = p, np.roll(p, -1, axis=0)
            volume[node] = 0.5 * abs(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))
    return volume


def meshed_square(h: float, horizon: float, volumes: str) -> Square:
    from peridem.cloud import mesh
    from peridem.shapes import rectangle

    side = 1 + 4 * horizon
    made = mesh(rectangle(side, side), h).placed((0.5, 0.5))
    x = np.asarray(made.nodes)
    lumped = np.asarray(made.volumes)
    return held_square(x, lumped if volumes == "lumped" else voronoi_volumes(x, lumped), h)


def jittered_square(h: float, horizon: float, volumes: str) -> Square:
    """A lattice with every node moved by up to 0.25 h along each axis."""
    square = lattice_square(h, horizon)
    x = square.one.reference[:, :2]
    x = x + np.random.default_rng(7).uniform(-0.25 * h, 0.25 * h, x.shape)
    equal = np.full(len(x), h * h)
    if volumes == "equal":
        return held_square(x, equal, h)
    if volumes == "voronoi":
        return held_square(x, voronoi_volumes(x, equal), h)
    triangles = Delaunay(x).simplices
    a, b = (x[triangles[:, k]] - x[triangles[:, 0]] for k in (1, 2))
    area = 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    lumped = np.zeros(len(x))
    np.add.at(lumped, triangles, area[:, None] / 3)
    return held_square(x, lumped, h)


def error(lab: Lab, square: Square, solid: Solid, exact, load, moduli: Array) -> float:
    """Relative L2 error of the displacement of the free nodes, weighted by volume."""
    one = square.one
    statics = Statics(lab, one, solid, square.spacing)
    u = exact(one.reference)
    force = load(one.reference, moduli) * one.volume[:, None]
    found = statics.solve(force, square.fixed, np.where(square.fixed[:, None], u, 0.0))
    lab.close()
    free, weight = ~square.fixed, one.volume[:, None]
    miss = np.sum((weight * (found - u) ** 2)[free])
    return float(np.sqrt(miss / np.sum((weight * u**2)[free])))


def order_of(sizes: Array, errors: Array) -> float:
    """Slope of the last two points on logarithmic axes."""
    return float(np.log(errors[-2] / errors[-1]) / np.log(sizes[-2] / sizes[-1]))


# --- delta- and m-convergence -----------------------------------------------------------------


def run_delta(lab: Lab, counts: tuple[int, ...]) -> Outcome:
    sizes = np.array([1.0 / count for count in counts])
    lattice = lattice_moduli(UNIT)
    curves = {"classical moduli": [], "moduli of the lattice": []}
    for h in sizes:
        solid = Solid(UNIT.bulk, UNIT.shear, M * h, 2)
        square = lattice_square(h, solid.horizon)
        for name, moduli in zip(curves, (classical_moduli(UNIT), lattice), strict=True):
            curves[name].append(error(lab, square, solid, smooth, smooth_load, moduli))
    own = np.array(curves["moduli of the lattice"])
    floor = curves["classical moduli"][-1]
    # the load is that of other moduli: the answer is off by the ratio of the two loads
    ratio = smooth_load(np.array([[0.5, 0.0, 0.0]]), lattice)[0, 0]
    ratio /= smooth_load(np.array([[0.5, 0.0, 0.0]]), classical_moduli(UNIT))[0, 0]
    listed = ", ".join(f"{value:.2e}" for value in own)
    rows = [
        shown(
            f"relative error, δ = {M} h, h = 1/{', 1/'.join(map(str, counts))}",
            listed,
            why="against elasticity with the moduli that this lattice has",
        ),
        within(
            "order in δ at fixed m, against elasticity with the moduli of the lattice",
            order_of(sizes, own),
            1.7,
            2.3,
            why="second order for smooth fields and held frames (Bobaru et al. 2009); the last "
            "two sizes",
        ),
        below(
            "relative error against classical elasticity at the smallest h",
            floor,
            3 * abs(ratio - 1) + own[-1],
            why=f"at fixed m it tends to the error of the lattice's moduli (C11, C12, C44 off by "
            f"{', '.join(f'{v:+.3f}' for v in lattice / classical_moduli(UNIT) - 1)}), not to 0",
        ),
    ]
    return Outcome(rows, lambda: draw_orders(sizes, curves, "h = δ/3.015", 2))


def run_m(lab: Lab, sizes: tuple[int, ...], horizon: float) -> Outcome:
    curves: dict[str, list[float]] = {}
    for influence, taper in (("linear", True), ("constant", True), ("constant", False)):
        name = f"{influence}, {'taper' if taper else 'full'}"
        curves[name] = []
        for m in sizes:
            h = 1.0 / round(m / horizon)
            solid = Solid(
                UNIT.bulk, UNIT.shear, (m + 0.015) * h, 2, influence=influence, taper=taper
            )
            square = lattice_square(h, solid.horizon)
            moduli = classical_moduli(UNIT)
            curves[name].append(error(lab, square, solid, quadratic, quadratic_load, moduli))
    rows: list[Row] = []
    for name, values in curves.items():
        listed = ", ".join(f"{value:.1e}" for value in values)
        rows.append(
            shown(
                f"{name}: relative error, m = {', '.join(map(str, sizes))}",
                listed,
                why="errors of quadrature alone",
            )
        )
        rows.append(
            below(
                f"{name}: error at m = {sizes[-1]} over that at m = {sizes[0]}",
                values[-1] / values[0],
                sizes[0] / sizes[-1],
                why="first order in 1/m at least, irregular where cells at the horizon count with "
                "a weight (Seleson and Littlewood 2018)",
            )
        )
    if len(sizes) > 3:
        rows.append(
            within(
                "linear, taper: order in 1/m, fitted",
                float(-np.polyfit(np.log(sizes), np.log(curves["linear, taper"]), 1)[0]),
                1.5,
                3.5,
                why="second order and more, as the weight goes to 0 at the horizon",
            )
        )
    return Outcome(rows, lambda: draw_orders(1.0 / np.array(sizes), curves, "1/m = h/δ", 1))


def draw_orders(sizes, curves, label, order):
    from .plots import panels, plain_log

    figure, (ax,) = panels(1, width=5.0)
    for (name, values), marker in zip(curves.items(), "os^Dv", strict=False):
        ax.loglog(sizes, values, f"{marker}-", label=name)
    first = max(values[0] for values in curves.values())
    ax.loglog(sizes, first * (np.array(sizes) / sizes[0]) ** order, "k:", label=f"order {order}")
    ax.set(xlabel=label, ylabel="relative L2 error of displacement")
    plain_log(ax.xaxis)
    ax.legend()
    return figure


# --- unstructured clouds ----------------------------------------------------------------------

CLOUDS = {
    "lattice": lambda h, delta: lattice_square(h, delta),
    "gmsh, lumped": lambda h, delta: meshed_square(h, delta, "lumped"),
    "gmsh, Voronoi": lambda h, delta: meshed_square(h, delta, "voronoi"),
    "jittered, lumped": lambda h, delta: jittered_square(h, delta, "lumped"),
    "jittered, Voronoi": lambda h, delta: jittered_square(h, delta, "voronoi"),
    "jittered, equal": lambda h, delta: jittered_square(h, delta, "equal"),
}


def run_clouds(
    lab: Lab, counts: tuple[int, ...], ms: tuple[float, ...], cubes: tuple[int, ...]
) -> Outcome:
    moduli, sizes = classical_moduli(UNIT), np.array([1.0 / count for count in counts])
    curves = {name: [] for name in CLOUDS}
    patch = {name: [] for name in CLOUDS}
    rows: list[Row] = []
    for name, make in CLOUDS.items():
        for h in sizes:
            solid = Solid(UNIT.bulk, UNIT.shear, M * h, 2)
            square = make(h, solid.horizon)
            curves[name].append(error(lab, square, solid, smooth, smooth_load, moduli))
            patch[name].append(error(lab, square, solid, linear, no_load, moduli))
        listed = [", ".join(f"{v:.1e}" for v in values[name]) for values in (patch, curves)]
        where = f"h = 1/{', 1/'.join(map(str, counts))}"
        rows.append(shown(f"{name}: error of a uniform strain, {where}", listed[0], why=f"m = {M}"))
        rows.append(
            shown(f"{name}: error of the smooth displacement, {where}", listed[1], why=f"m = {M}")
        )
        rows.append(
            shown(
                f"{name}: spread of the energy density over the nodes, uniform uniaxial strain",
                scatter_of_energy(lab, square, solid),
                why=f"h = 1/{counts[-1]}, m = {M}",
            )
        )
    h = sizes[0]
    by_m = {name: [] for name in CLOUDS}
    for name, make in CLOUDS.items():
        for m in ms:
            solid = Solid(UNIT.bulk, UNIT.shear, m * h, 2)
            by_m[name].append(error(lab, make(h, solid.horizon), solid, linear, no_load, moduli))
    rows += tetrahedra_rows(lab, cubes)
    rows += cloud_targets(curves, patch)
    return Outcome(rows, lambda: draw_clouds(sizes, curves, patch, ms, by_m), [CLOUD_NOTE])


def scatter_of_energy(lab: Lab, square: Square, solid: Solid) -> float:
    """Relative spread over nodes of the energy density of a uniform uniaxial strain."""
    sim = lab.simulation().load(square.one, dimension=solid.dimension, skin=square.spacing)
    sim.commands(solid_script(solid) + "compute node all peridem/atom energy")
    x = square.one.reference
    energies = []
    for size in (1e-4, -1e-4):
        moved = x.copy()
        moved[:, 0] *= 1 + size
        energies.append(sim.at(moved).compute("node"))
    lab.close()
    inner = ~square.fixed
    density = (np.mean(energies, axis=0) / square.one.volume)[inner]
    return float(np.std(density) / np.mean(density))


def tetrahedra_rows(lab: Lab, counts: tuple[int, ...]) -> list[Row]:
    """The uniform strain in 3D: a tetrahedral mesh of gmsh."""
    rows, errors, spread = [], [], 0.0
    for count in counts:
        h = 1.0 / count
        x, volume = cube(1 + 4 * M * h, h)
        one = cloud(x, volume=volume, margin=5 * h)
        square = Square(one, np.abs(x).max(axis=1) > 0.5, h)
        solid = Solid(UNIT.bulk, UNIT.shear, M * h)
        errors.append(error(lab, square, solid, linear, no_load, classical_moduli(UNIT)))
        spread = scatter_of_energy(lab, square, solid)
    sizes = f"h = 1/{', 1/'.join(map(str, counts))}"
    rows.append(
        below(
            f"gmsh tetrahedra, lumped: error of a uniform strain over h, {sizes}, largest",
            max(e * count for e, count in zip(errors, counts, strict=True)),
            0.2,
            why="first order in h; jittered lattices have 0.1 h",
        )
    )
    rows.append(
        shown(
            "gmsh tetrahedra, lumped: spread of the energy density over the nodes, uniform "
            "uniaxial strain",
            spread,
            why=f"h = 1/{counts[-1]}, m = {M}; lumped volumes of tetrahedra vary by a factor of 2",
        )
    )
    return rows


def cloud_targets(curves, patch) -> list[Row]:
    return [
        below(
            "lattice: error of a uniform strain",
            patch["lattice"][-1],
            1e-6,
            why="exact but for the tolerance of the solver, 1e-8 of the residual",
        ),
        below(
            "gmsh, lumped: error of a uniform strain, smallest h",
            patch["gmsh, lumped"][-1],
            0.01,
            why="what irregular cells may add: the size of the lattice's own error (2 %)",
        ),
        below(
            "gmsh: what Voronoi volumes change of the error, largest over the sizes",
            max(
                abs(a - b)
                for a, b in zip(curves["gmsh, lumped"], curves["gmsh, Voronoi"], strict=True)
            ),
            0.01,
            why="if more, the volume scheme would matter",
        ),
    ]


CLOUD_NOTE = (
    "Nodes of a mesh add little: displacements on gmsh clouds are as good as on lattices, and "
    "better at small h, since the nearly equilateral cells have no preferred axes and so less "
    "of an "
    "error of the moduli. How volumes are found does not matter there (lumped or Voronoi). On "
    "lattices with nodes moved at random, worse clouds than gmsh makes, errors are first order "
    "in h, "
    "and equal volumes for all nodes double them. Larger m makes both smaller."
)


def draw_clouds(sizes, curves, patch, ms, by_m):
    from .plots import panels, plain_log

    figure, axes = panels(3, width=3.9, height=3.4)
    for name, marker in zip(CLOUDS, "os^Dv*", strict=True):
        axes[0].loglog(sizes, curves[name], f"{marker}-", label=name)
        if name != "lattice":
            axes[1].loglog(sizes, patch[name], f"{marker}-", color=f"C{list(CLOUDS).index(name)}")
            axes[2].loglog(ms, by_m[name], f"{marker}-", color=f"C{list(CLOUDS).index(name)}")
    axes[0].set(xlabel="h", ylabel="relative L2 error", title="smooth displacement, m = 3.015")
    axes[1].set(xlabel="h", title="uniform strain, m = 3.015")
    axes[2].set(xlabel="m = δ/h", title=f"uniform strain, h = 1/{round(1 / sizes[0])}")
    for ax in axes:
        plain_log(ax.xaxis)
    axes[0].legend()
    return figure


# --- a plate with a hole ----------------------------------------------------------------------

PLATE = Solid(5 / 3, 1.0, M, 2, plane="stress")
YOUNG, KAPPA = 2.5, (3 - 0.25) / (1 + 0.25)
HALF = 5.0  # of the plate, over the radius of the hole


def kirsch(x: Array, stress: float = 1.0) -> Array:
    """Displacement of an endless plate with a hole of radius 1, pulled along x."""
    r, t = np.hypot(x[:, 0], x[:, 1]), np.arctan2(x[:, 1], x[:, 0])
    u = np.zeros_like(x)
    size = stress / (8 * PLATE.shear)
    u[:, 0] = r * (KAPPA + 1) * np.cos(t) - 2 / r**3 * np.cos(3 * t)
    u[:, 0] += 2 / r * ((1 + KAPPA) * np.cos(t) + np.cos(3 * t))
    u[:, 1] = r * (KAPPA - 3) * np.sin(t) - 2 / r**3 * np.sin(3 * t)
    u[:, 1] += 2 / r * ((1 - KAPPA) * np.sin(t) + np.sin(3 * t))
    return size * u


def far_field(x: Array, stress: float = 1.0) -> Array:
    """Displacement of the same plate without its hole."""
    u = np.zeros_like(x)
    u[:, 0], u[:, 1] = (KAPPA + 1) * x[:, 0], (KAPPA - 3) * x[:, 1]
    return stress / (8 * PLATE.shear) * u


def ligament(y: Array) -> Array:
    """sigma_xx on the line x = 0, over the far stress."""
    return 1 + 0.5 / y**2 + 1.5 / y**4


def lattice_plate(h: float) -> tuple[Array, Array]:
    count = round(2 * HALF / h)
    axis = (np.arange(count) + 0.5) * h - HALF
    x = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    x = x[np.hypot(*x.T) > 1.0]
    return x, np.full(len(x), h * h)


@dataclass(frozen=True)
class Plate:
    """What a plate with a hole did: along x = 0, and how much its hole grew."""

    y: Array
    stress: Array
    edge: float  # growth of the hole along the load over the classical one
    error: float  # relative L2 error of displacement
    error_of_hole: float  # the same, relative to what the hole adds to the displacement


def pulled_plate(lab: Lab, h: float, kind: str, solid: Solid | None = None) -> Plate:
    """``solid``: with PLATE's moduli; None: with a horizon of M spacings."""
    x, volume = lattice_plate(h) if kind == "lattice" else plate_with_hole(HALF, h)
    one = cloud(x, volume=volume, dimension=2, margin=5 * h)
    solid = solid or Solid(PLATE.bulk, PLATE.shear, M * h, 2, plane="stress")
    statics = Statics(lab, one, solid, h, extra="compute node all peridem/atom sxx syy")
    exact = kirsch(one.reference)
    fixed = np.abs(one.reference[:, :2]).max(axis=1) > HALF - 2 * solid.horizon
    u = statics.solve(np.zeros_like(exact), fixed, np.where(fixed[:, None], exact, 0.0), 1e-6)
    sxx = statics.compute("node", u)[:, 0]
    lab.close()
    # nodes within one spacing of the line x = 0, in bins of a spacing
    near_line = (np.abs(x[:, 0]) < 0.75 * h) & (np.abs(x[:, 1]) < HALF - 2 * solid.horizon)
    y = np.hypot(*x[near_line].T)
    order = np.argsort(y)
    # the hole's ends on the x axis
    ends = (np.abs(x[:, 1]) < 0.15) & (np.hypot(*x.T) < 1 + 1.01 * h)
    grown = float(np.sum(u[ends, 0] * x[ends, 0]) / np.sum(exact[ends, 0] * x[ends, 0]))
    inside = ~fixed
    miss = np.sum((volume[:, None] * (u - exact) ** 2)[inside])
    sizes = (
        np.sum((volume[:, None] * field**2)[inside])
        for field in (exact, exact - far_field(one.reference))
    )
    errors = (float(np.sqrt(miss / size)) for size in sizes)
    return Plate(y[order], sxx[near_line][order], grown, *errors)


def plate_rows(name: str, n: int, plate: Plate) -> list[Row]:
    edge = 1 + M / n
    deep = (plate.y > edge) & (plate.y < 3)
    top = int(np.argmax(plate.stress))
    return [
        near(
            f"{name}: growth of the hole over Kirsch's",
            plate.edge,
            1.0,
            abs=0.2 * M / n,
            why="0.2 δ/a: layers at the free edge are 20 % too stiff along it (surface case)",
        ),
        below(
            f"{name}: largest difference of the stress from Kirsch's a horizon and more from "
            f"the edge",
            float(np.abs(plate.stress - ligament(plate.y))[deep].max()),
            1.0 / n + 0.03,
            why="h times the gradient there, 1 to 2 far stresses per radius; the lattice's moduli",
        ),
        shown(
            f"{name}: largest stress, over the far stress",
            float(plate.stress[top]),
            expected=float(ligament(plate.y[top])),
            why=f"Kirsch at that node, y = {plate.y[top]:.3f} a; stresses of families that the "
            f"edge "
            "cuts are no measure of the classical stress",
        ),
    ]


def run_hole(lab: Lab, sizes: tuple[int, ...]) -> Outcome:
    rows: list[Row] = []
    found = {kind: [pulled_plate(lab, 1 / n, kind) for n in sizes] for kind in ("lattice", "gmsh")}
    for kind, plates in found.items():
        for n, plate in zip(sizes, plates, strict=True):
            rows += plate_rows(f"{kind}, radius {n} h", n, plate)
        if len(sizes) > 1:
            errors = np.array([plate.error for plate in plates])
            rows.append(
                within(
                    f"{kind}: order of the displacement error in δ, {sizes[-2]} to {sizes[-1]} "
                    f"h a radius",
                    order_of(1 / np.array(sizes, float), errors),
                    0.7,
                    2.2,
                    why="first order where free surfaces dominate, second inside",
                    missed=""
                    if kind == "gmsh"
                    else "the edge is a stair, and the error of the lattice's moduli (1 %) stays",
                )
            )
            listed = ", ".join(f"{value:.1e}" for value in errors)
            rows.append(
                shown(f"{kind}: relative L2 error of displacement", listed, why="δ = 3.015 h")
            )
    return Outcome(rows, lambda: draw_hole(found, sizes))


def draw_hole(found, sizes):
    from .plots import panels, plain_log

    figure, axes = panels(3, width=3.9, height=3.4)
    fine = np.linspace(1, 4, 300)
    for ax, (kind, plates) in zip(axes, found.items(), strict=False):
        for n, plate in zip(sizes, plates, strict=True):
            ax.plot(plate.y, plate.stress, ".-", lw=0.7, ms=3, label=f"a = {n} h")
        ax.plot(fine, ligament(fine), "k", lw=1, label="Kirsch")
        ax.set(xlim=(0.95, 3), xlabel="y / a", ylabel="σxx / far stress", title=kind)
        ax.legend()
        axes[2].loglog(1 / np.array(sizes), [plate.error for plate in plates], "o-", label=kind)
    axes[2].set(xlabel="h / a", ylabel="relative L2 error of displacement")
    plain_log(axes[2].xaxis)
    axes[2].legend()
    return figure


CASES = [
    Case(
        name="delta-convergence",
        title="δ-convergence at fixed m",
        what="The unit square with the displacement (sin πx cos πy, cos πx sin πy / 2) held on "
        "a frame two horizons wide and under "
        "the body force that belongs to it; LAMMPS computes forces, conjugate gradients solve. "
        "Plane strain, ν = 1/4, δ = 3.015 h.",
        source="Manufactured solution; b = −div σ(u). Orders: Bobaru et al. 2009, IJNME 77:852.",
        run=run_delta,
        small={"counts": (10, 20)},
        full={"counts": (10, 20, 40, 80)},
    ),
    Case(
        name="m-convergence",
        title="m-convergence at fixed δ",
        what="The same with (x² + y²/2, xy), of which the peridynamic operator gives the "
        "classical force exactly for any δ: what is left is "
        "the quadrature over families.",
        source="Third moments of a ball vanish, so L u = Navier's operator for quadratic u. "
        "Orders: Seleson and Littlewood 2018.",
        run=run_m,
        small={"sizes": (2, 3, 4), "horizon": 0.2},
        full={"sizes": (2, 3, 4, 6, 8, 12), "horizon": 0.2},
    ),
    Case(
        name="clouds",
        title="Unstructured clouds: gmsh meshes, jittered lattices, lumped and Voronoi volumes",
        what="The square again, on lattices, on meshes as grains have them, and on lattices "
        "with every node moved by up to h/4: "
        "how much error do irregular nodes add, and does it matter how volumes are found?",
        source="Manufactured solutions as above; a uniform strain needs no body force.",
        run=run_clouds,
        small={"counts": (10, 20), "ms": (2.015, 3.015), "cubes": (5,)},
        full={"counts": (12, 24, 48, 96), "ms": (2.015, 3.015, 4.015, 6.015), "cubes": (6, 12)},
    ),
    Case(
        name="hole",
        title="A plate with a hole",
        what="Plane stress, the displacement of Kirsch's solution held on a frame two horizons "
        "wide, 5 radii from the hole; the "
        "edge of the hole is free. Stress is that of compute peridem/atom.",
        source="Kirsch's solution: σxx(0, y) = 1 + a²/2y² + 3a⁴/2y⁴, stress concentration 3 "
        "(Timoshenko and Goodier, Theory of Elasticity).",
        run=run_hole,
        small={"sizes": (6,)},
        full={"sizes": (6, 12, 24)},
    ),
]
