"""Parametric solid of a crawler shoe, built with the OpenCASCADE kernel of gmsh.

Shoe axes: x along the propel direction, y lateral, z up; origin at the nominal centre of mass.
Only whoever rebuilds the meshes needs gmsh; the dimensions themselves need nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

PITCH = 0.655742
"""Distance between the pins of neighbouring shoes in m (spacing of the papers' centres of mass)."""

COM_HEIGHT = 0.2025
"""Nominal height of the centre of mass above the underside in m."""

PIN_HEIGHT = 0.0475
"""z of all pin axes in m, in shoe axes (pins 0.25 m above the underside)."""

FRONT_PIN_X = 0.3088
"""x of the front pin axis in m, in shoe axes."""

REAR_PIN_X = FRONT_PIN_X - PITCH
"""x of the rear pin axis in m; a neighbour one pitch behind has its front pin exactly there."""

TRACK_Y = 9.2901
"""y of the track's centres of mass in m, in the papers' global axes."""

TRACK_PIN_Y = {"right": 8.68, "left": 10.03}
"""y of the track's joint centres in m, in the papers' global axes."""

PIN_Y = {side: y - TRACK_Y for side, y in TRACK_PIN_Y.items()}
"""y of the joint centres in m; left is +y for somebody who looks along +x."""

JOINT_CENTERS: dict[str, tuple[float, float, float]] = {
    f"{end} {side}": (x, y, PIN_HEIGHT)
    for end, x in (("front", FRONT_PIN_X), ("rear", REAR_PIN_X))
    for side, y in PIN_Y.items()
}
"""Joint centres in shoe axes in m, by interface name."""


@dataclass(frozen=True)
class ShoeDimensions:
    """Dimensions of the shoe in m; heights are above the underside unless said otherwise."""

    width: float = 3.505
    plate_length: float = 0.63
    plate_thickness: float = 0.036
    beam_length: float = 0.336
    beam_center_x: float = 0.0043
    beam_height: float = 0.396
    plateau_half_width: float = 1.0
    wing_tip_length: float = 0.17
    wing_tip_height_right: float = 0.4085
    wing_tip_height_left: float = 0.3915
    top_length: float = 0.60
    top_thickness: float = 0.042
    front_notch_margin: float = 0.03
    rear_notch_margin: float = 0.085
    notch_fillet: float = 0.04
    rail_center_y: float = 0.24
    rail_width: float = 0.22
    rail_height: float = 0.426
    bore_radius: float = 0.065
    rear_lug_width: float = 0.165
    rear_lug_radius: float = 0.12
    rear_root_fillet: float = 0.04
    rear_edge_fillet: float = 0.02
    cheek_width: float = 0.09
    cheek_radius: float = 0.11
    cheek_root_fillet: float = 0.03
    throat_fillet: float = 0.02
    side_clearance: float = 0.0125
    nose_clearance: float = 0.012

    @property
    def rear_face(self) -> float:
        """X of the beam's rear face in m, where the rear lugs have their roots."""
        return self.beam_center_x - self.beam_length / 2

    @property
    def front_face(self) -> float:
        """X of the beam's front face in m, where the forks have their roots."""
        return self.beam_center_x + self.beam_length / 2

    @property
    def fork_gap(self) -> float:
        """Width of the room between the cheeks of a fork in m."""
        return self.rear_lug_width + 2 * self.side_clearance

    @property
    def fork_width(self) -> float:
        """Width of a fork over both cheeks in m."""
        return self.fork_gap + 2 * self.cheek_width


def _box(occ: Any, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> int:
    return occ.addBox(x[0], y[0], z[0], x[1] - x[0], y[1] - y[0], z[1] - z[0])


def _outline(occ: Any, segments: list[tuple]) -> int:
    """Plane face bounded by ('line', a, b) and ('arc', a, centre, b) segments, in order."""
    points: dict[tuple[float, ...], int] = {}

    def point(p: tuple[float, ...]) -> int:
        key = tuple(round(c, 9) for c in p)
        if key not in points:
            points[key] = occ.addPoint(*p)
        return points[key]

    curves = [
        occ.addLine(point(s[1]), point(s[2]))
        if s[0] == "line"
        else occ.addCircleArc(point(s[1]), point(s[2]), point(s[3]))
        for s in segments
    ]
    return occ.addPlaneSurface([occ.addCurveLoop(curves)])


def _extrude(occ: Any, face: int, dx: float, dy: float, dz: float) -> int:
    return next(tag for dim, tag in occ.extrude([(2, face)], dx, dy, dz) if dim == 3)


def _lug(
    occ: Any,
    pin: tuple[float, float, float],
    width: float,
    radius: float,
    root_x: float,
    side_fillet: float,
    edge_fillet: float,
) -> int:
    """Lug from a root plane to a round nose about the pin, flaring into the root on all sides.

    It is the common part of its plan, extruded upwards, and of its side view, extruded sideways.
    """
    x, y, z = pin
    sense = 1.0 if x > root_x else -1.0
    inside = root_x - sense * 0.08

    def flared(half: float, fillet: float, at: Any, tail: list[tuple]) -> int:
        upper, lower = half + fillet, -half - fillet
        flare = root_x + sense * fillet
        return _outline(
            occ,
            [
                ("line", at(inside, lower), at(inside, upper)),
                ("line", at(inside, upper), at(root_x, upper)),
                ("arc", at(root_x, upper), at(flare, upper), at(flare, half)),
                *tail,
                ("arc", at(flare, -half), at(flare, lower), at(root_x, lower)),
                ("line", at(root_x, lower), at(inside, lower)),
            ],
        )

    tall, wide = radius + 2 * edge_fillet, width + 4 * side_fillet
    flare = root_x + sense * side_fillet
    end = x + sense * 2 * radius

    def in_plan(u: float, v: float) -> tuple[float, float, float]:
        return (u, y + v, z - tall)

    plan = flared(
        width / 2,
        side_fillet,
        in_plan,
        [
            ("line", in_plan(flare, width / 2), in_plan(end, width / 2)),
            ("line", in_plan(end, width / 2), in_plan(end, -width / 2)),
            ("line", in_plan(end, -width / 2), in_plan(flare, -width / 2)),
        ],
    )

    def in_side_view(u: float, v: float) -> tuple[float, float, float]:
        return (u, y - wide / 2, z + v)

    nose = x + sense * radius
    flare = root_x + sense * edge_fillet
    side_view = flared(
        radius,
        edge_fillet,
        in_side_view,
        [
            ("line", in_side_view(flare, radius), in_side_view(x, radius)),
            ("arc", in_side_view(x, radius), in_side_view(x, 0.0), in_side_view(nose, 0.0)),
            ("arc", in_side_view(nose, 0.0), in_side_view(x, 0.0), in_side_view(x, -radius)),
            ("line", in_side_view(x, -radius), in_side_view(flare, -radius)),
        ],
    )
    bodies = (_extrude(occ, plan, 0, 0, 2 * tall), _extrude(occ, side_view, 0, wide, 0))
    common, _ = occ.intersect([(3, bodies[0])], [(3, bodies[1])])
    return common[0][1]


def _throat_cutter(
    occ: Any, pin: tuple[float, float, float], width: float, radius: float, fillet: float
) -> int:
    """Disc about the pin with rounded rims: the room for the neighbour's rear lug in a fork."""
    x, y, z = pin
    h = width / 2
    inner = h - fillet

    def at(v: float, r: float) -> tuple[float, float, float]:
        return (x, y + v, z + r)

    face = _outline(
        occ,
        [
            ("line", at(-h, 0), at(-h, radius - fillet)),
            (
                "arc",
                at(-h, radius - fillet),
                at(-h + fillet, radius - fillet),
                at(-h + fillet, radius),
            ),
            ("line", at(-h + fillet, radius), at(inner, radius)),
            (
                "arc",
                at(inner, radius),
                at(inner, radius - fillet),
                at(h, radius - fillet),
            ),
            ("line", at(h, radius - fillet), at(h, 0)),
            ("line", at(h, 0), at(-h, 0)),
        ],
    )
    turned = occ.revolve([(2, face)], x, y, z, 0, 1, 0, 2 * math.pi)
    return next(tag for dim, tag in turned if dim == 3)


def _beam(occ: Any, shoe: ShoeDimensions) -> int:
    """Cross beam with wings that taper in height and in length: its front view and its plan."""
    half, plateau = shoe.width / 2, shoe.plateau_half_width
    rear = shoe.beam_center_x - shoe.beam_length / 2

    def in_front_view(y: float, height: float) -> tuple[float, float, float]:
        return (rear, y, height - COM_HEIGHT)

    def in_plan(y: float, ahead: float) -> tuple[float, float, float]:
        return (shoe.beam_center_x + ahead, y, -COM_HEIGHT)

    front_view = [
        in_front_view(-half, 0.0),
        in_front_view(half, 0.0),
        in_front_view(half, shoe.wing_tip_height_left),
        in_front_view(plateau, shoe.beam_height),
        in_front_view(-plateau, shoe.beam_height),
        in_front_view(-half, shoe.wing_tip_height_right),
    ]
    tip, middle = shoe.wing_tip_length / 2, shoe.beam_length / 2
    plan = [
        in_plan(-half, -tip),
        in_plan(-plateau, -middle),
        in_plan(plateau, -middle),
        in_plan(half, -tip),
        in_plan(half, tip),
        in_plan(plateau, middle),
        in_plan(-plateau, middle),
        in_plan(-half, tip),
    ]
    faces = [
        _outline(occ, [("line", a, b) for a, b in zip(c, c[1:] + c[:1], strict=True)])
        for c in (front_view, plan)
    ]
    bodies = (
        _extrude(occ, faces[0], shoe.beam_length, 0, 0),
        _extrude(occ, faces[1], 0, 0, shoe.beam_height),
    )
    common, _ = occ.intersect([(3, bodies[0])], [(3, bodies[1])])
    return common[0][1]


def _notch_cutter(occ: Any, y: float, half_width: float, depth_x: float, end_x: float, fillet: float) -> int:
    """Upright slot about a lug with rounded inner corners, from depth_x to end_x."""
    bottom, round_end = depth_x, depth_x + math.copysign(fillet, end_x)
    h, inner = half_width, half_width - fillet

    def at(x: float, v: float) -> tuple[float, float, float]:
        return (x, y + v, 0.0)

    face = _outline(
        occ,
        [
            ("line", at(end_x, -h), at(round_end, -h)),
            ("arc", at(round_end, -h), at(round_end, -inner), at(bottom, -inner)),
            ("line", at(bottom, -inner), at(bottom, inner)),
            ("arc", at(bottom, inner), at(round_end, inner), at(round_end, h)),
            ("line", at(round_end, h), at(end_x, h)),
            ("line", at(end_x, h), at(end_x, -h)),
        ],
    )
    return _extrude(occ, face, 0, 0, 1.0)


def _top_plate(occ: Any, shoe: ShoeDimensions) -> int:
    """Upper flange of the cross beam, following the slope of the wings, notched at the lugs."""
    half, plateau = shoe.width / 2, shoe.plateau_half_width
    rear = shoe.beam_center_x - shoe.top_length / 2
    top = [
        (-half, shoe.wing_tip_height_right),
        (-plateau, shoe.beam_height),
        (plateau, shoe.beam_height),
        (half, shoe.wing_tip_height_left),
    ]
    bottom = [(y, height - shoe.top_thickness) for y, height in reversed(top)]
    corners = [(rear, y, height - COM_HEIGHT) for y, height in top + bottom]
    face = _outline(occ, [("line", a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)])
    flange = _extrude(occ, face, shoe.top_length, 0, 0)
    tools = []
    for name, (x, y, _) in JOINT_CENTERS.items():
        front = name.startswith("front")
        if front:
            depth, half_width = shoe.front_face, shoe.fork_width / 2 + shoe.front_notch_margin
        else:
            depth, half_width = shoe.rear_face, shoe.rear_lug_width / 2 + shoe.rear_notch_margin
        tools.append(_notch_cutter(occ, y, half_width, depth, 2 * x, shoe.notch_fillet))
    body, _ = occ.cut([(3, flange)], [(3, tool) for tool in tools])
    return body[0][1]


def build_solid(occ: Any, shoe: ShoeDimensions) -> int:
    """Make the shoe's solid in an open gmsh model.

    Parameters
    ----------
    occ : gmsh.model.occ
        The OpenCASCADE part of the gmsh interface; the caller synchronizes it.
    shoe : ShoeDimensions
        Dimensions in m.

    Returns
    -------
    int
        Tag of the one solid, in shoe axes.
    """
    base = -COM_HEIGHT
    half = shoe.width / 2

    plate = _box(
        occ,
        (-shoe.plate_length / 2, shoe.plate_length / 2),
        (-half, half),
        (base, base + shoe.plate_thickness),
    )

    rear = shoe.beam_center_x - shoe.top_length / 2
    parts = [_beam(occ, shoe), _top_plate(occ, shoe)]
    for side in (-1.0, 1.0):
        y = side * shoe.rail_center_y
        parts.append(
            _box(
                occ,
                (rear, rear + shoe.top_length),
                (y - shoe.rail_width / 2, y + shoe.rail_width / 2),
                (base, base + shoe.rail_height),
            )
        )
    for name, pin in JOINT_CENTERS.items():
        if name.startswith("rear"):
            parts.append(
                _lug(
                    occ,
                    pin,
                    shoe.rear_lug_width,
                    shoe.rear_lug_radius,
                    shoe.rear_face,
                    shoe.rear_root_fillet,
                    shoe.rear_edge_fillet,
                )
            )
        else:
            parts.append(
                _lug(
                    occ,
                    pin,
                    shoe.fork_width,
                    shoe.cheek_radius,
                    shoe.front_face,
                    shoe.cheek_root_fillet,
                    shoe.cheek_root_fillet,
                )
            )
    body, _ = occ.fuse([(3, plate)], [(3, part) for part in parts])

    tools = []
    for name, (x, y, z) in JOINT_CENTERS.items():
        reach = 0.55 * shoe.fork_width  # through both cheeks, short of the rails
        tools.append(occ.addCylinder(x, y - reach, z, 0, 2 * reach, 0, shoe.bore_radius))
        if name.startswith("front"):
            radius = shoe.rear_lug_radius + shoe.nose_clearance
            tools.append(_throat_cutter(occ, (x, y, z), shoe.fork_gap, radius, shoe.throat_fillet))
    body, _ = occ.cut(body, [(3, tool) for tool in tools])
    if len(body) != 1:
        raise ValueError(f"the dimensions make {len(body)} separate solids, not one shoe: {shoe}")
    return body[0][1]
