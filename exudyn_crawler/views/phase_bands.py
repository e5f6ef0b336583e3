"""Phases of a run behind its curves over time: light bands, with names above the first panel."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.text import Text

from exudyn_crawler.results.history.history import RunPhase
from exudyn_crawler.views.colours import PHASE_BANDS, PHASE_NAME

NAME_SIZE, NAME_INSET = 6.5, 2.0
"""Points: size of a name, and how far it stands to the right of its band's begin and above it."""


def banded(phases: Sequence[RunPhase]) -> list[RunPhase]:
    """Phases that get a band: none where there is but one."""
    return list(phases) if len(phases) > 1 else []


def draw_phases(axes: Sequence[Axes], phases: Sequence[RunPhase]) -> None:
    """Draw a band a phase behind the curves of some panels of a figure over the same time (s).

    Colours alternate. Names stand above the first panel alone; one that is wider than its band is left out.

    Parameters
    ----------
    axes : sequence of Axes
        Panels that have their curves, their place in the figure and their limits.
    phases : sequence of RunPhase
        Of the run; what of them is beyond the limits is not drawn.
    """
    for panel, ax in enumerate(axes):
        low, high = ax.get_xlim()
        for number, phase in enumerate(banded(phases)):
            begin, end = max(phase.begin, low), min(phase.end, high)
            if begin >= end:
                continue
            colour = PHASE_BANDS[number % len(PHASE_BANDS)]
            ax.axvspan(begin, end, facecolor=colour, edgecolor="none", zorder=0.0)
            if panel == 0:
                _write_name(ax, phase.name, begin, end)


def _write_name(ax: Axes, name: str, begin: float, end: float) -> None:
    """Write the name of a phase above its band, where no curve can be, if it is not wider than the band."""
    text: Text = ax.annotate(
        name,
        (begin, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(NAME_INSET, NAME_INSET),
        textcoords="offset points",
        va="bottom",
        fontsize=NAME_SIZE,
        color=PHASE_NAME,
        # a phase may have any name, also one that looks like a formula
        parse_math=False,
    )
    right = ax.transData.transform((end, 0.0))[0]
    if text.get_window_extent().x1 > right:
        text.remove()
