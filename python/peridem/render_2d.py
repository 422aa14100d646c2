"""Drawing one frame of a 2D scene: grains as filled shapes, walls, force chains."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from peridem import results_contacts
from peridem.cloud import unique_faces
from peridem.render_style import CHAIN, DARK, WALL, Style
from peridem.results_fragments import labels
from peridem.results_output import Output, PlacedRegion, PlacedWall

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

PIXELS = 800  # across a picture, on which it is asked what is wall
WIDEST = 0.5  # line of the largest force, in contact radii


def draw_frame(
    axes: Axes, output: Output, i: int, style: Style, chains: float | None = None
) -> None:
    """Draw frame i into axes whose limits are set.

    Args:
        axes: of matplotlib.
        output: a folder of a 2D run.
        i: number of the frame.
        style: which field, in which colours.
        chains: draw the network of contact forces, its widest line for this force; None: do not.
    """
    from matplotlib.collections import LineCollection, PolyCollection

    x = output.frame(i).position[:, :2]
    colours, shade = style.map(), style.shade(output.field(style.field, i))
    for wall in output.walls(output.time(i)):
        axes.add_patch(_half_plane(wall, axes))
    for region in output.regions(output.time(i)):
        _draw_region(axes, region)
    cells = output.intact_cells(i)
    rim = _rim(cells)
    loose = np.setdiff1d(np.arange(len(x)), cells)
    width = output.contact_radius * points_per_unit(axes)  # in points
    outline = min(0.6, 0.15 * width)
    rim_shade = colours(shade[rim[:, 0]] if style.is_name else shade[rim].mean(axis=1))
    # the dark rim lies inside, so that grains that touch do not hide each other's
    for grow, edge_colour in ((0.0, DARK), (-2.0 * outline, None)):
        lines = LineCollection(
            list(x[rim]),
            colors=rim_shade if edge_colour is None else edge_colour,
            linewidths=width + grow,
            capstyle="round",
            zorder=2 if edge_colour else 3,
        )
        axes.add_collection(lines)
    if len(loose):
        dots = _dots(axes, x[loose], output.contact_radius, colours(shade[loose]), outline)
        axes.add_collection(dots)
    fill = colours(shade[cells[:, 0]] if style.is_name else shade[cells].mean(axis=1))
    axes.add_collection(
        PolyCollection(list(x[cells]), facecolors=fill, edgecolors=fill, linewidths=0.3, zorder=4)
    )
    if chains is not None:
        draw_chains(axes, output, i, chains)


def _dots(axes: Axes, x: Array, diameter: float, fill: Array, outline: float) -> Any:
    """Nodes that hang on no cell."""
    from matplotlib.collections import EllipseCollection

    size = np.full(len(x), diameter)
    return EllipseCollection(
        size,
        size,
        np.zeros(len(x)),
        units="xy",
        offsets=x,
        offset_transform=axes.transData,
        facecolors=fill,
        edgecolors=DARK,
        linewidths=0.5 * outline,
        zorder=3,
    )


def _rim(cells: Any) -> Any:
    """Sides that belong to one cell only."""
    if len(cells) == 0:
        return np.zeros((0, 2), dtype=np.int64)
    sides, count = unique_faces(cells, 2)
    return sides[count == 1]


def chain_segments(output: Output, i: int) -> tuple[Array, Array]:
    """Lines of the network of forces at frame i, (s, 2, d), and the force along each, (s,).

    Each contact of two bodies gives two lines, from the point where they touch to the centre of
    either; a contact with a wall gives one, from the centre to the wall. Bodies are fragments
    where the dump has the attribute ``fragment``, else grains.
    """
    bodies = output.frame(i)["mol"].astype(np.int64)
    if "fragment" in output.attributes:
        bodies = labels(output, i)
    found = results_contacts.network(results_contacts.contacts(output, i, bodies))
    place = _centres(output, i, bodies)
    lines, force = [], []
    for (a, b), point, strength in zip(found.bodies, found.point, found.strength, strict=True):
        lines += [(place[int(a)], point), (point, place[int(b)])]
        force += [strength, strength]
    walls = {wall.name: wall for wall in output.walls(output.time(i))}
    for name, (names, forces) in results_contacts.wall_forces(output, i, bodies).items():
        wall = walls[name]
        for grain, push in zip(names.tolist(), forces, strict=True):
            foot = place[grain] - ((place[grain] - wall.point) @ wall.normal) * wall.normal
            lines.append((place[grain], foot))
            force.append(float(np.linalg.norm(push)))
    return np.array(lines).reshape(-1, 2, output.dimension), np.array(force)


def _centres(output: Output, i: int, bodies: NDArray[np.int64]) -> dict[int, Array]:
    """Centres of volume of the bodies, by name."""
    x = output.frame(i).position[:, : output.dimension]
    names, member = np.unique(bodies, return_inverse=True)
    total = np.zeros((len(names), x.shape[1]))
    np.add.at(total, member, x * output.volumes[:, None])
    total /= np.bincount(member, output.volumes)[:, None]
    return dict(zip(names.tolist(), total, strict=True))


def strongest(output: Output, frames: Sequence[int]) -> float:
    """The force that the widest line of a series of pictures stands for: nearly the largest."""
    force = np.concatenate([chain_segments(output, i)[1] for i in frames])
    return float(np.percentile(force, 98.0)) if len(force) else 1.0


def draw_chains(axes: Axes, output: Output, i: int, largest: float) -> None:
    """Draw the network of contact forces, the width of its lines in proportion to the force.

    Args:
        axes: where.
        output: of the run.
        i: number of the frame.
        largest: force of the widest line; 0: forces are widths as they are.
    """
    from matplotlib.collections import LineCollection

    lines, force = chain_segments(output, i)
    part = np.clip(force / largest if largest > 0.0 else force, 0.0, 1.2)
    keep = part > 0.01
    widest = max(WIDEST * _grain_size(output) * points_per_unit(axes), 1.0)
    axes.add_collection(
        LineCollection(
            list(lines[keep]),
            colors=CHAIN,
            linewidths=widest * part[keep],
            alpha=0.8,
            capstyle="round",
            zorder=6,
        )
    )


def _grain_size(output: Output) -> float:
    """About a quarter of the diameter of a usual grain: what the width of chains is measured by."""
    volume = np.bincount(output.frame(0)["mol"].astype(np.int64), output.volumes)
    return 0.25 * float(np.sqrt(np.median(volume[volume > 0.0])))


def view(output: Output, frames: Sequence[int]) -> tuple[float, float, float, float]:
    """Limits around nodes and walls in some frames: x low, x high, y low, y high."""
    points = []
    for i in frames:
        points.append(output.frame(i).position[:, :2])
        points += [wall.point[None, :2] for wall in output.walls(output.time(i))]
        points += [region.corners for region in output.regions(output.time(i))]
    everything = np.vstack(points)
    margin = 3.0 * output.contact_radius
    low, high = everything.min(axis=0) - margin, everything.max(axis=0) + margin
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def points_per_unit(axes: Axes) -> float:
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


def _draw_region(axes: Axes, wall: PlacedRegion) -> None:
    """All that is not on the free side of a region."""
    from matplotlib.colors import to_rgba

    (x_low, x_high), (y_low, y_high) = axes.get_xlim(), axes.get_ylim()
    rows = max(1, round(PIXELS * (y_high - y_low) / (x_high - x_low)))
    x = x_low + (np.arange(PIXELS) + 0.5) / PIXELS * (x_high - x_low)
    y = y_low + (np.arange(rows) + 0.5) / rows * (y_high - y_low)
    points = np.column_stack([values.ravel() for values in np.meshgrid(x, y)])
    solid = ~wall.contains(points).reshape(rows, PIXELS)
    picture = np.empty((rows, PIXELS, 4))
    picture[:] = to_rgba(WALL)
    picture[..., 3] = solid
    axes.imshow(
        picture,
        extent=(x_low, x_high, y_low, y_high),
        origin="lower",
        interpolation="bilinear",
        aspect="auto",
        zorder=1,
    )
    axes.set(xlim=(x_low, x_high), ylim=(y_low, y_high))
