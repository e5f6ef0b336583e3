"""Figures of contact, friction and joint forces, sinkage and deformation of one run."""

from collections.abc import Sequence

import xarray as xr
from matplotlib.figure import Figure

from exudyn_crawler.results.contacts import contacts_by_shoe, terrain_deformation
from exudyn_crawler.results.history import History
from exudyn_crawler.views.curves import JOINTS, SHOES, Panel, axis_panels, panel_figure

CONTACT_VECTORS = {
    "normal force": ("normal_force", "N"),
    "slip velocity": ("slip_velocity", "m/s"),
    "friction force": ("friction_force", "N"),
    "contact force": ("contact_force", "N"),
}
CONTACT_SCALARS = {
    "penetration depth": ("penetration", "m"),
    "sinkage velocity": ("penetration_rate", "m/s"),
    "friction torque": ("friction_torque", "N m"),
}
JOINT_VECTORS = {
    "spherical joint reaction": ("joint_force", "N"),
    "parallel joint torque": ("joint_torque", "N m"),
}


def force_figures(
    history: History, shoes: Sequence[int] = SHOES, joints: Sequence[int] = JOINTS
) -> dict[str, Figure]:
    """Every figure of one case, by a name that can be a file's; some shoes, and links by their rear shoe."""
    contacts = contacts_by_shoe(history)
    case = history.case.name
    figures = {}
    for title, (name, unit) in CONTACT_VECTORS.items():
        curves = {f"shoe {shoe}": contacts[name].sel(shoe=shoe) for shoe in shoes}
        figures[title] = panel_figure(f"{case}: {title}", axis_panels(title, unit, curves))
    scalars = [
        Panel(title, unit, {f"shoe {s}": vertical(contacts[name].sel(shoe=s)) for s in shoes})
        for title, (name, unit) in CONTACT_SCALARS.items()
    ]
    figures["sinkage and friction torque"] = panel_figure(f"{case}: sinkage and friction torque", scalars)
    for title, (name, unit) in JOINT_VECTORS.items():
        curves = {f"link {j}-{j + 1}": history.dataset[name].sel(joint=j) for j in joints}
        figures[title] = panel_figure(f"{case}: {title}", axis_panels(title, unit, curves))
    deformation = Panel("deformation", "m", {"terrain": terrain_deformation(history)})
    figures["terrain deformation"] = panel_figure(
        f"{case}: total terrain deformation from equilibrium", [deformation]
    )
    return figures


def vertical(values: xr.DataArray) -> xr.DataArray:
    """Component about the vertical of a vector; a scalar as it is."""
    return values.sel(axis="z") if "axis" in values.dims else values
