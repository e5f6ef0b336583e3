"""Shoe of a datasheet: plate and link by the pitch, its weight by rule or as printed, and the chain of it."""

from typing import Any

import numpy as np

from exudyn_crawler.case.datasheet import rules
from exudyn_crawler.case.datasheet.chain import Chain
from exudyn_crawler.case.datasheet.notes import Notes
from exudyn_crawler.case.datasheet.sheet import Datasheet
from exudyn_crawler.case.datasheet.shoe_mesh import MeshShoe
from exudyn_crawler.case.parameters.track import Rails, Shoe, Track

OF_MESH = "shoe_mesh: its volume of steel, its surfaces and bores"
RAIL_SHARE = 0.98  # of the pitch: length of a rail, so that neighbours do not overlap


def shoe_of(sheet: Datasheet, chain: Chain, notes: Notes, of_mesh: MeshShoe | None = None) -> Shoe:
    """Shoe of a mesh, or a plate that carries a link, whose masses are those of boxes.

    The underside of these is at the tips of the grousers. The link lies between the plate and the top of the
    rails.
    """
    if of_mesh is not None:
        for name in (*Shoe.model_fields, *(f"rails.{field}" for field in Rails.model_fields)):
            notes.note(f"shoe.{name}", None, "", "derived", OF_MESH)
        return of_mesh.shoe
    pitch = chain.pitch
    width = sheet.shoe_width
    link_height = pitch * notes.typical("link_height")
    rail_y = notes.sized("shoe.rails.left", "rail_place", pitch)
    rail_width = notes.sized("shoe.rails.width", "rail_width", pitch)
    plate = notes.typical("plate_mass") * pitch**2 * width
    link = notes.typical("link_mass") * pitch**3
    mass = plate + link
    how = "plate by pitch squared and width, and link by pitch cubed"
    if sheet.shoe_weight is not None:
        plate, link = (sheet.shoe_weight * part / mass for part in (plate, link))
        mass = sheet.shoe_weight
    else:
        notes.note("shoe.mass", mass, "kg", "derived", how)
    # heights above the underside
    seat = chain.grouser + pitch * notes.typical("plate_thickness")
    link_top = seat + link_height
    heights = 0.5 * seat, 0.5 * (seat + link_top)
    com = (plate * heights[0] + link * heights[1]) / mass
    boxes = (
        rules.box_inertia(plate, pitch, width, seat),
        rules.box_inertia(link, pitch, min(width, 2.0 * rail_y + rail_width), link_height),
    )
    shifts = [part * (height - com) ** 2 for part, height in zip((plate, link), heights, strict=True)]
    inertia = sum(boxes) + np.array([sum(shifts), sum(shifts), 0.0])
    how = "boxes of plate and link"
    for path, value, unit in (
        ("inertia", (*inertia.tolist(), 0.0, 0.0, 0.0), "kg m2"),
        ("com_height", com, "m"),
    ):
        notes.note(f"shoe.{path}", value, unit, "derived", how)
    half = 0.5 * RAIL_SHARE * pitch
    notes.note("shoe.length", pitch, "m", "derived", "plates tile the ground")
    top = link_top - com
    notes.note("shoe.rails.height", top, "m", "derived", "link's height above the plate")
    for name in ("rear", "front"):
        how = f"length of {RAIL_SHARE:g} pitches, so that neighbours do not overlap"
        notes.note(f"shoe.rails.{name}", None, "", "derived", how)
    notes.note("shoe.rails.right", None, "", "derived", "mirrored: that on the left")
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


def track_of(
    sheet: Datasheet, chain: Chain, shoe: Shoe, notes: Notes, of_mesh: MeshShoe | None = None
) -> Track:
    """Chain of both tracks, whose pins are those of a mesh or end at the rails' middles."""
    right = -0.5 * sheet.track_gauge
    notes.note("track.first_com", None, "", "derived", "half of the gauge")
    if of_mesh is not None:
        for name in ("pitch", "pin_ahead", "pin_height", "spherical_y", "parallel_y"):
            notes.note(f"track.{name}", None, "", "derived", OF_MESH)
        return Track(
            shoe_count=2 * chain.shoes,
            first_com=(0.0, right),
            pitch=chain.pitch,
            pin_ahead=of_mesh.pin_ahead,
            pin_height=of_mesh.pin_height,
            spherical_y=right + of_mesh.joint_y[0],
            parallel_y=right + of_mesh.joint_y[1],
        )
    rails = shoe.rails
    assert rails is not None
    values: dict[str, Any] = {
        "pitch": chain.pitch,
        "pin_ahead": 0.5 * chain.pitch,
        "pin_height": chain.tips - shoe.com_height,
        "spherical_y": right + rails.right,
        "parallel_y": right + rails.left,
    }
    notes.note("track.pin_ahead", values["pin_ahead"], "m", "derived", "half of the pitch")
    notes.note(
        "track.pin_height", values["pin_height"], "m", "derived", "pins above the underside less the COM"
    )
    for name in ("spherical_y", "parallel_y"):
        notes.note(f"track.{name}", values[name], "m", "derived", "in the middle of a rail")
    return Track(shoe_count=2 * chain.shoes, first_com=(0.0, right), **values)
