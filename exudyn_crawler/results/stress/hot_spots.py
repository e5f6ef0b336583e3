"""Hot spots of a shoe: nodes with the highest stress, their regions, and shares of loads in their stress."""

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

HOT_SPOTS = 5  # number of rows in the S-paper's hot-spot tables

Region = Literal["roller path", "notches", "lugs", "bores", "web", "wings"]
REGIONS: tuple[Region, ...] = get_args(Region)
BORES: Region = "bores"  # nodes in a joint's coupling; their stress is used if a pin is in contact
LUG_RADIUS, LUG_HALF_WIDTH = 0.24, 0.2
"""Radius about a pin's axis that includes the fillets at a lug's root, and least half width of a lug, m."""
FLANGE, BESIDE_LUG = 0.05, (0.015, 0.1)  # m: depth below the top; least and greatest way from a bore's end
WING_BESIDE = 0.5  # distance of wings from the outer side of a rail, m
EDGE = 0.01  # margin of the roller path beside the rails above it, and of a wide lug beside its bore, m
OF_PITCH = ph4100c.TRACK["pitch"]  # pitch of the shoe with these lengths, m; they scale with the pitch
MEGA = 1e6
SHARE = "contribution of "  # prefix of the loads' columns


def shoe_regions(whole: Shapes, track: Track) -> np.ndarray:
    """Return the region of every node of a shoe: array (n,) of str, one of `REGIONS` each.

    Bores are the nodes in joints' spiders. Lugs are the other nodes about the pins, with the lugs' roots.
    Notches are the nodes beside lugs in the flange, below the surface "top". The roller path lies below the
    surface "rails" and above the pins; wings begin 0.5 m beside the rails. The web is the rest. Without a
    surface "rails" there is neither roller path nor wing, without "top" no notch. Lengths are those of the
    P&H 4100C's shoe, in proportion to the pitch.
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
        # a fork's cheeks, and a lug beside the joint, extend as far as their bores
        end = np.abs(nodes[mesh.nodes_of(f"bore {name}"), 1] - center[1]).max() if has_bore else 0.0
        regions[near & (beside < max(LUG_HALF_WIDTH * size, end + EDGE * size))] = "lugs"
        if has_bore:
            notch = (z > flange) & (np.abs(x - center[0]) < LUG_RADIUS * size) & (regions != "roller path")
            first, last = (end + size * way for way in BESIDE_LUG)
            regions[notch & (beside > first) & (beside < last)] = "notches"
    regions[whole.spider_nodes] = BORES
    return regions


def near_pull(history: History, whole: Shapes, shoe: int) -> np.ndarray:
    """Return True for each node of the elements about the node that the drive pulls: array (nodes,)."""
    marked = np.zeros(len(whole.nodes), dtype=bool)
    elements = whole.mesh.elements
    node = pulled_node(history.case, whole.mesh)
    if node is not None and shoe == history.case.track.shoe_count:
        marked[elements[(elements == node).any(axis=1)]] = True
    return marked


def mesh_dataset(whole: Shapes) -> xr.Dataset:
    """Return the mesh variables of datasets of stress and life: nodes, flat surface triangles, spiders."""
    named = {
        "node_position": whole.nodes,
        "triangle": flat_triangles(whole.mesh.boundary),
        "in_spider": np.isin(np.arange(len(whole.nodes)), whole.held_nodes),
    }
    variables = {name: catalogue.variable(name, values) for name, values in named.items()}
    return xr.Dataset(variables, {"node": np.arange(len(whole.nodes)), "axis": ["x", "y", "z"]})


def flat_triangles(faces: np.ndarray) -> np.ndarray:
    """Return flat triangles (4 k, 3) through all nodes of faces (k, 6): corners, then midside nodes."""
    quarters = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))
    return np.stack([faces[:, list(quarter)] for quarter in quarters], axis=1).reshape(-1, 3)


def stress_directions(criterion: damage.SignedCriterion, stress: np.ndarray) -> np.ndarray:
    """Return rows (t, 6) whose products with stresses (t, 6) are a criterion's signal.

    The rows are the criterion's derivatives by the stress. A criterion is homogeneous of first order in the
    stress, so that the products with the stresses of loads add up to it (Euler).
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
    """Return each load's share in the von Mises stress of nodes (k,), each at its own stored time (k,).

    A load's stress is its static response with the inertia of the free shoe. Its share is the projection of
    this stress on the deviator s of the whole, ``3/2 s : sigma_load / von Mises^2``. Shares add up to 1;
    those of relieving loads are negative. The table has a row for each node and a column "contribution of
    LOAD" for each load; shares are zero without stress.
    """
    modes = basis.shapes.stress_modes[nodes]
    parts = {load: np.einsum("kcm,km->kc", modes, q) for load, q in basis.by_load(shoe, rows).items()}
    return pd.DataFrame({SHARE + load: share for load, share in shares(parts).items()})


def shares(parts: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the shares (k,), see `load_shares`, of the stresses (k, 6) of loads in their sum."""
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
    """Return hot spots among some nodes with verdicts, regions, shares of loads and positions at t = 0."""
    whole = basis.shapes
    time = history.time.values
    start = history.case.gear.shoe_reference(history.case)[shoe - 1]
    # only those stored times of a long run that may be in the table
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
    """Return hot spots among the nodes `away` (n,) from single nodal forces, see `highest_nodes`.

    The highest usable nodes come first. The highest node in a joint's rigid spider follows them if it is
    higher: its stress is that beside a rigid ring and is not used.
    """
    is_held = np.isin(np.arange(len(regions)), basis.shapes.held_nodes)
    usable = np.flatnonzero(away & ~is_held)
    table = highest_nodes(history, basis, shoe, peaks, regions, usable)
    held = np.flatnonzero(away & is_held)
    if not len(held) or peaks.values[held].max() <= peaks.values[usable].max():
        return table
    highest = held[[int(peaks.values[held].argmax())]]
    last = highest_nodes(history, basis, shoe, peaks, regions, highest).assign(rank=len(table) + 1)
    return pd.concat((table, last), ignore_index=True)


def highest_by_phase(history: History, stress: xr.Dataset) -> pd.DataFrame:
    """Return the highest von Mises stress of each flexible shoe and load phase, with time and place."""
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
    """Return the columns of one or several positions in the shoe's frame, m."""
    return {f"{axis} in the shoe in m": place.sel(axis=axis).values[()] for axis in "xyz"}


def peak_spots(by_shoe: Mapping[int, pd.DataFrame]) -> dict[str, tuple[int, pd.DataFrame]]:
    """Return the highest usable hot spot of all shoes, and a higher one beside a pin coupling, if any.

    The keys are the names of both; each value is the shoe's number and a table of one row. If no hot spot is
    usable, the highest one beside a pin stands alone.
    """
    candidates = [(shoe, spots.iloc[[row]]) for shoe, spots in by_shoe.items() for row in range(len(spots))]
    held = [spot for spot in candidates if spot[1]["flag"].iloc[0] == IN_SPIDER]
    free = [spot for spot in candidates if spot[1]["flag"].iloc[0] != IN_SPIDER]

    def value(spot: tuple[int, pd.DataFrame]) -> float:
        return float(spot[1]["value"].iloc[0])

    peaks = {"peak stress": max(free, key=value)} if free else {}
    if held and (not free or value(max(held, key=value)) > value(peaks["peak stress"])):
        peaks["higher beside a pin coupling, not to be used"] = max(held, key=value)
    return peaks


def hot_spot_table(hot_spots: pd.DataFrame, stress: xr.Dataset) -> pd.DataFrame:
    """Return a shoe's hot spots: stresses in MPa with verdicts, errors and causes, then time and place."""
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
    """Return the highest node of every region and flexible shoe, with its shoe, see `hot_spot_table`."""
    tables = [hot_spot_table(table, stress).assign(shoe=shoe) for shoe, table in by_region.items()]
    whole = pd.concat(tables, ignore_index=True)
    shares = whole.filter(like=SHARE).fillna(0.0)
    first = ["shoe", "region"]
    others = [name for name in whole if name not in (*first, "rank")]
    return whole.assign(**shares)[[*first, *others]]
