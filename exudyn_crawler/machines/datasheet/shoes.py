"""Shoe and chain of a datasheet: plate and link scaled by the pitch, with derived or printed weight."""

import math

import numpy as np

from exudyn_crawler.case.parameters.pin import LinkPin, PinKind
from exudyn_crawler.case.parameters.track import Rails, Shoe, Track
from exudyn_crawler.machines.datasheet import rules, travel
from exudyn_crawler.machines.datasheet.chain import Chain
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from exudyn_crawler.machines.datasheet.shoe_mesh import MeshShoe

FADING = 0.1  # turning rate of a hinge with 0.7 of the friction over the rate of the sprocket
RAIL_SHARE = 0.98  # length of a rail over the pitch, so that neighbours do not overlap


def shoe_of(sheet: Datasheet, chain: Chain, of_mesh: MeshShoe | None = None) -> Shoe:
    """Return the shoe of a mesh, or a plate with a link, both with the masses of boxes.

    The underside of the box shoe is at the grouser tips. The link lies between the plate and the top of the
    rails.
    """
    if of_mesh is not None:
        return of_mesh.shoe
    pitch = chain.pitch
    width = sheet.shoe_width
    link_height = pitch * sheet.typical_value("link_height")
    rail_y = pitch * sheet.typical_value("rail_place")
    rail_width = pitch * sheet.typical_value("rail_width")
    plate = sheet.typical_value("plate_mass") * pitch**2 * width
    link = sheet.typical_value("link_mass") * pitch**3
    mass = plate + link
    if sheet.shoe_weight is not None:
        plate, link = (sheet.shoe_weight * part / mass for part in (plate, link))
        mass = sheet.shoe_weight
    # heights above the underside
    seat = chain.grouser + pitch * sheet.typical_value("plate_thickness")
    link_top = seat + link_height
    heights = 0.5 * seat, 0.5 * (seat + link_top)
    com = (plate * heights[0] + link * heights[1]) / mass
    boxes = (
        rules.box_inertia(plate, pitch, width, seat),
        rules.box_inertia(link, pitch, min(width, 2.0 * rail_y + rail_width), link_height),
    )
    shifts = [part * (height - com) ** 2 for part, height in zip((plate, link), heights, strict=True)]
    inertia = sum(boxes) + np.array([sum(shifts), sum(shifts), 0.0])
    half = 0.5 * RAIL_SHARE * pitch
    top = link_top - com
    rails = Rails(rear=-half, front=half, right=-rail_y, left=rail_y, width=rail_width, height=top)
    return Shoe(
        mass=mass,
        inertia=(*inertia.tolist(), 0.0, 0.0, 0.0),
        com_height=com,
        length=pitch,
        width=width,
        underside_center=(0.0, 0.0),
        load_point=(0.0, 0.0, top),
        rails=rails,
    )


def pin_of(sheet: Datasheet, chain: Chain) -> LinkPin:
    """Return the pins of the chain by the kind of machine; those of shovels have no friction.

    Pins of cast shoes run dry, with millimetres of play. Their friction without this play would hold the sag
    of the chain, whose tension then rises several times as a shoe comes on to the tumbler.
    """
    usual: dict[str, PinKind] = {"shovel": "ideal", "dozer": "sealed", "vehicle": "rubber"}
    rate = travel.run_speed(sheet) / (chain.built_gaps * chain.pitch / (2.0 * math.pi))
    return LinkPin(kind=usual.get(sheet.kind, "greased"), friction_rate=FADING * rate)


def track_of(sheet: Datasheet, chain: Chain, shoe: Shoe, of_mesh: MeshShoe | None = None) -> Track:
    """Return the chain of both tracks; its pins are those of a mesh, or end at the rails' middles."""
    right = -0.5 * sheet.track_gauge
    if of_mesh is not None:
        return Track(
            shoe_count=2 * chain.shoes,
            first_com=(0.0, right),
            pitch=chain.pitch,
            pin_ahead=of_mesh.pin_ahead,
            pin_height=of_mesh.pin_height,
            spherical_y=right + of_mesh.joint_y[0],
            parallel_y=right + of_mesh.joint_y[1],
            pin=pin_of(sheet, chain),
        )
    rails = shoe.roller_path
    return Track(
        shoe_count=2 * chain.shoes,
        first_com=(0.0, right),
        pitch=chain.pitch,
        pin_ahead=0.5 * chain.pitch,
        pin_height=chain.tips - shoe.com_height,
        spherical_y=right + rails.right,
        parallel_y=right + rails.left,
        pin=pin_of(sheet, chain),
    )
