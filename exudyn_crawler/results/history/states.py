"""From the states of the multibody system to a history's named variables; nothing here solves anything."""

from collections.abc import Callable, Iterable
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from exudyn_crawler.case import SIDES
from exudyn_crawler.ground import rotations, terrain
from exudyn_crawler.ground.cells.ground import COARSE
from exudyn_crawler.ground.pairs import RESULT, RESULTS
from exudyn_crawler.model.state import IDLERS, MOTOR, RATES, SIDE_FRAME, TUMBLERS, VERSION, pin_name
from exudyn_crawler.results.history import History, catalogue, files

if TYPE_CHECKING:
    from exudyn_crawler.model.track_system import TrackSystem

AXES = ["x", "y", "z"]

CONTACTS = catalogue.select(per="pair", files="history")  # variables of every contact

LINKS = (catalogue.OPEN_LINKS, catalogue.CLOSED_LINKS, catalogue.PAIR_OF_LOOPS)

VERSIONS = {f"{name.replace('-', '_')}_version": version(name) for name in ("exudyn", "exudyn-crawler")}

NEIGHBOURS = ("behind", "ahead")
"""Shoes that a roller may be on at once: the last one whose COM its axis has passed, and the next."""


COORDINATES = ("coordinates", "coordinates rate")


class _States(NamedTuple):
    """Stored states (times, layout.size) of a system."""

    system: "TrackSystem"
    rows: np.ndarray

    def part(self, name: str) -> np.ndarray:
        return self.system.layout.part(self.rows, name)

    def parts(self, names: Iterable[str]) -> np.ndarray:
        """Parts of one shape side by side: (times, names, ...)."""
        return np.stack([self.part(name) for name in names], axis=1)

    def each(self, of: Callable[..., Any], *names: str) -> list[Any]:
        """What a function makes of some parts of each state."""
        return [of(*state) for state in zip(*map(self.part, names), strict=True)]


def system_history(system: "TrackSystem", rows: np.ndarray) -> History:
    """History of states (times, layout.size) of a system."""
    case, states = system.case, _States(system, rows)
    time = states.part("time")
    start = case.shoe_reference if case.is_closed else case.track.com_positions(case.shoe.com_height)
    contacts, pairs = _contacts(states)
    values = _motion(states, "shoes", start) | _reactions(states) | _terrain(states) | contacts
    values["shoe_load"] = case.loads.loads(time)
    if system.gear_forces is not None:
        values |= (_closed if case.is_closed else _rolled)(states, _gear_forces(states, system.gear_forces))
    dataset = xr.Dataset(
        {name: catalogue.variable(name, one) for name, one in values.items()},
        coords={
            "time": ("time", time, {"units": "s"}),
            "shoe": case.track.shoes,
            "joint": ("joint", case.joints, {"long_name": LINKS[case.is_closed * case.tracks]}),
            **({"unit": case.terrain.units} if len(case.terrain.units) else {}),
            "axis": AXES,
            **_coordinates(system),
            **files.contact_coordinates(pairs),
        },
        attrs={"title": case.name, **VERSIONS, files.LAYOUT_VERSION: VERSION},
    )
    return History(case=case, dataset=files.with_motion_of_units(dataset))


def _motion(states: _States, bodies: str, start: np.ndarray, prefix: str = "") -> dict[str, np.ndarray]:
    """Motion of the bodies of a part of the states, whose coordinates count from where they start.

    `start` (..., 3) are positions (m), or with the angles there (rad) (..., 6).
    """
    u, v, a = (states.part(f"{bodies}{rate}") for rate in RATES)
    angles, rates, accelerations = u[..., 3:], v[..., 3:], a[..., 3:]
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


def _pins(states: _States) -> tuple[np.ndarray, np.ndarray]:
    """Force and torque of every joint on its rear shoe: arrays (times, links, sides, 3), NaN for no joint.

    A joint's equations are ``p_front - p_rear = 0`` and, with the axes of the rear shoe marked 0 and of
    the front one 1, ``y0 . x1 = 0`` and ``y0 . z1 = 0``: the multipliers of the first are the force on
    the rear shoe, those of the others turn it by ``x1 x y0`` and ``z1 x y0``. In a closed track the first
    three are along the axes of the chain's plane (`model.joints.plane_axis`).
    """
    layout, case = states.system.layout, states.system.case
    joints, angles = case.joints, states.part("shoes")[..., 3:]
    if case.is_closed:
        angles = angles + case.shoe_reference[:, 3:]
    frames = rotations.rotation_matrices(angles)
    rear, front = np.moveaxis(frames[:, case.links - 1], 2, 0)
    y0, x1, z1 = rear[..., 1], front[..., 0], front[..., 2]
    level = np.stack((np.cos(angles[..., 2]), np.sin(angles[..., 2]), np.zeros(angles.shape[:2])), axis=-1)
    about_x, about_z = np.cross(x1, y0), np.cross(z1, y0)
    force, torque = np.full((2, len(states.rows), len(joints), len(SIDES), 3), np.nan)
    for link, side in np.ndindex(force.shape[1:3]):
        name = pin_name(SIDES[side], int(joints[link]))
        if layout.has(name):
            reaction = states.part(name)
            force[:, link, side] = reaction[:, :3]
            if case.is_closed:
                ahead, across = level[:, link], y0[:, link]
                axes = np.stack((ahead, across, np.cross(ahead, across)), axis=1)
                force[:, link, side] = np.einsum("tr,trc->tc", reaction[:, :3], axes)
            turning = reaction[:, 3, None] * about_x[:, link]
            torque[:, link, side] = turning + reaction[:, -1, None] * about_z[:, link]
    return force, torque


def _reactions(states: _States) -> dict[str, np.ndarray]:
    """Forces and torques of links and drive; of a track with flexible shoes those of each pin, too."""
    layout, (force, torque) = states.system.layout, _pins(states)
    named = {
        "joint_force": np.nansum(force, axis=2),
        "joint_torque": np.nansum(torque, axis=2),
        "drive_force": -states.part("drive")[:, 0] * (not states.system.case.is_rolled),
        "drive_point": _drive_point(states),
        "drive_torque": -states.part("turn")[:, 0] if layout.has("turn") else np.zeros(len(states.rows)),
    }
    if layout.flexible_shoes:
        # a rigid link has one joint, whose reaction is no pin's
        single = np.isnan(force[:, :, -1:])
        named |= {
            "modal_coordinate": states.part("modes"),
            "modal_velocity": states.part("modes rate"),
            "pin_force": np.where(single, np.nan, force),
            "pin_torque": np.where(single, np.nan, torque),
        }
    return named


def _drive_point(states: _States) -> np.ndarray:
    """Where the drive acts: array (times, 3)."""
    case, point, front = states.system.case, states.system.point, states.part("shoes")[:, -1]
    # the front shoe is the last of the flexible ones, if it is one of them
    modal = states.part("modes")[:, -1] if point.rows.size else np.zeros((len(front), 0))
    start = case.shoe_reference[-1]
    return front[:, :3] + start[:3] + point.arm(front[:, 3:] + start[3:], modal)


def _terrain(states: _States) -> dict[str, np.ndarray]:
    contact = states.system.contact
    if not len(states.system.case.terrain.units):
        return {}
    modes = contact.coordinates
    if isinstance(modes, terrain.TerrainModes):
        shapes = dict(zip(files.SHAPES.values(), (modes.heave, modes.tilt), strict=True))
        rates = zip(RATES, files.RATES, strict=True)
        return shapes | {
            f"{files.TERRAIN}{name}": states.part(f"terrain{rate}").copy() for rate, name in rates
        }
    named = {}
    for rate in RATES:
        units = np.stack([modes.motion(row) for row in states.part(f"terrain{rate}")])
        for name, column in (("heave", 2), ("tilt", 3)):
            named[f"unit_{name}{rate.replace(' ', '_')}"] = units[..., column]
    return named


def _contacts(states: _States) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Contacts over time, a column for each volume of a pair that ever met; zero while there is none."""
    more = ("contact",) if states.system.layout.contact else ()
    results = states.each(states.system.contact.results, *COORDINATES, *more)
    rows = np.concatenate(results)
    keys = rows[:, [RESULT[name] for name in ("shoe", "unit", "finger")]].astype(int)
    keys[:, :2] += 1  # shoes and units count from 1
    pairs, column = np.unique(keys, axis=0, return_inverse=True)
    when = np.repeat(np.arange(len(results)), [len(one) for one in results])
    tables = {}
    for name, quantity in CONTACTS.items():
        if not quantity.lacking(states.system.case):
            values = rows[..., RESULT[name]]
            tables[name] = np.zeros((len(results), len(pairs), *values.shape[1:]))
            # a history in memory has the numbers of its file
            tables[name][when, column.ravel()] = values.astype(quantity.dtype)
    node_force = catalogue.QUANTITIES["node_force"]
    if not node_force.lacking(states.system.case):
        flexible = np.array(states.system.layout.flexible_shoes) - 1
        forces = states.part("contact")[:, flexible, RESULTS:].astype(node_force.dtype).astype(float)
        tables["node_force"] = forces.reshape(*forces.shape[:2], *COARSE, 3)
    return tables, pairs


def _gear_forces(states: _States, forces: Callable[..., dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """What a running gear does to the shoes, as of `TrackSystem.gear_forces`, over all times."""
    each = states.each(forces, "time", *COORDINATES)
    return {name: np.array([one[name] for one in each]) for name in each[0]}


def _rolled(states: _States, found: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Motion of the side frame, forces of its rollers and pull of its drive."""
    case = states.system.case
    frame, motion = case.undercarriage, _motion(states, SIDE_FRAME, case.frame_start, "side_frame_")
    assert frame is not None
    turned = rotations.rotation_matrices(motion["side_frame_angles"])[:, 0, 0]
    axes = motion["side_frame_position"][:, :1] + np.outer(turned, frame.rollers)
    first = case.shoe_reference[0, 0] + states.part("shoes")[:, :1, 0]
    behind = np.floor((axes - first) / case.track.pitch).astype(int)
    behind = np.clip(behind, 0, case.track.shoe_count - len(NEIGHBOURS))
    rollers, when = np.arange(axes.shape[1]), np.arange(len(axes))[:, None, None]
    shoes = behind[..., None] + np.arange(len(NEIGHBOURS))
    # of either slot of a shoe, where it has the roller: (times, rollers, neighbours, strips, 3)
    has = (found["strip_wheel"][when, shoes] == rollers[:, None, None])[..., None, None]
    split = (*axes.shape, len(NEIGHBOURS), len(SIDES), frame.strips, 3)
    force, foot = (
        np.where(has, found[name][when, shoes], 0.0).sum(axis=3).reshape(split).transpose(0, 1, 3, 4, 2, 5)
        for name in ("strip_force", "strip_foot")
    )
    return motion | {
        "drive_pull": -states.part("drive")[:, 0],
        "roller_shoe": behind + 1,
        "roller_force": force.sum(axis=(3, 4)),
        "tread_force": force,
        "tread_foot": foot,
    }


def _closed(states: _States, found: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Motion of side frame and tumbler of a closed track, drive, wheels and teeth."""
    case = states.system.case
    names, start = TUMBLERS[case.tracks], case.tumbler_reference
    place = states.parts(names)[..., :3] + start[:, :3]
    torque = -states.parts(map(MOTOR.format, names))[..., 0]
    pitch, rate = (
        states.parts(f"{name}{after}" for name in names)[..., 4] - states.part(SIDE_FRAME + after)[:, 4, None]
        for after in RATES[:2]
    )
    take_up = _take_up(states)
    if case.tracks == 1:
        place, torque, pitch, rate, take_up = (one[:, 0] for one in (place, torque, pitch, rate, take_up))
    named = _motion(states, SIDE_FRAME, case.frame_start, "side_frame_") | {
        "tumbler_position": place,
        "tumbler_angle": pitch,
        "tumbler_speed": rate,
        "drive_moment": torque,
        "take_up": take_up,
        "wheel_force": found["on_wheels"],
        "wheel_load": found["wheel"][..., :3],
        "wheel_moment": found["wheel"][..., 3:],
        "tooth_force": found["tooth"][..., :3],
        "tooth_moment": found["tooth"][..., 3:],
        "guide_force": found["guide"],
        "wheel_energy": found["energy"][:, 0],
        "tooth_energy": found["energy"][:, 1],
    }
    return named | (_on_flexible_shoes(states, found) if states.system.layout.flexible_shoes else {})


def _on_flexible_shoes(states: _States, found: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Every strip of a wheel and every lug of the flexible shoes of a closed track."""
    case = states.system.case
    shoes = np.array(states.system.layout.flexible_shoes) - 1
    angles = states.part("shoes")[:, shoes, 3:] + case.shoe_reference[shoes, 3:]
    across = rotations.rotation_matrices(angles)[..., 1]
    names, of_track = TUMBLERS[case.tracks], shoes // case.loop.shoe_count
    turned = states.parts(names)[..., 3:] + case.tumbler_reference[:, 3:]
    axis = rotations.rotation_matrices(turned[:, of_track])[..., 1]
    times, count, slots, strips = found["strip_guide"].shape
    split = (times, count, slots, len(SIDES), strips // len(SIDES), 3)
    guide = found["strip_guide"][..., None] * across[:, :, None, None]
    return {
        "strip_wheel": found["strip_wheel"] + 1,
        "strip_force": found["strip_force"].reshape(split),
        "strip_foot": found["strip_foot"].reshape(split),
        "strip_guide": guide.reshape(split),
        "lug_force": found["lug_force"],
        "lug_guide": found["lug_guide"][..., None] * axis[:, :, None],
    }


def _take_up(states: _States) -> np.ndarray:
    """Take-up of the idlers of closed tracks, which shims keep: array (times, tracks), m."""
    case = states.system.case
    take_up = np.full((len(states.rows), case.tracks), case.assembled.take_up)
    if not case.has_tensioners:
        return take_up
    frame, start = states.part(SIDE_FRAME), case.idler_reference[:, :3] - case.frame_start
    for k, name in enumerate(IDLERS[case.tracks]):
        apart = states.part(name)[:, :3] - frame[:, :3] + start[k]
        turn = rotations.rotation_matrices(frame[:, 3:])
        take_up[:, k] += np.einsum("tik,ti->tk", turn, apart)[:, 0] - start[k, 0]
    return take_up


def _coordinates(system: "TrackSystem") -> dict[str, object]:
    """Coordinates of the dimensions of flexible shoes, and of rollers and treads."""
    named: dict[str, object] = {}
    if system.frequencies is not None:
        named["flexible_shoe"] = list(system.layout.flexible_shoes)
        named["mode"] = np.arange(1, system.layout.modes + 1)
        named["frequency"] = ("mode", system.frequencies, {"units": "Hz"})
        named["pin"] = list(SIDES)
    if system.case.closed_track is not None:
        named["wheel"] = system.case.wheel_names
    if system.case.tracks > 1:
        side = np.repeat(SIDES, system.case.loop.shoe_count)
        named |= {catalogue.TRACK: list(SIDES), "shoe_track": ("shoe", side), "joint_track": ("joint", side)}
    frame, gear = system.case.undercarriage, system.case.running_gear
    if gear is None or (frame is None and system.frequencies is None):
        return named
    strips = np.arange(1, gear.strips + 1)
    named |= {
        "rail": list(SIDES),
        "strip": ("strip", strips, {"long_name": "of a tread, from right to left"}),
    }
    if frame is None:
        return named
    rollers, under = np.arange(1, len(frame.rollers) + 1), "shoe under a roller's axis, or the next"
    return named | {
        "roller": ("roller", rollers, {"long_name": "from rear to front"}),
        "neighbour": ("neighbour", list(NEIGHBOURS), {"long_name": under}),
    }
