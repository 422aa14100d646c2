"""Forces on moving walls: pressure against penetration."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from peridem.results_output import Output
from peridem.results_tables import averages
from peridem.scene import WALLS

Array = NDArray[np.float64]


def wall_stress(folder: str | Path, wall: str | None = None) -> tuple[Array, Array]:
    """How far a moving wall has gone, and the pressure on it: (n,) and (n,).

    The pressure is the force of the grains along the wall's normal over its area: in 2D the
    distance of the two walls across it, in 3D the product of the distances of two pairs of walls.

    Args:
        folder: of the run, of a scene that :mod:`peridem.scene` wrote.
        wall: its name; None: the only one that moves.

    Raises:
        ValueError: no such wall, no record of it, or no pairs of walls across it.
    """
    output = Output(folder)
    walls = {placed.name: placed for placed in output.walls(0.0)}
    moving = [name for name, placed in walls.items() if placed.velocity.any()]
    if wall is None:
        if len(moving) != 1:
            raise ValueError(f"say which wall: {', '.join(moving) or 'none'} of them moves")
        wall = moving[0]
    if wall not in moving:
        raise ValueError(f"no moving wall '{wall}'; there are {', '.join(moving) or 'none'}")
    area = _area(output, wall)
    path = output.folder / WALLS
    if not path.is_file():
        raise ValueError(f"no file {path}: scripts of scenes with walls that move write it")
    record = averages(path)
    force = np.column_stack([record[f"f_{wall}[{k}]"] for k in range(1, output.dimension + 1)])
    return record[f"v_{wall}_travel"], -(force @ walls[wall].normal) / area


def _area(output: Output, wall: str) -> float:
    """What the walls across leave between them."""
    walls = output.walls(0.0)
    normal = next(placed.normal for placed in walls if placed.name == wall)
    area, pairs = 1.0, 0
    beside = [placed for placed in walls if abs(placed.normal @ normal) < 1e-9]
    while beside:
        along = beside[0].normal
        parallel = [placed for placed in beside if abs(placed.normal @ along) > 1.0 - 1e-9]
        beside = [placed for placed in beside if abs(placed.normal @ along) <= 1.0 - 1e-9]
        if len(parallel) == 2:
            area *= abs(float(along @ (parallel[1].point - parallel[0].point)))
            pairs += 1
    if pairs != output.dimension - 1:
        wanted = "two walls" if output.dimension == 2 else "two pairs of walls"
        raise ValueError(f"the area of wall '{wall}' needs {wanted} across it")
    return area


def from_contact(travel: Array, stress: Array, level: float = 0.01, lasting: int = 10) -> Array:
    """Penetration counted from a wall's first lasting contact.

    Args:
        travel: (n,) how far it has gone.
        stress: (n,) pressure on it.
        level: of the highest pressure, above which there is contact.
        lasting: so many records in a row.

    Raises:
        ValueError: there is no such contact.
    """
    touching = stress > level * stress.max()
    runs = np.convolve(touching, np.ones(lasting), "valid") >= lasting
    if not runs.any():
        raise ValueError(f"no contact that lasts for {lasting} records")
    return np.asarray(travel - travel[int(np.argmax(runs))])
