"""What grains are made of, and what happens where they touch.

The quantities are those of ``pair_style peridem/lps``, ``peridem/pmb`` and ``peridem/contact``; the
constants are worked out here only to choose a time step, to draw, and to explain what a scene does.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Influence = Literal["linear", "constant", "inverse", "gaussian"]
Plane = Literal["strain", "stress", "jha"]
Volume = Literal["taper", "full"]
Breaking = Literal["tension", "both"]
Potential = Literal["pmb", "elastic", "rnp"]

# of a bond of length q times the horizon; gaussian with its default width
INFLUENCE: dict[str, Callable[[Array], Array]] = {
    "linear": lambda q: np.asarray(1.0 - q),
    "constant": lambda q: np.asarray(np.ones_like(q)),
    "inverse": lambda q: np.asarray(1.0 / q),
    "gaussian": lambda q: np.asarray(np.exp(-q * q / 0.2)),
}


class _Bonded:
    """What the solids share: checks, the weight of a bond, keywords of ``pair_coeff``."""

    name: str
    density: float
    horizon: float
    gc: float | None
    s0: float | None
    viscosity: float
    influence: Influence
    width: float
    volume: Volume
    taper: float | None
    breaking: Breaking
    gc_spacing: float | None

    def _check_common(self) -> None:
        for what in ("density", "horizon", "width"):
            self._above(what, getattr(self, what))
        if self.gc is not None and self.s0 is not None:
            raise ValueError(f"material '{self.name}': one of gc and s0, not both")
        for what in ("gc", "s0", "taper", "gc_spacing"):
            if getattr(self, what) is not None:
                self._above(what, getattr(self, what))
        if self.gc_spacing is not None and self.gc is None:
            raise ValueError(f"material '{self.name}': gc_spacing goes with gc")
        if not (math.isfinite(self.viscosity) and self.viscosity >= 0.0):
            raise ValueError(
                f"material '{self.name}': viscosity must be at least 0, not {self.viscosity}"
            )
        self._one_of("influence", self.influence, tuple(INFLUENCE))
        self._one_of("volume", self.volume, ("taper", "full"))
        self._one_of("breaking", self.breaking, ("tension", "both"))

    def _above(self, what: str, value: float) -> None:
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(
                f"material '{self.name}': {what} must be finite and above 0, not {value}"
            )

    def _one_of(self, what: str, given: str, allowed: tuple[str, ...]) -> None:
        if given not in allowed:
            raise ValueError(
                f"material '{self.name}': {what} must be one of {', '.join(allowed)}, not '{given}'"
            )

    def weight(self, q: Array) -> Array:
        """Influence of bonds whose lengths are q times the horizon, (n,)."""
        if self.influence == "gaussian":
            return np.asarray(np.exp(-q * q / self.width))
        return INFLUENCE[self.influence](q)

    def moment(self, power: int) -> float:
        """Integral of w(q) q^power over 0..1; exact for polynomials, to 1e-12 for a gaussian."""
        x, weight = np.polynomial.legendre.leggauss(24)
        q = 0.5 * (x + 1.0)
        return float(0.5 * (weight * self.weight(q) * q**power).sum())

    def cut(self, length: Array, cell: Array) -> Array:
        """Partial-volume factor of bonds of the given lengths and mean cell sizes, (n,)."""
        if self.volume == "full":
            return np.ones_like(length)
        h = cell if self.taper is None else np.full_like(length, self.taper)
        return np.asarray(np.clip((self.horizon + 0.5 * h - length) / h, 0.0, 1.0))

    def _strength(self) -> str:
        if self.gc is not None:
            spacing = "" if self.gc_spacing is None else f" {self.gc_spacing:.12g}"
            return f"gc {self.gc:.8g}{spacing}"
        return "unbreakable" if self.s0 is None else f"s0 {self.s0:.12g}"

    def _common_words(self) -> list[str]:
        """Viscosity, influence, volume and breaking, where they are not the default."""
        words = [f"viscosity {self.viscosity:.8g}"] if self.viscosity else []
        words.append(f"influence {self.influence}")
        if self.influence == "gaussian":
            words.append(f"{self.width:.8g}")
        if self.volume == "full":
            words.append("volume full")
        elif self.taper is not None:
            words.append(f"volume taper {self.taper:.12g}")
        if self.breaking == "both":
            words.append("break both")
        return words


@dataclass(frozen=True)
class Material(_Bonded):
    """A linear peridynamic solid that breaks at a critical stretch.

    Attributes:
        bulk: bulk modulus K.
        poisson: Poisson's ratio, in (-1, 1/2).
        density: mass per volume (per area and unit thickness in 2D).
        horizon: largest length of a bond.
        gc: critical energy release rate, or None.
        s0: critical stretch, or None. With neither, bonds never break.
        viscosity: shear viscosity of the bonds, pressure times time.
        influence: weight of a bond of length R = q times the horizon: ``linear`` 1 - q,
            ``constant`` 1, ``inverse`` 1/q, ``gaussian`` exp(-q^2/width).
        plane: what a 2D run means: plane strain, plane stress, or ``jha`` (3D constants).
        name: for comments and for pairs of materials.
        width: of the gaussian.
        volume: ``taper``: cells that the horizon cuts count in part; ``full``: whole.
        taper: cell size of the taper; None: of each node, from its volume.
        breaking: in ``tension`` only, or ``both`` in tension and compression.
        gc_spacing: spacing of the lattice on which ``gc`` is to be spent; None: integrals.

    Raises:
        ValueError: a value outside its range; it says which, what was given and what is allowed.
    """

    bulk: float
    poisson: float
    density: float
    horizon: float
    gc: float | None = None
    s0: float | None = None
    viscosity: float = 0.0
    influence: Influence = "linear"
    plane: Plane = "strain"
    name: str = "solid"
    width: float = 0.2
    volume: Volume = "taper"
    taper: float | None = None
    breaking: Breaking = "tension"
    gc_spacing: float | None = None

    style = "peridem/lps"

    def __post_init__(self) -> None:
        self._above("bulk", self.bulk)
        if not -1.0 < self.poisson < 0.5:
            raise ValueError(
                f"material '{self.name}': poisson must lie in (-1, 1/2), not {self.poisson}"
            )
        if self.plane not in ("strain", "stress", "jha"):
            raise ValueError(
                f"material '{self.name}': plane must be strain, stress or jha, not '{self.plane}'"
            )
        self._check_common()

    @property
    def shear(self) -> float:
        """Shear modulus G = 3 K (1 - 2 nu) / (2 (1 + nu))."""
        return 1.5 * self.bulk * (1.0 - 2.0 * self.poisson) / (1.0 + self.poisson)

    def constants_dimension(self, dimension: int) -> int:
        """Dimension for which the constants of the solid are made: 3 with plane ``jha``."""
        return 3 if self.plane == "jha" else dimension

    def lame(self, dimension: int) -> float:
        """Lamé's first constant: K - 2G/3, or its plane-stress value 2 lambda G/(lambda + 2G)."""
        lame = self.bulk - 2.0 * self.shear / 3.0
        if dimension == 2 and self.plane == "stress":
            return 2.0 * lame * self.shear / (lame + 2.0 * self.shear)
        return lame

    def wave_speed(self, dimension: int) -> float:
        """Speed of longitudinal waves, sqrt((lambda' + 2G)/rho)."""
        return math.sqrt((self.lame(dimension) + 2.0 * self.shear) / self.density)

    def critical_stretch(self, dimension: int) -> float:
        """Stretch at which a bond breaks; infinite if it never does.

        From Gc by isotropic extension: s0^2 = Gc m / (d^2 kappa' I) with kappa' = lambda' + 2G/d,
        m the integral of w R^2 over the family and I the work of the bonds across a plane,
        pi * integral of w R^5 in 3D, 2 * integral of w R^4 in 2D. With ``gc_spacing``, which puts
        sums over a lattice in their place, it is an estimate.
        """
        if self.s0 is not None:
            return self.s0
        if self.gc is None:
            return math.inf
        if dimension == 2 and self.plane == "jha":
            factor = 3.0 * self.shear + 0.75**4 * (self.bulk - 5.0 * self.shear / 3.0)
            return math.sqrt(self.gc / (factor * self.horizon))
        d, size = dimension, self.horizon
        kappa = self.lame(d) + 2.0 * self.shear / d
        if d == 3:
            family = 4.0 * math.pi * size**5 * self.moment(4)
            across = math.pi * size**6 * self.moment(5)
        else:
            family = 2.0 * math.pi * size**4 * self.moment(3)
            across = 2.0 * size**5 * self.moment(4)
        return math.sqrt(self.gc * family / (d * d * kappa * across))

    def describe(self, dimension: int) -> str:
        """Where the numbers of ``pair_coeff`` come from, for a comment."""
        stretch = self.critical_stretch(dimension)
        if math.isinf(stretch):
            return "bonds never break"
        if self.gc_spacing is not None:
            return f"Gc = {self.gc:g} on a lattice; LAMMPS prints the stretch, near {stretch:.2g}"
        why = ""
        if self.gc is not None:
            jha = dimension == 2 and self.plane == "jha"
            law = "sqrt(Gc/((3G + 0.75^4 (K - 5G/3)) horizon))" if jha else "sqrt(Gc m/(d^2 K' I))"
            why = f" = {law} for Gc = {self.gc:g}"
        return f"bonds break at a stretch of {stretch:.3g}{why}"

    def pair_coeff(self, dimension: int) -> str:
        """The keywords of ``pair_coeff I J peridem/lps``."""
        words = [f"bulk {self.bulk:.12g} poisson {self.poisson:.12g} horizon {self.horizon:.12g}"]
        words.append(self._strength())
        words += self._common_words()
        if dimension == 2:
            words.append(f"plane {self.plane}")
        return " ".join(words)


@dataclass(frozen=True)
class BondMaterial(_Bonded):
    """A bond-based solid (``pair_style peridem/pmb``).

    Attributes:
        density: mass per volume (per area and unit thickness in 2D).
        horizon: largest length of a bond.
        young, bulk, c: one of them: Young's modulus, bulk modulus, or the micro-modulus. None of
            them with ``potential="rnp"`` and ``depth`` and ``beta``.
        potential: ``pmb`` breaks at a critical stretch, ``elastic`` never, ``rnp`` softens.
        depth, beta: C and beta of the potential C (1 - exp(-beta R s^2)); they take the place of
            the moduli and of ``gc`` and ``s0``.
        gc, s0, viscosity, influence, name, width, volume, taper, breaking, gc_spacing: as of
            :class:`Material`.
        plane: ``strain`` or ``stress``, of a 2D run.

    Raises:
        ValueError: a value outside its range, or too many or too few of them.
    """

    density: float
    horizon: float
    young: float | None = None
    bulk: float | None = None
    c: float | None = None
    potential: Potential = "pmb"
    depth: float | None = None
    beta: float | None = None
    gc: float | None = None
    s0: float | None = None
    viscosity: float = 0.0
    influence: Influence = "linear"
    plane: Plane = "strain"
    name: str = "solid"
    width: float = 0.2
    volume: Volume = "taper"
    taper: float | None = None
    breaking: Breaking = "tension"
    gc_spacing: float | None = None

    style = "peridem/pmb"

    def __post_init__(self) -> None:
        self._check_common()
        self._one_of("potential", self.potential, ("pmb", "elastic", "rnp"))
        self._one_of("plane", self.plane, ("strain", "stress"))
        for what in ("young", "bulk", "c", "depth", "beta"):
            if getattr(self, what) is not None:
                self._above(what, getattr(self, what))
        shaped = self.depth is not None or self.beta is not None
        given = [w for w in ("young", "bulk", "c") if getattr(self, w) is not None]
        if shaped and (self.potential != "rnp" or None in (self.depth, self.beta)):
            raise ValueError(
                f"material '{self.name}': depth and beta go together, with potential rnp"
            )
        if shaped and (given or self.gc is not None or self.s0 is not None):
            raise ValueError(
                f"material '{self.name}': depth and beta take the place of moduli, gc and s0"
            )
        if not shaped and len(given) != 1:
            raise ValueError(
                f"material '{self.name}': one of young, bulk and c needed, not "
                f"{', '.join(given) or 'none'}"
            )

    def poisson_of(self, dimension: int) -> float:
        """Poisson's ratio, which bonds alone fix: 1/4, in plane stress 1/3."""
        return 1.0 / 3.0 if dimension == 2 and self.plane == "stress" else 0.25

    def micro_modulus(self, dimension: int) -> float:
        """c, from c * integral of w R over the family = 2 d (d + 2) G where it is not given."""
        if self.c is not None:
            return self.c
        if self.depth is not None and self.beta is not None:
            return 2.0 * self.depth * self.beta
        d, nu = dimension, self.poisson_of(dimension)
        if self.young is not None:
            shear = self.young / (2.0 * (1.0 + nu))
        else:
            shear = 1.5 * float(self.bulk or 0.0) * (1.0 - 2.0 * nu) / (1.0 + nu)
        return 2.0 * d * (d + 2) * shear / self._family_sum(d)

    def _family_sum(self, dimension: int) -> float:
        """Integral of w R over the family."""
        if dimension == 3:
            return 4.0 * math.pi * self.horizon**4 * self.moment(3)
        return 2.0 * math.pi * self.horizon**3 * self.moment(2)

    def moduli(self, dimension: int) -> tuple[float, float]:
        """Bulk and shear modulus."""
        d, nu = dimension, self.poisson_of(dimension)
        shear = self.micro_modulus(d) * self._family_sum(d) / (2.0 * d * (d + 2))
        return 2.0 * shear * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu)), shear

    def wave_speed(self, dimension: int) -> float:
        """Speed of longitudinal waves, sqrt((lambda' + 2G)/rho) with lambda' = G."""
        return math.sqrt(3.0 * self.moduli(dimension)[1] / self.density)

    def critical_stretch(self, dimension: int) -> float:
        """Stretch at which a bond is taken out (of the horizon's length for rnp), or infinity."""
        if self.potential == "elastic":
            return math.inf
        if self.beta is not None:
            return 10.0 / math.sqrt(2.0 * self.beta * self.horizon)
        if self.s0 is not None:
            return self.s0 * (10.0 if self.potential == "rnp" else 1.0)
        if self.gc is None:
            return math.inf
        d, size, c = dimension, self.horizon, self.micro_modulus(dimension)
        if self.potential == "rnp":
            power = 3 if d == 3 else 2
            across = (math.pi if d == 3 else 2.0) * size ** (power + 2) * self.moment(power)
            return 10.0 * math.sqrt(self.gc / (c * across))
        power = 4 if d == 3 else 3
        across = (0.5 * math.pi if d == 3 else 1.0) * size ** (power + 1) * self.moment(power)
        return math.sqrt(self.gc / (c * across))

    def describe(self, dimension: int) -> str:
        """Where the numbers of ``pair_coeff`` come from, for a comment."""
        c, stretch = self.micro_modulus(dimension), self.critical_stretch(dimension)
        law = "as given" if self.c is not None else "c * integral of w R = 2 d (d + 2) G"
        gone = "bonds never break" if math.isinf(stretch) else f"bonds are gone at {stretch:.3g}"
        return f"micro-modulus {c:.4g} ({law}); {gone}"

    def pair_coeff(self, dimension: int) -> str:
        """The keywords of ``pair_coeff I J peridem/pmb``."""
        words = [f"horizon {self.horizon:.12g}"]
        for what in ("young", "bulk", "c"):
            if getattr(self, what) is not None:
                words.append(f"{what} {getattr(self, what):.12g}")
        if self.depth is not None:
            words.append(f"potential rnp {self.depth:.12g} {self.beta:.12g}")
        else:
            words.append(f"potential {self.potential}")
            if self.potential != "elastic":
                words.append(self._strength())
        words += self._common_words()
        if dimension == 2:
            words.append(f"plane {self.plane}")
        return " ".join(words)


@dataclass(frozen=True)
class Inert:
    """Nodes without bonds: bodies that others touch, and whose motion is prescribed.

    Attributes:
        density: mass per volume (per area and unit thickness in 2D).
        name: for comments and for pairs of materials.
        bulk: modulus for contact; None: that of the other side counts.
    """

    density: float
    name: str = "inert"
    bulk: float | None = None

    style = ""

    def __post_init__(self) -> None:
        for what in ("density", "bulk"):
            value = getattr(self, what)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise ValueError(
                    f"material '{self.name}': {what} must be finite and above 0, not {value}"
                )


Solid = Material | BondMaterial
AnyMaterial = Material | BondMaterial | Inert


def law_of(material: Solid) -> tuple[str, ...]:
    """What LAMMPS cannot mix: bonds between two materials that differ in it must be said."""
    weight = [material.influence] + [f"{material.width:.8g}"] * (material.influence == "gaussian")
    potential = material.potential if isinstance(material, BondMaterial) else ""
    return (material.style, *weight, material.volume, material.breaking, potential)


def bulk_of(material: AnyMaterial, dimension: int) -> float | None:
    """Bulk modulus of a material; None for one that has none."""
    return material.moduli(dimension)[0] if isinstance(material, BondMaterial) else material.bulk


@dataclass(frozen=True)
class Interface:
    """Bonds between two materials inside one grain: a weak grain boundary, say.

    Attributes:
        between: names of the two materials.
        keywords: of ``pair_coeff I J`` (``s0 0.002``, ``gc 1 bulk 2e7 poisson 0.25``, ...).
    """

    between: tuple[str, str]
    keywords: str

    def critical_stretch(self, a: AnyMaterial, b: AnyMaterial, dimension: int) -> float | None:
        """Stretch at which the bonds break; None where the keywords do not tell it simply.

        With ``gc`` alone it follows from the moduli and the horizon of the two, which have to be
        alike but for the name.
        """
        words = self.keywords.split()
        if "s0" in words:
            return float(words[words.index("s0") + 1])
        if not (isinstance(a, Material) and isinstance(b, Material)) or a.influence != "linear":
            return None
        if len(words) == 2 and words[0] == "gc" and replace(a, name="") == replace(b, name=""):
            return replace(a, gc=float(words[1]), s0=None).critical_stretch(dimension)
        return None


@dataclass(frozen=True)
class Contact:
    """Repulsion, damping and friction between the nodes of different grains and fragments.

    Attributes:
        radius: distance below which two nodes push each other; None: 0.95 of the smallest spacing
            of boundary nodes in the scene.
        stiff: spring constant of one pair of nodes over K h^(d-2), K the bulk modulus and h the
            size of the nodes' cells (``modulus K form bulk``).
        restitution: ratio of the speeds after and before two grains meet, in (0, 1].
        friction: Coulomb's coefficient.
        modulus: bulk modulus; None: the harmonic mean of the two materials.
        stiffness: k_N by hand, force/length^(1+2d); it takes the place of ``stiff``.
        onset: part of ``radius`` over which a contact becomes stiff, in [0, 1): the larger, the
            less energy grains gain that rattle without loss. 0: a linear spring.
        jha_horizon: with it, k_N = 18 K/(pi horizon^5) (``form jha2021``) instead of ``stiff``.
        damping: beta_N by hand; it takes the place of ``restitution``.
        tangential: ``history`` (a spring, cut at the friction limit) or ``regularised`` (a drag).
        tangential_value: ratio of the tangential to the normal spring, or the drag.
        fragments: whether nodes of one grain without an intact bond touch.

    Raises:
        ValueError: a value outside its range.
    """

    radius: float | None = None
    stiff: float = 10.0
    restitution: float = 1.0
    friction: float = 0.0
    onset: float = 0.0
    modulus: float | None = None
    stiffness: float | None = None
    jha_horizon: float | None = None
    damping: float | None = None
    tangential: Literal["history", "regularised"] = "history"
    tangential_value: float | None = None
    fragments: bool = True

    def __post_init__(self) -> None:
        for what in ("radius", "stiff", "modulus", "stiffness", "jha_horizon", "tangential_value"):
            value = getattr(self, what)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"contact: {what} must be above 0, not {value}")
        if not 0.0 < self.restitution <= 1.0:
            raise ValueError(f"contact: restitution must lie in (0, 1], not {self.restitution}")
        if not 0.0 <= self.onset < 1.0:
            raise ValueError(f"contact: onset must lie in [0, 1), not {self.onset}")
        for what in ("friction", "damping"):
            value = getattr(self, what)
            if value is not None and not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"contact: {what} must be at least 0, not {value}")
        if self.tangential not in ("history", "regularised"):
            raise ValueError(
                f"contact: tangential must be history or regularised, not '{self.tangential}'"
            )
        if self.damping is not None and self.restitution != 1.0:
            raise ValueError("contact: one of damping and restitution, not both")
        if self.stiffness is not None and self.jha_horizon is not None:
            raise ValueError("contact: one of stiffness and jha_horizon, not both")

    def spring(self, bulk: float, volumes: tuple[float, float], dimension: int) -> float:
        """Spring constant of a pair of nodes of the given volumes, force over length."""
        v = volumes[0] * volumes[1]
        modulus = bulk if self.modulus is None else self.modulus
        if self.stiffness is not None:
            return self.stiffness * v
        if self.jha_horizon is not None:
            return 18.0 * modulus / (math.pi * self.jha_horizon**5) * v
        size = 0.5 * sum(v ** (1.0 / dimension) for v in volumes)
        return float(self.stiff * modulus * size ** (dimension - 2))

    def keywords(self, radius: float, bulk: float | None) -> str:
        """The keywords of ``pair_coeff I J peridem/contact`` and ``fix peridem/wall``.

        Args:
            radius: contact distance.
            bulk: modulus of the pair; None: what LAMMPS finds in the solids.
        """
        words = [f"radius {radius:.12g}"]
        modulus = bulk if self.modulus is None else self.modulus
        if self.stiffness is not None:
            words.append(f"stiffness {self.stiffness:.12g}")
        else:
            words += [] if modulus is None else [f"modulus {modulus:.8g}"]
            words.append(
                f"form bulk {self.stiff:.8g}"
                if self.jha_horizon is None
                else f"form jha2021 horizon {self.jha_horizon:.8g}"
            )
        if self.onset > 0.0:
            words.append(f"onset {self.onset:.8g}")
        if self.damping is not None:
            words.append(f"damping {self.damping:.8g}")
        else:
            words.append(f"restitution {self.restitution:.8g}")
        words.append(f"friction {self.friction:.8g}")
        if self.tangential != "history" or self.tangential_value is not None:
            words.append(f"tangential {self.tangential}")
            if self.tangential_value is not None:
                words.append(f"{self.tangential_value:.8g}")
        if not self.fragments:
            words.append("fragments no")
        return " ".join(words)
