"""Pictures, films, plots of wall stress, and time series for ParaView.

All of them read a folder that LAMMPS ran in (:class:`peridem.results.Output`). Grains are drawn by
the cells of their meshes. A cell is left out once one of its sides has been stretched beyond the
critical stretch in a dump so far, so cracks and fragments show. In 2D, outlines are drawn half a
contact radius outside the boundary nodes, which is where two grains touch.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from peridem import render_2d, render_3d
from peridem.render_3d import Camera
from peridem.render_plots import fragments_png, stress_png, thermo_png
from peridem.render_style import INTACT, WALL, Style, damage_colours, style_of, time_text
from peridem.render_vtk import pvd
from peridem.results_output import Output
from peridem.results_walls import wall_stress

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "INTACT",
    "WALL",
    "Camera",
    "Output",
    "Style",
    "animation",
    "damage_colours",
    "fragments_png",
    "grains_png",
    "pvd",
    "stress_png",
    "thermo_png",
    "wall_stress",
]

Array = NDArray[np.float64]

WIDTH = 11.0  # inches of a picture of several frames
SLIMMEST = 100.0  # length over width of what fits into a picture


def grains_png(
    folder: str | Path,
    path: str | Path,
    frames: Sequence[int] | None = None,
    top: float | None = None,
    *,
    field: str = "damage",
    bottom: float | None = None,
    colours: str = "",
    chains: bool = False,
    camera: Camera | None = None,
) -> Path:
    """Grains at several times, coloured by a field.

    Args:
        folder: of the run.
        path: of the picture: .png, .pdf, .svg.
        frames: numbers of the dump's frames, negative from the end; None: four, evenly spread.
        top: end of the colour scale (0.6 for damage; else what the field reaches).
        field: ``damage`` or another one that :meth:`peridem.results.Output.fields` lists.
        bottom: start of the colour scale.
        colours: name of a colour map of matplotlib.
        chains: draw the forces between grains as lines (2D).
        camera: of a 3D scene.

    Raises:
        ValueError: no such frame, nodes that have flown far away, or forces asked for in 3D.
        KeyError: no such field.
    """
    from matplotlib.figure import Figure as NewFigure

    output = Output(folder)
    chosen = output.chosen(frames, 4)
    style = style_of(output, chosen, field, bottom, top, colours)
    panel = _Panel(output, chosen, style, chains, camera)
    columns = min(len(chosen), 2 if panel.aspect < 1.25 else 4)
    rows = -(-len(chosen) // columns)
    wide = WIDTH / columns
    high = wide * panel.aspect
    head, foot = 0.5, 0.2 if style.is_name else 0.75
    full = rows * (high + 0.3) + head + foot
    figure = NewFigure(figsize=(WIDTH, full), dpi=150)
    for k, i in enumerate(chosen):
        row, column = divmod(k, columns)
        bottom_edge = full - head - (row + 1) * (high + 0.3)
        axes = figure.add_axes(
            (
                (column * wide + 0.05) / WIDTH,
                bottom_edge / full,
                (wide - 0.1) / WIDTH,
                high * (wide - 0.1) / wide / full,
            )
        )
        panel.draw(axes, i)
        title = f"$t_{{{k + 1}}}$ = {time_text(output.time(i))}"
        if style.field == "damage":
            title += f", mean damage {output.mean_damage(i):.3f}"
        axes.set_title(title, fontsize=10)
    figure.text(0.5, 1.0 - 0.25 / full, output.title, ha="center", va="center", fontsize=13)
    if not style.is_name:
        _colour_bar(figure, style, full)
    figure.savefig(path)
    return Path(path)


def _colour_bar(figure: Figure, style: Style, high: float) -> None:
    """The colour scale below the frames of a figure so many inches high."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    figure.colorbar(
        ScalarMappable(Normalize(style.low, style.high), style.map()),
        cax=figure.add_axes((0.3, 0.45 / high, 0.4, 0.14 / high)),
        orientation="horizontal",
        extend="max" if style.field == "damage" and style.high < 1.0 else "neither",
    ).set_label(style.label, fontsize=9)


def animation(
    folder: str | Path,
    path: str | Path,
    frames: Sequence[int] | None = None,
    top: float | None = None,
    *,
    field: str = "damage",
    bottom: float | None = None,
    colours: str = "",
    chains: bool = False,
    camera: Camera | None = None,
    rate: float = 15.0,
    width: int = 800,
) -> Path:
    """A film of the run: .mp4 (H.264) or .gif.

    Args:
        folder, path, frames, top, field, bottom, colours, chains, camera: as of
            :func:`grains_png`; None for frames: all.
        rate: frames per second.
        width: of the film, in pixels.

    Raises:
        ValueError: another ending of the path; else as :func:`grains_png`.
    """
    import imageio.v3 as iio

    path = Path(path)
    if path.suffix not in (".mp4", ".gif"):
        raise ValueError(f"a film ends in .mp4 or .gif, not '{path.name}'")
    if not (math.isfinite(rate) and rate > 0.0):
        raise ValueError(f"a film needs more than 0 frames per second, not {rate:g}")
    output = Output(folder)
    chosen = output.chosen(frames, len(output.dump))
    style = style_of(output, chosen, field, bottom, top, colours)
    pictures = _pictures(_Panel(output, chosen, style, chains, camera), chosen, width)
    part = path.with_name(f"part-{path.name}")
    if path.suffix == ".gif":
        iio.imwrite(part, list(pictures), duration=1000.0 / rate, loop=0)
    else:
        words: dict[str, Any] = {"fps": rate, "codec": "libx264", "macro_block_size": 2}
        iio.imwrite(part, list(pictures), plugin="FFMPEG", **words)
    part.replace(path)
    return path


def _pictures(panel: _Panel, frames: Sequence[int], width: int) -> Iterator[NDArray[np.uint8]]:
    """Each frame as an array of pixels, all of one size."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    inches, head = width / 100.0, 0.35
    rows = round(inches * panel.aspect * 50) / 50  # an even number of pixels, as films need
    for i in frames:
        figure = Figure(figsize=(inches, rows + head - 0.01), dpi=100)
        figure.set_size_inches(inches, (round((rows + head) * 50) * 2) / 100)
        high = figure.get_size_inches()[1]
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0 - head / high))
        panel.draw(axes, i)
        figure.text(0.02, 1.0 - 0.5 * head / high, time_text(panel.output.time(i)), va="center")
        canvas: Any = FigureCanvasAgg(figure)
        canvas.draw()
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


class _Panel:
    """Draws frames of one run, all to the same scale."""

    def __init__(
        self,
        output: Output,
        frames: list[int],
        style: Style,
        chains: bool,
        camera: Camera | None,
    ) -> None:
        self.output, self.style = output, style
        self._camera = camera
        self._flat = output.dimension == 2
        self._largest: float | None = None
        if chains and not self._flat:
            raise ValueError("force chains are drawn in 2D scenes only")
        if chains:
            self._largest = render_2d.strongest(output, frames)
        if self._flat:
            self._view = render_2d.view(output, frames)
            x_low, x_high, y_low, y_high = self._view
            self.aspect = (y_high - y_low) / (x_high - x_low)
            if not 1.0 / SLIMMEST < self.aspect < SLIMMEST:
                raise ValueError(
                    f"the nodes of these frames reach from x = {x_low:.3g} to {x_high:.3g} and y = "
                    f"{y_low:.3g} to {y_high:.3g}, which is no picture: has something flown away?"
                )
        else:
            self._bounds = render_3d.bounds_of(output, frames)
            self.aspect = 1.0

    def draw(self, axes: Any, i: int) -> None:
        """One frame into empty axes."""
        axes.axis("off")
        if self._flat:
            axes.set_xlim(*self._view[:2])
            axes.set_ylim(*self._view[2:])
            render_2d.draw_frame(axes, self.output, i, self.style, self._largest)
        else:
            shot = render_3d.image(self.output, i, self.style, self._bounds, camera=self._camera)
            axes.imshow(shot, interpolation="antialiased")
