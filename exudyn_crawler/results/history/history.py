"""Results of a run: named arrays over time with units and meaning, the case, and phases of the run."""

import difflib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
import xarray as xr

from exudyn_crawler.case import SIDES, Case, LoadCycle, MachineCycle
from exudyn_crawler.results.history import catalogue, files
from fem.interrupts import interrupts_wait

TIMES_IN_PART = 2**13  # stored times of a part of a long run; all its drawn quantities take 0.2 GB of memory
MOST_IN_MEMORY = 25 * 10**7  # size of a history that is read at once, bytes: 70 s of 13 rigid shoes at 2 ms
MOST_PHASES = 30  # greatest number of a cycle's phases that tables and pictures distinguish


@dataclass(frozen=True)
class History:
    """Results of a run.

    Every variable of the dataset is also an attribute: ``history.position.sel(shoe=13, axis="x")``.
    `exudyn_crawler.results.history.catalogue` lists the variables; each has unit and meaning as attributes.

    Attributes
    ----------
    case : Case
        Case of the run.
    dataset : xarray.Dataset
        Dimensions time (s), shoe, joint, unit, contact and axis (x, y, z of the global frame).
    begin : xarray.Dataset, optional
        First instant of the run, the origin of displacements; given for a later part of a run.
    """

    case: Case
    dataset: xr.Dataset
    begin: xr.Dataset | None = None

    def __getattr__(self, name: str) -> xr.DataArray:
        """Return a variable or coordinate of the dataset, or a quantity derived from them."""
        # copying and pickling ask for attributes before there is a dataset
        variables = self.dataset.variables if "dataset" in vars(self) else {}
        if name in variables and not name.startswith("_"):
            return self.dataset[name]
        if variables and name in catalogue.DERIVED:
            return self.quantity(name)
        raise AttributeError(f"a history has no {name!r}; it has {sorted(map(str, variables))}")

    def __dir__(self) -> list[str]:
        """Return the names of attributes for completion: those of every object and the variables."""
        derived = [name for name in catalogue.DERIVED if self.has(name)]
        return [*super().__dir__(), *map(str, self.dataset.variables), *derived]

    def _repr_html_(self) -> str:
        """Return the case in a line and the dataset, as HTML for notebooks."""
        shown = f"<p>History of the case {escape(repr(self.case.name))} over {self.duration:g} s</p>"
        return shown + self.dataset._repr_html_()

    @property
    def duration(self) -> float:
        """Time of the last state, s."""
        return float(self.dataset.time[-1])

    @property
    def in_memory(self) -> bool:
        """True unless variables are read from a file at each access."""
        return "source" not in self.dataset.encoding

    def has(self, name: str, stress: xr.Dataset | None = None) -> bool:
        """Return True if `quantity` can return a quantity of the catalogue."""
        quantity = catalogue.QUANTITIES[name]
        if catalogue.lacking(quantity, self.case):
            return False
        derives = quantity.derived_from and all(self.has(source, stress) for source in quantity.derived_from)
        return derives or name in self.dataset or (stress is not None and name in stress)

    def quantity(self, name: str, stress: xr.Dataset | None = None) -> xr.DataArray:
        """Return a quantity of the catalogue, stored or derived; those of stress come from `stress`.

        `stress` is the dataset of `StressResults`. ValueError for a name that the catalogue does not have, or
        a quantity that the case or its stresses do not have.
        """
        if name not in catalogue.QUANTITIES:
            near = difflib.get_close_matches(name, catalogue.QUANTITIES, n=1, cutoff=0.0)
            raise ValueError(f"there is no quantity {name!r}; the nearest is {near[0]!r}")
        if not self.has(name, stress):
            lacking = (
                catalogue.lacking(catalogue.QUANTITIES[name], self.case)
                or "more than a history: stresses, say"
            )
            raise ValueError(f"{name} needs {lacking}")
        if catalogue.QUANTITIES[name].derived_from:
            begin = self.dataset if self.begin is None else self.begin
            return catalogue.with_meaning(name, catalogue.DERIVED[name](self.case, self.dataset, begin))
        return self.dataset[name] if stress is None or name not in stress else stress[name]

    def over_time(self, names: Iterable[str], stress: xr.Dataset | None = None) -> dict[str, xr.DataArray]:
        """Return quantities of the catalogue by name, see `quantity`; those of contacts are by shoe."""
        chosen = list(names)
        of_pairs = [name for name in chosen if name in catalogue.BY_SHOE]
        contacts = catalogue.by_shoe(self.case, self.dataset, of_pairs) if of_pairs else {}
        return {name: contacts[name] if name in contacts else self.quantity(name, stress) for name in chosen}

    def contacts_by_shoe(self) -> xr.Dataset:
        """Return the contact of every shoe with all units below it: dimensions time, shoe, axis.

        normal_force, friction_force, contact_force (N), friction_torque (N m) and area (m2) are summed over
        the shoe's contacts. penetration (m), penetration_rate and slip_velocity (m/s) are those of the
        contact that penetrates deepest at the time.
        """
        return catalogue.by_shoe(self.case, self.dataset, catalogue.BY_SHOE)

    def of_track(self, side: str) -> "History":
        """Return the history of one of two tracks of a machine, "right" or "left", as that of a closed track.

        It has this track's shoes, links and contacts alone, numbered from 1. The position of its side frame
        is that of the machine's point in the middle of the track.
        """
        case = self.case.of_track(side)
        data = self.dataset.sel(track=side, drop=True)
        number = SIDES.index(side)
        count = case.track.shoe_count
        mine = slice(number * count, (number + 1) * count)
        wheels = len(case.gear.wheel_names)
        turn = catalogue.rotation_matrices(data.side_frame_angles.transpose(..., "axis").values)
        arm = self.case.gear.middles[number] * turn[..., 1]
        place = data.side_frame_position.transpose(..., "axis")
        data = data.isel(shoe=mine, joint=mine)
        for dim, names in _names_on(side, data).items():
            data = data.sel({dim: [f"{side} {name}" for name in names]}).assign_coords({dim: names})
        for dim, shoe in {"contact": "contact_shoe", "flexible_shoe": "flexible_shoe"}.items():
            if dim in data.dims:
                data = data.isel({dim: np.isin(data[shoe], data.shoe)})
                data = data.assign_coords({shoe: data[shoe] - mine.start})
        if "strip_wheel" in data:
            number_of = data.strip_wheel - number * wheels
            data = data.assign(strip_wheel=number_of.where(data.strip_wheel > 0, 0).astype(int))
        joint = ("joint", case.gear.joints(case.track), {"long_name": catalogue.LINKS[1]})
        data = data.drop_vars(["shoe_track", "joint_track"]).assign_coords(shoe=case.track.shoes, joint=joint)
        return History(case, data.assign(side_frame_position=place.copy(data=place.values + arm)))

    def save(self, path: str | Path, overwrite: bool = False) -> Path:
        """Write the history to one NetCDF file, contacts in single precision; see `results.history.files`.

        FileExistsError if the file exists and `overwrite` is false.
        """
        return files.save_joined(self.case, [files.Chunk.of(self.dataset)], Path(path), overwrite)

    def every(self, step: int) -> Self:
        """Return the history of every `step`-th stored time from the first, in memory; itself for step 1."""
        if step == 1:
            return self
        return type(self)(self.case, self.dataset.isel(time=slice(None, None, step)).load().drop_encoding())

    def parts(self, stress: xr.Dataset | None = None) -> Iterator[tuple[Self, xr.Dataset | None]]:
        """Yield consecutive parts with their `stress`; memory holds all quantities of one part together."""
        begin = self.dataset.isel(time=[0]) if self.begin is None else self.begin
        for start in range(0, self.time.size, TIMES_IN_PART):
            part = self.dataset.isel(time=slice(start, start + TIMES_IN_PART))
            part_stress = None if stress is None else stress.sel(time=slice(*part.time.values[[0, -1]]))
            yield type(self)(self.case, part, begin), part_stress

    @classmethod
    @interrupts_wait()
    def load(cls, path: str | Path) -> Self:
        """Read a file that `save` wrote.

        A file larger than `MOST_IN_MEMORY` stays on disk: a variable is read at each access.
        FileNotFoundError if there is no such file; ValueError if the file does not hold a history, or has
        another layout version.
        """
        path = Path(path)
        # first without h5netcdf, which fills the terminal over a file that HDF5 cannot read
        case = files.case_in_file(path)
        with files.reading_history(path):
            stored = xr.open_dataset(path, engine="h5netcdf", cache=False)
            dataset = files.unpacked(stored)
            if stored.nbytes <= MOST_IN_MEMORY:
                dataset = files.unpacked(stored.load().drop_encoding())
                stored.close()
            _check(case, dataset)
        return cls(case=case, dataset=dataset)


def _names_on(side: str, dataset: xr.Dataset) -> dict[str, list[str]]:
    """Return the names of one track's items, such as wheels, by dimension and without the track's side."""
    names = {}
    for dim in map(str, dataset.dims):
        texts = dataset[dim].values.astype(str).tolist() if dim in dataset.coords else []
        if mine := [text.removeprefix(f"{side} ") for text in texts if text.startswith(f"{side} ")]:
            names[dim] = mine
    return names


def as_history(run: History | str | Path) -> History:
    """Return a history as it is, or read it from a file; raise as `History.load`."""
    return run if isinstance(run, History) else History.load(run)


def _check(case: Case, dataset: xr.Dataset) -> None:
    """Raise ValueError if the variables of a dataset are not those of a history of the case."""
    catalogue.check_dimensions(dataset)
    stored = catalogue.select(files="history").items()
    always = {name for name, quantity in stored if {*quantity.needs} <= {case.terrain.model}}
    always -= {*files.TERRAIN_COORDINATES}
    if missing := sorted(always - set(map(str, dataset.variables))):
        raise ValueError(f"it has no {missing[0]}")
    numbers = {"shoe": case.track.shoes, "joint": case.gear.joints(case.track), "unit": case.terrain.units}
    for name, expected in numbers.items():
        if len(expected) and not np.array_equal(dataset[name], expected):
            raise ValueError(f"its {name}s are not those of its case")
    time = dataset.time.values
    if not (len(time) and np.isfinite(time).all() and (np.diff(time) > 0.0).all()):
        raise ValueError("its times do not increase")


class RunPhase(NamedTuple):
    """Part of a run."""

    name: str
    begin: float  # s
    end: float

    def rows(self, time: np.ndarray) -> np.ndarray:
        """Return True for each time (s) in the phase: (times,); its begin belongs to the phase before."""
        after = time >= 0.0 if self.begin == 0.0 else time > self.begin * (1.0 + 1e-9)
        return after & (time <= self.end * (1.0 + 1e-9))


def phases(cycle: LoadCycle | MachineCycle, duration: float) -> list[RunPhase]:
    """Return the phases that a run of some `duration` (s) reaches.

    The first phase begins with the run. The last phase of the cycle, whose loads stay, ends with the run. A
    phase that ends as the run begins is left out unless it is the only one. A cycle of more than
    `MOST_PHASES`, such as the rows of a measurement, is one phase.
    """
    if len(cycle.phases) > MOST_PHASES:
        return [RunPhase("loads", 0.0, duration)]
    ends = [phase.end for phase in cycle.phases]
    spans = zip(cycle.phases, pairwise([0.0, *ends[:-1], max(ends[-1], duration)]), strict=True)
    reached = [(phase.name, begin, min(end, duration)) for phase, (begin, end) in spans]
    return [RunPhase(*phase) for phase in reached if phase[1] < phase[2]]


def common_phases(*histories: History) -> list[RunPhase]:
    """Return the phases that runs have in common, by the longest run; empty if those of two runs differ.

    They are phases of the machine's load if there is a machine, else of the shoes' loads.
    """
    duration = max(history.duration for history in histories)
    cycles = (history.case.machine or history.case.loads for history in histories)
    first, *others = (phases(cycle, duration) for cycle in cycles)
    return first if all(other == first for other in others) else []
