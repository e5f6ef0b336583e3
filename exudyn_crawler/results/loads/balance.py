"""Conservation of momentum and energy, checked on the history of a run.

Nothing here knows the solver: forces, positions and motion come from the stored variables, and what should
vanish or add up is returned. All vectors are global, all units SI.
"""

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads.actions import actions, shoe_mass
from exudyn_crawler.results.loads.rollers import frame_energies, frame_powers

FORCE = {"units": "N"}
MOMENT = {"units": "N m"}


KINDS = ("weight", "load", "contact", "drive", "joint")
ROLLED_KINDS = (*KINDS, "roller", "chain")
"""Kinds of actions on shoes, in the order in which they are added; under a side frame."""


def shoe_actions(history: History) -> xr.Dataset:
    """What acts on every shoe, by its kind.

    Returns
    -------
    xarray.Dataset
        `force` (N) and `moment` about the origin of the shoe's frame (N m), both (source, time, shoe, axis);
        sources are weight, load, contact, drive and joint (those of both links of a shoe together), and under
        a side frame roller and chain.
    """
    position = history.position.values
    kinds = KINDS if history.case.propel == "dragged" else ROLLED_KINDS
    forces = np.zeros((len(kinds), *position.shape))
    moments = np.zeros_like(forces)
    for action in actions(history):
        source, shoe = kinds.index(action.kind), action.shoe - 1
        forces[source, :, shoe] += action.force
        moments[source, :, shoe] += action.moment_about(position[:, shoe])
    dims = ("source", "time", "shoe", "axis")
    return xr.Dataset(
        {"force": (dims, forces, FORCE), "moment": (dims, moments, MOMENT)},
        coords={
            "source": list(kinds),
            "time": history.time,
            "shoe": history.shoe,
            "axis": history.axis,
        },
    )


def shoe_momentum_rates(history: History) -> xr.Dataset:
    """Rates of every shoe's momentum: `force` (N) and, about its frame, `moment` (N m), (time, shoe, axis).

    The elastic modes of a flexible shoe carry no momentum. They do carry angular momentum, whose rate takes
    accelerations of modes that a history does not keep: its moments are NaN.
    """
    case = history.case
    masses = [shoe_mass(case, shoe) for shoe in case.track.shoes.tolist()]
    frames = rotation_matrices(history.angles.values)
    inertia = frames @ case.shoe.inertia_tensor @ np.swapaxes(frames, -1, -2)
    omega, alpha = history.angular_velocity.values, history.angular_acceleration.values
    spin = _times(inertia, alpha) + np.cross(omega, _times(inertia, omega))
    if case.flexible is not None:
        spin[:, [shoe - 1 for shoe in case.flexible.shoes]] = np.nan
    center = _times(frames, np.array([one.center for one in masses]))
    rate = history.acceleration.values + np.cross(alpha, center) + np.cross(omega, np.cross(omega, center))
    rate *= np.array([one.mass for one in masses])[:, None]
    dims = ("time", "shoe", "axis")
    return xr.Dataset(
        {"force": (dims, rate, FORCE), "moment": (dims, spin, MOMENT)},
        coords={"time": history.time, "shoe": history.shoe, "axis": history.axis},
    )


def shoe_imbalance(history: History) -> xr.Dataset:
    """Momentum's rate less all that acts, of every single shoe: zero where mechanics holds.

    Returns
    -------
    xarray.Dataset
        `force` (N) and `moment` about the shoe's frame (N m), both (time, shoe, axis); moments of flexible
        shoes are NaN, see `shoe_momentum_rates`.
    """
    difference = shoe_momentum_rates(history) - shoe_actions(history).sum("source")
    return _with_units(difference)


def track_imbalance(history: History, about: ArrayLike = (0.0, 0.0, 0.0)) -> xr.Dataset:
    """Momentum's rate less what acts from outside, of the track as a whole: zero where mechanics holds.

    The links are internal and left out, so that this holds without their reactions.

    Parameters
    ----------
    about : array (3,)
        Fixed point that moments are taken about, m.

    Returns
    -------
    xarray.Dataset
        `force` (N) and `moment` about the point (N m), both (time, axis); with flexible shoes the moment is
        NaN, see `shoe_momentum_rates`.
    """
    outside = shoe_actions(history).drop_sel(source="joint").sum("source")
    one_by_one = shoe_momentum_rates(history) - outside
    arm = history.position.values - np.asarray(about, dtype=float)
    moment = one_by_one["moment"] + np.cross(arm, one_by_one["force"].values)
    return _with_units(xr.Dataset({"force": one_by_one["force"], "moment": moment}).sum("shoe", skipna=False))


def energies(history: History) -> xr.Dataset:
    """Stored energy of track and terrain over time, J: kinetic, gravitational and of the springs.

    Each (time,). Heights count from the origin of the COMs of shoes and from free springs of the units.
    Under a side frame also those of `rollers.frame_energies`.

    Raises
    ------
    ValueError
        For a history with flexible shoes.
    """
    _only_rigid(history)
    case, terrain = history.case, history.case.terrain
    shoe = case.shoe
    frames = rotation_matrices(history.angles.values)
    omega = history.angular_velocity.values
    body_omega = _times(np.swapaxes(frames, -1, -2), omega)
    heave, tilt = history.unit_heave.values, history.unit_tilt.values
    moving = 0.5 * shoe.mass * np.sum(history.velocity.values**2, axis=(1, 2))
    moving += 0.5 * np.sum(body_omega * (body_omega @ shoe.inertia_tensor), axis=(1, 2))
    moving += 0.5 * terrain.unit_mass * np.sum(history.unit_heave_rate.values**2, axis=1)
    tilting = terrain.unit_inertia[terrain.tilt_axis]
    moving += 0.5 * tilting * np.sum(history.unit_tilt_rate.values**2, axis=1)
    gravity = case.gravity_vector()
    weight = shoe.mass * history.position.values.sum(axis=1) @ gravity
    weight += terrain.unit_mass * heave.sum(axis=1) * gravity[2]
    springs = 0.5 * terrain.heave_stiffness * np.sum(heave**2, axis=1)
    springs += 0.5 * terrain.tilt_stiffness * np.sum(tilt**2, axis=1)
    found = _over_time(history, "J", kinetic=moving, gravitational=-weight, springs=springs)
    return found if case.undercarriage is None else found.assign(frame_energies(history, case.undercarriage))


def powers(history: History) -> xr.Dataset:
    """Power of all that stores no energy of its own in `energies`, W, each (time,).

    `drive` and `machine_load` bring power in, under a side frame as `rollers.frame_powers` has it with what
    its rollers take; `elastic_contact` goes into the contact's stiffness and
    comes back from it; `friction` (with the friction torque), `contact_damping` and `terrain_damping`
    take power.

    Raises
    ------
    ValueError
        For a history of contact by spheres: one row a pair does not say what its spheres take; or one with
        flexible shoes.
    """
    _only_rigid(history)
    case, terrain, law = history.case, history.case.terrain, history.case.contact
    if law.model != "pair":
        raise ValueError("powers need a history of contact.model 'pair', whose law they divide")
    frames = rotation_matrices(history.angles.values)
    omega, velocity = history.angular_velocity.values, history.velocity.values
    # while it acts, its point moves at its speed
    driven = history.drive_force.values * case.drive.speed.value(history.time.values)
    driven += history.drive_torque.values * np.sum(frames[:, -1, :, 2] * omega[:, -1], axis=-1)
    beside = case.loads.side_shift.value(history.time.values)[:, None, None] * frames[..., 1]
    at_load = velocity + np.cross(omega, frames @ np.array(case.shoe.load_point) + beside)
    loaded = np.sum(history.shoe_load.values * (at_load @ terrain.down), axis=1)

    depth, rate = history.penetration.values, history.penetration_rate.values
    normal = np.linalg.norm(history.normal_force.values, axis=-1)
    elastic = law.stiffness * np.maximum(depth, 0.0) ** law.exponent
    part = np.clip(depth / law.damping_depth, 0.0, 1.0)
    damping = law.damping * rate * part**2 * (3.0 - 2.0 * part)
    both = elastic + damping
    share = np.divide(elastic, both, out=np.zeros_like(elastic), where=both > 0.0)
    pressed = normal * rate

    units = history.contact_unit.values - 1
    spin = omega[:, history.contact_shoe.values - 1].copy()
    spin[..., terrain.tilt_axis] -= history.unit_tilt_rate.values[:, units]
    rubbed = history.friction_force.values * history.slip_velocity.values
    rubbed = rubbed + history.friction_torque.values * spin

    absorbed = terrain.heave_stiffness * np.sum(history.unit_heave_rate.values**2, axis=1)
    absorbed += terrain.tilt_stiffness * np.sum(history.unit_tilt_rate.values**2, axis=1)
    found = _over_time(
        history,
        "W",
        drive=driven,
        machine_load=loaded,
        elastic_contact=np.sum(share * pressed, axis=1),
        contact_damping=np.sum((1.0 - share) * pressed, axis=1),
        friction=-rubbed.sum(axis=(1, 2)),
        terrain_damping=terrain.damping_time * absorbed,
    )
    return found if case.undercarriage is None else found.assign(frame_powers(history, case.undercarriage))


def energy_balance(history: History) -> xr.Dataset:
    """Where the work went, from the start to every time, J.

    Returns
    -------
    xarray.Dataset
        The changes of `energies`, the works of `powers` (by the trapezoidal rule over the stored states)
        and `imbalance`: work of drive and machine's forces less everything else; each (time,).
    """
    stored = energies(history)
    change = stored - stored.isel(time=0)
    work = powers(history).cumulative_integrate("time")
    supplied = work["drive"] + work["machine_load"]
    taken = sum(power for name, power in work.data_vars.items() if name not in ("drive", "machine_load"))
    balance = xr.merge((change, work), combine_attrs="drop").assign(
        imbalance=supplied - taken - sum(change.data_vars.values())
    )
    for values in balance.data_vars.values():
        values.attrs = {"units": "J"}
    return balance


def _only_rigid(history: History) -> None:
    if history.case.flexible is not None:
        raise ValueError("the energy balance needs a history of rigid shoes: it leaves out elastic energy")


def _times(matrices: NDArray, vectors: NDArray) -> NDArray:
    """Matrices (..., 3, 3) times vectors (..., 3)."""
    return (matrices @ vectors[..., None])[..., 0]


def _with_units(balance: xr.Dataset) -> xr.Dataset:
    balance["force"].attrs, balance["moment"].attrs = dict(FORCE), dict(MOMENT)
    return balance


def _over_time(history: History, unit: str, **values: NDArray) -> xr.Dataset:
    return xr.Dataset(
        {name: ("time", one, {"units": unit}) for name, one in values.items()}, coords={"time": history.time}
    )
