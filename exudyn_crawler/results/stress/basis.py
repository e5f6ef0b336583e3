"""Factors of the stress of a history: columns of displacement and stress, and coordinates.

The columns are all modes and, where the case asks for them, static fields: what static answers to the loads
of this history have beyond the modes. Their coordinates are products of those of the shoe's unit loads with
what each makes of the columns. Static fields have fewer and smoother unit loads than the shoe, since each
takes a static solution of the finite elements: a coarser grid of tractions that change evenly between its
points, and stations of each rail with a pressure about them. `StaticLoads.shares` turns the shoe's into
these, with the same forces.
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
from exudyn_crawler.files import writable_folder
from exudyn_crawler.model import flexible_shoes, reductions
from exudyn_crawler.results.history import History, files
from exudyn_crawler.results.loads import load_map
from exudyn_crawler.results.loads.kinds import Kind
from fem.body import rectangle_motion
from fem.memory import give_back_memory
from fem.stress import low_rank

TOLERANCE = 1e4
"""Pa by which fields that are left out may change a stress, as far as `MOST_FIELDS` allows: 0.01 MPa."""
MOST_FIELDS = 0.4  # greatest number of fields over that of modes
MOST_HELD = 1.5e8
"""Bytes of static fields that stay in memory for what asks for them next; the study mesh's take 2.2e8."""
LONG, PART = low_rank.SEGMENT, 2**12
"""Stored times of a run whose loads and coordinates are in memory together: 33 s, stored every 2 ms; and of a
longer one, of whose contacts with units there are 30 kB a time."""
GROUND_SPACING = 0.2  # m, at most, between points of the ground's grid: a fifth of a unit
RAIL_REACH = 0.1
"""m, half the length over which a force on a rail is spread: about an element; a roller's line is shorter."""
RAIL_SPACING = 0.0375  # m, about, between stations of a rail: `Stations` says what it leaves open


def ground_grid(mesh: fem.Mesh) -> fem.PressureGrid:
    """Grid of the static fields over the underside of a shoe; ValueError if that is no level rectangle."""
    under = mesh.nodes[mesh.nodes_of("underside"), :2]
    low = under.min(axis=0)
    high = under.max(axis=0)
    along, across = (1 + int(np.ceil(side / GROUND_SPACING)) for side in high - low)
    return fem.PressureGrid(fem.FlatRectangle(mesh, "underside", low, high), (along, across))


def rail_stations(mesh: fem.Mesh) -> list[fem.Stations]:
    """Stations of the static fields on each rail of a shoe, from right to left; each a level rectangle."""
    rails = fem.flat_parts(mesh, "rails")
    lengths = [rail.high[0] - rail.low[0] for rail in rails]
    return [
        fem.Stations(rail, 1 + round(length / RAIL_SPACING), min(RAIL_REACH, 0.5 * length))
        for rail, length in zip(rails, lengths, strict=True)
    ]


class StaticLoads(NamedTuple):
    """Static fields of a shoe's loads, and the shares (k, f) of their f unit loads in the shoe's k."""

    fields: fem.StaticFields
    shares: csr_array
    path: Path  # file of the fields, unless the disk did not take it

    @property
    def is_large(self) -> bool:
        """True for fields that are not to be in memory while nothing needs them."""
        return self.fields.displacements.nbytes > MOST_HELD


def static_loads(case: Case) -> StaticLoads | None:
    """Static fields beside all modes of a case's flexible shoes; cached on disk. None if not asked for."""
    if not case.flexible_shoes().static_fields:
        return None
    return _static_loads(load_map.unit_loads(case), flexible_shoes.whole_reduction(case))


def forget_static_fields() -> None:
    """Free static fields, a quarter of a GB of the study's mesh; those asked for again come from the disk."""
    _static_loads.cache_clear()


def store_static_fields(case: Case) -> None:
    """Leave large static fields of a case's flexible shoes on disk alone, unless that takes none."""
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
    """Loads of the static fields by family, which take the place of a shoe's unit loads."""
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
    families[load_map.INERTIA] = fem.UnitLoads.of_inertia(units.integrated.body.modes, interfaces)
    return families


@lru_cache(maxsize=2)
def field_shares(units: load_map.ShoeUnitLoads) -> csr_array:
    """Shares (k, f) of the f loads of static fields in the k unit loads of a shoe."""
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
    blocks.append(eye_array(len(units.integrated.body.frequencies)))
    return csr_array(block_diag(blocks))


def _ground_shares(underside: rectangle_motion.Underside, grid: fem.PressureGrid) -> np.ndarray:
    """Tractions (p, points of a grid) nearest to a unit over each rectangle from the underside's corner."""
    numbers = np.indices(underside.integral.shape[:2]).reshape(2, -1)
    sides = numbers.T * underside.cell
    low = np.tile(underside.corner, (len(sides), 1))
    forces = np.outer(np.prod(sides, axis=1), (0.0, 0.0, 1.0))
    return grid.coordinates(forces, low, low + sides)[..., 2]


def _rail_shares(strips: load_map.StripStations, stations: Sequence[fem.Stations]) -> csr_array:
    """Forces at static fields' stations, in the middle of a rail, by one at each station of the strips."""
    blocks = []
    along = strips.rear + strips.spacing * np.arange(load_map.STRIP_STATIONS)
    for rail in stations:
        x = np.clip(along, rail.rectangle.low[0], rail.rectangle.high[0])
        blocks.append(vstack([csr_array(rail.coordinates(np.ones((len(x), 1)), x)[..., 0])] * strips.lines))
    return csr_array(block_diag(blocks))


def parts_of(times: int) -> list[slice]:
    """Slices of successive stored times whose loads are in memory together."""
    return [slice(start, min(start + PART, times)) for start in range(0, times, PART)]


@dataclass(frozen=True)
class StressBasis:
    """Columns of displacement and stress with their coordinates."""

    shapes: fem.Shapes  # modes, and static fields beside them
    loads: Mapping[int, Mapping[Kind, csr_array]] | None
    """Coordinates (times, loads) by shoe, see `loads_by_kind`; None where they come from a history."""
    answers: np.ndarray  # (loads, columns), coordinates of the columns that a unit of each load makes
    coordinates: Mapping[int, np.ndarray]  # (times, columns), their products by shoe; in files of a long run
    bound: float | None
    """Pa by which left-out fields change the stress of any node at most; None without fields: not known."""
    history: History | None = None  # of which `by_load` makes the loads of the times that are asked for

    def by_load(self, shoe: int, rows: np.ndarray | slice = slice(None)) -> dict[str, np.ndarray]:
        """Coordinates of a shoe at stored times by what makes them: arrays (times, columns).

        They add up to those of all; loads that make nothing are left out. The words are those of `Kind.load`;
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
    """Stored times of a history, all of it in memory but the motion of the units, which are hundreds."""
    part = history.dataset.isel(time=rows)
    rest = part.drop_vars(files.UNIT_MOTION, errors="ignore").load()
    return History(history.case, part.assign(rest.data_vars))


@dataclass(frozen=True)
class _Again:
    """Iterable that calls a function for every iteration."""

    make: Callable[[], Iterator[Any]]

    def __iter__(self) -> Iterator[Any]:
        return self.make()


def _loads(history: History, shoes: Sequence[int], is_long: bool) -> Iterator[tuple[int, csr_array]]:
    """Loads of shoes over a history; of a long one of a part after the other."""
    parts = (_in_memory(history, rows) for rows in parts_of(history.time.size)) if is_long else [history]
    for part in parts:
        yield from ((shoe, sum(load_map.loads_by_kind(part, shoe).values())) for shoe in shoes)


def _in_files(parts: Iterable[tuple[int, np.ndarray]]) -> dict[int, np.ndarray]:
    """Rows (times, columns) of shoes that come in parts, each in a file without a name that memory maps."""
    folder = writable_folder(reductions.reductions_folder())
    stored = dict[int, Any]()
    # a map keeps its file when that is closed
    with ExitStack() as opened:
        for shoe, rows in parts:
            if shoe not in stored:
                stored[shoe] = opened.enter_context(tempfile.TemporaryFile(dir=folder))
            rows.tofile(stored[shoe])
        maps = {shoe: np.memmap(file, float, "r") for shoe, file in stored.items()}
        return {shoe: np.asarray(memory).reshape(-1, rows.shape[1]) for shoe, memory in maps.items()}


@contextmanager
def _on_disk(parts: Iterable[tuple[int, np.ndarray]]) -> Iterator[Iterable[tuple[int, np.ndarray]]]:
    """Rows of shoes in a file without a name, of which an iteration has those of one shoe in memory."""
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
    """Columns and coordinates of the stress of flexible shoes, by default of all; ValueError for others.

    Of a run of more than `LONG` stored times memory holds a segment; its coordinates are in a file.
    """
    chosen = list(history.case.flexible_shoes().shoes if shoes is None else shoes)
    units = load_map.unit_loads(history.case)
    is_long = history.time.size > LONG
    loads: Iterable[tuple[int, Any]] = _Again(lambda: _loads(history, chosen, is_long))
    if not history.case.flexible_shoes().static_fields:
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
        # the few columns take their place
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
    """Coordinates (times, columns) by shoe of loads (times, k) with answers (k, columns) of their units."""
    products = ((shoe, rows @ answers) for shoe, rows in loads)
    return _in_files(products) if is_long else dict(products)


def unit_stress(case: Case, node: int) -> np.ndarray:
    """Stress (loads, 6) in Pa at a node by a unit of each load of `unit_loads`, with all static fields."""
    units = load_map.unit_loads(case)
    static = static_loads(case)
    if static is None:
        return np.asarray(units.answers @ units.whole.stress_modes[node].T)
    return np.asarray(static.shares @ static.fields.stress_at(units.whole, node))
