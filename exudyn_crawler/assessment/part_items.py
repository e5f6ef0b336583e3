"""Items of a machine's parts: chain, pin and bush, rollers on their rails, shoe."""

from collections.abc import Iterator

import numpy as np

from exudyn_crawler.assessment import utilisation
from exudyn_crawler.assessment.inputs import AssessmentNumbers
from exudyn_crawler.assessment.items import KILO, MEGA, STATICS, AssessedItem, Source, case_item
from exudyn_crawler.assessment.settings import AssessmentSettings
from exudyn_crawler.assessment.shoe import ShoeFatigue, ShoeStress
from exudyn_crawler.assessment.states import CaseLoads
from exudyn_crawler.results.wear.closed_form import WheelTensions, pin_work

EUROCODE_PIN = Source("EN 1993-1-8, table 3.10", "S")
EUROCODE_HOLE = Source("EN 1993-1-8, eq. 3.15", "S")
MANGANESE = Source("dry bores of manganese 40 to 80 MPa", "R")
JOHNSON = Source("Johnson 1985, 4.2 and 9.1", "S")
HARDENED = Source("hardened crawler rollers 6 to 10 MPa, 1.4 times as an exception", "R")
SPECIFIC = 6e6
"""Specific pressure of hardened steel crawler rollers, Pa: the least of 6 to 10 MPa (remembered; 4 to 6 MPa
for cast manganese against alloy steel)."""
YOUNGS_MODULUS = 210e9
"""Young's modulus of steel, Pa."""
EXTREME = 1.4
"""Factor on the allowed specific pressure in the third group (remembered)."""


def chain_items(numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings) -> Iterator[AssessedItem]:
    """Yield the tension of the chain over its breaking tension."""
    breaking = "; breaking: see inputs"
    yield case_item(
        row,
        "chain tension",
        row.tension / KILO,
        numbers.chain.breaking / KILO,
        "kN",
        f"tension at rest + pull{breaking}",
        STATICS,
        of_run=f"greatest of a link{breaking}",
        factor=row.strength,
        needs=row.missing_of_travel,
    )


def pin_items(numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings) -> Iterator[AssessedItem]:
    """Yield the items of pin and bush of the more loaded hinge."""
    shoe = numbers.shoe
    force = row.tension / shoe.hinges * utilisation.SHARED
    stress = utilisation.pin_stress(force, shoe.hinge)
    resists = utilisation.pin_resistance(shoe.pin, shoe.lug)
    share = f"force {utilisation.SHARED:g} T / {shoe.hinges} (share assumed)"
    bearing = "F / (2 d a), outer lugs" if shoe.hinge.outer_governs else "F / (d b), inner lug"
    bending = "F (b + 4 c + 2 a) / 8 over W"
    factor = row.strength
    rows = [
        ("pin, shear", stress.shear, resists.shear, factor, "F / 2 over pi d2 / 4", EUROCODE_PIN),
        ("pin and lug, bearing", stress.bearing, resists.bearing, factor, bearing, EUROCODE_PIN),
        ("pin, bending", stress.bending, resists.bending, factor, bending, EUROCODE_PIN),
    ]
    if shoe.hinge.play:
        contact = utilisation.hole_contact(force, shoe.hinge, YOUNGS_MODULUS)
        bears = 2.5 * min(shoe.pin.yield_strength, shoe.lug.yield_strength)
        in_hole = "0.591 sqrt(E F (d0 - d) / (d2 t)), service load"
        rows.append(("pin in its hole, contact", contact, bears, 1.0, in_hole, EUROCODE_HOLE))
    if row.group == "H":
        worn = force / (shoe.hinge.diameter * shoe.hinge.inner)
        rows.append(("bush, wear", worn, shoe.wear_pressure, 1.0, "F / (d b), inner lug or bush", MANGANESE))
    needs = row.missing_of_travel
    for name, value, limit, of_load, formula, source in rows:
        words = f"{formula}; {share}"
        number = value / MEGA
        yield case_item(row, name, number, limit / MEGA, "MPa", words, source, factor=of_load, needs=needs)
    both = (stress.bending / resists.bending) ** 2 + (stress.shear / resists.shear) ** 2
    words = f"(M / M_Rd)2 + (F / F_Rd)2, square of the force; {share}"
    name = "pin, bending and shear together"
    yield case_item(row, name, both, 1.0, "1", words, EUROCODE_PIN, factor=factor**2, needs=needs)


def pin_work_items(
    numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings
) -> Iterator[AssessedItem]:
    """Yield the work of wear of a pin in a lap of the chain, forward and in reverse, in normal travel.

    The tumbler at the rear pulls the lower run forward, and the upper run with the idler in reverse.
    """
    if row.group != "H" or row.drive != "straight":
        return
    rest, taut = numbers.chain.rest, row.tension
    radius = 0.5 * numbers.shoe.hinge.diameter
    ways = {
        "forward": WheelTensions(taut, rest, rest, rest),
        "reverse": WheelTensions(rest, taut, taut, taut),
    }
    for way, tensions in ways.items():
        yield case_item(
            row,
            f"pin, work of wear in a lap, {way}",
            pin_work(radius, numbers.chain.bends, tensions) / KILO,
            np.nan,
            "kJ",
            formula="r (a_t (T1 + T2) + a_i (T3 + T4)), without vibration; gives ratios, no hours",
            source=Source("geometry of the chain; runs 3 to 4 % above with their own tensions", "D"),
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
    hertz = f"Hertz, {force / KILO:.0f} kN a tread"
    needs = row.missing_of_loads
    limits = [("yield below the surface", contact.to_yield, "pressure goes by the root of the force")]
    if row.group != "HZS":
        limits.append(("shakedown", contact.to_shakedown, "flows in every pass beyond it"))
    factor = np.sqrt(row.strength)
    for name, times, reason in limits:
        item, formula = f"roller on rail, {name}", f"{hertz}; {reason}"
        yield case_item(
            row, item, stress, stress * times, "MPa", formula, JOHNSON, factor=factor, needs=needs
        )
    if row.support == "even":
        item, formula = "roller on rail, specific pressure", f"F / (D b), {force / KILO:.0f} kN a tread"
        limit = SPECIFIC * (EXTREME if row.group == "HZS" else 1.0) / MEGA
        yield case_item(row, item, contact.specific / MEGA, limit, "MPa", formula, HARDENED, needs=needs)


def shoe_items(
    loads: list[CaseLoads], stresses: list[ShoeStress], settings: AssessmentSettings
) -> Iterator[AssessedItem]:
    """Yield the greatest stress of the shoe by check cases."""
    by_name = {row.name: row for row in loads}
    limit = settings.material.yield_strength / MEGA
    for stress in stresses:
        row = by_name[stress.load_case]
        yield case_item(
            row,
            "shoe, static stress",
            stress.stress / MEGA,
            limit,
            "MPa",
            f"check case {stress.check_case!r}, {stress.region}",
            Source("finite elements", "D"),
            factor=row.strength,
            needs=row.missing_of_loads,
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
    travel = f"passes of rollers in {settings.hours:g} h, {settings.travel_part:g} of them in travel"
    stress = f"{fatigue.region}, amplitude {fatigue.amplitude / MEGA:.0f} MPa"
    formula = f"{travel}; {stress} by {0.5 * row.roller / KILO:.0f} kN a tread"
    source = Source("FKM guideline by check cases", "S")
    needs = row.missing_of_loads
    return case_item(row, "shoe, fatigue", passes, fatigue.cycles, "cycles", formula, source, needs=needs)
