"""Residual hours of the parts of a machine by inspections: percent worn, life with a band, action."""

import datetime
import math
from dataclasses import dataclass

import numpy as np
import pandas as pd

from exudyn_crawler.origins import Ruled
from exudyn_crawler.results.wear.inspections import MACHINE, PROPEL, Basis, Inspections, Series
from exudyn_crawler.results.wear.laws import WORN_OUT
from exudyn_crawler.results.wear.life_fit import (
    CONFIDENCE,
    LifeFit,
    MixedFit,
    fit_by_run,
    fit_life,
    wear_coefficient,
)
from exudyn_crawler.results.wear.parts import parts
from exudyn_crawler.results.wear.plan import WearPart, WearPlan
from exudyn_crawler.settings.fields import errors_at

STATED = "stated"
"""Rule of a propel share that the wear file gives."""
LATEST = datetime.date(9000, 1, 1)
"""Latest date that is told."""


@dataclass(frozen=True)
class PartForecast:
    """Wear of one part over its hours since it was new, in the past and to its limit."""

    series: Series
    plan: WearPart
    basis: Basis
    used: np.ndarray
    """Hours of the readings since the part was new, (readings,)."""
    percent: np.ndarray
    """Percent worn at the readings, (readings,)."""
    fit: LifeFit | None
    """None: the readings show no wear."""
    unfit: str
    """Reason of a missing fit."""
    now: float
    """Hours of the part at the last inspection of the machine."""
    mixed: MixedFit | None = None
    """Fit with a coefficient for each run, if asked for."""

    @property
    def name(self) -> str:
        """Name for reading."""
        return self.series.name

    @property
    def worn_now(self) -> float:
        """Percent worn at the last inspection by the law; by the last reading without a fit."""
        return float(self.percent[-1] if self.fit is None else self.fit.percent(np.array(self.now)))

    @property
    def residual(self) -> tuple[float, float, float]:
        """Residual hours of the basis and both ends of their band; zero beyond the limit."""
        if self.fit is None:
            return math.nan, math.nan, math.nan
        lives = self.fit.life, self.fit.low, self.fit.high
        rest = [life - self.now if math.isnan(life) else max(life - self.now, 0.0) for life in lives]
        return rest[0], rest[1], rest[2]

    @property
    def action(self) -> str:
        """Action at the limit."""
        row = parts()[self.series.part]
        return row.due_turned if self.series.turned else row.due


@dataclass(frozen=True)
class WearForecast:
    """Forecasts of all inspected parts, the next one due first."""

    plan: WearPlan
    inspections: Inspections
    parts: tuple[PartForecast, ...]

    @property
    def per_machine_hour(self) -> float:
        """Hours of the basis in a machine hour; NaN if unknown."""
        if self.inspections.basis == MACHINE:
            return 1.0
        share = propel_share(self.plan, self.inspections).value
        return math.nan if share is None else float(share)

    def date_after(self, hours: float) -> datetime.date | None:
        """Return the date after some hours of the basis, at the rate of the inspections; None if unknown."""
        days = hours / self.per_machine_hour / self.inspections.machine_hours_a_day
        last = self.inspections.last.date
        return last + datetime.timedelta(days=days) if days < (LATEST - last).days else None

    @property
    def table(self) -> pd.DataFrame:
        """A row for each part: percent worn, life and residual hours with their band, action."""
        rows = []
        unit = self.inspections.basis
        for part in self.parts:
            life = (math.nan,) * 3 if part.fit is None else (part.fit.life, part.fit.low, part.fit.high)
            rest = [hours / self.per_machine_hour for hours in part.residual]
            date = None if math.isnan(rest[0]) else self.date_after(part.residual[0])
            rows.append(
                {
                    "part": part.name,
                    "worn in %": part.worn_now,
                    "machine hours left": rest[0],
                    "at least": rest[1],
                    "at most": rest[2],
                    "about": "" if date is None else date.isoformat(),
                    "action": part.action if part.fit is not None else part.unfit,
                    f"life in {unit}": life[0],
                    "life at least": life[1],
                    "life at most": life[2],
                    "law": "" if part.fit is None else part.fit.law.words,
                    "a in %/h^k": math.nan if part.fit is None else wear_coefficient(part.fit),
                    "scatter in %": math.nan if part.fit is None else part.fit.scatter,
                    "readings": len(part.percent),
                    "limit in mm": 1e3 * part.plan.size_at_limit,
                    "limit from": part.plan.limit_source,
                    "law from": part.plan.law_source,
                }
            )
        return pd.DataFrame(rows)

    @property
    def readings(self) -> pd.DataFrame:
        """A row for each reading: hours since new, size, percent worn, and that of the law."""
        rows = []
        for part in self.parts:
            at_law = np.full(len(part.used), np.nan) if part.fit is None else part.fit.percent(part.used)
            for reading, used, percent, law in zip(
                part.series.readings, part.used, part.percent, at_law, strict=True
            ):
                rows.append(
                    {
                        "part": part.name,
                        "date": reading.date.isoformat(),
                        "machine hours": reading.machine_hours,
                        f"{part.basis} since new": used,
                        "place": reading.place,
                        "size in mm": 1e3 * reading.size,
                        "worn in %": percent,
                        "by the law in %": law,
                    }
                )
        return pd.DataFrame(rows)

    @property
    def by_run(self) -> pd.DataFrame:
        """A row for each part and run with a coefficient of its own: life if all hours were of that run."""
        rows = []
        for part in self.parts:
            runs = () if part.mixed is None else part.mixed.runs
            for number, run in enumerate(runs):
                assert part.mixed is not None
                fit = part.mixed.life(np.eye(len(runs))[number].tolist())
                lives = fit.life, fit.low, fit.high
                rows.append((part.name, run, *lives))
        heads = ["part", "run", f"life in {self.inspections.basis}", "at least", "at most"]
        return pd.DataFrame(rows, columns=heads)

    @property
    def lines(self) -> list[str]:
        """Lines on what is due first, on the band and on the basis."""
        due = [part for part in self.parts if part.fit is not None]
        lines = [self._due_words(part) for part in due[:2]]
        lines += [f"{part.name}: {part.unfit}" for part in self.parts if part.fit is None]
        share = f" ({100 * self.per_machine_hour:.3g} % of the machine hours)"
        lines.append(
            f"wear over {self.inspections.basis}{share if self.inspections.basis == PROPEL else ''}; bands "
            f"of {100 * CONFIDENCE:g} % from the scatter of the readings: they hold if duty and ground stay"
        )
        if self.inspections.basis == MACHINE:
            lines.append("propel hours are not counted: a change of the share of travel changes the forecast")
        return lines

    def _due_words(self, part: PartForecast) -> str:
        """Describe the residual hours of a part."""
        rest, low, high = (hours / self.per_machine_hour for hours in part.residual)
        if rest == 0.0:
            return f"{part.name}: {part.worn_now:.0f} % worn, {part.action} now"
        band = "no band from one reading" if math.isnan(low) else f"{_hours(low)} to {_hours(high)}"
        date = self.date_after(part.residual[0])
        about = "" if date is None else f", about {date.isoformat()}"
        return (
            f"{part.name}: {part.worn_now:.0f} % worn; {part.action} in {_hours(rest)} machine hours "
            f"({band}){about}"
        )


def _hours(hours: float) -> str:
    """Return hours in three digits."""
    return "no end" if math.isinf(hours) else f"{float(f'{hours:.3g}'):.0f}"


def propel_share(plan: WearPlan, inspections: Inspections | None) -> Ruled:
    """Return propel hours over machine hours: that of the plan, or as counted; the value None is unknown."""
    if plan.propel_share is not None:
        return Ruled(plan.propel_share, STATED)
    counted = math.nan if inspections is None else inspections.propel_share
    return Ruled(None, "unknown") if math.isnan(counted) else Ruled(counted, "counted")


def percent_worn(size: np.ndarray, part: WearPart) -> np.ndarray:
    """Return percent worn at sizes (m): 0 when new, 100 at the limit."""
    return WORN_OUT * (part.new - size) / (part.new - part.size_at_limit)


def forecast(plan: WearPlan, inspections: Inspections) -> WearForecast:
    """Forecast residual hours of all inspected parts.

    Raises `ValueError` if the plan lacks a measured part, or if the readings do not determine an exponent or
    a coefficient of each run.
    """
    if plan.by_run and len(inspections.runs) < 2:
        raise ValueError(
            f"by_run: {plan.inspections} must have at least two columns 'hours NAME', got "
            f"{len(inspections.runs)}"
        )
    found = [_part_forecast(plan, inspections, series) for series in inspections.series()]
    if not found:
        raise ValueError(f"{plan.inspections} must have readings beside new and turned parts, got none")
    found.sort(key=lambda part: (part.fit is None, part.residual[0] if part.fit is not None else 0.0))
    return WearForecast(plan, inspections, tuple(found))


def _part_forecast(plan: WearPlan, inspections: Inspections, series: Series) -> PartForecast:
    """Return the forecast of one part."""
    basis = inspections.basis
    part = plan.part(series.part)
    if part is None:
        raise ValueError(
            f"parts must have a table for {series.part!r}, which row {series.readings[0].row} of "
            f"{plan.inspections} measures: part = {series.part!r}, new, limit"
        )
    used = series.hours(basis)
    percent = percent_worn(series.sizes, part)
    begin = 0.0 if series.begin is None else series.begin.hours(basis)
    now = inspections.last.hours(basis) - begin
    if not np.sum(used * percent) > 0.0:
        return PartForecast(series, part, basis, used, percent, None, "no wear measured yet: no hours", now)
    error = None
    if part.reading_error is not None:
        error = WORN_OUT * part.reading_error / abs(part.new - part.size_at_limit)
    if plan.by_run:
        if part.law is None:
            raise ValueError(f"parts: exponent of {series.part!r} must be a number with by_run, got 'fitted'")
        hours = series.hours_of_runs()
        with errors_at(series.name):
            mixed = fit_by_run(hours, percent, part.law, inspections.runs, error)
        mix = hours[-1] / used[-1]
        return PartForecast(series, part, basis, used, percent, mixed.life(mix.tolist()), "", now, mixed)
    with errors_at(series.name):
        fit = fit_life(used, percent, part.law, error)
    return PartForecast(series, part, basis, used, percent, fit, "", now)
