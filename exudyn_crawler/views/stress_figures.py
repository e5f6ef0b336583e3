"""Figures 11 to 17 and 21 of the S-paper: flexible shoes over the cycle."""

from dataclasses import replace

from matplotlib.figure import Figure

from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.results.stress.recovery import StressResults
from exudyn_crawler.views.curves import Panel, panel_figure
from exudyn_crawler.views.series import (
    HIGHEST_STRESS,
    TERRAIN_DEFORMATION,
    Series,
    deformation_panels,
    history_series,
    shoe_names,
)

OF_SHOES = {
    "displacement": "displacement from equilibrium",
    "velocity": "velocity",
    "angular velocity": "angular velocity",
    "contact force": "contact force",
}
"""Figures of the flexible shoes and the series that they draw."""
OF_PINS = {"revolute joint reaction": "pin force", "revolute joint torque": "pin torque"}
"""Same of the pins, a figure for each side."""
MODES_DRAWN = 6
"""Lowest modal coordinates in the figure."""


def stress_figures(history: History, results: StressResults) -> dict[str, Figure]:
    """Every figure of a run with flexible shoes, by a name that can be a file's."""
    found = history_series(history, results.dataset)
    shoes = shoe_names(history.flexible_shoe.values)
    phases = common_phases(history)
    figures = {
        name: panel_figure(f"flexible shoes: {name}", found[label].panels(shoes), phases)
        for name, label in OF_SHOES.items()
    }
    for name, label in OF_PINS.items():
        for side in history.pin.values:
            figures[f"{side} {name}"] = panel_figure(
                f"flexible shoes: {side} {name}", _of_side(found[label], str(side)).panels(), phases
            )
    figures["terrain deformation"] = panel_figure(TERRAIN_DEFORMATION, deformation_panels(found), phases)
    figures["modal coordinates"] = panel_figure(
        f"modal coordinates 1 to {MODES_DRAWN}",
        [_modal_panel(history, int(shoe)) for shoe in history.flexible_shoe.values],
        phases,
    )
    figures[HIGHEST_STRESS] = panel_figure(
        "highest nodal von Mises stress", found[HIGHEST_STRESS].panels_by_item(), phases
    )
    return figures


def _of_side(pins: Series, side: str) -> Series:
    """Series of the pins on one side, named after their links."""
    chosen = [str(item) for item in pins.values["item"].values if str(item).endswith(f" {side}")]
    links = [item.removesuffix(f" {side}") for item in chosen]
    return replace(pins, values=pins.values.sel(item=chosen).assign_coords(item=links))


def _modal_panel(history: History, shoe: int) -> Panel:
    lowest = history.modal_coordinate.sel(flexible_shoe=shoe).isel(mode=slice(MODES_DRAWN))
    curves = {f"{float(mode.frequency):.0f} Hz": mode for mode in lowest.transpose("mode", "time")}
    return Panel(f"shoe {shoe}", "kg0.5 m", curves)
