"""The largest stable time step of a scene.

Velocity Verlet is stable while dt < 2/omega, omega the highest natural frequency. For the bonds it
is found from the stiffness of a grain's reference configuration; contacts, of which there are none
yet when a scene is written, are bounded by the most that a node can have at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import eigsh
from scipy.spatial import cKDTree

from peridem.cloud import Cloud, piece_sizes
from peridem.material import BondMaterial, Material, Solid

Array = NDArray[np.float64]

# Springs pressed at once that fix peridem/timestep allows for at the lightest node before grains
# touch: d + 1, as compute peridem/dt has it.
CONTACTS_AT_ONCE = {2: 3, 3: 4}


def bonds(cloud: Cloud, horizon: float) -> tuple[NDArray[np.int64], Array]:
    """Bonds of a cloud: pairs of nodes within the horizon, (b, 2), and their lengths, (b,)."""
    pairs = cKDTree(cloud.nodes).query_pairs(horizon * (1.0 + 1e-9), output_type="ndarray")
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))].astype(np.int64)
    length = np.linalg.norm(cloud.nodes[pairs[:, 1]] - cloud.nodes[pairs[:, 0]], axis=1)
    return pairs, np.asarray(length)


def pieces(cloud: Cloud, horizon: float) -> NDArray[np.int64]:
    """Nodes of each piece of a cloud that bonds hold together, (p,), the largest first."""
    n, links = len(cloud.nodes), cloud.links
    length = np.linalg.norm(cloud.nodes[links[:, 1]] - cloud.nodes[links[:, 0]], axis=1)
    sizes = piece_sizes(n, links[length <= horizon])  # a few of the bonds, and most often enough
    return sizes if len(sizes) == 1 else piece_sizes(n, bonds(cloud, horizon)[0])


def stiffness(cloud: Cloud, material: Solid) -> sparse.csr_matrix:
    """Stiffness matrix of a peridynamic solid in its reference configuration.

    Row and column d*i + k belong to the displacement of node i along k, d the dimension:
    (d n, d n), symmetric.

    Raises:
        ValueError: nodes without a bond within the horizon; it says how many and the first of them.
    """
    n, d = cloud.nodes.shape
    pairs, length = bonds(cloud, material.horizon)
    i, j = pairs.T
    alone = np.setdiff1d(np.arange(n), pairs)
    if len(alone):
        raise ValueError(
            f"cloud '{cloud.name}': {len(alone)} of {n} nodes have no other within the horizon "
            f"{material.horizon:g} (the first is node {alone[0] + 1}); spacing is {cloud.spacing:g}"
        )
    cell = 0.5 * (cloud.cell_sizes[i] + cloud.cell_sizes[j])
    weight = material.weight(length / material.horizon) * material.cut(length, cell)
    extension = _extension(cloud, pairs, length)
    if isinstance(material, BondMaterial):
        spring = material.micro_modulus(d) * weight * cloud.volumes[i] * cloud.volumes[j] / length
        return sparse.csr_matrix(extension.T @ sparse.diags(spring) @ extension)
    return _state_stiffness(cloud, material, pairs, length, weight, extension)


def _extension(cloud: Cloud, pairs: NDArray[np.int64], length: Array) -> sparse.csr_matrix:
    """Extensions of all bonds from the displacements, (b, d n)."""
    d, (i, j) = cloud.dimension, pairs.T
    b = np.arange(len(pairs))
    along = (cloud.nodes[j] - cloud.nodes[i]) / length[:, None]
    column = np.concatenate([(d * j[:, None] + np.arange(d)), (d * i[:, None] + np.arange(d))])
    return sparse.csr_matrix(
        (np.concatenate([along, -along]).ravel(), (np.tile(b, 2).repeat(d), column.ravel())),
        shape=(len(pairs), d * len(cloud.nodes)),
    )


def _state_stiffness(
    cloud: Cloud,
    material: Material,
    pairs: NDArray[np.int64],
    length: Array,
    weight: Array,
    extension: sparse.csr_matrix,
) -> sparse.csr_matrix:
    """The linear peridynamic solid: shear springs along the bonds, and the dilatation of nodes."""
    n, d, volume = len(cloud.nodes), cloud.dimension, cloud.volumes
    i, j = pairs.T
    family = np.zeros(n)
    np.add.at(family, i, weight * length**2 * volume[j])
    np.add.at(family, j, weight * length**2 * volume[i])
    dc = material.constants_dimension(d)
    share = dc * weight * length
    gather = sparse.csr_matrix(
        (
            np.concatenate([share * volume[j] / family[i], share * volume[i] / family[j]]),
            (np.concatenate([i, j]), np.tile(np.arange(len(pairs)), 2)),
        ),
        shape=(n, len(pairs)),
    )
    dilatation = gather @ extension
    shear, lame = material.shear, material.lame(d)
    spring = dc * (dc + 2) * shear * weight * volume[i] * volume[j]
    spring *= 1.0 / family[i] + 1.0 / family[j]
    matrix = extension.T @ sparse.diags(spring) @ extension
    matrix += dilatation.T @ sparse.diags((lame - shear) * volume) @ dilatation
    return sparse.csr_matrix(matrix)


def shear_of(material: Solid, dimension: int) -> float:
    """Shear modulus."""
    return material.moduli(dimension)[1] if isinstance(material, BondMaterial) else material.shear


def highest_frequency(cloud: Cloud, material: Solid) -> float:
    """Highest natural frequency of a grain, in radians per time."""
    root = 1.0 / np.sqrt(material.density * cloud.volumes.repeat(cloud.dimension))
    scale = sparse.diags(root)
    matrix = scale @ stiffness(cloud, material) @ scale
    if matrix.shape[0] <= 12:
        return math.sqrt(float(np.linalg.eigvalsh(matrix.toarray())[-1]))
    start = np.random.default_rng(1).standard_normal(matrix.shape[0])
    top = eigsh(matrix, k=1, which="LA", v0=start, tol=1e-6, return_eigenvectors=False)
    return math.sqrt(float(top[0]))


@dataclass(frozen=True)
class StableStep:
    """What limits the time step.

    Attributes:
        bonds: largest stable step of the springs of the bonds alone.
        contacts: largest stable step of the springs of the contacts alone.
        rate: of the dashpots along the bonds, per time: twice the rate at which a motion dies away.
    """

    bonds: float
    contacts: float
    rate: float = 0.0

    @property
    def springs(self) -> float:
        """Largest stable step of bonds and contacts.

        At worst the squares of frequencies add up (eigenvalues of a sum of symmetric matrices).
        """
        return 1.0 / math.sqrt(self.bonds**-2 + self.contacts**-2)

    @property
    def together(self) -> float:
        """Largest stable step with the dashpots, whose velocities lag by half a step.

        The damping ratio is that of the bonds' fastest motion, as ``compute peridem/dt`` has it.
        """
        damping = 0.25 * self.rate * self.bonds
        return self.springs * (math.sqrt(1.0 + damping**2) - damping)


def stable_step(clouds: list[Cloud], materials: list[Solid], spring: float) -> StableStep:
    """The largest stable time step of grains with the given clouds and materials.

    The dashpots that make up ``restitution`` need no smaller step: LAMMPS bounds them itself.

    Args:
        clouds: one for each kind of grain, at its largest and smallest size in use.
        materials: of each cloud.
        spring: stiffest spring of one pair of touching nodes, force over length.
    """
    kinds = list(zip(clouds, materials, strict=True))
    omega = max(highest_frequency(c, m) for c, m in kinds)
    # the viscous part of a bond is its shear spring times viscosity over shear modulus
    d = clouds[0].dimension
    rate = omega**2 * max(m.viscosity / shear_of(m, d) for m in materials)
    # rows of a contact stiffness: a node's own springs and their far ends, k/m each (Gershgorin)
    rows = 2.0 * CONTACTS_AT_ONCE[clouds[0].dimension]
    lightest = min(float(m.density * c.volumes.min()) for c, m in kinds)
    return StableStep(2.0 / omega, 2.0 / math.sqrt(rows * spring / lightest), rate)
