"""Numbers of an assessment from a case and settings.

Formulas take these numbers and no case. Beside this module `ledger` lists values of a case, `shoe` takes its
mesh and track for the check of a shoe, and `run_forces` reads the case of a run. Positions are in the axes of
`assessment.forces`, whose origin is the middle of the rectangle below both tracks.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from exudyn_crawler.assessment import chain, grounds, travel
from exudyn_crawler.assessment.forces import MachineWeights, Work
from exudyn_crawler.assessment.pressure import Footprints, Law, law_of_sinkage
from exudyn_crawler.assessment.settings import AssessmentSettings
from exudyn_crawler.assessment.stability import Edges
from exudyn_crawler.assessment.utilisation import PartStrength, PinnedHinge, RollerTread, chain_strength
from exudyn_crawler.case import Case, CellContact, Machine, PairContact
from exudyn_crawler.case.gear.running_gear import RunningGear
from exudyn_crawler.case.parameters.pin import RADIUS as PIN_RADIUS
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.machines.datasheet import typical
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.origins import Ruled
from exudyn_crawler.results.wear.closed_form import Bends, bends_of, pin_drag
from meshes.geometry import PITCH, ShoeDimensions

RISE = 5e-3
"""Largest height, m, of the lowest pins of a grounded end wheel above those under the rollers."""
HEAVIEST = 50.0
"""Greatest pressure in the table of the ground's sinkage, in mean pressures of the machine."""
HEAVY = 400e3
"""Mass, kg, above which a machine without a datasheet counts as a mining shovel, with a smaller pull over its
weight."""
PINS = {"diameter": 2.0 * PIN_RADIUS, "inner": 0.50, "outer": 0.20, "gap": 0.005}
"""Dimensions of the pins, fraction of the pitch: diameter 0.20 to 0.22 (remembered); the others assumed,
since no source has them."""

WORK_TO_STATE = ("payload", "reach", "digging", "wind_area")
"""Work settings that do not follow from the machine."""


class RollerNumbers(NamedTuple):
    """Lower rollers of a track."""

    places: np.ndarray
    """X of the rollers from the middle of the rectangle, (rollers,), m."""
    groups: tuple[tuple[int, ...], ...]
    """Roller numbers, from 0, that share their load: two of a bogie, or one alone."""
    tread: RollerTread
    grounded_shoe_weight: float
    """Weight of one track's grounded shoes, N: part of the ground load that no roller carries."""

    @property
    def supports(self) -> np.ndarray:
        """X of the supports of the frame (rollers and bogies), (groups,), m."""
        return np.array([self.places[list(group)].mean() for group in self.groups])

    @property
    def stiffness(self) -> np.ndarray:
        """Stiffness of these supports over that of a roller, (groups,)."""
        return np.array([len(group) for group in self.groups], dtype=float)

    def shared(self, loads: np.ndarray) -> np.ndarray:
        """Return loads (..., rollers) from loads (..., groups), N; a bogie's rollers share its load."""
        rollers = np.zeros((*loads.shape[:-1], len(self.places)))
        for number, group in enumerate(self.groups):
            rollers[..., list(group)] = loads[..., [number]] / len(group)
        return rollers


class ChainNumbers(NamedTuple):
    """Chain of one track."""

    weight: float
    """N/m."""
    pitch: float
    """m."""
    shoes: int
    """Number of shoes of one track."""
    rest: float
    """Tension at rest, N."""
    breaking: float
    """N."""
    speed: float
    """Greatest speed of the case, m/s."""
    idler_drag: float
    """Resistance of an idler that both runs pull at rest, N."""
    pin_drag: float
    """Resistance by the losses of the pins with the tension at rest, N."""
    rises: tuple[float, float]
    """Rise over run of the chain from the outer roller to tumbler and to idler."""
    bends: Bends
    """Angles by which its hinges bend on the tumbler and on the idler, rad."""


class GroundNumbers(NamedTuple):
    """Ground below the tracks."""

    name: str
    allowed: float
    """Allowed pressure, Pa; NaN if unknown."""
    friction: float
    rolling: float
    cohesion: float
    """Pa."""
    undrained: float | None
    """Undrained strength of clay, Pa."""
    compaction: travel.Compaction | None
    """Compaction law of the case's ground, if the case has one."""
    law: Law | None
    """Pressure law of a case with cells; None: linear."""
    law_name: str


class ShoeNumbers(NamedTuple):
    """Shoe and its hinges."""

    mass: float
    width: float
    rail: float
    """Distance of the rails' middles from the shoe's middle, m."""
    hinge: PinnedHinge
    hinges: int
    pin: PartStrength
    lug: PartStrength
    wear_pressure: float
    ready: bool
    """True for the ready shoe, which has meshes."""


class AssessmentNumbers(NamedTuple):
    """Inputs of all formulas."""

    gravity: float
    footprints: Footprints
    fewest: Footprints
    """Footprints with the least number of whole shoes below the rollers."""
    edges: Edges
    weights: MachineWeights
    work: Work
    least_reach: float
    grade: float
    """rad."""
    slope: float
    """Side slope, rad."""
    rollers: RollerNumbers
    chain: ChainNumbers
    shoe: ShoeNumbers
    ground: GroundNumbers
    drive: travel.TrackDrive
    power: float | None
    """Power of both tracks, W."""
    ruled: dict[str, Ruled]
    """Derived numbers with their rules, by settings key or by a name without a setting."""
    not_stated: frozenset[str] = frozenset()
    """Keys of settings without a value, stated or derived from the machine."""

    @property
    def weight(self) -> float:
        """Weight of the machine without payload, N."""
        return self.gravity * (self.weights.lower_mass + self.weights.upper_mass)

    @property
    def empty(self) -> Work:
        """Work of the machine at rest without payload, bank, wind and slewing."""
        return self.work._replace(payload=0.0, digging=(0.0, 0.0), wind=0.0, slew_rate=0.0)

    @property
    def resistance(self) -> travel.TravelResistance:
        """Resistance to straight travel."""
        ground = self.ground
        return travel.TravelResistance(
            ground.rolling, self.chain.idler_drag, self.chain.pin_drag, self.footprints, ground.compaction
        )


def numbers_of(case: Case, settings: AssessmentSettings, sheet: Datasheet | None = None) -> AssessmentNumbers:
    """Return the numbers of a machine on two closed tracks.

    `settings` give what the case does not have, and `sheet`, from which the case is, the kind of machine.
    Raise `ValueError` if the case has no machine.
    """
    gear = case.gear
    if not isinstance(gear, Machine):
        raise ValueError(f"gear.kind must be 'machine', which stands on two tracks, got {gear.kind!r}")
    gravity = case.gravity
    pitch = gear.chain_pitch(case.track)
    ends = _end_wheels(case, gear, pitch)
    stand = _stands(gear, ends, pitch)
    length = settings.length or stand.length
    least = settings.length or stand.least_length
    gauge = gear.car_body.gauge
    width = case.shoe.width
    footprints = Footprints(gauge, length, width)
    middle = 0.5 * (stand.rear + stand.front)
    side = 0.5 * gauge if settings.side_edges == "middle" else 0.5 * (gauge + width)
    edges = Edges(stand.front - middle, middle - stand.rear, side, side)
    weights = _weights(case, gear, middle)
    work, least_reach = _work(settings)
    rollers = _rollers(case, gear, middle, length, pitch)
    shoe = _shoe(case, settings, pitch)
    of_chain, tensions = _chain(case, gear, settings, shoe, ends)
    ground, of_ground = _ground(case, settings, footprints, gravity, weights)
    drive, torque = _drive(case, gear, settings, weights.lower_mass + weights.upper_mass, sheet)
    ruled = {
        "length": Ruled(stand.length, "", stand.standing),
        "fewest.length": Ruled(least, ""),
        "edges.front": Ruled(edges.front, "", stand.standing),
        "edges.side": Ruled(side, settings.side_edges),
        "weights.lower_mass": Ruled(weights.lower_mass, ""),
        "weights.lower_com": Ruled(weights.lower_com, ""),
        "work.least_reach": Ruled(least_reach, ""),
        "rollers.grounded_shoe_weight": Ruled(rollers.grounded_shoe_weight, ""),
        "chain.weight": Ruled(of_chain.weight, ""),
        "drive.radius": Ruled(drive.radius, ""),
        "drive.torque": torque,
        **{f"pins.{name}": Ruled(size, "ready shoe" if shoe.ready else "") for name, size in _sizes(shoe)},
        **tensions,
        **of_ground,
    }
    return AssessmentNumbers(
        gravity=gravity,
        footprints=footprints,
        fewest=footprints._replace(length=least),
        edges=edges,
        weights=weights,
        work=work,
        least_reach=least_reach,
        grade=math.atan(settings.work.grade),
        slope=math.atan(settings.work.side_slope),
        rollers=rollers,
        shoe=shoe,
        chain=of_chain,
        ground=ground,
        drive=drive,
        power=settings.drive.power,
        ruled=ruled,
        not_stated=frozenset(
            f"work.{name}" for name in WORK_TO_STATE if getattr(settings.work, name) is None
        ),
    )


def _chosen(stated: float | None, derived: Ruled) -> float:
    """Return a stated value, or else the derived one."""
    return float(derived.value) if stated is None else stated


def _sizes(shoe: ShoeNumbers) -> list[tuple[str, float]]:
    """Return the sizes of a hinge joint by the names of the settings."""
    return [(name, getattr(shoe.hinge, name)) for name in PINS]


class _Stand(NamedTuple):
    """Length of a track on the ground, in the machine's axes, m."""

    rear: float
    """X of the edges of tipping, rear and front."""
    front: float
    length: float
    least_length: float
    standing: str
    """Names of the grounded end wheels."""


class _EndWheel(NamedTuple):
    """Tumbler or idler, by the pins that it carries, in the machine's axes, m."""

    name: str
    x: float
    lift: float
    """Height of its lowest pins above those under the rollers."""


def _end_wheels(case: Case, gear: Machine, pitch: float) -> tuple[_EndWheel, _EndWheel]:
    """Return tumbler and idler, with the pins on the belt that the chain is assembled along."""
    rails = case.shoe.roller_path
    rise = rails.height - case.track.pin_height
    lowest = -(gear.roller_radius + rise)
    tumbler_x, tumbler_z = gear.tumbler.place
    (idler_x, idler_z), on_idler = gear.idler_circle(0.0, rise, pitch)
    return (
        _EndWheel("tumbler", tumbler_x, tumbler_z - gear.tumbler.radius(case.track.pitch) - lowest),
        _EndWheel("idler", idler_x, idler_z - on_idler - lowest),
    )


def _stands(gear: Machine, ends: tuple[_EndWheel, _EndWheel], pitch: float) -> _Stand:
    """Return the length of a track on the ground: between grounded end wheels, or below the rollers."""
    standing = [wheel for wheel in ends if wheel.lift <= RISE]
    rear = min([gear.rollers[0], *(wheel.x for wheel in standing)])
    front = max([gear.rollers[-1], *(wheel.x for wheel in standing)])
    span = front - rear
    # a shoe bears on all of its length until its roller has left it; beyond an end wheel it does not bear
    beyond = pitch * (1.0 - 0.5 * len(standing))
    whole = pitch * (math.floor(span / pitch + 1e-9) + 1)
    names = " and ".join(wheel.name for wheel in standing) or "neither tumbler nor idler"
    words = f"{names} as low as the rollers (within {1e3 * RISE:g} mm)"
    least = span + beyond if standing else min(span + beyond, whole)
    return _Stand(rear, front, span + beyond, least, words)


def _weights(case: Case, gear: Machine, middle: float) -> MachineWeights:
    """Return masses and centres of the slewing and the fixed parts."""
    start = gear.frame_start(case)
    shift = np.array([-middle, 0.0, start[2]])
    body = gear.car_body
    fixed = [(part.mass, part.com) for part in gear.frame_parts[:-1]]
    tumblers = gear.tumbler_reference(case)[:, :3] - start
    fixed += [(gear.tumbler.mass, place) for place in tumblers]
    if (slide := gear.idler.slide) is not None:
        fixed += [(slide.mass, place) for place in gear.idler_reference(case)[:, :3] - start]
    for parts, reference in ((gear.bogies, gear.bogie_reference), (gear.arms, gear.arm_reference)):
        places = reference(case)[:, :3] - start
        fixed += zip([part.mass for part in parts] * gear.tracks, places, strict=True)
    shoes = gear.shoe_reference(case)[:, :3] - start
    fixed.append((case.shoe.mass * len(shoes), shoes.mean(axis=0)))
    mass = sum(part for part, _ in fixed)
    com = np.sum([part * place for part, place in fixed], axis=0) / mass + shift
    ahead, aside, above = body.upper_com
    place = (ahead - body.swing_axis, aside, above + float(start[2]))
    return MachineWeights(mass, tuple(com.tolist()), body.upper_mass, place, body.swing_axis - middle)


def _work(settings: AssessmentSettings) -> tuple[Work, float]:
    """Return the work of the upper structure and its least reach."""
    asked = settings.work
    reach = asked.reach or 0.0
    wind = asked.wind_pressure * (asked.wind_area or 0.0)
    work = Work(
        asked.payload or 0.0,
        reach,
        asked.height,
        asked.digging or (0.0, 0.0),
        wind,
        asked.wind_height,
        0.0,
        asked.slew_rate,
    )
    return work, 0.5 * reach if asked.least_reach is None else asked.least_reach


def _rollers(case: Case, gear: Machine, middle: float, length: float, pitch: float) -> RollerNumbers:
    places = np.array(gear.rollers) - middle
    pairs = {bogie.rollers[0] - 1: tuple(number - 1 for number in bogie.rollers) for bogie in gear.bogies}
    second = {pair[1] for pair in pairs.values()}
    groups = tuple(pairs.get(number, (number,)) for number in range(len(places)) if number not in second)
    lying = length / pitch * case.shoe.mass * case.gravity
    return RollerNumbers(places, groups, RollerTread(gear.roller_radius, gear.tread_width), lying)


def _shoe(case: Case, settings: AssessmentSettings, pitch: float) -> ShoeNumbers:
    """Return the shoe with its hinges: those of the ready shoe, or sizes by the pitch for another shoe."""
    rails = case.shoe.roller_path
    ready = abs(case.track.pitch - PITCH) < 1e-6 and abs(case.shoe.width - ShoeDimensions.width) < 1e-6
    own = {
        "diameter": 2.0 * ShoeDimensions.bore_radius,
        "inner": ShoeDimensions.rear_lug_width,
        "outer": ShoeDimensions.cheek_width,
        "gap": ShoeDimensions.side_clearance,
    }
    usual = own if ready else {name: size * pitch for name, size in PINS.items()}
    asked = settings.pins
    stated = {name: getattr(asked, name) for name in PINS if getattr(asked, name) is not None}
    pin = PartStrength(asked.tensile_strength, asked.yield_strength)
    lug = PartStrength(settings.material.tensile_strength, settings.material.yield_strength)
    rail = 0.5 * (rails.left - rails.right)
    hinge = PinnedHinge(**(usual | stated), play=asked.play)
    return ShoeNumbers(case.shoe.mass, case.shoe.width, rail, hinge, 2, pin, lug, asked.wear_pressure, ready)


def _chain(
    case: Case,
    gear: Machine,
    settings: AssessmentSettings,
    shoe: ShoeNumbers,
    ends: tuple[_EndWheel, _EndWheel],
) -> tuple[ChainNumbers, dict[str, Ruled]]:
    """Return the chain with its rest tension (sag or pretension), its breaking tension, and their rules."""
    rails = case.shoe.roller_path
    pitch = gear.chain_pitch(case.track)
    weight = shoe.mass * case.gravity / pitch
    idler = gear.idler
    if idler.pretension is not None:
        of_rest = Ruled(idler.pretension, "gear.idler.pretension")
    elif idler.tensioner is not None:
        of_rest = Ruled(0.5 * idler.tensioner.preload, "tensioner")
    else:
        span = float(gear.upper_spans[-1])
        tension = chain.tension_of_sag(weight, span, gear.wanted_sag, rails.front - rails.rear)
        of_rest = Ruled(tension, "sag", f"l {span:.4g} m, f {1e3 * gear.wanted_sag:.4g} mm")
    if gear.tension_limit:
        of_breaking = Ruled(gear.tension_limit, "gear.tension_limit")
    else:
        of_breaking = Ruled(chain_strength(shoe.hinge, shoe.hinges, shoe.pin), "pins")
    drive = settings.drive
    rest = _chosen(drive.rest_tension, of_rest)
    breaking = _chosen(drive.breaking_tension, of_breaking)
    speed = max(abs(value) for value in case.drive.speed.values)
    drag = 2.0 * gear.rolling_resistance * rest
    runs = gear.rollers[0] - ends[0].x, ends[1].x - gear.rollers[-1]
    rises = tuple(max(wheel.lift, 0.0) / run for wheel, run in zip(ends, runs, strict=True))
    shoes = case.track.shoe_count // case.gear.tracks
    bends = bends_of(case)
    of_pins = pin_drag(case, rest)
    numbers = ChainNumbers(
        weight, pitch, shoes, rest, breaking, speed, drag, of_pins, (rises[0], rises[1]), bends
    )
    return numbers, {"drive.rest_tension": of_rest, "drive.breaking_tension": of_breaking}


def _of_case(case: Case) -> tuple[str, dict[str, Ruled]]:
    """Return name, sliding friction, rolling resistance and cohesion of a case's ground."""
    contact = case.contact
    cohesion = Ruled(0.0, "friction alone")
    name = "ground of the case"
    if isinstance(contact, PairContact):
        friction = Ruled(contact.dynamic_friction, "contact.dynamic_friction")
    elif not isinstance(contact, CellContact):
        friction = Ruled(contact.friction, "contact.friction")
    else:
        law: Any = contact.law
        name = f"{name}, {law.model}"
        if isinstance(law, BekkerSoil):
            slope = math.tan(math.radians(law.friction_angle))
            friction = Ruled(slope, "contact.law.friction_angle")
            cohesion = Ruled(law.cohesion, "contact.law.cohesion")
        else:
            friction = Ruled(float(law.friction), "contact.law.friction")
    rolling = Ruled(case.part(RunningGear).rolling_resistance, "gear.rolling_resistance")
    return name, {"friction": friction, "rolling": rolling, "cohesion": cohesion}


def _ground(
    case: Case,
    settings: AssessmentSettings,
    footprints: Footprints,
    gravity: float,
    weights: MachineWeights,
) -> tuple[GroundNumbers, dict[str, Ruled]]:
    """Return the named ground or that of the case, with single values of the settings, and its rules."""
    asked = settings.ground
    law: Law | None = None
    law_name = "linear"
    compaction = None
    allowed = asked.allowed_pressure
    if asked.name is not None:
        named = grounds.ground(asked.name)
        name = named.name
        how = f"{name}: {named.source} [{named.mark}]"
        keys = ("friction", "rolling", "cohesion", "allowed_pressure")
        values = {key: Ruled(getattr(named, key), "named ground", how) for key in keys}
        allowed = named.allowed_pressure if allowed is None else allowed
    else:
        name, values = _of_case(case)
        if isinstance(case.contact, CellContact):
            of_cells = case.contact.law
            least = min(footprints.width, footprints.length)
            mean = gravity * (weights.lower_mass + weights.upper_mass) / footprints.area
            law = law_of_sinkage(lambda pressure: of_cells.sinkage(pressure, least), HEAVIEST * mean)
            law_name = of_cells.model
            if isinstance(of_cells, BekkerSoil):
                compaction = travel.Compaction(of_cells.k_c, of_cells.k_phi, of_cells.exponent)
    if asked.friction is not None:
        # a given traction over load includes the cohesion
        values["cohesion"] = Ruled(0.0, "given friction")
    friction, rolling, cohesion = (
        _chosen(getattr(asked, key), values[key]) for key in ("friction", "rolling", "cohesion")
    )
    numbers = GroundNumbers(
        name,
        math.nan if allowed is None else allowed,
        friction,
        rolling,
        cohesion,
        asked.undrained_strength,
        compaction,
        law,
        law_name,
    )
    return numbers, {f"ground.{key}": value for key, value in values.items()}


def _pull_share(mass: float, sheet: Datasheet | None) -> tuple[float, str]:
    """Return the greatest pull of a machine (kg) over its weight, and the source of this typical value."""
    if sheet is not None and (own := sheet.typical.pull_share) is not None:
        return own, f"{own:g}, typical.pull_share of the datasheet"
    kind = sheet.kind if sheet is not None else "shovel" if mass > HEAVY else ""
    row = typical.row_of("pull_share", kind)
    return row.value, f"{row.value:g} of {row.of or 'other machine'}s ({row.source}; {row.known})"


def _drive(
    case: Case, gear: Machine, settings: AssessmentSettings, mass: float, sheet: Datasheet | None
) -> tuple[travel.TrackDrive, Ruled]:
    """Return the drive of one track, and the rule of its torque for settings without one."""
    radius = gear.travel_per_angle(case.track)
    asked = settings.drive
    if gear.torque_limit is not None:
        torque = Ruled(gear.torque_limit, "gear.torque_limit")
    else:
        share, source = _pull_share(mass, sheet)
        torque = Ruled(0.5 * share * mass * case.gravity * radius / asked.efficiency, "pull", source)
    return travel.TrackDrive(_chosen(asked.torque, torque), radius, asked.efficiency), torque
