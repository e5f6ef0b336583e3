"""Tables of a run: key results, extremes, loads, and differences from another run."""

from collections.abc import Iterable, Iterator, Mapping
from operator import attrgetter
from typing import Any, Literal, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from exudyn_crawler.case import SIDES, Case
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.files import blocks
from exudyn_crawler.results.history import History, catalogue, phases, tension
from exudyn_crawler.results.history.side_frame import pins_in_frame

KEY_UNITS = catalogue.READ_IN | {"m": ("mm", 1e3)}
"""Units of key results for reading, and factors to them; lengths are small and read in mm."""
WHEELS = {"roller": "a roller", "idler": "the idler", "carrier": "a carrier", "slide": "a line of a slide"}
"""Kinds of wheels of closed tracks, and their words in names of results."""
HELD = "stress beside a pin coupling, not to be used"
"""Name of the highest stress of nodes in rigid spiders, shown if it exceeds the highest usable one."""
STRESSES = catalogue.select(files="stress")
START = ", start"
"""End of the name of a greatest value during the start of the drive."""
SAME_TIME = 1e-9  # fraction of a time below which two times are the same
AT_LIMIT = 0.95
"""Torque of a drive at its limit, fraction of the limit; the chain then lags by 3 times `torque_speed`."""
MOST_CHANGE = 1000.0  # greatest shown change of a greatest value, %; a larger one has no meaning


class Extreme(NamedTuple):
    """Extreme value of a series, the first of equal ones."""

    value: float
    of: str  # item with this value: shoe, link, roller
    time: float  # s


_value = attrgetter("value")
ResultRow = tuple[str, float, str, str, float]
"""Row of the key results: result, value, unit, of and at."""


def key_results(history: History, stress: xr.Dataset | None = None) -> pd.DataFrame:
    """Return greatest stress, forces, sinkage and speed of a run, its distance and its residual at the start.

    Greatest values but stresses are those after the start, see `start_ends`. One that is higher during the
    start has a row of its own, with `START` in its name. The stress is the highest usable one of the whole
    run; a higher one beside a pin coupling follows it. Columns are result, value, unit, of (shoe, link or
    roller, if any) and at (s). Vectors count by their length, forces by their magnitude.
    """
    ranked = sorted(
        catalogue.select(key_result=True).values(),
        key=lambda quantity: (quantity.key_place, quantity.key_result),
    )
    named = {quantity.name: quantity for quantity in ranked if history.has(quantity.name, stress)}
    greatest: dict[tuple[str, str], Extreme] = {}
    at_start: dict[tuple[str, str], Extreme] = {}
    driven = _Driven()
    begin = start_ends(history)
    for part, stresses in history.parts(stress):
        for name, values in part.over_time(named, stresses).items():
            after = (values.time >= begin * (1.0 - SAME_TIME)).values | (name in STRESSES)
            for chosen, found in ((after, greatest), (~after, at_start)):
                if chosen.any():
                    _add(found, part.case, name, values.isel(time=chosen))
        driven.add(part)
    rows = []
    for (name, label), extreme in _with_start(greatest, at_start):
        drawn, factor = KEY_UNITS.get(named[name].unit, (named[name].unit, 1.0))
        unit, factor = catalogue.OF_GROUND.get(name, (drawn, factor))
        rows.append((label, extreme.value * factor, unit, extreme.of, extreme.time))
        if name == "highest_von_mises" and stress is not None:
            rows += _held(stress, extreme.value, factor, unit)
    rows += [*driven.rows(), *_hanging(history)]
    # motion of the front shoe, or of the side frame that rolls over the shoes
    framed = history.has("side_frame_displacement")
    moved = part.side_frame_displacement if framed else part.displacement.isel(shoe=-1)
    of = "side frame" if framed else f"shoe {int(history.shoe[-1])}"
    rows.append(("distance travelled", float(_size(moved.isel(time=-1))), "m", of, history.duration))
    of, force = unbalanced(history)
    rows.append(("residual force at the start", 1e-3 * force, "kN", of, float(history.time[0])))
    return pd.DataFrame(rows, columns=["result", "value", "unit", "of", "at"])


def start_ends(history: History) -> float:
    """Return the time (s) at which the start of a run's drive ends; 0 if the run has no time after it."""
    end = history.case.drive.start_ends
    return end if end < history.duration * (1.0 - SAME_TIME) else 0.0


def _add(found: dict[tuple[str, str], Extreme], case: Case, name: str, values: xr.DataArray) -> None:
    """Add the extremes of a quantity's key results to those found so far."""
    for label, some in _apart(case, name, values):
        extreme = _extreme(_size(some))
        found[name, label] = max(found.get((name, label), extreme), extreme, key=_value)


def _with_start(
    greatest: Mapping[tuple[str, str], Extreme], at_start: Mapping[tuple[str, str], Extreme]
) -> Iterator[tuple[tuple[str, str], Extreme]]:
    """Yield all extremes, each with that of the start behind it if that is greater."""
    for (name, label), extreme in greatest.items():
        yield (name, label), extreme
        start = at_start.get((name, label), extreme)
        if start.value > extreme.value:
            yield (name, label + START), start


def greatest_over_time(history: History, names: Iterable[str]) -> dict[str, xr.DataArray]:
    """Return the greatest magnitude over the machine at every time, by key result, of quantities the run has.

    Each array is (time,), in the unit of key results, which its attribute `units` names.
    """
    greatest = {}
    for name, values in history.over_time(name for name in names if history.has(name)).items():
        unit = catalogue.QUANTITIES[name].unit
        drawn, factor = catalogue.OF_GROUND.get(name, KEY_UNITS.get(unit, (unit, 1.0)))
        for label, some in _apart(history.case, name, values):
            size = abs(_size(some))
            over_machine = size.max([dimension for dimension in size.dims if dimension != "time"])
            greatest[label] = (factor * over_machine).assign_attrs(units=drawn)
    return greatest


def _held(stress: xr.Dataset, usable: float, factor: float, unit: str) -> Iterator[ResultRow]:
    """Yield the row of the highest stress in rigid spiders if it exceeds the `usable` one, Pa."""
    peaks = stress.peak_von_mises.where(stress.in_spider)
    if not float(peaks.max()) > usable:
        return
    place = {dim: int(index) for dim, index in peaks.argmax(...).items()}
    shoe = int(peaks.shoe[place["shoe"]])
    time = float(stress.peak_time.isel(place))
    yield HELD, float(peaks.isel(place)) * factor, unit, f"shoe {shoe}", time


def _apart(case: Case, name: str, values: xr.DataArray) -> Iterator[tuple[str, xr.DataArray]]:
    """Yield names and values of a quantity's key results; rollers, idler and carriers have separate ones."""
    result = catalogue.QUANTITIES[name].key_result
    if "wheel" not in values.dims:
        yield result, values
        return
    for kind, words in WHEELS.items():
        some = [label.words for label in case.gear.wheel_labels if label.kind == kind]
        if some:
            yield result.replace("a wheel", words), values.sel(wheel=some)


class _Driven:
    """Time that drives with a torque limit spend at this limit."""

    def __init__(self) -> None:
        self._since: dict[str, float] = {}
        self._seconds: dict[str, float] = {}

    def add(self, part: History) -> None:
        """Add a part of a run."""
        if not part.case.gear.loops or (limit := part.case.part(Closed).torque_limit) is None:
            return
        time = part.time.values
        moment = part.drive_moment.transpose("time", ...).values.reshape(len(time), -1)
        for name, torque in zip(part.case.gear.tumblers, np.abs(moment).T, strict=True):
            at_limit = torque >= AT_LIMIT * limit
            if at_limit.any():
                self._since.setdefault(name, float(time[at_limit.argmax()]))
                self._seconds[name] = self._seconds.get(name, 0.0) + float(np.trapezoid(at_limit, time))

    def rows(self) -> list[ResultRow]:
        """Return rows of the key results; none if no drive reached its limit."""
        return [
            (_of_side("time at the torque limit of the drive", name), seconds, "s", name, self._since[name])
            for name, seconds in self._seconds.items()
        ]


def _hanging(history: History) -> list[ResultRow]:
    """Return rows of pretension and sag of closed chains at the start of the run."""
    if not history.case.gear.loops:
        return []
    start = history.dataset.isel(time=0)
    time = float(start.time)
    rows = []
    for chain in tension.hanging_chains(history.case, start):
        of = f"{chain.side} idler".strip()
        pull = 1e-3 * chain.pretension
        rows.append((_of_side("pretension at the start", chain.side), pull, "kN", of, time))
        sag = 1e3 * chain.sag
        rows.append((_of_side("sag at the start", chain.side), sag, "mm", f"{of} to {chain.carrier}", time))
    return rows


def _of_side(result: str, name: str) -> str:
    """Return the name of a result with the side at the begin of `name`, so that names of rows differ."""
    side = name.partition(" ")[0].partition("_")[0]
    return f"{result}, {side}" if side in SIDES else result


def unbalanced(history: History) -> tuple[str, float]:
    """Return the shoe or side frame with the greatest residual force at the start of a run, and the force, N.

    The residual force is mass times acceleration.
    """
    case = history.case
    start = history.dataset.isel(time=0)
    shoes = case.shoe.mass * _size(start.acceleration).values
    forces = {f"shoe {shoe}": float(force) for shoe, force in zip(history.shoe.values, shoes, strict=True)}
    if case.gear.frame_parts:
        mass = sum(part.mass for part in case.gear.frame_parts)
        forces["side frame"] = mass * float(_size(start.side_frame_acceleration))
    return max(forces.items(), key=lambda item: item[1])


def _size(values: xr.DataArray) -> xr.DataArray:
    """Return the length of vectors, the magnitude of forces, and other values as they are."""
    if "axis" in values.dims:
        return ((values**2).sum("axis")) ** 0.5
    return abs(values) if values.attrs.get("units") == "N" else values


def _extreme(values: xr.DataArray, which: Literal["greatest", "largest"] = "greatest") -> Extreme:
    """Return the greatest value of a series, or that of largest magnitude."""
    ranked = abs(values) if which == "largest" else values
    indices = {str(dim): int(index) for dim, index in ranked.argmax(...).items()}
    of = ", ".join(_item(values, dim, index) for dim, index in indices.items() if dim != "time")
    return Extreme(float(values.isel(indices)), of, float(values.time[indices["time"]]))


def _item(values: xr.DataArray, dim: str, index: int) -> str:
    """Return the name of an item of a dimension; a contact's name has its shoe, and its unit if any."""
    if dim == "contact":
        unit = int(values.contact_unit[index])
        return f"shoe {int(values.contact_shoe[index])}" + (f" on unit {unit}" if unit else "")
    number = values[dim].values[index]
    if dim == "joint":
        return catalogue.link_name(values.joint, int(number))
    return f"{dim.split('_')[-1]} {number}"


def extremes(history: History) -> pd.DataFrame:
    """Return the least and greatest value of every numeric variable by axis, with its item and time (s)."""
    series: dict[tuple[str, str, str], tuple[_Bound, _Bound]] = {}
    first = 0
    # a variable of a long run may be larger than memory
    for part in blocks(history.dataset):
        for name, values in part.data_vars.items():
            if "time" not in values.dims or not np.issubdtype(values.dtype, np.number):
                continue
            for axis, numbers in _numbers_by_axis(values):
                key = (str(name), axis, values.attrs.get("units", ""))
                for bound in series.setdefault(key, (_Bound(np.fmin), _Bound(np.fmax))):
                    bound.add(numbers, first)
        first += part.sizes["time"]
    rows = []
    for key, (least, greatest) in series.items():
        if least.place:
            values = history.dataset[key[0]]
            rows.append((*key, *least.of(values), *greatest.of(values)))
    columns = [f"{which}{of}" for which in ("least", "greatest") for of in ("", "_of", "_at in s")]
    return pd.DataFrame(rows, columns=["variable", "axis", "unit", *columns])


class _Bound:
    """Least or greatest number of a series that comes in parts along time, the first of equal ones.

    `choose` is `numpy.fmin` or `numpy.fmax`, which ignore NaN.
    """

    def __init__(self, choose: np.ufunc) -> None:
        self._choose = choose
        self._value = np.nan
        self.place: tuple[int, ...] = ()  # row in time, then index along each other dimension

    def add(self, numbers: np.ndarray, first: int) -> None:
        """Add the next part (times, ...); `first` is the row of its first time in the whole series."""
        if not numbers.size:
            return
        value = float(self._choose.reduce(self._choose.reduce(numbers, axis=0), axis=None))
        if np.isnan(value) or self._choose(self._value, value) == self._value:
            return
        row, *others = np.unravel_index(int((numbers == value).argmax()), numbers.shape)
        self._value = value
        self.place = (first + int(row), *map(int, others))

    def of(self, values: xr.DataArray) -> Extreme:
        """Return the extreme, with item and time, from the whole `values`."""
        dims = [str(dim) for dim in values.dims if dim not in ("time", "axis")]
        items = (_item(values, dim, index) for dim, index in zip(dims, self.place[1:], strict=True))
        return Extreme(self._value, ", ".join(items), float(values.time[self.place[0]]))


def _numbers_by_axis(values: xr.DataArray) -> list[tuple[str, np.ndarray]]:
    """Return components (times, ...) of a vector with the names of their axes; a scalar has an empty name."""
    if "axis" not in values.dims:
        return [("", values.transpose("time", ...).values)]
    numbers = values.transpose("time", ..., "axis").values
    return [(str(axis), numbers[..., column]) for column, axis in enumerate(values.axis.values)]


def _by_axis(values: xr.DataArray) -> list[tuple[str, xr.DataArray]]:
    """Return the components of a vector with the names of their axes; a scalar has an empty name."""
    if "axis" not in values.dims:
        return [("", values)]
    return [(str(axis), values.sel(axis=axis)) for axis in values.axis.values]


def load_table(history: History) -> pd.DataFrame:
    """Return the loads on the shoes and their sum, N, at the begin and each end of a phase, a column each."""
    loads = history.case.loads
    columns: dict[str, object] = {"shoe": [*map(str, range(1, loads.shoe_count + 1)), "sum"]}
    instants = [("begin", 0.0)] + [(phase.name, phase.end) for phase in phases(loads, history.duration)]
    for name, time in instants:
        by_shoe = loads.loads(time)[0]
        columns[f"{name} ({time:.6g} s) in N"] = [*by_shoe, by_shoe.sum()]
    return pd.DataFrame(columns)


def tension_along_chain(history: History) -> xr.Dataset:
    """Return the tension of a closed chain by link, and by fixed point of the loop.

    Point k of the loop is the position of the front pin of shoe k at t = 0. A link counts for the nearest
    point by the rotation of the tumbler. `least`, `mean` and `greatest` (N) have the dimension joint;
    `least_at`, `mean_at` and `greatest_at` are those of the points, with the dimension place. Points also
    have x and z in the side frame (m), and `part`, the part of the loop.
    """
    case = history.case
    closed = case.part(Closed)
    data = history.dataset
    track = case.track
    tension = history.over_time(["link_tension"])["link_tension"].transpose("time", "joint").values
    count = tension.shape[1]
    turned = data.tumbler_angle.values * closed.tumbler.shoes_per_turn / (2.0 * np.pi)
    place = np.rint(np.arange(count) - turned[:, None]).astype(int) % count
    tension_at = [tension[place == number] for number in range(count)]
    start = data.isel(time=0)
    rise = (0.0 if case.shoe.rails is None else case.shoe.rails.height) - track.pin_height
    x, _, z = pins_in_frame(case, start).T
    on_tumbler, on_idler = (
        np.hypot(x - at[0], z - at[1]) < radius + 0.1 * track.pitch
        for at, radius in (
            (closed.tumbler.place, closed.tumbler.radius(track.pitch)),
            closed.idler_circle(float(start.take_up), rise, closed.chain_pitch(track)),
        )
    )
    part = np.where(z > closed.tumbler.place[1], "upper run", "lower run")
    part = np.where(on_tumbler, "tumbler", np.where(on_idler, "idler", part))
    how: dict[str, Any] = {"least": np.min, "mean": np.mean, "greatest": np.max}
    unit = {"units": "N"}
    named = {name: ("joint", of(tension, axis=0), unit) for name, of in how.items()}
    named |= {
        f"{name}_at": (
            "place",
            np.array([of(values) if values.size else np.nan for values in tension_at]),
            unit,
        )
        for name, of in how.items()
    }
    at = {"x": ("place", x, {"units": "m"}), "z": ("place", z, {"units": "m"}), "part": ("place", part)}
    return xr.Dataset(named | at, {"joint": data.joint, "place": np.arange(1, count + 1)})


COLUMNS = ["quantity", "axis", "unit", "greatest in A", "greatest in B", "change in %"]
COLUMNS += ["rms difference", "greatest difference", "of", "at in s"]
STILL = 1e-7
"""Least component that counts, fraction of the greatest on all axes: the solver's residual (0.2 N) over the
forces."""
ROUNDING = 1e-12
"""Greatest difference by rounding, fraction of a quantity's greatest value over all its axes."""


def compared(history: History, stress: xr.Dataset | None = None) -> dict[str, xr.DataArray]:
    """Return a run's quantities to compare with another run's; contacts by shoe, units for reading."""
    named = [name for name in catalogue.select(compared=True) if history.has(name, stress)]
    return {name: catalogue.for_reading(values) for name, values in history.over_time(named, stress).items()}


def difference_table(first: Mapping[str, xr.DataArray], second: Mapping[str, xr.DataArray]) -> pd.DataFrame:
    """Return the differences of two runs' quantities, A and B of `compared`, by axis; see `COLUMNS`.

    The table compares the shoes, links and units of both runs over their common time. B is interpolated
    linearly at the stored times of A. A row stands only for differences beyond rounding. It has the greatest
    magnitude of each run and its change. Then follow root mean square and greatest magnitude of B less A,
    with item and time. A change of more than tenfold is left out, since both values show it.
    """
    rows = []
    for name in [name for name in first if name in second]:
        time = first[name].time.values
        end = float(second[name].time[-1])
        time = time[time <= end * (1.0 + 1e-9)]
        a, b = xr.align(first[name], second[name], join="inner", exclude=["time"])
        a, b = a.sel(time=time), b.interp(time=np.minimum(time, end)).assign_coords(time=time)
        greatest = float(abs(a).max()) if a.size else 0.0
        for (axis, series), (_, other) in zip(_by_axis(a), _by_axis(b), strict=True):
            still = axis and all(bool((abs(values) <= STILL * greatest).all()) for values in (series, other))
            difference = other - series
            if still or not (abs(difference) > ROUNDING * max(greatest, ROUNDING)).any():
                continue
            size = float(abs(series).max())
            now = float(abs(other).max())
            change = 100.0 * (now - size) / size if size > 0.0 else np.nan
            change = change if abs(change) <= MOST_CHANGE else np.nan
            rms = float(np.sqrt((difference**2).mean()))
            extreme = _extreme(difference.fillna(0.0), "largest")
            rows.append((str(name), axis, series.attrs.get("units", ""), size, now, change, rms, *extreme))
    return pd.DataFrame(rows, columns=COLUMNS)
