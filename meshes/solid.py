"""Parametric solid of the shoe, built with the OpenCASCADE kernel of gmsh, in shoe axes."""

import math
from typing import Any

from meshes.geometry import COM_HEIGHT, JOINT_CENTERS, ShoeDimensions


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
            ("arc", at(-h, radius - fillet), at(-h + fillet, radius - fillet), at(-h + fillet, radius)),
            ("line", at(-h + fillet, radius), at(inner, radius)),
            ("arc", at(inner, radius), at(inner, radius - fillet), at(h, radius - fillet)),
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


def _rail(occ: Any, shoe: ShoeDimensions, side: float) -> int:
    """Rail on one side (1 left, -1 right), from the underside up."""
    rear = shoe.beam_center_x - shoe.top_length / 2
    y, base = side * shoe.rail_center_y, -COM_HEIGHT
    return _box(
        occ,
        (rear, rear + shoe.top_length),
        (y - shoe.rail_width / 2, y + shoe.rail_width / 2),
        (base, base + shoe.rail_height),
    )


def _lug_at(occ: Any, shoe: ShoeDimensions, joint: str) -> int:
    """Rear lug of a joint, or the fork in front before its throat is cut."""
    pin = JOINT_CENTERS[joint]
    if joint.startswith("rear"):
        fillets = (shoe.rear_root_fillet, shoe.rear_edge_fillet)
        return _lug(occ, pin, shoe.rear_lug_width, shoe.rear_lug_radius, shoe.rear_face, *fillets)
    fillet = shoe.cheek_root_fillet
    return _lug(occ, pin, shoe.fork_width, shoe.cheek_radius, shoe.front_face, fillet, fillet)


def _pin_cutters(occ: Any, shoe: ShoeDimensions) -> list[int]:
    """Bores of all joints and the throats of the forks."""
    tools = []
    for name, (x, y, z) in JOINT_CENTERS.items():
        reach = 0.55 * shoe.fork_width  # through both cheeks, short of the rails
        tools.append(occ.addCylinder(x, y - reach, z, 0, 2 * reach, 0, shoe.bore_radius))
        if name.startswith("front"):
            radius = shoe.rear_lug_radius + shoe.nose_clearance
            tools.append(_throat_cutter(occ, (x, y, z), shoe.fork_gap, radius, shoe.throat_fillet))
    return tools


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

    Raises
    ------
    ValueError
        If the dimensions make several solids.
    """
    base = -COM_HEIGHT
    plate = _box(
        occ,
        (-shoe.plate_length / 2, shoe.plate_length / 2),
        (-shoe.width / 2, shoe.width / 2),
        (base, base + shoe.plate_thickness),
    )
    parts = [_beam(occ, shoe), _top_plate(occ, shoe)]
    parts += [_rail(occ, shoe, side) for side in (-1.0, 1.0)]
    parts += [_lug_at(occ, shoe, joint) for joint in JOINT_CENTERS]
    body, _ = occ.fuse([(3, plate)], [(3, part) for part in parts])
    body, _ = occ.cut(body, [(3, tool) for tool in _pin_cutters(occ, shoe)])
    if len(body) != 1:
        raise ValueError(f"dimensions must make one solid, got {len(body)} separate ones with {shoe}")
    return body[0][1]
