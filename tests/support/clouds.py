"""Clouds of nodes as numpy arrays, and the LAMMPS data files that hold them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from .oracle import Array, Ints


@dataclass
class Cloud:
    """Nodes in the order of their atom-IDs (1, 2, ...).

    ``x`` are unwrapped positions, ``reference`` where the nodes were when the grains were whole.
    ``box`` is (3, 2); ``periodic`` says which directions wrap.
    """

    x: Array
    volume: Array
    molecule: Ints
    density: Array
    types: Ints
    box: Array
    reference: Array
    v: Array
    periodic: tuple[bool, bool, bool] = (False, False, False)
    comment: str = field(default="cloud of nodes")

    @property
    def n(self) -> int:
        return len(self.volume)

    @property
    def mass(self) -> Array:
        return self.density * self.volume

    def moved(self, x: Array, v: Array | None = None) -> Cloud:
        """The same grains at other positions; the reference stays."""
        return replace(self, x=x.copy(), v=self.v if v is None else v.copy())

    def write(self, path: Path, with_reference: bool = True, ntypes: int | None = None) -> None:
        """Write a LAMMPS data file for ``atom_style peridem`` (with the word ``reference``)."""
        span = self.box[:, 1] - self.box[:, 0]
        image = np.zeros((self.n, 3), int)
        for axis in range(3):
            if self.periodic[axis]:
                image[:, axis] = np.floor((self.x[:, axis] - self.box[axis, 0]) / span[axis])
        wrapped = self.x - image * span
        lines = [self.comment, "", f"{self.n} atoms"]
        lines.append(f"{int(self.types.max()) if ntypes is None else ntypes} atom types")
        for axis, name in enumerate("xyz"):
            low, high = self.box[axis]
            lines.append(f"{low:.17g} {high:.17g} {name}lo {name}hi")
        lines += ["", "Atoms # peridem", ""]
        for k in range(self.n):
            numbers = [self.volume[k], self.density[k], *wrapped[k]]
            if with_reference:
                numbers += list(self.reference[k])
            text = " ".join(f"{value:.17g}" for value in numbers)
            tail = " ".join(str(value) for value in image[k])
            lines.append(f"{k + 1} {self.molecule[k]} {self.types[k]} {text} {tail}")
        lines += ["", "Velocities", ""]
        lines += [
            f"{k + 1} " + " ".join(f"{value:.17g}" for value in self.v[k]) for k in range(self.n)
        ]
        path.write_text("\n".join(lines) + "\n")


def cloud(
    x: Array,
    volume: Array | float = 1.0,
    molecule: Ints | int = 1,
    density: Array | float = 1.0,
    types: Ints | int = 1,
    dimension: int = 3,
    margin: float = 5.0,
    v: Array | None = None,
) -> Cloud:
    """A cloud in its reference state, in a box ``margin`` larger than it; (n, 2) becomes (n, 3)."""
    x = np.asarray(x, dtype=float)
    if x.shape[1] == 2:
        x = np.column_stack([x, np.zeros(len(x))])
    n = len(x)
    box = np.stack([x.min(axis=0) - margin, x.max(axis=0) + margin], axis=1)
    if dimension == 2:
        box[2] = (-0.5, 0.5)
    return Cloud(
        x=x,
        volume=np.broadcast_to(np.asarray(volume, float), n).copy(),
        molecule=np.broadcast_to(np.asarray(molecule, int), n).copy(),
        density=np.broadcast_to(np.asarray(density, float), n).copy(),
        types=np.broadcast_to(np.asarray(types, int), n).copy(),
        box=box,
        reference=x.copy(),
        v=np.zeros((n, 3)) if v is None else np.asarray(v, float).copy(),
    )


def join(*parts: Cloud, margin: float = 5.0) -> Cloud:
    """Several clouds as one, in a box ``margin`` larger than all; molecules stay as they are."""
    x = np.concatenate([part.x for part in parts])
    flat = all(np.all(part.box[2] == (-0.5, 0.5)) for part in parts)
    whole = cloud(x, dimension=2 if flat else 3, margin=margin)
    for name in ("volume", "molecule", "density", "types", "reference", "v"):
        setattr(whole, name, np.concatenate([getattr(part, name) for part in parts]))
    return whole


def momenta(one: Cloud, x: Array, v: Array) -> Array:
    """Momentum, and angular momentum about the origin: (6,)."""
    p = one.mass[:, None] * v
    return np.append(p.sum(axis=0), np.cross(x, p).sum(axis=0))


def lattice(shape: tuple[int, ...], spacing: float = 1.0) -> Array:
    """Points of a square or cubic lattice centred on the origin, shape (n, 3)."""
    axes = [spacing * (np.arange(count) - 0.5 * (count - 1)) for count in shape]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(shape))
    return np.column_stack([points, np.zeros((len(points), 3 - len(shape)))])


def disc(radius: float, spacing: float = 1.0, centre: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Square-lattice points within ``radius`` of ``centre``, shape (n, 3)."""
    count = 2 * int(np.ceil(radius / spacing)) + 1
    points = lattice((count, count), spacing)
    points = points[np.linalg.norm(points, axis=1) <= radius]
    return points + np.array([*centre, 0.0])


def ragged(
    rng: np.random.Generator, shape: tuple[int, ...], jitter: float = 0.2, **options
) -> Cloud:
    """A jittered lattice of unit spacing with volumes from 0.6 to 1.4 and densities from 1 to 3."""
    x = lattice(shape)
    n, d = len(x), len(shape)
    x[:, :d] += rng.uniform(-jitter, jitter, (n, d))
    options.setdefault("volume", rng.uniform(0.6, 1.4, n))
    options.setdefault("density", rng.uniform(1.0, 3.0, n))
    return cloud(x, dimension=d, **options)


def deformed(rng: np.random.Generator, one: Cloud, size: float, dimension: int) -> Array:
    """Positions after a random displacement of up to ``size`` per coordinate."""
    x = one.reference.copy()
    x[:, :dimension] += rng.uniform(-size, size, (one.n, dimension))
    return x


def rotated(x: Array, angle: float, axis: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Array:
    """Positions rotated about an axis through the origin (Rodrigues' formula)."""
    k = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return x @ turn.T
