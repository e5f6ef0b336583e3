"""Actions on the shoes and the side frame of a history: a record for each action, over all times.

Balances of momentum and energy and the modal loads of a flexible shoe are sums over these records. A new kind
of load needs a force element in `model` and a record here. All vectors are global, all units SI.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr

from exudyn_crawler.case import SIDES, Case, Track
from exudyn_crawler.case.gear.base import WheelKind
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.gear.rolled import Rolled
from exudyn_crawler.case.parameters.track import MIDWAY
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.flexible_shoes import side_weights, whole_reduction
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads.kinds import Kind
from exudyn_crawler.results.loads.locations import (
    ENDS,
    PINS,
    GroundUnit,
    Location,
    OnTread,
    Pin,
    Point,
    words,
)


class AtInterface(NamedTuple):
    """Entry into a flexible shoe at the centre of an interface, through the coupling there."""

    name: str


class OverSurface(NamedTuple):
    """Entry into a flexible shoe spread over the surface that carries the machine's load."""

    shift: np.ndarray | None = None  # (times,), m left of the surface's middle; None if its pressure is even


class OverRectangle(NamedTuple):
    """Entry into a flexible shoe spread evenly over a rectangle of its underside."""

    low: np.ndarray  # (times, 2), least x and y in the shoe's frame, m
    high: np.ndarray
    pressed: np.ndarray  # (times,), True while there is contact


class AtGridNode(NamedTuple):
    """Entry into a flexible shoe about a node (from 0) of its underside's coarse grid, spread by hats."""

    node: int


class OnRail(NamedTuple):
    """Entry into a flexible shoe at x (times,) in its frame, m, along one of its rails."""

    line: int  # strip of the treads, counted from 0 over both rails
    x: np.ndarray
    roller: int = 0  # number from 0


class AtDriveNode(NamedTuple):
    """Entry into a flexible shoe at the node that the drive moves; without such a node, at its frame."""


class AtPins(NamedTuple):
    """Entry into a flexible shoe at the centres of several interfaces, in equal parts."""

    names: tuple[str, ...]


Entry = AtInterface | OverSurface | OverRectangle | AtGridNode | AtDriveNode | AtPins | OnRail

ON_RAILS: dict[WheelKind, Kind] = {
    "roller": Kind.ROLLER,
    "idler": Kind.IDLER,
    "carrier": Kind.CARRIER,
    "slide": Kind.SLIDE,
}


@dataclass(frozen=True)
class Action:
    """Force and moment of one source on one body.

    Kinds on all shoes are joint, weight, load, contact and drive. Under a side frame there are also roller
    and chain (pull of the drive, tension of the ends). A rigid shoe of a closed track has wheel and tooth,
    each with its flanges. A flexible one has roller, idler, carrier, slide and tooth without flanges, and
    guide for all flanges. Kinds on the side frame are weight, machine, roller and pull.
    """

    kind: Kind
    shoe: int  # its number; 0 is the side frame
    place: Location
    point: np.ndarray  # (times, 3), m, point of action; on a flexible shoe a point of the undeformed one
    force: np.ndarray  # (times, 3), N, on the body
    moment: np.ndarray  # (times, 3), N m, in addition to that of the force
    entry: Entry | None = None  # into a flexible shoe; None if it loads no mode: at the frame, or as its mass

    @property
    def where(self) -> str:
        """Location in words, such as "front right" (a pin) or "unit 12" (of the ground)."""
        return words(self.place)

    def moment_about(self, center: np.ndarray) -> np.ndarray:
        """Return the moment about a point (times, 3) or (3,), m: array (times, 3), N m."""
        return np.cross(self.point - center, self.force) + self.moment


class ShoeMass(NamedTuple):
    """Mass of a shoe, and points in its frame (3,), m."""

    mass: float  # kg
    center: np.ndarray
    load_point: np.ndarray  # centre of the machine's load
    beside: np.ndarray  # displacement of this centre by each metre of a load's shift to the left


def shoe_mass(case: Case, shoe: int) -> ShoeMass:
    """Return the mass of a shoe of a case; a flexible one has that of its mesh."""
    flexible = case.flexible
    if flexible is None or shoe not in flexible.shoes:
        left = np.array([0.0, 1.0, 0.0])
        return ShoeMass(case.shoe.mass, np.zeros(3), np.array(case.shoe.load_point), left)
    body = whole_reduction(case).body
    weights = body.weights(flexible.load_surface)
    right, left = (half @ body.nodes / half.sum() for half in side_weights(weights, body.nodes))
    beside = (left - right) / (left[1] - right[1])
    return ShoeMass(body.mass, body.center_of_mass, weights @ body.nodes, beside)


def shoe_frames(history: History, shoe: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions (times, 3), m, of a shoe's frame, and its axes (times, 3, 3), a column each."""
    position, angles = (history.dataset[name].sel(shoe=shoe).values for name in ("position", "angles"))
    return position, rotation_matrices(angles)


def actions(history: History, shoe: int | None = None) -> list[Action]:
    """Return all actions on the shoes of a history, or on one of them; see `Action` for the kinds."""
    shoes = history.case.track.shoes.tolist() if shoe is None else [shoe]
    return [action for number in shoes for action in _on_shoe(history, number)]


def _on_shoe(history: History, shoe: int) -> Iterator[Action]:
    position, frames = shoe_frames(history, shoe)
    flexible = history.case.flexible
    bends = flexible is not None and shoe in flexible.shoes
    yield from _joints(history, shoe, position, frames)
    yield from _weight_and_load(history, shoe, position, frames)
    if bends and "node_force" in history.dataset:
        yield from _grid(history, shoe, position, frames)
    else:
        yield from _contacts(history, shoe, bends)
    yield from OF_GEAR[history.case.gear.kind](history, shoe, position, frames, bends)


def _joints(history: History, shoe: int, position: np.ndarray, frames: np.ndarray) -> Iterator[Action]:
    """Yield joints of both links; a link of rigid shoes has one, at its right pin, or midway if closed.

    With play a force acts at the pin of the shoe behind, within the play beside that of the shoe in front.
    """
    track = history.case.track
    gear = history.case.gear
    joints = gear.joints(track)
    ends = dict(zip(gear.links(track)[:, 1].tolist(), joints.tolist(), strict=True))
    # stored forces act on a link's rear shoe: those of the link behind act here with the opposite sign
    for end, joint, sign in zip(ENDS, (shoe, ends.get(shoe, 0)), (1.0, -1.0), strict=True):
        if joint not in joints:
            continue
        link = history.dataset.sel(joint=joint)
        reactions = [link.joint_force.values, link.joint_torque.values]
        if "pin_force" in link and bool(link.pin_force.notnull().all()):
            reactions = [link.pin_force.values, link.pin_torque.values]
        force, torque = (sign * pair.reshape(len(position), -1, 3) for pair in reactions)
        pins = [Pin(end, side) for side in SIDES[: force.shape[1]]]
        if len(pins) == 1:
            pins = [Pin(end, gear.rigid_joint)]
        for number, pin in enumerate(pins):
            pushed = force[:, number]
            moment = torque[:, number]
            point = position + frames @ _center(track, pin)
            wear = track.pitch - gear.shoe_pitch(track)
            if gear.pin_play is not None and end == "rear":
                behind = history.dataset.sel(shoe=joint)
                turned = rotation_matrices(behind.angles.values)
                acts = behind.position.values + turned @ _center(track, Pin("front", pin.side))
                moment = moment + np.cross(acts - point, pushed)
            elif wear and end == "rear":  # a worn pin is farther back
                moment = moment + np.cross(wear * frames[:, :, 0], pushed)
            yield Action(Kind.JOINT, shoe, pin, point, pushed, moment, AtInterface(words(pin)))


def _center(track: Track, pin: Pin) -> np.ndarray:
    """Return the joint centre (3,) of a pin in the shoe's frame, m."""
    if pin.side == MIDWAY:
        return np.mean([track.joint_centers[words(Pin(pin.end, side))] for side in SIDES], axis=0)
    return np.array(track.joint_centers[words(pin)])


def _weight_and_load(
    history: History, shoe: int, position: np.ndarray, frames: np.ndarray
) -> Iterator[Action]:
    body = shoe_mass(history.case, shoe)
    zero = np.zeros_like(position)
    weight = zero + body.mass * history.case.gravity_vector()
    load = history.shoe_load.sel(shoe=shoe).values[:, None] * history.case.terrain.down
    yield Action(Kind.WEIGHT, shoe, Point.CENTER, position + frames @ body.center, weight, zero)
    shift = history.case.loads.side_shift.value(history.time.values)
    place = body.load_point + shift[:, None] * body.beside
    point = position + (frames @ place[..., None])[..., 0]
    entry = OverSurface(shift if np.any(shift) else None)
    yield Action(Kind.LOAD, shoe, Point.TOP, point, load, zero, entry)


def _grid(history: History, shoe: int, position: np.ndarray, frames: np.ndarray) -> Iterator[Action]:
    """Yield the forces of the cells at the nodes of a flexible shoe's grid."""
    forces = history.node_force.sel(flexible_shoe=shoe).values
    x0, x1, y0, y1, z = history.case.shoe.footprint
    zero = np.zeros_like(position)
    for node, (i, j) in enumerate(np.ndindex(forces.shape[1:3])):
        place = np.linspace(x0, x1, forces.shape[1])[i], np.linspace(y0, y1, forces.shape[2])[j], z
        force = np.einsum("tij,tj->ti", frames, forces[:, i, j])
        point = position + frames @ place
        yield Action(Kind.CONTACT, shoe, Point.CELLS, point, force, zero, AtGridNode(node))


def _contacts(history: History, shoe: int, bends: bool) -> Iterator[Action]:
    """Yield the contact with each unit that the shoe ever touched, or with the cells."""
    columns = np.flatnonzero(history.contact_shoe.values == shoe)
    # read once, since a history larger than memory reads its file at each access
    area, point, normal, friction, torque = (
        history.dataset[name].isel(contact=columns).values
        for name in ("area", "point", "normal_force", "friction_force", "friction_torque")
    )
    patch = history.patch.isel(contact=columns).values if bends else None
    for column, unit in enumerate(history.contact_unit.values[columns].tolist()):
        entry = None
        if patch is not None:
            entry = OverRectangle(patch[:, column, 0::2], patch[:, column, 1::2], area[:, column] > 0.0)
        force = normal[:, column] + friction[:, column]
        place = GroundUnit(unit) if unit else Point.CELLS
        yield Action(Kind.CONTACT, shoe, place, point[:, column], force, torque[:, column], entry)


def _on_dragged(
    history: History, shoe: int, position: np.ndarray, frames: np.ndarray, bends: bool
) -> Iterator[Action]:
    """Yield the drive of the front shoe along x at its point, and the turn about its z axis at its frame."""
    if shoe != history.case.track.shoe_count:
        return
    zero = np.zeros_like(position)
    force = np.zeros_like(position)
    force[:, 0] = history.drive_force.values
    moment = history.drive_torque.values[:, None] * frames[:, :, 2]
    moved = Point(history.case.drive.point)
    entry: Entry = AtDriveNode()
    if moved is Point.FRONT_PINS:
        entry = AtPins(tuple(name for name, pin in PINS.items() if pin.end == "front"))
    yield Action(Kind.DRIVE, shoe, moved, history.drive_point.values, force, zero, entry)
    yield Action(Kind.DRIVE, shoe, Point.FRAME, position, zero, moment)


def _on_rolled(
    history: History, shoe: int, position: np.ndarray, frames: np.ndarray, bends: bool
) -> Iterator[Action]:
    """Yield treads of rollers, pull of the drive and tension of the chain's ends."""
    yield from treads_on(history, shoe, position, frames)
    yield from _chain(history, shoe, position, frames)


def _on_closed(
    history: History, shoe: int, position: np.ndarray, frames: np.ndarray, bends: bool
) -> Iterator[Action]:
    """Yield wheels and teeth on a rigid shoe, or every tread and lug of a flexible one."""
    if bends:
        yield from treads_on(history, shoe, position, frames)
        yield from _lugs(history, shoe, position, frames)
    else:
        yield from wheels_and_teeth(history, shoe, position)


OF_GEAR = {"dragged": _on_dragged, "rolled": _on_rolled, "closed": _on_closed, "machine": _on_closed}
"""Actions of a gear on a shoe, by the gear's kind; `bends` is True for a flexible shoe."""


def wheels_and_teeth(history: History, shoe: int, position: np.ndarray) -> Iterator[Action]:
    """Yield the wrenches of a closed track's wheels and of its tumbler on a shoe, about the shoe's COM."""
    acting = history.dataset.sel(shoe=shoe)
    wheels = acting.wheel_load.values, acting.wheel_moment.values
    teeth = acting.tooth_force.values, acting.tooth_moment.values
    yield Action(Kind.WHEEL, shoe, Point.CENTER, position, *wheels)
    yield Action(Kind.TOOTH, shoe, Point.CENTER, position, *teeth)


def _lugs(history: History, shoe: int, position: np.ndarray, frames: np.ndarray) -> Iterator[Action]:
    """Yield teeth on the lugs of a flexible shoe, which act at the adjacent bores, and their flange."""
    acting = history.dataset.sel(flexible_shoe=shoe)
    track = history.case.track
    guide = acting.lug_guide.values
    for kind, forces in ((Kind.TOOTH, acting.lug_force.values - guide), (Kind.GUIDE, guide)):
        for lug, (name, place) in enumerate(history.case.part(Closed).lugs(track)):
            force = forces[:, lug]
            center = np.array(track.joint_centers[name])
            if force.any():
                moment = np.cross(frames @ (place - center), force)
                point = position + frames @ center
                yield Action(kind, shoe, PINS[name], point, force, moment, AtInterface(name))


class Treads(NamedTuple):
    """Strips of treads on shoes, with a slot for each wheel that may be on a shoe."""

    shoe: np.ndarray  # (times, slots), number of the shoe
    wheel: np.ndarray  # (times, slots), number from 0, -1 for none
    force: np.ndarray  # (times, slots, rails, strips, 3), N, on the shoe, flange included
    foot: np.ndarray  # (times, slots, rails, strips, 3), m, point of action
    guide: np.ndarray  # (times, slots, rails, strips, 3), N, force of the flange alone


def treads(dataset: xr.Dataset) -> Treads:
    """Return the treads in the dataset of a rolled track, or of a closed one with flexible shoes."""
    # read once: a history larger than memory reads its file at each access
    if "tread_force" in dataset:
        dims = ("time", "roller", "neighbour", "rail", "strip", "axis")
        force, foot = (dataset[f"tread_{name}"].transpose(*dims).values for name in ("force", "foot"))
        # a tread presses on the shoe behind its roller's axis and on the one ahead of that
        shoe = dataset.roller_shoe.transpose("time", "roller").values[..., None] + np.arange(force.shape[2])
        wheel = np.arange(force.shape[1])[:, None]
        guide = np.broadcast_to(0.0, force.shape)
    else:
        force, foot, guide = (dataset[f"strip_{name}"].values for name in ("force", "foot", "guide"))
        shoe = dataset.flexible_shoe.values[:, None]
        wheel = dataset.strip_wheel.values - 1
    times, *slots = force.shape[:3]
    numbers = (np.broadcast_to(array, (times, *slots)).reshape(times, -1) for array in (shoe, wheel))
    return Treads(*numbers, *(array.reshape(times, -1, *array.shape[3:]) for array in (force, foot, guide)))


def treads_on(history: History, shoe: int, position: np.ndarray, frames: np.ndarray) -> Iterator[Action]:
    """Yield each strip of a tread that was ever on the shoe, and its flange.

    In a closed track the shoe must be flexible.
    """
    labels = history.case.gear.wheel_labels
    stored = "strip_force" in history.dataset  # holds flexible shoes alone
    strips = treads(history.dataset.sel(flexible_shoe=[shoe]) if stored else history.dataset)
    wheels = np.where(strips.shoe == shoe, strips.wheel, -1)
    for wheel, rail, strip in np.ndindex(len(labels), *strips.force.shape[2:4]):
        touches = (wheels == wheel) & strips.force[:, :, rail, strip].any(axis=-1)
        if not touches.any():
            continue
        pressed = np.zeros_like(position)
        sideways = np.zeros_like(position)
        point = position.copy()
        for slot in np.flatnonzero(touches.any(axis=0)):
            times = touches[:, slot]
            rows = (times, slot, rail, strip)
            sideways[times] = strips.guide[rows]
            point[times] = strips.foot[rows]
            pressed[times] = strips.force[rows] - strips.guide[rows]
        x = np.einsum("ti,ti->t", point - position, frames[:, :, 0])
        entry = OnRail(rail * strips.force.shape[3] + strip, x, wheel)
        tread = OnTread(labels[wheel], SIDES[rail])
        if pressed.any():
            kind = ON_RAILS[tread.wheel.kind]
            yield Action(kind, shoe, tread, point, pressed, np.zeros_like(position), entry)
        if sideways.any():
            flange = tread._replace(flange=True)
            yield Action(Kind.GUIDE, shoe, flange, point, sideways, np.zeros_like(position), entry)


def _chain(history: History, shoe: int, position: np.ndarray, frames: np.ndarray) -> Iterator[Action]:
    """Yield the pull of the drive at the shoe's front pins, and the chain's tension at the outermost pins."""
    track = history.case.track
    zero = np.zeros_like(position)
    tension = history.case.part(Rolled).end_tension
    pulls = {"front": -drive_pulls(history)[:, shoe - 1], "rear": zero[:, 0]}
    if shoe == track.shoe_count:
        pulls["front"] = pulls["front"] + tension
    if shoe == 1:
        pulls["rear"] = pulls["rear"] - tension
    for name, center in track.joint_centers.items():
        pin = PINS[name]
        force = zero.copy()
        force[:, 0] = 0.5 * pulls[pin.end]
        if force.any():
            point = position + frames @ center
            yield Action(Kind.CHAIN, shoe, pin, point, force, zero, AtInterface(name))


def drive_pulls(history: History) -> np.ndarray:
    """Return the backward pull of the drive at each shoe's front pins: array (times, shoes), N."""
    track = history.case.track
    frame = history.case.part(Rolled)
    first = history.position.sel(shoe=1, axis="x").values + track.pin_ahead
    tumbler = history.side_frame_position.sel(axis="x").values + frame.tumbler
    shares = frame.shares_of_links(tumbler - first, track.shoe_count - 1, track.pitch)
    return history.drive_pull.values[:, None] * np.column_stack((shares, np.zeros(len(shares))))
