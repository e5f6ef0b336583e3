"""What acts on the shoes and the side frame of a history, as data: a record for each action, over all times.

Balances of momentum and energy and the modal loads of a flexible shoe sum over these records; a new kind of
load is one force element in `model` and one record here. All vectors are global, all units SI.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr

from exudyn_crawler.case import SIDES, Case, Undercarriage
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.flexible_shoes import side_weights, whole_reduction
from exudyn_crawler.results.history.history import History


class AtInterface(NamedTuple):
    """Enters a flexible shoe at the centre of one of its interfaces, through the rigid spider there."""

    name: str


class OverSurface(NamedTuple):
    """Enters a flexible shoe spread over the surface that the machine's load presses on."""

    shift: np.ndarray | None = None  # (times,), m left of the surface's middle; None if its pressure is even


class OverRectangle(NamedTuple):
    """Enters a flexible shoe spread evenly over a rectangle of its underside."""

    low: np.ndarray  # (times, 2), least x and y in the shoe's frame, m
    high: np.ndarray
    pressed: np.ndarray  # (times,), whether there is one at all


class AtGridNode(NamedTuple):
    """Enters a flexible shoe about a node, from 0, of the coarse grid of its underside, spread by hats."""

    node: int


class OnRail(NamedTuple):
    """Enters a flexible shoe at x (times,) in its frame, m, along one of its rails."""

    line: int  # strip of the treads, counted from 0 over both rails
    x: np.ndarray
    roller: int = 0  # number from 0


class AtDrivePoint(NamedTuple):
    """Enters a flexible shoe at the point that the drive moves."""


Entry = AtInterface | OverSurface | OverRectangle | AtGridNode | AtDrivePoint | OnRail


@dataclass(frozen=True)
class Action:
    """One thing that acts on one body.

    Kinds on shoes are "joint", "weight", "load", "contact" and "drive", under a side frame also "roller" and
    "chain" (pull of the drive, tension of the ends), in a closed track "wheel" and "tooth", each with its
    flanges, on its flexible shoes "roller", "idler", "carrier", "slide" and "tooth" without, and "guide" of
    all flanges; on the frame "weight", "machine", "roller" and "pull".
    """

    kind: str
    shoe: int  # its number; 0 is the side frame
    where: str  # place in words, such as "front right" (a pin) or "unit 12" (what the shoe stands on)
    point: np.ndarray  # (times, 3), m, where the force acts; on a flexible shoe a point of the unbent one
    force: np.ndarray  # (times, 3), N, on the body
    moment: np.ndarray  # (times, 3), N m, beside that of the force
    entry: Entry | None = None  # into a flexible shoe; None by its frame or as its mass: no mode is loaded

    def moment_about(self, place: np.ndarray) -> np.ndarray:
        """Moment about a place (times, 3) or (3,), m: array (times, 3), N m."""
        return np.cross(self.point - place, self.force) + self.moment


class ShoeMass(NamedTuple):
    """Mass of a shoe and points of its frame (3,), m."""

    mass: float  # kg
    center: np.ndarray
    load_point: np.ndarray  # under the machine's load
    beside: np.ndarray  # how far that moves for each metre of a load's shift to the left


def shoe_mass(case: Case, shoe: int) -> ShoeMass:
    """Mass of a shoe of a case; a flexible one has that of its mesh."""
    flexible = case.flexible
    if flexible is None or shoe not in flexible.shoes:
        left = np.array([0.0, 1.0, 0.0])
        return ShoeMass(case.shoe.mass, np.zeros(3), np.array(case.shoe.load_point), left)
    body = whole_reduction(case).body
    weights = body.weights(flexible.load_surface)
    right, left = (one @ body.nodes / one.sum() for one in side_weights(weights, body.nodes))
    beside = (left - right) / (left[1] - right[1])
    return ShoeMass(body.mass, body.center_of_mass, weights @ body.nodes, beside)


def shoe_frames(history: History, shoe: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions (times, 3), m, of a shoe's frame, and its axes (times, 3, 3), a column each."""
    position, angles = (history.dataset[name].sel(shoe=shoe).values for name in ("position", "angles"))
    return position, rotation_matrices(angles)


def actions(history: History, shoe: int | None = None) -> list[Action]:
    """All that acts on the shoes of a history, or on one of them, as of `Action.kind`."""
    shoes = history.case.track.shoes.tolist() if shoe is None else [shoe]
    return [action for number in shoes for action in _on_shoe(history, number)]


def _on_shoe(history: History, shoe: int) -> Iterator[Action]:
    (position, frames), flexible = shoe_frames(history, shoe), history.case.flexible
    bends = flexible is not None and shoe in flexible.shoes
    yield from _joints(history, shoe, position, frames)
    yield from _weight_and_load(history, shoe, position, frames)
    if bends and "node_force" in history.dataset:
        yield from _grid(history, shoe, position, frames)
    else:
        yield from _contacts(history, shoe, bends)
    if shoe == history.case.track.shoe_count and not history.case.is_closed:
        yield from _drive(history, shoe, position, frames)
    if history.case.is_closed and not bends:
        yield from wheels_and_teeth(history, shoe, position)
    elif history.case.running_gear is not None:
        yield from treads_on(history, shoe, position, frames)
        yield from (_lugs if history.case.is_closed else _chain)(history, shoe, position, frames)


def _joints(history: History, shoe: int, position: np.ndarray, frames: np.ndarray) -> Iterator[Action]:
    """Joints of both links; a link of two rigid shoes has one, at its right pin, in a closed track midway."""
    track, closed = history.case.track, history.case.closed_track
    ends = dict(zip(history.case.links[:, 1].tolist(), history.case.joints.tolist(), strict=True))
    # the link ahead acts on its rear shoe as stored, the link behind with the opposite
    for end, joint, sign in (("front", shoe, 1.0), ("rear", ends.get(shoe, 0), -1.0)):
        if joint not in history.case.joints:
            continue
        link = history.dataset.sel(joint=joint)
        reactions = [link.joint_force.values, link.joint_torque.values]
        if "pin_force" in link and bool(link.pin_force.notnull().all()):
            reactions = [link.pin_force.values, link.pin_torque.values]
        force, torque = (sign * one.reshape(len(position), -1, 3) for one in reactions)
        for side in range(force.shape[1]):
            where = f"{end} {SIDES[side]}"
            place, pushed = np.array(track.joint_centers[where]), force[:, side]
            if closed is not None and force.shape[1] == 1:
                centers = [c for name, c in track.joint_centers.items() if name.startswith(end)]
                place = np.mean(centers, axis=0)
            moment = torque[:, side]
            if closed is not None and end == "rear":  # a worn pin is farther back
                wear = (track.pitch - closed.chain_pitch(track)) * frames[:, :, 0]
                moment = moment + np.cross(wear, pushed)
            point = position + frames @ place
            yield Action("joint", shoe, where, point, pushed, moment, AtInterface(where))


def _weight_and_load(
    history: History, shoe: int, position: np.ndarray, frames: np.ndarray
) -> Iterator[Action]:
    own = shoe_mass(history.case, shoe)
    zero = np.zeros_like(position)
    weight = zero + own.mass * history.case.gravity_vector()
    load = history.shoe_load.sel(shoe=shoe).values[:, None] * history.case.terrain.down
    yield Action("weight", shoe, "COM", position + frames @ own.center, weight, zero)
    shift = history.case.loads.side_shift.value(history.time.values)
    place = own.load_point + shift[:, None] * own.beside
    point = position + (frames @ place[..., None])[..., 0]
    entry = OverSurface(shift if np.any(shift) else None)
    yield Action("load", shoe, "top", point, load, zero, entry)


def _grid(history: History, shoe: int, position: np.ndarray, frames: np.ndarray) -> Iterator[Action]:
    """Forces of the cells at the nodes of a flexible shoe's grid."""
    forces = history.node_force.sel(flexible_shoe=shoe).values
    x0, x1, y0, y1, z = history.case.shoe.footprint
    zero = np.zeros_like(position)
    for node, (i, j) in enumerate(np.ndindex(forces.shape[1:3])):
        place = np.linspace(x0, x1, forces.shape[1])[i], np.linspace(y0, y1, forces.shape[2])[j], z
        force = np.einsum("tij,tj->ti", frames, forces[:, i, j])
        yield Action("contact", shoe, "cells", position + frames @ place, force, zero, AtGridNode(node))


def _contacts(history: History, shoe: int, bends: bool) -> Iterator[Action]:
    """Contact with every unit that the shoe ever met, or with the cells."""
    own = np.flatnonzero(history.contact_shoe.values == shoe)
    # read once, for histories larger than memory
    area, point, normal, friction, torque = (
        history.dataset[name].isel(contact=own).values
        for name in ("area", "point", "normal_force", "friction_force", "friction_torque")
    )
    patch = history.patch.isel(contact=own).values if bends else None
    for column, unit in enumerate(history.contact_unit.values[own].tolist()):
        entry = None
        if patch is not None:
            entry = OverRectangle(patch[:, column, 0::2], patch[:, column, 1::2], area[:, column] > 0.0)
        force = normal[:, column] + friction[:, column]
        where = f"unit {unit}" if unit else "cells"
        yield Action("contact", shoe, where, point[:, column], force, torque[:, column], entry)


def _drive(history: History, shoe: int, position: np.ndarray, frames: np.ndarray) -> Iterator[Action]:
    """Drive along x at its point, and the turn about the shoe's own z axis, on its frame."""
    zero, force = np.zeros_like(position), np.zeros_like(position)
    force[:, 0] = history.drive_force.values
    moment = history.drive_torque.values[:, None] * frames[:, :, 2]
    at = history.case.drive.point
    yield Action("drive", shoe, at, history.drive_point.values, force, zero, AtDrivePoint())
    yield Action("drive", shoe, "frame", position, zero, moment)


def wheels_and_teeth(history: History, shoe: int, position: np.ndarray) -> Iterator[Action]:
    """Wrenches about the COM of all wheels of a closed track on the shoe, and of its tumbler."""
    on_shoe = history.dataset.sel(shoe=shoe)
    yield Action("wheel", shoe, "COM", position, on_shoe.wheel_load.values, on_shoe.wheel_moment.values)
    yield Action("tooth", shoe, "COM", position, on_shoe.tooth_force.values, on_shoe.tooth_moment.values)


def _lugs(history: History, shoe: int, position: np.ndarray, frames: np.ndarray) -> Iterator[Action]:
    """Teeth on the lugs of a flexible shoe, which the bores next to them hold, and their flange."""
    on_shoe, track = history.dataset.sel(flexible_shoe=shoe), history.case.track
    guide = on_shoe.lug_guide.values
    for kind, forces in (("tooth", on_shoe.lug_force.values - guide), ("guide", guide)):
        for lug, (where, place) in enumerate(history.case.closed_gear().lugs(track)):
            force, center = forces[:, lug], np.array(track.joint_centers[where])
            if force.any():
                moment = np.cross(frames @ (place - center), force)
                point = position + frames @ center
                yield Action(kind, shoe, where, point, force, moment, AtInterface(where))


class Treads(NamedTuple):
    """Strips of treads on shoes: a slot for each wheel that may be on a shoe."""

    shoe: np.ndarray  # (times, slots), its number
    wheel: np.ndarray  # (times, slots), number from 0, -1 for none
    force: np.ndarray  # (times, slots, rails, strips, 3), N, on the shoe, with that of the flange
    foot: np.ndarray  # same, m, where it acts
    guide: np.ndarray  # same, N, of the flange alone


def treads(dataset: xr.Dataset) -> Treads:
    """Treads of a rolled history's dataset, or of a closed one's with flexible shoes."""
    # read once: a history larger than memory reads a variable from its file whenever it is asked for
    if "tread_force" in dataset:
        dims = ("time", "roller", "neighbour", "rail", "strip", "axis")
        force, foot = (dataset[f"tread_{name}"].transpose(*dims).values for name in ("force", "foot"))
        # a tread presses on the shoe behind its roller's axis and on the one ahead of that
        shoe = dataset.roller_shoe.transpose("time", "roller").values[..., None] + np.arange(force.shape[2])
        wheel, guide = np.arange(force.shape[1])[:, None], np.broadcast_to(0.0, force.shape)
    else:
        force, foot, guide = (dataset[f"strip_{name}"].values for name in ("force", "foot", "guide"))
        shoe, wheel = dataset.flexible_shoe.values[:, None], dataset.strip_wheel.values - 1
    times, *slots = force.shape[:3]
    numbers = (np.broadcast_to(one, (times, *slots)).reshape(times, -1) for one in (shoe, wheel))
    return Treads(*numbers, *(one.reshape(times, -1, *one.shape[3:]) for one in (force, foot, guide)))


def treads_on(history: History, shoe: int, position: np.ndarray, frames: np.ndarray) -> Iterator[Action]:
    """Every strip of a tread that was ever on the shoe, and its flange; a flexible one in a closed track."""
    if closed := history.case.is_closed:
        names = history.wheel.values.tolist()
    else:
        names = [f"roller {number}" for number in history.roller.values]
    found = treads(history.dataset.sel(flexible_shoe=[shoe]) if closed else history.dataset)
    wheels, force, foot, guide = np.where(found.shoe == shoe, found.wheel, -1), *found[2:]
    for wheel, rail, strip in np.ndindex(len(names), *force.shape[2:4]):
        here = (wheels == wheel) & force[:, :, rail, strip].any(axis=-1)
        if not here.any():
            continue
        pressed, sideways, point = np.zeros_like(position), np.zeros_like(position), position.copy()
        for slot in np.flatnonzero(here.any(axis=0)):
            on, at = here[:, slot], (here[:, slot], slot, rail, strip)
            sideways[on], point[on] = guide[at], foot[at]
            pressed[on] = force[at] - guide[at]
        x = np.einsum("ti,ti->t", point - position, frames[:, :, 0])
        entry, where = OnRail(rail * force.shape[3] + strip, x, wheel), f"{names[wheel]} {SIDES[rail]}"
        if pressed.any():
            # with two tracks wheels are "right idler" and so on
            kind = next(kind for kind in ("roller", "idler", "carrier", "slide") if kind in where)
            yield Action(kind, shoe, where, point, pressed, np.zeros_like(position), entry)
        if sideways.any():
            where = f"flange of {where}"
            yield Action("guide", shoe, where, point, sideways, np.zeros_like(position), entry)


def _chain(history: History, shoe: int, position: np.ndarray, frames: np.ndarray) -> Iterator[Action]:
    """Pull of the drive at the shoe's front pins, and the tension of the chain at the outermost ones."""
    track, zero, tension = history.case.track, np.zeros_like(position), frame_of(history).end_tension
    pulls = {"front": -drive_pulls(history)[:, shoe - 1], "rear": zero[:, 0]}
    if shoe == track.shoe_count:
        pulls["front"] = pulls["front"] + tension
    if shoe == 1:
        pulls["rear"] = pulls["rear"] - tension
    for where, center in track.joint_centers.items():
        force = zero.copy()
        force[:, 0] = 0.5 * pulls[where.split()[0]]
        if force.any():
            yield Action("chain", shoe, where, position + frames @ center, force, zero, AtInterface(where))


def drive_pulls(history: History) -> np.ndarray:
    """Pull of the drive at each shoe's front pins, backward, N: array (times, shoes)."""
    track, frame = history.case.track, frame_of(history)
    first = history.position.sel(shoe=1, axis="x").values + track.pin_ahead
    tumbler = history.side_frame_position.sel(axis="x").values + frame.tumbler
    shares = frame.shares_of_links(tumbler - first, track.shoe_count - 1, track.pitch)
    return history.drive_pull.values[:, None] * np.column_stack((shares, np.zeros(len(shares))))


def frame_of(history: History) -> Undercarriage:
    """Undercarriage of the history's case; ValueError if it has none."""
    frame = history.case.undercarriage
    if frame is None:
        name = history.case.name
        raise ValueError(f"the history must be of a case with an undercarriage, {name!r} has none")
    return frame
