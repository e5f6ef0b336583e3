"""Shoe of an assessment by check cases: stress under its rollers' loads and chain, static and fatigue."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from exudyn_crawler.assessment.states import CaseLoads
from exudyn_crawler.results.checks import cases as ready, solve
from exudyn_crawler.results.life.duty import UNLOADED, FatigueMaterial
from exudyn_crawler.results.stress.hot_spots import BORES
from fem.stress import von_mises

BELOW = {
    "even": ("even, sand", "both ends 0.2 m"),
    "two": ("both ends 0.2 m", "diagonal corners 0.3 m"),
    "outer": ("both ends 0.2 m", "diagonal corners 0.3 m"),
    "one": ("ridge 0.4 m",),
    "corner": ("ridge 0.4 m",),
}
"""Check cases of the ground below a shoe, by what the rollers stand on."""
TURNED = "turn 70/30, side force at rails"
DRIVEN = "drive push forward"
FATIGUE = "even, sand"
"""Check case that comes with each roller."""


class ShoeStress(NamedTuple):
    """Greatest stress of a shoe in a load case and a check case."""

    load_case: str
    check_case: str
    region: str
    stress: float
    """von Mises, without factor, Pa."""


class ShoeFatigue(NamedTuple):
    """Region that cracks first under the passes of rollers."""

    region: str
    amplitude: float
    """Pa."""
    cycles: float
    """That 97.5 % survive."""


def shoe_stresses(
    loads: list[CaseLoads], material: FatigueMaterial, mesh: str, say: Callable[[str], None]
) -> tuple[list[ShoeStress], ShoeFatigue | None]:
    """Greatest stress of the ready shoe in each load case, and its fatigue under normal passes.

    Check cases are solved once; ground without steps answers in proportion to forces, so that a load case
    scales them (`docs/check-cases.md`). Bores are left out: pins hold them by spiders.
    """
    normal = [row for row in loads if row.group == loads[0].group]
    force = 0.5 * max(row.roller for row in normal)
    check = ready.ShoeCheck(name="shoe of the assessment", mesh=mesh, material=material, levels=())
    shoe = solve.CheckedShoe(check)
    wanted = {name for names in BELOW.values() for name in names} | {TURNED, DRIVEN}
    cases = tuple(case for case in ready.ready_cases(shoe.outline, force) if case.name in wanted)
    found = solve.solve_cases(check.with_(cases=cases), shoe, say)
    greatest = {}
    outside = np.flatnonzero(shoe.regions != BORES)
    for case, stress in zip(found.cases, found.stress, strict=True):
        mises = von_mises(stress[outside])
        node = int(mises.argmax())
        greatest[case.name] = float(mises[node]), str(shoe.regions[outside[node]])
    rows = []
    for row in loads:
        scales = dict.fromkeys(BELOW[row.support], 0.5 * row.roller / force)
        if row.drive == "turn":
            scales[TURNED] = row.needed / ready.PULL
        if row.drive in ("stall", "blocked"):
            scales[DRIVEN] = row.needed / ready.PULL
        rows += [
            ShoeStress(row.name, name, greatest[name][1], scale * greatest[name][0])
            for name, scale in scales.items()
        ]
    cycles = found.cycle(UNLOADED, FATIGUE)
    cycles = cycles[cycles["region"] != BORES]
    if cycles.empty:
        return rows, None
    first = cycles.loc[cycles["cycles to a crack"].idxmin()]
    amplitude = 1e6 * float(first["amplitude in MPa"])
    return rows, ShoeFatigue(str(first["region"]), amplitude, float(first["cycles to a crack"]))
