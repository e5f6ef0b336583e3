"""Figures of contact, friction and joint forces, sinkage and deformation of one run."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.views.curves import JOINTS, SHOES, panel_figure
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
    panels["terrain deformation"] = deformation_panels(found)
    titles = {"terrain deformation": TERRAIN_DEFORMATION}
    phases = common_phases(history)
    return {
        name: panel_figure(f"{history.case.name}: {titles.get(name, name)}", one, phases)
        for name, one in panels.items()
    }
