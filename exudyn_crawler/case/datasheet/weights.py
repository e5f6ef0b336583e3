"""Weights of a datasheet's machine: what its operating weight consists of, and where it is."""

import math
from typing import NamedTuple

from exudyn_crawler.case.datasheet import lift_chart
from exudyn_crawler.case.datasheet.chain import Chain
from exudyn_crawler.case.datasheet.notes import Notes
from exudyn_crawler.case.datasheet.sheet import Datasheet, DatasheetError
from exudyn_crawler.case.parameters.base import Six, Three

UPPER_OF_REST, BODY_OF_REST = 0.7, 0.4  # chosen here, for machines whose tracks are heavy
LEAST_FRAMES = 0.02  # of the operating weight: both side frames with their wheels


class PartWeights(NamedTuple):
    """Masses of a machine's parts beside its shoes, kg, and their COMs in the machine's axes, m."""

    frame: float  # one side frame with its wheels, without sprocket
    frame_inertia: Six
    frame_com: Three
    body: float
    body_inertia: Six
    body_com: Three
    upper: float
    upper_inertia: Six
    upper_com: Three


def gyration_inertia(mass: float, roll: float, pitch: float, yaw: float) -> Six:
    """Inertia by radii of gyration, m."""
    return mass * roll**2, mass * pitch**2, mass * yaw**2, 0.0, 0.0, 0.0


def weights_of(
    sheet: Datasheet, chain: Chain, shoe: float, beside: tuple[float, float], axes: float, notes: Notes
) -> PartWeights:
    """Weights of the parts, which add up to the operating weight.

    `shoe` is the mass of one (kg), `beside` are those of a track's sprocket and of what it has on springs,
    `axes` is the height of the rollers' axes above ground, m.
    A DatasheetError where the parts weigh more than the machine.
    """
    length = chain.on_ground
    upper, body, frames = _shares(sheet, chain, shoe, beside, notes)
    frame = notes.note(
        "gear.mass", 0.5 * frames, "kg", "derived", "half of what is left of the operating weight"
    )
    gyration = notes.typical("frame_gyration") * length
    height = length * notes.typical("body_height")
    frame_com = (0.0, 0.0, 0.2 * height)
    body_com = (0.0, 0.0, height)
    upper_com = _upper_com(sheet, upper, length, axes, notes)
    long, wide, tall = (length * notes.typical(f"upper_{name}") for name in ("long", "wide", "tall"))
    radii = math.hypot(wide, tall), math.hypot(long, tall), math.hypot(long, wide)
    turned = length * notes.typical("body_gyration")
    for path, how in (
        ("gear.inertia", "frame_gyration"),
        ("gear.car_body.inertia", "body_gyration"),
        ("gear.car_body.upper_inertia", "upper_long, upper_wide and upper_tall"),
        ("gear.com", "body_height"),
        ("gear.car_body.com", "body_height"),
    ):
        notes.note(path, None, "", "assumed", f"by {how} of the typical values")
    return PartWeights(
        frame,
        gyration_inertia(frame, 0.4 * gyration, gyration, gyration),
        frame_com,
        body,
        gyration_inertia(body, turned, turned, turned),
        body_com,
        upper,
        gyration_inertia(upper, *radii),
        upper_com,
    )


def _shares(
    sheet: Datasheet, chain: Chain, shoe: float, beside: tuple[float, float], notes: Notes
) -> tuple[float, float, float]:
    """Masses of upper structure, car body and both side frames, kg."""
    whole = sheet.operating_weight
    sprocket, springs = beside
    tracks = 2.0 * chain.shoes * shoe + 2.0 * sprocket
    others = whole - 2.0 * springs
    upper = sheet.upper_weight
    if upper is None:
        upper = notes.sized("gear.car_body.upper_mass", "upper_share", whole, "kg")
    body = notes.sized("gear.car_body.mass", "body_share", whole, "kg")
    rest = others - tracks - upper
    if rest - body < LEAST_FRAMES * whole and sheet.upper_weight is None:
        upper = UPPER_OF_REST * max(0.0, others - tracks)
        how = f"{UPPER_OF_REST:g} of what heavy tracks leave"
        notes.note("gear.car_body.upper_mass", upper, "kg", "derived", how)
        rest = others - tracks - upper
    if rest - body < LEAST_FRAMES * whole:
        body = BODY_OF_REST * max(0.0, rest)
        how = f"{BODY_OF_REST:g} of what upper structure and tracks leave"
        notes.note("gear.car_body.mass", body, "kg", "derived", how)
    if rest - body < LEAST_FRAMES * whole:
        raise DatasheetError(
            f"{2 * chain.shoes} shoes of {shoe:.4g} kg with sprockets weigh {1e-3 * tracks:.4g} t, which "
            f"leaves {1e-3 * rest:.3g} t of an operating weight of {1e-3 * whole:.4g} t for car body and "
            f"side frames beside an upper structure of {1e-3 * upper:.4g} t"
        )
    return upper, body, rest - body


def _upper_com(sheet: Datasheet, upper: float, length: float, axes: float, notes: Notes) -> Three:
    """COM of the upper structure in the machine's axes, m: printed, or for the machine's where it is."""
    # the case has its tumbler at the rear; a machine with its sprocket in front stands the other way round
    ahead = 1.0 if sheet.sprocket == "rear" else -1.0
    path = "gear.car_body.upper_com"
    if sheet.upper_com is not None:
        x, y, z = sheet.upper_com
        com = ahead * x, ahead * y, z - axes
        notes.note(path, com, "m", "derived", "upper_com, from the rollers' axes on")
        return com
    place = sheet.com_ahead
    if place is None:
        place = _com_of_chart(sheet, length, notes)
    com = ahead * place * sheet.operating_weight / upper, 0.0, length * notes.typical("upper_height")
    notes.note(path, com, "m", "assumed", "so that the machine's COM is at com_ahead; upper_height")
    return com


def _com_of_chart(sheet: Datasheet, length: float, notes: Notes) -> float:
    """COM of the machine ahead of the middle, m: of its lift chart, or typical."""
    chart = sheet.lift_chart
    if chart is None:
        return length * notes.typical("com_ahead")
    line = 0.5 * (sheet.track_gauge if chart.over == "side" else length)
    near = [point.radius for point in chart.points if point.radius <= line]
    if near:
        raise DatasheetError(
            f"lift_chart has a load at {near[0]:g} m, within the tipping line {line:.3g} m from the axis"
        )
    fit = lift_chart.fit_of(chart, line)
    how = f"lift chart over {chart.over}, {len(chart.points)} loads within {100.0 * fit.error:.1f} %"
    if not 0.0 < fit.front < sheet.operating_weight:
        raise DatasheetError(
            f"lift_chart gives a front of {1e-3 * fit.front:.3g} t: loads of one height and direction, which "
            "tipping limits, belong in it"
        )
    notes.note("front of the lift chart", fit.front, "kg", "derived", how)
    reach = notes.typical("travel_reach") * max(point.radius for point in chart.points)
    place = lift_chart.com_ahead(fit, sheet.operating_weight, line, reach)
    notes.note("COM ahead of the middle", place, "m", "derived", f"{how}; front at {reach:.3g} m")
    return place
