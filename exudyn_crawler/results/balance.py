"""Conservation of momentum and energy, checked on the history of a run of any solver.

All vectors are global, all units SI.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from copy import copy
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from exudyn_crawler.case import Case, Rolled, statics
from exudyn_crawler.case.gear.arms import Arm
from exudyn_crawler.case.gear.base import POSTS
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.gear.running_gear import Bogie, RunningGear
from exudyn_crawler.case.parameters.base import inertia_tensor
from exudyn_crawler.case.parameters.contact import PairContact
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.case.parameters.track import FlexibleShoes
from exudyn_crawler.ground.rotations import moments_on_angles, rotation_matrices
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads import actions as acting
from exudyn_crawler.results.loads.kinds import Kind
from exudyn_crawler.results.loads.load_map import loads_by_kind, unit_loads
from exudyn_crawler.results.loads.locations import PINS, PinsOfShoe, Point

FREEDOMS = ("travel", "sway", "heave", "roll", "pitch", "yaw")
"""Names of a side frame's balances in the order of its coordinates."""
BESIDE = 0.6
"""Distance along the frame from an end wheel's axis up to which a link or shoe counts as on it, pitches."""


class _Motion:
    """Motion of the frames of shoes, arrays (times, shoes, 3), or of the side frame, (times, 3).

    `axes` (..., 3, 3) has one axis per column. `center` is the centre of mass relative to the origin.
    `inertia` (3, 3) is about `center` in the body's axes.
    """

    def __init__(
        self, history: History, prefix: str, mass: ArrayLike, center: ArrayLike, inertia: np.ndarray
    ) -> None:
        names = ("position", "velocity", "acceleration", "angular_velocity", "angular_acceleration")
        motion = (history.dataset[f"{prefix}{name}"].values for name in names)
        self.origin, self.velocity, self.acceleration, self.omega, self.alpha = motion
        self.axes = rotation_matrices(history.dataset[f"{prefix}angles"].values)
        self.center = _times(self.axes, np.asarray(center))
        self.mass = np.asarray(mass)
        self.inertia = inertia

    def momentum_rates(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the rates of momentum (N) and of angular momentum about the origin (N m): (..., 3)."""
        inertia = self.axes @ self.inertia @ np.swapaxes(self.axes, -1, -2)
        turning = np.cross(self.omega, np.cross(self.omega, self.center))
        rate = self.mass[..., None] * (self.acceleration + np.cross(self.alpha, self.center) + turning)
        spin = _times(inertia, self.alpha) + np.cross(self.omega, _times(inertia, self.omega))
        return rate, spin + np.cross(self.center, rate)

    def energies(self, gravity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return kinetic and gravitational energy of each body, the latter from z = 0: arrays (...), J."""
        omega = _times(np.swapaxes(self.axes, -1, -2), self.omega)
        velocity = self.velocity + np.cross(self.omega, self.center)
        twice = self.mass * np.sum(velocity**2, axis=-1) + np.sum(omega * (omega @ self.inertia), axis=-1)
        return 0.5 * twice, -self.mass * ((self.origin + self.center) @ gravity)

    def velocity_at(self, points: np.ndarray, shoe: int = 0) -> np.ndarray:
        """Return the velocity (times, 3) of a shoe, or of the side frame, at points (times, 3), m/s."""
        rows = (slice(None), shoe - 1) if shoe else slice(None)
        return self.velocity[rows] + np.cross(self.omega[rows], points - self.origin[rows])

    def powers(self, loads: Iterable[acting.Action]) -> Mapping[Kind, np.ndarray]:
        """Return the power (times,) of actions by kind, W; zero for kinds without an action."""
        summed: dict[Kind, np.ndarray] = defaultdict(lambda: np.zeros(len(self.omega)))
        for action in loads:
            omega = self.omega[:, action.shoe - 1] if action.shoe else self.omega
            moved = action.force * self.velocity_at(action.point, action.shoe)
            summed[action.kind] += np.sum(moved + action.moment * omega, axis=-1)
        return summed


def _shoes(history: History) -> _Motion:
    """Return the motion of the shoes; that of a flexible one is of its frame, with the mass of its mesh."""
    case = history.case
    masses = [acting.shoe_mass(case, shoe) for shoe in case.track.shoes.tolist()]
    mass = [shoe.mass for shoe in masses]
    center = [shoe.center for shoe in masses]
    return _Motion(history, "", mass, center, case.shoe.inertia_tensor)


def _side_frame(history: History) -> _Motion:
    """Return the motion of the side frame or the machine."""
    parts = history.case.gear.frame_parts
    mass = sum(part.mass for part in parts)
    center = sum(part.mass * part.com for part in parts) / mass
    inertia = np.zeros((3, 3))
    for part in parts:
        arm = part.com - center
        inertia += part.inertia + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return _Motion(history, "side_frame_", mass, center, inertia)


def _of_tracks(history: History, name: str) -> np.ndarray:
    """Return a quantity of tumblers or idlers: array (tracks, times, ...)."""
    array = history.dataset[name]
    return (
        (array if "track" in array.dims else array.expand_dims("track"))
        .transpose("track", "time", ...)
        .values
    )


def _others(history: History, frame: _Motion) -> Iterator[_Motion]:
    """Yield the motions of tumblers, of idlers that slide, of bogies and of arms in their side frame."""
    if history.case.gear.tumblers:
        yield from _of_chains(history, frame)
    yield from (swung.motion for swung in _swung(history, frame))


def _of_chains(history: History, frame: _Motion) -> Iterator[_Motion]:
    """Yield the motions of tumblers, which turn in their side frame, then of idlers that slide along it."""
    case = history.case
    time = history.time.values
    closed = case.part(Closed)
    places = _of_tracks(history, "tumbler_position")
    take_up = _of_tracks(history, "take_up")
    inertia = inertia_tensor(closed.tumbler.inertia)
    still = np.zeros_like(take_up)
    angle = closed.assembled(case).tumbler[4] + _of_tracks(history, "tumbler_angle")
    for place, *turn in zip(places, angle, _of_tracks(history, "tumbler_speed"), still, strict=True):
        yield _riding(frame, time, place, turn, closed.tumbler.mass, inertia)
    if (slide := closed.idler.slide) is not None:
        arms = closed.idler_reference(case)[:, None, :3] - closed.frame_start(case)
        arms = arms + (take_up - closed.assembled(case).take_up)[..., None] * np.eye(3)[0]
        inertia = slide.inertia_tensor(closed.idler.radius)
        for place, way in zip(_times(frame.axes, arms), take_up, strict=True):
            yield _riding(frame, time, frame.origin + place, [still[0], still[0], way], slide.mass, inertia)


class _Swung(NamedTuple):
    """Bogie or arm of a side frame, with its motion about its pivot."""

    part: Bogie | Arm
    axles: dict[int, np.ndarray]  # from its pivot in its own axes, m, by number of the wheel, from 0
    angle: np.ndarray  # (times,), about the frame's y, rad
    rate: np.ndarray  # (times,), rad/s
    motion: _Motion

    @property
    def upward(self) -> float:
        """Sense of the angle that lifts an arm's wheel: 1 behind the pivot, else -1."""
        return 1.0 if next(iter(self.axles.values()))[0] < 0.0 else -1.0


def _swung(history: History, frame: _Motion) -> Iterator[_Swung]:
    """Yield bogies, then arms, track by track."""
    case = history.case
    gear = case.part(RunningGear)
    time = history.time.values
    still = np.zeros_like(time)
    rollers = [k for k, label in enumerate(gear.wheel_labels) if label.kind == "roller"]
    of_tracks = np.reshape(rollers, (gear.tracks, -1))
    kinds = (
        ("bogie_angle", [(bogie, bogie.rollers) for bogie in gear.bogies], gear.bogie_reference(case)),
        ("arm_angle", [(arm, (arm.roller,)) for arm in gear.arms], gear.arm_reference(case)),
    )
    for name, parts, reference in kinds:
        on_tracks = [(of_track, *part) for of_track in of_tracks for part in parts]
        angles = history.dataset[name].transpose(..., "time").values if parts else ()
        pivots = reference[:, :3] - gear.frame_start(case)
        for (of_track, part, carried), angle, pivot in zip(on_tracks, angles, pivots, strict=True):
            x, z = part.pivot
            axles = {int(of_track[k - 1]): np.array((gear.rollers[k - 1] - x, 0.0, -z)) for k in carried}
            rate = _rate(angle, time)
            place = frame.origin + frame.axes @ pivot
            com = part.com[0], 0.0, part.com[1]
            inertia = inertia_tensor(part.inertia)
            motion = _riding(frame, time, place, [angle, rate, still], part.mass, inertia, com)
            yield _Swung(part, axles, angle, rate, motion)


def _sprung(history: History, frame: _Motion) -> Iterator[tuple[Arm, _Swung]]:
    """Yield the arms with their motions."""
    for swung in _swung(history, frame):
        if isinstance(swung.part, Arm):
            yield swung.part, swung


def _spring_energy(arm: Arm, swung: _Swung) -> np.ndarray:
    """Return the energy of an arm's spring and bump stop from its nominal position, J: (times,)."""
    up = swung.upward * swung.angle
    energy: np.ndarray = (arm.torque + 0.5 * arm.stiffness * up) * up
    if arm.stop is not None:
        energy = energy + 0.5 * arm.stop_stiffness * np.maximum(up - arm.stop, 0.0) ** 2
    return energy


def _riding(
    frame: _Motion,
    time: np.ndarray,
    place: np.ndarray,
    motion: list[np.ndarray],
    mass: float,
    inertia: np.ndarray,
    com: ArrayLike = (0.0, 0.0, 0.0),
) -> _Motion:
    """Return the motion of a body in a frame with its axle at a place (times, 3), m.

    `motion` holds the body's angle (rad) and speed (rad/s) about the frame's y, and its way along x (m).
    `com` (3,) is its COM from its axle in its own axes, m.
    """
    body = copy(frame)
    arm = place - frame.origin
    (angle, spin, way) = (series[:, None] for series in motion)
    ahead = frame.axes[..., 0]
    axle = frame.axes[..., 1]
    rate = _rate(way, time)
    body.velocity = frame.velocity_at(place) + rate * ahead
    swung = np.cross(frame.alpha, arm) + np.cross(
        frame.omega, np.cross(frame.omega, arm) + 2.0 * rate * ahead
    )
    body.acceleration = frame.acceleration + swung + _rate(rate, time) * ahead
    body.omega = frame.omega + spin * axle
    body.alpha = frame.alpha + _rate(spin, time) * axle + np.cross(frame.omega, spin * axle)
    body.axes = frame.axes @ rotation_matrices(angle * np.eye(3)[1])
    body.origin, body.center = place, _times(body.axes, np.asarray(com))
    body.mass = np.asarray(mass)
    body.inertia = inertia
    return body


def _rate(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Return the rate of values (times, ...) by differences; zero for a single time."""
    return np.gradient(values, time, axis=0) if len(time) > 1 else np.zeros_like(values)


def shoe_actions(history: History) -> xr.Dataset:
    """Return actions on shoes by kind: `force`, N, `moment` about the frame, N m: (source, time, shoe, axis).

    Sources are the kinds of actions in the history, in the order of `Kind`.
    """
    position = history.position.values
    loads = acting.actions(history)
    kinds = [kind for kind in Kind if kind in {action.kind for action in loads}]
    forces = np.zeros((len(kinds), *position.shape))
    moments = np.zeros_like(forces)
    for action in loads:
        source = kinds.index(action.kind)
        shoe = action.shoe - 1
        forces[source, :, shoe] += action.force
        moments[source, :, shoe] += action.moment_about(position[:, shoe])
    return _of_shoes(history, forces, moments, source=[kind.value for kind in kinds])


def shoe_momentum_rates(history: History) -> xr.Dataset:
    """Return shoes' momentum rates: `force` (N) and, about the frame, `moment` (N m), (time, shoe, axis).

    The elastic modes of a flexible shoe carry no momentum, but they carry angular momentum. The rate of this
    needs modal accelerations that a history does not keep: its moments are NaN.
    """
    rate, spin = _shoes(history).momentum_rates()
    if history.case.flexible is not None:
        spin[:, [shoe - 1 for shoe in history.case.flexible.shoes]] = np.nan
    return _of_shoes(history, rate, spin)


def _of_shoes(history: History, force: np.ndarray, moment: np.ndarray, **coords: object) -> xr.Dataset:
    dims = (*coords, "time", "shoe", "axis")
    return xr.Dataset(
        {"force": (dims, force, {"units": "N"}), "moment": (dims, moment, {"units": "N m"})},
        coords=coords | {name: history.dataset[name] for name in ("time", "shoe", "axis")},
    )


def shoe_imbalance(history: History) -> xr.Dataset:
    """Return each shoe's `shoe_momentum_rates` less all actions: zero if the mechanics holds."""
    with xr.set_options(keep_attrs=True):
        return shoe_momentum_rates(history) - shoe_actions(history).sum("source")


def track_imbalance(history: History, about: ArrayLike = (0.0, 0.0, 0.0)) -> xr.Dataset:
    """Return the whole track's momentum rate less the external actions: zero if the mechanics holds.

    The links are internal and left out. The result has `force` (N) and `moment` (N m), both (time, axis),
    about a fixed point (3,) in m. With flexible shoes the moment is NaN, see `shoe_momentum_rates`.
    """
    with xr.set_options(keep_attrs=True):
        outside = shoe_actions(history).drop_sel(source=Kind.JOINT.value).sum("source")
        one_by_one = shoe_momentum_rates(history) - outside
        arm = history.position.values - np.asarray(about, dtype=float)
        one_by_one["moment"] += np.cross(arm, one_by_one["force"].values)
        return one_by_one.sum("shoe", skipna=False)


def frame_imbalance(history: History) -> xr.Dataset:
    """Return the rate of the side frame's momentum less all actions on it: zero if the mechanics holds.

    `travel` and `heave` (N) are along x and z. `roll` and `pitch` (N m) are about the axes of these angles
    and the frame's origin. Each is (time,). Held coordinates y and yaw are left out; a machine on two tracks
    has `sway` and `yaw` for them. The frame includes its bogies and arms, and in a closed track its tumblers
    and the idlers that slide; forces between these are internal. Raises `ValueError` if there is no side
    frame, or posts hold it.
    """
    case = history.case
    frame = _side_frame(history)
    force, moment = frame.momentum_rates()
    for body in _others(history, frame):
        rate, spin = body.momentum_rates()
        weight = body.mass * case.gravity_vector()
        spin = spin - np.cross(body.center, weight)
        rate = rate - weight
        force = force + rate
        moment = moment + spin + np.cross(body.origin - frame.origin, rate)
    for action in frame_actions(history):
        force = force - action.force
        moment = moment - action.moment_about(frame.origin)
    angles = moments_on_angles(history.side_frame_angles.values, moment)
    forces = _over_time(history, "N", travel=force[:, 0], sway=force[:, 1], heave=force[:, 2])
    turned = _over_time(history, "N m", roll=angles[:, 0], pitch=angles[:, 1], yaw=angles[:, 2])
    imbalance = forces.assign(turned)
    return imbalance.drop_vars([FREEDOMS[held] for held in case.gear.holds])


def tumbler_imbalance(history: History) -> np.ndarray:
    """Return the rate of tumblers' spin less drive and teeth, (tracks, times), N m; zero as above."""
    data = history.dataset
    frame = _side_frame(history)
    left = []
    torques = _of_tracks(history, "drive_moment")
    shoes = np.split(np.arange(data.sizes["shoe"]), len(torques))
    for body, torque, shoe in zip(_others(history, frame), torques, shoes, strict=False):
        arm = data.position.values[:, shoe] - body.origin[:, None]
        moment = data.tooth_moment.values[:, shoe] + np.cross(arm, data.tooth_force.values[:, shoe])
        spin = body.momentum_rates()[1] + moment.sum(axis=1)
        left.append(np.sum(spin * frame.axes[..., 1], axis=-1) - torque)
    return np.array(left)


def energies(history: History) -> xr.Dataset:
    """Return the stored energy of track and terrain over time, J: kinetic, gravitational and of the springs.

    Each is (time,). Heights of the shoes' COMs count from the origin, those of the units from free springs.
    On cells there are no springs: the energy that the ground stores and gives back is part of `powers`. Under
    a side frame there are also `frame_kinetic`, `frame_gravitational` (heights from z = 0) and `treads`, the
    energy in their contacts with rails. The frame's energies include bogies and arms, and in a closed track
    tumblers and idlers. `teeth` is the energy in their contacts, `tensioners` that in the springs of idlers,
    `arm_springs` that in the springs of arms, from their nominal position, `elastic` that of the modes of
    flexible shoes, `pin_springs` that of rubber bushes between rigid shoes, or of pins with play in their
    bores. Raises `ValueError` for flexible shoes of an open track, or on cells.
    """
    case = history.case
    if case.flexible is not None:
        _refuse_lacking(case)
    gravity = history.case.gravity_vector()
    kinetic, height = (energy.sum(axis=1) for energy in _shoes(history).energies(gravity))
    stored = {"kinetic": kinetic, "gravitational": height}
    if case.contact.model != "cells":
        terrain = case.part(Terrain)
        heave = history.unit_heave.values
        tilt = history.unit_tilt.values
        kinetic += 0.5 * terrain.unit_mass * np.sum(history.unit_heave_rate.values**2, axis=1)
        tilting = terrain.unit_inertia[terrain.tilt_axis]
        kinetic += 0.5 * tilting * np.sum(history.unit_tilt_rate.values**2, axis=1)
        height -= terrain.unit_mass * heave.sum(axis=1) * gravity[2]
        springs = 0.5 * terrain.heave_stiffness * np.sum(heave**2, axis=1)
        stored["springs"] = springs + 0.5 * terrain.tilt_stiffness * np.sum(tilt**2, axis=1)
    if case.gear.frame_parts:
        side = _side_frame(history)
        by_body = [motion.energies(gravity) for motion in (side, *_others(history, side))]
        stored["frame_kinetic"], stored["frame_gravitational"] = (
            sum(of_kind) for of_kind in zip(*by_body, strict=True)
        )
        if case.part(RunningGear).arms:
            sprung = _sprung(history, side)
            stored["arm_springs"] = np.sum([_spring_energy(arm, swung) for arm, swung in sprung], axis=0)
    if history.has("tread_force"):
        stored["treads"], _, _ = _treads(history, case.part(Rolled), side, _shoes(history))
    if history.has("wheel_energy"):
        stored["treads"] = history.wheel_energy.values
        stored["teeth"] = history.tooth_energy.values
        if (spring := case.part(Closed).idler.tensioner) is not None:
            push = spring.preload - spring.stiffness * _of_tracks(history, "take_up")
            stored["tensioners"] = 0.5 * np.sum(push**2, axis=0) / spring.stiffness
        elif (recoil := case.part(Closed).idler.recoil) is not None:
            back = case.part(Closed).assembled(case).take_up - _of_tracks(history, "take_up")
            stored["tensioners"] = np.sum(recoil.preload * back + 0.5 * recoil.stiffness * back**2, axis=0)
    if _pins_store_energy(case):
        stored["pin_springs"] = _pin_energy(history)
    if case.flexible is not None:
        squares = (history.modal_coordinate.values * 2.0 * np.pi * history.frequency.values) ** 2
        stored["elastic"] = 0.5 * squares.sum(axis=(1, 2))
        stored["kinetic"] += 0.5 * np.sum(history.modal_velocity.values**2, axis=(1, 2))
    return _over_time(history, "J", **stored)


def powers(history: History) -> xr.Dataset:
    """Return the powers of everything without a stored energy in `energies`, W, each (time,).

    `drive` and `machine_load` supply power. `elastic_contact` goes into the contact's stiffness and comes
    back from it. `friction` (with the friction torque), `contact_damping` and `terrain_damping` take power.
    On cells `pressure` and `shear` are the power that the ground takes; it gives some of it back. `pressure`
    is the power of the normal tractions' resultant (on a plane, of all normal tractions), `shear` is the
    rest. Under a side frame the drive pulls on frame and chain. The machine's load is that on the frame with
    the tension of the chain's ends, and `rolling_resistance` and `tread_damping` take power, too. In a closed
    track the drive is the torque on the tumblers. `wheel_losses` and `tooth_losses` are the power that wheels
    and teeth take and do not store: by resistance, damping and flanges. `drawbar` is the power that a drawbar
    takes from the frame. `modal_damping`, `tensioner_damping`, `arm_damping` and `pin_losses`
    (friction of pins, what rubber bushes lose, and damping of play) take power if they exist. Raises
    `ValueError` as in `energies`, or for contact by spheres: its history does not have the power of each
    contact.
    """
    case = history.case
    _refuse_lacking(case)
    shoes = _shoes(history)
    supplied = shoes.powers(acting.actions(history))
    named = {"drive": supplied[Kind.DRIVE], "machine_load": supplied[Kind.LOAD]}
    if case.contact.model == "cells":
        pressed = np.linalg.norm(history.normal_force.values, axis=-1) * history.penetration_rate.values
        named["pressure"] = pressed.sum(axis=1)
        named["shear"] = -supplied[Kind.CONTACT] - named["pressure"]
    else:
        named |= _unit_powers(history, shoes)
    if history.has("tread_force"):
        named |= _rolled_powers(history, case.part(Rolled), shoes, supplied[Kind.CHAIN])
    if history.has("wheel_energy"):
        named |= _closed_powers(history, shoes)
    if not case.track.pin.is_ideal or case.gear.pin_play is not None:
        named["pin_losses"] = _pin_losses(history, supplied[Kind.JOINT])
    if case.gear.frame_parts and case.part(RunningGear).arms:
        sprung = _sprung(history, _side_frame(history))
        named["arm_damping"] = np.sum([arm.damping * swung.rate**2 for arm, swung in sprung], axis=0)
    return _over_time(history, "W", **named)


def _pins_store_energy(case: Case) -> bool:
    """Return True if pins store energy, in rubber bushes or in contacts with their bores."""
    return case.track.pin.kind == "rubber" or case.gear.pin_play is not None


def _pin_energy(history: History) -> np.ndarray:
    """Return the energy of the twisted bushes of all pins, or of their contacts with play, J: (times,)."""
    case = history.case
    if case.gear.pin_play is not None:
        pressed: np.ndarray = history.play_energy.values
        return pressed
    law = case.track.pin.law(case.track.pitch)
    rear, front = np.moveaxis(
        rotation_matrices(history.angles.values)[:, case.gear.links(case.track) - 1], 2, 0
    )
    ahead = front[..., 0]
    angle = np.arctan2(-np.sum(ahead * rear[..., 2], axis=-1), np.sum(ahead * rear[..., 0], axis=-1))
    energy: np.ndarray = 0.5 * law.stiffness * np.sum((angle - law.unloaded) ** 2, axis=1)
    return energy


def _pin_losses(history: History, on_frames: np.ndarray) -> np.ndarray:
    """Return the power (times,) that the pins take and do not store, W.

    `on_frames` is the power of their forces and moments on the frames of all shoes, W; flexible shoes are
    bent besides.
    """
    taken = -on_frames
    if history.case.flexible is not None:
        units = unit_loads(history.case)
        for shoe in history.case.flexible.shoes:
            velocity = history.modal_velocity.sel(flexible_shoe=shoe).values
            loads = loads_by_kind(history, shoe)[Kind.JOINT]
            taken = taken - np.sum(loads @ units.work @ units.integrated.inside * velocity, axis=1)
    if _pins_store_energy(history.case):
        taken = taken - np.gradient(_pin_energy(history), history.time.values)
    return taken


def _unit_powers(history: History, shoes: _Motion) -> dict[str, np.ndarray]:
    """Return the powers (times,) that units and the contact with them take."""
    terrain = history.case.part(Terrain)
    law = history.case.part(PairContact)
    depth = history.penetration.values
    rate = history.penetration_rate.values
    normal = np.linalg.norm(history.normal_force.values, axis=-1)
    elastic = law.stiffness * np.maximum(depth, 0.0) ** law.exponent
    part = np.clip(depth / law.damping_depth, 0.0, 1.0)
    damping = law.damping * rate * part**2 * (3.0 - 2.0 * part)
    total = elastic + damping
    share = np.divide(elastic, total, out=np.zeros_like(elastic), where=total > 0.0)
    pressed = normal * rate
    units = history.contact_unit.values - 1
    spin = shoes.omega[:, history.contact_shoe.values - 1].copy()
    spin[..., terrain.tilt_axis] -= history.unit_tilt_rate.values[:, units]
    rubbed = history.friction_force.values * history.slip_velocity.values
    rubbed = rubbed + history.friction_torque.values * spin
    absorbed = terrain.heave_stiffness * np.sum(history.unit_heave_rate.values**2, axis=1)
    absorbed += terrain.tilt_stiffness * np.sum(history.unit_tilt_rate.values**2, axis=1)
    return {
        "elastic_contact": np.sum(share * pressed, axis=1),
        "contact_damping": np.sum((1.0 - share) * pressed, axis=1),
        "friction": -rubbed.sum(axis=(1, 2)),
        "terrain_damping": terrain.damping_time * absorbed,
    }


def _rolled_powers(
    history: History, frame: Rolled, shoes: _Motion, chain: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the powers (times,) at a side frame over rigid shoes; `chain` is the power on their pins."""
    motion = _side_frame(history)
    on_frame = motion.powers(frame_actions(history))
    last = history.case.track.shoe_count
    pins = middle_pins
    front = shoes.velocity_at(pins(history, "front")[:, -1], last)
    tension = frame.end_tension * (front - shoes.velocity_at(pins(history, "rear")[:, 0], 1))[:, 0]
    _, resisted, damped = _treads(history, frame, motion, shoes)
    return {
        "drive": on_frame[Kind.PULL] + chain - tension,
        "machine_load": on_frame[Kind.MACHINE] + tension,
        "rolling_resistance": resisted,
        "tread_damping": damped,
    }


class _GearPowers(NamedTuple):
    """Powers that wheels and teeth of closed tracks take, stored energy included, by shoe, W."""

    wheel: np.ndarray  # (times, shoes)
    tooth: np.ndarray  # (times, shoes)
    carried: dict[str, np.ndarray]  # (times,), by kind of wheel: given back where wheels move in the frame
    modal_damping: np.ndarray | None  # (times,), of flexible shoes


def _gear_powers(history: History, shoes: _Motion, frame: _Motion) -> _GearPowers:
    data = history.dataset
    case = history.case
    tumblers = list(_of_chains(history, frame))
    count = case.gear.loop(case.track).shoe_count
    taken = {}
    wheels = ([frame] * len(tumblers), "wheel_load")
    teeth = (tumblers, "tooth_force")
    for kind, (carriers, stored) in ((Kind.WHEEL, wheels), (Kind.TOOTH, teeth)):
        force = data[stored].values
        moment = data[f"{kind}_moment"].values
        taken[kind.value] = power = np.zeros(force.shape[:2])
        for shoe in range(data.sizes["shoe"]):
            gear = carriers[shoe // count]
            slip = shoes.velocity[:, shoe] - gear.velocity_at(shoes.origin[:, shoe])
            spin = shoes.omega[:, shoe] - gear.omega
            power[:, shoe] = -np.sum(force[:, shoe] * slip + moment[:, shoe] * spin, axis=-1)
    damped = None if case.flexible is None else _modal_powers(history, taken)
    carried = {}
    if case.part(Closed).idler.slide is not None:
        rate = _rate(_of_tracks(history, "take_up").T, history.time.values)
        idlers = [label.kind == "idler" for label in case.gear.wheel_labels]
        pushed = data.wheel_force.values[:, idlers] @ frame.axes[..., :1]
        carried["idler"] = np.sum(pushed[..., 0] * rate, axis=1)
    for swung in _swung(history, frame):
        for wheel, axle in swung.axles.items():
            moment = _moment_on(history, shoes, swung.motion, wheel, axle)
            turned = np.sum(moment * frame.axes[..., 1], axis=1) * swung.rate
            carried["roller"] = carried.get("roller", 0.0) + turned
    return _GearPowers(taken[Kind.WHEEL.value], taken[Kind.TOOTH.value], carried, damped)


def wheel_powers(history: History) -> xr.Dataset:
    """Return the powers (W, each (time,)) that wheels of closed tracks take: `roller`, `idler`, `upper_run`.

    The upper run lies on carriers, slides or road wheels. The energy stored in the contacts is included:
    together they are `wheel_losses` of `powers` and the rate of `treads` of `energies`. A shoe's wheel is the
    one of its place: the idler beyond the idler's axis less `BESIDE` pitches, else that of its run.
    """
    case = history.case
    closed = case.part(Closed)
    shoes, frame = _shoes(history), _side_frame(history)
    found = _gear_powers(history, shoes, frame)
    from_frame = np.einsum("tsa,tab->tsb", shoes.origin - frame.origin[:, None], frame.axes)
    front, high = closed.idler.place
    take_up = _of_tracks(history, "take_up").T
    ahead = np.repeat(take_up, case.track.shoe_count // len(take_up.T), axis=1) + front
    on_idler = from_frame[..., 0] > ahead - BESIDE * case.track.pitch
    above = ~on_idler & (from_frame[..., 2] > 0.5 * (closed.tumbler.place[1] + high))
    places = {"roller": ~on_idler & ~above, "idler": on_idler, "upper_run": above}
    by_kind = {
        name: np.where(place, found.wheel, 0.0).sum(axis=1) - found.carried.get(name, 0.0)
        for name, place in places.items()
    }
    return _over_time(history, "W", **by_kind)


def _closed_powers(history: History, shoes: _Motion) -> dict[str, np.ndarray]:
    """Return the powers (times,) at the gear of closed tracks."""
    data = history.dataset
    time = history.time.values
    case = history.case
    frame = _side_frame(history)
    found = _gear_powers(history, shoes, frame)
    taken = {
        "wheel_losses": found.wheel.sum(axis=1)
        - sum(found.carried.values())
        - np.gradient(data.wheel_energy.values, time),
        "tooth_losses": found.tooth.sum(axis=1) - np.gradient(data.tooth_energy.values, time),
    }
    if found.modal_damping is not None:
        taken["modal_damping"] = found.modal_damping
    if (slide := case.part(Closed).idler.slide) is not None:
        rate = _rate(_of_tracks(history, "take_up").T, time)
        taken["tensioner_damping"] = slide.stiffness * slide.relaxation * np.sum(rate**2, axis=1)
    if history.has("drawbar_pull"):
        taken["drawbar"] = -frame.powers([_drawbar(history)])[Kind.PULL]
    drive = np.sum(_of_tracks(history, "drive_moment") * _of_tracks(history, "tumbler_speed"), axis=0)
    force, moment = statics.machine_wrench(case, time)
    machine = np.sum(force * frame.velocity + moment * frame.omega, axis=-1)
    return {"drive": drive, "machine_load": machine} | taken


def _moment_on(
    history: History, shoes: _Motion, carrier: _Motion, wheel: int, axle: np.ndarray
) -> np.ndarray:
    """Return the moment of a roller's force about the origin of its carrier, (times, 3), N m.

    The resistance acts at the rail of the shoe whose COM is nearest to the axle (3,), m in the carrier.
    """
    gear = history.case.part(Closed)
    count = gear.loop(history.case.track).shoe_count
    first = count * (wheel // (len(gear.wheel_labels) // gear.tracks))
    force = history.wheel_force.values[:, wheel]
    arm = _times(carrier.axes, axle)
    apart = shoes.origin[:, first : first + count] - (carrier.origin + arm)[:, None]
    nearest = first + np.argmin(np.sum(apart**2, axis=-1), axis=1)
    when = np.arange(len(nearest))
    rail = shoes.axes[when, nearest]
    foot = carrier.origin + arm - gear.roller_radius * rail[..., 2]
    spin = np.cross(shoes.omega[when, nearest], foot - shoes.origin[when, nearest])
    slip = carrier.velocity_at(foot) - shoes.velocity[when, nearest] - spin
    speed = np.sum(slip * rail[..., 0], axis=1)
    drag = gear.rolling_resistance * speed / np.hypot(speed, gear.resistance_speed)
    resisted = gear.roller_radius * np.linalg.norm(force, axis=1) * drag / np.hypot(1.0, drag)
    moment: np.ndarray = np.cross(arm, force) + resisted[:, None] * rail[..., 1]
    return moment


def _modal_powers(history: History, taken: dict[str, np.ndarray]) -> np.ndarray:
    """Return the power of modal damping (times,), W; subtract bending from what wheels and teeth take.

    `taken` has the powers of each shoe by kind of gear: (times, shoes).
    """
    flexible = history.case.part(FlexibleShoes)
    units = unit_loads(history.case)
    rates = 4.0 * np.pi * history.frequency.values * flexible.damping.value(history.frequency.values)
    for shoe in flexible.shoes:
        velocity = history.modal_velocity.sel(flexible_shoe=shoe).values
        for kind, loads in loads_by_kind(history, shoe).items():
            if kind.gear is not None:
                on_modes = loads @ units.work @ units.integrated.inside
                taken[kind.gear][:, shoe - 1] -= np.sum(on_modes * velocity, axis=1)
    damped: np.ndarray = np.sum(rates * history.modal_velocity.values**2, axis=(1, 2))
    return damped


def _treads(
    history: History, frame: Rolled, motion: _Motion, shoes: _Motion
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the energy in the treads, J, and the powers of resistance and damping, W: arrays (times,)."""
    energy, resisted, damped = np.zeros((3, history.time.size))
    carriers = {k: (motion, np.array((x, 0.0, 0.0))) for k, x in enumerate(frame.rollers)}
    carriers |= {k: (one.motion, axle) for one in _swung(history, motion) for k, axle in one.axles.items()}
    rails = history.case.shoe.rails
    middles = () if rails is None else rails.middles
    stiffness = frame.stiffness / frame.strips
    power = frame.exponent + 1.0
    on_rails = (
        (load, load.entry) for load in acting.actions(history) if isinstance(load.entry, acting.OnRail)
    )
    for action, entry in on_rails:
        rail, strip = divmod(entry.line, frame.strips)
        carrier, axle = carriers[entry.roller]
        place = np.array((0.0, middles[rail] + frame.strip_places[strip], 0.0)) + axle
        away = carrier.origin + carrier.axes @ place - action.point
        distance = np.linalg.norm(away, axis=1, keepdims=True)
        normal = away / distance
        force = -action.force
        depth = np.where(force.any(axis=1), frame.radius - distance[:, 0], 0.0).clip(0.0)
        slip = carrier.velocity_at(action.point) - shoes.velocity_at(action.point, action.shoe)
        pressed = np.sum(force * normal, axis=1)
        rate = -np.sum(normal * slip, axis=1)
        energy += stiffness / power * depth**power
        damped += (pressed - stiffness * depth**frame.exponent) * rate
        resisted -= np.sum(force * slip, axis=1) + pressed * rate
    return energy, resisted, damped


def energy_balance(history: History) -> xr.Dataset:
    """Return the energy balance from the start to every time, J, each (time,).

    It has the changes of `energies`, the works of `powers` (by the trapezoidal rule over the stored states)
    and `imbalance`: the work of the drive and of the machine's forces less everything else.
    """
    stored = energies(history)
    change = stored - stored.isel(time=0)
    work = powers(history).cumulative_integrate("time")
    supplied = work["drive"] + work["machine_load"]
    taken = sum(power for name, power in work.data_vars.items() if name not in ("drive", "machine_load"))
    balance = xr.merge((change, work)).assign(imbalance=supplied - taken - sum(change.data_vars.values()))
    for values in balance.data_vars.values():
        values.attrs = {"units": "J"}
    return balance


def middle_pins(history: History, end: str) -> np.ndarray:
    """Return the middle of the pins at an end, "front" or "rear", of each shoe: (times, shoes, 3), m."""
    centers = history.case.track.joint_centers
    place = np.mean([center for name, center in centers.items() if PINS[name].end == end], axis=0)
    return history.position.values + rotation_matrices(history.angles.values) @ place


def frame_actions(history: History) -> Iterator[acting.Action]:
    """Yield the actions on a history's side frame without those that hold y and yaw.

    In closed tracks these include actions on tumblers and on idlers that slide, without the weight of these.
    Raises `ValueError` without a side frame, or if posts hold it.
    """
    case = history.case
    if not case.gear.frame_parts or case.gear.holds == POSTS:
        raise ValueError(f"{case.name!r} must have a side frame that no posts hold")
    origin = history.side_frame_position.values
    turn = rotation_matrices(history.side_frame_angles.values)
    zero = np.zeros_like(origin)
    for part in case.gear.frame_parts:
        weight = zero + part.mass * case.gravity_vector()
        center = origin + turn @ part.com
        yield acting.Action(Kind.WEIGHT, 0, Point.CENTER, center, weight, zero)
    wrench = statics.machine_wrench(case, history.time.values)
    yield acting.Action(Kind.MACHINE, 0, Point.ORIGIN, origin, *wrench)
    if history.has("drawbar_pull"):
        yield _drawbar(history)
    if history.has("wheel_load"):
        for shoe in case.track.shoes.tolist():
            for action in acting.wheels_and_teeth(history, shoe, history.position.sel(shoe=shoe).values):
                yield replace(action, shoe=0, force=-action.force, moment=-action.moment)
        return
    pulls = acting.drive_pulls(history)
    pins = middle_pins(history, "front")
    for shoe in case.track.shoes.tolist():
        for action in acting.treads_on(history, shoe, *acting.shoe_frames(history, shoe)):
            yield replace(action, shoe=0, force=-action.force)
        pull = pulls[:, shoe - 1, None] * np.array((1.0, 0.0, 0.0))
        yield acting.Action(Kind.PULL, 0, PinsOfShoe(shoe), pins[:, shoe - 1], pull, zero)


def _drawbar(history: History) -> acting.Action:
    """Return the pull of a drawbar on the side frame."""
    case = history.case
    height = case.drive.drawbar_height - case.part(Closed).frame_start(case)[2]
    origin = history.side_frame_position.values
    point = origin + rotation_matrices(history.side_frame_angles.values) @ np.array((0.0, 0.0, height))
    zero = np.zeros_like(origin)
    force = zero.copy()
    force[:, 0] = -history.drawbar_pull.values
    return acting.Action(Kind.PULL, 0, Point.DRAWBAR, point, force, zero)


def lacking(case: Case) -> str | None:
    """Return what the history of a case lacks for its powers; None if it has all."""
    if case.flexible is not None and (case.contact.model == "cells" or not case.gear.loops):
        return "rigid shoes, since its history leaves out the work of the ground or of pins on their modes"
    if case.flexible is not None and case.track.pin.kind == "rubber":
        return "rigid shoes between rubber bushes, since their modes twist the bushes, too"
    if case.contact.model not in ("pair", "cells"):
        return "contact.model 'pair' or 'cells', whose contacts have a power"
    return None


def _refuse_lacking(case: Case) -> None:
    if (what := lacking(case)) is not None:
        raise ValueError(f"the energy of {case.name!r} needs {what}")


def _times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return matrices (..., 3, 3) times vectors (..., 3)."""
    return (matrices @ vectors[..., None])[..., 0]


def _over_time(history: History, unit: str, **values: np.ndarray) -> xr.Dataset:
    return xr.Dataset(
        {name: ("time", value, {"units": unit}) for name, value in values.items()},
        coords={"time": history.time},
    )
