"""Figures of a rolled run: forces of the rollers, what shoes carry of them, motion of the side frame."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from matplotlib.figure import Figure

from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.views.curves import Panel, panel_figure
from exudyn_crawler.views.series import (
    FRAME_ANGLE,
    FRAME_WAY,
    PULL,
    RAIL_FORCE,
    ROLLER_FORCE,
    Series,
    history_series,
    on_rails,
    shoe_names,
)


def roller_figures(history: History, shoes: Sequence[int]) -> dict[str, Figure]:
    """Every figure of a rolled run, by a name that can be a file's.

    Parameters
    ----------
    shoes : sequence of int
        Numbers of the shoes whose load by the rollers is drawn.
    """
    found = history_series(history)
    panels = {
        ROLLER_FORCE: _vertical(found, ROLLER_FORCE, *(on_rails(str(side)) for side in history.rail.values)),
        RAIL_FORCE: found[RAIL_FORCE].panels(shoe_names(shoes)),
        # the way along x is given
        "side frame": [
            *found[PULL].panels(),
            *_vertical(found, FRAME_WAY),
            *found[FRAME_ANGLE].panels(),
        ],
    }
    phases = common_phases(history)
    return {name: panel_figure(f"{history.case.name}: {name}", one, phases) for name, one in panels.items()}


def _vertical(found: Mapping[str, Series], *labels: str) -> list[Panel]:
    """Panels of the vertical components."""
    drawn = (found[label] for label in labels)
    upward = (replace(one, values=one.values.sel(axis=["z"])) for one in drawn)
    return [panel for one in upward for panel in one.panels()]
