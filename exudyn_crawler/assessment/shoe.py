"""Stress of the shoe by check cases under roller loads and chain pull, static and in fatigue."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from exudyn_crawler.assessment.settings import AssessmentSettings
from exudyn_crawler.assessment.states import CaseLoads
from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters.track import COUPLING
from exudyn_crawler.results.checks import cases as ready, solve
from exudyn_crawler.results.checks.checked_shoe import CheckedShoe
from exudyn_crawler.results.life.duty import UNLOADED
from fem.body.element_stress import von_mises

TURNED = "turn 70/30, side force at rails"
DRIVEN = "drive push forward"
FATIGUE = "even, sand"
"""Check case that repeats with each roller."""


class ShoeStress(NamedTuple):
    """Greatest stress of a shoe in a load case and a check case."""

    load_case: str
    check_case: str
    region: str
    stress: float
    """Stress of von Mises without factor, Pa."""


class ShoeFatigue(NamedTuple):
    """Region of the first crack under the passes of rollers."""

    load_case: str
    """Load case with the roller load of the passes."""
    region: str
    amplitude: float
    """Stress amplitude, Pa."""
    cycles: float
    """Number of cycles survived with 97.5 % probability."""


def check_of(case: Case, settings: AssessmentSettings, ready_shoe: bool) -> ready.ShoeCheck | None:
    """Return the check of a machine's shoe: of the ready one, or by the mesh of the case's flexible shoes.

    Return None if the machine's shoe is not the ready one and the case has no mesh of it.
    """
    if not ready_shoe and case.flexible is None:
        return None
    gear: Any = case.gear
    mesh = settings.mesh if ready_shoe or case.flexible is None else case.flexible.mesh
    pins = COUPLING if ready_shoe or case.flexible is None else case.flexible.pins
    return ready.ShoeCheck(
        name="shoe of the assessment",
        mesh=str(mesh),
        pins=pins,
        material=settings.material,
        track=None if ready_shoe else case.gear.loop(case.track),
        roller_radius=gear.roller_radius,
        tread_width=gear.tread_width,
        levels=(),
    )


def _below(beside: float) -> dict[str, tuple[str, ...]]:
    """Return the check cases of the ground below a shoe by roller support; `beside`: see `ShoeOutline`."""
    ends = f"both ends {0.2 * beside:.3g} m"
    corners = f"diagonal corners {0.3 * beside:.3g} m"
    ridge = f"ridge {0.4 * beside:.3g} m"
    return {
        "even": (FATIGUE, ends),
        "two": (ends, corners),
        "outer": (ends, corners),
        "one": (ridge,),
        "corner": (ridge,),
    }


def shoe_stresses(
    loads: list[CaseLoads], check: ready.ShoeCheck, say: Callable[[str], None]
) -> tuple[list[ShoeStress], ShoeFatigue | None]:
    """Return the greatest stress of a shoe in each load case, and its fatigue under passes of normal travel.

    Passes have the greatest roller load of the first group's load cases in straight travel. If there are
    none, all of the group's load cases count. Check cases are solved once: on ground without steps, stress is
    proportional to force, so that a load case scales it (`docs/check-cases.md`). The check case of turns has
    pull and roller load of the turn with the greatest needed pull. Bores are left out where a
    coupling makes their stress.
    """
    normal = [row for row in loads if row.group == loads[0].group]
    travel = [row for row in normal if row.drive == "straight"] or normal
    passing = max(travel, key=lambda row: row.roller)
    force = 0.5 * passing.roller
    shoe = CheckedShoe(check)
    below = _below(shoe.outline.beside)
    wanted = {name for names in below.values() for name in names} | {TURNED, DRIVEN}
    cases = {case.name: case for case in ready.ready_cases(shoe.outline, force)}
    turning = max((row for row in loads if row.drive == "turn"), key=lambda row: row.needed, default=None)
    if turning is not None:
        turned = ready.ready_cases(shoe.outline, 0.5 * turning.roller, turning.needed / ready.PULL)
        cases |= {case.name: case for case in turned if case.name == TURNED}
    chosen = tuple(case for name, case in cases.items() if name in wanted)
    answers = solve.solve_cases(check.with_(cases=chosen), shoe, say)
    greatest = {}
    outside = np.flatnonzero(~np.isin(shoe.regions, shoe.unused_regions))
    for case, stress in zip(answers.cases, answers.stress, strict=True):
        mises = von_mises(stress[outside])
        node = int(mises.argmax())
        greatest[case.name] = float(mises[node]), str(shoe.regions[outside[node]])
    rows = []
    for row in loads:
        scales = dict.fromkeys(below[row.support], 0.5 * row.roller / force)
        if turning is not None and row.drive == "turn":
            scales[TURNED] = row.needed / turning.needed
        if row.drive in ("stall", "blocked"):
            scales[DRIVEN] = row.needed / ready.PULL
        rows += [
            ShoeStress(row.name, name, greatest[name][1], scale * greatest[name][0])
            for name, scale in scales.items()
            if name in greatest  # a mesh without a roller path has no drive that pushes at it
        ]
    cycles = answers.cycle(UNLOADED, FATIGUE)
    cycles = cycles[~cycles["region"].isin(shoe.unused_regions)]
    if cycles.empty:
        return rows, None
    first = cycles.loc[cycles["cycles to a crack"].idxmin()]
    amplitude = 1e6 * float(first["amplitude in MPa"])
    return rows, ShoeFatigue(passing.name, str(first["region"]), amplitude, float(first["cycles to a crack"]))
