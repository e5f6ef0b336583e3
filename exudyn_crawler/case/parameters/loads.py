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
    """Return the values of profiles at each time: array (times, profiles)."""
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
        """Return the profiles over time; each row has their values at the end of a phase."""
        ends = tuple(phase.end for phase in self.phases)
        return [drive.StepProfile(times=ends, values=values) for values in zip(*rows, strict=True)]


class Phase(PhaseEnd):
    """Part of a load cycle: the load on every shoe at its end, and where across the shoes it acts."""

    loads: tuple[Load, ...] = quantity(
        "N", "downward loads on shoes 1 to n at the phase's end", in_place=EQUAL_LOADS, min_length=1
    )
    side_shift: float = quantity(
        "m", "lateral shift of the loads, positive to the left (+y)", (-1.0, 1.0), ge=-10, le=10, default=0.0
    )


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
        """Return constant loads (N, shoes 1..n); one number is the load on each of `shoe_count` shoes."""
        every = [loads] * shoe_count if isinstance(loads, int | float) else loads
        return cls(phases=(Phase(name="constant", end=0.0, loads=tuple(every)),))

    @classmethod
    def propel(cls, shoe_count: int = ph4100c.SHOE_COUNT) -> Self:
        """Return the machine's weight spread evenly (F-paper): 386.4 kN on each shoe."""
        return cls.constant(ph4100c.PROPEL_LOAD, shoe_count)

    @classmethod
    def shovel_cycle(cls) -> Self:
        """Return propel, dig, hoist and swing, dump and return of the P&H 4100C (S-paper).

        The paper prints only the loads on shoe 7. The others follow from its statements and from both sums:
        machine 13 x 386.4 kN, dipper 445 kN.

        - Dig: the dipper's load rises linearly over shoes 7 to 13. The machine's load grows with the square
          of the distance from shoe 7; on shoe 7 it is the rest of the printed 384 kN.
        - Swing: both loads are symmetric about shoe 7 and fall linearly with the distance. The machine's load
          falls from 541 kN, the dipper's from the rest of the printed 732 kN down to zero.
        - Dump: the machine's load of the swing. Return: even loads.
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

        In a phase, a single number is the load on each of `shoe_count` shoes. Raises `FileNotFoundError` if
        there is no such file, and `CaseFileError`, with the fault, if it is not TOML or not a load cycle.
        """
        values = partial(with_equal_loads, shoe_count=shoe_count)
        return reading.read_parameters(path, cls, "load cycle", values)

    @classmethod
    def from_csv(cls, path: str | Path, shoe_count: int = ph4100c.SHOE_COUNT) -> Self:
        """Read measured loads, with a time in each row and units in the heads; each row ends a phase.

        A column "load [kN]" is the load on each of `shoe_count` shoes, "sum [kN]" the load on all of them.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        CaseFileError
            If the file has no loads over time.
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
        """Return the loads at the end of every phase, kN: a row a shoe, a column a phase, and their sums."""
        # a slow import that only this table needs
        import pandas as pd

        columns = {
            f"{phase.name} ({phase.end:g} s)": [*phase.loads, sum(phase.loads)] for phase in self.phases
        }
        shoes = [*map(str, range(1, self.shoe_count + 1)), "sum"]
        return pd.DataFrame({"shoe": shoes, **{n: np.array(v) / 1e3 for n, v in columns.items()}})

    @property
    def shoe_count(self) -> int:
        """Number of shoes of the cycle."""
        return len(self.phases[0].loads)

    @property
    def of_shoes(self) -> list[drive.StepProfile]:
        """Load on every shoe over time, N."""
        return self.profiles(phase.loads for phase in self.phases)

    @property
    def side_shift(self) -> drive.StepProfile:
        """Lateral offset of the loads from the load points over time, m, positive to the left."""
        return self.profiles([phase.side_shift] for phase in self.phases)[0]

    def loads(self, time: np.typing.ArrayLike) -> np.ndarray:
        """Return the loads at each time: array (times, shoes), N downward."""
        return values_of(self.of_shoes, time)


def with_equal_loads(content: Any, shoe_count: int) -> Any:
    """Return the content of a load cycle with a single number, for a phase or for all, repeated per shoe."""

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
    """Return a load cycle, or its content, adapted to a number of shoes if all its loads are zero.

    Any other cycle or content is returned unchanged.
    """
    whole = content.model_dump() if isinstance(content, LoadCycle) else content
    match whole:
        case {"phases": [*phases]} if all(_is_of_nothing(phase) for phase in phases):
            spread = [phase | {"loads": [0.0] * shoe_count} for phase in phases]
            if isinstance(content, LoadCycle):
                return LoadCycle.model_validate({"phases": spread})
            return whole | {"phases": spread}
    return content


def _is_of_nothing(phase: Any) -> bool:
    """Return whether all loads of a phase are zero."""
    values = phase.get("loads") if isinstance(phase, dict) else None
    return isinstance(values, list | tuple) and all(
        fields.is_number(value) and value == 0 for value in values
    )


def _falling(greatest: float, total: float, distance: np.ndarray) -> np.ndarray:
    """Return loads with a given sum that fall linearly with the distance from `greatest` to zero."""
    reach = np.cumsum(np.sort(distance))
    count = np.arange(1, len(reach) + 1)
    # with only the n nearest shoes loaded, the sum is linear in the slope; the largest slope of all n holds
    slope = np.max((count * greatest - total)[reach > 0.0] / reach[reach > 0.0])
    return np.clip(greatest - slope * distance, 0.0, None)
