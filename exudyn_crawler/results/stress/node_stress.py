"""Stress at one node of a flexible shoe over a run: tensor, principal stresses, von Mises stress."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from exudyn_crawler.model.flexible_shoes import whole_reduction
from exudyn_crawler.results.history.files import case_in_file
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads.load_map import check_flexible, loads_by_kind
from exudyn_crawler.results.stress.basis import unit_stress
from fem import Shapes
from fem.stress import principal, von_mises

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")
MEGA = 1e6


def node_stress(
    history: History | str | Path, shoe: int, near: ArrayLike | None = None, node: int | None = None
) -> xr.Dataset:
    """Stress over time at the node of a flexible shoe that is nearest to a point, or at a node by its number.

    Parameters
    ----------
    history : History or str or Path
        A history, or the file of one.
    shoe : int
        Number of the shoe.
    near : array (3,), optional
        Point in the shoe's frame, m: x along the track, z up, from the nominal COM of the undeformed shoe.
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
    FileNotFoundError
        If there is no such file.
    ValueError
        If the shoe is not a flexible one of the history, the point is not three finite numbers or far from
        the shoe, there is no such node, neither or both of point and node are given, or the file does not
        hold a history.
    """
    # what cannot be is reported before a long history is read
    case = history.case if isinstance(history, History) else case_in_file(Path(history))
    check_flexible(case, shoe)
    whole = whole_reduction(case).body
    number, distance = _chosen(whole, near, node)
    history = history if isinstance(history, History) else History.load(history)
    stress = sum(loads_by_kind(history, shoe).values()) @ unit_stress(case, number)
    pascal = {"units": "Pa"}
    return xr.Dataset(
        {
            "stress": (("time", "component"), stress, pascal | {"long_name": "stress in the shoe's axes"}),
            "principal": (("time", "order"), principal(stress)[:, ::-1], pascal),
            "von_mises": ("time", von_mises(stress), pascal | {"long_name": "von Mises stress"}),
            "place": ("axis", whole.nodes[number], {"units": "m", "long_name": "place in the shoe's frame"}),
        },
        coords={
            "time": ("time", history.time.values, {"units": "s"}),
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


def node_table(found: xr.Dataset) -> pd.DataFrame:
    """Dataset of `node_stress` as a table: a row a stored time, stresses in MPa."""
    columns = {"time in s": found.time.values}
    columns |= {f"{name} in MPa": found.stress.sel(component=name).values / MEGA for name in COMPONENTS}
    columns |= {f"principal {k} in MPa": found.principal.sel(order=k).values / MEGA for k in (1, 2, 3)}
    return pd.DataFrame(columns | {"von Mises in MPa": found.von_mises.values / MEGA})


def _chosen(whole: Shapes, near: ArrayLike | None, node: int | None) -> tuple[int, float]:
    """Number of the node that is asked for, and its distance in m from the point that is."""
    if (near is None) == (node is None):
        raise ValueError("near or node must be given, got neither or both")
    if node is not None:
        if not 0 <= node < len(whole.nodes):
            raise ValueError(f"node must be in 0..{len(whole.nodes) - 1}, got {node}")
        return node, 0.0
    point = np.asarray(near, dtype=float)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise ValueError(f"near must be three finite numbers in m, got {near!r}")
    distances = np.linalg.norm(whole.nodes - point, axis=1)
    number = int(distances.argmin())
    distance = float(distances[number])
    if distance > np.ptp(whole.nodes, axis=0).max():
        raise ValueError(
            f"near must be at the shoe, in m in its frame, got {point.tolist()}, "
            f"{distance:.4g} m from the nearest node"
        )
    return number, distance
