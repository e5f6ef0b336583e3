"""Side frame, bogies, arms, wheels and drive tumbler as solids, under a rolled track and in a closed one.

`history` holds some instants, see `track.instants`. How high and wide a side frame is, and how wide the
teeth are, no parameter says: their drawn size means nothing.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.spatial import ConvexHull

from exudyn_crawler.case import SIDES, Case, Rails, RunningGear
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history import History
from exudyn_crawler.views import style
from exudyn_crawler.views.scenes.scene import Solid, box, carried, disc, star

BEAM = (0.05, 0.85)
"""m above the rollers' axes that the drawn beam of a rolling side frame reaches from and to."""
GAP, MARK = 0.03, 0.012
"""m between the beam and the treads beside it; width of the line that shows how far a wheel turns."""
TEETH, SLIDE, SHAFT, LUG_SIDES, ARC_POINTS = 0.18, 0.12, 0.3, 16, 7
"""m, width of drawn teeth and lugs, height of drawn slides; radius of the tumbler's shaft over that of its
pins' circle; sides of a drawn lug; points along a gap between two teeth."""
EYE = 0.25
"""Half width of a drawn bogie or arm about its pivot and the axes of its rollers, of a roller's radius."""
TURNING = {"roller": "rollers", "idler": "idler", "carrier": "carriers"}
"""Titles of the kinds of wheels that turn; slides do not."""


def poses(dataset: xr.Dataset, of: str = "") -> tuple[np.ndarray, np.ndarray]:
    """Origins (times, shoes, 3), m, and turns (times, shoes, 3, 3) of all shoes, or of a side frame."""
    origin, angles = (
        dataset[f"{of}{name}"].transpose("time", ..., "axis").values for name in ("position", "angles")
    )
    return origin, rotation_matrices(angles)


def frame_poses(history: History) -> tuple[np.ndarray, np.ndarray]:
    """Origins (times, 1, 3), m, and turns (times, 1, 3, 3) of the side frame."""
    origin, turn = poses(history.dataset, "side_frame_")
    return origin[:, None], turn[:, None]


def frame_on_rails(case: Case) -> tuple[RunningGear, Rails]:
    """Side frame of a case, and the rails that its wheels run on; ValueError if it has none."""
    frame = case.running_gear()
    rails = case.shoe.rails
    assert rails is not None
    return frame, rails


def gear_solids(history: History) -> list[Solid]:
    """Side frames and all that turns in them, and the car body; nothing of a dragged track."""
    if not history.case.frame_parts:
        return []
    solids = [] if history.case.tracks == 1 else [car_body(history)]
    for name, track in each_track(history).items():
        on_frame = [beam(track), *swinging_solids(track), *wheel_solids(track)]
        of_track = [*on_frame, *slide_solids(track), *tumbler_solids(track)]
        solids += [replace(solid, name=f"{name}{solid.name}") for solid in of_track]
    return solids


def each_track(history: History) -> dict[str, History]:
    """Every track by itself, by what stands before the names of its bodies: its side where there are two."""
    if history.case.tracks == 1:
        return {"": history}
    return {f"{side} ": history.of_track(side) for side in SIDES}


def car_body(history: History) -> Solid:
    """Block that stands for the car body, from one side frame to the other."""
    (low, high) = BEAM
    (right, left) = history.case.gear.middles
    half = 0.2 * (left - right)
    shape = box((-half, right, low), (half, left, high))
    return Solid("car body", *shape, style.BEAM, *frame_poses(history), 0.5, style.ROLLER_EDGE)


def beam_ends(case: Case) -> tuple[float, float]:
    """Lowest and highest z of the drawn beam in the side frame, m: it ends below what is above the frame."""
    _, _, lowest = case.running_gear().extent(case.shoe, case.track)
    return BEAM[0], min(BEAM[1], lowest)


def beam(history: History) -> Solid:
    """Beam between the rails that stands for the side frame; of a closed one it carries all axes."""
    frame, rails = frame_on_rails(history.case)
    half = 0.5 * (float(np.ptp(rails.middles)) - frame.tread_width) - GAP
    low, high = beam_ends(history.case)
    rear, front, _ = frame.extent(history.case.shoe, history.case.track)
    shape = box((rear, -half, low), (front, half, high))
    return Solid("side frame", *shape, style.BEAM, *frame_poses(history), 0.5, style.ROLLER_EDGE)


class _Swinging(NamedTuple):
    """Bogie or arm: what swings about a pivot of the frame and carries rollers."""

    name: str
    pivot: tuple[float, float]  # x and z in the frame, m
    rollers: tuple[int, ...]  # their numbers
    turn: np.ndarray  # (times, 1, 3, 3)


def swinging_solids(history: History) -> list[Solid]:
    """Bodies of bogies and arms, each round its pivot and the axes of its rollers."""
    frame, rails = frame_on_rails(history.case)
    # arms on both sides of the rollers, which are seen below them
    width = float(np.ptp(rails.middles)) + frame.tread_width + 2.0 * GAP
    eye = EYE * frame.first_wheels(history.case.shoe, history.case.track)[0, 2]
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
    """Bogies and arms of one track."""
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
    """Ways by which bogies and arms have moved rollers' axes: array (times, rollers, 3), m, global."""
    frame, _ = frame_on_rails(history.case)
    _, turn = frame_poses(history)
    ways = np.zeros((len(turn), len(frame.rollers), 3))
    for _, (x, z), rollers, swung in _swinging(history):
        for number in rollers:
            ways[:, number - 1] = (swung - turn)[:, 0] @ np.array([frame.rollers[number - 1] - x, 0.0, -z])
    return ways


def _wheels(case: Case) -> dict[str, tuple[list[str], np.ndarray]]:
    """Names of the wheels of each kind, and x, z and radius of theirs in the frame (n, 3), m."""
    frame, _ = frame_on_rails(case)
    table = frame.first_wheels(case.shoe, case.track)
    wheels = {}
    for kind, title in TURNING.items():
        rows = [row for row, label in enumerate(frame.wheel_labels) if label.kind == kind]
        if rows:
            wheels[title] = [frame.wheel_labels[row].words for row in rows], table[rows]
    return wheels


def slide_solids(history: History) -> list[Solid]:
    """Slides under the upper run of a closed track, on both rails."""
    frame, rails = frame_on_rails(history.case)
    half = 0.5 * frame.tread_width
    placed = carried(*frame_poses(history), np.outer(rails.middles, [0.0, 1.0, 0.0]))
    shapes = (box((x0, -half, z - SLIDE), (x1, half, z)) for x0, x1, z in frame.slide_places)
    return [
        Solid(f"slide {n}", *shape, style.ROLLER, *placed, edges=style.ROLLER_EDGE)
        for n, shape in enumerate(shapes, start=1)
    ]


def wheel_solids(history: History) -> list[Solid]:
    """Treads of every kind of wheel, and a line across each, which turns as the chain runs over it."""
    case = history.case
    frame, rails = frame_on_rails(case)
    origin, turn = frame_poses(history)
    # how far wheels have turned counts from upright, whatever the pitch of the frame
    axle = turn[..., 1]
    forward = np.cross(axle, [0.0, 0.0, 1.0])
    forward /= np.linalg.norm(forward, axis=-1, keepdims=True)
    level = np.stack((forward, axle, np.cross(forward, axle)), axis=-1)
    way = origin[..., 0] - case.frame_start[0]
    if history.has("tumbler_angle"):
        way = history.tumbler_angle.values[:, None] * case.closed_gear().travel_per_angle(case.track)
    solids = []
    edge = style.ROLLER_EDGE
    for name, (labels, wheels) in _wheels(case).items():
        # roller by roller, its right tread first
        places = np.array([(x, y, z) for x, z, _ in wheels for y in rails.middles])
        radius = wheels[0, 2]
        hub = origin
        if name == "idler":  # a spring moves it from where it was assembled
            hub = origin + (history.take_up.values - case.assembled.take_up)[:, None, None] * turn[..., 0]
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
    """Outline of the tumbler's teeth, arcs and flanks of the gaps: (n, 2), x and z in m, clockwise."""
    profile = case.closed_gear().tumbler.profile(case.track)
    end = profile.flank_angle
    gap = -2.0 * np.pi * np.arange(round(profile.gaps)) / profile.gaps
    inward = np.stack((-np.cos(gap), -np.sin(gap)), axis=-1)
    aside = np.stack((-np.sin(gap), np.cos(gap)), axis=-1)
    along = np.linspace(end, -end, ARC_POINTS)
    # of the arcs, and between two flanks' ends
    deep = profile.arc * np.cos(along)
    wide = profile.arc * np.sin(along)
    if profile.flank > 0.0:
        way = profile.flank * np.array([-np.sin(end), np.cos(end)])
        deep = np.concatenate(([deep[0] + way[0]], deep, [deep[-1] + way[0]]))
        wide = np.concatenate(([wide[0] + way[1]], wide, [wide[-1] - way[1]]))
    ways = deep[:, None] * inward[:, None] + wide[:, None] * aside[:, None]
    return (-profile.center * inward[:, None] + ways).reshape(-1, 2)


def tumbler_solids(history: History) -> list[Solid]:
    """Toothed wheels of a drive tumbler on its shaft, and the lugs of shoes that run into them, if any."""
    if not history.case.gear.tumblers:
        return []
    case = history.case
    frame = history.case.closed_gear()
    tumbler = frame.tumbler
    centers = case.track.joint_centers
    planes = np.array([[0.0, centers[f"rear {side}"][1], 0.0] for side in SIDES])
    _, turn = frame_poses(history)
    angle = case.assembled.tumbler[4] + history.tumbler_angle.values[:, None, None]
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
    """Forces of a closed track's wheels and of its teeth on every shoe, of one instant or of several.

    Names, colours, places (..., shoes, 3), m, where the lines that they act on are nearest to the COM, not a
    number where there is no force, and forces (..., shoes, 3), N.
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
    """Wheels and tumbler, as far as they are within some m of shoes with origins (times, shoes, 3)."""
    if not history.case.frame_parts:
        return []
    near = []
    for track in each_track(history).values():
        for solid in (*wheel_solids(track)[::2], *tumbler_solids(track)[1:2]):
            apart = np.linalg.norm((solid.origin[:, :, None] - shoes[:, None])[..., [0, 2]], axis=-1)
            away = apart.min(axis=2) > beside + np.linalg.norm(solid.points[:, [0, 2]], axis=1).max()
            near.append(replace(solid, origin=np.where(away[..., None], np.nan, solid.origin)))
    return near
