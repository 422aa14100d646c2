"""Pictures: grains as filled shapes, wall stress, and VTU/PVD time series.

All of them read a folder that :mod:`peridem.scene` wrote and LAMMPS ran in. Grains are drawn by the
cells of their meshes. A cell is left out once one of its sides has been stretched beyond the
critical stretch in a dump so far, so cracks and fragments show. Outlines are drawn half a contact
radius outside the boundary nodes, which is where two grains touch.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from peridem import results
from peridem.cloud import unique_faces
from peridem.scene import DUMP, MESH, NODE_COLUMNS, SUMMARY, WALLS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
Cells = NDArray[np.int64]

COLUMN = {name: f"c_node[{i}]" for i, name in enumerate(NODE_COLUMNS, 1)}
INTACT, DARK, WALL = "#d5dde6", "#2b2f36", "#7b8490"
DAMAGE_COLOURS = (INTACT, "#f3c77b", "#e07b39", "#b3261e", "#5a1014")


@dataclass(frozen=True)
class PlacedWall:
    """A wall at some time: a point, the unit normal towards the grains, the velocity."""

    name: str
    point: Array
    normal: Array
    velocity: Array


class Output:
    """A folder of results.

    Attributes:
        folder: where they are.
        dump: frames.
        reference: (n, d) reference positions in the order of the atom IDs.
        cells: (m, d + 1) triangles or tetrahedra as rows of atom numbers from 0.
        contact_radius, timestep, dimension: of the scene.

    Raises:
        FileNotFoundError: a file of the scene or of the run is missing.
        ValueError: the dump has other atoms than the scene.
    """

    def __init__(self, folder: str | Path) -> None:
        import meshio

        self.folder = Path(folder)
        for name, maker in ((SUMMARY, "the scene"), (MESH, "the scene")):
            if not (self.folder / name).is_file():
                raise FileNotFoundError(f"no {name} of {maker} in {self.folder}")
        dumps = [self.folder / DUMP, self.folder / (DUMP + ".gz")]
        self.dump = results.Dump(next((d for d in dumps if d.is_file()), dumps[0]))
        self._summary: dict[str, Any] = json.loads((self.folder / SUMMARY).read_text())
        self.title: str = self._summary["title"]
        self.dimension: int = self._summary["dimension"]
        self.contact_radius: float = self._summary["contact_radius"]
        self.timestep: float = self._summary["timestep"]
        mesh = meshio.read(self.folder / MESH)
        self.reference: Array = mesh.points[:, : self.dimension]
        self.cells: Cells = mesh.cells[0].data.astype(np.int64)
        self.edges, _ = unique_faces(self.cells, 2)
        self._rest = self._lengths(self.reference)
        self._broken: list[NDArray[np.bool_]] = []

    def _lengths(self, position: Array) -> Array:
        ends = position[self.edges]
        return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))

    def time(self, i: int) -> float:
        """Time of frame i; of a run whose step changes, from its log file."""
        step, log = float(self.dump.steps[i]), self.folder / "log.lammps"
        if self._summary.get("adaptive") and log.is_file():
            table = results.thermo(log)
            return float(np.interp(step, table["Step"], table["Time"]))
        return step * self.timestep

    def walls(self, time: float) -> list[PlacedWall]:
        """The walls where they are at a time."""
        walls = []
        for wall in self._summary["walls"]:
            point, normal, velocity = (np.array(wall[k]) for k in ("point", "normal", "velocity"))
            walls.append(PlacedWall(wall["name"], point + time * velocity, normal, velocity))
        return walls

    def broken_edges(self, i: int) -> NDArray[np.bool_]:
        """Which sides of cells have been stretched beyond breaking up to frame i."""
        i = range(len(self.dump))[i]
        while len(self._broken) <= i:
            frame = self.dump[len(self._broken)]
            if len(frame["id"]) != len(self.reference):
                raise ValueError(
                    f"{self.dump.path} has {len(frame['id'])} atoms at step {frame.step}, "
                    f"the scene {len(self.reference)}"
                )
            stretch = self._lengths(frame.position) / self._rest - 1.0
            kind = frame["type"].astype(np.int64) - 1
            critical = np.array(
                [np.inf if s is None else s for s in self._summary["critical_stretch"]]
            )
            over = stretch > critical[kind[self.edges]].min(axis=1)
            before = self._broken[-1] if self._broken else np.zeros(len(over), dtype=bool)
            self._broken.append(over | before)
        return self._broken[i]

    def intact_cells(self, i: int) -> Cells:
        """The cells none of whose sides is broken at frame i."""
        broken = self.edges[self.broken_edges(i)]
        n = len(self.reference)
        codes = broken[:, 0] * n + broken[:, 1]
        ordered = np.sort(self.cells, axis=1)
        keep = np.ones(len(ordered), dtype=bool)
        for a in range(ordered.shape[1]):
            for b in range(a + 1, ordered.shape[1]):
                keep &= ~np.isin(ordered[:, a] * n + ordered[:, b], codes)
        return np.asarray(self.cells[keep])

    def pick(self, count: int) -> list[int]:
        """Numbers of so many frames, evenly spread from the first to the last."""
        return sorted(set(np.linspace(0, len(self.dump) - 1, count).round().astype(int).tolist()))


# ---- PNG -----------------------------------------------------------------------------------------


def draw_frame(axes: Axes, output: Output, i: int, top: float) -> None:
    """Draw frame i of a 2D scene into axes whose limits are set; damage colours end at ``top``."""
    from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection

    frame = output.dump[i]
    x, damage = frame.position, frame[COLUMN["damage"]]
    colours = damage_colours()
    for wall in output.walls(output.time(i)):
        axes.add_patch(_half_plane(wall, axes))

    cells = output.intact_cells(i)
    sides, count = unique_faces(cells, 2)
    rim = sides[count == 1]
    loose = np.setdiff1d(np.arange(len(x)), cells)
    unit = _points_per_unit(axes)
    width = output.contact_radius * unit  # in points
    outline = min(0.6, 0.15 * width)
    shade = colours(np.clip(damage[rim].mean(axis=1) / top, 0.0, 1.0))
    size = np.full(len(loose), output.contact_radius)
    # the dark rim lies inside, so that grains that touch do not hide each other's
    for grow, edge_colour in ((0.0, DARK), (-2.0 * outline, None)):
        lines = LineCollection(
            list(x[rim]),
            colors=shade if edge_colour is None else edge_colour,
            linewidths=width + grow,
            capstyle="round",
            zorder=2 if edge_colour else 3,
        )
        axes.add_collection(lines)
    if len(loose):
        axes.add_collection(
            EllipseCollection(
                size,
                size,
                np.zeros(len(loose)),
                units="xy",
                offsets=x[loose],
                offset_transform=axes.transData,
                facecolors=colours(np.clip(damage[loose] / top, 0.0, 1.0)),
                edgecolors=DARK,
                linewidths=0.5 * outline,
                zorder=3,
            )
        )
    fill = colours(np.clip(damage[cells].mean(axis=1) / top, 0.0, 1.0))
    axes.add_collection(
        PolyCollection(list(x[cells]), facecolors=fill, edgecolors=fill, linewidths=0.3, zorder=4)
    )


def grains_png(
    folder: str | Path, path: str | Path, frames: Sequence[int] | None = None, top: float = 0.6
) -> Path:
    """Grains at several times, coloured by damage (the broken part of each node's bonds).

    Args:
        folder: of the run.
        path: of the picture.
        frames: numbers of the dump's frames, negative from the end; None: four, evenly spread.
        top: damage at the end of the colour scale.

    Raises:
        ValueError: the scene is not 2D, or the dump is empty.
    """
    output = Output(folder)
    if output.dimension != 2:
        raise ValueError("pictures are drawn of 2D scenes; look at 3D ones through the PVD file")
    if len(output.dump) == 0:
        raise ValueError(f"{output.dump.path} has no frame")
    chosen = [range(len(output.dump))[i] for i in (output.pick(4) if frames is None else frames)]
    plt = _pyplot()
    x_low, x_high, y_low, y_high = _view(output, chosen)
    columns = min(len(chosen), 2 if x_high - x_low > 0.8 * (y_high - y_low) else 4)
    rows = -(-len(chosen) // columns)
    wide = 11.0 / columns
    high = wide * (y_high - y_low) / (x_high - x_low)
    head, foot = 0.5, 0.75
    figure = plt.figure(figsize=(11.0, rows * (high + 0.3) + head + foot), dpi=150)
    full_width, full = figure.get_size_inches()
    for k, i in enumerate(chosen):
        row, column = divmod(k, columns)
        bottom = full - head - (row + 1) * (high + 0.3)
        axes = figure.add_axes(
            (
                (column * wide + 0.05) / full_width,
                bottom / full,
                (wide - 0.1) / full_width,
                high * (wide - 0.1) / wide / full,
            )
        )
        axes.set_xlim(x_low, x_high)
        axes.set_ylim(y_low, y_high)
        axes.axis("off")
        draw_frame(axes, output, i, top)
        mean = output.dump[i][COLUMN["damage"]].mean()
        axes.set_title(
            f"$t_{{{k + 1}}}$ = {1e3 * output.time(i):.4g} ms, mean damage {mean:.3f}", fontsize=10
        )
    figure.text(0.5, 1.0 - 0.25 / full, output.title, ha="center", va="center", fontsize=13)
    bar = figure.add_axes((0.3, 0.45 / full, 0.4, 0.14 / full))
    figure.colorbar(
        plt.cm.ScalarMappable(plt.Normalize(0.0, top), damage_colours()),
        cax=bar,
        orientation="horizontal",
        extend="max" if top < 1.0 else "neither",
    ).set_label("damage (broken part of a node's bonds)", fontsize=9)
    figure.savefig(path)
    plt.close(figure)
    return Path(path)


def damage_colours() -> Any:
    """The colour map of damage, from intact (light) to broken (dark red)."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("damage", DAMAGE_COLOURS)


def _pyplot() -> Any:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def _view(output: Output, frames: Sequence[int]) -> tuple[float, float, float, float]:
    """Limits around nodes and walls in the chosen frames."""
    points = [output.dump[i].position for i in frames]
    for i in frames:
        points += [wall.point[None, :] for wall in output.walls(output.time(i))]
    everything = np.vstack(points)
    margin = 3.0 * output.contact_radius
    low, high = everything.min(axis=0) - margin, everything.max(axis=0) + margin
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def _points_per_unit(axes: Axes) -> float:
    """Printer's points per unit of length along x."""
    low, high = axes.get_xlim()
    figure = axes.get_figure()
    assert figure is not None
    inches = axes.get_position().width * figure.get_size_inches()[0]  # type: ignore[union-attr]
    return float(72.0 * inches / (high - low))


def _half_plane(wall: PlacedWall, axes: Axes) -> Any:
    """The side behind a wall, drawn to the edge of the axes."""
    from matplotlib.patches import Polygon

    size = 2.0 * float(np.ptp(axes.get_xlim()) + np.ptp(axes.get_ylim()))
    along = np.array([-wall.normal[1], wall.normal[0]])
    back = wall.point - size * wall.normal
    corners = [
        wall.point - size * along,
        wall.point + size * along,
        back + size * along,
        back - size * along,
    ]
    return Polygon(np.array(corners), facecolor=WALL, edgecolor="none", zorder=1)


# ---- wall stress ---------------------------------------------------------------------------------


def wall_stress(folder: str | Path, wall: str | None = None) -> tuple[Array, Array]:
    """How far a moving wall has gone, and the pressure on it: (n,) and (n,).

    The pressure is the force of the grains along the wall's normal over its area, which in 2D is
    the distance of the two walls across it.

    Args:
        folder: of the run.
        wall: its name; None: the only one that moves.

    Raises:
        ValueError: no such wall, or no pair of walls across it.
    """
    output_file = Path(folder) / WALLS
    summary = json.loads((Path(folder) / SUMMARY).read_text())
    walls = {w["name"]: w for w in summary["walls"]}
    moving = [name for name, w in walls.items() if any(w["velocity"])]
    if wall is None:
        if len(moving) != 1:
            raise ValueError(f"say which wall: {', '.join(moving) or 'none'} of them moves")
        wall = moving[0]
    if wall not in moving:
        raise ValueError(f"no moving wall '{wall}'; there are {', '.join(moving) or 'none'}")
    if summary["dimension"] != 2:
        raise ValueError("the area of a wall is known in 2D only")
    normal = np.array(walls[wall]["normal"])
    along = np.array([-normal[1], normal[0]])
    across = [
        float(along @ np.array(w["point"]))
        for w in walls.values()
        if abs(along @ np.array(w["normal"])) > 1.0 - 1e-9
    ]
    if len(across) != 2:
        raise ValueError(f"the area of wall '{wall}' needs two walls across it, not {len(across)}")
    record = results.averages(output_file)
    force = np.column_stack([record[f"f_{wall}[{k}]"] for k in (1, 2)])
    return record[f"v_{wall}_travel"], -(force @ normal) / abs(across[1] - across[0])


def stress_png(
    folder: str | Path,
    path: str | Path,
    wall: str | None = None,
    frames: Sequence[int] | None = None,
) -> Path:
    """Pressure on a moving wall against how far it has gone; marks at the times of ``frames``."""
    output = Output(folder)
    travel, stress = wall_stress(folder, wall)
    window = max(1, len(stress) // 50)
    smooth = np.convolve(stress, np.full(window, 1.0 / window), "valid")
    middle = np.convolve(travel, np.full(window, 1.0 / window), "valid")
    unit, name = (1e3, "kPa") if smooth.max() < 1e6 else (1e6, "MPa")
    plt = _pyplot()
    figure, axes = plt.subplots(figsize=(7.0, 4.2), dpi=150, layout="constrained")
    record = results.averages(Path(folder) / WALLS)
    times = record.get("v_now", record["TimeStep"] * output.timestep)
    every = 1e3 * float(times[-1]) / len(times)
    for x, y, colour, line, span in (
        (travel, stress, "#9db4cc", 0.7, every),
        (middle, smooth, "#1f4e79", 1.8, window * every),
    ):
        label = f"averaged over {span:.2g} ms"
        axes.plot(1e3 * x, y / unit, color=colour, lw=line, label=label)
    chosen = [range(len(output.dump))[i] for i in (output.pick(4) if frames is None else frames)]
    speed = travel[-1] / times[-1]
    for k, i in enumerate(chosen):
        at = output.time(i) * speed
        value = float(np.interp(at, middle, smooth)) / unit
        axes.plot(1e3 * at, value, "o", mfc="white", mec="#b3261e", ms=6, zorder=5)
        axes.annotate(f"$t_{{{k + 1}}}$", (1e3 * at, value), (4, 8), textcoords="offset points")
    axes.set_xlabel("penetration of the wall (mm)")
    axes.set_ylabel(f"pressure on the wall ({name})")
    axes.set_xlim(0.0, 1.04e3 * float(travel[-1]))
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    figure.savefig(path)
    plt.close(figure)
    return Path(path)


# ---- VTU and PVD ---------------------------------------------------------------------------------


def pvd(folder: str | Path, path: str | Path) -> Path:
    """A time series for ParaView: a .pvd file, and beside it a folder with a .vtu for each frame.

    Points carry damage, the other columns of the dump, velocity, displacement and grain; nodes that
    have lost all their cells are there as single points. 2D walls are a second part.
    """
    import meshio

    output, path = Output(folder), Path(path)
    pieces = path.with_suffix("")
    pieces.mkdir(parents=True, exist_ok=True)
    kind = {2: "triangle", 3: "tetra"}[output.dimension]
    view = _view(output, range(len(output.dump))) if output.dimension == 2 else None
    entries = []
    for i, frame in enumerate(output.dump):
        cells = output.intact_cells(i)
        loose = np.setdiff1d(np.arange(len(output.reference)), cells)
        blocks: list[tuple[str, Cells]] = [(kind, cells)]
        if len(loose):
            blocks.append(("vertex", loose[:, None]))
        fields = {"grain": frame["mol"].astype(np.int32)}
        fields |= {
            name: frame[column].astype(np.float32)
            for name, column in COLUMN.items()
            if column in frame.columns
        }
        velocity = np.column_stack([frame[f"v{k}"] for k in "xyz"[: output.dimension]])
        fields["velocity"] = _three(velocity).astype(np.float32)
        fields["displacement"] = _three(frame.position - output.reference).astype(np.float32)
        name = f"grains_{i:04d}.vtu"
        meshio.Mesh(_three(frame.position), blocks, point_data=fields).write(pieces / name)
        entries.append((output.time(i), 0, f"{pieces.name}/{name}"))
        if view is not None and output.walls(0.0):
            name = f"walls_{i:04d}.vtu"
            _walls_mesh(output, output.time(i), view).write(pieces / name)
            entries.append((output.time(i), 1, f"{pieces.name}/{name}"))
    lines = ['<?xml version="1.0"?>', '<VTKFile type="Collection" version="0.1">', "<Collection>"]
    lines += [
        f'<DataSet timestep="{time:.9g}" part="{part}" file="{name}"/>'
        for time, part, name in entries
    ]
    path.write_text("\n".join([*lines, "</Collection>", "</VTKFile>"]) + "\n")
    return path


def _three(vectors: Array) -> Array:
    """Vectors with a z of 0 where they have none."""
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))


def _walls_mesh(output: Output, time: float, view: tuple[float, float, float, float]) -> Any:
    """The lines of plane walls inside a rectangle."""
    import meshio

    points: list[Array] = []
    for wall in output.walls(time):
        along = np.array([-wall.normal[1], wall.normal[0]])
        # parameters at which the line meets the sides of the rectangle
        low, high = -np.inf, np.inf
        for k in range(2):
            if abs(along[k]) > 1e-12:
                ends = (np.array(view[2 * k : 2 * k + 2]) - wall.point[k]) / along[k]
                low, high = max(low, ends.min()), min(high, ends.max())
        points += [wall.point + low * along, wall.point + high * along]
    lines = np.arange(len(points)).reshape(-1, 2)
    return meshio.Mesh(_three(np.array(points)), [("line", lines)])
