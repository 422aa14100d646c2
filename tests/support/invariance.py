"""One scene run in many ways that must not matter, and how far the ends lie apart.

Three scenes in which everything happens at once: bonds break, grains and fragments rub, walls
drive.  Ways: numbers of ranks, processor grids, newton on and off, tiled communication, balancing
on the way, a restart half-way.  Every way records the same steps; :func:`differences` compares each
record with that of one rank.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import dedent

import numpy as np

from .clouds import Cloud, join, ragged
from .heaps import REBUILD
from .oracle import Array, Solid
from .runs import MpiRunner, header, lps_words, read_dump

PIECES = 4  # runs of equal length; the restart comes after half of them
COLUMNS = "id mol x y z vx vy vz fx fy fz c_node[1] c_node[2]"


@dataclass(frozen=True)
class Scene:
    """Grains, and the script lines that load them."""

    name: str
    dimension: int
    shape: tuple[int, ...]  # nodes of a grain
    places: tuple[tuple[float, float, float], ...]
    contact: str
    steps: int
    dt: float
    periodic: bool = False
    shear: float = 0.0  # speed of the lid along x
    sink: float = 0.5  # and down

    @property
    def solid(self) -> Solid:
        return Solid(
            bulk=3.0, shear=1.2, horizon=2.3, dimension=self.dimension, s0=0.05, viscosity=0.1
        )

    def grains(self) -> Cloud:
        """Jittered blocks at rest, the upper ones thrown at the lower ones."""
        rng = np.random.default_rng(20100718)
        parts = []
        for k, place in enumerate(self.places):
            part = ragged(rng, self.shape, molecule=k + 1)
            part.reference += place
            part.x = part.reference.copy()
            parts.append(part)
        one = join(*parts, margin=1.5)
        if self.periodic:
            one.periodic = (True, False, False)
            one.box[0] = (one.x[:, 0].min() - 0.55, one.x[:, 0].max() + 0.55)
        else:
            one.box[0] += (-6.0, 6.0)
        one.box[1] += (-0.5, 4.0)
        up = one.x[:, 1] > one.x[:, 1].mean()
        one.v[up, 1] = -0.3
        one.v[:, 0] += 0.2 if self.periodic else 0.05
        return one

    def loads(self, one: Cloud) -> str:
        low, high = one.x[:, 1].min() - 0.98, one.x[:, 1].max() + 0.98
        lines = [
            f"fix floor all peridem/wall plane 0 {low:.12g} 0 0 1 0",
            (
                f"fix lid all peridem/wall plane 0 {high:.12g} 0 0 -1 0 velocity {self.shear} "
                f"{-self.sink} 0"
            ),
            "fix weight all gravity 0.02 vector 0 -1 0",
        ]
        if not self.periodic:
            sides = one.x[:, 0].min() - 1.5, one.x[:, 0].max() + 1.5
            lines += [
                f"region pit block {sides[0]:.12g} {sides[1]:.12g} INF INF INF INF open 3 open 4 "
                "open 5 open 6",
                "fix pit all peridem/wall region pit",
            ]
        return "\n".join(lines)


CRUSH = Scene(
    "crush",
    2,
    (5, 5),
    ((0, 0, 0), (5.2, 0.4, 0), (0.3, 5.2, 0), (5.5, 5.5, 0)),
    "radius 0.95 stiffness 5.0 damping 0.2 friction 0.4",
    200,
    0.02,
)
SHEAR = Scene(
    "shear, periodic",
    2,
    (5, 5),
    ((0, 0, 0), (5.1, 0.1, 0), (0.3, 5.2, 0), (5.3, 5.3, 0)),
    "radius 0.95 stiffness 5.0 restitution 0.5 friction 0.4",
    200,
    0.02,
    periodic=True,
    shear=0.4,
)
BLOCKS = Scene(
    "blocks, 3D",
    3,
    (4, 3, 3),
    ((0, 0, 0), (4.2, 0.1, 0.2), (0.2, 3.3, 0.1)),
    "radius 0.95 stiffness 5.0 restitution 0.6 friction 0.4 tangential regularised",
    120,
    0.02,
)
SCENES = (CRUSH, SHEAR, BLOCKS)


@dataclass(frozen=True)
class Way:
    """How a scene is run."""

    ranks: int = 1
    grid: str = "* * *"
    newton: str = "on"
    tiled: bool = False
    balance: bool = False
    restart: int = 0  # ranks that write the restart half-way, 0 for none

    @property
    def name(self) -> str:
        text = f"{self.ranks} rank{'s' if self.ranks > 1 else ''}"
        if self.restart:
            return f"restart of {self.restart}, read by {text}"
        text += f", grid {self.grid}" if self.grid != "* * *" else ""
        text += ", newton off" if self.newton == "off" else ""
        text += ", tiled" if self.tiled else ""
        return text + (", balanced on the way" if self.balance else "")


ALONE = Way()


def ways(dimension: int) -> list[Way]:
    """All ways but the one that everything is compared with."""
    grids = {1: [], 2: ["2 1 1", "1 2 1"], 4: ["4 1 1", "2 2 1", "1 4 1"]}
    if dimension == 3:
        grids[2].append("1 1 2")
        grids[4] += ["2 1 2", "1 2 2"]
    found = [Way(newton="off")]
    for ranks, some in grids.items():
        found += [Way(ranks, grid, newton) for grid in some for newton in ("on", "off")]
    found += [Way(ranks, tiled=True, newton=n) for ranks in (2, 4) for n in ("on", "off")]
    found += [Way(ranks, tiled=True, balance=True) for ranks in (2, 4)]
    found += [Way(2, "2 1 1", balance=True)]
    found += [Way(readers, restart=writers) for writers in (1, 2, 4) for readers in (1, 2, 4)]
    return found


# --- scripts -------------------------------------------------------------------------------------


def settings(scene: Scene, one: Cloud, fresh: bool) -> str:
    """Styles and loads; ``fresh`` unless they come from a restart file."""
    style = "pair_style hybrid/overlay peridem/lps peridem/contact\n" if fresh else ""
    return (
        style
        + dedent(
            f"""
            pair_coeff * * peridem/lps {lps_words(scene.solid)}
            pair_coeff * * peridem/contact {scene.contact}
            compute books all peridem/energy
            """
        )
        + scene.loads(one)
        + dedent(
            f"""
            {REBUILD}
            fix motion all nve
            compute node all peridem/atom damage bonds
            timestep {scene.dt}
            thermo_style custom step pe ke c_books[8] press
            thermo_modify norm no
            thermo 1000000
            variable energy equal pe+ke
            variable pressure equal press
            """
        )
    )


def record(scene: Scene, name: str, first: int, last: int) -> str:
    """Run the pieces ``first`` to ``last``, writing the state before and after each."""
    walls = " ".join(f"$(f_{wall}[{k}]:%.17g)" for wall in ("floor", "lid") for k in (1, 2, 6, 8))
    numbers = f"$(v_energy:%.17g) $(v_pressure:%.17g) {walls}"
    lines = ["run 0 post no"]
    for piece in range(first, last + 1):
        if piece > first:
            lines.append(f"run {scene.steps // PIECES} post no")
        lines.append(f"write_dump all custom {name}.{piece} {COLUMNS} modify format float %.17g")
        lines.append(f'print "{numbers}" file {name}.{piece}.numbers screen no')
    return "\n".join(lines) + "\n"


def script(scene: Scene, one: Cloud, way: Way, name: str) -> str:
    """Input of one way; its states go to NAME.PIECE, numbers to NAME.PIECE.numbers."""
    head = "clear\n" + header(
        one,
        "grains.data",
        dimension=scene.dimension,
        newton=way.newton,
        extra="" if way.tiled else f"processors {way.grid}",
    )
    if way.tiled:
        head += "comm_style tiled\nbalance 1.0 rcb\n"
    body = settings(scene, one, fresh=True)
    if way.balance:
        body += f"fix even all balance 20 1.0 {'rcb' if way.tiled else 'shift x 10 1.02'}\n"
    return head + body + record(scene, name, 0, PIECES)


def first_half(scene: Scene, one: Cloud, name: str) -> str:
    head = "clear\n" + header(one, "grains.data", dimension=scene.dimension)
    half = PIECES // 2
    text = head + settings(scene, one, fresh=True) + record(scene, name, 0, half)
    return text + f"write_restart {name}.restart\n"


def second_half(scene: Scene, one: Cloud, written: str, name: str) -> str:
    head = f"clear\natom_style peridem\nread_restart {written}.restart\nneighbor 0.3 bin\n"
    return head + settings(scene, one, fresh=False) + record(scene, name, PIECES // 2, PIECES)


def run_all(scene: Scene, mpi: MpiRunner, some: Sequence[Way]) -> dict[Way, str]:
    """Run every way, as few processes as possible; the names of their records."""
    one = scene.grains()
    one.write(mpi.folder / "grains.data")
    names = {way: f"way{k}" for k, way in enumerate(some)}
    for ranks in sorted({way.restart for way in some} - {0}):
        mpi(first_half(scene, one, f"half{ranks}"), ranks)
    for ranks in sorted({way.ranks for way in some}):
        mpi(
            "\n".join(
                second_half(scene, one, f"half{way.restart}", names[way])
                if way.restart
                else script(scene, one, way, names[way])
                for way in some
                if way.ranks == ranks
            ),
            ranks,
        )
    return names


# --- comparison ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Difference:
    """Largest differences from one rank, per piece (0 = first state); NaN where not recorded.

    What a restart has read is compared as it is: positions, velocities and bonds.  Its forces are
    evaluated anew, with velocities of the full step, so they are compared one piece later.
    """

    way: Way
    force: Array  # of the largest force
    motion: Array  # positions and velocities, both of order 1
    bonds: Array  # nodes whose number of intact bonds differs
    energy: Array  # of the largest total energy
    walls: Array  # reaction, torque, work, of the largest


def numbers(folder: Path, name: str, piece: int) -> Array:
    return np.array((folder / f"{name}.{piece}.numbers").read_text().split(), dtype=float)


def differences(
    scene: Scene, mpi: MpiRunner, choose: Callable[[int], list[Way]] = ways
) -> tuple[list[Difference], Array]:
    """Each way against one rank; and the mean damage of one rank, per piece."""
    some = [ALONE, *choose(scene.dimension)]
    names = run_all(scene, mpi, some)
    alone = [read_dump(mpi.folder / f"{names[ALONE]}.{k}")[0] for k in range(PIECES + 1)]
    printed = [numbers(mpi.folder, names[ALONE], k) for k in range(PIECES + 1)]
    span = scene.grains().box[0, 1] - scene.grains().box[0, 0]
    scale = np.abs(np.stack(printed)).max(axis=0)
    damage = np.array([frame["c_node[1]"].mean() for frame in alone])

    found = []
    for way in some[1:]:
        table = np.full((5, PIECES + 1), np.nan)
        first = PIECES // 2 if way.restart else 0
        for k in range(first, PIECES + 1):
            (frame,) = read_dump(mpi.folder / f"{names[way]}.{k}")
            away = frame["x y z"] - alone[k]["x y z"]
            if scene.periodic:
                away[:, 0] -= span * np.round(away[:, 0] / span)
            force = alone[k]["fx fy fz"]
            table[1, k] = max(
                np.abs(away).max(), np.abs(frame["vx vy vz"] - alone[k]["vx vy vz"]).max()
            )
            table[2, k] = (frame["c_node[2]"] != alone[k]["c_node[2]"]).sum()
            if way.restart and k == first:
                continue
            table[0, k] = np.abs(frame["fx fy fz"] - force).max() / np.abs(force).max()
            off = np.abs(numbers(mpi.folder, names[way], k) - printed[k])
            table[3, k] = (off[:2] / scale[:2]).max()
            table[4, k] = (off[2:] / scale[2:].max()).max()
        found.append(Difference(way, *table))
    return found, damage
