"""Stresses of the flexible shoes over a run: of all nodes as a dataset, or of one node."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.model.flexible_shoes import whole_reduction
from exudyn_crawler.results.history import History, as_history, catalogue, files, phases
from exudyn_crawler.results.loads.load_map import check_flexible, loads_by_kind
from exudyn_crawler.results.stress import hot_spots
from exudyn_crawler.results.stress.basis import stress_basis, unit_stress
from fem import Extremes, OneOfEach, Shapes, mesh_error, recover_extremes
from fem.body.element_stress import principal, von_mises
from fem.memory import give_back_memory
from fem.stress import trust
from fem.stress.candidates import scaled_shapes

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")


@dataclass(frozen=True)
class StressResults:
    """Recovered stresses of a run.

    `dataset` has the catalogue's quantities of stress. Dimensions are shoe (the flexible ones), time, node,
    frame (chosen stored instants, s) and axis; face and corner of the surface's flat triangles, four a face.
    `highest_von_mises` is that of usable nodes: not in a rigid spider, and not `at_load`, where the stress by
    a force on one node grows without limit as the mesh is refined. `frame_name` is "begin", "end of dig" or
    "peak".
    """

    dataset: xr.Dataset
    hot_spots: Mapping[int, pd.DataFrame]  # nodes not at_load by shoe, see `hot_spots.ranked_nodes`
    by_region: Mapping[int, pd.DataFrame]  # highest node of every region but the bores, by shoe
    whole: Shapes  # modes and static fields as the basis of the stresses

    def _repr_html_(self) -> str:
        """Return the hot spots of every shoe and the dataset, as HTML for notebooks."""
        of = "highest von Mises stresses (Pa; places in m at t = 0)"
        tables = [f"<p>Shoe {k}: {of}</p>{spots.to_html(index=False)}" for k, spots in self.hot_spots.items()]
        return "".join([*tables, self.dataset._repr_html_()])


def recover_stresses(
    history: History | str | Path, times: Sequence[float] | None = None, peak: bool = True
) -> StressResults:
    """Recover the stresses of all flexible shoes from a run, or from the file of its history.

    Whole fields are those of the stored instants nearest to `times` (s) within the run, by default begin and
    ends of the load cycle's phases. With `peak` they include the instant of the highest stress of all shoes.
    ValueError if the run has no flexible shoes, or none of the times lies within it.
    """
    history = as_history(history)
    names = _frames(history, times)
    basis = stress_basis(history)
    whole = basis.shapes
    coordinates = basis.coordinates
    regions = hot_spots.shoe_regions(whole, history.case.track)
    pulled = {shoe: hot_spots.near_pull(history, whole, shoe) for shoe in coordinates}
    usable = {
        shoe: np.setdiff1d(np.flatnonzero(~at_load), whole.held_nodes) for shoe, at_load in pulled.items()
    }
    scaled = scaled_shapes(whole.stress_modes)
    give_back_memory()
    reached = {
        shoe: recover_extremes(whole.stress_modes, q, ranked=usable[shoe], scaled=scaled)
        for shoe, q in coordinates.items()
    }
    del scaled
    if peak:
        highest = np.max([extremes.highest for extremes in reached.values()], axis=0)
        names.setdefault(int(highest.argmax()), []).append("peak")
    frames = np.array(sorted(names))
    words = [", ".join(filter(None, names[row])) for row in frames]
    datasets = []
    tables = {}
    by_region = {}
    each = OneOfEach(regions)
    for shoe, q in coordinates.items():
        peaks = reached[shoe].peaks
        datasets.append(_of_shoe(history, whole, q, reached[shoe], frames, pulled[shoe]))
        tables[shoe] = hot_spots.ranked_nodes(history, basis, shoe, peaks, regions, ~pulled[shoe])
        by_region[shoe] = hot_spots.highest_nodes(history, basis, shoe, peaks, regions, usable[shoe], each)
    # writing the results needs the mesh alone
    whole.forget_stress_modes()
    mesh = hot_spots.mesh_dataset(whole)
    dataset = xr.concat(datasets, dim=xr.Variable("shoe", list(coordinates)))
    dataset = dataset.transpose("time", "frame", "shoe", ...).assign(mesh.data_vars)
    dataset = dataset.assign(
        truncation=catalogue.variable("truncation", np.array(np.nan if basis.bound is None else basis.bound)),
        frame_name=catalogue.variable("frame_name", np.array(words, dtype=object)),
    )
    dataset = dataset.assign(peak_verdict=verdicts(dataset)).assign_coords(mesh.coords)
    return StressResults(dataset, tables, by_region, whole)


def _frames(history: History, times: Sequence[float] | None) -> dict[int, list[str]]:
    """Return rows of the stored instants nearest to times (s), or to the ends of phases, with their names."""
    duration = history.duration
    stored = history.time.values
    parts = phases(history.case.loads, duration)
    known = {0.0: "begin"} | {round(part.end, 9): f"end of {part.name}" for part in parts}
    within = [time for time in (known if times is None else times) if time <= duration * (1.0 + 1e-9)]
    if not within:
        raise ValueError(f"none of the times {times} s lies within the run of {duration:g} s")
    names: dict[int, list[str]] = {}
    for time in within:
        names.setdefault(int(np.argmin(np.abs(stored - time))), []).append(known.get(round(time, 9), ""))
    return names


def _of_shoe(
    history: History,
    whole: Shapes,
    q: np.ndarray,
    extremes: Extremes,
    frames: np.ndarray,
    at_load: np.ndarray,
) -> xr.Dataset:
    """Return the stress of one shoe with coordinates q (times, columns)."""
    time = history.time.values
    displacements = whole.displacement(q[frames])
    errors = [mesh_error(whole.mesh, whole.material, displacement) for displacement in displacements]
    resolved = trust.resolution_over(whole, q)
    named = {
        "highest_von_mises": extremes.highest,
        "highest_node": extremes.highest_nodes,
        "peak_von_mises": extremes.greatest,
        "peak_time": time[extremes.greatest_at],
        "least_von_mises": extremes.least,
        "peak_mesh_error": trust.with_bores(resolved.error, whole).astype(np.float32),
        "peak_jump": resolved.relative_jump.astype(np.float32),
        "at_load": at_load,
        "frame_von_mises": whole.von_mises(q[frames]).astype(np.float32),
        "frame_mesh_error": np.array(errors, dtype=np.float32),
        "frame_displacement": displacements.astype(np.float32),
    }
    return xr.Dataset(
        {name: catalogue.variable(name, values, without=("shoe",)) for name, values in named.items()},
        coords={
            "time": ("time", time, {"units": "s"}),
            "frame": ("frame", time[frames], {"units": "s", "long_name": "chosen instants"}),
        },
    )


def verdicts(stress: xr.Dataset, more: np.typing.ArrayLike = 0.0) -> catalogue.Variable:
    """Return verdicts on a run's greatest stresses with a further uncertainty `more` (shoe, node), Pa."""
    ordered = stress.transpose("shoe", ...)
    size = np.maximum(ordered.peak_von_mises.values, np.finfo(float).tiny)
    mesh = ordered.peak_mesh_error.values
    # NaN where no stress is known
    part = mesh + (np.nan_to_num(float(stress.truncation)) + np.asarray(more)) / size
    part = np.where(ordered.at_load.values, np.nan, part)
    held = np.broadcast_to(stress.in_spider.values, part.shape)
    numbers = trust.verdict_numbers(part, mesh, ordered.peak_jump.values, held)
    return catalogue.variable("peak_verdict", numbers)


def peak_time(history: History, shoe: int) -> float:
    """Return the time (s) of the highest von Mises stress of a flexible shoe; ValueError for others."""
    basis = stress_basis(history, [shoe])
    extremes = recover_extremes(basis.shapes.stress_modes, basis.coordinates[shoe])
    return float(history.time[int(extremes.highest.argmax())])


def node_stress(
    history: History | str | Path, shoe: int, near: np.typing.ArrayLike | None = None, node: int | None = None
) -> xr.Dataset:
    """Return the stress over time at a node of a flexible shoe, nearest to a point or given by its number.

    The history may be the path of its file. `near` is a point in the shoe's frame, m: x along the track, z
    up, from the nominal COM of the undeformed shoe. `node` is a number as in tables of hot spots, from 0.

    `stress` is (time, component), Pa, in the shoe's axes; `principal` (time, order), Pa, in falling order;
    `von_mises` (time), Pa; `place` (axis), m, of the node in the shoe's frame. Attributes are shoe, node,
    `distance_m` of the node from `near`, and `in_spider`: True for a node in a joint's rigid spider, with the
    stress beside a rigid ring.

    FileNotFoundError if there is no such file; ValueError if it holds no history. ValueError also if the shoe
    is not a flexible one, or there is no such node. ValueError if the point is not three finite numbers, or
    far from the shoe. ValueError if both or neither of `near` and `node` are given.
    """
    # bad input is refused before a long history is read
    case = history.case if isinstance(history, History) else files.case_in_file(Path(history))
    check_flexible(case, shoe)
    whole = whole_reduction(case).body
    number, distance = _chosen(whole, near, node)
    history = history if isinstance(history, History) else History.load(history)
    stress = sum(loads_by_kind(history, shoe).values()) @ unit_stress(case, number)
    in_spider = bool(np.isin(number, whole.held_nodes))
    pascal = {"units": "Pa"}
    return xr.Dataset(
        {
            "stress": (("time", "component"), stress, pascal | {"long_name": "stress in the shoe's axes"}),
            "principal": (("time", "order"), principal(stress)[:, ::-1], pascal),
            "von_mises": ("time", von_mises(stress), pascal | {"long_name": "von Mises stress"}),
            "place": ("axis", whole.nodes[number], {"units": "m", "long_name": "place in the shoe's frame"}),
        },
        coords={"time": history.time, "component": list(COMPONENTS), "order": [1, 2, 3], "axis": [*"xyz"]},
        attrs={"shoe": shoe, "node": number, "distance_m": distance, "in_spider": in_spider},
    )


def node_table(dataset: xr.Dataset) -> pd.DataFrame:
    """Return the dataset of `node_stress` as a table: a row a stored time, stresses in MPa."""
    names = [*COMPONENTS, *(f"principal {k}" for k in dataset.order.values), "von Mises"]
    stress = np.column_stack((dataset.stress, dataset.principal, dataset.von_mises)) / hot_spots.MEGA
    table = pd.DataFrame(stress, columns=[f"{name} in MPa" for name in names])
    table.insert(0, "time in s", dataset.time.values)
    return table


def _chosen(whole: Shapes, near: np.typing.ArrayLike | None, node: int | None) -> tuple[int, float]:
    """Return the number of the chosen node, and its distance in m from the given point (0 without one)."""
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
    far = f"got {point.tolist()}, {distances[number]:.4g} m from the nearest node"
    if distances[number] > np.ptp(whole.nodes, axis=0).max():
        raise ValueError(f"near must be a point of the shoe, in m in its frame, {far}")
    return number, float(distances[number])
