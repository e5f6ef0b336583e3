"""Contact of a shoe with a terrain unit, on frames: one contact a pair that overlaps.

It acts at the centroid of the overlap volume, along the normal of the unit's top face with the normal law,
across it with friction and about it with the friction torque; the unit receives the opposite of all that
the shoe receives. Where the shoe is flexible, the mean displacement of the patch of its underside over the
unit adds to its rigid motion.
"""

from typing import NamedTuple

from exudyn_crawler.ground.frames import (
    Frame,
    Vector,
    along,
    columns_of,
    compiled,
    dot,
    inlined,
    norm,
    turned,
    turned_back,
    upward,
    velocity_at,
)
from exudyn_crawler.ground.laws import Law, drag_ratio, normal_force, spin_torque
from exudyn_crawler.ground.laws.impact import step
from exudyn_crawler.ground.overlap import Overlap, overlap
from exudyn_crawler.ground.rotations import FloatArray

FROM_CURVE = -1.0
"""In place of a ratio of friction to slip: the one of the friction law."""


class Footprint(NamedTuple):
    """Underside in the shoe's frame: least and greatest x, least and greatest y, z (m)."""

    low_x: float
    high_x: float
    low_y: float
    high_y: float
    z: float


class PairLaw(NamedTuple):
    """Contact law, and what of it a pair of shoe and unit has.

    All of it, growing with STEP up to an overlap as wide as `edge_width` (m), or, where `whole_area` is not
    zero, as much as the overlap has of this area (m2).
    """

    law: Law
    edge_width: float
    whole_area: float


class Patch(NamedTuple):
    """Elastic displacement (m) and velocity (m/s) of the part of an underside on a unit, shoe's axes."""

    displacement: Vector
    velocity: Vector


RIGID = Patch((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
"""Patch of a rigid shoe."""


class Contact(NamedTuple):
    """One contact; vectors are global, forces and torque act on the shoe. Columns of `RESULT`."""

    penetration: float
    penetration_rate: float
    area: float
    point: Vector
    normal_force: Vector
    friction_force: Vector
    slip_velocity: Vector
    friction_torque: Vector


RESULT, RESULTS = columns_of(Contact, "shoe", "unit")
"""Columns of a contact's results, and how many they are. Vectors are global; forces and torque act on the
shoe; the slip velocity is the shoe's relative to the unit."""
RESULT["patch"] = slice(RESULTS, RESULTS + 4)
RESULTS += 4


@compiled
def pair_overlap(shoe: Frame, unit: Frame, footprint: Footprint, half: Vector, work: FloatArray) -> Overlap:
    """Overlap of a shoe, taken as rigid, with a unit of which `half` holds half the sides (m).

    `work` is scratch memory as of `overlap_workspace`.
    """
    corners = work[0]
    apart = along(shoe.r, -1.0, unit.r)
    for k in range(4):
        x = footprint.low_x if k == 0 or k == 3 else footprint.high_x
        y = footprint.low_y if k < 2 else footprint.high_y
        corner = turned_back(unit.R, along(apart, 1.0, turned(shoe.R, (x, y, footprint.z))))
        corners[k, 0], corners[k, 1], corners[k, 2] = corner[0], corner[1], half[2] - corner[2]
    return overlap(work, half[0], half[1])


@inlined
def share_of(part: Overlap, law: PairLaw) -> float:
    """Share of the law that an overlap has."""
    if law.whole_area > 0.0:
        return part.area / law.whole_area
    width = min(part.high_xi - part.low_xi, part.high_eta - part.low_eta)
    return step(width, 0.0, 0.0, law.edge_width, 1.0)


@inlined
def contact_point(part: Overlap, unit: Frame, top: float) -> Vector:
    """Where a contact acts (m): above the centroid of the overlap, halfway up to the face at `top`."""
    return along(unit.r, 1.0, turned(unit.R, (part.xi, part.eta, top - 0.5 * part.depth)))


@compiled
def pair_contact(
    part: Overlap, shoe: Frame, unit: Frame, patch: Patch, top: float, law: PairLaw, ratio: float
) -> Contact:
    """Contact of a shoe with a unit at a known overlap.

    Parameters
    ----------
    top : float
        Height of the unit's top face above its centre, m.
    ratio : float
        Friction over normal force and slip speed, s/m; `FROM_CURVE` takes it from the friction law.
    """
    normal = upward(unit.R)
    point = contact_point(part, unit, top)
    velocity = along(velocity_at(shoe, point), -1.0, velocity_at(unit, point))
    velocity = along(velocity, 1.0, turned(shoe.R, patch.velocity))
    depth = part.depth - dot(normal, turned(shoe.R, patch.displacement))
    rate = -dot(velocity, normal)
    slip = along(velocity, rate, normal)
    speed = norm(slip)
    force = share_of(part, law) * normal_force(law.law, depth, rate)
    drag = force * (ratio if ratio >= 0.0 else drag_ratio(law.law, speed))
    spin = dot(along(shoe.omega, -1.0, unit.omega), normal)
    torque = spin_torque(law.law, spin, part.area, drag * speed)
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


@compiled
def keep(contact: Contact, shoe: int, unit: int, row: FloatArray) -> None:
    """Write a contact of a shoe and a unit (from 0) into a row of results (RESULTS)."""
    row[0], row[1] = shoe, unit
    row[2], row[3], row[4] = contact.penetration, contact.penetration_rate, contact.area
    for k in range(3):
        row[5 + k] = contact.point[k]
        row[8 + k] = contact.normal_force[k]
        row[11 + k] = contact.friction_force[k]
        row[14 + k] = contact.slip_velocity[k]
        row[17 + k] = contact.friction_torque[k]


@compiled
def keep_patch(rectangle: tuple[float, float, float, float], row: FloatArray) -> None:
    """Write the patch of a contact, as of `pair_track.patch_rectangle`, into a row of results."""
    for k in range(4):
        row[RESULTS - 4 + k] = rectangle[k]
