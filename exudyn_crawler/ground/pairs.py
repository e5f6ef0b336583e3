"""Contact of a shoe with a terrain unit, from their frames: one contact for each overlap volume.

The contact acts at the centroid of the overlap volume: the normal law along its normal, friction across it,
and the friction torque about it. The unit receives the opposite of all that the shoe receives. The normal is
that of the unit's top face, or the direction of the area vector of all the unit's faces within the shoe,
including side faces. Inside a unit both are the same. On a flexible shoe the mean displacement of the
underside's patch over the unit is added to the rigid motion.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from exudyn_crawler.ground import columns, frames, laws, overlap
from exudyn_crawler.ground.compiled import inlined, inner, kernel
from exudyn_crawler.ground.frames import Frame, Vector, along, dot, norm, turned, turned_back, upward
from exudyn_crawler.ground.packed import FloatArray

Rectangle = tuple[float, float, float, float]
"""Least and greatest x, least and greatest y, m."""
FROM_CURVE = -1.0
"""Flag instead of a ratio of friction to slip: take the ratio of the friction law."""
WHOLE: Any = np.int64(0)
"""Flag instead of a finger's number: the whole underside. No literal, see `ground.compiled`."""


class Footprint(NamedTuple):
    """Underside in the shoe's frame: least and greatest x, least and greatest y, z (m)."""

    low_x: float
    high_x: float
    low_y: float
    high_y: float
    z: float


class PairLaw(NamedTuple):
    """Laws of normal force and friction, with an overlap's share of them, its normal and its penetration.

    The share grows with STEP to 1 at an overlap of width `edge_width` (m). If `whole_area` (m2) is not zero,
    it is the overlap's fraction of this area. With `area_normal` the normal is that of the area vector. With
    `closest_points` the penetration is the distance of the closest points of both surfaces.
    """

    impact: laws.Impact
    coulomb: laws.Coulomb
    edge_width: float
    whole_area: float
    area_normal: bool
    closest_points: bool


class Volume(NamedTuple):
    """Overlap that makes a contact, with its part of the underside and the size of the unit.

    `weight` is its share of the law beside others of the same pair. `footprint` is its rectangle of the
    underside, `half` half the unit's sides (m). `fading` is the slope of the weight over the reach of the
    whole underside (1/m). `finger` is a finger's number from 1, or `WHOLE`.
    """

    part: overlap.Overlap
    weight: float
    footprint: Footprint
    half: Vector
    fading: float = 0.0
    finger: int = 0


FACE_BLEND = 2e-3
"""Excess (m) over the least distance up to which other faces count for the distance of the closest points;
chosen here, so that the closest points move from face to face without a jump."""


class Patch(NamedTuple):
    """Elastic displacement (m) and velocity (m/s) of the part of an underside on a unit, shoe's axes."""

    displacement: Vector
    velocity: Vector


RIGID = Patch((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
"""Patch of a rigid shoe."""


class Contact(NamedTuple):
    """Contact of a shoe with a unit; vectors are global, forces and torque act on the shoe."""

    penetration: float  # m
    penetration_rate: float
    area: float
    point: Vector
    normal_force: Vector
    friction_force: Vector
    slip_velocity: Vector  # of the shoe relative to the unit
    friction_torque: Vector


class ResultColumns(NamedTuple):
    """First columns of the results of a contact; see `Contact`."""

    shoe: columns.Number  # from 0, as the unit
    unit: columns.Number
    finger: columns.Number  # 0 for a volume of the whole underside, else the finger's number from 1
    penetration: columns.Number
    penetration_rate: columns.Number
    area: columns.Number
    point: columns.Triple
    normal_force: columns.Triple
    friction_force: columns.Triple
    slip_velocity: columns.Triple
    friction_torque: columns.Triple
    # of a flexible shoe: least and greatest x, least and greatest y, shoe's axes
    patch: columns.Quadruple


COLUMN = columns.columns_of(ResultColumns)
RESULT: dict[str, Any] = columns.places_of(ResultColumns)
RESULTS = columns.width_of(ResultColumns)
"""First columns of a contact's results, the same columns by name, and their number."""
NO_PATCH: Rectangle = (0.0, 0.0, 0.0, 0.0)


@kernel
def pair_overlap(
    shoe: Frame, unit: Frame, footprint: Footprint, half: Vector, work: FloatArray
) -> overlap.Overlap:
    """Return the overlap of a shoe, taken as rigid, with a unit; `half` holds half the sides (m) of the unit.

    `work` is scratch memory; see `overlap_workspace`.
    """
    corners = work[0]
    apart = along(shoe.r, -1.0, unit.r)
    for k in range(4):
        x = footprint.low_x if k == 0 or k == 3 else footprint.high_x
        y = footprint.low_y if k < 2 else footprint.high_y
        corner = turned_back(unit.R, along(apart, 1.0, turned(shoe.R, (x, y, footprint.z))))
        corners[k, 0] = corner[0]
        corners[k, 1] = corner[1]
        corners[k, 2] = half[2] - corner[2]
        corners[k, 3] = x
    return overlap.overlap(work, half[0], half[1])


@inlined
def share_of(volume: Volume, law: PairLaw) -> float:
    """Return an overlap's share of the law."""
    part = volume.part
    if law.whole_area > 0.0:
        return volume.weight * part.area / law.whole_area
    width = min(part.high_xi - part.low_xi, part.high_eta - part.low_eta)
    return volume.weight * laws.step(width, 0.0, 0.0, law.edge_width, 1.0)


@inlined
def contact_point(part: overlap.Overlap, unit: Frame, top: float) -> Vector:
    """Return a contact's point (m): above the overlap's centroid, halfway up to the face at `top`."""
    return along(unit.r, 1.0, turned(unit.R, (part.xi, part.eta, top - 0.5 * part.depth)))


@inlined
def leans(part: overlap.Overlap, law: PairLaw) -> bool:
    """Return True if a law uses more of a clipped overlap than its depth at the centroid."""
    return part.cut > 0 and (law.area_normal or law.closest_points)


@inlined
def normal_of(part: overlap.Overlap, unit: Frame, law: PairLaw) -> Vector:
    """Return the normal of a contact, global, from the unit to the shoe."""
    if not law.area_normal or (part.side_x == 0.0 and part.side_y == 0.0):
        return upward(unit.R)
    faces = (part.side_x, part.side_y, part.area)
    return turned(unit.R, along((0.0, 0.0, 0.0), 1.0 / norm(faces), faces))


@inner
def _way_out(place: Vector, toward: Vector, footprint: Footprint) -> float:
    """Return the distance (m) from a point in the shoe's frame to the underside's outline in a direction."""
    way = math.inf
    for axis in range(2):
        low, high = (footprint.low_x, footprint.high_x) if axis == 0 else (footprint.low_y, footprint.high_y)
        if toward[axis] != 0.0:
            face = high if toward[axis] > 0.0 else low
            way = min(way, (face - place[axis]) / toward[axis])
    return max(0.0, way)


@inner
def _closest_distance(volume: Volume, shoe: Frame, unit: Frame) -> float:
    """Return the distance (m) of the closest points of both surfaces about a contact's point.

    The closest points lie on opposite faces: the top face and the underside, or a side of the unit and the
    end or side of the shoe within it, whichever are closer.
    """
    part = volume.part
    half = volume.half
    place = turned_back(shoe.R, along(contact_point(part, unit, half[2]), -1.0, shoe.r))
    toward_x = turned_back(shoe.R, turned(unit.R, (-1.0 if part.xi > 0.0 else 1.0, 0.0, 0.0)))
    toward_y = turned_back(shoe.R, turned(unit.R, (0.0, -1.0 if part.eta > 0.0 else 1.0, 0.0)))
    x = half[0] - abs(part.xi) + _way_out(place, toward_x, volume.footprint)
    y = half[1] - abs(part.eta) + _way_out(place, toward_y, volume.footprint)
    least = min(part.depth, x, y)
    total = 0.0
    mean = 0.0
    for thickness in (x, y, part.depth):
        weight = laws.step(thickness - least, 0.0, 1.0, FACE_BLEND, 0.0)
        total = total + weight
        mean = mean + weight * thickness
    return mean / total


@kernel
def pair_contact(
    volume: Volume, shoe: Frame, unit: Frame, patch: Patch, law: PairLaw, ratio: float
) -> Contact:
    """Return the contact of a shoe with a unit at a known overlap.

    `ratio` is friction over normal force and slip speed, s/m; `FROM_CURVE` takes it from the friction law.
    """
    part = volume.part
    normal = normal_of(part, unit, law)
    point = contact_point(part, unit, volume.half[2])
    velocity = along(frames.velocity_at(shoe, point), -1.0, frames.velocity_at(unit, point))
    velocity = along(velocity, 1.0, turned(shoe.R, patch.velocity))
    penetration = part.depth
    if law.closest_points and part.cut > 0:
        penetration = _closest_distance(volume, shoe, unit)
    depth = penetration - dot(normal, turned(shoe.R, patch.displacement))
    rate = -dot(velocity, normal)
    slip = along(velocity, rate, normal)
    speed = norm(slip)
    force = share_of(volume, law) * laws.impact_force(law.impact, depth, rate)
    drag = force * (ratio if ratio >= 0.0 else laws.friction_per_slip(law.coulomb, speed))
    spin = dot(along(shoe.omega, -1.0, unit.omega), normal)
    torque = laws.friction_torque(law.coulomb, spin, part.area, drag * speed)
    nothing = (0.0, 0.0, 0.0)
    return Contact(
        depth,
        rate,
        part.area,
        point,
        along(nothing, force, normal),
        along(nothing, -drag, slip),
        slip,
        along(nothing, torque, normal),
    )


@kernel
def keep(contact: Contact, shoe: int, unit: int, finger: int, patch: Rectangle, row: FloatArray) -> None:
    """Write a contact into a row of results (RESULTS,)."""
    row[COLUMN.shoe] = shoe
    row[COLUMN.unit] = unit
    row[COLUMN.finger] = finger
    row[COLUMN.penetration] = contact.penetration
    row[COLUMN.penetration_rate] = contact.penetration_rate
    row[COLUMN.area] = contact.area
    for k in range(3):
        row[COLUMN.point + k] = contact.point[k]
        row[COLUMN.normal_force + k] = contact.normal_force[k]
        row[COLUMN.friction_force + k] = contact.friction_force[k]
        row[COLUMN.slip_velocity + k] = contact.slip_velocity[k]
        row[COLUMN.friction_torque + k] = contact.friction_torque[k]
    for k in range(4):
        row[COLUMN.patch + k] = patch[k]
