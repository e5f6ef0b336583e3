"""Figures of the F-paper: contact, friction and joint forces, sinkage and deformation."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from exudyn_crawler.results.contacts import contact_force, contacts_by_shoe
from exudyn_crawler.results.history import History
from exudyn_crawler.views.curves import JOINTS, SHOES, Panel, axis_panels, panel_figure
from exudyn_crawler.views.series import (
    CONTACT_SCALARS,
    CONTACT_VECTORS,
    JOINT_VECTORS,
    TERRAIN_DEFORMATION,
    deformation_panels,
    history_series,
    link_names,
    shoe_names,
)


def force_figures(
    history: History, shoes: Sequence[int] = SHOES, joints: Sequence[int] = JOINTS
) -> dict[str, Figure]:
    """Every figure of one case, by a name that can be a file's; some shoes, and links by their rear shoe."""
    found = history_series(history)
    items, links = shoe_names(shoes), link_names(joints)
    panels = {label: found[label].panels(items) for label in CONTACT_VECTORS}
    panels["sinkage and friction torque"] = [
        panel for label in CONTACT_SCALARS for panel in found[label].panels(items)
    ]
    panels |= {label: found[label].panels(links) for label in JOINT_VECTORS}
    case = history.case.name
    figures = {name: panel_figure(f"{case}: {name}", one) for name, one in panels.items()}
    figures["terrain deformation"] = panel_figure(f"{case}: {TERRAIN_DEFORMATION}", deformation_panels(found))
    return figures


def crossing_figure(history: History, shoe: int = 7) -> Figure:
    """Contacts of one shoe drawn apart, a curve for every unit it meets."""
    forces = contact_force(history)
    curves: dict[str, dict[str, xr.DataArray]] = {"penetration": {}, "normal": {}, "contact": {}}
    for index in np.flatnonzero(history.contact_shoe.values == shoe):
        unit = f"unit {int(history.contact_unit[index])}"
        curves["penetration"][unit] = history.penetration.isel(contact=index)
        curves["normal"][unit] = history.normal_force.isel(contact=index).sel(axis="z")
        curves["contact"][unit] = forces.isel(contact=index).sel(axis="x")
    panels = [
        Panel("penetration depth", "m", curves["penetration"]),
        Panel("z normal force", "N", curves["normal"]),
        Panel("x contact force", "N", curves["contact"]),
    ]
    return panel_figure(f"{history.case.name}: shoe {shoe} crossing units", panels)


def turning_figures(histories: Mapping[str, History], shoe: int = 10, joint: int = 10) -> dict[str, Figure]:
    """Cases against each other: contact of one shoe, reactions of one link."""
    contacts = {case: contacts_by_shoe(one).sel(shoe=shoe) for case, one in histories.items()}
    figures = {}
    for title, (name, unit) in CONTACT_VECTORS.items():
        curves = {case: one[name] for case, one in contacts.items()}
        figures[f"shoe {shoe} {title}"] = panel_figure(
            f"shoe {shoe}: {title}", axis_panels(title, unit, curves)
        )
    scalars: Sequence[Panel] = [
        Panel(title, unit, {case: _scalar(one[name]) for case, one in contacts.items()})
        for title, (name, unit) in CONTACT_SCALARS.items()
    ]
    figures[f"shoe {shoe} sinkage and friction torque"] = panel_figure(
        f"shoe {shoe}: sinkage and friction torque", scalars
    )
    for title, (name, unit) in JOINT_VECTORS.items():
        curves = {case: one.dataset[name].sel(joint=joint) for case, one in histories.items()}
        figures[f"link {joint} {title}"] = panel_figure(
            f"link {joint}-{joint + 1}: {title}", axis_panels(title, unit, curves)
        )
    return figures


def _scalar(values: xr.DataArray) -> xr.DataArray:
    """Component about the vertical of a vector; a scalar as it is."""
    return values.sel(axis="z") if "axis" in values.dims else values
