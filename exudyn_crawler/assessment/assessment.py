"""Assessment of a machine: its inputs, load cases and items, as tables."""

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files

import numpy as np
import pandas as pd

from exudyn_crawler.assessment import forces, pressure, run_forces, stability
from exudyn_crawler.assessment.inputs import AssessmentNumbers, Origin, numbers_of
from exudyn_crawler.assessment.items import AssessedItem, all_items, governing
from exudyn_crawler.assessment.load_cases import LoadCases, read_load_cases
from exudyn_crawler.assessment.settings import AssessmentSettings
from exudyn_crawler.assessment.shoe import ShoeFatigue, ShoeStress, check_of, shoe_stresses
from exudyn_crawler.assessment.states import SLEW, CaseLoads, loads_of
from exudyn_crawler.case import Case

KILO = 1e3


@dataclass(frozen=True)
class Assessment:
    """Assessment of a machine on two tracks."""

    name: str
    settings: AssessmentSettings
    numbers: AssessmentNumbers
    load_cases: LoadCases
    loads: list[CaseLoads]
    found: list[AssessedItem]
    left_out: list[str]
    """What the assessment could not look at, a line each."""
    compared: pd.DataFrame | None
    """Formulas beside a run's forces."""

    @cached_property
    def governing(self) -> list[AssessedItem]:
        """Items, the greatest utilisation first, each in the load case that governs it."""
        return governing(self.found)

    @property
    def items(self) -> pd.DataFrame:
        """Table of these items."""
        rows = [
            {
                "item": item.item,
                "load case": item.load_case,
                "group": item.group,
                "utilisation": item.utilisation,
                "within": item.verdict,
                "number": item.number,
                "limit": item.limit,
                "unit": item.unit,
                "factor": item.factor,
                "from": item.basis,
                "formula": item.formula,
                "source": item.source,
                "mark": item.mark,
            }
            for item in self.governing
        ]
        return pd.DataFrame(rows)

    @property
    def inputs(self) -> pd.DataFrame:
        """Table of the inputs, with where each comes from."""
        return pd.DataFrame([row._asdict() | {"value": _text(row.value)} for row in self.numbers.inputs])

    @property
    def cases(self) -> pd.DataFrame:
        """Table of the load cases with what each gives."""
        rows = [
            {
                "load case": row.name,
                "group": row.group,
                "factor": row.strength,
                "from": row.basis,
                "greatest pressure in kPa": row.greatest_pressure / KILO,
                "at slew in deg": np.degrees(row.slew),
                "track load in kN": row.track_load / KILO,
                "margin against tipping": row.margin,
                "edge": row.edge,
                "tips further in deg": np.degrees(row.tilt),
                "greatest roller load in kN": row.roller / KILO,
                "needed pull of a track in kN": row.needed / KILO,
                "chain tension in kN": row.tension / KILO,
                "force across a shoe in kN": row.side_force / KILO,
                "travel": row.ends,
            }
            for row in self.loads
        ]
        return pd.DataFrame(rows)

    @cached_property
    def over_slew(self) -> pd.DataFrame:
        """Pressure and stability by angle of slewing: level, at rest, with the payload and without."""
        level = forces.gravity_on_slope(self.numbers.gravity, 0.0, 0.0)
        tables = []
        for words, payload in (("without payload", 0.0), ("with payload", self.numbers.work.payload)):
            work = self.numbers.work._replace(payload=payload, digging=(0.0, 0.0), wind=0.0, slew_rate=0.0)
            acting = forces.forces_at(self.numbers.weights, work, SLEW, level)
            stands = forces.resultant(acting)
            left, right = pressure.pressure_of_tracks(stands, self.numbers.fewest)
            tipped = stability.tipping(acting, self.numbers.edges)
            reach = self.numbers.work.reach or 2.0 * max(self.numbers.edges)
            bare = forces.forces_at(self.numbers.weights, work._replace(payload=0.0), SLEW, level)
            axis = self.numbers.weights.swing_axis
            loads = stability.tipping_load(bare, self.numbers.edges, reach, axis, SLEW)
            columns = {
                "state": words,
                "slew in deg": np.degrees(SLEW),
                "ahead in m": stands.ahead,
                "to the left in m": stands.aside,
                "left track, greatest in kPa": left.greatest / KILO,
                "right track, greatest in kPa": right.greatest / KILO,
                "left track, mean in kPa": left.mean / KILO,
                "right track, mean in kPa": right.mean / KILO,
                "length that carries in m": left.length,
                "least margin": tipped.margin.min(axis=1),
                "edge": [stability.EDGES[edge] for edge in tipped.margin.argmin(axis=1)],
                "tips at in deg": np.degrees(tipped.angle.min(axis=1)),
                "rated load in t": self.settings.rated_part * loads / self.numbers.gravity / KILO,
            }
            tables.append(pd.DataFrame(columns))
            if not self.numbers.work.payload:
                break
        return pd.concat(tables, ignore_index=True)

    @property
    def plate(self) -> pd.DataFrame:
        """Greatest pressure of both tracks as one rigid plate on the case's ground, beside that of beams."""
        over = self.over_slew
        rows = []
        for angle in (0.0, 30.0, 60.0, 90.0, 180.0):
            state = over[
                (over["slew in deg"].round() == angle) & (over["state"] == over["state"].iloc[-1])
            ].iloc[0]
            place = float(state["ahead in m"]), float(state["to the left in m"])
            beams = max(state["left track, greatest in kPa"], state["right track, greatest in kPa"])
            weight = self.numbers.weight
            if state["state"] == "with payload":
                weight += self.numbers.gravity * self.numbers.work.payload
            row = {"slew in deg": angle, "beams in kPa": beams}
            laws: dict[str, pressure.Law | None] = {"linear": None}
            if self.numbers.ground.law is not None:
                laws[self.numbers.ground.law_name] = self.numbers.ground.law
            for name, law in laws.items():
                if np.isfinite(beams):
                    found = pressure.plate_pressure(weight, *place, self.numbers.fewest, law)
                    row[f"plate on {name} ground in kPa"] = found.greatest / KILO
            rows.append(row)
        return pd.DataFrame(rows)

    @property
    def clauses(self) -> pd.DataFrame:
        """Which clauses are followed, and which are left out."""
        text = files("exudyn_crawler.assessment").joinpath("clauses.toml").read_text(encoding="utf-8")
        return pd.DataFrame(tomllib.loads(text)["clauses"]).rename(columns={"leaves_out": "leaves out"})

    @property
    def lines(self) -> list[str]:
        """Lines that say what governs, what exceeds its limit, and what the numbers stand on."""
        first = self.governing[0]
        over = [item for item in self.governing if item.utilisation > 1.0]
        assumed = sum(row.origin == "assumed" for row in self.numbers.inputs)
        exceed = f"{len(over)} of {len(self.governing)} items exceed their limit"
        if over:
            exceed += ": " + ", ".join(item.item for item in over)
        return [
            f"governs: {first.item}, {first.utilisation:.3g} of 1, {first.load_case!r} ({first.group})",
            exceed,
            f"load cases: {self.load_cases.name}; {assumed} of {len(self.numbers.inputs)} inputs are assumed",
            *self.left_out,
        ]


def _text(value: object) -> str:
    """Value of an input for reading."""
    if isinstance(value, tuple | list):
        return ", ".join(_text(part) for part in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def assessment_of(
    case: Case,
    settings: AssessmentSettings | None = None,
    *,
    name: str | None = None,
    given: tuple[str, ...] = (),
    origins: Mapping[str, tuple[Origin, str]] | None = None,
    run: run_forces.RunForces | None = None,
    say: Callable[[str], None] = lambda _text: None,
) -> Assessment:
    """Assessment of the machine of a case; a ValueError if it does not stand on two closed tracks.

    `given` and `origins`: see `numbers_of`; a `run` gives its forces to the load case that it is of.
    """
    settings = settings or AssessmentSettings(name=case.name)
    numbers = numbers_of(case, settings, given, origins)
    load_cases = read_load_cases(settings.load_cases)
    by_formula = loads_of(numbers, load_cases)
    loads = by_formula
    compared = None
    if run is not None:
        loads, stands = run_forces.with_run(numbers, by_formula, run)
        compared = run_forces.comparison(numbers, by_formula, run, stands)
    left_out = []
    stresses: list[ShoeStress] = []
    fatigue: ShoeFatigue | None = None
    check = check_of(case, settings, numbers.shoe.ready)
    if settings.mesh is None:
        left_out.append("left out: the shoe's stress, since mesh is none")
    elif check is None:
        left_out.append(
            "left out: the shoe's stress: the machine's shoe is not the ready one of the 4100C, and the case "
            "has no mesh of its own, which [flexible] names"
        )
    else:
        say(f"check cases of the shoe, mesh {check.mesh}")
        stresses, fatigue = shoe_stresses(loads, check, say)
    items = all_items(numbers, settings, loads, stresses, fatigue)
    return Assessment(name or settings.name, settings, numbers, load_cases, loads, items, left_out, compared)
