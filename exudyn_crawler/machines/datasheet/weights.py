"""Weights of a datasheet's machine: the parts of its operating weight and their COMs."""

import math
from typing import NamedTuple

from exudyn_crawler.case.parameters.base import Six, Three
from exudyn_crawler.machines.datasheet import lift_chart
from exudyn_crawler.machines.datasheet.chain import Chain
from exudyn_crawler.machines.datasheet.sheet import Datasheet, DatasheetError
from exudyn_crawler.origins import Ruled

UPPER_OF_REST, BODY_OF_REST = 0.7, 0.4  # shares for machines with heavy tracks (assumed)
HEAVY_TRACKS = "heavy tracks"
"""Name of the rule that shares the rest of the weight beside the tracks."""
LEAST_FRAMES = 0.02  # least mass of both side frames with wheels, fraction of the operating weight


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
    ruled: dict[str, Ruled]
    """Values with several possible rules, with the rule of each, by their paths."""


def gyration_inertia(mass: float, roll: float, pitch: float, yaw: float) -> Six:
    """Return the inertia from radii of gyration, m."""
    return mass * roll**2, mass * pitch**2, mass * yaw**2, 0.0, 0.0, 0.0


def weights_of(
    sheet: Datasheet, chain: Chain, shoe: float, beside: tuple[float, float], axes: float
) -> PartWeights:
    """Return the weights of the parts, whose sum is the operating weight.

    `shoe` is the mass of a shoe (kg). `beside` are the masses of a track's sprocket and sprung parts (kg),
    and `axes` is the height of the rollers' axes above ground, m. Raise `DatasheetError` if the parts weigh
    more than the machine.
    """
    length = chain.on_ground
    of_upper, of_body, frames = _shares(sheet, chain, shoe, beside)
    upper: float = of_upper.value
    body: float = of_body.value
    frame = 0.5 * frames
    gyration = sheet.typical_value("frame_gyration") * length
    height = length * sheet.typical_value("body_height")
    frame_com = (0.0, 0.0, 0.2 * height)
    body_com = (0.0, 0.0, height)
    ruled = {"datasheet.upper_weight": of_upper, "gear.car_body.mass": of_body}
    # the case has its tumbler at the rear; a machine with its sprocket in front is reversed in it
    ahead = 1.0 if sheet.sprocket == "rear" else -1.0
    if sheet.upper_com is not None:
        x, y, z = sheet.upper_com
        upper_com = ahead * x, ahead * y, z - axes
    else:
        # puts the COM of the whole machine in its place
        ruled["datasheet.com_ahead"] = place = _com_ahead(sheet, length)
        height = length * sheet.typical_value("upper_height")
        upper_com = ahead * place.value * sheet.operating_weight / upper, 0.0, height
    long, wide, tall = (length * sheet.typical_value(f"upper_{name}") for name in ("long", "wide", "tall"))
    radii = math.hypot(wide, tall), math.hypot(long, tall), math.hypot(long, wide)
    turned = length * sheet.typical_value("body_gyration")
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
        ruled,
    )


def _shares(
    sheet: Datasheet, chain: Chain, shoe: float, beside: tuple[float, float]
) -> tuple[Ruled, Ruled, float]:
    """Return the masses of upper structure, car body and both side frames, kg."""
    whole = sheet.operating_weight
    sprocket, springs = beside
    tracks = 2.0 * chain.shoes * shoe + 2.0 * sprocket
    others = whole - 2.0 * springs
    upper = sheet.upper_weight
    if upper is None:
        upper = whole * sheet.typical_value("upper_share")
    body = whole * sheet.typical_value("body_share")
    of_upper = of_body = ""
    rest = others - tracks - upper
    if rest - body < LEAST_FRAMES * whole and sheet.upper_weight is None:
        upper = UPPER_OF_REST * max(0.0, others - tracks)
        of_upper = HEAVY_TRACKS
        rest = others - tracks - upper
    if rest - body < LEAST_FRAMES * whole:
        body = BODY_OF_REST * max(0.0, rest)
        of_body = HEAVY_TRACKS
    if rest - body < LEAST_FRAMES * whole:
        raise DatasheetError(
            f"{2 * chain.shoes} shoes of {shoe:.4g} kg with sprockets weigh {1e-3 * tracks:.4g} t, which "
            f"leaves {1e-3 * rest:.3g} t of an operating weight of {1e-3 * whole:.4g} t for car body and "
            f"side frames beside an upper structure of {1e-3 * upper:.4g} t"
        )
    return Ruled(upper, of_upper), Ruled(body, of_body), rest - body


def _com_ahead(sheet: Datasheet, length: float) -> Ruled:
    """Return the COM of the machine ahead of the middle, m: printed, from its lift chart, or typical."""
    if sheet.com_ahead is not None:
        return Ruled(sheet.com_ahead, "given")
    chart = sheet.lift_chart
    if chart is None:
        return Ruled(length * sheet.typical_value("com_ahead"), "")
    line = 0.5 * (sheet.track_gauge if chart.over == "side" else length)
    near = [point.radius for point in chart.points if point.radius <= line]
    if near:
        raise DatasheetError(
            f"lift_chart has a load at {near[0]:g} m, within the tipping line {line:.3g} m from the axis"
        )
    fit = lift_chart.fit_of(chart, line)
    if not 0.0 < fit.front < sheet.operating_weight:
        raise DatasheetError(
            f"lift_chart gives a front of {1e-3 * fit.front:.3g} t: loads of one height and direction, which "
            "tipping limits, belong in it"
        )
    reach = sheet.typical_value("travel_reach") * max(point.radius for point in chart.points)
    loads = f"{len(chart.points)} loads over {chart.over} within {100.0 * fit.error:.1f} %"
    front = f"front of {1e-3 * fit.front:.3g} t at {reach:.3g} m"
    place = lift_chart.com_ahead(fit, sheet.operating_weight, line, reach)
    return Ruled(place, "lift chart", f"{loads}, {front}")
