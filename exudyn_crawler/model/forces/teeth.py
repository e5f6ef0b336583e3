"""Contact of the lugs of shoes with the teeth of a drive tumbler, and the lateral guide of shoes there.

A gap between two teeth is a concave arc about a centre on a circle of the tumbler, in its x-z plane. Straight
flanks may follow; at the addendum circle the gap ends in a corner. A lug is a circle about a marker of its
shoe. It touches the arc of the gap that is nearest by its angle, beyond the arc's end the flank, and beyond
the flank the corner. Penetration and force are continuous. The force acts along the line from the arc's
centre, across the flank, or from the corner to the lug's centre, so that it turns neither. The chain on a
half-pitch sprocket uses every second gap, which is also the nearest one. A flexible shoe receives the force
at the marker, at a bore.

Across the tumbler a lug has play between flanges. Their force grows to its full value as the lug enters the
gap between the teeth.
"""

import math
from typing import NamedTuple

import numpy as np

from exudyn_crawler.case.parameters.tooth_profile import ToothProfile
from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.frames import along, cross, dot, turned, turned_back
from exudyn_crawler.ground.laws import Impact, step
from exudyn_crawler.ground.packed import FloatArray, Floats1, Floats2, Ints1
from exudyn_crawler.ground.rows import ForceRows, Weights
from exudyn_crawler.model.bodies import Bodies, attitude_of, frame_of, moved, read_body
from exudyn_crawler.model.forces.impact import Flange, flange_force, law_slopes, stored_energy
from exudyn_crawler.model.markers import NOTHING, Markers, end_of, write_point

SLACK = 0.02
"""Distance (m) that exceeds any displacement of a lug by bending."""
ASIDE = 0.1
"""Upper limit (m) on the additional distance of a shoe beside its tumbler's middle plane."""


class Teeth(NamedTuple):
    """Lugs of all shoes and the tumblers that they touch; l of them."""

    markers: Ints1  # (l,): centre of each lug
    tumblers: Ints1  # (l,): body that it meets
    side: Floats1  # (l,): y of its gear plane in the tumbler, m
    profile: ToothProfile
    law: Impact
    flange: Flange


class TeethWorkspace(NamedTuple):
    """Contacts of lugs at a state."""

    rows: ForceRows  # those that touch: force on the shoe, N, global
    depth: Floats1  # (l,): m; no touch unless positive
    force: Floats2  # (l, 3): on the shoe, N, global
    moment: Floats2  # (l, 3): of it about the shoe's COM, N m, global
    guide: Floats1  # (l,): part of the force across the tumbler, N
    energy: Floats1  # (1,): in the teeth, J

    @classmethod
    def allocate(cls, lugs: int, modes: int) -> "TeethWorkspace":
        """Return a workspace for `lugs` lugs."""
        rows = ForceRows.allocate(lugs, 3, modes)
        return cls(
            rows=rows,
            depth=np.zeros(lugs),
            force=np.zeros((lugs, 3)),
            moment=np.zeros((lugs, 3)),
            guide=np.zeros(lugs),
            energy=np.zeros(1),
        )


@kernel
def tooth(profile: ToothProfile, x: float, z: float) -> tuple[float, float, float, float]:
    """Return the penetration into the teeth of a lug's centre at x and z in the tumbler's axes.

    Returns
    -------
    tuple
        Depth (m), x and z of the normal, from the tooth to the lug, and the rotation of the normal for each m
        of motion of the lug across it (1/m), positive if this moves the lug back.
    """
    angle = 2.0 * math.pi / profile.gaps
    k = round(math.atan2(z, x) / angle)
    cx = profile.center * math.cos(k * angle)
    cz = profile.center * math.sin(k * angle)
    dx = x - cx
    dz = z - cz
    distance = math.sqrt(dx * dx + dz * dz)
    if distance < 1e-12:
        return profile.lug - profile.arc, 1.0, 0.0, 0.0
    inward = (-cx / profile.center, -cz / profile.center)
    limit = (profile.center**2 + profile.arc**2 - profile.rim**2) / (2.0 * profile.center * profile.arc)
    if dx * inward[0] + dz * inward[1] >= limit * distance:
        return distance - (profile.arc - profile.lug), -dx / distance, -dz / distance, 1.0 / distance
    side = 1.0 if dz * inward[0] - dx * inward[1] > 0.0 else -1.0
    end = side * math.sqrt(max(0.0, 1.0 - limit * limit))
    # out of the gap, along the flank
    tx = -abs(end) * inward[0] - side * limit * inward[1]
    tz = -abs(end) * inward[1] + side * limit * inward[0]
    ex = x - cx - profile.arc * (limit * inward[0] - end * inward[1])
    ez = z - cz - profile.arc * (limit * inward[1] + end * inward[0])
    if profile.flank > 0.0 and ex * tx + ez * tz < profile.flank:
        nx, nz = -(limit * inward[0] - end * inward[1]), -(limit * inward[1] + end * inward[0])
        return profile.lug - (ex * nx + ez * nz), nx, nz, 0.0
    ex -= profile.flank * tx
    ez -= profile.flank * tz
    distance = math.sqrt(ex * ex + ez * ez)
    return profile.lug - distance, ex / distance, ez / distance, -1.0 / distance


@inner(allocates=True)
def write_rows(
    teeth: Teeth,
    bodies: Bodies,
    markers: Markers,
    state: FloatArray,
    weights: Weights,
    work: TeethWorkspace,
) -> None:
    """Write the rows of the lugs that touch at a state."""
    rows = work.rows
    count = 0
    profile = teeth.profile
    values = np.zeros((2, 6 + markers.displacement.shape[2]))
    work.energy[0] = 0.0
    for k in range(teeth.markers.shape[0]):
        work.depth[k] = 0.0
        work.guide[k] = 0.0
        for c in range(3):
            work.force[k, c] = work.moment[k, c] = 0.0
        marker = teeth.markers[k]
        t = teeth.tumblers[k]
        b = markers.body[marker]
        first = bodies.coordinate[b]
        other = bodies.coordinate[t]
        dx = bodies.reference[b, 0] + state[0, first] - bodies.reference[t, 0] - state[0, other]
        dy = bodies.reference[b, 1] + state[0, first + 1] - bodies.reference[t, 1] - state[0, other + 1]
        dz = bodies.reference[b, 2] + state[0, first + 2] - bodies.reference[t, 2] - state[0, other + 2]
        lever = math.sqrt(markers.position[marker, 0] ** 2 + markers.position[marker, 2] ** 2) + SLACK
        if math.sqrt(dx * dx + dy * dy + dz * dz) > profile.addendum + profile.lug + lever + ASIDE:
            continue
        attitude, of_shoe = attitude_of(bodies, t), attitude_of(bodies, b)
        tumbler, shoe = frame_of(bodies, t, state, attitude), frame_of(bodies, b, state, of_shoe)
        if markers.modes[marker] > 0:
            read_body(bodies, b, state[0], values[0])
            read_body(bodies, b, state[1], values[1])
        arm = end_of(markers, marker, of_shoe, values[0]).lever
        from_axis = along(along(shoe.r, 1.0, arm), -1.0, tumbler.r)
        local = turned_back(tumbler.R, from_axis)
        inside = profile.addendum + profile.lug - math.sqrt(local[0] ** 2 + local[2] ** 2)
        if inside <= 0.0:
            continue
        depth, nx, nz, turn = tooth(profile, local[0], local[2])
        velocity = along(shoe.v, 1.0, cross(shoe.omega, arm))
        if markers.modes[marker] > 0:
            bent = moved(NOTHING, markers.displacement[marker], values[1])
            velocity = along(velocity, 1.0, turned(shoe.R, bent))
        velocity = along(along(velocity, -1.0, tumbler.v), -1.0, cross(tumbler.omega, from_axis))
        normal, across = turned(tumbler.R, (nx, 0.0, nz)), attitude.axes[1]
        force, by_depth, by_rate = law_slopes(teeth.law, depth, -dot(normal, velocity))
        engaged, off = step(inside, 0.0, 0.0, profile.lug, 1.0), local[1] - teeth.side[k]
        sideways, stiff, damped = flange_force(teeth.flange, off, dot(across, velocity))
        sideways, stiff, damped = engaged * sideways, engaged * stiff, engaged * damped
        if force <= 0.0 and sideways == 0.0:
            continue
        tangential = cross(across, normal)
        whole = along(along(NOTHING, force, normal), sideways, across)
        work.depth[k], work.guide[k] = max(depth, 0.0), sideways
        work.energy[0] += stored_energy(teeth.law, depth)
        rows.bodies[count, 0], rows.bodies[count, 1], rows.unit[count] = b, t, -1
        shapes = markers.displacement[marker]
        write_point(of_shoe, arm, shapes, markers.modes[marker], 1.0, rows.jacobian[count, 0])
        write_point(attitude, from_axis, shapes, np.int64(0), -1.0, rows.jacobian[count, 1])
        moment = cross(arm, whole)
        for r in range(3):
            rows.wrench[count, r] = work.force[k, r] = whole[r]
            work.moment[k, r] = moment[r]
        if weights.position != 0.0 or weights.velocity != 0.0:
            along_normal = weights.position * by_depth + weights.velocity * by_rate
            along_tangent = weights.position * force * turn
            along_axis = weights.position * stiff + weights.velocity * damped
            for r in range(3):
                for c in range(3):
                    rows.tangent[count, r, c] = (
                        along_normal * normal[r] * normal[c]
                        + along_tangent * tangential[r] * tangential[c]
                        + along_axis * across[r] * across[c]
                    )
        count += 1
    rows.acting[0] = count
