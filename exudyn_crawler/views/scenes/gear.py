"""Solids of side frame, bogies, arms, wheels and drive tumbler, for rolled and closed tracks.

`history` holds some instants, see `track.instants`. The drawn height and width of a side frame and the drawn
width of teeth follow from no parameter and mean nothing.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.spatial import ConvexHull

from exudyn_crawler.case import SIDES, Case, Rails, RunningGear
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history import History
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes.scene import Solid, box, carried, disc, star

BEAM = (0.05, 0.85)
"""Lower and upper edge of the drawn beam of a rolling side frame, m above the rollers' axes."""
GAP, MARK = 0.03, 0.012
"""Distance (m) of the beam from the treads beside it; width (m) of the line that shows the rotation of a
wheel."""
TEETH, SLIDE, SHAFT, LUG_SIDES, ARC_POINTS = 0.18, 0.12, 0.3, 16, 7
"""Width of drawn teeth and lugs (m), height of drawn slides (m); radius of the tumbler's shaft over that of
its pitch circle; sides of a drawn lug; points along a gap between two teeth."""
EYE = 0.25
"""Half width of a drawn bogie or arm around its pivot and its rollers' axes, fraction of a roller's
radius."""
TURNING = {"roller": "rollers", "idler": "idler", "carrier": "carriers"}
"""Titles of the kinds of turning wheels; slides do not turn."""


def poses(dataset: xr.Dataset, of: str = "") -> tuple[np.ndarray, np.ndarray]:
    """Return origins (times, shoes, 3), m, and axes (times, shoes, 3, 3) of all shoes, or of a side frame."""
    origin, angles = (
        dataset[f"{of}{name}"].transpose("time", ..., "axis").values for name in ("position", "angles")
    )
    return origin, rotation_matrices(angles)


def frame_poses(history: History) -> tuple[np.ndarray, np.ndarray]:
    """Return origins (times, 1, 3), m, and axes (times, 1, 3, 3) of the side frame."""
    origin, turn = poses(history.dataset, "side_frame_")
    return origin[:, None], turn[:, None]


def frame_on_rails(case: Case) -> tuple[RunningGear, Rails]:
    """Return the side frame of a case and the rails below its wheels.

    Raises ValueError if the case has no side frame.
    """
    return case.part(RunningGear), case.shoe.roller_path


def gear_solids(history: History) -> list[Solid]:
    """Return side frames with their wheels and tumbler, and the car body; nothing for a dragged track."""
    if not history.case.gear.frame_parts:
        return []
    solids = [] if history.case.gear.tracks == 1 else [car_body(history)]
    for name, track in each_track(history).items():
        on_frame = [beam(track), *swinging_solids(track), *wheel_solids(track)]
        of_track = [*on_frame, *slide_solids(track), *tumbler_solids(track)]
        solids += [replace(solid, name=f"{name}{solid.name}") for solid in of_track]
    return solids


def each_track(history: History) -> dict[str, History]:
    """Return every track alone, by the prefix of its bodies' names: its side if there are two tracks."""
    if history.case.gear.tracks == 1:
        return {"": history}
    return {f"{side} ": history.of_track(side) for side in SIDES}


def car_body(history: History) -> Solid:
    """Return a block for the car body, from one side frame to the other."""
    (low, high) = BEAM
    (right, left) = history.case.gear.middles
    half = 0.2 * (left - right)
    shape = box((-half, right, low), (half, left, high))
    return Solid("car body", *shape, style.BEAM, *frame_poses(history), 0.5, style.ROLLER_EDGE)


def beam_ends(case: Case) -> tuple[float, float]:
    """Return lowest and highest z (m) of the drawn beam in the side frame, below all parts above it."""
    _, _, lowest = case.part(RunningGear).extent(case)
    return BEAM[0], min(BEAM[1], lowest)


def beam(history: History) -> Solid:
    """Return a beam between the rails for the side frame; in a closed track it carries all axes."""
    frame, rails = frame_on_rails(history.case)
    half = 0.5 * (float(np.ptp(rails.middles)) - frame.tread_width) - GAP
    low, high = beam_ends(history.case)
    rear, front, _ = frame.extent(history.case)
    shape = box((rear, -half, low), (front, half, high))
    return Solid("side frame", *shape, style.BEAM, *frame_poses(history), 0.5, style.ROLLER_EDGE)


class _Swinging(NamedTuple):
    """Bogie or arm: body on a pivot of the side frame that carries rollers."""

    name: str
    pivot: tuple[float, float]  # x and z in the frame, m
    rollers: tuple[int, ...]  # their numbers
    turn: np.ndarray  # (times, 1, 3, 3)


def swinging_solids(history: History) -> list[Solid]:
    """Return the bodies of bogies and arms, each around its pivot and the axes of its rollers."""
    frame, rails = frame_on_rails(history.case)
    # wider than the rollers, which remain visible below
    width = float(np.ptp(rails.middles)) + frame.tread_width + 2.0 * GAP
    eye = EYE * frame.first_wheels(history.case)[0, 2]
    solids = []
    for name, (x, z), rollers, turn in _swinging(history):
        joints = np.array([*((frame.rollers[number - 1], 0.0) for number in rollers), (x, z)])
        around = (joints - (x, z))[:, None] + eye * np.array([[-1, -1], [-1, 1], [1, 1], [1, -1]])
        corners = around.reshape(-1, 2)
        outline = corners[ConvexHull(corners).vertices[::-1]]
        placed = carried(*frame_poses(history), np.array([[x, 0.0, z]]), turn)
        solids.append(Solid(name, *star(outline, width), style.BEAM, *placed, edges=style.ROLLER_EDGE))
    return solids


def _swinging(history: History) -> list[_Swinging]:
    """Return the bogies and arms of one track."""
    frame, _ = frame_on_rails(history.case)
    _, turn = frame_poses(history)
    carriers: list[tuple[tuple[float, float], tuple[int, ...]]]
    carriers = [(bogie.pivot, bogie.rollers) for bogie in frame.bogies]
    carriers += [(arm.pivot, (arm.roller,)) for arm in frame.arms]
    swung = []
    for dimension in ("bogie", "arm"):
        if history.has(f"{dimension}_angle"):
            swung += list(history.dataset[f"{dimension}_angle"].transpose(dimension, "time").values)
    names = (*frame.bogie_names, *frame.arm_names)
    turns = [turn @ rotation_matrices(angle[:, None, None] * np.eye(3)[1]) for angle in swung]
    return [_Swinging(name, *of, turned) for name, of, turned in zip(names, carriers, turns, strict=True)]


def _swung(history: History) -> np.ndarray:
    """Return displacements of the rollers' axes by bogies and arms: array (times, rollers, 3), m, global."""
    frame, _ = frame_on_rails(history.case)
    _, turn = frame_poses(history)
    ways = np.zeros((len(turn), len(frame.rollers), 3))
    for _, (x, z), rollers, swung in _swinging(history):
        for number in rollers:
            ways[:, number - 1] = (swung - turn)[:, 0] @ np.array([frame.rollers[number - 1] - x, 0.0, -z])
    return ways


def _wheels(case: Case) -> dict[str, tuple[list[str], np.ndarray]]:
    """Return names of the wheels of each kind, and their x, z and radius in the side frame (n, 3), m."""
    frame, _ = frame_on_rails(case)
    table = frame.first_wheels(case)
    wheels = {}
    for kind, title in TURNING.items():
        rows = [row for row, label in enumerate(frame.wheel_labels) if label.kind == kind]
        if rows:
            wheels[title] = [frame.wheel_labels[row].words for row in rows], table[rows]
    return wheels


def slide_solids(history: History) -> list[Solid]:
    """Return the slides under the upper run of a closed track, on both rails."""
    frame, rails = frame_on_rails(history.case)
    half = 0.5 * frame.tread_width
    placed = carried(*frame_poses(history), np.outer(rails.middles, [0.0, 1.0, 0.0]))
    shapes = (box((x0, -half, z - SLIDE), (x1, half, z)) for x0, x1, z in frame.slide_places)
    return [
        Solid(f"slide {n}", *shape, style.ROLLER, *placed, edges=style.ROLLER_EDGE)
        for n, shape in enumerate(shapes, start=1)
    ]


def wheel_solids(history: History) -> list[Solid]:
    """Return the treads of every kind of wheel, each with a line that turns as the chain runs over it."""
    case = history.case
    frame, rails = frame_on_rails(case)
    origin, turn = frame_poses(history)
    # rotations of wheels count from the vertical, at any pitch of the frame
    axle = turn[..., 1]
    forward = np.cross(axle, [0.0, 0.0, 1.0])
    forward /= np.linalg.norm(forward, axis=-1, keepdims=True)
    level = np.stack((forward, axle, np.cross(forward, axle)), axis=-1)
    way = origin[..., 0] - case.part(RunningGear).frame_start(case)[0]
    if history.has("tumbler_angle"):
        way = history.tumbler_angle.values[:, None] * case.part(Closed).travel_per_angle(case.track)
    solids = []
    edge = style.ROLLER_EDGE
    for name, (labels, wheels) in _wheels(case).items():
        # roller by roller, its right tread first
        places = np.array([(x, y, z) for x, z, _ in wheels for y in rails.middles])
        radius = wheels[0, 2]
        hub = origin
        if name == "idler":  # a spring moves it from its assembled position
            taut = case.part(Closed).assembled(case).take_up
            hub = origin + (history.take_up.values - taut)[:, None, None] * turn[..., 0]
        placed = carried(hub, turn, places, level @ rotation_matrices(way[..., None] / radius * np.eye(3)[1]))
        if name == TURNING["roller"]:
            placed = placed[0] + np.repeat(_swung(history), len(rails.middles), axis=1), placed[1]
        half = np.array([0.5 * MARK, 0.5 * frame.tread_width + 0.002, radius])
        tread = disc(radius, frame.tread_width)
        named = tuple(np.repeat(labels, len(rails.middles)).tolist())
        solids += [
            Solid(name, *tread, style.ROLLER, *placed, edges=edge, labels=named),
            Solid(f"{name}, marks", *box(-half, half), edge, *placed),
        ]
    return solids


def tooth_outline(case: Case) -> np.ndarray:
    """Return the outline of the tumbler's teeth, arcs and flanks: (n, 2), x and z in m, clockwise."""
    profile = case.part(Closed).tumbler.profile(case.track)
    end = profile.flank_angle
    gap = -2.0 * np.pi * np.arange(round(profile.gaps)) / profile.gaps
    inward = np.stack((-np.cos(gap), -np.sin(gap)), axis=-1)
    aside = np.stack((-np.sin(gap), np.cos(gap)), axis=-1)
    along = np.linspace(end, -end, ARC_POINTS)
    # of the arcs, and of the flanks' ends
    deep = profile.arc * np.cos(along)
    wide = profile.arc * np.sin(along)
    if profile.flank > 0.0:
        way = profile.flank * np.array([-np.sin(end), np.cos(end)])
        deep = np.concatenate(([deep[0] + way[0]], deep, [deep[-1] + way[0]]))
        wide = np.concatenate(([wide[0] + way[1]], wide, [wide[-1] - way[1]]))
    ways = deep[:, None] * inward[:, None] + wide[:, None] * aside[:, None]
    return (-profile.center * inward[:, None] + ways).reshape(-1, 2)


def tumbler_solids(history: History) -> list[Solid]:
    """Return the toothed wheels of a drive tumbler, its shaft, and the lugs that mesh with them, if any."""
    if not history.case.gear.tumblers:
        return []
    case = history.case
    frame = history.case.part(Closed)
    tumbler = frame.tumbler
    centers = case.track.joint_centers
    planes = np.array([[0.0, centers[f"rear {side}"][1], 0.0] for side in SIDES])
    _, turn = frame_poses(history)
    first = case.part(Closed).assembled(case).tumbler[4]
    angle = first + history.tumbler_angle.values[:, None, None]
    axis = history.tumbler_position.transpose("time", "axis").values[:, None], turn
    turned = turn @ rotation_matrices(angle * np.eye(3)[1])
    middle = planes.mean(axis=0)[None]
    shaft = disc(SHAFT * tumbler.radius(case.track.pitch), float(np.ptp(planes[:, 1])))
    teeth = star(tooth_outline(case), TEETH)
    lug = disc(tumbler.lug_radius, TEETH, LUG_SIDES)
    lugs = carried(*poses(history.dataset), np.array([place for _, place in frame.lugs(case.track)]))
    edge = style.ROLLER_EDGE
    return [
        Solid("shaft of the tumbler", *shaft, style.BEAM, *carried(*axis, middle, turned), edges=edge),
        Solid("tumbler", *teeth, style.TUMBLER, *carried(*axis, planes, turned), edges=edge),
        Solid("lugs", *lug, style.LUG, *lugs, edges=edge),
    ]


def gear_forces(dataset: xr.Dataset) -> list[tuple[str, str, np.ndarray, np.ndarray]]:
    """Return the forces of wheels and teeth on every shoe of a closed track, at one instant or several.

    For each kind: name, colour, points (..., shoes, 3), m, and forces (..., shoes, 3), N. A point is that of
    the force's line of action nearest to the COM; it is NaN without a force.
    """
    names = (("wheels", "wheel_load", "wheel_moment"), ("teeth", "tooth_force", "tooth_moment"))
    forces = []
    for (name, force, moment), colour in zip(names, (style.ROLLER_FORCE, style.TOOTH_FORCE), strict=True):
        place, f, m = (
            dataset[variable].transpose(..., "shoe", "axis").values
            for variable in ("position", force, moment)
        )
        size = np.sum(f * f, axis=-1, keepdims=True)
        off = np.divide(np.cross(f, m), size, out=np.full_like(f, np.nan), where=size > 0.0)
        forces.append((f"forces of {name}", colour, place + off, f))
    return forces


def near_gear(history: History, shoes: np.ndarray, beside: float) -> list[Solid]:
    """Return wheels and tumbler within `beside` (m) of shoes with origins (times, shoes, 3)."""
    if not history.case.gear.frame_parts:
        return []
    near = []
    for track in each_track(history).values():
        for solid in (*wheel_solids(track)[::2], *tumbler_solids(track)[1:2]):
            apart = np.linalg.norm((solid.origin[:, :, None] - shoes[:, None])[..., [0, 2]], axis=-1)
            away = apart.min(axis=2) > beside + np.linalg.norm(solid.points[:, [0, 2]], axis=1).max()
            near.append(replace(solid, origin=np.where(away[..., None], np.nan, solid.origin)))
    return near
