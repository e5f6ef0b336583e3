"""Items of a machine's parts: chain, pin and bush, rollers on their rails, shoe."""

from collections.abc import Iterator

import numpy as np

from exudyn_crawler.assessment import utilisation
from exudyn_crawler.assessment.inputs import AssessmentNumbers
from exudyn_crawler.assessment.items import KILO, MEGA, AssessedItem, by_run, case_item
from exudyn_crawler.assessment.settings import AssessmentSettings
from exudyn_crawler.assessment.shoe import ShoeFatigue, ShoeStress
from exudyn_crawler.assessment.states import CaseLoads

SPECIFIC = 6e6
"""Specific pressure of hardened steel crawler rollers, Pa: the least of 6 to 10 MPa (recalled; 4 to 6 MPa for
cast manganese against alloy steel)."""
YOUNGS_MODULUS = 210e9
"""Young's modulus of steel, Pa."""
EXTREME = 1.4
"""Factor on the allowed specific pressure in the third group (recalled)."""


def chain_items(numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings) -> Iterator[AssessedItem]:
    """Yield the tension of the chain over its breaking tension."""
    yield case_item(
        row,
        "chain tension",
        row.tension / KILO,
        numbers.chain.breaking / KILO,
        "kN",
        factor=row.strength,
        formula=by_run(row, "tension at rest + pull", "greatest of a link"),
        source=by_run(row, "statics; breaking: see inputs", f"{row.basis}; breaking: see inputs"),
        mark="D",
        needs=row.missing_of_travel,
    )


def pin_items(numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings) -> Iterator[AssessedItem]:
    """Yield the items of pin and bush of the more loaded hinge."""
    shoe = numbers.shoe
    force = row.tension / shoe.hinges * utilisation.SHARED
    stress = utilisation.pin_stress(force, shoe.hinge)
    resists = utilisation.pin_resistance(shoe.pin, shoe.lug)
    source = "EN 1993-1-8, table 3.10"
    share = f"force {utilisation.SHARED:g} T / {shoe.hinges} (share assumed)"
    bearing = "F / (2 d a), outer lugs" if shoe.hinge.outer_governs else "F / (d b), inner lug"
    rows = (
        ("pin, shear", stress.shear, resists.shear, "F / 2 over pi d2 / 4"),
        ("pin and lug, bearing", stress.bearing, resists.bearing, bearing),
        ("pin, bending", stress.bending, resists.bending, "F (b + 4 c + 2 a) / 8 over W"),
    )
    for name, value, limit, formula in rows:
        yield case_item(
            row,
            name,
            value / MEGA,
            limit / MEGA,
            "MPa",
            factor=row.strength,
            formula=f"{formula}; {share}",
            source=source,
            mark="S",
            needs=row.missing_of_travel,
        )
    yield case_item(
        row,
        "pin, bending and shear together",
        (stress.bending / resists.bending) ** 2 + (stress.shear / resists.shear) ** 2,
        1.0,
        "1",
        factor=row.strength**2,
        formula=f"(M / M_Rd)2 + (F / F_Rd)2, square of the force; {share}",
        source=source,
        mark="S",
        needs=row.missing_of_travel,
    )
    if shoe.hinge.play:
        yield case_item(
            row,
            "pin in its hole, contact",
            utilisation.hole_contact(force, shoe.hinge, YOUNGS_MODULUS) / MEGA,
            2.5 * min(shoe.pin.yield_strength, shoe.lug.yield_strength) / MEGA,
            "MPa",
            formula=f"0.591 sqrt(E F (d0 - d) / (d2 t)), service load; {share}",
            source="EN 1993-1-8, eq. 3.15",
            mark="S",
            needs=row.missing_of_travel,
        )
    if row.group == "H":
        yield case_item(
            row,
            "bush, wear",
            force / (shoe.hinge.diameter * shoe.hinge.inner) / MEGA,
            shoe.wear_pressure / MEGA,
            "MPa",
            formula=f"F / (d b), inner lug or bush; {share}",
            source="dry bores of manganese 40 to 80 MPa",
            mark="R",
            needs=row.missing_of_travel,
        )


def roller_items(
    numbers: AssessmentNumbers, row: CaseLoads, settings: AssessmentSettings
) -> Iterator[AssessedItem]:
    """Yield the items of the most loaded roller's tread on its rail."""
    force = 0.5 * row.roller
    tread = numbers.rollers.tread
    contact = utilisation.roller_contact(force, tread, settings.material.yield_strength)
    stress = contact.pressure / MEGA
    limits = [("yield below the surface", contact.to_yield, "pressure goes by the root of the force")]
    if row.group != "HZS":
        limits.append(("shakedown", contact.to_shakedown, "flows in every pass beyond it"))
    for name, times, reason in limits:
        yield case_item(
            row,
            f"roller on rail, {name}",
            stress,
            stress * times,
            "MPa",
            factor=np.sqrt(row.strength),
            formula=f"Hertz, {force / KILO:.0f} kN a tread; {reason}",
            source="Johnson 1985, 4.2 and 9.1",
            mark="S",
            needs=row.missing_of_loads,
        )
    if row.support == "even":
        yield case_item(
            row,
            "roller on rail, specific pressure",
            contact.specific / MEGA,
            SPECIFIC * (EXTREME if row.group == "HZS" else 1.0) / MEGA,
            "MPa",
            formula=f"F / (D b), {force / KILO:.0f} kN a tread",
            source="hardened crawler rollers 6 to 10 MPa, 1.4 times as an exception",
            mark="R",
            needs=row.missing_of_loads,
        )


def shoe_items(
    loads: list[CaseLoads], stresses: list[ShoeStress], settings: AssessmentSettings
) -> Iterator[AssessedItem]:
    """Yield the greatest stress of the shoe by check cases."""
    by_name = {row.name: row for row in loads}
    for stress in stresses:
        yield case_item(
            by_name[stress.load_case],
            "shoe, static stress",
            stress.stress / MEGA,
            settings.material.yield_strength / MEGA,
            "MPa",
            factor=by_name[stress.load_case].strength,
            formula=f"check case {stress.check_case!r}, {stress.region}",
            source="finite elements",
            mark="D",
            needs=by_name[stress.load_case].missing_of_loads,
        )


def fatigue_item(
    numbers: AssessmentNumbers, settings: AssessmentSettings, loads: list[CaseLoads], fatigue: ShoeFatigue
) -> AssessedItem:
    """Return the roller passes in the travel hours of the machine over the fatigue life of a shoe."""
    row = next(case for case in loads if case.name == fatigue.load_case)
    rollers = len(numbers.rollers.places)
    way = numbers.chain.speed * 3600.0 * settings.travel_part * settings.hours
    around = numbers.chain.shoes * numbers.chain.pitch
    passes = rollers * way / around
    return AssessedItem(
        "shoe, fatigue",
        row.name,
        row.group,
        passes,
        fatigue.cycles,
        "cycles",
        1.0,
        passes / fatigue.cycles,
        row.basis,
        f"passes of rollers in {settings.hours:g} h, {settings.travel_part:g} of them in travel; "
        f"{fatigue.region}, amplitude {fatigue.amplitude / MEGA:.0f} MPa by {0.5 * row.roller / KILO:.0f} kN "
        "a tread",
        "FKM guideline by check cases",
        "S",
        needs=row.missing_of_loads,
    )
