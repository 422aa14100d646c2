"""What LAMMPS wrote, as numpy arrays: dumps, thermo output, averages, and what follows from them.

Files are read when they are asked for, a dump one frame at a time.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from peridem.results_contacts import Contacts, Network, contacts, network, wall_forces
from peridem.results_dump import Dump, Frame
from peridem.results_fragments import Fragments, fragments, labels
from peridem.results_output import Output
from peridem.results_tables import Table, Vectors, averages, thermo, vectors
from peridem.results_walls import from_contact, wall_stress

__all__ = [
    "Contacts",
    "Dump",
    "Fragments",
    "Frame",
    "Network",
    "Output",
    "Table",
    "Vectors",
    "averages",
    "contacts",
    "fragments",
    "from_contact",
    "labels",
    "network",
    "per_grain",
    "thermo",
    "vectors",
    "wall_forces",
    "wall_stress",
]

Array = NDArray[np.float64]


def per_grain(
    frame: Frame, values: Array | None = None, weights: Array | None = None
) -> tuple[NDArray[np.int64], Array]:
    """Means over the nodes of each grain.

    Args:
        frame: with the column ``mol``.
        values: (n,) or (n, k), one row for each atom; None: the positions.
        weights: (n,) of the nodes, such as their volumes; None: all alike.

    Returns:
        The molecule-IDs, (g,), and the means, (g,) or (g, k).
    """
    grains, member = np.unique(frame["mol"].astype(np.int64), return_inverse=True)
    data = frame.position if values is None else np.asarray(values, dtype=float)
    weight = np.ones(len(member)) if weights is None else np.asarray(weights, dtype=float)
    shape = (-1, *[1] * (data.ndim - 1))
    total = np.zeros((len(grains), *data.shape[1:]))
    np.add.at(total, member, data * weight.reshape(shape))
    return grains, total / np.bincount(member, weight).reshape(shape)
