"""Definition of a sweep: a case, its varied values, their design, and answers; reader of its file."""

import hashlib
import itertools
import json
import math
import os
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from functools import cache, cached_property
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, TypeVar

import pandas as pd
from scipy.stats import qmc

from exudyn_crawler.case.parameters import checks
from exudyn_crawler.machines import CaseFile, Outputs, case_of
from exudyn_crawler.machines.case_file import BARE
from exudyn_crawler.machines.datasheet import files as datasheets
from exudyn_crawler.settings import fields, reading, units
from exudyn_crawler.settings.parameters import Errors, Parameters, option, quantity
from exudyn_crawler.sweep.answers import ANSWERS, Answers, DamageOptions, Life, Often
from exudyn_crawler.sweep.vary import Varied, Vary, checked_case

Design = Literal["grid", "list", "latin_hypercube", "sobol", "saltelli"]
SAMPLED = ("latin_hypercube", "sobol", "saltelli")  # designs that draw points between bounds
Row = tuple[Any, ...]  # values of a run, one of every `Vary`
Made = TypeVar("Made")
MOST_RUNS = 1_000_000
SHOWN_WARNINGS = 6  # greatest number of warnings of implausible values
FOLDER_DIGITS = 16  # of a digest, in the name of a run's folder
OWN_COLUMNS = ("run", "folder", "status", "reason", "wall_time_s")
"""Columns of a sweep's table other than varied values and answers."""
ASSUMED = "assumed"  # key of a sweep's file: all assumed values of a datasheet's machine are drawn
TYPICAL = f"{datasheets.KEY}.typical"
"""Prefix of the paths of a datasheet's assumed values."""
MESH = "flexible.mesh"
MEASURED = ("low", "high", "values")  # keys of `Vary` in the unit of the case
LIVES = (*DamageOptions.model_fields, *Often.model_fields, "survival")
"""Parameters of an answer of life that may vary; all such answers share them."""


class PlannedRun(NamedTuple):
    """Run of a sweep; runs with the same case, duration, outputs, versions and drawn lives are one run."""

    number: int  # from 1
    values: Row
    digest: str  # SHA-256, names its folder
    answers: tuple[Answers, ...]
    obstacle: str = ""  # why the machine of drawn values cannot be built; such a run has no digest


class Fleet(Parameters):
    """Shoes whose machine hours a scatter counts."""

    shoes: int = quantity("1", "number of shoes of all machines", ge=1, le=10_000_000, default=78)
    hours_a_year: float = quantity(
        "h", "machine hours in a year", (100.0, 8784.0), gt=0, le=8784, default=6000.0
    )
    rebuild: float = quantity(
        "h", "machine hours after which all shoes are replaced", (100.0, 1e6), gt=0, le=1e9, default=25_000.0
    )


class Variation(Parameters):
    """Parameters that vary, and their design."""

    vary: tuple[Vary, ...] = option("varied values", min_length=1)
    design: Design = option("design: grid, list, latin_hypercube, sobol or saltelli", "grid")
    runs: int | None = option(
        "number of points drawn by latin_hypercube, sobol or saltelli", None, ge=1, le=MOST_RUNS
    )
    seed: int = option("seed of the random numbers", 1, ge=0, le=2**32 - 1)
    fleet: Fleet = option("fleet for the number of cracked shoes", Fleet())

    # members of each kind, beside its answers
    named: ClassVar[Any]
    planned: ClassVar[Any]
    _varied: ClassVar[Any]
    if TYPE_CHECKING:

        @property
        def answers(self) -> tuple[Answers, ...]: ...  # noqa: D102

    def _odd_fleet(self) -> list[str]:
        """Return lines about implausible values of the fleet."""
        return [f"fleet.{line}" for line in checks.out_of_range(self.fleet)]

    def _errors(self) -> Errors:
        names = [*OWN_COLUMNS, *self.columns, *(answer.label for answer in self.answers)]
        if twice := [name for name, count in Counter(names).items() if count > 1]:
            yield f"name must be given for columns with the same name: {', '.join(twice)}"
        paths = Counter(path for variable in self.vary for path in variable.keys)
        if again := [path for path, count in paths.items() if count > 1]:
            yield f"a path must be varied once, got {', '.join(again)} again"
        sizes = [
            len(variable.values) if variable.values is not None else variable.count or 1
            for variable in self.vary
        ]
        if self.design == "grid" and self.runs is None and (count := math.prod(sizes)) > MOST_RUNS:
            yield f"runs must be at most {MOST_RUNS}, got a grid of at least {count}"
        for variable in self.vary:
            variable.check(self._varied)
        self.rows  # noqa: B018 - numbers of runs that do not fit the design are refused here

    @property
    def is_sampled(self) -> bool:
        """True if the design draws points; then the answers scatter as the varied values do."""
        return self.design in SAMPLED

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the varied values."""
        return tuple(variable.label for variable in self.vary)

    @cached_property
    def rows(self) -> list[Row]:
        """Values of all runs."""
        return design_rows(self.design, self.vary, self.runs, self.seed)

    def units(self) -> dict[str, str]:
        """Return the units of the columns of varied values and answers, empty for those without a unit."""
        varied = {variable.label: variable.unit_in(self._varied) for variable in self.vary}
        return varied | {answer.label: answer.unit for answer in self.answers}

    def meanings(self) -> dict[str, str]:
        """Return the meanings of the columns of varied values and answers."""
        varied = {
            variable.label: ("factor of " if variable.factor else "") + ", ".join(variable.keys)
            for variable in self.vary
        }
        return varied | {answer.label: answer.meaning for answer in self.answers}

    @cached_property
    def _content(self) -> dict[str, Any]:
        return self._varied.model_dump(mode="json")

    def _changed(self, values: Row) -> Any:
        """Return a copy of the varied subject with the values of a run."""
        content = self._content
        for variable, value in zip(self.vary, values, strict=True):
            content = variable.applied(content, value)
        if self._content.get(datasheets.KEY) is not None:
            content = datasheets.followed(content, self._content)
        return checked_case(content, type(self._varied))

    def _of_all(self, make: Callable[[int, Row], Made]) -> list[Made]:
        """Return the results of a function of number and values for all runs; an error names its run."""
        made = []
        for number, values in enumerate(self.rows, 1):
            try:
                made.append(make(number, values))
            except ValueError as error:
                named = ", ".join(
                    f"{name} = {value}" for name, value in zip(self.columns, values, strict=True)
                )
                raise ValueError(f"run {number} ({named}): {error}") from error
        return made

    def table(self) -> pd.DataFrame:
        """Return all runs: columns run, folder and varied values; raises and warns as `planned`."""
        rows = [(run.number, run.digest[:FOLDER_DIGITS], *run.values) for run in self.planned]
        return pd.DataFrame(rows, columns=["run", "folder", *self.columns])


class Sweep(Variation):
    """Case, varied values, design and answers; answers that the runs cannot give are refused at once."""

    case: CaseFile
    answers: tuple[Answers, ...] = option("answers computed for every run", min_length=1)
    outputs: Outputs = option("outputs of every run, in place of those of the case", BARE)

    def _errors(self) -> Errors:
        yield from super()._errors()
        for answer in self.answers:
            answer.check(self.case)

    @property
    def named(self) -> str:
        """Name of the case and duration, for reading."""
        return f"{self.case.case.name}, {self.case.duration:g} s"

    @cached_property
    def _varied(self) -> Varied:
        """Varied subject: a case file and, if paths lead to it, the first answer of life, for all."""
        life = None
        if any(path.startswith("life.") for varied in self.vary for path in varied.keys):
            life = next((answer for answer in self.answers if isinstance(answer, Life)), None)
            if life is None:
                raise ValueError("vary: paths of life need an answer of model 'life'")
        return Varied(**dict(self.case) | {"outputs": self.outputs}, life=life)

    def case_of(self, values: Row) -> tuple[CaseFile, str, tuple[Answers, ...]]:
        """Return case file, digest and answers of a run; the name of the case ends with the digest."""
        varied = self._changed(values)
        answers = self.answers
        lives = None
        if varied.life is not None:
            drawn = {name: getattr(varied.life, name) for name in LIVES}
            answers = tuple(
                answer.with_(**drawn) if isinstance(answer, Life) else answer for answer in answers
            )
            lives = ANSWERS.dump_python(answers, mode="json")
        # already checked
        case_file = CaseFile.model_construct(
            **{name: getattr(varied, name) for name in CaseFile.model_fields}
        )
        digest = run_digest(case_file, lives)
        name = f"{case_file.case.name[:80]} {digest[:FOLDER_DIGITS]}"
        case = case_file.case.model_copy(update={"name": name})
        return case_file.model_copy(update={"case": case}), digest, answers

    @cached_property
    def planned(self) -> tuple[PlannedRun, ...]:
        """All runs, checked; warns of implausible values, with the number of the first run that has each."""
        odd: dict[str, int] = {}
        draws_typical = self.is_sampled and any(
            path.startswith(TYPICAL) for variable in self.vary for path in variable.keys
        )

        def plan(number: int, values: Row) -> PlannedRun:
            try:
                case_file, digest, chosen = self.case_of(values)
            except ValueError as error:
                # typical values are those of real machines, but some do not fit each other
                if not draws_typical:
                    raise
                return PlannedRun(number, values, "", (), str(error))
            for answer in chosen:
                answer.check(case_file)
            for line in checks.implausible(case_file.case, case_file.duration):
                odd.setdefault(line, number)
            return PlannedRun(number, values, digest, chosen)

        planned = tuple(self._of_all(plan))
        lines = [f"{output.label}: {line}" for output in self.answers for line in checks.out_of_range(output)]
        lines += self._odd_fleet()
        unbuilt = [run for run in planned if run.obstacle]
        if len(unbuilt) == len(planned):
            raise ValueError(f"none of {len(planned)} draws can be built; run 1: {unbuilt[0].obstacle}")
        lines += [f"run {number}: {line}" for line, number in odd.items()]
        more = [f"{len(lines) - SHOWN_WARNINGS} more warnings of this sweep's values"]
        checks.warn_of(lines[:SHOWN_WARNINGS] + more * (len(lines) > SHOWN_WARNINGS))
        if unbuilt:
            numbers = ", ".join(str(run.number) for run in unbuilt[:SHOWN_WARNINGS])
            numbers += ", ..." * (len(unbuilt) > SHOWN_WARNINGS)
            left_out = f"{len(unbuilt)} of {len(planned)} draws cannot be built and are left out"
            checks.warn_of([f"{left_out}: runs {numbers}; the first: {unbuilt[0].obstacle}"])
        return planned


def run_digest(case_file: CaseFile, life: Any = None) -> str:
    """Return the SHA-256 of a run's inputs: case less its name, duration, outputs, mesh and versions.

    `life` are the answers of a run if they vary; runs of one case with different answers then have different
    folders.
    """
    content = case_file.model_dump(mode="json")
    del content["case"]["name"]
    if life is not None:
        content["life"] = life
    content["versions"] = _versions()
    flexible = case_file.case.flexible
    if flexible is not None and (mesh := Path(flexible.mesh)).is_file():
        content["mesh"] = _file_digest(mesh, mesh.stat().st_mtime_ns)
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


@cache
def _file_digest(path: Path, _changed_at: int) -> str:
    """Return the SHA-256 of a file, cached for the many runs of a sweep."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


@cache
def _versions() -> list[str]:
    return [version(name) for name in ("exudyn-crawler", "exudyn")]


def design_rows(design: Design, varied: tuple[Vary, ...], runs: int | None, seed: int) -> list[Row]:
    """Return the values of all runs.

    Samples draw `runs` points: by `scipy.stats.qmc`, or (saltelli) by SALib the points for the best estimate
    of Sobol indices (Saltelli 2002); these add `runs` points for each `Vary`, and once more. Raises
    `ValueError` if the number of runs does not fit the design.
    """
    if design not in SAMPLED:
        if runs is not None:
            raise ValueError(f"runs must be left out with design {design!r}: its values make the runs")
        levels = [variable.levels() for variable in varied]
        if design == "grid":
            return list(itertools.product(*levels))
        lengths = {variable.label: len(values) for variable, values in zip(varied, levels, strict=True)}
        if len(set(lengths.values())) > 1:
            counts = ", ".join(f"{name} {count}" for name, count in lengths.items())
            raise ValueError(f"lists must have as many values each with design 'list', got {counts}")
        return list(zip(*levels, strict=True))
    if runs is None:
        raise ValueError(f"runs must be given with design {design!r}")
    if design != "latin_hypercube" and runs & (runs - 1):
        raise ValueError(f"runs must be a power of 2 with design {design!r}, got {runs}")
    if design == "saltelli":
        from SALib.sample.sobol import sample  # optional dependency

        points = sample(salib_problem(len(varied)), runs, calc_second_order=False, seed=seed)
    else:
        sampler = qmc.Sobol if design == "sobol" else qmc.LatinHypercube
        points = sampler(len(varied), rng=seed).random(runs)
    return [
        tuple(variable.at(u) for variable, u in zip(varied, point, strict=True)) for point in points.tolist()
    ]


def salib_problem(dimensions: int) -> dict[str, Any]:
    """Return the problem of the varied parameters for SALib, in the unit cube."""
    names = [str(k) for k in range(dimensions)]
    return {"num_vars": dimensions, "names": names, "bounds": [[0.0, 1.0]] * dimensions}


def read_sweep(path: str | Path) -> Sweep:
    """Read a sweep file; relative paths of cases and meshes start from its folder.

    `case` is a case file, the name of a case such as "translation", or a table with the content of a case
    file; the other keys are those of `Sweep`, tables ``[[vary]]`` and ``[[answers]]`` among them. Raises as
    `read_case`.
    """
    path = Path(path)

    def values(content: reading.Content) -> reading.Content:
        case = case_of(content.pop("case", None), path)
        if content.pop(ASSUMED, False):
            content["vary"] = [*content.get("vary", []), *_assumed(case)]
        if isinstance(vary := content.get("vary"), list):
            content["vary"] = [
                _of_file(entry, path.parent, case) if isinstance(entry, dict) else entry for entry in vary
            ]
        return content | {"case": case.model_dump(mode="json")}

    return reading.read_parameters(path, Sweep, "sweep file", values)


def _assumed(case_file: CaseFile) -> list[reading.Content]:
    """Return variables for all assumed values of a datasheet's machine, each over its range."""
    if case_file.datasheet is None:
        raise ValueError(f"{ASSUMED} needs a case with a datasheet and assumed values")
    return datasheets.assumed_ranges(case_file.datasheet)


def _of_file(varied: reading.Content, folder: Path, case_file: CaseFile) -> reading.Content:
    """Return a variation with absolute paths of meshes, and texts with units as numbers in the unit there."""
    keys = varied.get("key")
    if MESH in str(keys):
        meshes = {
            name: _whole_paths(varied[name], folder) for name in ("values", "settings") if name in varied
        }
        return varied | meshes
    if varied.get("factor"):
        return varied
    paths = [str(key) for key in (keys if isinstance(keys, list) else [keys])]
    if settings := varied.get("settings"):
        return varied | {"settings": _in_units(settings, [_unit_at(case_file, path) for path in paths])}
    unit = _unit_at(case_file, paths[0]) if paths else ""
    many = listed if isinstance(listed := varied.get("values"), list) else []
    bounds = {name: varied[name] for name in MEASURED[:2] if name in varied}
    names = [*bounds, *(f"values[{k}]" for k in range(len(many)))]
    units.refuse_mixed([*bounds.values(), *many], unit, names)
    numbers = {name: units.number_of(varied[name], unit) for name in MEASURED if name in varied}
    # a written unit shows that the numbers are meant
    has_units = any(number != varied[name] for name, number in numbers.items())
    return varied | numbers | ({"unit": varied.get("unit", unit)} if has_units else {})


def _in_units(settings: Any, units_of_paths: list[str]) -> Any:
    """Return rows of values in the units of their paths, numbers for texts with units."""
    if not isinstance(settings, list) or not all(isinstance(row, list) for row in settings):
        return settings  # refused later with all other errors
    for k, unit in enumerate(units_of_paths):
        values = {n: row[k] for n, row in enumerate(settings) if k < len(row)}
        units.refuse_mixed([*values.values()], unit, [f"settings[{n}][{k}]" for n in values])
    return [
        [
            *(units.number_of(*pair) for pair in zip(row, units_of_paths, strict=False)),
            *row[len(units_of_paths) :],
        ]
        for row in settings
    ]


def _unit_at(case_file: CaseFile, path: str) -> str:
    """Return the unit of the value at a path; empty for a value without a unit and for a wrong path."""
    # a wrong path is refused later with all other errors
    with suppress(ValueError):
        entry = fields.entry_at(case_file, fields.parse_path(path))
        return "" if entry is None else entry.unit
    return ""


def _whole_paths(value: Any, folder: Path) -> Any:
    """Return a value, or values, with absolute paths in place of names of files in a folder."""
    if isinstance(value, list):
        return [_whole_paths(element, folder) for element in value]
    is_file = isinstance(value, str) and os.path.isfile(folder / value)
    return str((folder / value).resolve()) if is_file else value
