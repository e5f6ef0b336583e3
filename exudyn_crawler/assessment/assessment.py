"""Assessment of a machine: its inputs, load cases and items, as tables."""

import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.resources import files

import numpy as np
import pandas as pd

from exudyn_crawler.assessment import machine_items, part_items, run_forces, slewing
from exudyn_crawler.assessment.inputs import AssessmentNumbers, numbers_of
from exudyn_crawler.assessment.items import NOT_KNOWN, AssessedItem, governing
from exudyn_crawler.assessment.ledger import inputs_ledger
from exudyn_crawler.assessment.load_cases import LoadCases, read_load_cases
from exudyn_crawler.assessment.settings import AssessmentSettings
from exudyn_crawler.assessment.shoe import ShoeFatigue, ShoeStress, check_of, shoe_stresses
from exudyn_crawler.assessment.states import FORMULA, CaseLoads, loads_of
from exudyn_crawler.case import Case
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.origins import Ledger, Origin

KILO = 1e3
ATTACHMENT = "work.payload and work.reach are a payload, or an attachment's mass and place; payload = 0: none"
ITEMS_OF_A_CASE = (
    *(machine_items.pressure_items, machine_items.tipping_items, machine_items.pull_items),
    *(
        part_items.chain_items,
        part_items.pin_items,
        part_items.pin_work_items,
        part_items.roller_items,
        machine_items.across_items,
    ),
)
"""Functions that yield the items of a load case."""


@dataclass(frozen=True)
class Assessment:
    """Assessment of a machine on two tracks."""

    name: str
    settings: AssessmentSettings
    numbers: AssessmentNumbers
    ledger: Ledger
    """Inputs with their provenance."""
    load_cases: LoadCases
    loads: list[CaseLoads]
    found: list[AssessedItem]
    left_out: list[str]
    """Parts that the assessment left out, a line each."""
    compared: pd.DataFrame | None
    """Formulas compared with the forces of runs."""

    @cached_property
    def governing(self) -> list[AssessedItem]:
        """Items by falling utilisation, each in its governing load case."""
        return governing(self.found)

    @property
    def items(self) -> pd.DataFrame:
        """Table of the governing items."""
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
                "factor from": item.factor_source,
                "from": item.basis,
                "formula": item.formula,
                "source": item.source.text,
                "mark": item.source.mark,
            }
            for item in self.governing
        ]
        return pd.DataFrame(rows)

    @property
    def inputs(self) -> pd.DataFrame:
        """Table of the inputs with their provenance."""
        return pd.DataFrame([row._asdict() | {"value": _text(row.value)} for row in self.ledger])

    @property
    def cases(self) -> pd.DataFrame:
        """Table of the load cases and their results."""
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
                "tips about": row.tilt_edge,
                "greatest roller load in kN": row.roller / KILO,
                "needed pull of a track in kN": row.needed / KILO,
                "chain tension in kN": row.tension / KILO,
                "force across a shoe in kN": row.side_force / KILO,
                "travel": row.ends,
                "needs": ", ".join(row.missing),
            }
            for row in self.loads
        ]
        return pd.DataFrame(rows)

    @cached_property
    def over_slew(self) -> pd.DataFrame:
        """Pressure and stability by slewing angle: level, at rest, with and without payload."""
        return slewing.over_slew(self.numbers, self.settings.rated_part)

    @cached_property
    def tipping(self) -> pd.DataFrame:
        """Moments about each edge by slewing angle, with slope, wind and payload."""
        return slewing.tipping_over_slew(self.numbers)

    @property
    def plate(self) -> pd.DataFrame:
        """Greatest pressure of both tracks as one rigid plate on the case's ground, beside that of beams."""
        return slewing.beams_and_plate(self.numbers, self.over_slew)

    @property
    def clauses(self) -> pd.DataFrame:
        """Clauses of standards that are followed or left out."""
        text = files("exudyn_crawler.assessment").joinpath("clauses.toml").read_text(encoding="utf-8")
        return pd.DataFrame(tomllib.loads(text)["clauses"]).rename(columns={"leaves_out": "leaves out"})

    @property
    def lines(self) -> list[str]:
        """Summary lines: governing item, exceeded limits and basis of the numbers."""
        first = self.governing[0]
        over = [item for item in self.governing if item.utilisation > 1.0]
        assumed = self.ledger.counts.get(Origin.ASSUMED, 0)
        exceed = f"{len(over)} of {len(self.governing)} items exceed their limit"
        if over:
            exceed += ": " + ", ".join(item.item for item in over)
        unknown = [item for item in self.governing if item.verdict.startswith(NOT_KNOWN)]
        needs = dict.fromkeys(key for item in unknown for key in item.needs)
        names = ", ".join(item.item for item in unknown)
        return [
            f"governs: {first.item}, {first.utilisation:.3g} of 1, {first.load_case!r} ({first.group})",
            exceed,
            *([f"{NOT_KNOWN}: {names}; they need {', '.join(needs)}"] if unknown else []),
            *([ATTACHMENT] if "work.payload" in needs else []),
            f"load cases: {self.load_cases.name}; {assumed} of {len(self.ledger)} inputs are assumed",
            *(f"{row.name!r} has the forces of {row.basis}" for row in self.loads if row.basis != FORMULA),
            *self.left_out,
        ]


def _text(value: object) -> str:
    """Return the value of an input as text."""
    if isinstance(value, tuple | list):
        return ", ".join(_text(part) for part in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def assessment_of(
    case: Case,
    settings: AssessmentSettings | None = None,
    *,
    name: str | None = None,
    given: tuple[str, ...] = (),
    origins: Ledger | None = None,
    sheet: Datasheet | None = None,
    runs: Sequence[tuple[str | None, run_forces.RunForces]] = (),
    say: Callable[[str], None] = lambda _text: None,
) -> Assessment:
    """Assess the machine of a case; raise `ValueError` unless it stands on two closed tracks.

    `given` and `origins`: see `inputs_ledger`; `sheet`: see `numbers_of`. The forces of each run replace
    those of the load case beside it. Without a name they replace those of the load case that fits the run.
    """
    settings = settings or AssessmentSettings(name=case.name)
    numbers = numbers_of(case, settings, sheet)
    ledger = inputs_ledger(case, settings, numbers, given, origins)
    load_cases = read_load_cases(settings.load_cases)
    by_formula = loads_of(numbers, load_cases)
    loads = by_formula
    compared = []
    for wanted, run in runs:
        loads, stands = run_forces.with_run(numbers, loads, run, wanted)
        compared.append(run_forces.comparison(numbers, by_formula, run, stands))
    left_out = []
    stresses: list[ShoeStress] = []
    fatigue: ShoeFatigue | None = None
    check = check_of(case, settings, numbers.shoe.ready)
    if settings.mesh is None:
        left_out.append("left out: the shoe's stress, since mesh is none")
    elif check is None:
        left_out.append(
            "left out: the shoe's stress: the machine's shoe is not the ready one of the 4100C, and the case "
            "has no mesh of it in [flexible]"
        )
    else:
        say(f"check cases of the shoe, mesh {check.mesh}")
        stresses, fatigue = shoe_stresses(loads, check, say)
    items = [item for row in loads for kind in ITEMS_OF_A_CASE for item in kind(numbers, row, settings)]
    items += part_items.shoe_items(loads, stresses, settings)
    if fatigue is not None:
        items.append(part_items.fatigue_item(numbers, settings, loads, fatigue))
    items += machine_items.machine_items(numbers, settings)
    beside = pd.concat(compared, ignore_index=True) if compared else None
    return Assessment(
        name=name or settings.name,
        settings=settings,
        numbers=numbers,
        ledger=ledger,
        load_cases=load_cases,
        loads=loads,
        found=items,
        left_out=left_out,
        compared=beside,
    )
