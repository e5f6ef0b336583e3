"""Machine and dipper loads on the shoes over time."""

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Self

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator
from scipy.optimize import brentq

from exudyn_crawler.case.base import Parameters, quantity
from exudyn_crawler.case.profile import StepProfile

SHOVEL_SHOES = 13
MIDDLE_SHOE = 7
PROPEL_LOAD = 386.4e3
"""N on every shoe during propel (F-paper): the weight of the machine less the shoes, evenly spread."""
DIPPER_LOAD = 445e3
"""N of dipper load per track (S-paper)."""
DIG_LOAD, SWING_LOAD, DUMP_LOAD = 384e3, 732e3, 541e3
"""N on shoe 7 at the ends of dig, swing and dump (S-paper)."""


class Phase(Parameters):
    """Part of a load cycle: the load on every shoe at its end."""

    name: Annotated[str, Field(min_length=1, description="name of the phase")]
    end: float = quantity("s", "time at which the phase ends", ge=0)
    loads: tuple[float, ...] = quantity(
        "N", "downward load on shoes 1..n at the end of the phase", min_length=1
    )


class LoadCycle(Parameters):
    """Downward loads on the shoes, in phases whose ends are joined by cubic STEPs, and the drive's times.

    Before the end of the first phase the loads are constant at its values, after the last one at the last.
    """

    phases: Annotated[tuple[Phase, ...], Field(min_length=1)]
    drive_on: tuple[tuple[float, float], ...] | None = quantity(
        "s",
        "times from and to which the drive moves the front shoe, free otherwise; None: always",
        default=None,
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        ends = [phase.end for phase in self.phases]
        if np.any(np.diff(ends) <= 0.0):
            raise ValueError(f"the phases' ends must increase, got {ends}")
        counts = {phase.name: len(phase.loads) for phase in self.phases}
        if len(counts) != len(self.phases):
            raise ValueError(f"the phases' names must differ, got {[p.name for p in self.phases]}")
        if len(set(counts.values())) != 1:
            raise ValueError(f"every phase needs a load for every shoe, got counts {counts}")
        if self.drive_on is not None:
            times = [time for window in self.drive_on for time in window]
            if times and (times[0] < 0.0 or np.any(np.diff(times) <= 0.0)):
                raise ValueError(f"drive_on must be times from 0 s that increase, got {self.drive_on}")
        return self

    @property
    def switch_times(self) -> tuple[float, ...]:
        """Times after 0 at which the drive goes on or off, s."""
        return tuple(time for window in self.drive_on or () for time in window if time > 0.0)

    def off_since(self, time: float) -> float:
        """How long the drive has been off just after a time, s; zero while it is on."""
        if self.drives_after(time):
            return 0.0
        return time - max((end for _, end in self.drive_on or () if end <= time * (1.0 + 1e-9)), default=0.0)

    def drives_after(self, time: float) -> bool:
        """Whether the drive is on just after a time (s)."""
        if self.drive_on is None:
            return True
        return any(start <= time * (1.0 + 1e-9) < end for start, end in self.drive_on)

    @classmethod
    def constant(cls, loads: Sequence[float]) -> Self:
        """Same loads (N, shoes 1..n) at all times."""
        return cls(phases=(Phase(name="constant", end=0.0, loads=tuple(loads)),))

    @classmethod
    def propel(cls, shoe_count: int = 13) -> Self:
        """Machine weight spread evenly (F-paper): 386.4 kN on each shoe."""
        return cls.constant([386.4e3] * shoe_count)

    @classmethod
    def shovel_cycle(cls) -> Self:
        """Propel, dig, hoist and swing, dump and return of the P&H 4100C (S-paper).

        Only the loads on shoe 7 are printed. The others follow from what is stated of them, with every
        sum kept (machine 13 x 386.4 kN, dipper 445 kN):

        - dig: the dipper on shoes 7 to 13, rising evenly from shoe to shoe; the machine's load grows with
          the square of the distance from shoe 7, where it is what the printed 384 kN leave it;
        - swing: both symmetric about shoe 7 and falling evenly from there, the machine's from 541 kN, the
          dipper's from the rest of the printed 732 kN until nothing is left;
        - dump: the machine's share of the swing alone;
        - return: even again.
        """
        from_middle = np.abs(np.arange(1, SHOVEL_SHOES + 1) - MIDDLE_SHOE)
        machine = SHOVEL_SHOES * PROPEL_LOAD

        dipper = np.clip(np.arange(1, SHOVEL_SHOES + 1) - (MIDDLE_SHOE - 1), 0, None)
        dipper = DIPPER_LOAD * dipper / dipper.sum()
        least = DIG_LOAD - dipper[MIDDLE_SHOE - 1]
        bowl = (machine - SHOVEL_SHOES * least) / np.sum(from_middle**2)
        dig = least + bowl * from_middle**2 + dipper

        slope = (SHOVEL_SHOES * DUMP_LOAD - machine) / from_middle.sum()
        dump = DUMP_LOAD - slope * from_middle
        swing = dump + _falling(SWING_LOAD - DUMP_LOAD, DIPPER_LOAD, from_middle)

        even = np.full(SHOVEL_SHOES, PROPEL_LOAD)
        ends = {
            "propel": (15.0, even),
            "dig": (22.5, dig),
            "hoist and swing": (30.0, swing),
            "dump": (33.5, dump),
            "return": (40.0, even),
        }
        return cls(
            phases=tuple(
                Phase(name=name, end=end, loads=tuple(loads.tolist())) for name, (end, loads) in ends.items()
            ),
            drive_on=((0.0, 15.0),),
        )

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Read a cycle from a TOML file.

        It holds a list of tables ``[[phases]]`` with name, end and loads and, if the drive is not always on,
        ``drive_on`` as a list of pairs of times.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        ValueError
            If it is not TOML or not a load cycle, naming what is wrong.
        """
        path = Path(path)
        if not path.is_file():
            raise FileNotFoundError(f"no load cycle {path}")
        try:
            content = tomllib.loads(path.read_bytes().decode("utf-8-sig"))
        except (ValueError, RecursionError) as error:
            raise ValueError(f"{path} is not TOML: {error}") from error
        return cls.model_validate(content)

    def table(self) -> pd.DataFrame:
        """Loads at the end of every phase in kN: a row a shoe, a column a phase, and their sums."""
        columns = {
            f"{phase.name} ({phase.end:g} s)": [*phase.loads, sum(phase.loads)] for phase in self.phases
        }
        shoes = [*map(str, range(1, self.shoe_count + 1)), "sum"]
        return pd.DataFrame({"shoe": shoes, **{n: np.array(v) / 1e3 for n, v in columns.items()}})

    @property
    def shoe_count(self) -> int:
        """Number of shoes that the cycle loads."""
        return len(self.phases[0].loads)

    def profile(self, shoe: int) -> StepProfile:
        """Load on a shoe (1..n) over time, N."""
        if not 1 <= shoe <= self.shoe_count:
            raise ValueError(f"shoe must be in 1..{self.shoe_count}, got {shoe}")
        return StepProfile(
            times=tuple(phase.end for phase in self.phases),
            values=tuple(phase.loads[shoe - 1] for phase in self.phases),
        )

    def loads(self, time: ArrayLike) -> NDArray:
        """Loads at each time: array (times, shoes), N downward."""
        t = np.atleast_1d(np.asarray(time, dtype=float))
        return np.column_stack([self.profile(s).value(t) for s in range(1, self.shoe_count + 1)])


def _falling(greatest: float, total: float, distance: NDArray) -> NDArray:
    """Loads that fall evenly with the distance from `greatest` to nothing, with a given sum."""
    slope = brentq(lambda slope: np.clip(greatest - slope * distance, 0.0, None).sum() - total, 0.0, greatest)
    return np.clip(greatest - slope * distance, 0.0, None)
