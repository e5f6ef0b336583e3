"""Items of a machine as a whole: pressure, tipping, travel, rated load and grades."""

from collections.abc import Callable, Iterator

import numpy as np
from scipy.optimize import brentq

from exudyn_crawler.assessment import forces, pressure, stability, travel, utilisation
from exudyn_crawler.assessment.forces import Numbers
from exudyn_crawler.assessment.inputs import AssessmentNumbers
from exudyn_crawler.assessment.items import BALANCE, KILO, STATICS, AssessedItem, Source, case_item
from exudyn_crawler.assessment.settings import AssessmentSettings
from exudyn_crawler.assessment.states import IN_LINE, SLEW, CaseLoads
from exudyn_crawler.results.history.catalogue import LOADED

BEAMS = Source("statics of two beams", "D")
MEYERHOF = Source("Meyerhof 1953", "R")
BY_LOAD = Source("friction by load (convention)", "D")
RATED = Source("SAE J1097, ISO 10567", "S")
CLAY = Source("Prandtl and Skempton", "R")
ROWLAND = "1.26 W / (2 n A b sqrt(p D))"
IDLER = "2 T, T at rest and of the stalled drive"
SLIGHT = 1e-6
"""Friction coefficient that counts as zero."""
SAFETY_OF_CLAY = 2.0
"""Safety factor against failure of the ground, 2 to 3 (remembered)."""


def pressure_items(
    numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings
) -> Iterator[AssessedItem]:
    """Yield the pressure on even ground against the allowed pressure."""
    if row.support != "even":
        return
    allowed = numbers.ground.allowed / KILO
    needs = row.missing_of_loads
    if np.isnan(allowed):
        needs = (*needs, "ground.name or ground.allowed_pressure")
    whole = row.carries >= numbers.fewest.length * (1.0 - 1e-9)
    shape = "P / (b L) (1 + 6 e / L)" if whole else "2 P / (3 b (L / 2 - e)), a triangle"
    yield case_item(
        row,
        "greatest ground pressure",
        row.greatest_pressure / KILO,
        allowed,
        "kPa",
        f"{shape}, upper structure at {np.degrees(row.slew):.0f} deg",
        BEAMS,
        of_run="greatest normal force of a shoe over pitch x width",
        needs=needs,
    )
    if np.isfinite(row.even_pressure):
        even = row.even_pressure / KILO
        name, formula = "even equivalent of the pressure", "P / (b (L - 2 e))"
        yield case_item(row, name, even, allowed, "kPa", formula, MEYERHOF, needs=needs)
    if np.isfinite(row.mean_pressure):
        mean = row.mean_pressure / KILO
        name = "mean pressure of the loaded shoes"
        formula = f"mean of the shoes with {LOADED:g} of the greatest force and more, over pitch x width"
        yield case_item(row, name, mean, allowed, "kPa", formula, Source(row.basis, "D"), needs=needs)


def tipping_items(
    numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings
) -> Iterator[AssessedItem]:
    """Yield the required margin against tipping over the margin of the load case."""
    if row.support != "even":
        return
    moments = f"stabilising over overturning moments, {row.edge} edge"
    tips = f"tips {np.degrees(row.tilt):.1f} deg further about the {row.tilt_edge} edge"
    source = Source(f"statics; limit: {row.factors}", "D")
    yield AssessedItem(
        "tipping",
        row.name,
        row.group,
        row.margin,
        row.tipping,
        "1",
        f"{moments}; {tips}",
        source,
        needs=row.missing,
        is_least=True,
    )


def pull_items(numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings) -> Iterator[AssessedItem]:
    """Yield the pull needed for travel against the pull of drive and ground."""
    if row.drive not in ("straight", "turn"):
        return
    formula = f"R / 2, R = {numbers.resistance.formula}"
    if row.drive == "turn":
        formula = f"M / B + {formula}, M of the shear strength over both footprints"
    ends = f"; it {row.ends}"
    yield case_item(
        row,
        f"pull of a track, {row.name}",
        row.needed / KILO,
        row.available / KILO,
        "kN",
        formula + ends,
        BALANCE,
        of_run=f"mean torque of a tumbler x efficiency over its radius{ends}",
        needs=row.missing_of_travel,
    )


def across_items(numbers: AssessmentNumbers, row: CaseLoads, _: AssessmentSettings) -> Iterator[AssessedItem]:
    """Yield the lateral force on a shoe; no limit found in any source."""
    if row.support != "even" or not row.side_force:
        return
    cohesion = "c + " if numbers.ground.cohesion else ""
    strength = f"{cohesion}friction x greatest pressure"
    formula = f"({strength}) x pitch x width"
    if row.drive != "turn":
        formula = f"push aside over weight x greatest pressure, at most {strength}, x pitch x width"
    yield case_item(
        row,
        "force across a shoe",
        row.side_force / KILO,
        np.nan,
        "kN",
        formula,
        BY_LOAD,
        of_run="greatest friction across a shoe",
        needs=row.missing_of_loads,
    )


def machine_items(numbers: AssessmentNumbers, settings: AssessmentSettings) -> Iterator[AssessedItem]:
    """Yield the items outside the load cases: rated load, grades, power, turn and blocked track."""
    yield from _rated_load(numbers, settings)
    yield from _grades(numbers)
    yield from _turn(numbers)
    yield from _information(numbers)
    if numbers.power:
        taken = float(numbers.resistance.on_grade(numbers.weight, 0.0)) * numbers.chain.speed
        name = "power of travel", "travels straight on the level", "H"
        formula = f"R v, R = {numbers.resistance.formula}"
        yield AssessedItem(*name, taken / KILO, numbers.power / KILO, "kW", formula, BALANCE)


def _rated_load(numbers: AssessmentNumbers, settings: AssessmentSettings) -> Iterator[AssessedItem]:
    """Yield the payload over the rated load at its reach; no item if the machine lifts no payload."""
    needs = tuple(key for key in ("work.payload", "work.reach") if key in numbers.not_stated)
    if "work.payload" not in needs and not numbers.work.payload:
        return
    payload = np.nan if "work.payload" in needs else numbers.work.payload
    rated = np.nan
    words = "the tipping load at the reach"
    if "work.reach" not in needs:
        words = f"the tipping load at {numbers.work.reach:g} m, least of all angles"
        level = forces.gravity_on_slope(numbers.gravity, 0.0, 0.0)
        acting = forces.forces_at(numbers.weights, numbers.empty, SLEW, level)
        tips = stability.tipping_load(
            acting, numbers.edges, numbers.work.reach, numbers.weights.swing_axis, SLEW
        )
        rated = settings.rated_part * float(tips.min()) / numbers.gravity
    name = "payload over rated load", "lifts at its reach", "H"
    formula = f"{settings.rated_part:g} of {words}"
    yield AssessedItem(*name, payload / KILO, rated / KILO, "t", formula, RATED, needs=needs)


def _grades(numbers: AssessmentNumbers) -> Iterator[AssessedItem]:
    """Yield the permitted grade over the grades that the drive can climb and the ground can bear."""
    ground = numbers.ground
    drive = 2.0 * numbers.drive.pull
    resistance = numbers.resistance
    area = numbers.footprints.area
    bears = "c A + mu V cos a" if ground.cohesion else "mu V cos a"
    kinds: dict[str, tuple[Callable[[float], Numbers], str]] = {
        "the drive climbs": (lambda _: drive, "2 T eta / r"),
        "the ground bears": (
            lambda load: travel.traction(load, ground.friction, ground.cohesion, area),
            bears,
        ),
    }
    for does, (available, words) in kinds.items():
        angle = travel.greatest_slope(resistance, numbers.weight, available)
        possible = float(np.tan(angle)) if angle < 0.5 * np.pi else np.inf
        name = f"permitted grade over grade that {does}", "travels up a grade", "HZ"
        formula = f"{resistance.formula} = {words}"
        yield AssessedItem(*name, float(np.tan(numbers.grade)), possible, "1", formula, BALANCE)


def _turn(numbers: AssessmentNumbers) -> Iterator[AssessedItem]:
    """Yield the ground friction over the friction at which a turn on the spot stalls the drive."""
    level = forces.gravity_on_slope(numbers.gravity, 0.0, 0.0)
    stands = forces.resultant(forces.forces_at(numbers.weights, numbers.empty, IN_LINE, level))
    place = int(np.argmin(np.abs(stands.ahead)))
    ahead = float(stands.ahead[place])
    aside = float(stands.aside[place])
    cohesion = numbers.ground.cohesion

    def pull(friction: float) -> float:
        return travel.turn_of_footprints(
            numbers.weight, numbers.footprints, friction, ahead, aside, cohesion
        ).pull

    spare = numbers.drive.pull - 0.5 * float(numbers.resistance.on_grade(numbers.weight, 0.0))
    try:
        turns = _stalling_friction(pull, max(spare, 0.0), cohesion)
    except ValueError:
        return  # the lighter track slips at any friction
    name = "friction over that at which a turn on the spot stalls", "turns on the spot", "HZ"
    balance = f"M / B = T eta / r - R / 2, R = {numbers.resistance.formula}"
    formula = f"{balance}; any radius asks for the same friction"
    yield AssessedItem(*name, numbers.ground.friction, turns, "1", formula, BALANCE)


def _stalling_friction(pull: Callable[[float], float], spare: float, cohesion: float) -> float:
    """Return the friction at which a turn takes a spare pull (N); 0 if cohesion alone takes more.

    The pull is proportional to the friction without cohesion.
    """
    if not cohesion:
        return spare / pull(1.0)
    if pull(SLIGHT) >= spare:
        return 0.0
    high = 1.0
    while pull(high) < spare:
        high *= 2.0
    return float(brentq(lambda friction: pull(friction) - spare, SLIGHT, high, rtol=1e-9))


def _information(numbers: AssessmentNumbers) -> Iterator[AssessedItem]:
    """Yield numbers without a limit, and the bearing capacity of clay if its strength is given."""
    area = numbers.footprints
    ground = numbers.ground
    if ground.undrained is not None:
        bears = pressure.bearing_capacity(ground.undrained, area)
        mean = numbers.weight / area.area
        name = "mean pressure over bearing capacity of clay", "stands", "H"
        formula = "5.14 c_u (1 + 0.2 b / L)"
        factor = SAFETY_OF_CLAY, "2 to 3 against failure of the ground [R]"
        yield AssessedItem(*name, mean / KILO, bears / KILO, "kPa", formula, CLAY, *factor)
    rollers = numbers.rollers
    diameter = 2.0 * rollers.tread.radius
    peak = pressure.mean_maximum_pressure(
        numbers.weight, len(rollers.places), 1.0, area.width, numbers.chain.pitch, diameter
    )
    stall = numbers.drive.pull
    held = float(travel.traction(0.5 * numbers.weight, ground.friction, ground.cohesion, 0.5 * area.area))
    blocked = travel.blocked_track(stall, numbers.chain.rest, held, area.gauge)
    mean_load = 0.5 * (0.5 * numbers.weight - rollers.grounded_shoe_weight) / len(rollers.places)
    moment = utilisation.bending_of_shoe(mean_load, numbers.shoe.width, numbers.shoe.rail)
    push = "F B / 2, F the lesser of drive and ground"
    rows = (
        ("mean maximum pressure on soft ground", "H", peak, "kPa", ROWLAND, Source("Rowland", "R")),
        ("yaw moment of a blocked track", "HZS", blocked.yaw_moment, "kN m", push, STATICS),
        ("push on the idler of a blocked track", "HZS", blocked.idler_push, "kN", IDLER, STATICS),
        ("bending moment of a shoe, mean rollers", "H", moment, "kN m", "P (W / 4 - a)", Source("beam", "D")),
    )
    for item, group, value, unit, formula, source in rows:
        yield AssessedItem(item, "of no load case", group, value / KILO, np.nan, unit, formula, source)
