"""Factors of the stress of a history: columns of displacement and stress, and their coordinates.

The columns are all modes and, if the case wants them, static fields: the part of the static responses to
this history's loads that the modes lack. The coordinates are products of the coordinates of the shoe's unit
loads with the columns' coordinates for each unit load. Static fields have fewer and smoother unit loads than
the shoe, since each takes a static solution of the finite elements. The ground has a coarser grid, with
tractions linear between its points; each rail has stations with a pressure about them. `StaticLoads.shares`
maps the shoe's unit loads to these, with the same forces.
"""

import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import block_diag, csr_array, eye_array, hstack, kron, vstack

import fem
from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters.track import FlexibleShoes
from exudyn_crawler.files import writable_folder
from exudyn_crawler.model import flexible_shoes, reductions
from exudyn_crawler.results.history import History, files
from exudyn_crawler.results.loads import load_map
from exudyn_crawler.results.loads.kinds import Kind
from fem.body import rectangle_motion
from fem.memory import give_back_memory
from fem.stress import low_rank

TOLERANCE = 1e4
"""Greatest change of a stress by omitted fields, Pa, as far as `MOST_FIELDS` allows: 0.01 MPa."""
MOST_FIELDS = 0.4  # greatest number of fields, fraction of the number of modes
MOST_HELD = 1.5e8
"""Greatest size of static fields that stay in memory for their next use, bytes; study mesh: 2.2e8."""
LONG, PART = low_rank.SEGMENT, 2**12
"""Stored times with loads and coordinates in memory together: `LONG` of a run, 33 s stored every 2 ms; `PART`
of a longer run, since its contacts with units take 30 kB a time."""
GROUND_SPACING = 0.2  # greatest distance of points of the ground's grid, m: a fifth of a unit
RAIL_REACH = 0.1
"""Half the length of a rail that carries a force, m: about an element; a roller's line contact is shorter."""
RAIL_SPACING = 0.0375  # approximate distance of stations on a rail, m; see `Stations` for its error


def ground_grid(mesh: fem.Mesh) -> fem.PressureGrid:
    """Return the static fields' grid over the underside of a shoe; ValueError if it is no level rectangle."""
    under = mesh.nodes[mesh.nodes_of("underside"), :2]
    low = under.min(axis=0)
    high = under.max(axis=0)
    along, across = (1 + int(np.ceil(side / GROUND_SPACING)) for side in high - low)
    return fem.PressureGrid(fem.FlatRectangle(mesh, "underside", low, high), (along, across))


def rail_stations(mesh: fem.Mesh) -> list[fem.Stations]:
    """Return the static fields' stations on each rail of a shoe, from right to left.

    Each rail is a level rectangle.
    """
    rails = fem.flat_parts(mesh, "rails")
    lengths = [rail.high[0] - rail.low[0] for rail in rails]
    return [
        fem.Stations(rail, 1 + round(length / RAIL_SPACING), min(RAIL_REACH, 0.5 * length))
        for rail, length in zip(rails, lengths, strict=True)
    ]


class StaticLoads(NamedTuple):
    """Static fields of a shoe's loads, and shares (k, f) of their f unit loads in the k of the shoe."""

    fields: fem.StaticFields
    shares: csr_array
    path: Path  # file of the fields; absent if it could not be written

    @property
    def is_large(self) -> bool:
        """True for fields too large to stay in memory between uses."""
        return self.fields.displacements.nbytes > MOST_HELD


def static_loads(case: Case) -> StaticLoads | None:
    """Return the static fields of a case's flexible shoes, cached on disk; None if the case wants none."""
    if not case.part(FlexibleShoes).static_fields:
        return None
    return _static_loads(load_map.unit_loads(case), flexible_shoes.whole_reduction(case))


def forget_static_fields() -> None:
    """Free the memory of static fields, 0.25 GB for the study mesh; later uses read them from disk."""
    _static_loads.cache_clear()


def store_static_fields(case: Case) -> None:
    """Keep large static fields of a case's flexible shoes on disk only, unless they have no file."""
    static = static_loads(case)
    if static is not None and static.is_large and static.path.is_file():
        forget_static_fields()


@lru_cache(maxsize=2)
def _static_loads(units: load_map.ShoeUnitLoads, whole: fem.CachedReduction) -> StaticLoads:
    families = field_families(units)
    folder = reductions.reductions_folder()
    factors = flexible_shoes.partition(units.body, units.whole.interfaces)
    fields, path, _ = fem.cached_static_fields(folder, factors, whole, families, warn=reductions.warn)
    return StaticLoads(fields, field_shares(units), path)


def field_families(units: load_map.ShoeUnitLoads) -> dict[str, fem.UnitLoads]:
    """Return the static fields' unit loads by family; they replace those of the shoe."""
    mesh = units.body.mesh
    interfaces = units.whole.interfaces
    families = {load_map.JOINTS: fem.UnitLoads.at_centers(len(mesh.nodes), interfaces)}
    for name, family in units.spread.items():
        if name == load_map.GROUND and units.underside is not None:
            weights = ground_grid(mesh).weights
        elif name == load_map.RAILS and units.strips is not None:
            weights = hstack([station.weights for station in rail_stations(mesh)])
        else:
            weights = np.zeros((len(mesh.nodes), len(family.weights)))
            weights[family.nodes] = family.weights.T
        families[name] = fem.UnitLoads.spread(csr_array(weights), interfaces)
    if units.contacts:
        families[load_map.PINS] = fem.UnitLoads(*units.pressures)
    families[load_map.INERTIA] = fem.UnitLoads.of_inertia(units.integrated.body.modes, interfaces)
    return families


@lru_cache(maxsize=2)
def field_shares(units: load_map.ShoeUnitLoads) -> csr_array:
    """Return the shares (k, f) of the f loads of static fields in the k unit loads of a shoe."""
    mesh = units.body.mesh
    blocks = [eye_array(6 * len(units.whole.interfaces))]
    for name, family in units.spread.items():
        if name == load_map.GROUND and units.underside is not None:
            shares = csr_array(_ground_shares(units.underside, ground_grid(mesh)))
        elif name == load_map.RAILS and units.strips is not None:
            shares = _rail_shares(units.strips, rail_stations(mesh))
        else:
            shares = eye_array(len(family.weights))
        blocks.append(kron(shares, eye_array(3)))
    if units.contacts:
        blocks.append(eye_array(units.pressures[1].shape[1]))
    blocks.append(eye_array(len(units.integrated.body.frequencies)))
    return csr_array(block_diag(blocks))


def _ground_shares(underside: rectangle_motion.Underside, grid: fem.PressureGrid) -> np.ndarray:
    """Return tractions (p, points of a grid) nearest to 1 over each rectangle from the underside's corner."""
    numbers = np.indices(underside.integral.shape[:2]).reshape(2, -1)
    sides = numbers.T * underside.cell
    low = np.tile(underside.corner, (len(sides), 1))
    forces = np.outer(np.prod(sides, axis=1), (0.0, 0.0, 1.0))
    return grid.coordinates(forces, low, low + sides)[..., 2]


def _rail_shares(strips: load_map.StripStations, stations: Sequence[fem.Stations]) -> csr_array:
    """Return forces at static fields' stations, in a rail's middle, by 1 at each station of the strips."""
    blocks = []
    along = strips.rear + strips.spacing * np.arange(load_map.STRIP_STATIONS)
    for rail in stations:
        x = np.clip(along, rail.rectangle.low[0], rail.rectangle.high[0])
        blocks.append(vstack([csr_array(rail.coordinates(np.ones((len(x), 1)), x)[..., 0])] * strips.lines))
    return csr_array(block_diag(blocks))


def parts_of(times: int) -> list[slice]:
    """Return slices of successive stored times; memory holds the loads of one slice together."""
    return [slice(start, min(start + PART, times)) for start in range(0, times, PART)]


@dataclass(frozen=True)
class StressBasis:
    """Columns of displacement and stress, and their coordinates."""

    shapes: fem.Shapes  # modes, and static fields beside them
    loads: Mapping[int, Mapping[Kind, csr_array]] | None
    """Coordinates (times, loads) by shoe, see `loads_by_kind`; None if they come from a history."""
    answers: np.ndarray  # (loads, columns), coordinates of the columns by a unit of each load
    coordinates: Mapping[int, np.ndarray]  # (times, columns), products by shoe; in files for a long run
    bound: float | None
    """Greatest change of the stress of any node by omitted fields, Pa; None (not known) without fields."""
    history: History | None = None  # source of the loads of `by_load`

    def by_load(self, shoe: int, rows: np.ndarray | slice = slice(None)) -> dict[str, np.ndarray]:
        """Return the coordinates of a shoe at stored times by load: arrays (times, columns).

        Their sum is that of all loads; loads without effect are left out. The names are those of `Kind.load`;
        "inertia" is that of the integrated modes.
        """
        by_load: dict[str, np.ndarray] = {}
        if self.loads is not None:
            kinds = {kind: loads[rows] for kind, loads in self.loads[shoe].items()}
        else:
            assert self.history is not None
            kinds = load_map.loads_by_kind(_in_memory(self.history, rows), shoe)
        for kind, loads in kinds.items():
            coordinates = np.asarray(loads @ self.answers)
            if coordinates.any():
                by_load[kind.load] = by_load.get(kind.load, 0.0) + coordinates
        return by_load


def _in_memory(history: History, rows: np.ndarray | slice) -> History:
    """Return stored times of a history, in memory except for the motion of the hundreds of units."""
    part = history.dataset.isel(time=rows)
    rest = part.drop_vars(files.UNIT_MOTION, errors="ignore").load()
    return History(history.case, part.assign(rest.data_vars))


@dataclass(frozen=True)
class _Again:
    """Iterable that calls a function for each iteration."""

    make: Callable[[], Iterator[Any]]

    def __iter__(self) -> Iterator[Any]:
        return self.make()


def _loads(history: History, shoes: Sequence[int], is_long: bool) -> Iterator[tuple[int, csr_array]]:
    """Yield the loads of shoes over a history, part by part for a long one."""
    parts = (_in_memory(history, rows) for rows in parts_of(history.time.size)) if is_long else [history]
    for part in parts:
        yield from ((shoe, sum(load_map.loads_by_kind(part, shoe).values())) for shoe in shoes)


def _in_files(parts: Iterable[tuple[int, np.ndarray]]) -> dict[int, np.ndarray]:
    """Return rows (times, columns) of shoes that come in parts, each in an unnamed memory-mapped file."""
    folder = writable_folder(reductions.reductions_folder())
    stored = dict[int, Any]()
    # a memory map keeps its file after the file is closed
    with ExitStack() as opened:
        for shoe, rows in parts:
            if shoe not in stored:
                stored[shoe] = opened.enter_context(tempfile.TemporaryFile(dir=folder))
            rows.tofile(stored[shoe])
        maps = {shoe: np.memmap(file, float, "r") for shoe, file in stored.items()}
        return {shoe: np.asarray(memory).reshape(-1, rows.shape[1]) for shoe, memory in maps.items()}


@contextmanager
def _on_disk(parts: Iterable[tuple[int, np.ndarray]]) -> Iterator[Iterable[tuple[int, np.ndarray]]]:
    """Yield an iterable of the rows of shoes in an unnamed file; it holds one shoe in memory at a time."""
    with tempfile.TemporaryFile(dir=writable_folder(reductions.reductions_folder())) as file:
        shoes = []
        for shoe, rows in parts:
            np.save(file, rows)
            shoes.append(shoe)

        def stored() -> Iterator[tuple[int, np.ndarray]]:
            file.seek(0)
            return ((shoe, np.load(file)) for shoe in shoes)

        yield _Again(stored)


def stress_basis(history: History, shoes: Sequence[int] | None = None) -> StressBasis:
    """Return columns and coordinates of the stress of flexible shoes, by default all; ValueError for others.

    For a run of more than `LONG` stored times memory holds a segment, and a file has the coordinates.
    """
    chosen = list(history.case.part(FlexibleShoes).shoes if shoes is None else shoes)
    units = load_map.unit_loads(history.case)
    is_long = history.time.size > LONG
    loads: Iterable[tuple[int, Any]] = _Again(lambda: _loads(history, chosen, is_long))
    if not history.case.part(FlexibleShoes).static_fields:
        coordinates = _coordinates(loads, units.answers, is_long)
        return StressBasis(units.whole, None, units.answers, coordinates, None, history)
    # a static field takes the place of many loads
    shares = field_shares(units)
    fewer = _Again(lambda: ((shoe, (rows @ shares).toarray()) for shoe, rows in loads))
    most = int(MOST_FIELDS * len(units.whole.frequencies))
    with nullcontext(fewer) if is_long else _on_disk(fewer) as acting:
        give_back_memory()
        static = static_loads(history.case)
        assert static is not None
        histories: Any = _Again(lambda: (rows for _, rows in acting))
        columns = fem.field_columns(units.body, static.fields, histories, TOLERANCE, most)
        answers = np.hstack((static.fields.held(units.whole.frequencies), columns.turn))
        # the few columns replace the static fields
        is_large = static.is_large
        del static
        if is_large:
            forget_static_fields()
        give_back_memory()
        coordinates = _coordinates(acting, answers, is_long)
    shapes = columns.beside(units.whole)
    return StressBasis(shapes, None, shares @ answers, coordinates, columns.bound, history)


def _coordinates(
    loads: Iterable[tuple[int, Any]], answers: np.ndarray, is_long: bool
) -> dict[int, np.ndarray]:
    """Return coordinates (times, columns) by shoe of loads (times, k) with answers (k, columns) to units."""
    products = ((shoe, rows @ answers) for shoe, rows in loads)
    return _in_files(products) if is_long else dict(products)


def unit_stress(case: Case, node: int) -> np.ndarray:
    """Return the stress (loads, 6) in Pa at a node by a unit of each load, with all static fields.

    The loads are those of `unit_loads`.
    """
    units = load_map.unit_loads(case)
    static = static_loads(case)
    if static is None:
        return np.asarray(units.answers @ units.whole.stress_modes[node].T)
    return np.asarray(static.shares @ static.fields.stress_at(units.whole, node))
