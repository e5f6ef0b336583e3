"""Side frame and rollers of a history: loads on rails, balance of the frame, where its energy goes."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.case import Undercarriage
from exudyn_crawler.case.parameters.track import SIDES
from exudyn_crawler.ground.rotations import moments_on_angles, rotation_matrices
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads.actions import OnRail, actions, pulled_shares


def roller_loads(history: History, shoe: int) -> xr.Dataset:
    """Forces of the rollers on the rails of a shoe, in its axes.

    Both strips of a tread together: their forces have the same direction and act on a line across the rail.

    Parameters
    ----------
    shoe : int
        Number of the shoe.

    Returns
    -------
    xarray.Dataset
        `force` (time, roller, rail, axis), N; `place` (time, roller, rail, axis), m: where it acts, x
        along and y across the shoe, z up; NaN while a roller is not on the rail.

    Raises
    ------
    ValueError
        If no side frame rolls over the history's track, or that has no such shoe.
    """
    frame = _frame_of(history)
    history.case.track.check_shoe(shoe)
    axes = rotation_matrices(history.angles.sel(shoe=shoe).values)
    origin = history.position.sel(shoe=shoe).values
    shape = (len(axes), len(frame.rollers), len(SIDES), 3)
    force, weighted, weight = np.zeros(shape), np.zeros(shape), np.zeros(shape[:3])
    for action in actions(history, shoe):
        if isinstance(action.entry, OnRail):
            roller = int(action.where.split()[1]) - 1
            at = (slice(None), roller, action.entry.line // frame.strips)
            own, size = np.einsum("tij,ti->tj", axes, action.force), np.linalg.norm(action.force, axis=1)
            force[at] += own
            weighted[at] += size[:, None] * np.einsum("tij,ti->tj", axes, action.point - origin)
            weight[at] += size
    place = np.full(shape, np.nan)
    np.divide(weighted, weight[..., None], out=place, where=weight[..., None] > 0.0)
    dims = ("time", "roller", "rail", "axis")
    return xr.Dataset(
        {"force": (dims, force, {"units": "N"}), "place": (dims, place, {"units": "m"})},
        coords={name: getattr(history, name) for name in dims},
    )


def _frame_of(history: History) -> Undercarriage:
    frame = history.case.undercarriage
    if frame is None:
        raise ValueError(
            f"the history must be of a case with an undercarriage, {history.case.name!r} has none"
        )
    return frame


def frame_imbalance(history: History) -> xr.Dataset:
    """Rate of the side frame's momentum less all that acts on it: zero where mechanics holds.

    Its y and its yaw are held and have reactions, which are left out.

    Returns
    -------
    xarray.Dataset
        `travel` and `heave` (N) along x and z, `roll` and `pitch` (N m) about the axes of these angles and
        the frame's origin, each (time,).

    Raises
    ------
    ValueError
        If no side frame rolls over the history's track.
    """
    frame = _frame_of(history)
    motion = _Motion(history, frame)
    rate, spin = motion.momentum_rates()
    force, moment = motion.applied()
    off, turning = rate - force, spin - moment
    angles = moments_on_angles(history.side_frame_angles.values, turning)
    named = {"travel": (off[:, 0], "N"), "heave": (off[:, 2], "N")}
    named |= {"roll": (angles[:, 0], "N m"), "pitch": (angles[:, 1], "N m")}
    return xr.Dataset(
        {name: ("time", values, {"units": unit}) for name, (values, unit) in named.items()},
        coords={"time": history.time},
    )


def frame_energies(history: History, frame: Undercarriage) -> dict[str, xr.DataArray]:
    """Energy of the side frame and in the treads over time, J, each (time,).

    `frame_kinetic`; `frame_gravitational`, heights from z = 0; `treads`, stored in their contacts with rails.
    """
    motion = _Motion(history, frame)
    own = np.einsum("tji,tj->ti", motion.axes, motion.omega)
    kinetic = 0.5 * frame.mass * np.sum(motion.center_velocity**2, axis=1)
    kinetic += 0.5 * np.sum(own * (own @ frame.inertia_tensor), axis=1)
    height = (motion.origin + motion.center) @ history.case.gravity_vector()
    power = frame.exponent + 1.0
    treads = frame.stiffness / frame.strips / power * motion.depth**power
    sums = {
        "frame_kinetic": kinetic,
        "frame_gravitational": -frame.mass * height,
        "treads": treads.sum(axis=(1, 2, 3, 4)),
    }
    return {name: _over_time(history, values, "J") for name, values in sums.items()}


def frame_powers(history: History, frame: Undercarriage) -> dict[str, xr.DataArray]:
    """Powers about a side frame over rigid shoes, W, each (time,).

    `drive`, of its pull on frame and chain; `machine_load`, of the machine's force and moment on the frame
    and the tension of the chain's ends; `rolling_resistance` and `tread_damping`, which take power.
    """
    motion, case = _Motion(history, frame), history.case
    velocity, omega = history.velocity.values, history.angular_velocity.values
    front, rear = _pins(history, "front"), _pins(history, "rear")
    along = [(velocity + np.cross(omega, pins - history.position.values))[..., 0] for pins in (rear, front)]
    over = motion.velocity[:, None] + np.cross(motion.omega[:, None], front - motion.origin[:, None])
    passing = np.sum(pulled_shares(history, frame) * (over[..., 0] - along[1]), axis=1)
    force, moment = case.machine_wrench(history.time.values)
    given = np.sum(force * motion.velocity, axis=1) + np.sum(moment * motion.omega, axis=1)
    given += frame.end_tension * (along[1][:, -1] - along[0][:, 0])

    shoe = np.minimum(history.roller_shoe.values[..., None] + np.arange(2), case.track.shoe_count) - 1
    times = np.arange(len(velocity))[:, None, None]
    under = (slice(None), slice(None), None, None)
    arm = motion.foot - history.position.values[times, shoe][under]
    slip = motion.velocity[:, None, None, None, None] + np.cross(
        motion.omega[:, None, None, None, None], motion.foot - motion.origin[:, None, None, None, None]
    )
    slip -= velocity[times, shoe][under] + np.cross(omega[times, shoe][under], arm)
    normal = np.sum(motion.on_frame * motion.normal, axis=-1)
    tangential = motion.on_frame - normal[..., None] * motion.normal
    rate = -np.sum(motion.normal * slip, axis=-1)
    elastic = frame.stiffness / frame.strips * motion.depth**frame.exponent
    sums = {
        "drive": history.drive_pull.values * passing,
        "machine_load": given,
        "rolling_resistance": -np.sum(tangential * slip, axis=(1, 2, 3, 4, 5)),
        "tread_damping": np.sum((normal - elastic) * rate, axis=(1, 2, 3, 4)),
    }
    return {name: _over_time(history, values, "W") for name, values in sums.items()}


def _pins(history: History, end: str) -> NDArray:
    """Middle between the pins at an end of every shoe: array (times, shoes, 3), m, global."""
    centers = history.case.track.joint_centers
    place = np.mean([center for name, center in centers.items() if name.startswith(end)], axis=0)
    return history.position.values + rotation_matrices(history.angles.values) @ place


def _over_time(history: History, values: NDArray, unit: str) -> xr.DataArray:
    return xr.DataArray(values, dims="time", coords={"time": history.time}, attrs={"units": unit})


class _Motion:
    """Motion of a side frame and what its treads do, as arrays; all global, SI.

    Attributes
    ----------
    origin, velocity, omega, center, center_velocity : array (times, 3)
        Of the frame; `center` is its COM from the origin.
    axes : array (times, 3, 3)
    on_frame, foot, normal : array (times, rollers, 2, strips, 2, 3)
        Force of every tread on the frame, its place, and the direction from there to the roller's axis.
    depth : array (times, rollers, 2, strips, 2)
        Zero where a tread does not touch.
    """

    def __init__(self, history: History, frame: Undercarriage) -> None:
        self._history, self._frame = history, frame
        rails = history.case.shoe.rails
        self.origin, self.velocity = history.side_frame_position.values, history.side_frame_velocity.values
        self.axes = rotation_matrices(history.side_frame_angles.values)
        self.omega = history.side_frame_angular_velocity.values
        self.center = self.axes @ np.array(frame.com)
        self.center_velocity = self.velocity + np.cross(self.omega, self.center)
        self.on_frame, self.foot = -history.tread_force.values, history.tread_foot.values
        middles = () if rails is None else rails.middles
        places = [[[(x, y + dy, 0.0) for dy in frame.strip_places] for y in middles] for x in frame.rollers]
        middle = np.einsum("tij,rabj->trabi", self.axes, np.array(places)) + self.origin[:, None, None, None]
        away = middle[..., None, :] - self.foot
        distance = np.linalg.norm(away, axis=-1)
        self.normal = away / distance[..., None]
        self.depth = np.where(self.on_frame.any(axis=-1), frame.radius - distance, 0.0).clip(0.0)

    def momentum_rates(self) -> tuple[NDArray, NDArray]:
        """Rates of momentum (N) and of angular momentum about the origin (N m): array (times, 3) each."""
        history, frame = self._history, self._frame
        alpha = history.side_frame_angular_acceleration.values
        inertia = self.axes @ frame.inertia_tensor @ np.swapaxes(self.axes, -1, -2)
        turning = np.cross(self.omega, np.cross(self.omega, self.center))
        rate = history.side_frame_acceleration.values + np.cross(alpha, self.center) + turning
        rate = frame.mass * rate
        spin = np.einsum("tij,tj->ti", inertia, alpha)
        spin += np.cross(self.omega, np.einsum("tij,tj->ti", inertia, self.omega))
        return rate, spin + np.cross(self.center, rate)

    def applied(self) -> tuple[NDArray, NDArray]:
        """Sums of forces on the frame (N) and of moments about its origin (N m): array (times, 3) each."""
        history, frame = self._history, self._frame
        case = history.case
        weight = frame.mass * case.gravity_vector()
        force, moment = case.machine_wrench(history.time.values)
        force, moment = force + weight, moment + np.cross(self.center, weight)
        arm = self.foot - self.origin[:, None, None, None, None]
        force = force + self.on_frame.sum(axis=(1, 2, 3, 4))
        moment = moment + np.cross(arm, self.on_frame).sum(axis=(1, 2, 3, 4))
        pulled = _pins(history, "front")
        pull = np.zeros_like(pulled)
        pull[..., 0] = history.drive_pull.values[:, None] * pulled_shares(history, frame)
        return force + pull.sum(axis=1), moment + np.cross(pulled - self.origin[:, None], pull).sum(axis=1)
