"""Conservation of momentum and energy, checked on the history of a run, whatever solved it.

All vectors are global, all units SI.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from exudyn_crawler.case import Undercarriage
from exudyn_crawler.case.parameters.base import inertia_tensor
from exudyn_crawler.ground.rotations import moments_on_angles, rotation_matrices
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads import actions as acting

KINDS = ("weight", "load", "contact", "drive", "joint")
ROLLED_KINDS = (*KINDS, "roller", "chain")
CLOSED_KINDS = ("weight", "load", "contact", "joint", "wheel", "tooth", "roller", "idler", "carrier", "guide")
"""Kinds of actions on shoes, in the order in which they are added; under a side frame; in a closed track."""


class _Motion:
    """Motion of the frames of shoes, arrays (times, shoes, 3), or of the side frame, (times, 3).

    `axes` (..., 3, 3) has an axis a column, `center` is that of mass from the origin, about which `inertia`
    (3, 3) is, in the body's axes.
    """

    def __init__(
        self, history: History, prefix: str, mass: ArrayLike, center: ArrayLike, inertia: np.ndarray
    ) -> None:
        names = ("position", "velocity", "acceleration", "angular_velocity", "angular_acceleration")
        motion = (history.dataset[f"{prefix}{name}"].values for name in names)
        self.origin, self.velocity, self.acceleration, self.omega, self.alpha = motion
        self.axes = rotation_matrices(history.dataset[f"{prefix}angles"].values)
        self.center = _times(self.axes, np.asarray(center))
        self.mass, self.inertia = np.asarray(mass), inertia

    def momentum_rates(self) -> tuple[np.ndarray, np.ndarray]:
        """Rates of momentum (N) and of angular momentum about the origin (N m): arrays (..., 3)."""
        inertia = self.axes @ self.inertia @ np.swapaxes(self.axes, -1, -2)
        turning = np.cross(self.omega, np.cross(self.omega, self.center))
        rate = self.mass[..., None] * (self.acceleration + np.cross(self.alpha, self.center) + turning)
        spin = _times(inertia, self.alpha) + np.cross(self.omega, _times(inertia, self.omega))
        return rate, spin + np.cross(self.center, rate)

    def energies(self, gravity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Kinetic energy of each body and that of gravity from z = 0 on: arrays (...), J."""
        omega = _times(np.swapaxes(self.axes, -1, -2), self.omega)
        velocity = self.velocity + np.cross(self.omega, self.center)
        twice = self.mass * np.sum(velocity**2, axis=-1) + np.sum(omega * (omega @ self.inertia), axis=-1)
        return 0.5 * twice, -self.mass * ((self.origin + self.center) @ gravity)

    def velocity_at(self, points: np.ndarray, shoe: int = 0) -> np.ndarray:
        """Velocity (times, 3) of a shoe, or of the side frame, at points (times, 3), m/s."""
        at = (slice(None), shoe - 1) if shoe else slice(None)
        return self.velocity[at] + np.cross(self.omega[at], points - self.origin[at])

    def powers(self, loads: Iterable[acting.Action]) -> Mapping[str, np.ndarray]:
        """Power (times,) of actions by their kind, W; zero of others."""
        summed: dict[str, np.ndarray] = defaultdict(lambda: np.zeros(len(self.omega)))
        for one in loads:
            omega = self.omega[:, one.shoe - 1] if one.shoe else self.omega
            moved = one.force * self.velocity_at(one.point, one.shoe)
            summed[one.kind] += np.sum(moved + one.moment * omega, axis=-1)
        return summed


def _shoes(history: History) -> _Motion:
    """Motion of the shoes; of a flexible one that of its frame, with the mass of its mesh."""
    case = history.case
    masses = [acting.shoe_mass(case, shoe) for shoe in case.track.shoes.tolist()]
    mass, center = [one.mass for one in masses], [one.center for one in masses]
    return _Motion(history, "", mass, center, case.shoe.inertia_tensor)


def _side_frame(history: History, frame: Undercarriage) -> _Motion:
    return _Motion(history, "side_frame_", frame.mass, frame.com, frame.inertia_tensor)


def shoe_actions(history: History) -> xr.Dataset:
    """What acts on shoes by kind: `force`, N, `moment` about the frame, N m, (source, time, shoe, axis)."""
    position = history.position.values
    case = history.case
    kinds = CLOSED_KINDS if case.is_closed else ROLLED_KINDS if case.is_rolled else KINDS
    forces = np.zeros((len(kinds), *position.shape))
    moments = np.zeros_like(forces)
    for action in acting.actions(history):
        source, shoe = kinds.index(action.kind), action.shoe - 1
        forces[source, :, shoe] += action.force
        moments[source, :, shoe] += action.moment_about(position[:, shoe])
    return _of_shoes(history, forces, moments, source=list(kinds))


def shoe_momentum_rates(history: History) -> xr.Dataset:
    """Rates of every shoe's momentum: `force` (N) and, about its frame, `moment` (N m), (time, shoe, axis).

    The elastic modes of a flexible shoe carry no momentum. They do carry angular momentum, whose rate takes
    accelerations of modes that a history does not keep: its moments are NaN.
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
    """Rate as of `shoe_momentum_rates` less all that acts, of every shoe: zero where mechanics holds."""
    with xr.set_options(keep_attrs=True):
        return shoe_momentum_rates(history) - shoe_actions(history).sum("source")


def track_imbalance(history: History, about: ArrayLike = (0.0, 0.0, 0.0)) -> xr.Dataset:
    """Momentum's rate less what acts from outside, of the track as a whole: zero where mechanics holds.

    The links are internal and left out. `force` (N) and `moment` about a fixed point (3,) in m (N m), both
    (time, axis); with flexible shoes the moment is NaN, see `shoe_momentum_rates`.
    """
    with xr.set_options(keep_attrs=True):
        outside = shoe_actions(history).drop_sel(source="joint").sum("source")
        one_by_one = shoe_momentum_rates(history) - outside
        arm = history.position.values - np.asarray(about, dtype=float)
        one_by_one["moment"] += np.cross(arm, one_by_one["force"].values)
        return one_by_one.sum("shoe", skipna=False)


def frame_imbalance(history: History) -> xr.Dataset:
    """Rate of the side frame's momentum less all that acts on it: zero where mechanics holds.

    `travel` and `heave` (N) along x and z, `roll` and `pitch` (N m) about the axes of these angles and the
    frame's origin, each (time,); what holds y and yaw is left out. ValueError if there is no side frame.
    """
    motion = _side_frame(history, acting.frame_of(history))
    force, moment = motion.momentum_rates()
    for action in acting.frame_actions(history):
        force, moment = force - action.force, moment - action.moment_about(motion.origin)
    angles = moments_on_angles(history.side_frame_angles.values, moment)
    forces = _over_time(history, "N", travel=force[:, 0], heave=force[:, 2])
    return forces.assign(_over_time(history, "N m", roll=angles[:, 0], pitch=angles[:, 1]))


def energies(history: History) -> xr.Dataset:
    """Stored energy of track and terrain over time, J: kinetic, gravitational and of the springs.

    Each (time,). Heights count from the origin of the COMs of shoes and from free springs of the units.
    Under a side frame also `frame_kinetic`; `frame_gravitational`, heights from z = 0; and `treads`, stored
    in their contacts with rails. In a closed track the frame's are with those of the tumbler, and `teeth` is
    what their contacts store. ValueError for a history with flexible shoes.
    """
    _only_rigid(history)
    case, terrain, frame = history.case, history.case.unit_terrain(), history.case.undercarriage
    gravity = case.gravity_vector()
    kinetic, height = (one.sum(axis=1) for one in _shoes(history).energies(gravity))
    heave, tilt = history.unit_heave.values, history.unit_tilt.values
    kinetic += 0.5 * terrain.unit_mass * np.sum(history.unit_heave_rate.values**2, axis=1)
    tilting = terrain.unit_inertia[terrain.tilt_axis]
    kinetic += 0.5 * tilting * np.sum(history.unit_tilt_rate.values**2, axis=1)
    height -= terrain.unit_mass * heave.sum(axis=1) * gravity[2]
    springs = 0.5 * terrain.heave_stiffness * np.sum(heave**2, axis=1)
    springs += 0.5 * terrain.tilt_stiffness * np.sum(tilt**2, axis=1)
    stored = {"kinetic": kinetic, "gravitational": height, "springs": springs}
    if case.is_closed:
        both = [motion.energies(gravity) for motion in (_closed_frame(history), _tumbler(history))]
        stored["frame_kinetic"], stored["frame_gravitational"] = (sum(one) for one in zip(*both, strict=True))
        stored["treads"], stored["teeth"] = history.wheel_energy.values, history.tooth_energy.values
    if frame is not None:
        motion = _side_frame(history, frame)
        stored["frame_kinetic"], stored["frame_gravitational"] = motion.energies(gravity)
        stored["treads"], _, _ = _treads(history, frame, motion, _shoes(history))
    return _over_time(history, "J", **stored)


def powers(history: History) -> xr.Dataset:
    """Power of all that stores no energy of its own in `energies`, W, each (time,).

    `drive` and `machine_load` bring power in; `elastic_contact` goes into the contact's stiffness and comes
    back from it; `friction` (with the friction torque), `contact_damping` and `terrain_damping` take power.
    Under a side frame the drive pulls on frame and chain, the machine's load is that on the frame with the
    tension of the chain's ends, and `rolling_resistance` and `tread_damping` take power, too. In a closed
    track the drive is its torque on the tumbler, and `wheel_losses` and `tooth_losses` are what these take
    and do not store: by resistance, damping and flanges. ValueError for a history of contact by spheres, of
    which a row does not say what each takes, or one with flexible shoes.
    """
    _only_rigid(history)
    case, terrain, law = history.case, history.case.unit_terrain(), history.case.contact
    if law.model != "pair":
        raise ValueError("powers need a history of contact.model 'pair', whose law they divide")
    shoes = _shoes(history)
    supplied = shoes.powers(acting.actions(history))
    depth, rate = history.penetration.values, history.penetration_rate.values
    normal = np.linalg.norm(history.normal_force.values, axis=-1)
    elastic = law.stiffness * np.maximum(depth, 0.0) ** law.exponent
    part = np.clip(depth / law.damping_depth, 0.0, 1.0)
    damping = law.damping * rate * part**2 * (3.0 - 2.0 * part)
    both = elastic + damping
    share = np.divide(elastic, both, out=np.zeros_like(elastic), where=both > 0.0)
    pressed = normal * rate
    units = history.contact_unit.values - 1
    spin = shoes.omega[:, history.contact_shoe.values - 1].copy()
    spin[..., terrain.tilt_axis] -= history.unit_tilt_rate.values[:, units]
    rubbed = history.friction_force.values * history.slip_velocity.values
    rubbed = rubbed + history.friction_torque.values * spin
    absorbed = terrain.heave_stiffness * np.sum(history.unit_heave_rate.values**2, axis=1)
    absorbed += terrain.tilt_stiffness * np.sum(history.unit_tilt_rate.values**2, axis=1)
    named = {
        "drive": supplied["drive"],
        "machine_load": supplied["load"],
        "elastic_contact": np.sum(share * pressed, axis=1),
        "contact_damping": np.sum((1.0 - share) * pressed, axis=1),
        "friction": -rubbed.sum(axis=(1, 2)),
        "terrain_damping": terrain.damping_time * absorbed,
    }
    if case.undercarriage is not None:
        named |= _rolled_powers(history, case.undercarriage, shoes, supplied["chain"])
    if case.is_closed:
        named |= _closed_powers(history, shoes)
    return _over_time(history, "W", **named)


def _rolled_powers(
    history: History, frame: Undercarriage, shoes: _Motion, chain: np.ndarray
) -> dict[str, np.ndarray]:
    """Powers about a side frame over rigid shoes, on whose pins the chain has a power (times,)."""
    motion = _side_frame(history, frame)
    on_frame = motion.powers(acting.frame_actions(history))
    last, pins = history.case.track.shoe_count, acting.middle_pins
    front = shoes.velocity_at(pins(history, "front")[:, -1], last)
    tension = frame.end_tension * (front - shoes.velocity_at(pins(history, "rear")[:, 0], 1))[:, 0]
    _, resisted, damped = _treads(history, frame, motion, shoes)
    supplied = {"drive": on_frame["pull"] + chain - tension, "machine_load": on_frame["machine"] + tension}
    return supplied | {"rolling_resistance": resisted, "tread_damping": damped}


def _closed_frame(history: History) -> _Motion:
    """Motion of a closed track's side frame."""
    closed = history.case.closed_track
    assert closed is not None
    return _Motion(history, "side_frame_", closed.mass, closed.com, closed.inertia_tensor)


def _tumbler(history: History) -> _Motion:
    """Motion of a closed track's tumbler, with the side frame and against it."""
    case, data, motion = history.case, history.dataset, _closed_frame(history)
    assert case.closed_track is not None
    tumbler = case.closed_track.tumbler
    motion.velocity = motion.velocity_at(data.tumbler_position.values)
    motion.origin, motion.center = data.tumbler_position.values, np.zeros(3)
    motion.omega = motion.omega + data.tumbler_speed.values[:, None] * motion.axes[..., 1]
    angle = case.assembled.tumbler[4] + data.tumbler_angle.values
    motion.axes = motion.axes @ rotation_matrices(angle[:, None] * np.eye(3)[1])
    motion.mass, motion.inertia = np.asarray(tumbler.mass), inertia_tensor(tumbler.inertia)
    return motion


def _closed_powers(history: History, shoes: _Motion) -> dict[str, np.ndarray]:
    """Powers about the gear of a closed track with rigid shoes."""
    data, time = history.dataset, history.time.values
    taken = {}
    for kind, gear in (("wheel", _closed_frame(history)), ("tooth", _tumbler(history))):
        force, moment = data["wheel_load" if kind == "wheel" else "tooth_force"], data[f"{kind}_moment"]
        lost = -np.gradient(data[f"{kind}_energy"].values, time)
        for shoe in range(data.sizes["shoe"]):
            slip = shoes.velocity[:, shoe] - gear.velocity_at(shoes.origin[:, shoe])
            spin = shoes.omega[:, shoe] - gear.omega
            lost -= np.sum(force.values[:, shoe] * slip + moment.values[:, shoe] * spin, axis=-1)
        taken[f"{kind}_losses"] = lost
    drive = (data.drive_moment * data.tumbler_speed).values
    return {"drive": drive, "machine_load": np.zeros(len(time))} | taken


def _treads(
    history: History, frame: Undercarriage, motion: _Motion, shoes: _Motion
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Energy in the treads, J, and the power that their resistance and damping take, W: arrays (times,)."""
    energy, resisted, damped = np.zeros((3, history.time.size))
    rails = history.case.shoe.rails
    middles = () if rails is None else rails.middles
    stiffness, power = frame.stiffness / frame.strips, frame.exponent + 1.0
    on_rails = ((one, one.entry) for one in acting.actions(history) if isinstance(one.entry, acting.OnRail))
    for action, entry in on_rails:
        rail, strip = divmod(entry.line, frame.strips)
        place = (frame.rollers[entry.roller], middles[rail] + frame.strip_places[strip], 0.0)
        away = motion.origin + motion.axes @ np.array(place) - action.point
        distance = np.linalg.norm(away, axis=1, keepdims=True)
        normal, force = away / distance, -action.force
        depth = np.where(force.any(axis=1), frame.radius - distance[:, 0], 0.0).clip(0.0)
        slip = motion.velocity_at(action.point) - shoes.velocity_at(action.point, action.shoe)
        pressed, rate = np.sum(force * normal, axis=1), -np.sum(normal * slip, axis=1)
        energy += stiffness / power * depth**power
        damped += (pressed - stiffness * depth**frame.exponent) * rate
        resisted -= np.sum(force * slip, axis=1) + pressed * rate
    return energy, resisted, damped


def energy_balance(history: History) -> xr.Dataset:
    """Where the work went, from the start to every time, J, each (time,).

    The changes of `energies`, the works of `powers` (by the trapezoidal rule over the stored states) and
    `imbalance`: work of drive and machine's forces less everything else.
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


def _only_rigid(history: History) -> None:
    closed = history.case.closed_track
    if history.case.car_body is not None or (closed is not None and closed.idler.tensioner is not None):
        raise ValueError("the energy balance of closed tracks needs one track with its idler on shims")
    if history.case.flexible is not None:
        raise ValueError("the energy balance needs a history of rigid shoes: it leaves out elastic energy")


def _times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Matrices (..., 3, 3) times vectors (..., 3)."""
    return (matrices @ vectors[..., None])[..., 0]


def _over_time(history: History, unit: str, **values: np.ndarray) -> xr.Dataset:
    return xr.Dataset(
        {name: ("time", one, {"units": unit}) for name, one in values.items()}, coords={"time": history.time}
    )
