"""What a square or cubic lattice makes of the energy of the bonds that cross a plane.

``python -m support.crossing`` (from ``tests/``) prints the table of the manual's theory page: this
energy at the critical stretch of the closed form, over Gc, for horizons of 3, 4, 5 and 6 spacings.
"""

from __future__ import annotations

import math

import numpy as np

WIDTH = 0.4  # of the gaussian


def lower_gamma(a: float, x: float) -> float:
    """Incomplete gamma function of a half-integer or integer a, by its recurrence."""
    if a == 0.5:
        return math.sqrt(math.pi) * math.erf(math.sqrt(x))
    if a == 1.0:
        return 1.0 - math.exp(-x)
    return (a - 1.0) * lower_gamma(a - 1.0, x) - x ** (a - 1.0) * math.exp(-x)


def moment(influence: str, n: int) -> float:
    """Integral of w(q) q^n over 0 < q < 1."""
    return {
        "constant": 1.0 / (n + 1),
        "linear": 1.0 / (n + 1) - 1.0 / (n + 2),
        "inverse": 1.0 / n,
        "gaussian": 0.5 * WIDTH ** (0.5 * (n + 1)) * lower_gamma(0.5 * (n + 1), 1.0 / WIDTH),
    }[influence]


def lattice_over_integral(
    style: str, influence: str, volume: str, dimension: int, m: float, direction: str = "axis"
) -> float:
    """What the lattice makes of the crossing integral, as a fraction of the integral itself.

    Of each bond xi of one node, |xi n| / 2 crosses a plane of normal n, per unit of area and on
    average over the positions of the plane.  ``direction``: n along a lattice axis, or the mean
    over all directions.  Bonds longer than the horizon of ``m`` spacings do not exist, so the taper
    only takes away.  The linear solid divides by the weighted volume of the lattice, the bond-based
    one by that of the continuum.
    """
    axis = np.arange(-int(m) - 1, int(m) + 2)
    xi = np.stack(np.meshgrid(*[axis] * dimension), axis=-1).reshape(-1, dimension)
    big_r = np.linalg.norm(xi, axis=1)
    near = (big_r > 0) & (big_r < m * (1 + 1e-9))
    xi, big_r = xi[near], big_r[near]
    q = big_r / m
    w = {
        "constant": np.ones_like(q),
        "linear": 1 - q,
        "inverse": 1 / q,
        "gaussian": np.exp(-(q**2) / WIDTH),
    }[influence]
    v = np.minimum(1.0, m + 0.5 - big_r) if volume == "taper" else np.ones_like(q)
    mean = 0.5 if dimension == 3 else 2 / math.pi  # of |cos| over directions
    across = np.abs(xi[:, 0]) if direction == "axis" else mean * big_r
    if style == "peridem/lps":
        terms = w * v * q**2
        lattice_sum = (terms * across / 2).sum() / m / terms.sum()
        over = (
            4 * np.pi * moment(influence, 4) if dimension == 3 else 2 * np.pi * moment(influence, 3)
        )
        integral = (
            np.pi * moment(influence, 5) if dimension == 3 else 2 * moment(influence, 4)
        ) / over
    else:
        lattice_sum = (w * v * q * across / 2).sum() / m ** (dimension + 1)
        integral = np.pi * moment(influence, 4) if dimension == 3 else 2 * moment(influence, 3)
    return float(lattice_sum / integral)


def main() -> None:
    print("style        d volume influence   m = 3     4     5     6   (plane along the lattice)")
    for style in ("peridem/lps", "peridem/pmb"):
        for dimension in (2, 3):
            for volume in ("taper", "full"):
                for influence in ("linear", "constant", "gaussian", "inverse"):
                    row = [
                        lattice_over_integral(style, influence, volume, dimension, m)
                        for m in (3, 4, 5, 6)
                    ]
                    numbers = " ".join(f"{value:5.3f}" for value in row)
                    print(f"{style} {dimension} {volume:6} {influence:11} {numbers}")


if __name__ == "__main__":
    main()
