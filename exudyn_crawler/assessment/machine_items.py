"""Items of a machine as a whole: pressure, tipping, travel, what it lifts and climbs."""

from collections.abc import Iterator

import numpy as np

from exudyn_crawler.assessment import forces, pressure, stability, travel, utilisation
from exudyn_crawler.assessment.inputs import AssessmentNumbers
from exudyn_crawler.assessment.items import KILO, AssessedItem, by_run, case_item
from exudyn_crawler.assessment.settings import AssessmentSettings
from exudyn_crawler.assessment.states import FORMULA, IN_LINE, SLEW, CaseLoads

PULL_STRAIGHT = "V (sin a + f cos a) / 2 + 2 T f of the idler"
SAFETY_OF_CLAY = 2.0
"""Against failure of the ground, 2 to 3 (remembered)."""


def pressure_items(
    numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings
) -> Iterator[AssessedItem]:
    """Pressure on even ground beside what the ground bears."""
    if row.support != "even":
        return
    allowed = numbers.ground.allowed / KILO
    angle = f"{np.degrees(row.slew):.0f} deg"
    beams = f"P / (b L) (1 + 6 e / L) or triangle, upper structure at {angle}"
    yield case_item(
        row,
        "greatest ground pressure",
        row.greatest_pressure / KILO,
        allowed,
        "kPa",
        formula=by_run(row, beams, "greatest normal force of a shoe over pitch x width"),
        source=by_run(row, "statics of two beams", row.basis),
        mark="D",
    )
    if np.isfinite(row.even_pressure):
        yield case_item(
            row,
            "even equivalent of the pressure",
            row.even_pressure / KILO,
            allowed,
            "kPa",
            formula=by_run(row, "P / (b (L - 2 e))", "mean of the shoes that stand"),
            source=by_run(row, "Meyerhof 1953", row.basis),
            mark=by_run(row, "R", "D"),
        )


def tipping_items(
    numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings
) -> Iterator[AssessedItem]:
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
        FORMULA,
        f"stabilising over overturning moments, {row.edge} edge; tips {np.degrees(row.tilt):.1f} deg further",
        f"statics; limit: {row.factors}",
        "D",
    )


def pull_items(numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings) -> Iterator[AssessedItem]:
    """Pull that travel takes, of drive and ground."""
    if row.drive not in ("straight", "turn"):
        return
    formula = "M / B + f V / 2, friction over both footprints" if row.drive == "turn" else PULL_STRAIGHT
    formula = by_run(row, formula, "mean torque of a tumbler x efficiency over its radius")
    yield case_item(
        row,
        f"pull of a track, {row.name}",
        row.needed / KILO,
        row.available / KILO,
        "kN",
        formula=f"{formula}; it {row.ends}",
        source=by_run(row, "balance of travel", row.basis),
        mark="D",
    )


def across_items(numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings) -> Iterator[AssessedItem]:
    """Force across a shoe, which no source that could be read limits."""
    if row.support != "even" or not row.side_force:
        return
    turn = "friction x greatest pressure x pitch x width"
    aside = "push aside over weight, up to the friction, x greatest pressure x pitch x width"
    formula = by_run(row, turn if row.drive == "turn" else aside, "greatest friction across a shoe")
    yield AssessedItem(
        "force across a shoe",
        row.name,
        row.group,
        row.side_force / KILO,
        np.nan,
        "kN",
        1.0,
        np.nan,
        row.basis,
        formula,
        by_run(row, "friction by load (convention)", row.basis),
        "D",
    )


def machine_items(numbers: AssessmentNumbers, settings: AssessmentSettings) -> Iterator[AssessedItem]:
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
    yield from _turn(numbers)
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


def _turn(numbers: AssessmentNumbers) -> Iterator[AssessedItem]:
    """Friction of the ground over that up to which the drive turns the machine on the spot, where it turns.

    The pull of a turn goes with the friction, what wheels and chain take does not.
    """
    level = forces.gravity_on_slope(numbers.gravity, 0.0, 0.0)
    empty = numbers.work._replace(payload=0.0, digging=(0.0, 0.0), wind=0.0, slew_rate=0.0)
    stands = forces.resultant(forces.forces_at(numbers.weights, empty, IN_LINE, level))
    place = int(np.argmin(np.abs(stands.ahead)))
    ahead = float(stands.ahead[place])
    aside = float(stands.aside[place])
    try:
        pull = travel.turn_of_footprints(numbers.weight, numbers.footprints, 1.0, ahead, aside).pull
    except ValueError:
        return  # the lighter track slips whatever the friction is
    straight = 0.5 * travel.resistance(numbers.weight, 0.0, numbers.ground.rolling) + numbers.chain.idler_drag
    turns = max(numbers.drive.pull - straight, 0.0) / pull
    yield AssessedItem(
        "friction over that at which a turn on the spot stalls",
        "turns on the spot",
        "HZ",
        numbers.ground.friction,
        turns,
        "1",
        1.0,
        numbers.ground.friction / turns if turns else np.inf,
        FORMULA,
        "(drive - V f / 2 - 2 T f) B / M at a friction of 1; any radius asks for the same friction",
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
            "2 to 3 against failure of the ground [R]",
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
