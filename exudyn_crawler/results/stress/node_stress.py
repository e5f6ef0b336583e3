"""Stress at one node of a flexible shoe over a run: tensor, principal stresses, von Mises stress."""

from pathlib import Path

import xarray as xr
from numpy.typing import ArrayLike

from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.stress.node_look import COMPONENTS, look, look_into


def node_stress(
    history: History | str | Path, shoe: int, near: ArrayLike | None = None, node: int | None = None
) -> xr.Dataset:
    """Stress over time at the node of a flexible shoe that is nearest to a place, or at a node by its number.

    Parameters
    ----------
    history : History or str or Path
        A history, or the file of one. Of a file the loads on the shoe are kept on disk beside the reductions
        by its digest, so that further looks, in other processes too, need not read it.
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
    FileNotFoundError
        If there is no such file.
    ValueError
        If the shoe is not a flexible one of the history, the place is not three finite numbers, there is no
        such node, neither or both of place and node are given, or the file does not hold a history.
    """
    if isinstance(history, History):
        found = look(history, shoe, near, node)
    else:
        found = look_into(Path(history), shoe, near, node)
    pascal = {"units": "Pa"}
    return xr.Dataset(
        {
            "stress": (
                ("time", "component"),
                found.stress,
                pascal | {"long_name": "stress in the shoe's axes"},
            ),
            "principal": (("time", "order"), found.principal, pascal),
            "von_mises": ("time", found.von_mises, pascal | {"long_name": "von Mises stress"}),
            "place": ("axis", found.place, {"units": "m", "long_name": "place in the shoe's frame"}),
        },
        coords={
            "time": ("time", found.time, {"units": "s"}),
            "component": list(COMPONENTS),
            "order": [1, 2, 3],
            "axis": ["x", "y", "z"],
        },
        attrs={
            "shoe": found.shoe,
            "node": found.node,
            "distance_m": found.distance,
            "in_spider": found.in_spider,
        },
    )
