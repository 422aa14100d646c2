"""What a picture shows: which field, in which colours, between which values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from peridem.results_output import Output

Array = NDArray[np.float64]

INTACT, DARK, WALL, CHAIN = "#d5dde6", "#2b2f36", "#7b8490", "#b3261e"
DAMAGE_COLOURS = (INTACT, "#f3c77b", "#e07b39", "#b3261e", "#5a1014")
LABELS = {
    "damage": "damage (broken part of a node's bonds)",
    "stretch": "largest stretch over critical stretch",
    "dilatation": "dilatation",
    "energy": "strain energy of a node (J)",
    "bonds": "intact bonds of a node",
    "speed": "speed (m/s)",
    "displacement": "displacement (m)",
}
NAMES = ("grain", "fragment", "mol", "type", "id")  # values that are names, not amounts


@dataclass(frozen=True)
class Style:
    """Colours of a field.

    Attributes:
        field: as of :meth:`Output.field`.
        low, high: ends of the colour scale.
        colours: name of a map of matplotlib; '' picks one that suits the field.
    """

    field: str
    low: float
    high: float
    colours: str = ""

    @property
    def label(self) -> str:
        """Beside the colour bar."""
        return LABELS.get(self.field, self.field)

    @property
    def is_name(self) -> bool:
        """Whether the field holds names; then neighbours get different colours, without a scale."""
        return self.field in NAMES

    def map(self) -> Any:
        """The colour map."""
        import matplotlib

        if self.colours:
            if self.colours not in matplotlib.colormaps:
                raise ValueError(f"no colour map '{self.colours}' in matplotlib")
            return matplotlib.colormaps[self.colours]
        if self.field == "damage":
            return damage_colours()
        if self.is_name:
            return matplotlib.colormaps["tab20"]
        return matplotlib.colormaps["RdBu_r" if self.low < 0.0 < self.high else "viridis"]

    def shade(self, values: Array) -> Array:
        """Values between 0 and 1 for the colour map."""
        if self.is_name:
            return np.asarray((values.astype(np.int64) * 7) % 20 / 19.999)
        span = self.high - self.low
        return np.clip((values - self.low) / (span if span > 0.0 else 1.0), 0.0, 1.0)


def style_of(
    output: Output,
    frames: Sequence[int],
    field: str = "damage",
    low: float | None = None,
    high: float | None = None,
    colours: str = "",
) -> Style:
    """A style whose scale spans the values in some frames, without the outermost two per cent.

    Damage goes from 0 to 0.6 unless told otherwise; a field with values on both sides of 0 is
    centred there.

    Args:
        output: of the run.
        frames: numbers of those that are drawn.
        field: one of :meth:`peridem.results.Output.fields`.
        low, high: ends of the scale; None: found.
        colours: name of a colour map of matplotlib; empty: one that suits the field.
    """
    if field == "damage" and field not in output.attributes:
        field = "grain"  # a run without damage in its dump
    if field == "damage":
        return _checked(Style(field, *_ends(low, high, 0.0, 0.6), colours))
    values = np.concatenate([output.field(field, i) for i in frames])
    values = values[np.isfinite(values)]
    bottom, top = (float(v) for v in np.percentile(values, [1.0, 99.0])) if len(values) else (0, 1)
    if bottom < 0.0 < top and field not in NAMES:
        top = max(-bottom, top)
        bottom = -top
    return _checked(Style(field, *_ends(low, high, bottom, top), colours))


def _ends(low: float | None, high: float | None, bottom: float, top: float) -> tuple[float, float]:
    return bottom if low is None else low, top if high is None else high


def _checked(style: Style) -> Style:
    if not style.low <= style.high:
        raise ValueError(
            f"colour scale of '{style.field}': it must start below its end, not go from "
            f"{style.low:g} to {style.high:g}"
        )
    style.map()
    return style


def damage_colours() -> Any:
    """The colour map of damage, from intact (light) to broken (dark red)."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("damage", DAMAGE_COLOURS)


def time_text(seconds: float) -> str:
    """A time in a unit that suits it."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if abs(seconds) >= size or unit == "µs":
            return f"{seconds / size:.4g} {unit}" if seconds else "0 s"
    return f"{seconds:g} s"
