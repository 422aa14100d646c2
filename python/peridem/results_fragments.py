"""Fragments: which nodes still hang together, how many pieces there are and how large they are."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from peridem.results_output import Output

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


def labels(output: Output, i: int) -> Ints:
    """A number for each node that is the same within a fragment, (n,).

    It is the smallest atom-ID in the fragment: from the dump where it has the attribute
    ``fragment`` of ``compute peridem/atom`` (bonds tell), else nodes are together that intact cells
    connect (:meth:`Output.intact_cells`), which takes a cracked but still bonded piece for two.
    """
    if "fragment" in output.attributes:
        return output.field("fragment", i).astype(np.int64)
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    n = len(output.reference)
    cells = output.intact_cells(i)
    ends = np.vstack([cells[:, [0, k]] for k in range(1, cells.shape[1])])
    graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(n, n))
    count, member = connected_components(graph, directed=False)
    smallest = np.full(count, n)
    np.minimum.at(smallest, member, np.arange(n))
    names: Ints = output.frame(i)["id"].astype(np.int64)[smallest[member]]
    return names


@dataclass(frozen=True, eq=False)
class Fragments:
    """The pieces at one time, the largest first.

    Attributes:
        label: (f,) smallest atom-ID in each.
        grain: (f,) the grain it comes from.
        nodes: (f,) number of nodes.
        volume: (f,) volumes; areas in 2D.
        centre: (f, d) centres of volume.
        dimension: 2 or 3.
    """

    label: Ints
    grain: Ints
    nodes: Ints
    volume: Array
    centre: Array
    dimension: int

    def __len__(self) -> int:
        return len(self.label)

    @property
    def size(self) -> Array:
        """Diameter of the circle or sphere of the same volume, (f,)."""
        if self.dimension == 2:
            return np.asarray(np.sqrt(4.0 * self.volume / math.pi))
        return np.asarray(np.cbrt(6.0 * self.volume / math.pi))

    def finer(self, size: Array | float) -> Array:
        """Part of the volume in fragments up to a size: the grading curve."""
        limit = np.atleast_1d(np.asarray(size, dtype=float))
        order = np.argsort(self.size)
        passed = np.concatenate([[0.0], np.cumsum(self.volume[order])])
        at = np.searchsorted(self.size[order], limit, side="right")
        return np.asarray(passed[at] / passed[-1])


def fragments(output: Output, i: int) -> Fragments:
    """The fragments at frame i."""
    label, member, count = np.unique(labels(output, i), return_inverse=True, return_counts=True)
    volume = np.bincount(member, output.volumes)
    position = output.frame(i).position[:, : output.dimension]
    centre = np.zeros((len(label), output.dimension))
    np.add.at(centre, member, position * output.volumes[:, None])
    grain = np.zeros(len(label), dtype=np.int64)
    grain[member] = output.frame(i)["mol"].astype(np.int64)
    order = np.lexsort((label, -volume))
    return Fragments(
        label[order],
        grain[order],
        count[order].astype(np.int64),
        volume[order],
        (centre / volume[:, None])[order],
        output.dimension,
    )
