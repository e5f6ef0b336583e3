"""Common style of figures, pictures and pages: colours, units for reading, round numbers."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from exudyn_crawler.files import whole_file

GROUND, GROUND_EDGE = "#e2d3b3", "#8a7748"
SHOE, FLEXIBLE_SHOE, SHOE_EDGE = "#9fb1bd", "#d98c3f", "#3c4a54"
ROLLER, ROLLER_EDGE, BEAM = "#6c7a52", "#333d22", "#b9bfa6"
TUMBLER, LUG = "#c9a53a", "#f4f1e6"
CONTACT_FORCE, ROLLER_FORCE, TOOTH_FORCE = "#1f4fd8", "#8a1fb0", "#c0271d"
STRESS_MAP, HEAVE_MAP, SINKAGE_MAP = "YlOrRd", "cividis", "YlOrBr"
"""Colour maps of stress, heave and sinkage; those of stress and sinkage begin pale, so that shading shows
shape."""
PHASE_BANDS, PHASE_NAME = ("#eef2f6", "#fbfaf4"), "#66727d"
"""Colours of the bands of phases behind curves, in turn, and of the names of phases."""

NOT_KNOWN = "#9aa3a9"  # colour of a missing value

MEGA = 1e6
KILO = 1e3
MILLI = 1e-3
NEGLIGIBLE, NEGLIGIBLE_FORCE = 1e-6, 1e-3
"""Half the least range of an axis, in units for reading; rounding must not look like motion or a force."""

STYLE: dict[Any, Any] = {"figure.constrained_layout.use": True, "savefig.dpi": 130}
STYLE |= {"axes.formatter.limits": (-4, 5), "axes.spines.right": False, "axes.spines.top": False}
STYLE |= {"axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 0.9}
STYLE |= {"font.size": 9, "legend.frameon": False}


def negligible(unit: str) -> float:
    """Return half the least range of an axis in a unit for reading."""
    return NEGLIGIBLE_FORCE if unit in ("kN", "kN m") else NEGLIGIBLE


@contextmanager
def titled_figure(title: str, width: float, height: float) -> Iterator[Figure]:
    """Yield an empty figure (size in inches) within the common style; its title may look like a formula."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width, height))
        figure.suptitle(title, x=0.01, ha="left", parse_math=False)
        yield figure


PNG: dict[str, Any] = {"pil_kwargs": {"compress_level": 4}}
"""Options for PNG files: two thirds of the time of level 6, files 5 % larger."""


def save_figure(figure: Figure, path: Path, overwrite: bool = False) -> Path:
    """Write a figure in the file type of its suffix; the file appears whole or not at all."""
    with mpl.rc_context(STYLE), whole_file(path, overwrite) as temporary:
        figure.savefig(temporary, **PNG if path.suffix == ".png" else {})
    return path


def colour_map(colours: str | tuple[str, ...]) -> mpl.colors.Colormap:
    """Return the colour map of a name, or of one colour for each whole number; NaN is grey."""
    known = mpl.colormaps[colours] if isinstance(colours, str) else mpl.colors.ListedColormap(colours)
    return known.with_extremes(bad=NOT_KNOWN)


def scale_of(low: float, high: float, colours: str) -> mpl.cm.ScalarMappable:
    """Return the scale of a colour bar between two values."""
    return mpl.cm.ScalarMappable(mpl.colors.Normalize(low, high), colours)


def round_up(value: float) -> float:
    """Return the least of 1, 1.5, 2, 3, 4, 5, 6, 8, 10 times a power of ten not below a positive value."""
    power = 10.0 ** np.floor(np.log10(value))
    steps = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
    return float(power * min(step for step in steps if step * power >= value * (1.0 - 1e-12)))


def drawn_scale(values: np.typing.ArrayLike, length: float) -> float:
    """Return the greatest of 1, 2, 5 times a power of ten that draws `values` within `length`; 1 for 0."""
    greatest = float(np.abs(values).max(initial=0.0))
    most = length / greatest if greatest > 0.0 else 1.0
    power = 10.0 ** np.floor(np.log10(most))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= most * (1.0 + 1e-12)))
