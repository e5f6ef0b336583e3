"""Load cases in groups and the factors of the groups, from the program's or the user's data file."""

from importlib.resources import as_file, files
from pathlib import Path
from typing import Literal

from exudyn_crawler.settings.parameters import Errors, Name, Parameters, Several, option, quantity
from exudyn_crawler.settings.reading import read_parameters

Support = Literal["even", "two", "outer", "one", "corner"]
DriveState = Literal["none", "straight", "turn", "stall", "blocked"]


class LoadGroup(Parameters):
    """Group of load cases with its factors."""

    name: Name = option("name of the group")
    title: Name = option("title of the group in tables")
    strength: float = quantity("1", "load factor against the yield strength", (1.0, 2.0), gt=0, le=10)
    tipping: float = quantity(
        "1", "least ratio of stabilising to overturning moment", (1.0, 2.0), ge=1, le=10
    )
    mark: Literal["S", "R", "D", "given"] = option(
        "source of the factors: S seen in the standard, R remembered, D derived, given by the user", "given"
    )


class LoadCase(Parameters):
    """State of a machine with loads to compute."""

    name: Name = option("name of the load case")
    group: Name = option("name of the group of the load case")
    payload: bool = option("payload at its reach", False)
    digging: bool = option("force of the bank on the dipper", False)
    grade: bool = option("permitted grade, uphill", False)
    slope: bool = option("permitted side slope, downhill towards each edge in turn", False)
    wind: bool = option("greatest wind, towards each edge in turn", False)
    drive: DriveState = option("state of the drive of both tracks", "none")
    support: Support = option("rollers that carry the machine", "even")
    slew: Literal["all", "in line"] = option(
        "slewing angles of the upper structure: all, or ahead and astern", "all"
    )


class LoadCases(Parameters):
    """Groups with their factors, and load cases."""

    name: Name = option("name of the standard or of the set")
    source: str = option("source of groups and factors", "given by the user", max_length=1000)
    groups: Several[LoadGroup] = option("groups of load cases with their factors")
    cases: Several[LoadCase] = option("load cases in the order of the tables")

    def _errors(self) -> Errors:
        known = [group.name for group in self.groups]
        for number, case in enumerate(self.cases):
            if case.group not in known:
                yield f"cases[{number}].group must be one of {', '.join(known)}, got {case.group!r}"
        names = [case.name for case in self.cases]
        if double := sorted({name for name in names if names.count(name) > 1}):
            yield f"cases: names must differ, got {', '.join(double)} twice"

    def group_of(self, case: LoadCase) -> LoadGroup:
        """Return the group of a load case."""
        return next(group for group in self.groups if group.name == case.group)


def read_load_cases(path: str | Path | None = None) -> LoadCases:
    """Return the load cases of a file (TOML), or the program's own; errors are those of `read_parameters`."""
    if path is not None:
        return read_parameters(path, LoadCases, "file of load cases", lambda content: content)
    with as_file(files("exudyn_crawler.assessment").joinpath("load_cases.toml")) as packaged:
        return read_parameters(packaged, LoadCases, "file of load cases", lambda content: content)
