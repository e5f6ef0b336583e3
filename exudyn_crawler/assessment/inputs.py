"""Numbers of an assessment from a case and settings, each with where it comes from.

Nothing else of the room reads a case. Places are in the axes of `assessment.forces`: from the middle of the
rectangle on which both tracks stand.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from exudyn_crawler.assessment import chain, grounds, travel
from exudyn_crawler.assessment.forces import MachineWeights, Work
from exudyn_crawler.assessment.pressure import Footprints, Law, law_of_sinkage
from exudyn_crawler.assessment.settings import AssessmentSettings
from exudyn_crawler.assessment.stability import Edges
from exudyn_crawler.assessment.utilisation import PartStrength, PinnedHinge, RollerTread, chain_strength
from exudyn_crawler.case import Case, CellContact, Machine, PairContact
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from meshes.geometry import PITCH, ShoeDimensions

RISE = 5e-3
"""m, by which the lowest pins of an end wheel may be above those under the rollers while it still stands."""
HEAVIEST = 50.0
"""Mean pressures of the machine up to which the sinkage of the case's ground is tabled."""
HEAVY = 400e3
"""kg, from which on a machine counts as a mining shovel, whose drives pull less of its weight."""
PULL_OF_SHOVEL, PULL_OF_OTHERS = 0.5, 0.8
"""Of the weight, where no torque is given: 0.4 to 0.6 and 0.75 to 1 (remembered)."""
PINS = {"diameter": 0.21, "inner": 0.50, "outer": 0.20, "gap": 0.005}
"""Of the pitch: pins 0.20 to 0.22 (remembered); the others assumed, as no source has them."""

WORK_TO_STATE = ("payload", "reach", "digging", "wind_area")
"""Work that no machine says by itself."""

Origin = str


class AssessmentInput(NamedTuple):
    """Number of an assessment with where it comes from."""

    name: str
    value: Any
    unit: str
    origin: Origin
    how: str
    """Key of the file, rule, or range and source."""


class RollerNumbers(NamedTuple):
    """Lower rollers of a track."""

    places: np.ndarray
    """X from the middle of the rectangle, (rollers,), m."""
    groups: tuple[tuple[int, ...], ...]
    """Numbers, from 0, of rollers that share their load: two of a bogie, or one."""
    tread: RollerTread
    above_ground: float
    """Of their load at the ground, N: the shoes of one track that lie on it, which no roller carries."""

    @property
    def supports(self) -> np.ndarray:
        """X at which the frame stands on its rollers and bogies, (groups,), m."""
        return np.array([self.places[list(group)].mean() for group in self.groups])

    @property
    def stiffness(self) -> np.ndarray:
        """Of these supports over that of a roller, (groups,)."""
        return np.array([len(group) for group in self.groups], dtype=float)

    def shared(self, loads: np.ndarray) -> np.ndarray:
        """Return loads (..., rollers) of loads (..., groups), N: those of a bogie share theirs."""
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
    """Of one track."""
    rest: float
    """Tension at rest, N."""
    breaking: float
    """N."""
    speed: float
    """Greatest of the case, m/s."""
    idler_drag: float
    """Resistance of the idler on which both runs pull at rest, N."""
    rises: tuple[float, float]
    """Rise over run of the chain from the outer roller to tumbler and to idler."""


class GroundNumbers(NamedTuple):
    """Ground below the tracks."""

    name: str
    allowed: float
    """Pa; NaN where it is not known."""
    friction: float
    rolling: float
    cohesion: float
    """Pa."""
    undrained: float | None
    """Undrained strength of clay, Pa."""
    compaction: travel.Compaction | None
    """Of the case's ground, which a track compacts."""
    law: Law | None
    """Of a case with cells; None: linear."""
    law_name: str


class ShoeNumbers(NamedTuple):
    """Shoe and its hinges."""

    mass: float
    width: float
    rail: float
    """Of the rails' middles beside the shoe's, m."""
    hinge: PinnedHinge
    hinges: int
    pin: PartStrength
    lug: PartStrength
    wear_pressure: float
    ready: bool
    """True for the ready shoe, of which there are meshes."""


class AssessmentNumbers(NamedTuple):
    """All that the formulas take."""

    gravity: float
    footprints: Footprints
    fewest: Footprints
    """The same as whole shoes below the rollers are fewest."""
    edges: Edges
    weights: MachineWeights
    work: Work
    least_reach: float
    grade: float
    """rad."""
    slope: float
    """rad, of the side slope."""
    rollers: RollerNumbers
    chain: ChainNumbers
    shoe: ShoeNumbers
    ground: GroundNumbers
    drive: travel.TrackDrive
    power: float | None
    """W, of both tracks."""
    inputs: list[AssessmentInput]
    not_stated: frozenset[str] = frozenset()
    """Keys of the settings that have no value, where none follows from the machine."""

    @property
    def weight(self) -> float:
        """Of the machine without payload, N."""
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
            ground.rolling, self.chain.idler_drag, self.footprints, ground.compaction
        )


class _Notes:
    """Inputs in the order in which they come, with the origin that the case's file or the settings know."""

    def __init__(self, given: tuple[str, ...], origins: Mapping[str, tuple[Origin, str]]) -> None:
        self.given = given
        self.origins = origins
        self.rows: list[AssessmentInput] = []

    def case(self, name: str, value: Any, unit: str, key: str) -> Any:
        """Value that stands in the case at a key."""
        origin, how = self.origins.get(key, ("given", f"case: {key}"))
        return self.note(name, value, unit, origin, how)

    def setting(
        self, name: str, value: Any, unit: str, key: str, how: str = "default of the settings"
    ) -> Any:
        """Value of the settings at a key, given by their file or a default."""
        is_given = any(key == path or path.startswith(f"{key}.") for path in self.given)
        if is_given:
            return self.note(name, value, unit, "given", f"settings: {key}")
        return self.note(name, value, unit, "assumed", how)

    def either(self, name: str, given: Any, unit: str, key: str, value: Any, origin: Origin, how: str) -> Any:
        """Value of the settings where it is not None, else another one with its origin."""
        if given is not None:
            return self.note(name, given, unit, "given", f"settings: {key}")
        return self.note(name, value, unit, origin, how)

    def note(self, name: str, value: Any, unit: str, origin: Origin, how: str) -> Any:
        """Note a value, which comes back."""
        self.rows.append(AssessmentInput(name, value, unit, origin, how))
        return value


def numbers_of(
    case: Case,
    settings: AssessmentSettings,
    given: tuple[str, ...] = (),
    origins: Mapping[str, tuple[Origin, str]] | None = None,
) -> AssessmentNumbers:
    """Numbers of a machine on two closed tracks.

    Parameters
    ----------
    case : Case
        Of a machine; a ValueError if its gear is none.
    settings : AssessmentSettings
        What the case does not say.
    given : tuple of str
        Paths of the settings that a file gave; others count as assumed.
    origins : mapping of str
        Origin, and how it came about, of values of the case by their keys; others count as given.
    """
    gear = case.gear
    if not isinstance(gear, Machine):
        raise ValueError(f"gear.kind must be 'machine', which stands on two tracks, got {gear.kind!r}")
    notes = _Notes(given, origins or {})
    gravity = notes.case("gravity", case.gravity, "m/s2", "gravity")
    stand = _stands(case, gear)
    length = notes.either(
        "length on ground", settings.length, "m", "length", stand.length, "derived", stand.how
    )
    least = notes.either(
        "length on the fewest shoes",
        settings.length,
        "m",
        "length",
        stand.least_length,
        "derived",
        "whole shoes below the rollers, p (floor(span / p) + 1), or the length on ground",
    )
    gauge = notes.case("gauge", gear.car_body.track_distance, "m", "gear.car_body.track_distance")
    width = notes.case("width of the shoes", case.shoe.width, "m", "shoe.width")
    footprints = Footprints(gauge, length, width)
    middle = 0.5 * (stand.rear + stand.front)
    side = 0.5 * gauge if settings.side_edges == "middle" else 0.5 * (gauge + width)
    edges = Edges(stand.front - middle, middle - stand.rear, side, side)
    words = f"{settings.side_edges} of the tracks"
    how = f"{stand.standing}, else the outer rollers"
    notes.note("edges in front and at the rear", 0.5 * (stand.front - stand.rear), "m", "derived", how)
    notes.setting("edges at the sides", side, "m", "side_edges", f"{words}; ISO 10567 has the outside")
    weights = _weights(case, gear, middle, notes)
    work, least_reach = _work(settings, notes)
    steep = notes.setting("permitted grade", settings.work.grade, "1", "work.grade", "rise over run, assumed")
    slope = notes.setting("permitted side slope", settings.work.side_slope, "1", "work.side_slope", "assumed")
    pitch = notes.case("pitch", gear.chain_pitch(case.track), "m", "track.pitch")
    return AssessmentNumbers(
        gravity=gravity,
        footprints=footprints,
        fewest=footprints._replace(length=least),
        edges=edges,
        weights=weights,
        work=work,
        least_reach=least_reach,
        grade=math.atan(steep),
        slope=math.atan(slope),
        rollers=_rollers(case, gear, middle, length, pitch, notes),
        shoe=(shoe := _shoe(case, settings, pitch, notes)),
        chain=_chain(case, gear, settings, shoe, pitch, notes),
        ground=_ground(case, settings, footprints, gravity, weights, notes),
        drive=_drive(gear, settings, gravity * (weights.lower_mass + weights.upper_mass), case, notes),
        power=settings.drive.power,
        inputs=notes.rows,
        not_stated=frozenset(
            f"work.{name}" for name in WORK_TO_STATE if getattr(settings.work, name) is None
        ),
    )


class _Stand(NamedTuple):
    """Length on which a track stands, in the machine's axes, m."""

    rear: float
    """X of the edges about which it tips."""
    front: float
    length: float
    least_length: float
    standing: str
    """End wheels that stand, in words."""
    how: str


def _stands(case: Case, gear: Machine) -> _Stand:
    """Length on which a track stands: between end wheels that stand, or below the rollers."""
    rails = case.shoe.rails
    assert rails is not None  # of a closed track
    rise = rails.height - case.track.pin_height
    lowest = -(gear.roller_radius + rise)
    tumbler_x, tumbler_z = gear.tumbler.place
    pitch = gear.chain_pitch(case.track)
    # pins lie on the same belt that the chain is assembled along
    (idler_x, idler_z), on_idler = gear.idler_circle(0.0, rise, pitch)
    ends = (
        (tumbler_x, tumbler_z - gear.tumbler.radius(case.track.pitch), "tumbler"),
        (idler_x, idler_z - on_idler, "idler"),
    )
    standing = [(x, name) for x, z, name in ends if z - lowest <= RISE]
    rear = min([gear.rollers[0], *(x for x, _ in standing)])
    front = max([gear.rollers[-1], *(x for x, _ in standing)])
    span = front - rear
    # a shoe that a roller is about to leave bears on the whole of its length, one beyond end wheels does not
    beyond = pitch * (1.0 - 0.5 * len(standing))
    whole = pitch * (math.floor(span / pitch + 1e-9) + 1)
    names = " and ".join(name for _, name in standing) or "neither tumbler nor idler"
    words = f"{names} as low as the rollers (within {1e3 * RISE:g} mm)"
    how = f"{words}; half a pitch beyond outer rollers, as the chain lies on the mean"
    least = min(span + beyond, whole) if not standing else span + beyond
    return _Stand(rear, front, span + beyond, least, words, how)


def _weights(case: Case, gear: Machine, middle: float, notes: _Notes) -> MachineWeights:
    """Masses and places of what slews and what does not."""
    start = case.frame_start
    shift = np.array([-middle, 0.0, start[2]])
    body = gear.car_body
    fixed = [(part.mass, part.com) for part in gear.frame_parts[:-1]]
    tumblers = case.tumbler_reference[:, :3] - start
    fixed += [(gear.tumbler.mass, place) for place in tumblers]
    if (slide := gear.idler.slide) is not None:
        fixed += [(slide.mass, place) for place in case.idler_reference[:, :3] - start]
    if gear.bogies:
        masses = [bogie.mass for bogie in gear.bogies] * gear.tracks
        pivots = gear.bogie_reference(case.shoe, case.track)[:, :3] - start
        fixed += list(zip(masses, pivots, strict=True))
    if gear.arms:
        masses = [arm.mass for arm in gear.arms] * gear.tracks
        pivots = gear.arm_reference(case.shoe, case.track)[:, :3] - start
        fixed += list(zip(masses, pivots, strict=True))
    shoes = case.shoe_reference[:, :3] - start
    fixed.append((case.shoe.mass * len(shoes), shoes.mean(axis=0)))
    mass = sum(part for part, _ in fixed)
    com = np.sum([part * place for part, place in fixed], axis=0) / mass + shift
    how = "sum of car body, side frames, tumblers and shoes of the case"
    notes.note("mass of all that does not slew", mass, "kg", "derived", how)
    notes.note(
        "its COM", tuple(com.round(4).tolist()), "m", "derived", f"{how}; from the middle, on the ground"
    )
    upper = notes.case("mass of the upper structure", body.upper_mass, "kg", "gear.car_body.upper_mass")
    ahead, aside, above = body.upper_com
    place = (ahead - body.swing_axis, aside, above + float(start[2]))
    key = "gear.car_body.upper_com"
    notes.case("its COM from the swing axis, on the ground", tuple(np.round(place, 4).tolist()), "m", key)
    return MachineWeights(mass, tuple(com.tolist()), upper, place, body.swing_axis - middle)


def _work(settings: AssessmentSettings, notes: _Notes) -> tuple[Work, float]:
    """Work of the upper structure, and its least reach."""
    asked = settings.work
    none = "none given"
    payload = notes.setting("payload", asked.payload or 0.0, "kg", "work.payload", none)
    reach = notes.setting("reach of the payload", asked.reach or 0.0, "m", "work.reach", none)
    least = 0.5 * reach if asked.least_reach is None else asked.least_reach
    notes.setting("least reach", least, "m", "work.least_reach", "half of the reach")
    height = notes.setting("height of the payload", asked.height, "m", "work.height", none)
    bank = asked.digging or (0.0, 0.0)
    digging = notes.setting("force of the bank, away and up", bank, "N", "work.digging", none)
    rate = notes.setting("rate of slewing", asked.slew_rate, "rad/s", "work.slew_rate", none)
    pressure = notes.setting("pressure of the wind", asked.wind_pressure, "Pa", "work.wind_pressure")
    area = notes.setting("area of the wind", asked.wind_area or 0.0, "m2", "work.wind_area", none)
    middle = notes.setting("height of the wind", asked.wind_height, "m", "work.wind_height", none)
    work = Work(payload, reach, height, digging, pressure * area, middle, 0.0, rate)
    return work, least


def _rollers(
    case: Case, gear: Machine, middle: float, length: float, pitch: float, notes: _Notes
) -> RollerNumbers:
    places = np.array(notes.case("lower rollers", gear.rollers, "m", "gear.rollers")) - middle
    pairs = {bogie.rollers[0] - 1: tuple(number - 1 for number in bogie.rollers) for bogie in gear.bogies}
    second = {pair[1] for pair in pairs.values()}
    groups = tuple(pairs.get(number, (number,)) for number in range(len(places)) if number not in second)
    radius = notes.case("radius of the rollers", gear.roller_radius, "m", "gear.roller_radius")
    width = notes.case("width of each tread", gear.tread_width, "m", "gear.tread_width")
    lying = length / pitch * case.shoe.mass * case.gravity
    notes.note(
        "weight of the shoes on the ground", lying, "N", "derived", "length on ground by the pitch, a track"
    )
    return RollerNumbers(places, groups, RollerTread(radius, width), lying)


def _shoe(case: Case, settings: AssessmentSettings, pitch: float, notes: _Notes) -> ShoeNumbers:
    """Shoe with its hinges: those of the ready shoe where it is that, else by the pitch."""
    rails = case.shoe.rails
    assert rails is not None  # of a closed track
    ready = abs(case.track.pitch - PITCH) < 1e-6 and abs(case.shoe.width - ShoeDimensions.width) < 1e-6
    own = {
        "diameter": 2.0 * ShoeDimensions.bore_radius,
        "inner": ShoeDimensions.rear_lug_width,
        "outer": ShoeDimensions.cheek_width,
        "gap": ShoeDimensions.side_clearance,
    }
    play = notes.setting("pin: play in its hole", settings.pins.play, "m", "pins.play", "none given")
    origin: Origin = "derived" if ready else "assumed"
    how = (
        "dimension of the ready shoe"
        if ready
        else "by the pitch; pins 0.20 to 0.22 p (remembered), others assumed"
    )
    asked = settings.pins
    sizes = {
        name: notes.either(
            f"pin: {name}",
            getattr(asked, name),
            "m",
            f"pins.{name}",
            own[name] if ready else PINS[name] * pitch,
            origin,
            how,
        )
        for name in own
    }
    steel = "42CrMo4 quenched and tempered, 100 to 160 mm (EN 10083-3, remembered)"
    pin = PartStrength(
        notes.setting("pin: tensile strength", asked.tensile_strength, "Pa", "pins.tensile_strength", steel),
        notes.setting("pin: yield strength", asked.yield_strength, "Pa", "pins.yield_strength", steel),
    )
    allowed = "wear of dry bores of manganese 40 to 80 MPa (remembered)"
    wear = notes.setting(
        "pin: pressure that wear allows", asked.wear_pressure, "Pa", "pins.wear_pressure", allowed
    )
    material = settings.material
    lug = PartStrength(
        notes.setting("shoe: tensile strength", material.tensile_strength, "Pa", "material", material.name),
        notes.setting("shoe: yield strength", material.yield_strength, "Pa", "material", material.name),
    )
    mass = notes.case("mass of a shoe", case.shoe.mass, "kg", "shoe.mass")
    rail = 0.5 * (rails.left - rails.right)
    hinge = PinnedHinge(**sizes, play=play)
    return ShoeNumbers(mass, case.shoe.width, rail, hinge, 2, pin, lug, wear, ready)


def _chain(
    case: Case, gear: Machine, settings: AssessmentSettings, shoe: ShoeNumbers, pitch: float, notes: _Notes
) -> ChainNumbers:
    """Chain with its tension at rest, by sag or pretension, and what breaks it."""
    rails = case.shoe.rails
    assert rails is not None  # of a closed track
    weight = shoe.mass * case.gravity / pitch
    notes.note("weight of the chain", weight, "N/m", "derived", "mass of a shoe by the pitch")
    idler = gear.idler
    if idler.pretension is not None:
        rest: float = idler.pretension
        origin, how = notes.origins.get("gear.idler.pretension", ("given", "case: gear.idler.pretension"))
    elif idler.tensioner is not None:
        rest = 0.5 * idler.tensioner.preload
        origin = "derived"
        how = "half of the tensioner's preload"
    else:
        span = float(gear.upper_spans[-1])
        rest = chain.tension_of_sag(weight, span, gear.wanted_sag, rails.front - rails.rear)
        origin = "derived"
        how = f"w l2 / (8 f), span {span:.4g} m less a rail, sag {1e3 * gear.wanted_sag:.4g} mm"
    rest = notes.either(
        "tension at rest", settings.drive.rest_tension, "N", "drive.rest_tension", rest, origin, how
    )
    limit = gear.tension_limit
    strength = limit or chain_strength(shoe.hinge, shoe.hinges, shoe.pin)
    words = "case: gear.tension_limit" if limit else "0.6 f_u of the pins in all their sections"
    breaking = notes.either(
        "breaking tension",
        settings.drive.breaking_tension,
        "N",
        "drive.breaking_tension",
        strength,
        "given" if limit else "derived",
        words,
    )
    speed = max(abs(value) for value in case.drive.speed.values)
    drag = 2.0 * gear.rolling_resistance * rest
    rise = rails.height - case.track.pin_height
    lowest = -(gear.roller_radius + rise)
    _, on_idler = gear.idler_circle(0.0, rise, pitch)
    lifts = (
        gear.tumbler.place[1] - gear.tumbler.radius(case.track.pitch) - lowest,
        gear.idler.place[1] - on_idler - lowest,
    )
    runs = gear.rollers[0] - gear.tumbler.place[0], gear.idler.place[0] - gear.rollers[-1]
    rises = tuple(max(lift, 0.0) / run for lift, run in zip(lifts, runs, strict=True))
    shoes = case.track.shoe_count // case.tracks
    return ChainNumbers(weight, pitch, shoes, rest, breaking, speed, drag, (rises[0], rises[1]))


class _GroundValue(NamedTuple):
    """Value of the ground with where it comes from."""

    value: float
    origin: Origin
    how: str


def _of_case(case: Case, notes: _Notes) -> tuple[str, dict[str, _GroundValue]]:
    """Return the name of a case's ground, its friction while shoes slip, rolling resistance and cohesion."""

    def of_key(value: float, key: str) -> _GroundValue:
        return _GroundValue(value, *notes.origins.get(key, ("given", f"case: {key}")))

    contact = case.contact
    cohesion = _GroundValue(0.0, "derived", "friction alone in the case's contact")
    name = "ground of the case"
    if isinstance(contact, PairContact):
        friction = of_key(contact.dynamic_friction, "contact.dynamic_friction")
    elif not isinstance(contact, CellContact):
        friction = of_key(contact.friction, "contact.friction")
    else:
        law: Any = contact.law
        name = f"{name}, {law.model}"
        if isinstance(law, BekkerSoil):
            slope = math.tan(math.radians(law.friction_angle))
            friction = of_key(slope, "contact.law.friction_angle")
            cohesion = of_key(law.cohesion, "contact.law.cohesion")
        else:
            friction = of_key(float(law.friction), "contact.law.friction")
    rolling = of_key(case.running_gear().rolling_resistance, "gear.rolling_resistance")
    return name, {"friction": friction, "rolling": rolling, "cohesion": cohesion}


def _ground(
    case: Case,
    settings: AssessmentSettings,
    footprints: Footprints,
    gravity: float,
    weights: MachineWeights,
    notes: _Notes,
) -> GroundNumbers:
    """Return one ground: the named one, or that of the case; the settings replace single values of it."""
    asked = settings.ground
    law: Law | None = None
    law_name = "linear"
    compaction = None
    allowed = asked.allowed_pressure
    if asked.name is not None:
        named = grounds.ground(asked.name)
        name = named.name
        how = f"{name}: {named.source} [{named.mark}]"
        values = {
            key: _GroundValue(getattr(named, key), "derived", how)
            for key in ("friction", "rolling", "cohesion")
        }
        pressure = named.allowed_pressure
        allowed = notes.either(
            "allowed pressure", allowed, "Pa", "ground.allowed_pressure", pressure, "derived", how
        )
    else:
        name, values = _of_case(case, notes)
        if allowed is not None:
            notes.note("allowed pressure", allowed, "Pa", "given", "settings: ground.allowed_pressure")
        if isinstance(case.contact, CellContact):
            of_cells = case.contact.law
            least = min(footprints.width, footprints.length)
            mean = gravity * (weights.lower_mass + weights.upper_mass) / footprints.area
            law = law_of_sinkage(lambda pressure: of_cells.sinkage(pressure, least), HEAVIEST * mean)
            law_name = of_cells.model
            if isinstance(of_cells, BekkerSoil):
                compaction = travel.Compaction(of_cells.k_c, of_cells.k_phi, of_cells.exponent)
    words = {
        "friction": ("friction on the ground", "1"),
        "rolling": ("resistance straight", "1"),
        "cohesion": ("cohesion of the ground", "Pa"),
    }
    if asked.friction is not None:
        # traction over load, as it is given, has the cohesion in it
        values["cohesion"] = _GroundValue(0.0, "derived", "in the friction that is given")
    friction, rolling, cohesion = (
        notes.either(title, getattr(asked, key), unit, f"ground.{key}", *values[key])
        for key, (title, unit) in words.items()
    )
    undrained = asked.undrained_strength
    if undrained is not None:
        notes.note("undrained strength", undrained, "Pa", "given", "settings: ground.undrained_strength")
    return GroundNumbers(
        name,
        math.nan if allowed is None else allowed,
        friction,
        rolling,
        cohesion,
        undrained,
        compaction,
        law,
        law_name,
    )


def _drive(
    gear: Machine, settings: AssessmentSettings, weight: float, case: Case, notes: _Notes
) -> travel.TrackDrive:
    """Drive of one track."""
    radius = gear.travel_per_angle(case.track)
    notes.note("travel for a radian of the tumbler", radius, "m", "derived", "teeth x pitch / (2 pi)")
    asked = settings.drive
    efficiency = notes.setting(
        "efficiency of the chain", asked.efficiency, "1", "drive.efficiency", "0.9 to 0.95 (remembered)"
    )
    if gear.torque_limit is not None:
        torque: float = gear.torque_limit
        origin, how = notes.origins.get("gear.torque_limit", ("given", "case: gear.torque_limit"))
    else:
        share = PULL_OF_SHOVEL if weight > HEAVY * case.gravity else PULL_OF_OTHERS
        torque = 0.5 * share * weight * radius / efficiency
        origin = "assumed"
        ranges = "0.4 to 0.6 of shovels, 0.75 to 1 of excavators (remembered)"
        how = f"pull of both tracks {share:g} of the weight; {ranges}"
    torque = notes.either("torque of a tumbler", asked.torque, "N m", "drive.torque", torque, origin, how)
    return travel.TrackDrive(torque, radius, efficiency)
