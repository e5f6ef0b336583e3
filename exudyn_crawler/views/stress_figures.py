"""Figures 11 to 17 and 21 of the S-paper: flexible shoes over the cycle."""

from collections.abc import Mapping

import xarray as xr
from matplotlib.figure import Figure

from exudyn_crawler.results.contacts import contacts_by_shoe, terrain_deformation
from exudyn_crawler.results.history import History
from exudyn_crawler.results.stresses import StressResults
from exudyn_crawler.views.curves import Panel, axis_panels, kinematic_series, panel_figure

MODES_DRAWN = 6
"""Lowest modal coordinates in the figure."""
MOTION = {"displacement": "m", "velocity": "m/s", "angular velocity": "deg/s"}


def stress_figures(history: History, results: StressResults) -> dict[str, Figure]:
    """Every figure of a run, by a name that can be a file's."""
    shoes = history.case.flexible_shoes().shoes
    figures = {}
    for quantity, unit in MOTION.items():
        curves = {f"shoe {shoe}": kinematic_series(history, quantity, shoe) for shoe in shoes}
        figures[quantity] = _axes_figure(quantity, unit, curves)
    contacts = contacts_by_shoe(history).contact_force
    curves = {f"shoe {shoe}": contacts.sel(shoe=shoe) for shoe in shoes}
    figures["contact force"] = _axes_figure("contact force", "N", curves)
    for quantity, name, unit in (("reaction", "pin_force", "N"), ("torque", "pin_torque", "N m")):
        for side in history.pin.values:
            title = f"{side} revolute joint {quantity}"
            figures[title] = _axes_figure(title, unit, _pins(history, name, str(side)))
    deformation = Panel("deformation", "m", {"terrain": terrain_deformation(history)})
    figures["terrain deformation"] = panel_figure("total terrain deformation from equilibrium", [deformation])
    figures["modal coordinates"] = panel_figure(
        f"modal coordinates 1 to {MODES_DRAWN}",
        [
            Panel(
                f"shoe {shoe}",
                "kg0.5 m",
                {
                    f"{float(mode.frequency):.0f} Hz": mode
                    for mode in history.modal_coordinate.sel(flexible_shoe=shoe)
                    .isel(mode=slice(MODES_DRAWN))
                    .transpose("mode", "time")
                },
            )
            for shoe in shoes
        ],
    )
    highest = results.dataset.highest_von_mises / 1e6
    figures["highest von Mises stress"] = panel_figure(
        "highest nodal von Mises stress",
        [Panel(f"shoe {shoe}", "MPa", {f"shoe {shoe}": highest.sel(shoe=shoe)}) for shoe in shoes],
    )
    return figures


def _axes_figure(title: str, unit: str, curves: Mapping[str, xr.DataArray]) -> Figure:
    return panel_figure(f"flexible shoes: {title}", axis_panels(title, unit, curves))


def _pins(history: History, name: str, side: str) -> dict[str, xr.DataArray]:
    """Curves of all links with a flexible shoe."""
    values = history.dataset[name]
    linked = values.notnull().all(["time", "pin", "axis"])
    return {f"link {j}-{j + 1}": values.sel(pin=side, joint=j) for j in values.joint.values[linked.values]}
