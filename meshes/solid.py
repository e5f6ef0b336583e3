"""Parametric solid of the shoe, built with the OpenCASCADE kernel of netgen, in shoe axes."""

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

from meshes.geometry import COM_HEIGHT, JOINT_CENTERS, ShoeDimensions

Point = tuple[float, float, float]
Pair = tuple[float, float]


def box(occ: Any, x: Pair, y: Pair, z: Pair) -> Any:
    """Return the box between two positions along each axis."""
    return occ.Box(*(occ.Pnt(*corner) for corner in zip(x, y, z, strict=True)))


def _outline(occ: Any, segments: list[tuple]) -> Any:
    """Return the plane face bounded by ('line', a, b) and ('arc', a, centre, b) segments, in order."""
    edges = [
        occ.Segment(occ.Pnt(*s[1]), occ.Pnt(*s[2])) if s[0] == "line" else _arc(occ, *s[1:]) for s in segments
    ]
    return occ.Face(occ.Wire(edges))


def polygon(occ: Any, corners: list[Point]) -> Any:
    """Return the plane face between corners in order."""
    return _outline(occ, [("line", a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)])


def _arc(occ: Any, start: Point, center: Point, end: Point) -> Any:
    """Return the shorter arc of a circle from start to end."""
    first, last = (tuple(p - c for p, c in zip(point, center, strict=True)) for point in (start, end))
    chord = [a + b for a, b in zip(first, last, strict=True)]
    stretch = math.hypot(*first) / math.hypot(*chord)
    middle = [c + stretch * along for c, along in zip(center, chord, strict=True)]
    return occ.ArcOfCircle(*(occ.Pnt(*point) for point in (start, middle, end)))


def lug(
    occ: Any,
    pin: Point,
    width: float,
    radius: float,
    root_x: float,
    side_fillet: float,
    edge_fillet: float,
) -> Any:
    """Return a lug from a root plane to a round nose about the pin, with fillets on all sides of the root.

    It is the intersection of its plan, extruded upwards, with its side view, extruded sideways.
    """
    x, y, z = pin
    sense = 1.0 if x > root_x else -1.0
    inside = root_x - sense * 0.08

    def flared(half: float, fillet: float, at: Any, tail: list[tuple]) -> Any:
        upper = half + fillet
        lower = -half - fillet
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

    tall = radius + 2 * edge_fillet
    wide = width + 4 * side_fillet
    flare = root_x + sense * side_fillet
    end = x + sense * 2 * radius

    def in_plan(u: float, v: float) -> Point:
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

    def in_side_view(u: float, v: float) -> Point:
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
    return plan.Extrude(occ.Vec(0, 0, 2 * tall)) * side_view.Extrude(occ.Vec(0, wide, 0))


def throat_cutter(occ: Any, pin: Point, width: float, radius: float, fillet: float) -> Any:
    """Return a disc about the pin with rounded rims: the space for the neighbour's rear lug in a fork."""
    x, y, z = pin
    h = width / 2
    inner = h - fillet

    def at(v: float, r: float) -> Point:
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
    return face.Revolve(occ.Axis(occ.Pnt(x, y, z), occ.Dir(0, 1, 0)), 360)


def _beam(occ: Any, shoe: ShoeDimensions) -> Any:
    """Return the cross beam with wings that taper in height and length, from its front view and its plan."""
    half = shoe.width / 2
    plateau = shoe.plateau_half_width
    rear = shoe.beam_center_x - shoe.beam_length / 2

    def in_front_view(y: float, height: float) -> Point:
        return (rear, y, height - COM_HEIGHT)

    def in_plan(y: float, ahead: float) -> Point:
        return (shoe.beam_center_x + ahead, y, -COM_HEIGHT)

    front_view = [
        in_front_view(-half, 0.0),
        in_front_view(half, 0.0),
        in_front_view(half, shoe.wing_tip_height_left),
        in_front_view(plateau, shoe.beam_height),
        in_front_view(-plateau, shoe.beam_height),
        in_front_view(-half, shoe.wing_tip_height_right),
    ]
    tip = shoe.wing_tip_length / 2
    middle = shoe.beam_length / 2
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
    faces = [polygon(occ, corners) for corners in (front_view, plan)]
    return faces[0].Extrude(occ.Vec(shoe.beam_length, 0, 0)) * faces[1].Extrude(
        occ.Vec(0, 0, shoe.beam_height)
    )


def notch_cutter(occ: Any, y: float, half_width: float, depth_x: float, end_x: float, fillet: float) -> Any:
    """Return an upright slot about a lug with rounded inner corners, from depth_x to end_x."""
    bottom = depth_x
    round_end = depth_x + math.copysign(fillet, end_x)
    h = half_width
    inner = half_width - fillet

    def at(x: float, v: float) -> Point:
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
    return face.Extrude(occ.Vec(0, 0, 1.0))


def _top_plate(occ: Any, shoe: ShoeDimensions) -> Any:
    """Return the upper flange of the cross beam, along the slope of the wings and notched at the lugs."""
    half = shoe.width / 2
    plateau = shoe.plateau_half_width
    rear = shoe.beam_center_x - shoe.top_length / 2
    top = [
        (-half, shoe.wing_tip_height_right),
        (-plateau, shoe.beam_height),
        (plateau, shoe.beam_height),
        (half, shoe.wing_tip_height_left),
    ]
    bottom = [(y, height - shoe.top_thickness) for y, height in reversed(top)]
    corners = [(rear, y, height - COM_HEIGHT) for y, height in top + bottom]
    flange = polygon(occ, corners).Extrude(occ.Vec(shoe.top_length, 0, 0))
    for name, (x, y, _) in JOINT_CENTERS.items():
        front = name.startswith("front")
        if front:
            depth = shoe.front_face
            half_width = shoe.fork_width / 2 + shoe.front_notch_margin
        else:
            depth = shoe.rear_face
            half_width = shoe.rear_lug_width / 2 + shoe.rear_notch_margin
        flange -= notch_cutter(occ, y, half_width, depth, 2 * x, shoe.notch_fillet)
    return flange


def _rail(occ: Any, shoe: ShoeDimensions, side: float) -> Any:
    """Return the rail on one side (1 left, -1 right) with its block, from the underside up."""
    rear, front = (shoe.beam_center_x + end * shoe.top_length / 2 for end in (-1.0, 1.0))
    y = side * shoe.rail_center_y
    base = -COM_HEIGHT
    across = (y - shoe.rail_width / 2, y + shoe.rail_width / 2)
    top = base + shoe.path_height
    over = shoe.rail_overhang
    block = box(occ, (rear + over, front - over), across, (base, top))
    if over == 0.0:
        return block
    return block + box(occ, (rear, front), across, (base + shoe.rail_height - shoe.rail_depth, top))


def _cores(occ: Any, shoe: ShoeDimensions) -> Iterator[Any]:
    """Yield the pockets of the beam: below each rail, between them, and two beside each up to the plateau."""
    wall = shoe.core_wall
    base = -COM_HEIGHT
    edges = [shoe.rail_center_y + side * shoe.rail_width / 2 for side in (-1.0, 1.0)]
    edges += [0.5 * (edges[1] + shoe.plateau_half_width), shoe.plateau_half_width]
    walls = [*(-y for y in reversed(edges)), *edges]
    for right, left in pairwise(walls):
        yield box(
            occ,
            (shoe.rear_face + wall, shoe.front_face - wall),
            (right + wall / 2, left - wall / 2),
            (base + shoe.plate_thickness + wall, base + shoe.rail_height - shoe.core_roof),
        )


def _lug_at(occ: Any, shoe: ShoeDimensions, joint: str) -> Any:
    """Return the rear lug of a joint, or its front fork before the throat is cut."""
    pin = JOINT_CENTERS[joint]
    if joint.startswith("rear"):
        fillets = (shoe.rear_root_fillet, shoe.rear_edge_fillet)
        return lug(occ, pin, shoe.rear_lug_width, shoe.rear_lug_radius, shoe.rear_face, *fillets)
    fillet = shoe.cheek_root_fillet
    return lug(occ, pin, shoe.fork_width, shoe.cheek_radius, shoe.front_face, fillet, fillet)


def _pin_cutters(occ: Any, shoe: ShoeDimensions) -> list[Any]:
    """Return the bores of all joints, with named faces, and the throats of the forks."""
    tools = []
    for name, (x, y, z) in JOINT_CENTERS.items():
        reach = 0.55 * shoe.fork_width  # through both cheeks, short of the rails
        bore = occ.Cylinder(occ.Pnt(x, y - reach, z), occ.Dir(0, 1, 0), r=shoe.bore_radius, h=2 * reach)
        bore.faces.name = f"bore {name}"
        tools.append(bore)
        if name.startswith("front"):
            radius = shoe.rear_lug_radius + shoe.nose_clearance
            tools.append(throat_cutter(occ, (x, y, z), shoe.fork_gap, radius, shoe.throat_fillet))
    return tools


def build_solid(occ: Any, shoe: ShoeDimensions) -> Any:
    """Build the shoe's solid.

    Parameters
    ----------
    occ : module
        `netgen.occ`.
    shoe : ShoeDimensions
        Dimensions in m.

    Returns
    -------
    netgen.occ.TopoDS_Shape
        Single solid in shoe axes with named bore faces.

    Raises
    ------
    ValueError
        If the dimensions make several solids.
    """
    base = -COM_HEIGHT
    body = box(
        occ,
        (-shoe.plate_length / 2, shoe.plate_length / 2),
        (-shoe.width / 2, shoe.width / 2),
        (base, base + shoe.plate_thickness),
    )
    parts = [_beam(occ, shoe), _top_plate(occ, shoe)]
    parts += [_rail(occ, shoe, side) for side in (-1.0, 1.0)]
    parts += [_lug_at(occ, shoe, joint) for joint in JOINT_CENTERS]
    for part in parts:
        body += part
    for tool in (*_pin_cutters(occ, shoe), *(_cores(occ, shoe) if shoe.core_wall else ())):
        body -= tool
    if len(body.solids) != 1:
        raise ValueError(f"dimensions must make one solid, got {len(body.solids)} separate ones with {shoe}")
    return body
