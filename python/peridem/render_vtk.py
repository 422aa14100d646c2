"""Time series for ParaView."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from peridem import render_2d
from peridem.results_output import Output

Array = NDArray[np.float64]


def pvd(folder: str | Path, path: str | Path) -> Path:
    """A time series for ParaView: a .pvd file, and beside it a folder with a .vtu for each frame.

    Points carry grain, damage and the other attributes of ``compute peridem/atom``, the other
    columns of the dump, velocity and displacement; cells carry the grain. Cells that are broken are
    left out; nodes that have lost all their cells are there as single points. 2D walls are a second
    part.
    """
    import meshio

    output, path = Output(folder), Path(path)
    pieces = path.with_suffix("")
    pieces.mkdir(parents=True, exist_ok=True)
    flat = output.dimension == 2
    frame_view = render_2d.view(output, range(len(output.dump))) if flat else None
    entries = []
    for i in range(len(output.dump)):
        name = f"grains_{i:04d}.vtu"
        _grains(output, i).write(pieces / name)
        time = output.time(i)
        entries.append((time, 0, f"{pieces.name}/{name}"))
        if frame_view is not None and output.walls(time):
            name = f"walls_{i:04d}.vtu"
            points, ends = _wall_lines(output, time, frame_view)
            meshio.Mesh(points, [("line", ends)]).write(pieces / name)
            entries.append((time, 1, f"{pieces.name}/{name}"))
    lines = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1">', "<Collection>"]
    lines += [
        f'<DataSet timestep="{time:.9g}" part="{part}" file="{name}"/>'
        for time, part, name in entries
    ]
    # last, so that it never names files that are not there
    path.write_text("\n".join([*lines, "</Collection>", "</VTKFile>"]) + "\n")
    return path


def _grains(output: Output, i: int) -> Any:
    import meshio

    frame, cells = output.frame(i), output.intact_cells(i)
    kind = {2: "triangle", 3: "tetra"}[output.dimension]
    loose = np.setdiff1d(np.arange(len(output.reference)), cells)
    blocks: list[tuple[str, NDArray[np.int64]]] = [(kind, cells)]
    if len(loose):
        blocks.append(("vertex", loose[:, None]))
    known = {"id", "mol", "x", "y", "z", "vx", "vy", "vz", *output.attributes.values()}
    grain = frame["mol"].astype(np.int32)
    fields: dict[str, NDArray[Any]] = {"grain": grain}
    fields |= {n: frame[c].astype(np.float32) for n, c in output.attributes.items()}
    fields |= {c: v.astype(np.float32) for c, v in frame.columns.items() if c not in known}
    if "vx" in frame:
        fields["velocity"] = _three(frame.velocity).astype(np.float32)
    moved = frame.position[:, : output.dimension] - output.reference
    fields["displacement"] = _three(moved).astype(np.float32)
    cell_data = {"grain": [grain[block[:, 0]] for _, block in blocks]}
    return meshio.Mesh(_three(frame.position), blocks, point_data=fields, cell_data=cell_data)


def _three(vectors: Array) -> Array:
    """Vectors with a z of 0 where they have none."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))


def _wall_lines(
    output: Output, time: float, frame_view: tuple[float, float, float, float]
) -> tuple[Array, NDArray[np.int64]]:
    """The lines of plane walls inside a rectangle."""
    points: list[Array] = []
    for wall in output.walls(time):
        along = np.array([-wall.normal[1], wall.normal[0]])
        # parameters at which the line meets the sides of the rectangle
        low, high = -np.inf, np.inf
        for k in range(2):
            if abs(along[k]) > 1e-12:
                ends = (np.array(frame_view[2 * k : 2 * k + 2]) - wall.point[k]) / along[k]
                low, high = max(low, ends.min()), min(high, ends.max())
        points += [wall.point + low * along, wall.point + high * along]
    return _three(np.array(points)), np.arange(len(points)).reshape(-1, 2)
