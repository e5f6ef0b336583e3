"""Values of a case, or of its life, that differ between the runs of a sweep."""

from functools import partial
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import Field, ValidationError
from scipy.stats import norm

from exudyn_crawler.machines import CaseFile
from exudyn_crawler.machines.case_files import with_equal_loads
from exudyn_crawler.results.life.duty import Duty
from exudyn_crawler.settings import fields, reading
from exudyn_crawler.settings.error_lines import error_lines
from exudyn_crawler.settings.parameters import Errors, Name, Parameters, option
from exudyn_crawler.sweep.answers import Life

WITHIN = 0.9  # fraction of the drawn values between low and high
Puts = tuple[Any, ...]  # values, one a path
Base = TypeVar("Base", bound=CaseFile | Duty)
Key = Annotated[str, Field(min_length=1, max_length=200)]


class Varied(CaseFile):
    """Subject of a sweep's paths: a case file and, under `life`, the parameters of its answers of life."""

    life: Life | None = None


def checked_case(content: dict[str, Any], kind: type[Base]) -> Base:
    """Return the case file or duty of a content.

    Raises `ValueError` with the first error and its path.
    """
    if (case := content.get("case")) is not None:
        content = content | {"case": with_equal_loads(case)}
    try:
        return reading.from_content(kind, content)
    except ValidationError as error:
        raise ValueError(next(error_lines(error, kind))) from error


class Vary(Parameters):
    """Value of the case that varies from run to run, or several values that change together."""

    key: Key | tuple[Key, ...] = option(
        "path of the value, such as terrain.spring_stiffness, loads.phases[*].loads (of all phases), "
        "or life.material.casting_factor (of all answers of life); several paths share one value or "
        "factor"
    )
    name: Name | None = option("column of the table; none: last name of the path", None)
    unit: str | None = option(
        "unit of values and bounds, which must be that of the case; none: not checked", None
    )
    values: tuple[Any, ...] | None = option("list of values, in place of bounds", None)
    settings: tuple[Puts, ...] | None = option(
        "settings for each value, one for each path in order; tables and axes show the values in `unit`", None
    )
    low: float | None = option("lower bound", None)
    high: float | None = option("upper bound", None)
    count: int | None = option("number of grid values between the bounds", None, ge=2, le=1_000_000)
    scale: Literal["linear", "log"] = option(
        "spacing between the bounds: linear, equal steps; log, equal ratios", "linear"
    )
    distribution: Literal["uniform", "normal", "weibull"] = option(
        "distribution of drawn values; normal on a log scale is log-normal", "uniform"
    )
    within: float | None = option("probability between low and high; none: 0.9", None, gt=0, lt=1)
    factor: bool = option("values and bounds as factors of the base's value", False)

    def _errors(self) -> Errors:
        for path in self.keys:
            fields.parse_path(path)
        if not self.keys or len(set(self.keys)) != len(self.keys):
            yield f"key must be a path, or different ones, got {fields.shown(list(self.keys))}"
        errors = self._bound_errors() if self.values is None else self._value_errors(self.values)
        yield from (f"{self.label}: {error}" for error in errors)

    def _bound_errors(self) -> Errors:
        if self.settings is not None:
            yield "settings must be given with values, one for each"
        if self.low is None or self.high is None:
            yield "values, or low and high, must be given"
        elif self.low >= self.high:
            yield f"low must be less than high = {self.high:g}, got {self.low:g}"
        elif (self.scale == "log" or self.distribution == "weibull") and self.low <= 0.0:
            log = "distribution 'weibull'" if self.distribution == "weibull" else "scale 'log'"
            yield f"low must be positive with {log}, got {self.low:g}"
        if self.distribution == "uniform" and self.within is not None:
            yield f"within must be left out with distribution 'uniform', got {self.within:g}"
        if self.distribution == "weibull" and self.scale == "log":
            yield "scale must be left out with distribution 'weibull'"
        if self.distribution != "uniform" and self.count is not None:
            yield f"count must be left out with distribution {self.distribution!r}, which needs a sample"

    def _value_errors(self, values: tuple[Any, ...]) -> Errors:
        if (self.low, self.high, self.count, self.distribution) != (None, None, None, "uniform"):
            yield "low, high, count and distribution must be left out with values"
        if not values:
            yield "values must hold at least one value, got an empty list"
        if any(value in values[:k] for k, value in enumerate(values)):
            yield f"values must be different, got {fields.shown(list(values))}"
        if self.settings is None:
            return
        if self.name is None or self.factor:
            yield "settings must be given with a name, and without factor"
        counts = [len(row) for row in self.settings]
        paths = len(self.keys)
        if counts != [paths] * len(values):
            lists = f"{len(values)} lists, one a value, of {paths} each, one a path"
            yield f"settings must be {lists}, got lists of {fields.shown(counts)}"

    @property
    def keys(self) -> tuple[str, ...]:
        """All paths."""
        return (self.key,) if isinstance(self.key, str) else self.key

    @property
    def label(self) -> str:
        """Name of the column."""
        return self.name or fields.names_of(fields.parse_path(self.keys[0]))[-1]

    @property
    def _values(self) -> tuple[Any, ...]:
        """Values, or bounds."""
        return (self.low, self.high) if self.values is None else self.values

    def levels(self) -> tuple[Any, ...]:
        """Return the values of a grid.

        Raises `ValueError` for bounds without a count.
        """
        if self.values is not None:
            return self.values
        if self.count is None:
            raise ValueError(f"{self.label}: count must be given for a grid")
        return tuple(self.at(u) for u in np.linspace(0.0, 1.0, self.count))

    def at(self, portion: float) -> Any:
        """Return the value at a portion (0 to 1) of a distribution, between low and high, or of a list."""
        if self.values is not None:
            return self.values[min(int(portion * len(self.values)), len(self.values) - 1)]
        assert self.low is not None and self.high is not None  # noqa: PT018 - both or neither
        if self.distribution != "uniform":
            return self._quantile(portion)
        if portion in (0.0, 1.0):
            return self.high if portion else self.low
        if self.scale == "log":
            return float(self.low * (self.high / self.low) ** portion)
        return float(self.low + portion * (self.high - self.low))

    def _quantile(self, portion: float) -> float:
        """Return the quantile of the distribution given by its two quantiles `low` and `high`.

        A normal variable is linear in its standard score, the log of a Weibull one in ``log(-log(1 - p))``.
        """
        tail = 0.5 * (1.0 - (WITHIN if self.within is None else self.within))
        is_normal = self.distribution == "normal"
        is_log = self.scale == "log" or not is_normal
        portions = np.array([portion, tail, 1.0 - tail])
        score, least, most = norm.ppf(portions) if is_normal else np.log(-np.log1p(-portions))
        bounds = np.array([self.low, self.high])
        low, high = np.log(bounds) if is_log else bounds
        value = low + (score - least) / (most - least) * (high - low)
        return float(np.exp(value) if is_log else value)

    def unit_in(self, case_file: CaseFile | Duty) -> str:
        """Return the unit of the column; empty for factors and values without a unit."""
        if self.settings is not None:
            return self.unit or ""
        entry = fields.entry_at(case_file, fields.parse_path(self.keys[0]))
        return "" if self.factor or entry is None else entry.unit

    def applied(self, content: dict[str, Any], value: Any) -> dict[str, Any]:
        """Return the content of a case with a value, with the settings of that value, or multiplied by it."""
        puts: Puts = (value,) * len(self.keys)
        if self.settings is not None and self.values is not None:
            puts = self.settings[self.values.index(value)]
        kind = Varied if "case" in content else None
        for path, put in zip(self.keys, puts, strict=True):
            with fields.errors_at(path):
                content = fields.with_change(
                    content, fields.parse_path(path), partial(self._changed, put), kind
                )
        return content

    def _changed(self, put: Any, before: Any) -> Any:
        if self.factor:
            return _multiplied(before, put)
        # a count between bounds is rounded to a whole number
        is_count = fields.is_number(before) and isinstance(before, int) and self.values is None
        return round(put) if is_count else put

    def check(self, case_file: CaseFile | Duty) -> None:
        """Raise `ValueError` for unknown paths, a wrong unit or wrong values; the message names the path."""
        for path in self.keys:
            entry = fields.entry_at(case_file, fields.parse_path(path))
            if entry is None:
                continue
            if fields.is_table(entry.value):
                raise ValueError(f"{path} is a table; key must be the path of a value in it")
            if entry.place[-1] in fields.TAGS:
                raise ValueError(
                    f"{path} cannot be varied: it selects a class with other keys; make one sweep for each"
                )
            # settings are computed: their unit is that of their values
            if self.settings is None:
                self._check_unit(path, entry)
        content = case_file.model_dump(mode="json")
        for value in self._values:
            try:
                checked_case(self.applied(content, value), type(case_file))
            except ValueError as error:
                # values, each allowed, may fit each other only with other varied values
                cause = error.__cause__
                kinds = (
                    {error["type"] for error in cause.errors()} if isinstance(cause, ValidationError) else {}
                )
                if kinds != {"value_error"}:
                    raise
        if self.factor and all(self.applied(content, value) == content for value in self._values[:2]):
            raise ValueError(f"{', '.join(self.keys)}: a factor of zero changes nothing")

    def _check_unit(self, path: str, entry: fields.Item) -> None:
        """Raise ValueError for another unit, and for numbers that, given no unit, are likely in another."""
        if self.unit is not None and self.unit != ("" if self.factor else entry.unit):
            meant = "none with a factor" if self.factor else repr(entry.unit)
            raise ValueError(f"{path}: unit must be {meant}, got {self.unit!r}: values are in SI units")
        if self.unit is not None or self.factor:
            return
        for value in filter(fields.is_number, self._values):
            if cause := fields.likely_cause(float(value), entry.field):
                raise ValueError(
                    f"{path}: {value:g} {entry.unit} is implausible{cause}; "
                    f"if it is right, give unit = {entry.unit!r}"
                )


def _multiplied(before: Any, factor: Any) -> Any:
    """Return a number, or the numbers of a list, times a factor."""
    if isinstance(before, list):
        return [_multiplied(number, factor) for number in before]
    if not (fields.is_number(before) and fields.is_number(factor)):
        raise ValueError(
            f"factor must be applied to numbers, got {fields.shown(factor)} times {fields.shown(before)}"
        )
    product = before * factor
    return int(product) if isinstance(before, int) and float(product).is_integer() else product
