"""Loads of each load case: pressure, margin, rollers, chain and shoes at the worst slewing angle."""

from itertools import product
from typing import NamedTuple

import numpy as np

from exudyn_crawler.assessment import chain, forces, pressure, rollers, stability, travel
from exudyn_crawler.assessment.forces import Floats, Resultant, Work
from exudyn_crawler.assessment.inputs import AssessmentNumbers
from exudyn_crawler.assessment.load_cases import LoadCase, LoadCases

SLEW = np.radians(np.arange(0.0, 360.0, 5.0))
"""Slewing angles of the load cases, rad."""
IN_LINE = np.array([0.0, np.pi])
DOWNHILL = np.radians([0.0, 90.0, 180.0, 270.0])
"""Directions of the fall line and of the wind, rad."""
BACK = np.pi
"""Direction of the fall line for a machine that climbs, rad."""
FORMULA = "formula"


class CaseLoads(NamedTuple):
    """Loads of a machine in a load case; the worst of each over the slewing angles."""

    name: str
    group: str
    strength: float
    """Factor of its group on loads."""
    tipping: float
    """Required margin of its group against tipping."""
    factors: str
    """Source of both factors, with its mark."""
    drive: str
    support: str
    lies: str
    """Slope of the ground: "level", "grade" or "side slope"."""
    loaded: bool
    """True with a payload or a force of the bank."""
    basis: str
    """Formula, or the run that gives the forces."""
    greatest_pressure: float
    """Greatest pressure, Pa; infinite if the machine tips."""
    even_pressure: float
    """Meyerhof's even pressure of the more loaded track, Pa; NaN for a run."""
    slew: float
    """Angle of the greatest pressure, rad."""
    carries: float
    """Effective length of a track at the greatest pressure, m."""
    track_load: float
    """Greatest load of a track, N."""
    margin: float
    """Least stabilising over overturning moments."""
    edge: str
    """Edge of the least margin; edge of the least tilt if no force overturns."""
    tilt: float
    """Least further tilt until the machine tips, rad."""
    tilt_edge: str
    """Edge of the least tilt."""
    roller: float
    """Greatest load of a roller, N."""
    roller_loads: Floats
    """Roller loads of the track with the greatest one, (rollers,), N."""
    distance: float
    """Least distance of the resultant's foot from the edges, m, positive inside."""
    needed: float
    """Pull of a track needed for the travel, N."""
    available: float
    """Lesser of the pulls of drive and ground, N."""
    ends: str
    """"goes", "stalls" or "slips"; nothing where it stands."""
    tension: float
    """Greatest tension of the chain, N."""
    side_force: float
    """Greatest lateral force on a grounded shoe, N."""
    mean_pressure: float = np.nan
    """Mean pressure of the loaded shoes of a run, Pa; NaN for the formula."""
    missing: tuple[str, ...] = ()
    """Settings keys without a value that the load case needs; its forces lack them."""

    @property
    def missing_of_loads(self) -> tuple[str, ...]:
        """Keys that the forces on ground and rollers lack; empty for a run, which has its own forces."""
        return self.missing if self.basis == FORMULA else ()

    @property
    def missing_of_travel(self) -> tuple[str, ...]:
        """Keys that pull and chain tension lack; empty without travel, when neither depends on a load."""
        return self.missing_of_loads if self.drive in ("straight", "turn") else ()


class _Envelope(NamedTuple):
    """Results at all angles, slopes and works of a load case: arrays (n,)."""

    slew: Floats
    stands: Resultant
    greatest: Floats
    carries: Floats
    even: Floats
    heavier: Floats
    margin: Floats
    edge: Floats
    tilt: Floats
    tilt_edge: Floats
    distance: Floats


def loads_of(numbers: AssessmentNumbers, cases: LoadCases) -> list[CaseLoads]:
    """Return the loads of all load cases."""
    return [case_loads(numbers, cases, case) for case in cases.cases]


def case_loads(numbers: AssessmentNumbers, cases: LoadCases, case: LoadCase) -> CaseLoads:
    """Return the loads of one load case."""
    group = cases.group_of(case)
    envelope = _envelope(numbers, case)
    worst = int(np.argmax(envelope.greatest))
    tilts = int(np.argmin(envelope.tilt))
    tips = int(np.argmin(envelope.margin)) if np.isfinite(envelope.margin).any() else tilts
    travels = _travel(numbers, case, envelope)
    speed = 0.0 if case.drive == "none" else numbers.chain.speed
    mass = numbers.chain.weight / numbers.gravity
    tension = chain.travel_tension(numbers.chain.rest, travels.chain_pull, mass, speed).taut
    loads = _rollers(numbers, case, envelope, tension)
    return CaseLoads(
        name=case.name,
        group=group.name,
        strength=group.strength,
        tipping=group.tipping,
        factors=cases.source if group.mark == "given" else f"{cases.source} [{group.mark}]",
        drive=case.drive,
        support=case.support,
        lies="side slope" if case.slope else "grade" if case.grade else "level",
        loaded=bool((case.payload and numbers.work.payload) or (case.digging and any(numbers.work.digging))),
        basis=FORMULA,
        greatest_pressure=float(envelope.greatest[worst]),
        even_pressure=float(envelope.even.max()),
        slew=float(envelope.slew[worst]),
        carries=float(envelope.carries[worst]),
        track_load=float(envelope.heavier.max()),
        margin=float(envelope.margin[tips]),
        edge=stability.EDGES[int(envelope.edge[tips])],
        tilt=float(envelope.tilt[tilts]),
        tilt_edge=stability.EDGES[int(envelope.tilt_edge[tilts])],
        roller=float(loads.max()),
        roller_loads=loads,
        distance=float(envelope.distance.min()),
        needed=travels.needed,
        available=travels.available,
        ends=travels.ends,
        tension=tension,
        side_force=_side_force(numbers, case, envelope),
        missing=_missing(numbers, case),
    )


def _missing(numbers: AssessmentNumbers, case: LoadCase) -> tuple[str, ...]:
    """Return the settings keys without a value that a load case needs."""
    asked = {"work.payload": case.payload, "work.digging": case.digging, "work.wind_area": case.wind}
    missing = [key for key, wanted in asked.items() if wanted and key in numbers.not_stated]
    lifted = case.payload and ("work.payload" in missing or numbers.work.payload)
    dug = case.digging and ("work.digging" in missing or any(numbers.work.digging))
    if (lifted or dug) and "work.reach" in numbers.not_stated:
        missing.append("work.reach")
    return tuple(missing)


def _side_force(numbers: AssessmentNumbers, case: LoadCase, envelope: _Envelope) -> float:
    """Return the greatest lateral force on a grounded shoe, N.

    In a turn the most loaded shoe has all of its shear strength across. In other cases the shoes share the
    lateral push (slope, wind, bank, slewing) as they share the load, up to their strength (a convention
    here).
    """
    part = numbers.chain.pitch * numbers.footprints.width
    strength = numbers.ground.friction * envelope.greatest + numbers.ground.cohesion
    if case.drive == "turn":
        return float(strength.max()) * part
    pushed = np.abs(envelope.stands.push_left) / envelope.stands.weight
    shared = np.multiply(pushed, envelope.greatest, out=np.zeros_like(pushed), where=pushed > 0.0)
    return float(np.minimum(shared, strength).max()) * part


def _works(numbers: AssessmentNumbers, case: LoadCase) -> list[Work]:
    """Return the works of a load case: payload far, near and none, for each wind direction."""
    bare = numbers.work._replace(digging=(0.0, 0.0), wind=0.0)
    bare = bare if case.slew == "all" else bare._replace(slew_rate=0.0)
    works = [bare._replace(payload=0.0)]
    if case.payload:
        works += [bare, bare._replace(reach=numbers.least_reach)]
    if case.digging:
        works.append(bare._replace(digging=numbers.work.digging))
        works.append(works[0]._replace(digging=numbers.work.digging))
    if case.wind:
        ways = DOWNHILL.tolist()
        works = [
            work._replace(wind=numbers.work.wind, wind_towards=way) for work, way in product(works, ways)
        ]
    return works


def _slopes(numbers: AssessmentNumbers, case: LoadCase) -> list[Floats]:
    """Return the gravity (3,) of a load case for each direction of its slope, m/s2."""
    if case.slope:
        return [forces.gravity_on_slope(numbers.gravity, numbers.slope, way) for way in DOWNHILL.tolist()]
    if case.grade:
        return [forces.gravity_on_slope(numbers.gravity, numbers.grade, BACK)]
    return [forces.gravity_on_slope(numbers.gravity, 0.0, 0.0)]


def _envelope(numbers: AssessmentNumbers, case: LoadCase) -> _Envelope:
    """Return resultants, pressures and margins at all angles, slopes and works of a load case."""
    slew = SLEW if case.slew == "all" else IN_LINE
    parts = []
    for work, gravity in product(_works(numbers, case), _slopes(numbers, case)):
        acting = forces.forces_at(numbers.weights, work, slew, gravity)
        stands = forces.resultant(acting)
        tipped = stability.tipping(acting, numbers.edges)
        left, right = pressure.pressure_of_tracks(stands, numbers.fewest)
        over = np.abs(stands.aside) >= 0.5 * numbers.footprints.gauge
        greatest = np.where(over, np.inf, np.fmax(left.greatest, right.greatest))
        even = np.where(over, np.inf, np.fmax(left.even, right.even))
        loads = pressure.track_loads(stands.weight, stands.aside, numbers.footprints.gauge)
        parts.append(
            (
                slew,
                stands,
                greatest,
                left.length,
                even,
                np.maximum(*loads),
                tipped.margin.min(axis=1),
                tipped.first_edge,
                tipped.angle.min(axis=1),
                tipped.angle.argmin(axis=1),
                tipped.distance.min(axis=1),
            )
        )
    columns = list(zip(*parts, strict=True))
    stands = Resultant(*(np.concatenate(values) for values in zip(*columns.pop(1), strict=True)))
    angles, *others = (np.concatenate(values) for values in columns)
    return _Envelope(angles, stands, *others)


def _rollers(numbers: AssessmentNumbers, case: LoadCase, envelope: _Envelope, tension: float) -> Floats:
    """Return the loads (rollers,) of the track with the most loaded roller of the load case, N.

    Grounded shoes bear their own weight in the middle of their length. The load of the rollers is therefore
    further from the middle than that of the track.
    """
    places = numbers.rollers.supports
    lying = numbers.rollers.grounded_shoe_weight
    some = envelope.heavier > lying
    if not some.any():
        return np.zeros(len(numbers.rollers.places))
    heavier, ahead = envelope.heavier[some], envelope.stands.ahead[some]
    load = heavier - lying
    centre = np.clip(ahead * heavier / load, places[0], places[-1])
    if case.support == "even":
        on_supports = rollers.even_loads(load, centre, places, numbers.rollers.stiffness)
    elif case.support == "two":
        on_supports = rollers.two_loads(load, centre, places, rollers.neighbours(centre, places))
    elif case.support == "outer":
        on_supports = rollers.end_load(load, centre, places)
    elif case.support == "one":
        on_supports = rollers.one_load(load, centre, places)
    else:
        on_supports = _corner(numbers, envelope.stands.weight[some], ahead, envelope.stands.aside[some])
    loads = numbers.rollers.shared(on_supports)
    if case.support == "even":
        for end, rise in zip((0, -1), numbers.chain.rises, strict=True):
            loads[:, end] += chain.end_roller_push(tension, rise, 1.0)
    most: Floats = loads[loads.max(axis=1).argmax()]
    return most


def _corner(numbers: AssessmentNumbers, weight: Floats, ahead: Floats, aside: Floats) -> Floats:
    """Return the loads (states, supports) of a track with a corner on a stone, N: only the corner bears."""
    places = numbers.rollers.supports
    load = weight - 2.0 * numbers.rollers.grounded_shoe_weight
    away = weight / load
    length = float(places[-1] - places[0])
    corner = rollers.corner_load(load, away * ahead, away * aside, length, numbers.footprints.gauge)
    ends = np.where(ahead < 0.0, 0, len(places) - 1)
    return np.asarray(corner)[:, None] * (ends[:, None] == np.arange(len(places)))


class _Travel(NamedTuple):
    """Pull of one track in a load case."""

    needed: float
    """Pull needed, N."""
    available: float
    """Lesser of the pulls of drive and ground, N."""
    ends: str
    """"goes", "stalls" or "slips"; nothing where it stands."""
    chain_pull: float
    """Greatest pull of the chain, N."""


def _travel(numbers: AssessmentNumbers, case: LoadCase, envelope: _Envelope) -> _Travel:
    """Return the pull of a track by the drive of a load case: none, straight, turn, stalled or blocked."""
    if case.drive == "none":
        return _Travel(0.0, np.inf, "", 0.0)
    pull = numbers.drive.pull
    stands = envelope.stands
    ground = numbers.ground
    area = numbers.footprints.area
    # traction of a track in each state
    held = 0.5 * np.asarray(travel.traction(stands.weight, ground.friction, ground.cohesion, area))
    if case.drive in ("stall", "blocked"):
        return _Travel(pull, min(pull, float(np.max(held))), "stalls", pull)
    # pull of a track that travels straight in each state
    straight = 0.5 * np.asarray(numbers.resistance.pull(stands.weight, -stands.push_ahead))
    if case.drive == "straight":
        worst = int(np.argmax(straight / np.minimum(pull, held)))
        needed, bears = float(straight[worst]), float(held[worst])
        ends = travel.ends_by(needed, pull, bears)
        return _Travel(needed, min(pull, bears), ends, float(straight.max()))
    return _turn(numbers, envelope, float(straight.max()))


def _turn(numbers: AssessmentNumbers, envelope: _Envelope, straight: float) -> _Travel:
    """Return the pull of a track in a turn on the spot: that of travel (`straight`, N), and of the turn.

    The turn is that of the greatest weight, with the foot of the resultant that is nearest to the middle
    along the tracks.
    """
    stands = envelope.stands
    ground = numbers.ground
    area = numbers.footprints.area
    pull = numbers.drive.pull
    weight = float(stands.weight.max())
    worst = int(np.argmin(np.abs(stands.ahead)))
    place = float(stands.ahead[worst]), float(stands.aside[worst])
    try:
        turn = travel.turn_of_footprints(weight, numbers.footprints, ground.friction, *place, ground.cohesion)
    except ValueError:
        # the lighter track slips, and the machine stands
        lighter = weight - float(envelope.heavier[worst])
        strength = travel.traction(lighter, ground.friction, ground.cohesion, 0.5 * area)
        given = min(pull, float(strength))
        firm = weight + ground.cohesion * area / ground.friction
        lines = travel.turn_of_lines(firm, *numbers.footprints[1::-1], ground.friction)
        return _Travel(straight + lines.pull, given, "slips", given)
    needed = straight + turn.pull
    # shoes slide in a turn: the ground gives all of the needed pull, and only the drive can be too weak
    return _Travel(needed, pull, travel.ends_by(needed, pull, np.inf), needed)
