"""The collisions of the paper that the project starts from: two grains, with and without loss."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from support.clouds import Cloud, cloud, join
from support.oracle import Array
from support.runs import Simulation, number

from .base import Case, Lab, Outcome, Row, above, below, near, shown, within
from .contact import advance, centre_velocity, even_radius, momentum
from .fracture import book_page

MM = 1e-3
GRAVITY, DENSITY, GAP = 10.0, 1200.0, 0.05 * MM
START = float(np.sqrt(2 * GRAVITY * 0.4 * MM))  # of the paper's upper disc, 0.089 m/s
STIFF, SOFT = 2.16e7, 2.16e6  # bulk moduli; nu = 1/4
LOOKS = 200
CONTACT = 0.6e-3  # time after the fall: some times that of a contact of the soft grains


@dataclass(frozen=True)
class Grain:
    """What a grain is: shape, radius of the circle around it, bulk modulus, how it is turned."""

    shape: str = "circle"
    radius: float = 1 * MM
    bulk: float = STIFF
    angle: float = 0.0

    def cloud(self, h: float, molecule: int) -> Cloud:
        from peridem import shapes
        from peridem.cloud import mesh

        radius = self.radius
        if self.shape == "circle":  # with nodes at its top and its bottom
            radius = h * even_radius(radius / h)
        made = mesh(getattr(shapes, self.shape)(radius), h).placed(angle=self.angle)
        return cloud(
            np.asarray(made.nodes),
            volume=np.asarray(made.volumes),
            molecule=molecule,
            types=molecule,
            density=DENSITY,
            dimension=2,
        )


@dataclass(frozen=True)
class Scene:
    """Two grains; the lower one (None: a floor) is held, or free and without gravity."""

    lower: Grain | None
    upper: Grain
    held: bool = True

    @property
    def kind(self) -> int:
        """Molecule-ID and type of the upper grain."""
        return 1 if self.lower is None else 2

    @property
    def hit(self) -> float:
        """Speed at which they meet."""
        return float(np.sqrt(START**2 + 2 * GRAVITY * GAP)) if self.held else START


SCENES = {
    "disc on a held disc": Scene(Grain(), Grain()),
    "disc of half the radius on a held disc": Scene(Grain(), Grain(radius=0.5 * MM)),
    "soft disc on a held stiff disc": Scene(Grain(), Grain(bulk=SOFT)),
    "disc on a floor": Scene(None, Grain()),
    "drum on a floor": Scene(None, Grain("drum", angle=0.3)),
    "two free discs": Scene(Grain(), Grain(), held=False),
    "free discs of different radius and material": Scene(
        Grain(), Grain(radius=0.6 * MM, bulk=SOFT), held=False
    ),
    "free concave drum and hexagon": Scene(
        Grain("hexagon", angle=0.2), Grain("drum", angle=0.4), held=False
    ),
}
CENTRAL = [name for name in SCENES if "drum" not in name]


def height_above(lower: Cloud | None, upper: Cloud, reach: float) -> float:
    """Height from where on nodes are ``reach`` and more apart; discs then touch tip to tip."""
    if lower is None:
        return float(-upper.x[:, 1].min())
    across = np.abs(upper.x[:, None, 0] - lower.x[None, :, 0])
    rise = np.sqrt(np.maximum(reach**2 - across**2, 0.0))
    needed = lower.x[None, :, 1] - upper.x[:, None, 1] + rise
    return float(needed[across < reach].max()) - reach


def set_up(lab: Lab, scene: Scene, h: float, contact: str) -> tuple[Cloud, Simulation]:
    """The upper grain a gap above the other, moving down; nodes about ``h`` apart."""
    reach = 0.75 * h  # below the smallest spacing of all these meshes
    lower = None if scene.lower is None else scene.lower.cloud(h, 1)
    upper = scene.upper.cloud(h, scene.kind)
    upper.x[:, 1] += reach + GAP + height_above(lower, upper, reach)
    upper.reference = upper.x.copy()
    upper.v[:, 1] = -START
    one = upper if lower is None else join(lower, upper)
    one.box = np.array([[-20 * MM, 20 * MM], [-20 * MM, 20 * MM], [-0.5, 0.5]])
    sim = lab.simulation().load(one, dimension=2, units="si", skin=0.3 * h)
    solids = [
        f"pair_coeff {k} {k} peridem/lps bulk {number(grain.bulk)} poisson 0.25 gc 50 &\n"
        f"horizon {number(3 * h)}"
        for k, grain in enumerate([scene.lower, scene.upper][-scene.kind :], 1)
    ]
    lines = [
        "neigh_modify every 1 delay 0 check yes",
        f"group upper type {scene.kind}",
        f"group moving type {scene.kind if scene.held else '1 2'}",
        "pair_style hybrid/overlay peridem/lps peridem/contact",
        *solids,
        f"pair_coeff * * peridem/contact radius {number(reach)} {contact}",
        "" if scene.lower else "fix floor all peridem/wall plane 0 0 0 0 1 0",
        f"fix weight upper gravity {GRAVITY} vector 0 -1 0" if scene.held else "",
        "fix motion moving nve",
        "compute books all peridem/energy",
        "compute damage all peridem/atom damage",
        "thermo_style custom step time ke pe c_books[*]",
        "fix step all peridem/timestep safety 0.25 every 1000000",
        "run 0 post no",
        "unfix step",
    ]
    return one, sim.commands("\n".join(lines))


@dataclass(frozen=True)
class Hit:
    """Speeds of the two centres over time (t, upper y, lower y), energies over that at the "
    "start."""

    speed: Array
    drift: float
    lost: float
    stored: float
    damage: float
    momentum: float
    hit: float

    @property
    def ratio(self) -> float:
        """Speed of parting over that of approach."""
        apart = self.speed[:, 1] - self.speed[:, 2]
        return float(apart.max() / self.hit)


def collide(lab: Lab, scene: Scene, h: float, contact: str) -> Hit:
    one, sim = set_up(lab, scene, h, contact)
    energy, before = sim.thermo("ke"), momentum(one, sim)
    until = GAP / (0.5 * (START + scene.hit)) + CONTACT
    rows, pages = [], []
    for _ in range(LOOKS):
        advance(sim, until / LOOKS)
        lower = 0.0 if scene.held else centre_velocity(one, sim, 1)[1]
        rows.append((sim.thermo("time"), centre_velocity(one, sim, scene.kind)[1], lower))
        pages.append(book_page(sim))
    page = np.array(pages) / energy
    found = Hit(
        speed=np.array(rows),
        drift=float(np.abs(page[:, 7]).max()),
        lost=float(page[-1, 3] + page[-1, 4]),
        stored=float(page[:, 1].max()),
        damage=float(sim.compute("damage").max()),
        momentum=float(np.abs(momentum(one, sim) - before).max() / np.abs(before).max()),
        hit=scene.hit,
    )
    lab.close()
    return found


def scene_rows(name: str, scene: Scene, free: Hit, lossy: Hit) -> list[Row]:
    rows = [
        below(
            f"{name}, no loss: drift of the energy over that at the start",
            free.drift,
            2e-3,
            why="second order in the step: at a quarter of the largest, (ωΔt)²/8 is 0.03 of what "
            "the stiffest springs of contact hold",
        ),
        below(f"{name}, restitution 0.7: drift", lossy.drift, 2e-3, why="the same"),
        above(
            f"{name}: energy of contact at its largest over the kinetic energy",
            free.stored,
            1e-3,
            why="they meet",
        ),
    ]
    if scene.held:
        meeting = near(
            f"{name}: speed at which it meets (m/s)",
            -float(free.speed[:, 1].min()),
            scene.hit,
            rel=5e-3,
            why="free fall, seen at looks 1/200 of the time apart",
        )
    else:
        meeting = below(
            f"{name}: relative change of momentum",
            max(free.momentum, lossy.momentum),
            1e-11,
            why="rounding of some ten thousand steps",
        )
    return [*rows, meeting, *parting_rows(name, free, lossy)]


def parting_rows(name: str, free: Hit, lossy: Hit) -> list[Row]:
    if name not in CENTRAL:
        return [
            shown(
                f"{name}: speed of parting over approach, no loss, and with restitution 0.7",
                f"{free.ratio:.2f}, {lossy.ratio:.2f}",
                why="off centre: the rest is spin",
            )
        ]
    return [
        within(
            f"{name}, no loss: speed of parting over approach",
            free.ratio,
            0.9,
            1.0,
            why="what vibration keeps: a few per cent, more in a soft grain",
        ),
        near(
            f"{name}, restitution 0.7: speed of parting over approach",
            lossy.ratio,
            0.7,
            abs=0.05,
            why="as for discs in the restitution case",
        ),
    ]


def run_seeds(lab: Lab, spacing: float, names: tuple[str, ...]) -> Outcome:
    rows: list[Row] = []
    curves, broken = {}, 0.0
    for name in names or SCENES:
        scene = SCENES[name]
        free = collide(lab, scene, spacing * MM, "restitution 1")
        lossy = collide(lab, scene, spacing * MM, "restitution 0.7")
        rows += scene_rows(name, scene, free, lossy)
        curves[name] = (free, lossy)
        broken = max(broken, free.damage, lossy.damage)
    rows.append(
        below(
            "largest damage of any node",
            broken,
            0.0,
            why="collisions at 0.1 m/s break nothing at Gc = 50 J/m²",
        )
    )
    return Outcome(rows, lambda: draw_seeds(curves))


def draw_seeds(curves):
    from .plots import panels

    figure, axes = panels(2, width=4.8, height=3.8)
    for k, (name, hits) in enumerate(curves.items()):
        for ax, hit in zip(axes, hits, strict=True):
            apart = (hit.speed[:, 1] - hit.speed[:, 2]) / hit.hit
            ax.plot(1e3 * hit.speed[:, 0], apart, color=f"C{k}" if k < 7 else "k", label=name)
    for ax, e in zip(axes, (1.0, 0.7), strict=True):
        ax.axhline(e, color="0.5", ls=":", lw=0.8)
        ax.set(xlabel="time (ms)", ylabel="relative speed / that of approach")
        ax.set_title(f"restitution {e:g}")
    axes[0].legend(fontsize=6.5)
    return figure


CASES = [
    Case(
        name="two-grains",
        title="Two grains",
        what="Grains of 1 mm (K = 21.6 MPa, ν = 1/4, ρ = 1200 kg/m³, Gc = 50 J/m²; the soft "
        "ones a tenth of K) meet at 0.09 m/s: "
        "on a held disc or a floor under gravity, or free and without; plane strain, "
        "δ = 3 h, gmsh clouds, no friction.",
        source="The scenes of Jha et al. 2021, J. Mech. Phys. Solids 151:104376, section 4.1, "
        "with restitution as asked for; node by node "
        "against the PeriDEM library: `tests/verification/test_two_discs.py`.",
        run=run_seeds,
        small={"spacing": 0.32, "names": ("disc on a held disc", "free concave drum and hexagon")},
        full={"spacing": 0.2, "names": ()},
    ),
]
