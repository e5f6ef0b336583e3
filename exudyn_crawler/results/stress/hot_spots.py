"""Hot spots of a shoe: the highest nodes, their regions, and the shares of single loads in their stress."""

from collections.abc import Mapping
from typing import Literal, get_args

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from exudyn_crawler.case.parameters.track import Track
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.stress.basis import StressBasis
from fem import OneOfEach, Peaks, Shapes, hot_spots, judged
from fem.critical_plane import normal_stress_rows
from fem.damage import SignedCriterion
from fem.stress import VOIGT, von_mises

HOT_SPOTS = 5
"""Rows of the S-paper's hot-spot tables."""

Region = Literal["roller path", "lugs", "bores", "web", "wings"]
REGIONS: tuple[Region, ...] = get_args(Region)
BORES: Region = "bores"
"""Nodes that a joint's rigid spider holds, whose stress is none to use."""
LUG_RADIUS, LUG_HALF_WIDTH = 0.24, 0.2
"""m, from a pin's axis to behind the fillets at a lug's root, and to either side of its middle."""
WING_BESIDE = 0.5
"""m, from the outer side of a rail."""
EDGE = 0.01
"""m, by which the roller path is wider than the rails above it."""
SHARE = "share of "
"""What the columns of loads begin with."""


def shoe_regions(whole: Shapes, track: Track) -> NDArray:
    """Region of every node of a shoe: array (n,) of str, of `REGIONS`.

    Bores are what joints hold, lugs what else is about the pins, with the lugs' roots. The roller path is
    what lies below the surface "rails", from the height of the pins up; wings begin 0.5 m beside the rails.
    The web is the rest; without a surface "rails" there is neither roller path nor wing.
    """
    nodes, mesh = whole.nodes, whole.mesh
    x, y, z = nodes.T
    regions = np.full(len(nodes), "web", dtype=object)
    rails = nodes[mesh.nodes_of("rails"), 1] if "rails" in mesh.surfaces else np.empty(0)
    for rail in (rails[rails < 0.0], rails[rails >= 0.0]):
        if len(rail):
            within = (y >= rail.min() - EDGE) & (y <= rail.max() + EDGE)
            regions[within & (z > track.pin_height)] = "roller path"
    if len(rails):
        regions[(y < rails.min() - WING_BESIDE) | (y > rails.max() + WING_BESIDE)] = "wings"
    for center in track.joint_centers.values():
        near = np.hypot(x - center[0], z - center[2]) < LUG_RADIUS
        regions[near & (np.abs(y - center[1]) < LUG_HALF_WIDTH)] = "lugs"
    regions[whole.spider_nodes] = BORES
    return regions


def stress_directions(criterion: SignedCriterion, stress: NDArray) -> NDArray:
    """Rows (t, 6) whose products with stresses (t, 6) are a criterion's signal: its derivatives by them.

    A criterion is homogeneous of first order in the stress, so that the rows' products with the stresses of
    single loads add up to it (Euler).
    """
    if criterion == "signed principal":
        tensor = np.empty((len(stress), 3, 3))
        for k, (i, j) in enumerate(VOIGT):
            tensor[:, i, j] = tensor[:, j, i] = stress[:, k]
        values, vectors = np.linalg.eigh(tensor)
        place = np.where(values[:, 2] >= -values[:, 0], 2, 0)
        return normal_stress_rows(vectors[np.arange(len(stress)), :, place])
    mean = stress[:, :3].mean(axis=1, keepdims=True)
    rows = np.concatenate((1.5 * (stress[:, :3] - mean), 3.0 * stress[:, 3:]), axis=1)
    length = np.where(mean[:, 0] < 0.0, -1.0, 1.0) * von_mises(stress)
    return np.divide(rows, length[:, None], out=np.zeros_like(rows), where=length[:, None] != 0.0)


def load_shares(basis: StressBasis, shoe: int, nodes: NDArray, rows: NDArray) -> pd.DataFrame:
    """Share of each load in the von Mises stress of nodes, each at a stored time of its own.

    A load's share is the projection of its stress on the deviator s of the whole,
    ``3/2 s : sigma_load / von Mises^2``: the part of the von Mises stress that goes with a small part of the
    load. Shares add up to 1; a load that relieves has a negative one. The stress of a load is that of its
    static answer with the inertia of the free shoe; "inertia" is that of the integrated modes.

    Parameters
    ----------
    shoe : int
        One of its shoes.
    nodes : int array (k,)
        Numbers of nodes.
    rows : int array (k,)
        Indices of stored times.

    Returns
    -------
    pandas.DataFrame
        A row a node, a column "share of LOAD" a load; zero where there is no stress.
    """
    modes = basis.shapes.stress_modes[nodes]
    parts = {load: np.einsum("kcm,km->kc", modes, q) for load, q in basis.by_load(shoe, rows).items()}
    return pd.DataFrame({SHARE + load: own for load, own in shares(parts).items()})


def shares(parts: Mapping[str, NDArray]) -> dict[str, NDArray]:
    """Shares (k,) as of `load_shares` of the stresses (k, 6) of loads in their sum."""
    stress = np.sum(list(parts.values()), axis=0)
    directions = stress_directions("signed von mises", stress)
    whole = (directions * stress).sum(axis=1)
    zero = np.zeros_like(whole)
    return {
        load: np.divide((directions * own).sum(axis=1), whole, out=zero.copy(), where=whole != 0.0)
        for load, own in parts.items()
    }


def highest_nodes(
    history: History,
    basis: StressBasis,
    shoe: int,
    peaks: Peaks,
    regions: NDArray,
    nodes: NDArray,
    separation: OneOfEach | None = None,
) -> pd.DataFrame:
    """Hot spots among some nodes with verdicts, regions and shares of loads.

    Their places are those in the track at t = 0, as the S-paper gives them.
    """
    whole, q, track = basis.shapes, basis.coordinates[shoe], history.case.track
    table = hot_spots(
        whole,
        history.time.values,
        q,
        HOT_SPOTS,
        separation=separation,
        nodes=nodes,
        peaks=peaks,
    )
    at, rows = table["node"].to_numpy(), np.searchsorted(history.time.values, table["time"].to_numpy())
    at_start = track.com_positions(history.case.shoe.com_height)[shoe - 1]
    table = judged(table, basis.bound).assign(
        **{axis: table[axis] + at_start[k] for k, axis in enumerate("xyz")},
        region=regions[at],
    )
    return pd.concat((table, load_shares(basis, shoe, at, rows)), axis=1)
