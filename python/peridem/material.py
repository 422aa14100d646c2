"""What grains are made of, and what happens where they touch.

The quantities are those of ``pair_style peridem/lps`` and ``pair_style peridem/contact``; the
constants are worked out here only to choose a time step, to draw, and to explain what a scene does.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Influence = Literal["linear", "constant", "inverse"]
Plane = Literal["strain", "stress", "jha"]

INFLUENCE: dict[str, Callable[[Array], Array]] = {
    "linear": lambda q: np.asarray(1.0 - q),
    "constant": lambda q: np.asarray(np.ones_like(q)),
    "inverse": lambda q: np.asarray(1.0 / q),
}


@dataclass(frozen=True)
class Material:
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
            ``constant`` 1, ``inverse`` 1/q.
        plane: what a 2D run means: plane strain, plane stress, or ``jha`` (3D constants).
        name: for comments.

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

    def __post_init__(self) -> None:
        for what in ("bulk", "density", "horizon"):
            self._above(what, getattr(self, what), 0.0)
        if not -1.0 < self.poisson < 0.5:
            raise ValueError(
                f"material '{self.name}': poisson must lie in (-1, 1/2), not {self.poisson}"
            )
        if self.gc is not None and self.s0 is not None:
            raise ValueError(f"material '{self.name}': one of gc and s0, not both")
        for what in ("gc", "s0"):
            if getattr(self, what) is not None:
                self._above(what, getattr(self, what), 0.0)
        if not (math.isfinite(self.viscosity) and self.viscosity >= 0.0):
            raise ValueError(
                f"material '{self.name}': viscosity must be at least 0, not {self.viscosity}"
            )
        if self.influence not in INFLUENCE:
            raise ValueError(
                f"material '{self.name}': influence must be one of {', '.join(INFLUENCE)}, "
                f"not '{self.influence}'"
            )
        if self.plane not in ("strain", "stress", "jha"):
            raise ValueError(
                f"material '{self.name}': plane must be strain, stress or jha, not '{self.plane}'"
            )

    def _above(self, what: str, value: float, low: float) -> None:
        if not (math.isfinite(value) and value > low):
            raise ValueError(
                f"material '{self.name}': {what} must be finite and above {low:g}, not {value}"
            )

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
        pi * integral of w R^5 in 3D, 2 * integral of w R^4 in 2D.
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
            family = 4.0 * math.pi * size**5 * self._moment(4)
            across = math.pi * size**6 * self._moment(5)
        else:
            family = 2.0 * math.pi * size**4 * self._moment(3)
            across = 2.0 * size**5 * self._moment(4)
        return math.sqrt(self.gc * family / (d * d * kappa * across))

    def _moment(self, power: int) -> float:
        """Integral of w(q) q^power over 0..1; exact for these polynomials."""
        x, weight = np.polynomial.legendre.leggauss(8)
        q = 0.5 * (x + 1.0)
        return float(0.5 * (weight * INFLUENCE[self.influence](q) * q**power).sum())

    def pair_coeff(self, dimension: int) -> str:
        """The keywords of ``pair_coeff I J peridem/lps``."""
        words = [f"bulk {self.bulk:.8g} poisson {self.poisson:.8g} horizon {self.horizon:.8g}"]
        if self.gc is not None:
            words.append(f"gc {self.gc:.8g}")
        elif self.s0 is not None:
            words.append(f"s0 {self.s0:.8g}")
        else:
            words.append("unbreakable")
        if self.viscosity:
            words.append(f"viscosity {self.viscosity:.8g}")
        words.append(f"influence {self.influence}")
        if dimension == 2:
            words.append(f"plane {self.plane}")
        return " ".join(words)


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

    Raises:
        ValueError: a value outside its range.
    """

    radius: float | None = None
    stiff: float = 10.0
    restitution: float = 1.0
    friction: float = 0.0

    def __post_init__(self) -> None:
        if self.radius is not None and not (math.isfinite(self.radius) and self.radius > 0.0):
            raise ValueError(f"contact: radius must be above 0, not {self.radius}")
        if not (math.isfinite(self.stiff) and self.stiff > 0.0):
            raise ValueError(f"contact: stiff must be above 0, not {self.stiff}")
        if not 0.0 < self.restitution <= 1.0:
            raise ValueError(f"contact: restitution must lie in (0, 1], not {self.restitution}")
        if not (math.isfinite(self.friction) and self.friction >= 0.0):
            raise ValueError(f"contact: friction must be at least 0, not {self.friction}")

    def keywords(self, radius: float, bulk: float) -> str:
        """The keywords of ``pair_coeff I J peridem/contact`` and ``fix peridem/wall``."""
        return (
            f"radius {radius:.8g} modulus {bulk:.8g} form bulk {self.stiff:.8g} "
            f"restitution {self.restitution:.8g} friction {self.friction:.8g}"
        )
