"""Items of an assessment: a number, its limit and utilisation each, sorted, with formula and source."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from exudyn_crawler.assessment import forces, pressure, stability, travel, utilisation
from exudyn_crawler.assessment.inputs import AssessmentNumbers
from exudyn_crawler.assessment.settings import AssessmentSettings
from exudyn_crawler.assessment.shoe import ShoeFatigue, ShoeStress
from exudyn_crawler.assessment.states import FORMULA, SLEW, CaseLoads

MEGA = 1e6
KILO = 1e3
SPECIFIC = 6e6
"""Pa, specific pressure of crawler rollers of hardened steel, 4 to 6 cast manganese against alloy, 6 to 10
hardened (remembered; the least of the latter)."""
YOUNGS_MODULUS = 210e9
"""Pa."""
EXTREME = 1.4
"""Times the specific pressure that is allowed in the third group (remembered)."""
SAFETY_OF_CLAY = 2.0
"""Against failure of the ground, 2 to 3 (remembered)."""


class AssessedItem(NamedTuple):
    """Number of an assessment beside its limit; NaN for a limit that there is none of."""

    item: str
    load_case: str
    group: str
    number: float
    limit: float
    unit: str
    factor: float
    """On the load or the stress, of the group; 1 where the limit has it."""
    utilisation: float
    basis: str
    """Formula, or the run whose forces it takes."""
    formula: str
    source: str
    mark: str
    """S seen, D derived, R remembered."""

    @property
    def verdict(self) -> str:
        """Word "yes" where it is at most 1, "no" where it is not, nothing without a limit."""
        if np.isnan(self.utilisation):
            return ""
        return "yes" if self.utilisation <= 1.0 else "no"


def governing(items: Iterable[AssessedItem]) -> list[AssessedItem]:
    """Item with the greatest utilisation of each name, the greatest first, those without a limit last."""
    worst: dict[str, AssessedItem] = {}
    for item in items:
        before = worst.get(item.item)
        if before is None or np.nan_to_num(item.utilisation, nan=-1.0) > before.utilisation:
            worst[item.item] = item
    return sorted(worst.values(), key=lambda item: -np.nan_to_num(item.utilisation, nan=-1.0))


def all_items(
    numbers: AssessmentNumbers,
    settings: AssessmentSettings,
    loads: list[CaseLoads],
    stresses: list[ShoeStress],
    fatigue: ShoeFatigue | None,
) -> list[AssessedItem]:
    """Items of all load cases."""
    items = [
        item
        for row in loads
        for kind in (_pressure, _tipping, _pull, _chain, _pins, _rollers)
        for item in kind(numbers, row, settings)
    ]
    items += _shoe(loads, stresses, settings)
    if fatigue is not None:
        items.append(_fatigue(numbers, settings, loads[0], fatigue))
    return [*items, *_machine(numbers, settings)]


def _item(row: CaseLoads, name: str, number: float, limit: float, unit: str, **how: object) -> AssessedItem:
    """Item of a load case, whose factor is on the number."""
    factor = float(how.pop("factor", 1.0))  # type: ignore[arg-type]
    used = factor * number / limit if limit else np.inf
    words = {name: str(value) for name, value in how.items()}
    return AssessedItem(
        name,
        row.name,
        row.group,
        number,
        limit,
        unit,
        factor,
        used,
        row.basis,
        words["formula"],
        words["source"],
        words["mark"],
    )


def _pressure(numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings) -> Iterator[AssessedItem]:
    """Pressure on even ground beside what the ground bears."""
    if row.support != "even":
        return
    allowed = numbers.ground.allowed / KILO
    how = {"source": "statics of two beams", "mark": "D"}
    angle = f"{np.degrees(row.slew):.0f} deg"
    yield _item(
        row,
        "greatest ground pressure",
        row.greatest_pressure / KILO,
        allowed,
        "kPa",
        formula=f"P / (b L) (1 + 6 e / L) or triangle, upper structure at {angle}",
        **how,
    )
    if np.isfinite(row.even_pressure):
        yield _item(
            row,
            "even equivalent of the pressure",
            row.even_pressure / KILO,
            allowed,
            "kPa",
            formula="P / (b (L - 2 e))",
            source="Meyerhof 1953",
            mark="R",
        )


def _tipping(numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings) -> Iterator[AssessedItem]:
    """Margin against tipping: what is asked for over what there is."""
    if row.support != "even":
        return
    used = row.tipping / row.margin
    yield AssessedItem(
        "tipping",
        row.name,
        row.group,
        row.margin,
        row.tipping,
        "1",
        1.0,
        used,
        row.basis,
        f"stabilising over overturning moments, {row.edge} edge; tips {np.degrees(row.tilt):.1f} deg further",
        "ISO 5049-1 (factors)",
        "R",
    )


def _pull(numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings) -> Iterator[AssessedItem]:
    """Pull that a way takes, of drive and ground."""
    if row.drive not in ("straight", "turn"):
        return
    formula = "V (sin a + f cos a) / 2"
    if row.drive == "turn":
        formula = "M / B + f V / 2, friction over both footprints"
    yield _item(
        row,
        f"pull of a track, {row.name}",
        row.needed / KILO,
        row.available / KILO,
        "kN",
        formula=f"{formula}; it {row.ends}",
        source="balance of travel",
        mark="D",
    )


def _chain(numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings) -> Iterator[AssessedItem]:
    """Tension of the chain over its breaking tension."""
    yield _item(
        row,
        "chain tension",
        row.tension / KILO,
        numbers.chain.breaking / KILO,
        "kN",
        factor=row.strength,
        formula="tension at rest + pull",
        source="statics; breaking: see inputs",
        mark="D",
    )


def _pins(numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings) -> Iterator[AssessedItem]:
    """Pin and bush of the more loaded hinge."""
    shoe = numbers.shoe
    force = row.tension / shoe.hinges * utilisation.SHARED
    check = utilisation.pin_check(row.strength * force, shoe.hinge, shoe.pin, shoe.lug)
    stress = utilisation.pin_stress(force, shoe.hinge)
    source = "EN 1993-1-8, table 3.10"
    share = f"force {utilisation.SHARED:g} T / {shoe.hinges}"
    rows = (
        ("pin, shear", stress.shear, check.shear, f"F / 2 over pi d2 / 4; {share}"),
        ("pin and lug, bearing", stress.bearing_inner, check.bearing, f"F / (d b); {share}"),
        ("pin, bending", stress.bending, check.bending, f"F (b + 4 c + 2 a) / 8 over W; {share}"),
    )
    for name, value, used, formula in rows:
        limit = row.strength * value / used
        yield AssessedItem(
            name,
            row.name,
            row.group,
            value / MEGA,
            limit / MEGA,
            "MPa",
            row.strength,
            used,
            row.basis,
            formula,
            source,
            "S",
        )
    yield AssessedItem(
        "pin, bending and shear together",
        row.name,
        row.group,
        check.together,
        1.0,
        "1",
        row.strength,
        check.together,
        row.basis,
        f"(M / M_Rd)2 + (F / F_Rd)2; {share}",
        source,
        "S",
    )
    if shoe.hinge.play:
        yield _item(
            row,
            "pin in its hole, contact",
            utilisation.hole_contact(force, shoe.hinge, YOUNGS_MODULUS) / MEGA,
            2.5 * min(shoe.pin.yield_strength, shoe.lug.yield_strength) / MEGA,
            "MPa",
            formula=f"0.591 sqrt(E F (d0 - d) / (d2 t)), service load; {share}",
            source="EN 1993-1-8, eq. 3.15",
            mark="S",
        )
    if row.group == "H":
        yield _item(
            row,
            "bush, wear",
            stress.bearing_inner / MEGA,
            shoe.wear_pressure / MEGA,
            "MPa",
            formula=f"F / (d b); {share}",
            source="dry bores of manganese 40 to 80 MPa",
            mark="R",
        )


def _rollers(
    numbers: AssessmentNumbers, row: CaseLoads, settings: AssessmentSettings
) -> Iterator[AssessedItem]:
    """Tread of the most loaded roller on its rail."""
    force = 0.5 * row.roller
    tread = numbers.rollers.tread
    contact = utilisation.roller_contact(force, tread, settings.material.yield_strength)
    words = f"Hertz, {force / KILO:.0f} kN a tread"
    source = "Johnson 1985, 4.2 and 9.1"
    stress = contact.pressure / MEGA
    yield _item(
        row,
        "roller on rail, yield below the surface",
        stress,
        stress * contact.to_yield,
        "MPa",
        factor=np.sqrt(row.strength),
        formula=f"{words}; pressure goes by the root of the force",
        source=source,
        mark="S",
    )
    if row.group != "HZS":
        yield _item(
            row,
            "roller on rail, shakedown",
            stress,
            stress * contact.to_shakedown,
            "MPa",
            factor=np.sqrt(row.strength),
            formula=f"{words}; flows in every pass beyond it",
            source=source,
            mark="S",
        )
    if row.support == "even":
        yield _item(
            row,
            "roller on rail, specific pressure",
            contact.specific / MEGA,
            SPECIFIC * (EXTREME if row.group == "HZS" else 1.0) / MEGA,
            "MPa",
            formula="F / (D b)",
            source="hardened crawler rollers 6 to 10 MPa, 1.4 times as an exception",
            mark="R",
        )


def _shoe(
    loads: list[CaseLoads], stresses: list[ShoeStress], settings: AssessmentSettings
) -> Iterator[AssessedItem]:
    """Greatest stress of the shoe by check cases."""
    by_name = {row.name: row for row in loads}
    for stress in stresses:
        yield _item(
            by_name[stress.load_case],
            "shoe, static stress",
            stress.stress / MEGA,
            settings.material.yield_strength / MEGA,
            "MPa",
            factor=by_name[stress.load_case].strength,
            formula=f"check case {stress.check_case!r}, {stress.region}",
            source="finite elements",
            mark="D",
        )


def _fatigue(
    numbers: AssessmentNumbers, settings: AssessmentSettings, row: CaseLoads, fatigue: ShoeFatigue
) -> AssessedItem:
    """Passes of rollers while the machine travels a tenth of its hours, over those that a shoe survives."""
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
        f"{fatigue.region}, amplitude {fatigue.amplitude / MEGA:.0f} MPa",
        "FKM guideline by check cases",
        "S",
    )


def _machine(numbers: AssessmentNumbers, settings: AssessmentSettings) -> Iterator[AssessedItem]:
    """Items of no load case: rated load, grades that are possible, a blocked track."""
    level = forces.gravity_on_slope(numbers.gravity, 0.0, 0.0)
    empty = numbers.work._replace(payload=0.0, digging=(0.0, 0.0), wind=0.0, slew_rate=0.0)
    if numbers.work.payload:
        acting = forces.forces_at(numbers.weights, empty, SLEW, level)
        tips = stability.tipping_load(
            acting, numbers.edges, numbers.work.reach, numbers.weights.swing_axis, SLEW
        )
        rated = settings.rated_part * float(tips.min()) / numbers.gravity
        yield AssessedItem(
            "payload over rated load",
            "lifts at its reach",
            "H",
            numbers.work.payload / KILO,
            rated / KILO,
            "t",
            1.0,
            numbers.work.payload / rated if rated else np.inf,
            FORMULA,
            f"{settings.rated_part:g} of the tipping load at {numbers.work.reach:g} m, least of all angles",
            "SAE J1097, ISO 10567",
            "S",
        )
    drive = 2.0 * numbers.drive.pull
    ground = numbers.ground
    grades = {
        "grade that the drive climbs": travel.greatest_slope_by_drive(drive, numbers.weight, ground.rolling),
        "grade that the ground bears": travel.greatest_slope_by_traction(ground.friction, ground.rolling),
    }
    for name, angle in grades.items():
        possible = float(np.tan(angle)) if angle < 1.5 else np.inf
        wanted = float(np.tan(numbers.grade))
        used = wanted / possible if possible > 0.0 else np.inf
        yield AssessedItem(
            f"permitted grade over {name}",
            "travels up a grade",
            "HZ",
            wanted,
            possible,
            "1",
            1.0,
            used,
            FORMULA,
            "V (sin a + f cos a) = F; tan a = mu - f",
            "balance of travel",
            "D",
        )
    yield from _information(numbers)
    if numbers.power:
        speed = numbers.chain.speed
        taken = travel.resistance(numbers.weight, 0.0, ground.rolling) * speed
        yield AssessedItem(
            "power of travel",
            "travels straight on the level",
            "H",
            taken / KILO,
            numbers.power / KILO,
            "kW",
            1.0,
            taken / numbers.power,
            FORMULA,
            "F v",
            "balance of travel",
            "D",
        )


def _information(numbers: AssessmentNumbers) -> Iterator[AssessedItem]:
    """Numbers without a limit, and that of clay where its strength is given."""
    area = numbers.footprints
    ground = numbers.ground
    if ground.undrained is not None:
        bears = pressure.bearing_capacity(ground.undrained, area)
        mean = numbers.weight / area.area
        yield AssessedItem(
            "mean pressure over what clay bears",
            "stands",
            "H",
            mean / KILO,
            bears / KILO,
            "kPa",
            SAFETY_OF_CLAY,
            SAFETY_OF_CLAY * mean / bears,
            FORMULA,
            "5.14 c_u (1 + 0.2 b / L)",
            "Prandtl and Skempton",
            "R",
        )
    rollers = numbers.rollers
    diameter = 2.0 * rollers.tread.radius
    peak = pressure.mean_maximum_pressure(
        numbers.weight, len(rollers.places), 1.0, area.width, numbers.chain.pitch, diameter
    )
    stall = numbers.drive.pull
    held = float(travel.traction(0.5 * numbers.weight, ground.friction, ground.cohesion, 0.5 * area.area))
    blocked = travel.blocked_track(stall, numbers.chain.rest, held, area.gauge)
    mean_load = 0.5 * (0.5 * numbers.weight - rollers.above_ground) / len(rollers.places)
    moment = utilisation.bending_of_shoe(mean_load, numbers.shoe.width, numbers.shoe.rail)
    rows = (
        (
            "mean maximum pressure on soft ground",
            peak / KILO,
            "kPa",
            "1.26 W / (2 n A b sqrt(p D))",
            "Rowland",
            "R",
        ),
        ("yaw moment of a blocked track", blocked.yaw_moment / KILO, "kN m", "F B / 2", "statics", "D"),
        ("push on the idler of a blocked track", blocked.idler_push / KILO, "kN", "2 T", "statics", "D"),
        ("bending moment of a shoe, mean rollers", moment / KILO, "kN m", "P (W / 4 - a)", "beam", "D"),
    )
    for name, value, unit, formula, source, mark in rows:
        group = "HZS" if "blocked" in name else "H"
        yield AssessedItem(
            name, "of no load case", group, value, np.nan, unit, 1.0, np.nan, FORMULA, formula, source, mark
        )
