"""What the stress of a history is the product of: columns of displacement and stress, and coordinates.

The columns are all modes and, where the case asks for them, static fields: what static answers to the loads
of this history have beyond the modes. Their coordinates are products of those of the shoe's unit loads with
what each makes of the columns. Static fields have fewer and smoother unit loads than the shoe, since each
takes a static solution of the finite elements: a coarser grid of tractions that change evenly between its
points, and stations of each rail with a pressure about them. `StaticLoads.shares` turns the shoe's into
these, with the same forces.
"""

import itertools
import tempfile
import weakref
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import block_diag, csr_array, eye_array, hstack, kron, vstack

import fem
from exudyn_crawler.case import Case
from exudyn_crawler.files import writable_folder
from exudyn_crawler.model import flexible_shoes, reductions
from exudyn_crawler.results.history import History, files
from exudyn_crawler.results.loads import load_map
from fem import patches, rank

TOLERANCE = 1e4
"""Pa by which fields that are left out may change a stress, as far as `MOST_FIELDS` allows: 0.01 MPa."""
MOST_FIELDS = 0.4  # greatest number of fields over that of modes
LONG, PART = rank.SEGMENT, 2**12
"""Stored times of a run whose loads and coordinates are in memory together: 33 s, stored every 2 ms; and of a
longer one, of whose contacts with units there are 30 kB a time."""
LOADS = {"joint": "pins", "load": "machine load", "contact": "ground", "roller": "rollers", "chain": "drive"}
LOADS |= {"carrier": "carriers", "slide": "slides"}
"""Words for kinds of actions; others are their own. The chain pulls for the drive and at its ends."""
GROUND_SPACING = 0.2  # m, at most, between points of the ground's grid: a fifth of a unit
RAIL_REACH = 0.1
"""m, half the length over which a force on a rail is spread: about an element; a roller's line is shorter."""
RAIL_SPACING = 0.0375  # m, about, between stations of a rail: `Stations` says what it leaves open


def ground_grid(mesh: fem.Mesh) -> fem.PressureGrid:
    """Grid of the static fields over the underside of a shoe; ValueError if that is no level rectangle."""
    under = mesh.nodes[mesh.nodes_of("underside"), :2]
    low, high = under.min(axis=0), under.max(axis=0)
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


def static_loads(case: Case) -> StaticLoads | None:
    """Static fields beside all modes of a case's flexible shoes; cached on disk. None if not asked for."""
    if not case.flexible_shoes().static_fields:
        return None
    return _static_loads(load_map.unit_loads(case), flexible_shoes.whole_reduction(case))


@lru_cache(maxsize=2)
def _static_loads(units: load_map.ShoeUnitLoads, whole: fem.CachedReduction) -> StaticLoads:
    mesh, interfaces = units.body.mesh, units.whole.interfaces
    families = {load_map.JOINTS: fem.UnitLoads.at_centers(len(mesh.nodes), interfaces)}
    blocks = [eye_array(6 * len(interfaces))]
    for name, family in units.spread.items():
        if name == load_map.GROUND and units.underside is not None:
            grid = ground_grid(mesh)
            weights, shares = grid.weights, csr_array(_ground_shares(units.underside, grid))
        elif name == load_map.RAILS and units.strips is not None:
            stations = rail_stations(mesh)
            weights = hstack([one.weights for one in stations])
            shares = _rail_shares(units.strips, stations)
        else:
            weights, shares = np.zeros((len(mesh.nodes), len(family.weights))), eye_array(len(family.weights))
            weights[family.nodes] = family.weights.T
        families[name] = fem.UnitLoads.spread(csr_array(weights), interfaces)
        blocks.append(kron(shares, eye_array(3)))
    families[load_map.INERTIA] = fem.UnitLoads.of_inertia(units.integrated.body.modes, interfaces)
    blocks.append(eye_array(len(units.integrated.body.frequencies)))
    cached = reductions.cached_fields(units.body, whole, families)
    return StaticLoads(cached.fields, csr_array(block_diag(blocks)))


def _ground_shares(underside: patches.Underside, grid: fem.PressureGrid) -> np.ndarray:
    """Tractions (p, points of a grid) nearest to a unit over each rectangle from the underside's corner."""
    numbers = np.indices(underside.integral.shape[:2]).reshape(2, -1)
    sides = numbers.T * underside.cell
    low = np.tile(underside.corner, (len(sides), 1))
    forces = np.outer(np.prod(sides, axis=1), (0.0, 0.0, 1.0))
    return grid.coordinates(forces, low, low + sides)[..., 2]


def _rail_shares(strips: load_map.StripStations, stations: Sequence[fem.Stations]) -> csr_array:
    """Forces at static fields' stations, in the middle of a rail, by one at each station of the strips."""
    blocks = []
    for rail in stations:
        level = rail.rectangle
        x = np.clip(strips.positions, level.low[0], level.high[0])
        blocks.append(vstack([csr_array(rail.coordinates(np.ones((len(x), 1)), x)[..., 0])] * strips.lines))
    return csr_array(block_diag(blocks))


class StoredRows:
    """Rows (t, m) in a file without a name, of which parts are read: coordinates of a long run."""

    def __init__(self, columns: int) -> None:
        self._file = tempfile.TemporaryFile(dir=writable_folder(reductions.reductions_folder()))  # noqa: SIM115 - as long as it
        self.shape = (0, columns)
        weakref.finalize(self, self._file.close)

    def append(self, rows: np.ndarray) -> None:
        """Write rows behind the others."""
        rows.tofile(self._file)
        self.shape = (self.shape[0] + len(rows), self.shape[1])

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[np.ndarray]:
        """Blocks of rows, in order."""
        return (self[rows] for rows in parts_of(len(self)))

    def __getitem__(self, rows: slice | np.ndarray) -> np.ndarray:
        """Rows of a slice, or of numbers."""
        # mapped anew each time: what was read once does not stay in memory
        return np.array(np.memmap(self._file, float, "r", shape=self.shape)[rows])


Rows = np.ndarray | StoredRows


def parts_of(times: int) -> list[slice]:
    """Slices of successive stored times whose loads are in memory together."""
    return [slice(start, min(start + PART, times)) for start in range(0, times, PART)]


@dataclass(frozen=True)
class StressBasis:
    """Columns of displacement and stress with their coordinates."""

    shapes: fem.Shapes  # modes, and static fields beside them
    loads: Mapping[int, Mapping[str, csr_array]] | None
    """Coordinates (times, loads) by shoe, as of `loads_by_kind`; None for a long run, which has them anew."""
    answers: np.ndarray  # (loads, columns), coordinates of the columns that a unit of each load makes
    coordinates: Mapping[int, Any]  # (times, columns), their products by shoe: an array or `StoredRows`
    bound: float | None
    """Pa by which left-out fields change the stress of any node at most; None without fields: not known."""
    history: History | None = None  # of a run

    def by_load(self, shoe: int, rows: np.ndarray | slice = slice(None)) -> dict[str, np.ndarray]:
        """Coordinates of a shoe at stored times by what makes them: arrays (times, columns).

        They add up to those of all; loads that make nothing are left out. By words of `LOADS` for kinds of
        actions, or those kinds; "inertia" is that of the integrated modes.
        """
        found: dict[str, np.ndarray] = {}
        if self.loads is not None:
            kinds = {kind: loads[rows] for kind, loads in self.loads[shoe].items()}
        else:
            assert self.history is not None
            kinds = load_map.loads_by_kind(_in_memory(self.history, rows), shoe)
        for kind, loads in kinds.items():
            load, own = LOADS.get(kind, kind), np.asarray(loads @ self.answers)
            if own.any():
                found[load] = found.get(load, 0.0) + own
        return found


def _in_memory(history: History, rows: np.ndarray | slice) -> History:
    """Stored times of a history, all of it in memory but the motion of the units, which are hundreds."""
    part = history.dataset.isel(time=rows)
    units = {f"{name}{rate}" for name in files.SHAPES for rate in files.RATES}
    return History(history.case, part.assign({name: part[name].load() for name in {*part.data_vars} - units}))


@dataclass(frozen=True)
class _Histories(Sequence[np.ndarray]):
    """Coordinates (times, fields) of static fields' loads of a long run, of a segment and a shoe each."""

    history: History
    shoes: Sequence[int]
    shares: csr_array

    def loads(self) -> Iterator[tuple[int, csr_array]]:
        """Loads of all segments with their shoe."""
        for rows in parts_of(self.history.time.size):
            part = _in_memory(self.history, rows)
            yield from ((shoe, sum(load_map.loads_by_kind(part, shoe).values())) for shoe in self.shoes)

    def __len__(self) -> int:
        return len(self.shoes) * len(parts_of(self.history.time.size))

    def __iter__(self) -> Iterator[np.ndarray]:
        return ((load @ self.shares).toarray() for _, load in self.loads())

    def __getitem__(self, number: Any) -> Any:
        return next(itertools.islice(self, number, None))


def stress_basis(history: History, shoes: Sequence[int] | None = None) -> StressBasis:
    """Columns and coordinates of the stress of flexible shoes, by default of all; ValueError for others.

    Of a run of more than `LONG` stored times memory holds a segment; its coordinates are in a file.
    """
    if history.case.flexible is None:
        raise ValueError("the history has no flexible shoes")
    chosen = list(history.case.flexible.shoes if shoes is None else shoes)
    units, static = load_map.unit_loads(history.case), static_loads(history.case)
    shapes: fem.Shapes = units.whole
    by_kind, answers, bound = None, units.answers, None
    shares = eye_array(units.size, format="csr") if static is None else static.shares
    long = _Histories(history, chosen, shares)
    if history.time.size <= LONG:
        by_kind = {shoe: load_map.loads_by_kind(history, shoe) for shoe in chosen}
    loads = {} if by_kind is None else {shoe: sum(kinds.values()) for shoe, kinds in by_kind.items()}
    if static is not None:
        frequencies = units.whole.frequencies
        histories = [(load @ static.shares).toarray() for load in loads.values()] or long
        most = int(MOST_FIELDS * len(frequencies))
        columns = fem.field_columns(units.body, static.fields, histories, TOLERANCE, most)
        answers = static.shares @ np.hstack((static.fields.held(frequencies), columns.turn))
        shapes, bound = columns.beside(units.whole), columns.bound
    coordinates: dict[int, Any] = {shoe: load @ answers for shoe, load in loads.items()}
    if by_kind is None:
        coordinates = {shoe: StoredRows(answers.shape[1]) for shoe in chosen}
        for shoe, load in long.loads():
            coordinates[shoe].append(load @ answers)
    return StressBasis(shapes, by_kind, answers, coordinates, bound, history)


def unit_stress(case: Case, node: int) -> np.ndarray:
    """Stress (loads, 6) in Pa at a node by a unit of each load of `unit_loads`, with all static fields."""
    units, static = load_map.unit_loads(case), static_loads(case)
    if static is None:
        return np.asarray(units.answers @ units.whole.stress_modes[node].T)
    return np.asarray(static.shares @ static.fields.stress_at(units.whole, node))
