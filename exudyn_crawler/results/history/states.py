"""Conversion of stored states of the multibody system to the named variables of a history."""

from collections.abc import Callable, Iterable
from importlib.metadata import version
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr

from exudyn_crawler.case import SIDES, Closed
from exudyn_crawler.case.gear.base import SIDE_FRAME
from exudyn_crawler.case.gear.rolled import Rolled
from exudyn_crawler.case.gear.running_gear import RunningGear
from exudyn_crawler.ground import rotations, terrain
from exudyn_crawler.ground.cells.ground import COARSE
from exudyn_crawler.ground.pairs import RESULT, RESULTS
from exudyn_crawler.model.state import MOTOR, RATES, VERSION, friction_name, pin_name
from exudyn_crawler.results.history import History, catalogue, files

if TYPE_CHECKING:
    from exudyn_crawler.model.gear import GearForces
    from exudyn_crawler.model.track_system import TrackSystem

AXES = ["x", "y", "z"]

CONTACTS = catalogue.select(per="pair", files="history")  # variables of each contact

VERSIONS = {f"{name.replace('-', '_')}_version": version(name) for name in ("exudyn", "exudyn-crawler")}

NEIGHBOURS = ("behind", "ahead")
"""Shoes that may carry a roller at once: the last one whose COM its axis has passed, and the next."""

COORDINATES = ("coordinates", "coordinates rate")

Arrays = dict[str, np.ndarray]  # variables by name


class _States(NamedTuple):
    """Stored states (times, layout.size) of a system."""

    system: "TrackSystem"
    rows: np.ndarray

    def part(self, name: str) -> np.ndarray:
        return self.system.layout.part(self.rows, name)

    def parts(self, names: Iterable[str]) -> np.ndarray:
        """Return parts of the same shape side by side: (times, names, ...)."""
        return np.stack([self.part(name) for name in names], axis=1)


def system_history(system: "TrackSystem", rows: np.ndarray) -> History:
    """Return the history of states (times, layout.size) of a system."""
    case = system.case
    states = _States(system, rows)
    time = states.part("time")
    gear = case.gear
    start = gear.shoe_reference(case)
    if not start[:, 3:].any():  # the shoes of an open track start level
        start = start[:, :3]
    contacts, pairs = _contacts(states)
    values = _motion(states, "shoes", start)
    values |= _reactions(states, values) | _terrain(states) | contacts
    values["shoe_load"] = case.loads.loads(time)
    of_gear = OF_GEAR[case.gear.kind]
    values |= of_gear.values(states, values)
    dataset = xr.Dataset(
        {name: catalogue.variable(name, value) for name, value in values.items()},
        coords={
            "time": ("time", time, {"units": "s"}),
            "shoe": case.track.shoes,
            "joint": ("joint", gear.joints(case.track), {"long_name": catalogue.LINKS[gear.loops]}),
            **({"unit": case.terrain.units} if len(case.terrain.units) else {}),
            "axis": AXES,
            **_coordinates(system),
            **of_gear.coordinates(system),
            **files.contact_coordinates(pairs),
        },
        attrs={"title": case.name, **VERSIONS, files.LAYOUT_VERSION: VERSION},
    )
    return History(case=case, dataset=files.with_motion_of_units(dataset))


def _motion(states: _States, bodies: str, start: np.ndarray, prefix: str = "") -> Arrays:
    """Return the motion of bodies whose coordinates in the states count from their start.

    `bodies` names the part of the states. `start` has the positions (m) at the start, (..., 3), or the
    positions and angles (rad), (..., 6).
    """
    u, v, a = (states.part(f"{bodies}{rate}") for rate in RATES)
    angles = u[..., 3:]
    rates = v[..., 3:]
    accelerations = a[..., 3:]
    if start.shape[-1] > 3:
        angles = angles + start[..., 3:]
    return {
        f"{prefix}position": u[..., :3] + start[..., :3],
        f"{prefix}velocity": v[..., :3],
        f"{prefix}acceleration": a[..., :3],
        f"{prefix}angles": angles,
        f"{prefix}angular_velocity": rotations.angular_velocity(angles, rates),
        f"{prefix}angular_acceleration": rotations.angular_acceleration(angles, rates, accelerations),
    }


def _pins(states: _States, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return force and torque of every joint on its rear shoe, and the mask of existing joints.

    Force (N) and torque (N m) are arrays (times, links, sides, 3), zero without a joint; the mask is
    (links, sides).

    Axes of the rear shoe have the index 0, those of the front shoe the index 1. A joint's equations are
    ``p_front - p_rear = 0``, ``y0 . x1 = 0`` and ``y0 . z1 = 0``. The multipliers of the first are the force
    on the rear shoe. Those of the others are moments along ``x1 x y0`` and ``z1 x y0``. In a closed track the
    first three are components along the axes of the chain's plane (`model.joints.pin`). With play all are
    along the axes of the front shoe without its pitch (`model.joints.play`). The moment of a pin's friction
    is along y0.
    """
    layout = states.system.layout
    case = states.system.case
    joints = case.gear.joints(case.track)
    frames = rotations.rotation_matrices(angles)
    rear, front = np.moveaxis(frames[:, case.gear.links(case.track) - 1], 2, 0)
    y0, x1, z1 = rear[..., 1], front[..., 0], front[..., 2]
    plays = case.gear.pin_play is not None
    axis = front[..., 1] if plays else y0
    names = [[pin_name(side, int(link)) for side in SIDES] for link in joints]
    has = np.array([[layout.has(name) for name in row] for row in names])
    present = np.array(names)[has]
    first = np.array([layout.first_multiplier(name) for name in present])
    # existing joints alone: (times, joints, equations of a joint), each of a link
    columns = first[:, None] + np.arange(dict(layout.multipliers)[present[0]])
    reaction = states.part("multipliers")[:, columns]
    link = np.nonzero(has)[0]
    force, torque = np.zeros((2, len(reaction), *has.shape, 3))
    if case.gear.loops:
        yaw = angles[:, case.gear.links(case.track)[:, 1] - 1, 2] if plays else angles[..., 2]
        level = np.stack((np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)), axis=-1)
        axes = level, axis, np.cross(level, axis)
        if plays:
            x1, z1 = axes[0], axes[2]
        force[:, has] = sum(reaction[..., r, None] * axes[r][:, link] for r in range(3))
    else:
        force[:, has] = reaction[..., :3]
    about = np.cross(x1, y0), np.cross(z1, y0)
    torque[:, has] = sum(reaction[..., 3 + r, None] * about[r][:, link] for r in range(2))
    if layout.has(friction_name(present[0])):
        rubbed = [layout.first_multiplier(friction_name(name)) for name in present]
        torque[:, has] += states.part("multipliers")[:, rubbed, None] * y0[:, link]
    return force, torque, has


def _reactions(states: _States, motion: Arrays) -> Arrays:
    """Return forces and torques of links, and those of each pin in a track with flexible shoes."""
    layout = states.system.layout
    force, torque, has = _pins(states, motion["angles"])
    named = {
        "joint_force": force[:, :, 0] + force[:, :, 1],
        "joint_torque": torque[:, :, 0] + torque[:, :, 1],
    }
    if layout.flexible_shoes:
        # a rigid link has one joint, and its reaction is not that of one pin
        rigid = np.repeat(~has.all(axis=1), has.shape[1] * 3)
        for pins in force, torque:
            np.copyto(pins.reshape(len(pins), -1), np.nan, where=rigid)
        named |= {
            "modal_coordinate": states.part("modes"),
            "modal_velocity": states.part("modes rate"),
            "pin_force": force,
            "pin_torque": torque,
        }
    return named


def _terrain(states: _States) -> Arrays:
    """Return coordinates of the terrain and their shapes, or the motion of units that are bodies."""
    coordinates = states.system.contact.coordinates
    named = Arrays()
    if not len(states.system.case.terrain.units):
        return named
    if reduced := isinstance(coordinates, terrain.TerrainModes):
        named = {"heave_shape": coordinates.heave, "tilt_shape": coordinates.tilt}
    for rate in RATES:
        rows = states.part(f"terrain{rate}")
        after = rate.replace(" ", "_")
        if reduced:
            named[f"{files.TERRAIN}{after}"] = rows.copy()
        else:
            units = coordinates.motion(rows)
            named |= {f"unit_heave{after}": units[..., 2], f"unit_tilt{after}": units[..., 3]}
    return named


def _contacts(states: _States) -> tuple[Arrays, np.ndarray]:
    """Return contacts over time, a column for each pair (or finger) that ever touched; zero when apart."""
    more = ("contact",) if states.system.layout.contact else ()
    rows, counts = states.system.contact.results(*map(states.part, (*COORDINATES, *more)))
    keys = rows[:, [RESULT[name] for name in ("shoe", "unit", "finger")]].astype(int)
    keys[:, :2] += 1  # shoes and units count from 1
    # sorting one number a pair, in the order of the columns, is far faster than sorting rows
    shape = tuple(keys.max(axis=0, initial=0) + 1)
    numbers, column = np.unique(np.ravel_multi_index(tuple(keys.T), shape), return_inverse=True)
    pairs = np.column_stack(np.unravel_index(numbers, shape))
    when = np.repeat(np.arange(len(counts)), counts)
    tables = {}
    for name, quantity in CONTACTS.items():
        if not catalogue.lacking(quantity, states.system.case):
            values = rows[..., RESULT[name]]
            tables[name] = np.zeros((len(counts), len(pairs), *values.shape[1:]))
            # a history in memory has the numbers of its file
            tables[name][when, column] = values.astype(quantity.dtype)
    node_force = catalogue.QUANTITIES["node_force"]
    if not catalogue.lacking(node_force, states.system.case):
        flexible = np.array(states.system.layout.flexible_shoes) - 1
        forces = states.part("contact")[:, flexible, RESULTS:].astype(node_force.dtype).astype(float)
        tables["node_force"] = forces.reshape(*forces.shape[:2], *COARSE, 3)
    return tables, pairs


def _dragged(states: _States, motion: Arrays) -> Arrays:
    """Return force, point and torque of the drive on the front shoe."""
    layout = states.system.layout
    point = states.system.point
    angles = motion["angles"]
    # the front shoe is the last of the flexible ones, if it is one of them
    modal = states.part("modes")[:, -1] if point.rows.size else np.zeros((len(angles), 0))
    return {
        "drive_force": -states.part("drive")[:, 0],
        "drive_point": motion["position"][:, -1] + point.arm(angles[:, -1], modal),
        "drive_torque": -states.part("turn")[:, 0] if layout.has("turn") else np.zeros(len(angles)),
    }


def _side_frame(states: _States) -> tuple[Arrays, "GearForces"]:
    """Return the motion of the side frame, and the forces of its wheels."""
    gear_forces = states.system.gear_forces(states.part("time"), *map(states.part, COORDINATES))
    case = states.system.case
    motion = _motion(states, SIDE_FRAME, case.part(RunningGear).frame_start(case), "side_frame_")
    return motion | _swinging(states, motion), gear_forces


def _swinging(states: _States, of_frame: Arrays) -> Arrays:
    """Return the angles of bogies and arms about the frame's y; empty without any."""
    case = states.system.case
    gear = case.part(RunningGear)
    frame = rotations.rotation_matrices(of_frame["side_frame_angles"])
    angles = {}
    for quantity, names in (("bogie_angle", gear.bogie_names), ("arm_angle", gear.arm_names)):
        if names:
            first = gear.arm_reference(case) if names == gear.arm_names else 0.0
            turns = rotations.rotation_matrices((states.parts(names) + first)[..., 3:])
            forward = np.einsum("tki,tbk->tbi", frame, turns[..., 0])
            angles[quantity] = np.arctan2(-forward[..., 2], forward[..., 0])
    return angles


def _rolled(states: _States, motion: Arrays) -> Arrays:
    """Return motion of a side frame over an open track, forces of its rollers and pull of its drive."""
    case = states.system.case
    frame = case.part(Rolled)
    of_frame, gear_forces = _side_frame(states)
    turned = rotations.rotation_matrices(of_frame["side_frame_angles"])[:, 0, 0]
    axes = of_frame["side_frame_position"][:, :1] + np.outer(turned, frame.rollers)
    behind = np.floor((axes - motion["position"][:, :1, 0]) / case.track.pitch).astype(int)
    behind = np.clip(behind, 0, case.track.shoe_count - len(NEIGHBOURS))
    rollers = np.arange(axes.shape[1])
    when = np.arange(len(axes))[:, None, None]
    shoes = behind[..., None] + np.arange(len(NEIGHBOURS))
    # mask of the slots of a shoe that hold the roller, to broadcast over (strips, 3)
    has = (gear_forces.strip_wheel[when, shoes] == rollers[:, None, None])[..., None, None]
    split = (*axes.shape, len(NEIGHBOURS), len(SIDES), frame.strips, 3)
    force, foot = (
        np.where(has, forces[when, shoes], 0.0).sum(axis=3).reshape(split).transpose(0, 1, 3, 4, 2, 5)
        for forces in (gear_forces.strip_force, gear_forces.strip_foot)
    )
    return of_frame | {
        "drive_pull": -states.part("drive")[:, 0],
        "roller_shoe": behind + 1,
        "roller_force": force.sum(axis=(3, 4)),
        "tread_force": force,
        "tread_foot": foot,
    }


def _closed(states: _States, motion: Arrays) -> Arrays:
    """Return motion of side frame and tumblers of closed tracks, and forces of drive, wheels and teeth."""
    case = states.system.case
    of_frame, gear_forces = _side_frame(states)
    names = case.gear.tumblers
    start = case.part(Closed).tumbler_reference(case)
    place = states.parts(names)[..., :3] + start[:, :3]
    torque = -states.parts(map(MOTOR.format, names))[..., 0]
    pitch, rate = (
        states.parts(f"{name}{after}" for name in names)[..., 4] - states.part(SIDE_FRAME + after)[:, 4, None]
        for after in RATES[:2]
    )
    take_up = _take_up(states)
    if case.gear.tracks == 1:
        place, torque, pitch, rate, take_up = (array[:, 0] for array in (place, torque, pitch, rate, take_up))
    named = of_frame | {
        "tumbler_position": place,
        "tumbler_angle": pitch,
        "tumbler_speed": rate,
        "drive_moment": torque,
        "take_up": take_up,
        "wheel_force": gear_forces.on_wheels,
        "wheel_load": gear_forces.wheel[..., :3],
        "wheel_moment": gear_forces.wheel[..., 3:],
        "tooth_force": gear_forces.tooth[..., :3],
        "tooth_moment": gear_forces.tooth[..., 3:],
        "guide_force": gear_forces.guide,
        "wheel_energy": gear_forces.energy[:, 0],
        "tooth_energy": gear_forces.energy[:, 1],
    }
    if case.gear.pin_play is not None:
        named["play_energy"] = gear_forces.energy[:, 2]
    if case.drive.slip is not None:
        named["drawbar_pull"] = states.part("drive")[:, 0]
    if not states.system.layout.flexible_shoes:
        return named
    shoes = np.array(states.system.layout.flexible_shoes) - 1
    across = rotations.rotation_matrices(motion["angles"][:, shoes])[..., 1]
    turned = states.parts(names)[..., 3:] + start[:, 3:]
    axis = rotations.rotation_matrices(turned[:, shoes // case.gear.loop(case.track).shoe_count])[..., 1]
    times, count, slots, strips = gear_forces.strip_guide.shape
    split = (times, count, slots, len(SIDES), strips // len(SIDES), 3)
    guide = gear_forces.strip_guide[..., None] * across[:, :, None, None]
    return named | {
        "strip_wheel": gear_forces.strip_wheel + 1,
        "strip_force": gear_forces.strip_force.reshape(split),
        "strip_foot": gear_forces.strip_foot.reshape(split),
        "strip_guide": guide.reshape(split),
        "lug_force": gear_forces.lug_force,
        "lug_guide": gear_forces.lug_guide[..., None] * axis[:, :, None],
    }


def _take_up(states: _States) -> np.ndarray:
    """Return the take-up of the idlers of closed tracks, (times, tracks), m; constant unless idlers slide."""
    case = states.system.case
    gear = case.part(Closed)
    take_up = np.full((len(states.rows), gear.tracks), gear.assembled(case).take_up)
    if not gear.sliding_idlers:
        return take_up
    frame = states.part(SIDE_FRAME)
    start = gear.idler_reference(case)[:, :3] - gear.frame_start(case)
    for k, name in enumerate(gear.sliding_idlers):
        apart = states.part(name)[:, :3] - frame[:, :3] + start[k]
        turn = rotations.rotation_matrices(frame[:, 3:])
        take_up[:, k] += np.einsum("tik,ti->tk", turn, apart)[:, 0] - start[k, 0]
    return take_up


def _coordinates(system: "TrackSystem") -> dict[str, object]:
    """Return the coordinates of the dimensions of flexible shoes, and of two tracks."""
    named = dict[str, object]()
    if system.frequencies is not None:
        named["flexible_shoe"] = list(system.layout.flexible_shoes)
        named["mode"] = np.arange(1, system.layout.modes + 1)
        named["frequency"] = ("mode", system.frequencies, {"units": "Hz"})
        named["pin"] = list(SIDES)
    case = system.case
    if case.gear.tracks > 1:
        side = np.repeat(SIDES, case.gear.loop(case.track).shoe_count)
        named |= {catalogue.TRACK: list(SIDES), "shoe_track": ("shoe", side), "joint_track": ("joint", side)}
    return named


def _tread_coordinates(system: "TrackSystem") -> dict[str, object]:
    """Return the coordinates of the dimensions of treads."""
    strips = np.arange(1, system.case.part(RunningGear).strips + 1)
    return {
        "rail": list(SIDES),
        "strip": ("strip", strips, {"long_name": "of a tread, from right to left"}),
    }


def _swinging_coordinates(system: "TrackSystem") -> dict[str, object]:
    """Return the names of bogies and arms; empty without any."""
    gear = system.case.part(RunningGear)
    named = {"bogie": gear.bogie_names, "arm": gear.arm_names}
    return {dimension: list(names) for dimension, names in named.items() if names}


def _roller_coordinates(system: "TrackSystem") -> dict[str, object]:
    """Return the coordinates of the dimensions of rollers and their treads."""
    rollers = np.arange(1, len(system.case.part(RunningGear).rollers) + 1)
    under = "shoe under a roller's axis, or the next"
    return (
        _tread_coordinates(system)
        | _swinging_coordinates(system)
        | {
            "roller": ("roller", rollers, {"long_name": "from rear to front"}),
            "neighbour": ("neighbour", list(NEIGHBOURS), {"long_name": under}),
        }
    )


def _wheel_coordinates(system: "TrackSystem") -> dict[str, object]:
    """Return the coordinates of the dimensions of wheels; with flexible shoes also of their treads."""
    named = {"wheel": system.case.gear.wheel_names} | _swinging_coordinates(system)
    return named if system.frequencies is None else named | _tread_coordinates(system)


class _OfGear(NamedTuple):
    """Part of a history that depends on the kind of gear."""

    values: Callable[[_States, Arrays], Arrays]  # takes the states and the motion of the shoes
    coordinates: Callable[["TrackSystem"], dict[str, object]]


_CLOSED = _OfGear(_closed, _wheel_coordinates)
OF_GEAR = {
    "dragged": _OfGear(_dragged, lambda _system: {}),
    "rolled": _OfGear(_rolled, _roller_coordinates),
    "closed": _CLOSED,
    "machine": _CLOSED,
}
"""Gear's part of a history by the kind of gear."""
