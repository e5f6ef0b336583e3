"""Machine and dipper loads on the shoes over time."""

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.parameters import drive, measured_loads
from exudyn_crawler.case.parameters.base import Load
from exudyn_crawler.settings import fields, reading, units
from exudyn_crawler.settings.parameters import Errors, Name, Parameters, Several, option, quantity

if TYPE_CHECKING:
    import pandas as pd


EQUAL_LOADS = "a load in N for all shoes, such as '386.4 kN'"


class PhaseEnd(Parameters):
    """Part of a cycle, which says what acts at its end."""

    name: Name = option("name of the phase")
    end: float = quantity("s", "time at which the phase ends", ge=0, le=1e9)


def values_of(profiles: Iterable[drive.StepProfile], time: np.typing.ArrayLike) -> np.ndarray:
    """Values of profiles at each time: array (times, profiles)."""
    t = np.atleast_1d(np.asarray(time, dtype=float))
    return np.column_stack([profile.value(t) for profile in profiles])


class Cycle(Parameters):
    """Phases whose ends are joined by cubic STEPs."""

    phases: Several[Any]

    def _errors(self) -> Errors:
        ends = [phase.end for phase in self.phases]
        if np.any(np.diff(ends) <= 0.0):
            yield f"the phases' ends must increase, got {fields.shown(ends)}"

    def profiles(self, rows: Iterable[Iterable[float]]) -> list[drive.StepProfile]:
        """Quantities over time of their values at the ends of the phases, a row each."""
        ends = tuple(phase.end for phase in self.phases)
        return [drive.StepProfile(times=ends, values=values) for values in zip(*rows, strict=True)]


class Phase(PhaseEnd):
    """Part of a load cycle: the load on every shoe at its end, and where across the shoes it acts."""

    loads: tuple[Load, ...] = quantity(
        "N", "downward load on shoes 1..n at the phase's end", in_place=EQUAL_LOADS, min_length=1
    )
    side_shift: float = quantity("m", "how far left (+y) loads act", (-1.0, 1.0), ge=-10, le=10, default=0.0)


class LoadCycle(Cycle):
    """Downward loads on the shoes in phases whose ends cubic STEPs join, constant before and after them."""

    phases: Several[Phase]
    in_place: ClassVar[str] = EQUAL_LOADS

    def _errors(self) -> Errors:
        yield from super()._errors()
        counts = {phase.name: len(phase.loads) for phase in self.phases}
        if len(counts) != len(self.phases):
            yield f"the phases' names must differ, got {fields.shown([phase.name for phase in self.phases])}"
        if len(set(counts.values())) != 1:
            yield f"every phase needs a load for every shoe, got counts {fields.shown(counts)}"

    @classmethod
    def constant(cls, loads: float | Sequence[float], shoe_count: int = ph4100c.SHOE_COUNT) -> Self:
        """Same loads (N, shoes 1..n) at all times; one number is the load on each of `shoe_count` shoes."""
        every = [loads] * shoe_count if isinstance(loads, int | float) else loads
        return cls(phases=(Phase(name="constant", end=0.0, loads=tuple(every)),))

    @classmethod
    def propel(cls, shoe_count: int = ph4100c.SHOE_COUNT) -> Self:
        """Machine weight spread evenly (F-paper): 386.4 kN on each shoe."""
        return cls.constant(ph4100c.PROPEL_LOAD, shoe_count)

    @classmethod
    def shovel_cycle(cls) -> Self:
        """Propel, dig, hoist and swing, dump and return of the P&H 4100C (S-paper).

        Only the loads on shoe 7 are printed. The others follow from what is stated of them, with every
        sum kept (machine 13 x 386.4 kN, dipper 445 kN). Dig: the dipper on shoes 7 to 13, rising evenly; the
        machine's load grows with the square of the distance from shoe 7, where it is what the printed 384 kN
        leave it. Swing: both symmetric about shoe 7 and falling evenly from there, the machine's from 541 kN,
        the dipper's from the rest of the printed 732 kN until nothing is left. Dump: the machine's share of
        the swing alone. Return: even again.
        """
        count = ph4100c.SHOE_COUNT
        middle = ph4100c.MIDDLE_SHOE
        from_middle = np.abs(np.arange(1, count + 1) - middle)
        machine = count * ph4100c.PROPEL_LOAD

        dipper = np.clip(np.arange(1, count + 1) - (middle - 1), 0, None)
        dipper = ph4100c.DIPPER_LOAD * dipper / dipper.sum()
        least = ph4100c.DIG_LOAD - dipper[middle - 1]
        bowl = (machine - count * least) / np.sum(from_middle**2)
        dig = least + bowl * from_middle**2 + dipper

        slope = (count * ph4100c.DUMP_LOAD - machine) / from_middle.sum()
        dump = ph4100c.DUMP_LOAD - slope * from_middle
        swing = dump + _falling(ph4100c.SWING_LOAD - ph4100c.DUMP_LOAD, ph4100c.DIPPER_LOAD, from_middle)

        even = np.full(count, ph4100c.PROPEL_LOAD)
        ends = {
            "propel": (ph4100c.PROPEL_END, even),
            "dig": (ph4100c.DIG_END, dig),
            "hoist and swing": (ph4100c.SWING_END, swing),
            "dump": (ph4100c.DUMP_END, dump),
            "return": (ph4100c.RETURN_END, even),
        }
        phases = [
            Phase(name=name, end=end, loads=tuple(loads.tolist())) for name, (end, loads) in ends.items()
        ]
        return cls(phases=tuple(phases))

    @classmethod
    def from_toml(cls, path: str | Path, shoe_count: int = ph4100c.SHOE_COUNT) -> Self:
        """Read a cycle from a TOML file, a list of tables ``[[phases]]`` with name, end and loads.

        A phase with one number for all loads `shoe_count` shoes. A FileNotFoundError if there is no such
        file, a CaseFileError that names what is wrong if it is not TOML or not a load cycle.
        """
        values = partial(with_equal_loads, shoe_count=shoe_count)
        return reading.read_parameters(path, cls, "load cycle", values)

    @classmethod
    def from_csv(cls, path: str | Path, shoe_count: int = ph4100c.SHOE_COUNT) -> Self:
        """Read measured loads, a time and loads a row with units in the heads, as phases that end there.

        A column "load [kN]" is the load on each of `shoe_count` shoes, "sum [kN]" that on all of them.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        CaseFileError
            If it holds no loads over time.
        """
        rows = measured_loads.read_loads(Path(path), shoe_count)
        with reading.errors_named(Path(path), cls):
            content = [
                {
                    "name": f"{row.time:.10g} s",
                    "end": row.time,
                    "loads": row.loads,
                    "side_shift": row.side_shift,
                }
                for row in rows
            ]
            return reading.from_content(cls, {"phases": content})

    @classmethod
    def from_file(cls, path: str | Path, shoe_count: int = ph4100c.SHOE_COUNT) -> Self:
        """Read a cycle from a file, CSV by its ending or TOML; see `from_csv` and `from_toml`."""
        read = cls.from_csv if Path(path).suffix.lower() == ".csv" else cls.from_toml
        return read(path, shoe_count)

    def table(self) -> "pd.DataFrame":
        """Loads at the end of every phase in kN: a row a shoe, a column a phase, and their sums."""
        # a third of the time that a case takes to be shown
        import pandas as pd

        columns = {
            f"{phase.name} ({phase.end:g} s)": [*phase.loads, sum(phase.loads)] for phase in self.phases
        }
        shoes = [*map(str, range(1, self.shoe_count + 1)), "sum"]
        return pd.DataFrame({"shoe": shoes, **{n: np.array(v) / 1e3 for n, v in columns.items()}})

    @property
    def shoe_count(self) -> int:
        """Number of shoes that the cycle loads."""
        return len(self.phases[0].loads)

    @property
    def of_shoes(self) -> list[drive.StepProfile]:
        """Load on every shoe over time, N."""
        return self.profiles(phase.loads for phase in self.phases)

    @property
    def side_shift(self) -> drive.StepProfile:
        """How far beside the load points the loads act over time, m, positive to the left."""
        return self.profiles([phase.side_shift] for phase in self.phases)[0]

    def loads(self, time: np.typing.ArrayLike) -> np.ndarray:
        """Loads at each time: array (times, shoes), N downward."""
        return values_of(self.of_shoes, time)


def with_equal_loads(content: Any, shoe_count: int) -> Any:
    """Content of a load cycle in which one number for all shoes, or in its place, stands for each of them."""

    def spread(phase: Any) -> Any:
        load = units.number_of(phase.get("loads"), "N") if isinstance(phase, dict) else None
        return phase | {"loads": [load] * shoe_count} if fields.is_number(load) else phase

    if fields.is_number(load := units.number_of(content, "N")):
        content = {"phases": [{"name": "constant", "end": 0.0, "loads": load}]}
    match content:
        case {"phases": [*phases]}:
            return content | {"phases": [spread(phase) for phase in phases]}
    return content


def follow_shoes(content: Any, shoe_count: int) -> Any:
    """Load cycle, or its content, that loads no shoe: for another number of shoes; any other as it is."""
    whole = content.model_dump() if isinstance(content, LoadCycle) else content
    match whole:
        case {"phases": [*phases]} if all(_is_of_nothing(phase) for phase in phases):
            spread = [phase | {"loads": [0.0] * shoe_count} for phase in phases]
            if isinstance(content, LoadCycle):
                return LoadCycle.model_validate({"phases": spread})
            return whole | {"phases": spread}
    return content


def _is_of_nothing(phase: Any) -> bool:
    """True for a phase whose loads are all zero."""
    values = phase.get("loads") if isinstance(phase, dict) else None
    return isinstance(values, list | tuple) and all(
        fields.is_number(value) and value == 0 for value in values
    )


def _falling(greatest: float, total: float, distance: np.ndarray) -> np.ndarray:
    """Loads that fall evenly with the distance from `greatest` to nothing, with a given sum."""
    reach = np.cumsum(np.sort(distance))
    count = np.arange(1, len(reach) + 1)
    # with the n nearest ones alone loaded the sum is a line in the slope; the highest of these lines holds
    slope = np.max((count * greatest - total)[reach > 0.0] / reach[reach > 0.0])
    return np.clip(greatest - slope * distance, 0.0, None)
