"""Figures over time of whole runs: motion, forces, rollers and flexible shoes, as the papers draw them."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from matplotlib.figure import Figure

from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.results.stress.recovery import StressResults
from exudyn_crawler.views.figures.curves import Panel, panel_figure
from exudyn_crawler.views.figures.series import (
    CONTACT_SCALARS,
    CONTACT_VECTORS,
    FRAME_ANGLE,
    FRAME_WAY,
    HIGHEST_STRESS,
    JOINT_VECTORS,
    JOINTS,
    PULL,
    RAIL_FORCE,
    ROLLER_FORCE,
    SHOES,
    TERRAIN_DEFORMATION,
    Series,
    deformation_panels,
    history_series,
    link_names,
    motion_series,
    on_rails,
    overlay,
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


def kinematic_figure(history: History, quantity: str, shoes: Sequence[int] = SHOES) -> Figure:
    """x, y and z of a kinematic quantity of some shoes."""
    panels = motion_series(history, quantity).panels(shoe_names(shoes))
    return panel_figure(f"{history.case.name}: {quantity}", panels, common_phases(history))


def comparison_figure(histories: Mapping[str, History], quantity: str, shoe: int) -> Figure:
    """x, y and z of a kinematic quantity of one shoe in several cases."""
    found = {case: motion_series(one, quantity) for case, one in histories.items()}
    panels = overlay(found, shoe_names([shoe]))
    return panel_figure(f"shoe {shoe}: {quantity}", panels, common_phases(*histories.values()))


def force_figures(
    history: History, shoes: Sequence[int] = SHOES, joints: Sequence[int] = JOINTS
) -> dict[str, Figure]:
    """Forces of some shoes, and of links by their rear shoe, sinkage and terrain deformation.

    All figures here are by names that can be those of files.
    """
    found = history_series(history)
    items, links = shoe_names(shoes), link_names(joints)
    panels = {label: found[label].panels(items) for label in CONTACT_VECTORS}
    panels["sinkage and friction torque"] = [
        panel for label in CONTACT_SCALARS for panel in found[label].panels(items)
    ]
    panels |= {label: found[label].panels(links) for label in JOINT_VECTORS}
    panels["terrain deformation"] = deformation_panels(found)
    titles = {"terrain deformation": TERRAIN_DEFORMATION}
    phases = common_phases(history)
    return {
        name: panel_figure(f"{history.case.name}: {titles.get(name, name)}", one, phases)
        for name, one in panels.items()
    }


def roller_figures(history: History, shoes: Sequence[int]) -> dict[str, Figure]:
    """Forces of rollers, what shoes carry of them, and motion of the side frame.

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


def stress_figures(history: History, results: StressResults) -> dict[str, Figure]:
    """Figures 11 to 17 and 21 of the S-paper: flexible shoes over the cycle."""
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
