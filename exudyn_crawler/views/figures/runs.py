"""Figures over time of whole runs: motion, forces, rollers and flexible shoes, as the papers draw them.

All are by names that can be those of files.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from matplotlib.figure import Figure

from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.results.stress.recovery import StressResults
from exudyn_crawler.views.figures import series
from exudyn_crawler.views.figures.curves import Panel, panel_figure

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


def _figures(title: str, panels: Mapping[str, Sequence[Panel]], *histories: History) -> dict[str, Figure]:
    """Figures by their names, which stand in their titles."""
    phases = common_phases(*histories)
    return {name: panel_figure(f"{title}: {name}", one, phases) for name, one in panels.items()}


def kinematic_figure(history: History, quantity: str, shoes: Sequence[int] = series.SHOES) -> Figure:
    """x, y and z of a kinematic quantity of some shoes."""
    panels = series.motion_series(history, quantity).panels(series.shoe_names(shoes))
    return _figures(history.case.name, {quantity: panels}, history)[quantity]


def comparison_figure(histories: Mapping[str, History], quantity: str, shoe: int) -> Figure:
    """x, y and z of a kinematic quantity of one shoe in several cases."""
    found = {case: series.motion_series(one, quantity) for case, one in histories.items()}
    panels = series.overlay(found, series.shoe_names([shoe]))
    return _figures(f"shoe {shoe}", {quantity: panels}, *histories.values())[quantity]


def force_figures(
    history: History, shoes: Sequence[int] = series.SHOES, joints: Sequence[int] = series.JOINTS
) -> dict[str, Figure]:
    """Forces of some shoes, and of links by their rear shoe, sinkage and terrain deformation."""
    found = series.history_series(history)
    items, links = series.shoe_names(shoes), series.link_names(joints)
    panels = {label: found[label].panels(items) for label in series.CONTACT_VECTORS}
    sinking = [found[label].panels(items) for label in series.CONTACT_SCALARS]
    panels["sinkage and friction torque"] = [panel for one in sinking for panel in one]
    panels |= {label: found[label].panels(links) for label in series.JOINT_VECTORS}
    panels["terrain deformation"] = series.deformation_panels(found)
    return _figures(history.case.name, panels, history)


def roller_figures(history: History, shoes: Sequence[int]) -> dict[str, Figure]:
    """Forces of rollers, what some shoes carry of them, and motion of the side frame."""
    found = series.history_series(history)

    def vertical(*labels: str) -> list[Panel]:
        drawn = (replace(found[one], values=found[one].values.sel(axis=["z"])) for one in labels)
        return [panel for one in drawn for panel in one.panels()]

    sides = (series.on_rails(str(side)) for side in history.rail.values)
    # the way along x is given
    frame = [*found[series.PULL].panels(), *vertical(series.FRAME_WAY), *found[series.FRAME_ANGLE].panels()]
    panels = {
        series.ROLLER_FORCE: vertical(series.ROLLER_FORCE, *sides),
        series.RAIL_FORCE: found[series.RAIL_FORCE].panels(series.shoe_names(shoes)),
        "side frame": frame,
    }
    return _figures(history.case.name, panels, history)


def stress_figures(history: History, results: StressResults) -> dict[str, Figure]:
    """Figures 11 to 17 and 21 of the S-paper: flexible shoes over the cycle."""
    found = series.history_series(history, results.dataset)
    shoes = series.shoe_names(history.flexible_shoe.values)
    panels = {name: found[label].panels(shoes) for name, label in OF_SHOES.items()}
    for name, label in OF_PINS.items():
        for side in history.pin.values:
            panels[f"{side} {name}"] = found[label].of_side(str(side)).panels()
    panels["terrain deformation"] = series.deformation_panels(found)
    panels["modal coordinates"] = [_modal_panel(history, int(one)) for one in history.flexible_shoe.values]
    panels[series.HIGHEST_STRESS] = found[series.HIGHEST_STRESS].panels_by_item()
    return _figures(f"{history.case.name}, flexible shoes", panels, history)


def _modal_panel(history: History, shoe: int) -> Panel:
    """Lowest modal coordinates of a shoe."""
    lowest = history.modal_coordinate.sel(flexible_shoe=shoe).isel(mode=slice(MODES_DRAWN))
    curves = {f"{float(mode.frequency):.0f} Hz": mode for mode in lowest.transpose("mode", "time")}
    return Panel(f"shoe {shoe}", "kg0.5 m", curves)
