"""Stresses of the flexible shoes over a run: histories, fields and chosen instants as one dataset."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from exudyn_crawler.files import write_netcdf
from exudyn_crawler.model.drive_point import pulled_node
from exudyn_crawler.results.history.catalogue import QUANTITIES, Variable, variable
from exudyn_crawler.results.history.history import History, phases
from exudyn_crawler.results.loads.load_map import check_flexible
from exudyn_crawler.results.stress.basis import stress_basis
from exudyn_crawler.results.stress.hot_spots import BORES, highest_nodes, shoe_regions
from fem import Extremes, OneOfEach, Shapes, mesh_error, recover_extremes
from fem.trust import resolution_over, verdict_numbers

AT_ONCE = 50
"""Instants whose fields are in memory together."""


@dataclass(frozen=True)
class StressResults:
    """Recovered stresses of a run.

    Attributes
    ----------
    dataset : xarray.Dataset
        What the catalogue of quantities has of stress: dimensions shoe (the flexible ones), time, node, frame
        (chosen stored instants, s), axis, and face and corner of the surface's flat triangles, four a face.
        `highest_von_mises` is that of nodes which are not `at_load`: the stress that a force on one node
        makes there grows without limit as the mesh is refined. `frame_name` is "begin", "end of dig" or
        "peak", each as far as the instant is one.
    hot_spots : mapping
        Table of every flexible shoe, as of `fem.hot_spots` and `fem.judged`, of nodes that are not at_load;
        places global, those of the track at t = 0; region as of `hot_spots.shoe_regions`, and the share of
        each load as of `hot_spots.load_shares`.
    by_region : mapping
        Same of the highest node of every region; of bores, whose stress is none to use, there is none.
    whole : Shapes
        Modes, and static fields, that the stresses are made of.
    """

    dataset: xr.Dataset
    hot_spots: Mapping[int, pd.DataFrame]
    by_region: Mapping[int, pd.DataFrame]
    whole: Shapes

    def _repr_html_(self) -> str:
        """Hot spots of every shoe and the dataset, for notebooks."""
        tables = [
            f"<p>Shoe {shoe}: highest von Mises stresses (Pa; places in m at t = 0)</p>"
            + table.to_html(index=False)
            for shoe, table in self.hot_spots.items()
        ]
        return "".join([*tables, self.dataset._repr_html_()])

    def save(self, path: str | Path, overwrite: bool = False) -> Path:
        """Write the dataset to a NetCDF file, whole or not at all; raises as `write_netcdf`."""
        return write_netcdf(self.dataset, Path(path), overwrite)


def recover_stresses(
    history: History, times: Sequence[float] | None = None, peak: bool = True
) -> StressResults:
    """Recover the stresses of all flexible shoes from a run.

    Parameters
    ----------
    times : sequence of float, optional
        s, instants of which whole fields are returned, as the stored ones nearest to them and as far as the
        run goes; begin and ends of the load cycle's phases by default.
    peak : bool
        Return that of the highest stress of all shoes, too.

    Raises
    ------
    ValueError
        If the run has no flexible shoes, or none of the times lies within it.
    """
    named = _named_times(history, times)
    basis = stress_basis(history)
    whole, coordinates = basis.shapes, basis.coordinates
    regions = shoe_regions(whole, history.case.track)
    pulled = {shoe: near_pull(history, whole, shoe) for shoe in coordinates}
    reached = {
        shoe: recover_extremes(whole.stress_modes, q, ranked=np.flatnonzero(~pulled[shoe]))
        for shoe, q in coordinates.items()
    }
    if peak:
        highest = np.max([one.highest for one in reached.values()], axis=0)
        named.append((float(history.time[int(highest.argmax())]), "peak"))
    frames, names = _frames(history, named)
    found, tables, by_region = [], {}, {}
    for shoe, q in coordinates.items():
        extremes, at_load = reached[shoe], pulled[shoe]
        found.append(_of_shoe(history, whole, q, extremes, frames, at_load))
        away = np.flatnonzero(~at_load)
        tables[shoe] = highest_nodes(history, basis, shoe, extremes.peaks, regions, away)
        usable = away[regions[away] != BORES]
        each = OneOfEach(regions)
        by_region[shoe] = highest_nodes(history, basis, shoe, extremes.peaks, regions, usable, each)
    mesh = mesh_dataset(whole)
    dataset = xr.concat(found, dim=xr.Variable("shoe", list(coordinates)))
    dataset = dataset.transpose("time", "frame", "shoe", ...).assign(mesh.data_vars)
    dataset = dataset.assign(
        truncation=variable("truncation", np.array(np.nan if basis.bound is None else basis.bound)),
        frame_name=variable("frame_name", np.array(names, dtype=object)),
    )
    dataset = dataset.assign(peak_verdict=verdicts(dataset)).assign_coords(mesh.coords)
    return StressResults(dataset, tables, by_region, whole)


def _named_times(history: History, times: Sequence[float] | None) -> list[tuple[float, str]]:
    """Times (s) with their names: the chosen ones, as far as the run goes, or those of its phases."""
    duration = history.duration
    parts = phases(history.case.loads, duration)
    ends = [(0.0, "begin"), *((part.end, f"end of {part.name}") for part in parts)]
    if times is None:
        return ends
    within = [time for time in times if time <= duration * (1.0 + 1e-9)]
    if not within:
        raise ValueError(f"none of the times {list(times)} s lies within the run of {duration:g} s")
    known = {round(time, 9): name for time, name in ends}
    return [(time, known.get(round(time, 9), "")) for time in within]


def _frames(history: History, named: Sequence[tuple[float, str]]) -> tuple[NDArray, list[str]]:
    """Indices of the stored instants nearest to named times, rising, and the names of each."""
    stored = history.time.values
    names: dict[int, list[str]] = {}
    for time, name in named:
        names.setdefault(int(np.argmin(np.abs(stored - time))), []).append(name)
    rows = sorted(names)
    return np.array(rows), [", ".join(filter(None, names[row])) for row in rows]


def near_pull(history: History, whole: Shapes, shoe: int) -> NDArray:
    """Whether each node belongs to an element about the node that the drive pulls: array (nodes,)."""
    marked = np.zeros(len(whole.nodes), dtype=bool)
    node = pulled_node(history.case, whole.mesh)
    if node is not None and shoe == history.case.track.shoe_count:
        elements = whole.mesh.elements
        marked[elements[(elements == node).any(axis=1)]] = True
    return marked


def _of_shoe(
    history: History, whole: Shapes, q: NDArray, found: Extremes, frames: NDArray, at_load: NDArray
) -> xr.Dataset:
    """Stress of one shoe with coordinates q (times, columns)."""
    time = history.time.values
    displacements = whole.displacement(q[frames])
    errors = [mesh_error(whole.mesh, whole.material, displacement) for displacement in displacements]
    resolved = resolution_over(whole, q)
    named = {
        "highest_von_mises": found.highest,
        "highest_node": found.highest_nodes,
        "peak_von_mises": found.greatest,
        "peak_time": time[found.greatest_at],
        "least_von_mises": found.least,
        "peak_mesh_error": resolved.error.astype(np.float32),
        "peak_jump": resolved.relative_jump.astype(np.float32),
        "at_load": at_load,
        "frame_von_mises": whole.von_mises(q[frames]).astype(np.float32),
        "frame_mesh_error": np.array(errors, dtype=np.float32),
        "frame_displacement": displacements.astype(np.float32),
    }
    return xr.Dataset(
        {name: variable(name, values, without=("shoe",)) for name, values in named.items()},
        coords={
            "time": ("time", time, {"units": "s"}),
            "frame": ("frame", time[frames], {"units": "s", "long_name": "chosen instants"}),
        },
    )


def verdicts(stress: xr.Dataset, more: ArrayLike = 0.0) -> Variable:
    """Verdicts on the greatest stresses of a run with `more` (shoe, node), in Pa, open of them."""
    ordered = stress.transpose("shoe", ...)
    size = np.maximum(ordered.peak_von_mises.values, np.finfo(float).tiny)
    mesh = ordered.peak_mesh_error.values
    # not a number where no stress is known
    part = mesh + (np.nan_to_num(float(stress.truncation)) + np.asarray(more)) / size
    part = np.where(ordered.at_load.values, np.nan, part)
    held = np.broadcast_to(stress.in_spider.values, part.shape)
    return variable("peak_verdict", verdict_numbers(part, mesh, ordered.peak_jump.values, held))


def mesh_dataset(whole: Shapes) -> xr.Dataset:
    """What datasets of stress and life have of the mesh: nodes, flat triangles of the surface, spiders."""
    named = {
        "node_position": whole.nodes,
        "triangle": flat_triangles(whole.mesh.boundary),
        "in_spider": np.isin(np.arange(len(whole.nodes)), whole.spider_nodes),
    }
    return xr.Dataset(
        {name: variable(name, values) for name, values in named.items()},
        {"node": np.arange(len(whole.nodes)), "axis": ["x", "y", "z"]},
    )


def peak_time(history: History, shoe: int) -> float:
    """Time (s) of the highest von Mises stress of a flexible shoe; ValueError if the history has no such."""
    basis = stress_basis(history, [shoe])
    found = recover_extremes(basis.shapes.stress_modes, basis.coordinates[shoe])
    return float(history.time[int(found.highest.argmax())])


def flat_triangles(faces: NDArray) -> NDArray:
    """Flat triangles (4 k, 3) through all nodes of faces (k, 6), in their sense.

    The nodes of a face are its corners first and then the middles of its sides.
    """
    quarters = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))
    return np.stack([faces[:, list(quarter)] for quarter in quarters], axis=1).reshape(-1, 3)


def surface_stress(history: History, shoe: int, rows: ArrayLike) -> xr.Dataset:
    """Von Mises stress and elastic displacement of a shoe's surface at the stored instants of some rows.

    Returns
    -------
    xarray.Dataset
        `von_mises` (time, node), Pa; `displacement` (time, node, axis), m, in the shoe's frame;
        `node_position` (node, axis), m; `triangle` (face, corner), indices along node in outward sense.

    Raises
    ------
    ValueError
        If the shoe is not a flexible one of the history.
    """
    check_flexible(history.case, shoe)
    basis = stress_basis(history, [shoe])
    shapes = basis.shapes
    used, corners = np.unique(flat_triangles(shapes.mesh.boundary), return_inverse=True)
    q = basis.coordinates[shoe][np.asarray(rows)]
    parts = [q[start : start + AT_ONCE] for start in range(0, len(q), AT_ONCE)]
    von_mises = np.concatenate([shapes.von_mises(part, used).astype("f4") for part in parts])
    bend = np.concatenate([shapes.displacement(part)[:, used].astype("f4") for part in parts])
    return xr.Dataset(
        {
            "von_mises": (("time", "node"), von_mises, QUANTITIES["frame_von_mises"].attributes),
            "displacement": (("time", "node", "axis"), bend, QUANTITIES["frame_displacement"].attributes),
            "node_position": variable("node_position", shapes.nodes[used]),
            "triangle": (("face", "corner"), corners.reshape(-1, 3)),
        },
        coords={"time": history.time.isel(time=np.asarray(rows)), "axis": ["x", "y", "z"]},
    )
