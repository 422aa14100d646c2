#!/usr/bin/env python3
"""The compression of 502 grains of Jha et al. 2021 (figure 2a): settle a bed, then press it.

    python compression_502.py --deck input_0.yaml                   PeriDEM's deck, right physics
    python compression_502.py --deck input_0.yaml --as-published    as PeriDEM computes it
    python compression_502.py                                       24 grains, packed here
    python compression_502.py --small                               9 coarser ones, in seconds

Two runs: grains, rigid and with little restitution, fall until they rest; then the lid is put above
the bed and sinks on it. Everything goes to out/compression_502/ (another folder with --output).
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from peridem import cloud, deck, packing, program, render, results, scene, shapes, stages
from peridem.loads import Motion
from peridem.material import Contact, Material

MM = 1e-3
LID = "lid"
# Cracked grains rattle without loss here: contacts that open and close as linear springs would give
# them energy at each step that is merely stable (README). They become stiff over this part of the
# contact distance
ONSET = 0.03
SAFETY = 0.8
AT_REST = 0.03  # m/s, half the speed of the lid: such grains press with half a pascal
# the published curve where it was read off: penetration in mm -> pressure in kPa
PUBLISHED = (
    (0.5e-3, 3e3),
    (0.9e-3, 20e3),
    (1.45e-3, 57e3),
    (1.9e-3, 80e3),
    (2.4e-3, 86e3),
    (3e-3, 93e3),
)


@dataclass(frozen=True)
class Case:
    """A bed of grains and how it is pressed.

    Attributes:
        scene: the grains where they start to fall, the box, the lid.
        lid: number of the grain that the lid is made of (from 1); None: it is a surface.
        settling: time that the grains get to come to rest, s.
        start: height of the lid's lower edge as it starts, m; None: just above the bed.
        speed: of the lid, m/s.
        sinking: for so long, s.
    """

    scene: scene.Scene
    lid: int | None
    settling: float
    start: float | None
    speed: float
    sinking: float


def published(path: Path, as_published: bool) -> Case:
    """The 502 grains of PeriDEM's deck, in the two stages of the paper."""
    read = deck.load(path, as_published)
    print("\n".join(read.report))
    lid = read.grains[-1]  # its last particle
    settling = 0.06 if as_published else 0.075  # s; until they hardly move
    return Case(read.scene, lid, settling, start=31.0 * MM, speed=0.06, sinking=0.09)


def packed(count: int, spacing: float = 0.2 * MM, seed: int = 5) -> Case:
    """Discs and hexagons of the same material, in a box that they fill as in the deck."""
    radius, pitch = 1.0 * MM, 2.3 * MM
    solid = Material(
        name="grain", bulk=21.6e6, poisson=0.25, density=1200.0, horizon=3.05 * spacing, gc=50.0
    )
    outlines = [shapes.circle(radius), shapes.hexagon(radius)]
    random = np.random.default_rng(seed)
    kinds = (random.random(count) < 0.27).astype(int)
    columns = int(np.ceil(np.sqrt(1.65 * count)))
    rows = int(np.ceil(count / columns))
    width, height = pitch * columns + spacing, pitch * rows + 2.0 * spacing
    heap = packing.grid(
        outlines, kinds, (0.0, width, 0.0, height), 1.01 * spacing, jitter=0.5, seed=seed
    )
    walls = scene.box_walls((0.0, 0.0), (width, height), lid_velocity=-0.06)
    one = scene.Scene(
        title=f"{count} discs and hexagons",
        grains=scene.grains_of(heap, [cloud.mesh(o, spacing) for o in outlines], solid),
        contact=Contact(radius=0.95 * spacing, restitution=0.95),
        walls=walls,
        gravity=(0.0, -10.0),
        duration=1.0,
    )
    fall = float(np.sqrt(2.0 * 0.4 * height / 10.0))
    return Case(one, None, settling=2.5 * fall, start=None, speed=0.3, sinking=0.15 * height / 0.3)


# ---- the two stages ------------------------------------------------------------------------------


def settling(case: Case) -> scene.Scene:
    """The grains fall as rigid bodies that hardly bounce; the lid is out of the way."""
    base = case.scene

    def soft(contact: Contact) -> Contact:
        return replace(contact, restitution=0.3)

    return replace(
        base,
        title=f"{base.title}: settling",
        contact=soft(base.contact),
        pairs={pair: soft(contact) for pair, contact in base.pairs.items()},
        walls=[wall for wall in base.walls if wall.name != LID],
        motions=[Motion.held(m.name, m.nodes) for m in base.motions],
        adapt="eta 1e9",  # whatever hits them, they stay rigid
        timestep=None,
        leapfrog=False,
        duration=case.settling,
        frames=100,
        energies=False,
    )


def pressing(
    case: Case, settled: Path, safety: float = SAFETY, onset: float = ONSET
) -> scene.Scene:
    """The bed as it came to rest, the lid above it and sinking."""
    base, grains = case.scene, at_rest(case, settled)
    bed = [g for g in grains if g.material.style]
    top = max(float((g.cloud.nodes + g.displacement)[:, 1].max()) for g in bed)
    start = top + base.contact_radius if case.start is None else case.start
    print(f"top of the bed at {top / MM:.2f} mm, the lid starts at {start / MM:.2f} mm")
    contact, pairs, walls = base.contact, base.pairs, base.walls
    if case.lid is None:
        contact = replace(contact, onset=onset)
        pairs = {pair: replace(one, onset=onset) for pair, one in pairs.items()}
        lid = next(wall for wall in walls if wall.name == LID)
        down = replace(lid, point=(lid.point[0], start), velocity=(0.0, -case.speed))
        walls = [down if wall is lid else wall for wall in walls]
    else:
        # PeriDEM damps grains between their centres, which has no counterpart: as good as no
        # restitution at 0.95, at half the cost
        contact = replace(contact, restitution=1.0)
        nodes = grains[case.lid - 1].cloud.nodes
        lower = np.tile((0.0, start - float(nodes[:, 1].min())), (len(nodes), 1))
        grains[case.lid - 1] = replace(grains[case.lid - 1], displacement=lower)
    return replace(
        base,
        title=f"{base.title}: pressing",
        grains=grains,
        contact=contact,
        pairs=pairs,
        walls=walls,
        leapfrog=False,
        safety=safety,
        duration=case.sinking,
        frames=60,
        records=1200,
        attributes=("fragment",),
    )


def at_rest(case: Case, settled: Path) -> list[scene.Grain]:
    """The grains where they came to rest, which is checked; they start anew, without velocity."""
    grains = stages.grains_after(case.scene, settled)
    free = np.vstack([g.velocity for g in grains if g.material.style and g.velocity is not None])
    speed = float(np.sqrt((free**2).sum(axis=1).mean()))
    print(f"speed of the settled grains: {speed:.2g} m/s")
    if speed > AT_REST:
        print(f"they still move (over {AT_REST:g} m/s): the lid will hit them", file=sys.stderr)
    return [replace(grain, velocity=None) for grain in grains]


# ---- results -------------------------------------------------------------------------------------


def stress(folder: Path, case: Case) -> tuple[np.ndarray, np.ndarray]:
    """Penetration from the lid's first lasting contact, m, and the pressure on it, Pa."""
    if case.lid is None:
        travel, pressure = results.wall_stress(folder, LID)
    else:
        record = results.averages(folder / scene.WALLS)
        name = next(m.name for m in case.scene.motions if (m.velocity[1] or 0.0) < 0.0)
        body = case.scene.grains[case.lid - 1].cloud.nodes
        travel = case.speed * record["v_now"]
        pressure = record[f"f_{name}[2]"] / np.ptp(body[:, 0])
    return results.from_contact(travel, pressure, level=0.005), pressure


def smooth(travel: np.ndarray, pressure: np.ndarray, width: float) -> np.ndarray:
    """Mean over the records within half a width on either side."""
    sums = np.concatenate([[0.0], np.cumsum(pressure)])
    low = np.searchsorted(travel, travel - 0.5 * width)
    high = np.searchsorted(travel, travel + 0.5 * width, side="right")
    return np.asarray((sums[high] - sums[low]) / (high - low))


def measure(folder: Path, case: Case) -> dict[str, float]:
    """The numbers of the pressed bed."""
    output = results.Output(folder)
    travel, pressure = stress(folder, case)
    mean = smooth(travel, pressure, 0.05 * MM)
    found = {"deepest penetration, mm": float(travel[-1]) / MM}
    for depth, _ in PUBLISHED:
        if depth <= travel[-1]:
            found[f"pressure at {depth / MM:g} mm, kPa"] = (
                float(np.interp(depth, travel, mean)) / 1e3
            )
    found["largest pressure, kPa"] = float(mean.max()) / 1e3
    bonded = np.isin(output.frame(-1)["type"], types_with_bonds(case.scene))
    found["mean damage"] = output.mean_damage(-1)
    grain = output.frame(-1)["mol"][bonded].astype(int)
    hurt = np.bincount(grain, output.field("damage", -1)[bonded] > 0.0)
    found["grains with broken bonds"] = float((hurt > 0).sum())
    return found


def types_with_bonds(one: scene.Scene) -> list[int]:
    """Atom types of the materials that have bonds."""
    return [k for k, material in enumerate(one.materials, 1) if material.style]


def plot(folder: Path, case: Case, path: Path) -> None:
    """Pressure against penetration, with the published points."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.0, 4.0), dpi=120, layout="constrained")
    axes = figure.subplots()
    travel, pressure = stress(folder, case)
    axes.plot(travel / MM, pressure / 1e3, color="#9db7d5", lw=0.6, label="averages in time")
    mean = smooth(travel, pressure, 0.05 * MM)
    axes.plot(travel / MM, mean / 1e3, color="#1f4e79", lw=1.4, label="over 0.05 mm")
    if case.start is not None:
        depth, level = np.array(PUBLISHED).T
        axes.plot(depth / MM, level / 1e3, "o", color="#b3261e", ms=5, label="published curve")
    axes.set(
        xlabel="penetration of the lid (mm)", ylabel="pressure on the lid (kPa)", xlim=(0, None)
    )
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
    figure.savefig(path)


def main(arguments: list[str] | None = None) -> int:
    """Settle, press, measure and draw."""
    options = program.options(
        __doc__, "out/compression_502", small="nine coarser grains packed here: seconds"
    )
    options.add_argument("--deck", type=Path, help="PeriDEM's deck of 502 grains")
    options.add_argument("--as-published", action="store_true", help="with PeriDEM's own physics")
    options.add_argument(
        "--safety", type=float, default=SAFETY, help=f"part of the stable step ({SAFETY})"
    )
    options.add_argument(
        "--onset", type=float, default=ONSET, help=f"of contacts, part of their distance ({ONSET})"
    )
    options.add_argument("--grains", type=int, default=24, help="without a deck (24)")
    chosen = options.parse_args(arguments)
    if chosen.as_published and chosen.deck is None:
        options.error("--as-published needs --deck")
    folder: Path = chosen.output
    if chosen.deck:
        case = published(chosen.deck, chosen.as_published)
    else:
        case = packed(9, 0.25 * MM) if chosen.small else packed(chosen.grains)

    first = program.run(settling(case).write(folder / "settled"), chosen)[0]
    pressed = pressing(case, folder / "settled", chosen.safety, chosen.onset)
    second = program.run(pressed.write(folder / "pressed"), chosen)[0]
    found = measure(folder / "pressed", case)
    found["settling, minutes"] = first.wall_time / 60.0
    found["pressing, minutes"] = second.wall_time / 60.0
    (folder / "numbers.json").write_text(json.dumps(found, indent=1) + "\n")
    plot(folder / "pressed", case, folder / "stress.png")
    last = len(results.Dump(folder / "pressed" / scene.DUMP)) - 1
    shown = [round(part * last) for part in (0.25, 0.5, 0.75, 1.0)]
    render.grains_png(folder / "pressed", folder / "grains.png", shown)
    for name, value in found.items():
        print(f"{name:28}{value:12.5g}")
    print(f"In {folder}/: numbers.json, stress.png, grains.png; the runs settled/ and pressed/")
    return 0


if __name__ == "__main__":
    sys.exit(main())
