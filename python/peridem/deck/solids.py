"""Materials of a deck as those of a scene: with right physics, or as PeriDEM computes them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from peridem.deck.source import Block, Report
from peridem.material import BondMaterial, Influence, Material, Plane, Potential, Solid

TYPES = ("PDState", "PMBBond", "PDElasticBond", "RNPBond")
GAUSSIAN_WIDTH = 0.2  # PeriDEM's default


@dataclass(frozen=True)
class Weight:
    """An influence function: its name here, and the factor a0 before it there."""

    influence: Influence
    width: float
    factor: float

    def moment(self, power: int) -> float:
        """Integral of a0 w(q) q^power over 0..1."""
        plain = Material(1.0, 0.25, 1.0, 1.0, influence=self.influence, width=self.width)
        return self.factor * plain.moment(power)


@dataclass(frozen=True)
class SolidSpec:
    """The material of one zone as the deck has it.

    Attributes:
        kind: one of ``TYPES``.
        name: of the zone.
        density: mass per volume.
        horizon: absolute, or None.
        ratio: else, horizon over node spacing.
        young, bulk, shear, poisson: what is given or follows; poisson is 1/4 for bonds.
        gc, kic: critical energy release rate, stress intensity; None if not given.
        values: parameters of the bond potential, where moduli are not used.
        weight: influence function.
        plane: of a 2D run with right physics.
        block: for messages.
    """

    kind: str
    name: str
    density: float
    horizon: float | None
    ratio: float | None
    young: float
    bulk: float
    poisson: float
    gc: float | None
    kic: float | None
    values: tuple[float, ...]
    weight: Weight
    plane: Plane
    block: Block

    @property
    def shear(self) -> float:
        """Shear modulus."""
        return self.young / (2.0 * (1.0 + self.poisson))

    def horizon_of(self, spacing: float) -> float:
        """Horizon of a particle with the given smallest node spacing."""
        return self.horizon if self.horizon is not None else float(self.ratio or 0.0) * spacing


def specs(root: Block, count: int, dimension: int, report: Report) -> list[SolidSpec]:
    """The section ``Material``, zone by zone."""
    section = root.block("Material")
    found: list[SolidSpec] = []
    for number in range(1, count + 1):
        key = f"Zone_{number}"
        block = section.part(key, count == 1 and "Type" in section)
        if key not in section and block is not section:
            raise section.missing(key, f"the material of zone {number}")
        if "Copy_Material_Data" in block:
            source = block.whole("Copy_Material_Data")
            if not 1 <= source < number:
                raise block.error("Copy_Material_Data", f"a zone before {number} needed")
            found.append(replace(found[source - 1], name=f"zone_{number}"))
        else:
            found.append(_spec(block, f"zone_{number}", dimension, report))
    return _one_plane(found, report)


def _one_plane(found: list[SolidSpec], report: Report) -> list[SolidSpec]:
    """The same with one plane for all zones: what the first one says that says something."""
    said = [spec for spec in found if "Is_Plane_Strain" in spec.block]
    for spec in said:
        if spec.plane != said[0].plane:
            report.add(
                spec.block.place("Is_Plane_Strain"),
                f"not that of {said[0].name}: all zones have one, plane {said[0].plane}",
            )
    return [replace(spec, plane=said[0].plane) for spec in found] if said else found


def _spec(block: Block, name: str, dimension: int, report: Report) -> SolidSpec:
    kind = block.choice("Type", TYPES)
    classical = block.flag("Compute_From_Classical", True)
    potential = block.block("Bond_Potential")
    values = tuple(potential.numbers("Parameters"))
    potential.skip("Type")
    for key in potential.skip("Check_Sc_Factor", "Irreversible_Bond_Fracture"):
        report.add(potential.place(key), "no counterpart: broken bonds stay broken, at s0")
    for key in block.skip("State_Potential"):
        report.add(block.place(key), "no counterpart, in PeriDEM neither")
    if classical:
        young, bulk, poisson = _moduli(block, kind, report)
        values = ()
    else:
        needed = {"PDState": 3, "PMBBond": 2, "PDElasticBond": 1, "RNPBond": 2}[kind]
        if len(values) < needed:
            raise potential.error("Parameters", f"{kind} has {needed} of them, not {len(values)}")
        young, bulk, poisson = _given_moduli(kind, values)
    gc, kic = _toughness(block, kind, classical, report)
    plane: Plane = "strain"
    if "Is_Plane_Strain" in block and dimension == 2:
        plane = "strain" if block.flag("Is_Plane_Strain") else "stress"
        report.add(block.place("Is_Plane_Strain"), f"plane {plane}; in PeriDEM it changes nothing")
    horizon = block.positive("Horizon") if "Horizon" in block else None
    ratio = block.positive("Horizon_Mesh_Ratio") if "Horizon_Mesh_Ratio" in block else None
    if horizon is None and ratio is None:
        raise block.missing("Horizon", "or Horizon_Mesh_Ratio is needed")
    return SolidSpec(
        kind,
        name,
        block.positive("Density"),
        horizon,
        ratio,
        young,
        bulk,
        poisson,
        gc,
        kic,
        values,
        _weight(block, dimension, report),
        plane,
        block,
    )


def _moduli(block: Block, kind: str, report: Report) -> tuple[float, float, float]:
    """Young's modulus, bulk modulus and Poisson's ratio."""
    known = {key: block.positive(key) for key in ("E", "K", "G", "Poisson_Ratio") if key in block}
    if "Mu" in block:
        known.setdefault("G", block.positive("Mu"))
    for key in block.skip("Lambda"):
        report.add(block.place(key), "not used: two other moduli are needed")
    if kind != "PDState":
        for key in ("G", "Poisson_Ratio"):
            if known.pop(key, None) is not None and key in block:
                report.add(block.place(key), "not used: bonds alone fix Poisson's ratio")
        if not known:
            raise block.missing("K", "E or K is needed")
        if len(known) == 2:
            report.add(block.place("K"), "not used: E is given")
        young = known.get("E", 1.5 * known.get("K", 0.0))
        return young, young / 1.5, 0.25
    if len(known) < 2:
        given = ", ".join(known) or "none"
        raise block.missing("K", f"two of E, K, G, Poisson_Ratio are needed, there is {given}")
    if len(known) > 2:
        used = [key for key in ("K", "G", "E", "Poisson_Ratio") if key in known][:2]
        report.add(block.place(), f"{len(known)} moduli, which PeriDEM refuses; {used} are used")
        known = {key: known[key] for key in used}
    young, bulk, poisson = _elastic(known)
    if not -1.0 < poisson < 0.5:
        raise block.error(
            next(iter(known)), f"Poisson's ratio would be {poisson:.4g}: it must lie in (-1, 1/2)"
        )
    return young, bulk, poisson


def _elastic(known: dict[str, float]) -> tuple[float, float, float]:
    """Young's modulus, bulk modulus and Poisson's ratio from any two moduli."""
    e, k, g, nu = (known.get(key) for key in ("E", "K", "G", "Poisson_Ratio"))
    if k is not None and g is not None:
        nu = (3.0 * k - 2.0 * g) / (2.0 * (3.0 * k + g))
        return 9.0 * k * g / (3.0 * k + g), k, nu
    if e is not None and k is not None:
        nu = (3.0 * k - e) / (6.0 * k)
    elif e is not None and g is not None:
        nu = 0.5 * e / g - 1.0
    elif g is not None and nu is not None:
        e = 2.0 * g * (1.0 + nu)
    elif k is not None and nu is not None:
        e = 3.0 * k * (1.0 - 2.0 * nu)
    assert e is not None and nu is not None
    if nu >= 0.5:
        return e, math.inf, nu
    return e, e / (3.0 * (1.0 - 2.0 * nu)), nu


def _given_moduli(kind: str, values: tuple[float, ...]) -> tuple[float, float, float]:
    """Of a state-based solid whose K and G are given as parameters; 0 for bonds."""
    if kind == "PDState":
        return _elastic({"K": values[0], "G": values[1]})
    return 0.0, 0.0, 0.25


def _toughness(
    block: Block, kind: str, classical: bool, report: Report
) -> tuple[float | None, float | None]:
    gc = block.positive("Gc") if "Gc" in block else None
    kic = block.positive("KIc") if "KIc" in block else None
    if not classical or kind == "PDElasticBond":
        return None, None
    if gc is None and kic is None:
        raise block.missing("Gc", "or KIc is needed")
    if gc is not None and kic is not None:
        report.add(block.place("KIc"), "not used: Gc is given")
        kic = None
    return gc, kic


def _weight(block: Block, dimension: int, report: Report) -> Weight:
    part = block.block("Influence_Function")
    kind = part.whole("Type", 0)
    values = part.numbers("Parameters")
    if kind == 0:
        return Weight("constant", GAUSSIAN_WIDTH, values[0] if values else dimension + 1.0)
    if kind == 1:
        factor = values[0] if values else (12.0 if dimension == 2 else 20.0)
        if len(values) > 1 and not math.isclose(values[1], -values[0]):
            report.add(
                part.place("Parameters"),
                f"{values[0]:g} + ({values[1]:g}) q is not there: 1 - q is taken",
            )
        return Weight("linear", GAUSSIAN_WIDTH, factor)
    if kind == 2:
        if len(values) == 1:
            raise part.error("Parameters", "a gaussian has 2 of them, not 1")
        width = values[1] if values else GAUSSIAN_WIDTH
        if not width > 0.0:
            raise part.error("Parameters", f"the width must be above 0, not {width:g}")
        plain = Weight("gaussian", width, 1.0)
        return Weight("gaussian", width, values[0] if values else 1.0 / plain.moment(dimension))
    raise part.error("Type", f"0 constant, 1 linear or 2 gaussian needed, not {kind}")


# ---- materials of a scene ------------------------------------------------------------------------


def right(spec: SolidSpec, spacing: float, dimension: int) -> Solid:
    """The material with right physics, of a particle with the given smallest node spacing."""
    horizon = spec.horizon_of(spacing)
    common: dict[str, Any] = {
        "density": spec.density,
        "horizon": horizon,
        "influence": spec.weight.influence,
        "width": spec.weight.width,
        "name": spec.name,
    }
    gc = spec.gc
    if spec.kic is not None:
        stress = dimension == 2 and spec.plane == "stress"
        gc = spec.kic**2 / spec.young * (1.0 if stress else 1.0 - spec.poisson**2)
    if spec.kind == "PDState":
        s0 = spec.values[2] if spec.values else None
        return Material(
            bulk=spec.bulk, poisson=spec.poisson, gc=gc, s0=s0, plane=spec.plane, **common
        )
    return _bonds(spec, gc, horizon, dimension, common)


def _bonds(
    spec: SolidSpec, gc: float | None, horizon: float, dimension: int, common: dict[str, Any]
) -> BondMaterial:
    a0, values = spec.weight.factor, spec.values
    plane = "strain" if spec.plane == "jha" else spec.plane
    if spec.kind == "RNPBond" and values:
        depth = 2.0 * a0 * values[0] / ball(horizon, dimension)
        return BondMaterial(potential="rnp", depth=depth, beta=values[1], plane=plane, **common)
    kinds: dict[str, Potential] = {
        "PMBBond": "pmb",
        "PDElasticBond": "elastic",
        "RNPBond": "rnp",
    }
    kind = kinds[spec.kind]
    if values:
        s0 = values[1] if spec.kind == "PMBBond" else None
        return BondMaterial(c=a0 * values[0], s0=s0, potential=kind, plane=plane, **common)
    return BondMaterial(young=spec.young, gc=gc, potential=kind, plane=plane, **common)


def ball(horizon: float, dimension: int) -> float:
    """Horizon times the volume of the family ball, by which PeriDEM divides the RNP potential."""
    return math.pi * horizon**3 if dimension == 2 else 4.0 / 3.0 * math.pi * horizon**4


def published(spec: SolidSpec, spacing: float, dimension: int, weight: Weight) -> Solid:
    """The material as PeriDEM computes it, of a particle with the given smallest node spacing.

    Args:
        spec: of the zone.
        spacing: smallest distance of two nodes of the particle.
        dimension: 2 or 3.
        weight: influence function of the first zone, which counts for all.
    """
    horizon = spec.horizon_of(spacing)
    common: dict[str, Any] = {
        "density": spec.density,
        "horizon": horizon,
        "influence": weight.influence,
        "width": weight.width,
        "name": spec.name,
        "taper": spacing,
        "breaking": "both",
    }
    gc = spec.gc if spec.kic is None else spec.kic**2 / spec.young
    if spec.kind == "PDState":
        shear = spec.shear
        s0 = spec.values[2] if spec.values else None
        if s0 is None:
            assert gc is not None
            factor = 3.0 * shear + 0.75**4 * (spec.bulk - 5.0 * shear / 3.0)
            s0 = math.sqrt(gc / (factor * horizon))
        plane: Plane = "jha" if dimension == 2 else "strain"
        return Material(bulk=spec.bulk, poisson=spec.poisson, s0=s0, plane=plane, **common)
    return _published_bonds(spec, gc, horizon, dimension, weight, common)


def _published_bonds(
    spec: SolidSpec,
    gc: float | None,
    horizon: float,
    dimension: int,
    weight: Weight,
    common: dict[str, Any],
) -> BondMaterial:
    """Bond-based solids; PeriDEM's constants times the factor a0 of its influence function."""
    a0, nu = weight.factor, 0.25
    lame = spec.young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    around = math.pi * horizon**3
    if spec.kind == "PDElasticBond":
        c = spec.values[0] if spec.values else 24.0 * lame / around
        return BondMaterial(c=a0 * c, potential="elastic", **common)
    if spec.kind == "PMBBond":
        if spec.values:
            c, s0 = spec.values[:2]
        else:
            assert gc is not None
            c = 24.0 * (spec.young / (1.0 - nu) if dimension == 2 else lame) / around
            s0 = math.sqrt(5.0 * math.pi * gc / (9.0 * spec.young * horizon))
        return BondMaterial(c=a0 * c, s0=s0, **common)
    if spec.values:
        depth, beta = spec.values[:2]
    else:
        assert gc is not None
        m = weight.moment(dimension)
        depth = math.pi * gc / (4.0 * m) if dimension == 2 else 2.0 * gc / (3.0 * m)
        beta = (4.0 if dimension == 2 else 5.0) * lame / (depth * m)
    depth *= 2.0 * a0 / ball(horizon, dimension)
    return BondMaterial(potential="rnp", depth=depth, beta=beta, **common)
