"""Work of wear of each part in a propel hour of a duty, and the hours that follow for other duties."""

import math
from dataclasses import dataclass

import numpy as np
import pandas as pd

from exudyn_crawler.case import Case
from exudyn_crawler.results.wear import closed_form
from exudyn_crawler.results.wear.forecast import PartForecast, WearForecast
from exudyn_crawler.results.wear.laws import WORN_OUT, PowerLaw
from exudyn_crawler.results.wear.life_fit import LifeFit
from exudyn_crawler.results.wear.parts import limit_fraction, limit_source, limit_words
from exudyn_crawler.results.wear.plan import WearDuty, WearPart, WearPlan
from exudyn_crawler.results.wear.work import PAIRS, REGIONS, RunWork

HOUR = 3600.0  # s
PAIR_OF = {"pitch": "pin", "rail": "rail", "bush": "bush", "sprocket": "bush"}
"""Pair whose work wears a part; that of a tooth goes with that of a bush."""
WHEELS = ("roller", "carrier", "idler")


@dataclass(frozen=True)
class DutyWork:
    """Duty with the work of its runs, by their names."""

    duty: WearDuty
    runs: dict[str, RunWork]

    def an_hour(self, part: str, measure: str, side: str = "", place: str = "") -> float:
        """Return the work of one part in a propel hour, J; the mean of all without side or place."""
        return sum(
            run.share
            * HOUR
            / self.runs[run.name].duration
            * part_work(self.runs[run.name], part, measure, side, place)
            for run in self.duty.runs
        )


def part_work(work: RunWork, part: str, measure: str, side: str = "", place: str = "") -> float:
    """Return the work of one part over the interval of a run, J; the mean of all without side or place."""
    if part in WHEELS:
        names = [str(name) for name in work.wheels.wheel.values if f"{part} " in f"{name} "]
        names = [name for name in names if not side or name.startswith(side)] or names
        named = [name for name in names if place and name.endswith(f" {place}")]
        return float(work.wheels.sel(wheel=named or names).mean()) if names else 0.0
    pair = PAIR_OF.get(part, f"grouser, {measure}")
    each = work.each(pair)
    sides = work.by_place.track.values.tolist()
    return float(each[sides.index(side)] if side in sides else each.mean())


def pin_size(plan: WearPlan, case: Case) -> tuple[float, float]:
    """Return radius of a pin and length of its bearing, m: those of the plan, or of the case."""
    pin = case.track.pin
    pitch = case.track.pitch
    return plan.pin.radius or pin.radius_at(pitch), plan.pin.length or pin.length_at(pitch)


def work_table(duty: DutyWork) -> pd.DataFrame:
    """Return a row for each run, side and part: work a lap, a metre and a propel hour of one part."""
    rows = []
    for run in duty.duty.runs:
        work = duty.runs[run.name]
        sides = work.by_place.track.values.tolist()
        items = [(side, pair, float(work.each(pair)[k]), k) for k, side in enumerate(sides) for pair in PAIRS]
        of_track = len(work.wheels) // len(sides)
        items += [
            (
                sides[k // of_track],
                str(name).removeprefix(sides[k // of_track]).strip(),
                float(value),
                k // of_track,
            )
            for k, (name, value) in enumerate(zip(work.wheels.wheel.values, work.wheels.values, strict=True))
        ]
        for side, name, value, track in items:
            way = float(work.travel[track])
            rows.append(
                {
                    "duty": duty.duty.name,
                    "run": run.name,
                    "side": side,
                    "pair": name,
                    "work a lap in kJ": 1e-3 * value / work.laps[track] if way else 0.0,
                    "work a metre in J": value / way if way else 0.0,
                    "work a propel hour in kJ": 1e-3 * value * HOUR / work.duration,
                }
            )
    return pd.DataFrame(rows)


def region_table(duty: DutyWork) -> pd.DataFrame:
    """Return the work of a pin a lap by region of the loop and run, kJ."""
    rows = []
    for run in duty.duty.runs:
        work = duty.runs[run.name]
        laps = float(work.laps.sum())
        of_pins = work.by_place.sel(pair="pin").sum("track").values / work.shoes
        parts = [float(of_pins[work.regions == k].sum()) for k in range(len(REGIONS))]
        row: dict[str, object] = {"duty": duty.duty.name, "run": run.name}
        row |= {
            f"{name} in kJ a lap": 1e-3 * part / laps if laps else 0.0
            for name, part in zip(REGIONS, parts, strict=True)
        }
        rows.append(row)
    return pd.DataFrame(rows)


def sweep_table(duty: DutyWork) -> pd.DataFrame:
    """Return the work of a pin a lap by the threshold of sweeps, and by the closed form, kJ."""
    rows = []
    for run in duty.duty.runs:
        work = duty.runs[run.name]
        laps = float(work.laps.mean())
        for degrees, joule in work.pins_by_threshold.items():
            rows.append(
                {
                    "duty": duty.duty.name,
                    "run": run.name,
                    "sweeps from deg": degrees,
                    "pin in kJ a lap": 1e-3 * joule / laps if laps else 0.0,
                    "closed form in kJ a lap": 1e-3 * work.by_tensions / laps if laps else math.nan,
                    "ratio": joule / work.by_tensions if laps else math.nan,
                }
            )
    return pd.DataFrame(rows)


def turning_limit(plan: WearPlan) -> closed_form.GrowthLimit:
    """Return the growth at which pins and bushes are turned: that of the plan's pitch, or of makers.

    Raises `ValueError` if the plan has no pitch and makers differ.
    """
    pitch = plan.part("pitch")
    if pitch is not None:
        growth, source = pitch.size_at_limit / pitch.new - 1.0, pitch.limit_source
    else:
        mean = limit_fraction("pitch")
        if mean is None:
            raise ValueError(f"parts must have a pitch with its limit: makers differ, {limit_words('pitch')}")
        growth, source = mean, limit_source("pitch")
    return closed_form.GrowthLimit("pins and bushes to be turned", growth, source)


def growth_table(duty: DutyWork, plan: WearPlan, found: PartForecast | None) -> pd.DataFrame:
    """Return the limits of the growth of the pitch, the least first, with hours by inspections."""
    work = next(iter(duty.runs.values()))
    turning = turning_limit(plan)
    rows = []
    for limit in closed_form.growth_limits(work.case, work.take_up, turning):
        hours = math.nan
        if found is not None and found.fit is not None:
            hours = found.fit.life * found.fit.law.used(WORN_OUT * limit.growth / turning.growth)
        rows.append(
            {
                "limit": limit.limit,
                "growth in %": 100.0 * limit.growth,
                "life in hours of the basis": hours,
                "how": limit.how,
            }
        )
    return pd.DataFrame(rows)


def coefficient_life(plan: WearPlan, part: WearPart, duty: DutyWork) -> LifeFit:
    """Return the life (propel hours) of a part by its stated coefficient: worn volume over work.

    A pitch loses growth x diameter x length of the bearing: a crescent of depth h on a pin of diameter d has
    the area h d. The seals' hours of a sealed joint come first.
    """
    assert part.coefficient is not None
    case = next(iter(duty.runs.values())).case
    radius, length = pin_size(plan, case)
    volume = part.volume or (part.size_at_limit - part.new) * 2.0 * radius * length
    rate = duty.an_hour(part.part, plan.grouser_measure)
    life = volume / part.coefficient / rate if rate else math.inf
    if part.part == "pitch" and plan.pin.state == "sealed":
        life += plan.pin.sealed_hours or 0.0
    return LifeFit(PowerLaw(1.0), life, math.nan, math.nan, math.nan, 0)


def duty_table(plan: WearPlan, duties: list[DutyWork], found: WearForecast | None) -> pd.DataFrame:
    """Return a row for each part and duty: work a propel hour, its ratio to the first duty, life and rest.

    Hours follow from an inspection or a stated coefficient; others are NaN. A fitted life goes with the
    reciprocal of the work.
    """
    first = duties[0]
    inspected = {} if found is None else {part.name: part for part in found.parts}
    names = [(part.series.part, part.series.side, part.series.place, part) for part in inspected.values()]
    measured = {part for part, *_ in names}
    others = ("pitch", "bush", "rail", *WHEELS, "grouser")
    rows = []
    for part, side, place, seen in [
        *names,
        *((name, "", "", None) for name in others if name not in measured),
    ]:
        base = first.an_hour(part, plan.grouser_measure, side, place)
        for duty in duties:
            work = duty.an_hour(part, plan.grouser_measure, side, place)
            ratio = work / base if base else math.nan
            rest = life = (math.nan,) * 3
            stated = plan.part(part)
            origin = "not known"
            if seen is not None and seen.fit is not None and ratio:
                fit = seen.fit
                life = fit.life / ratio, fit.low / ratio, fit.high / ratio
                left = [value / ratio for value in seen.residual]
                rest = left[0], left[1], left[2]
                origin = f"inspections, {seen.basis}"
            elif stated is not None and stated.coefficient is not None:
                life = (coefficient_life(plan, stated, duty).life, math.nan, math.nan)
                origin = f"coefficient {1e9 * stated.coefficient:.3g} mm3/(N m), propel hours"
            rows.append(
                {
                    "part": " ".join(filter(None, (side, part, place))),
                    "duty": duty.duty.name,
                    "work a propel hour in kJ": 1e-3 * work,
                    "ratio": ratio,
                    "hours left": rest[0],
                    "at least": rest[1],
                    "at most": rest[2],
                    "life": life[0],
                    "hours from": origin,
                }
            )
    return pd.DataFrame(rows)


def mean_by_place(duty: DutyWork, pair: str) -> np.ndarray:
    """Return the work of a pair a metre of travel at each place, mean of the duty: (places,), J/m."""
    total = np.zeros(next(iter(duty.runs.values())).shoes)
    way = 0.0
    for run in duty.duty.runs:
        work = duty.runs[run.name]
        times = run.share / work.duration
        total = total + times * work.by_place.sel(pair=pair).sum("track").values
        way += times * float(work.travel.sum())
    return total / way if way else total
