"""Hot spots of a shoe: the highest nodes, their regions, and the shares of single loads in their stress."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from typing import Literal, get_args

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.case import Track, ph4100c
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.shoe_mesh import pulled_node
from exudyn_crawler.results.history import History, catalogue, phases
from exudyn_crawler.results.stress.basis import StressBasis
from fem import OneOfEach, Peaks, Shapes, hot_spots, judged
from fem.body.element_stress import von_mises
from fem.fatigue import critical_plane, damage
from fem.stress.trust import IN_SPIDER

HOT_SPOTS = 5  # rows of the S-paper's hot-spot tables

Region = Literal["roller path", "notches", "lugs", "bores", "web", "wings"]
REGIONS: tuple[Region, ...] = get_args(Region)
BORES: Region = "bores"  # nodes that a joint's rigid spider holds, whose stress is none to use
LUG_RADIUS, LUG_HALF_WIDTH = 0.24, 0.2
"""m, from a pin's axis to behind the fillets at a lug's root, and to either side of its middle at least."""
FLANGE, BESIDE_LUG = 0.05, (0.015, 0.1)  # m, below the top's level; from a bore's end, from and to
WING_BESIDE = 0.5  # m, from the outer side of a rail
EDGE = 0.01  # m, by which the roller path is wider than the rails above it, and a wide lug than its bore
OF_PITCH = ph4100c.TRACK["pitch"]  # m, of the shoe with these lengths: those of others go with their pitch
MEGA = 1e6
SHARE = "contribution of "  # what the columns of loads begin with


def shoe_regions(whole: Shapes, track: Track) -> np.ndarray:
    """Region of every node of a shoe: array (n,) of str, of `REGIONS`.

    Bores are what joints hold, lugs what else is about the pins, with the lugs' roots. Notches are what the
    flange, below the surface "top", has beside lugs. The roller path is what lies below the surface "rails",
    from the height of the pins up; wings begin 0.5 m beside the rails. The web is the rest; without a surface
    "rails" there is neither roller path nor wing, without "top" no notch. Lengths are those of the P&H
    4100C's shoe, times the pitch over its pitch.
    """
    size = track.pitch / OF_PITCH
    nodes = whole.nodes
    mesh = whole.mesh
    x, y, z = nodes.T
    regions = np.full(len(nodes), "web", dtype=object)
    rails = nodes[mesh.nodes_of("rails"), 1] if "rails" in mesh.surfaces else np.empty(0)
    for rail in (rails[rails < 0.0], rails[rails >= 0.0]):
        if len(rail):
            within = (y >= rail.min() - EDGE * size) & (y <= rail.max() + EDGE * size)
            regions[within & (z > track.pin_height)] = "roller path"
    if len(rails):
        beside_rails = WING_BESIDE * size
        regions[(y < rails.min() - beside_rails) | (y > rails.max() + beside_rails)] = "wings"
    flange = nodes[mesh.nodes_of("top"), 2].min() - FLANGE * size if "top" in mesh.surfaces else np.inf
    for name, center in track.joint_centers.items():
        near = np.hypot(x - center[0], z - center[2]) < LUG_RADIUS * size
        beside = np.abs(y - center[1])
        has_bore = f"bore {name}" in mesh.surfaces
        # a fork's cheeks, and a lug beside the joint, reach as far as their bores
        end = np.abs(nodes[mesh.nodes_of(f"bore {name}"), 1] - center[1]).max() if has_bore else 0.0
        regions[near & (beside < max(LUG_HALF_WIDTH * size, end + EDGE * size))] = "lugs"
        if has_bore:
            notch = (z > flange) & (np.abs(x - center[0]) < LUG_RADIUS * size) & (regions != "roller path")
            first, last = (end + size * way for way in BESIDE_LUG)
            regions[notch & (beside > first) & (beside < last)] = "notches"
    regions[whole.spider_nodes] = BORES
    return regions


def near_pull(history: History, whole: Shapes, shoe: int) -> np.ndarray:
    """True for each node of an element about the node that the drive pulls: array (nodes,)."""
    marked = np.zeros(len(whole.nodes), dtype=bool)
    elements = whole.mesh.elements
    node = pulled_node(history.case, whole.mesh)
    if node is not None and shoe == history.case.track.shoe_count:
        marked[elements[(elements == node).any(axis=1)]] = True
    return marked


def mesh_dataset(whole: Shapes) -> xr.Dataset:
    """Variables of the mesh in datasets of stress and life: nodes, flat triangles of the surface, spiders."""
    named = {
        "node_position": whole.nodes,
        "triangle": flat_triangles(whole.mesh.boundary),
        "in_spider": np.isin(np.arange(len(whole.nodes)), whole.spider_nodes),
    }
    variables = {name: catalogue.variable(name, values) for name, values in named.items()}
    return xr.Dataset(variables, {"node": np.arange(len(whole.nodes)), "axis": ["x", "y", "z"]})


def flat_triangles(faces: np.ndarray) -> np.ndarray:
    """Flat triangles (4 k, 3) through all nodes of faces (k, 6): corners first, then middles of sides."""
    quarters = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))
    return np.stack([faces[:, list(quarter)] for quarter in quarters], axis=1).reshape(-1, 3)


def stress_directions(criterion: damage.SignedCriterion, stress: np.ndarray) -> np.ndarray:
    """Rows (t, 6) whose products with stresses (t, 6) are a criterion's signal: its derivatives by them.

    A criterion is of first order in the stress: the products with the stresses of loads add up to it (Euler).
    """
    if criterion == "signed principal":
        values, vectors = np.linalg.eigh(stress[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]])
        place = np.where(values[:, 2] >= -values[:, 0], 2, 0)
        return critical_plane.normal_stress_rows(vectors[np.arange(len(stress)), :, place])
    mean = stress[:, :3].mean(axis=1, keepdims=True)
    rows = np.concatenate((1.5 * (stress[:, :3] - mean), 3.0 * stress[:, 3:]), axis=1)
    length = np.where(mean[:, 0] < 0.0, -1.0, 1.0) * von_mises(stress)
    return np.divide(rows, length[:, None], out=np.zeros_like(rows), where=length[:, None] != 0.0)


def load_shares(basis: StressBasis, shoe: int, nodes: np.ndarray, rows: np.ndarray) -> pd.DataFrame:
    """Share of each load in the von Mises stress of nodes (k,), each at a stored time (k,) of its own.

    A load's share is the projection of its stress, the static answer with the inertia of the free shoe, on
    the deviator s of the whole, ``3/2 s : sigma_load / von Mises^2``. Shares add up to 1, those of loads that
    relieve are negative. A row a node, a column "contribution of LOAD" a load; zero where there is no stress.
    """
    modes = basis.shapes.stress_modes[nodes]
    parts = {load: np.einsum("kcm,km->kc", modes, q) for load, q in basis.by_load(shoe, rows).items()}
    return pd.DataFrame({SHARE + load: share for load, share in shares(parts).items()})


def shares(parts: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Shares (k,) as in `load_shares` of the stresses (k, 6) of loads in their sum."""
    stress = np.sum(list(parts.values()), axis=0)
    directions = stress_directions("signed von mises", stress)
    whole = (directions * stress).sum(axis=1)
    zero = np.zeros_like(whole)
    return {
        load: np.divide((directions * part).sum(axis=1), whole, out=zero.copy(), where=whole != 0.0)
        for load, part in parts.items()
    }


def highest_nodes(
    history: History,
    basis: StressBasis,
    shoe: int,
    peaks: Peaks,
    regions: np.ndarray,
    nodes: np.ndarray,
    separation: OneOfEach | None = None,
) -> pd.DataFrame:
    """Hot spots among some nodes with verdicts, regions and shares of loads; positions those at t = 0."""
    whole = basis.shapes
    time = history.time.values
    start = history.case.shoe_reference[shoe - 1]
    # of a long run those stored times alone that may be in the table
    used, numbers = np.unique(peaks.time_indices, return_inverse=True)
    at_used = replace(peaks, time_indices=numbers)
    q = basis.coordinates[shoe][used]
    table = hot_spots(whole, time[used], q, HOT_SPOTS, separation=separation, nodes=nodes, peaks=at_used)
    numbers = table["node"].to_numpy()
    rows = np.searchsorted(time, table["time"].to_numpy())
    places = start[:3] + table[list("xyz")].to_numpy() @ rotation_matrices(start[3:]).T
    table = judged(table, basis.bound).assign(
        **dict(zip("xyz", places.T, strict=True)), region=regions[numbers]
    )
    return pd.concat((table, load_shares(basis, shoe, numbers, rows)), axis=1)


def ranked_nodes(
    history: History, basis: StressBasis, shoe: int, peaks: Peaks, regions: np.ndarray, away: np.ndarray
) -> pd.DataFrame:
    """Hot spots among the nodes that are `away` (n,) from single forces, see `highest_nodes`.

    The highest nodes that may be used come first. Behind them stands the highest of those that a joint's
    rigid spider holds, if it is higher: its stress is that beside a rigid ring, and not to be used.
    """
    is_held = regions == BORES
    usable = np.flatnonzero(away & ~is_held)
    table = highest_nodes(history, basis, shoe, peaks, regions, usable)
    held = np.flatnonzero(away & is_held)
    if not len(held) or peaks.values[held].max() <= peaks.values[usable].max():
        return table
    highest = held[[int(peaks.values[held].argmax())]]
    last = highest_nodes(history, basis, shoe, peaks, regions, highest).assign(rank=len(table) + 1)
    return pd.concat((table, last), ignore_index=True)


def highest_by_phase(history: History, stress: xr.Dataset) -> pd.DataFrame:
    """Highest von Mises stress of every flexible shoe in every phase of the load cycle: when and where."""
    rows = []
    reached = phases(history.case.loads, history.duration)
    for shoe, phase in product(stress.shoe.values, reached):
        within = stress.sel(shoe=shoe).isel(time=phase.rows(stress.time.values))
        if within.sizes["time"] == 0:
            continue
        instant = within.isel(time=int(within.highest_von_mises.argmax("time")))
        node = int(instant.highest_node)
        row = {"shoe": int(shoe), "phase": phase.name, "begin in s": phase.begin, "end in s": phase.end}
        row["highest von Mises in MPa"] = float(instant.highest_von_mises) / MEGA
        row |= {"time in s": float(instant.time), "node": node}
        rows.append(row | in_the_shoe(stress.node_position.isel(node=node)))
    return pd.DataFrame(rows)


def in_the_shoe(place: xr.DataArray) -> dict[str, np.ndarray]:
    """Columns of a position in the shoe's frame, m, or of several."""
    return {f"{axis} in the shoe in m": place.sel(axis=axis).values[()] for axis in "xyz"}


def peak_spots(by_shoe: Mapping[int, pd.DataFrame]) -> dict[str, tuple[int, pd.DataFrame]]:
    """Highest hot spot of all shoes that may be used, and behind it a higher one that a rigid pin holds.

    A table of one row and its shoe's number, by the words for it. Where pins hold all of them, their highest
    stands alone and says so.
    """
    every = [(shoe, spots.iloc[[row]]) for shoe, spots in by_shoe.items() for row in range(len(spots))]
    held = [one for one in every if one[1]["flag"].iloc[0] == IN_SPIDER]
    free = [one for one in every if one[1]["flag"].iloc[0] != IN_SPIDER]

    def value(one: tuple[int, pd.DataFrame]) -> float:
        return float(one[1]["value"].iloc[0])

    peaks = {"peak stress": max(free, key=value)} if free else {}
    if held and (not free or value(max(held, key=value)) > value(peaks["peak stress"])):
        peaks["higher beside a rigid pin, not to be used"] = max(held, key=value)
    return peaks


def hot_spot_table(hot_spots: pd.DataFrame, stress: xr.Dataset) -> pd.DataFrame:
    """Hot spots of a shoe: stresses in MPa with verdicts, errors and causes, then when and where they are."""
    columns = {
        "rank": hot_spots["rank"],
        "region": hot_spots["region"],
        "von Mises in MPa": hot_spots["value"] / MEGA,
        "verdict": hot_spots["verdict"],
    }
    errors = [name for name in ("error", "jump", "spread", "choice") if name in hot_spots]
    columns |= {f"{name} in MPa": hot_spots[name] / MEGA for name in errors}
    columns |= {"flag": hot_spots["flag"]} | hot_spots.filter(like=SHARE).to_dict("series")
    columns |= {"node": hot_spots["node"], "time in s": hot_spots["time"]}
    columns |= in_the_shoe(stress.node_position.isel(node=hot_spots["node"].to_numpy()))
    columns |= {f"{axis} in the track at t = 0 in m": hot_spots[axis] for axis in "xyz"}
    return pd.DataFrame(columns)


def region_table(by_region: Mapping[int, pd.DataFrame], stress: xr.Dataset) -> pd.DataFrame:
    """Highest node of every region of all flexible shoes as in `hot_spot_table`, and of which shoe it is."""
    tables = [hot_spot_table(table, stress).assign(shoe=shoe) for shoe, table in by_region.items()]
    whole = pd.concat(tables, ignore_index=True)
    shares = whole.filter(like=SHARE).fillna(0.0)
    first = ["shoe", "region"]
    others = [name for name in whole if name not in (*first, "rank")]
    return whole.assign(**shares)[[*first, *others]]
