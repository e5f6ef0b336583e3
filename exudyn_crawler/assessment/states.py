"""Loads of each load case: pressure, margin, rollers, chain and shoes at the worst angle of slewing."""

from itertools import product
from typing import NamedTuple

import numpy as np

from exudyn_crawler.assessment import chain, forces, pressure, rollers, stability, travel
from exudyn_crawler.assessment.forces import Floats, Resultant, Work
from exudyn_crawler.assessment.inputs import AssessmentNumbers
from exudyn_crawler.assessment.load_cases import LoadCase, LoadCases

SLEW = np.radians(np.arange(0.0, 360.0, 5.0))
"""Angles of slewing that are looked at, rad."""
IN_LINE = np.array([0.0, np.pi])
DOWNHILL = np.radians([0.0, 90.0, 180.0, 270.0])
"""Directions of the fall line and of the wind, rad."""
BACK = np.pi
"""Direction of the fall line of a machine that goes uphill, rad."""
FORMULA = "formula"


class CaseLoads(NamedTuple):
    """Loads that a machine bears in a load case; the worst of each over the angles of slewing."""

    name: str
    group: str
    strength: float
    """Factor on loads of its group."""
    tipping: float
    """Margin against tipping that its group asks for."""
    factors: str
    """Source of both, with its mark."""
    drive: str
    support: str
    lies: str
    """How the ground lies: "level", "grade" or "side slope"."""
    loaded: bool
    """True with a payload or a force of the bank."""
    basis: str
    """Formula, or the run whose forces these are."""
    greatest_pressure: float
    """Pa; infinite where it tips."""
    even_pressure: float
    """Meyerhof's, of the more loaded track, Pa."""
    slew: float
    """Angle of the greatest pressure, rad."""
    track_load: float
    """Greatest of a track, N."""
    margin: float
    """Least stabilising over overturning moments."""
    edge: str
    """About which that is."""
    tilt: float
    """Least angle until it tips, rad."""
    roller: float
    """Greatest load of a roller, N."""
    roller_loads: Floats
    """Of the track with the greatest one, (rollers,), N."""
    distance: float
    """Least of the foot of all forces' resultant from the edges, inside of them, m."""
    needed: float
    """Pull of a track that the travel takes, N."""
    available: float
    """Pull of the lesser of drive and ground, N."""
    ends: str
    """"goes", "stalls" or "slips"; nothing where it stands."""
    tension: float
    """Greatest of the chain, N."""
    side_force: float
    """Greatest across a shoe on the ground, N."""


class _Envelope(NamedTuple):
    """Everything at all angles, slopes and works of a load case: arrays (n,)."""

    slew: Floats
    stands: Resultant
    greatest: Floats
    even: Floats
    heavier: Floats
    margin: Floats
    edge: Floats
    tilt: Floats
    distance: Floats


def loads_of(numbers: AssessmentNumbers, cases: LoadCases) -> list[CaseLoads]:
    """Loads of all load cases."""
    return [case_loads(numbers, cases, case) for case in cases.cases]


def case_loads(numbers: AssessmentNumbers, cases: LoadCases, case: LoadCase) -> CaseLoads:
    """Loads of one load case."""
    group = cases.group_of(case)
    envelope = _envelope(numbers, case)
    worst = int(np.argmax(envelope.greatest))
    tips = int(np.argmin(envelope.margin))
    needed, available, ends, pull = _travel(numbers, case, envelope)
    speed = 0.0 if case.drive == "none" else numbers.chain.speed
    tension = chain.travel_tension(numbers.chain.rest, pull, numbers.chain.weight, speed).taut
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
        track_load=float(envelope.heavier.max()),
        margin=float(envelope.margin[tips]),
        edge=stability.EDGES[int(envelope.edge[tips])],
        tilt=float(envelope.tilt.min()),
        roller=float(loads.max()),
        roller_loads=loads,
        distance=float(envelope.distance.min()),
        needed=needed,
        available=available,
        ends=ends,
        tension=tension,
        side_force=_side_force(numbers, case, envelope),
    )


def _side_force(numbers: AssessmentNumbers, case: LoadCase, envelope: _Envelope) -> float:
    """Greatest force across a shoe on the ground, N.

    In a turn the most loaded shoe has all of its friction across. Else what pushes the machine aside (slope,
    wind, bank, slewing) is shared as the load is, as far as friction holds it (a convention here).
    """
    part = numbers.chain.pitch * numbers.footprints.width
    friction = numbers.ground.friction
    pushed = np.abs(envelope.stands.push_left) / envelope.stands.weight
    share = np.full_like(pushed, friction) if case.drive == "turn" else np.minimum(pushed, friction)
    pressed = np.multiply(share, envelope.greatest, out=np.zeros_like(share), where=share > 0.0)
    return float(pressed.max()) * part


def _works(numbers: AssessmentNumbers, case: LoadCase) -> list[Work]:
    """Works of a load case: with the payload far, near and without, by the wind's directions."""
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
    """Gravity (3,) of a load case by the directions of its slope, m/s2."""
    if case.slope:
        return [forces.gravity_on_slope(numbers.gravity, numbers.slope, way) for way in DOWNHILL.tolist()]
    if case.grade:
        return [forces.gravity_on_slope(numbers.gravity, numbers.grade, BACK)]
    return [forces.gravity_on_slope(numbers.gravity, 0.0, 0.0)]


def _envelope(numbers: AssessmentNumbers, case: LoadCase) -> _Envelope:
    """Resultants, pressures and margins at all angles, slopes and works of a load case."""
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
        edge = tipped.margin.argmin(axis=1)
        least = tipped.margin.min(axis=1)
        tilt = tipped.angle.min(axis=1)
        distance = tipped.distance.min(axis=1)
        parts.append((slew, stands, greatest, even, np.maximum(*loads), least, edge, tilt, distance))
    columns = list(zip(*parts, strict=True))
    stands = Resultant(*(np.concatenate(values) for values in zip(*columns.pop(1), strict=True)))
    angles, *others = (np.concatenate(values) for values in columns)
    return _Envelope(angles, stands, *others)


def _rollers(numbers: AssessmentNumbers, case: LoadCase, envelope: _Envelope, tension: float) -> Floats:
    """Loads (rollers,) of the track with the most loaded roller of the load case, N."""
    places = numbers.rollers.supports
    chosen = {int(np.argmax(np.abs(envelope.stands.ahead))), int(np.argmax(envelope.heavier))}
    chosen.add(int(np.argmax(envelope.greatest)))
    best = np.zeros(len(numbers.rollers.places))
    for number in chosen:
        load = max(float(envelope.heavier[number]) - numbers.rollers.above_ground, 0.0)
        centre = float(np.clip(envelope.stands.ahead[number], places[0], places[-1]))
        if case.support == "even":
            loads = numbers.rollers.shared(
                rollers.even_loads(load, centre, places, numbers.rollers.stiffness)
            )
            for end, rise in zip((0, -1), numbers.chain.rises, strict=True):
                loads[end] += chain.end_roller_push(tension, rise, 1.0)
        elif case.support == "corner":
            loads = numbers.rollers.shared(_corner(numbers, envelope, number))
        else:
            loads = numbers.rollers.shared(_uneven(case.support, load, centre, places))
        best = loads if loads.max() > best.max() else best
    return best


def _uneven(support: str, load: float, centre: float, places: Floats) -> Floats:
    """Loads of the rollers and bogies of one track on uneven ground, N."""
    if support == "two":
        return rollers.two_loads(load, centre, places, rollers.neighbours(centre, places))
    if support == "outer":
        return rollers.end_load(load, centre, places)
    return rollers.one_load(load, centre, places)


def _corner(numbers: AssessmentNumbers, envelope: _Envelope, number: int) -> Floats:
    """Loads of one track whose corner stands on a stone, N: that of the corner alone."""
    places = numbers.rollers.supports
    weight = float(envelope.stands.weight[number]) - 2.0 * numbers.rollers.above_ground
    ahead = float(envelope.stands.ahead[number])
    aside = float(envelope.stands.aside[number])
    length = float(places[-1] - places[0])
    loads = np.zeros(len(places))
    corner = rollers.corner_load(weight, ahead, aside, length, numbers.footprints.gauge)
    loads[0 if ahead < 0.0 else -1] = corner
    return loads


def _travel(
    numbers: AssessmentNumbers, case: LoadCase, envelope: _Envelope
) -> tuple[float, float, str, float]:
    """Pull of a track that is needed, available, what it ends by, and the pull that its chain bears, N."""
    if case.drive == "none":
        return 0.0, np.inf, "", 0.0
    weight = float(envelope.stands.weight.max())
    ground = numbers.ground
    part = numbers.footprints.length * numbers.footprints.width
    held = float(travel.traction(0.5 * weight, ground.friction, ground.cohesion, part))
    pull = numbers.drive.pull
    if case.drive in ("stall", "blocked"):
        return pull, min(pull, held), "stalls", pull
    slope = numbers.grade if case.grade else 0.0
    needed = 0.5 * travel.resistance(weight / np.cos(slope), slope, ground.rolling)
    needed += numbers.chain.idler_drag
    if ground.compaction is not None:
        mean = weight / numbers.footprints.area
        sides = numbers.footprints.width
        needed += 0.5 * travel.sinkage_resistance(mean, ground.compaction, sides)
    if case.drive == "straight":
        return needed, min(pull, held), travel.ends_by(needed, pull, held), needed
    worst = int(np.argmin(np.abs(envelope.stands.ahead)))
    place = float(envelope.stands.ahead[worst]), float(envelope.stands.aside[worst])
    try:
        turn = travel.turn_of_footprints(weight, numbers.footprints, ground.friction, *place)
    except ValueError:
        # the lighter track slips, and the machine stands
        lighter = ground.friction * (weight - float(envelope.heavier.max()))
        lines = travel.turn_of_lines(weight, *numbers.footprints[1::-1], ground.friction)
        return lines.pull, min(pull, lighter), "slips", min(pull, lighter)
    needed += turn.pull
    # shoes slide in a turn: ground gives what they ask for, and the drive alone can be too weak
    return needed, pull, travel.ends_by(needed, pull, np.inf), needed
