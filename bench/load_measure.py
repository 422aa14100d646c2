"""How good is the load measure of fix peridem/adapt?

    python -m bench.load_measure [--loads 300]

Grains of four shapes and two resolutions get random loads on their surface: a few nodes pushed
inwards and aside, or two clusters of nodes pushed towards each other.  What is not balanced moves
the grain as a rigid body.  The elastic equilibrium (linear, dense matrices) gives the largest
stretch of a bond; printed is its ratio to the estimate without its factor: the factor has to be the
largest.
"""

from __future__ import annotations

import argparse

import numpy as np
from numpy.typing import NDArray
from peridem import cloud, shapes
from peridem.cloud import Cloud
from peridem.material import Material
from peridem.series import Elastic, elastic
from scipy.spatial import cKDTree

from bench import table

Array = NDArray[np.float64]
BULK, POISSON, NEIGHBOURS = 21.6e6, 0.25, 3.05
YOUNG = 3 * BULK * (1 - 2 * POISSON)


def solid_of(one: Cloud) -> Elastic:
    """The grain in plane strain."""
    spacing = np.median(cKDTree(one.nodes).query(one.nodes, k=2)[0][:, 1])
    horizon = NEIGHBOURS * float(spacing)
    return elastic(one, Material(bulk=BULK, poisson=POISSON, density=1.0, horizon=horizon))


def random_load(one: Cloud, rng: np.random.Generator, opposed: bool) -> Array:
    """Forces on the nodes, (n, 2)."""
    x, force = one.nodes, np.zeros_like(one.nodes)
    surface = np.flatnonzero(one.surface)
    if opposed:
        first = rng.choice(surface)
        inwards = -x[first] / np.linalg.norm(x[first])
        for side in (1.0, -1.0):
            order = np.argsort(np.linalg.norm(x[surface] - side * x[first], axis=1))
            near = surface[order[: rng.integers(1, 4)]]
            force[near] += side * inwards / len(near)
        return force
    nodes = rng.choice(surface, rng.integers(2, 7), replace=False)
    inwards = -x[nodes] / np.linalg.norm(x[nodes], axis=1)[:, None]
    aside = np.column_stack([-inwards[:, 1], inwards[:, 0]])
    slide = rng.uniform(-0.5, 0.5, len(nodes))[:, None]
    force[nodes] = (inwards + slide * aside) * rng.uniform(0.2, 1, len(nodes))[:, None]
    return force


def bending(one: Cloud, force: Array) -> tuple[Array, Array]:
    """Places from the centre, and the forces less those that move the grain as a rigid body."""
    mass = one.volumes
    r = one.nodes - one.centroid
    torque = float(np.sum(r[:, 0] * force[:, 1] - r[:, 1] * force[:, 0]))
    turning = torque / float(mass @ (r**2).sum(axis=1))
    acceleration = force.sum(axis=0) / mass.sum() + turning * np.column_stack([-r[:, 1], r[:, 0]])
    return r, force - mass[:, None] * acceleration


def ratios(solid: Elastic, loads: int, rng: np.random.Generator) -> Array:
    """Largest tension and largest stretch of either sign over the estimate, (loads, 2)."""
    one, found = solid.cloud, np.zeros((loads, 2))
    inverse = np.linalg.pinv(solid.stiffness, rcond=1e-11)  # rigid motion has no stiffness
    for k in range(loads):
        r, force = bending(one, random_load(one, rng, k % 3 == 0))
        stretch = solid.stretch @ (inverse @ force.ravel())
        stress = force.T @ r / one.volumes.sum()
        average = np.abs(np.linalg.eigvalsh(0.5 * (stress + stress.T))).max()
        node = np.max(np.linalg.norm(force, axis=1) / np.sqrt(one.volumes))
        estimate = (average + node) / YOUNG
        found[k] = max(stretch.max(), 0.0) / estimate, np.abs(stretch).max() / estimate
    return found


def main() -> None:
    """Print the table."""
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--loads", type=int, default=300, help="on each grain (300)")
    loads = options.parse_args().loads
    rng = np.random.default_rng(1)
    rows: list[table.Row] = []
    for shape in (shapes.circle, shapes.hexagon, shapes.triangle, shapes.drum):
        for spacing in (0.2, 0.12):
            one = cloud.mesh(shape(1.0), spacing)
            found = ratios(solid_of(one), loads, rng)
            rows.append(
                {
                    "shape": one.name,
                    "nodes": len(one.nodes),
                    "tension, median": float(np.median(found[:, 0])),
                    "tension, largest": float(found[:, 0].max()),
                    "either sign, median": float(np.median(found[:, 1])),
                    "either sign, largest": float(found[:, 1].max()),
                }
            )
    print(table.markdown(rows))


if __name__ == "__main__":
    main()
