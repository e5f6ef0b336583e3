"""Stress at one node of a flexible shoe over a run: tensor, principal stresses, von Mises stress."""

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from exudyn_crawler.model.flexible_shoes import whole_reduction
from exudyn_crawler.results.history import History
from exudyn_crawler.results.stress_columns import stress_at
from fem.stress import principal, von_mises

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")
MEGA = 1e6


def node_stress(
    history: History, shoe: int, near: ArrayLike | None = None, node: int | None = None
) -> xr.Dataset:
    """Stress over time at the node of a flexible shoe that is nearest to a place, or at a node by its number.

    Parameters
    ----------
    shoe : int
        Number of the shoe.
    near : array (3,), optional
        Place in the shoe's frame, m: x along the track, z up, from the nominal COM of the undeformed shoe.
    node : int, optional
        Number of the node (from 0, as in tables of hot spots), in place of `near`.

    Returns
    -------
    xarray.Dataset
        `stress` (time, component), Pa, in the shoe's axes; `principal` (time, order), Pa, from the greatest
        down; `von_mises` (time), Pa; `place` (axis), m, of the node in the shoe's frame. Attributes: shoe,
        node, `distance_m` of the node from `near`, and `in_spider`, whether a joint's rigid spider holds it,
        so that it shows the stress beside a rigid ring.

    Raises
    ------
    ValueError
        If the shoe is not a flexible one of the history, the place is not three finite numbers, there is no
        such node, or neither or both of place and node are given.
    """
    flexible = history.case.flexible
    if flexible is None or shoe not in flexible.shoes:
        there = [] if flexible is None else list(flexible.shoes)
        raise ValueError(f"shoe must be a flexible one of the history, of {there}, got {shoe}")
    if (near is None) == (node is None):
        raise ValueError("near or node must be given, got neither or both")
    place = None if near is None else np.asarray(near, dtype=float)
    if place is not None and (place.shape != (3,) or not np.isfinite(place).all()):
        raise ValueError(f"near must be three finite numbers in m, got {near!r}")
    whole = whole_reduction(history.case).body
    number, distance = int(node or 0), 0.0
    if place is not None:
        distances = np.linalg.norm(whole.nodes - place, axis=1)
        number = int(distances.argmin())
        distance = float(distances[number])
    if not 0 <= number < len(whole.nodes):
        raise ValueError(f"node must be in 0..{len(whole.nodes) - 1}, got {node}")
    stress = stress_at(history, shoe, number)
    pascal = {"units": "Pa"}
    return xr.Dataset(
        {
            "stress": (("time", "component"), stress, pascal | {"long_name": "stress in the shoe's axes"}),
            "principal": (("time", "order"), principal(stress)[:, ::-1], pascal),
            "von_mises": ("time", von_mises(stress), pascal | {"long_name": "von Mises stress"}),
            "place": ("axis", whole.nodes[number], {"units": "m", "long_name": "place in the shoe's frame"}),
        },
        coords={
            "time": history.time,
            "component": list(COMPONENTS),
            "order": [1, 2, 3],
            "axis": ["x", "y", "z"],
        },
        attrs={
            "shoe": shoe,
            "node": number,
            "distance_m": distance,
            "in_spider": bool(np.isin(number, whole.spider_nodes)),
        },
    )


def node_stress_table(found: xr.Dataset) -> pd.DataFrame:
    """Result of `node_stress` as a table: a row a stored time, stresses in MPa."""
    columns = {"time in s": found.time.values}
    for component in found.component.values:
        columns[f"{component} in MPa"] = found.stress.sel(component=component).values / MEGA
    for order in found.order.values:
        columns[f"principal {order} in MPa"] = found.principal.sel(order=order).values / MEGA
    columns["von Mises in MPa"] = found.von_mises.values / MEGA
    return pd.DataFrame(columns)
