"""From the states of the multibody system to a history's named variables.

Works on the rows that `engine.System.state` gives; nothing here solves anything.
"""

from importlib.metadata import version

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.case.track import SIDES
from exudyn_crawler.ground.pairs import RESULT
from exudyn_crawler.ground.rotations import angular_acceleration, angular_velocity, rotation_matrices
from exudyn_crawler.ground.sphere_contact import SphereContact
from exudyn_crawler.model.system import System
from exudyn_crawler.results.history import History

AXES = ["x", "y", "z"]

Variable = tuple[tuple[str, ...], NDArray, dict[str, str]]


def history_of(system: System, rows: NDArray) -> History:
    """Turn the stored states of a run into its history.

    Parameters
    ----------
    rows : array (times, 1 + 3 coordinates + multipliers)
        Rows as of `System.state`.
    """
    size = system.contact.size
    time = rows[:, 0]
    q, q_t, q_tt = (rows[:, 1 + k * size : 1 + (k + 1) * size] for k in range(3))
    multipliers = rows[:, 1 + 3 * size :]
    case = system.case
    variables = (
        _shoes(system, q, q_t, q_tt) | _reactions(system, q, multipliers) | _terrain(system, q, q_t, q_tt)
    )
    variables["shoe_load"] = (
        ("time", "shoe"),
        case.loads.loads(time),
        {"units": "N", "long_name": "machine and dipper load, downward"},
    )
    variables |= _flexible(system, q, q_t, multipliers)
    contacts, pairs = _contacts(system, rows, q, q_t)
    dataset = xr.Dataset(
        variables | contacts,
        coords={
            "time": ("time", time, {"units": "s"}),
            "shoe": case.track.shoes,
            "joint": ("joint", case.track.joints, {"long_name": "link of shoes i and i + 1"}),
            "unit": case.terrain.units,
            "axis": AXES,
            **_flexible_coordinates(system),
            "contact_shoe": ("contact", pairs[:, 0]),
            "contact_unit": ("contact", pairs[:, 1]),
        },
        attrs={
            "title": case.name,
            "exudyn_version": version("exudyn"),
            "exudyn_crawler_version": version("exudyn-crawler"),
        },
    )
    return History(case=case, dataset=dataset)


def _shoes(system: System, q: NDArray, q_t: NDArray, q_tt: NDArray) -> dict[str, Variable]:
    shoes = system.case.track.shoe_count
    u, v, a = (x[:, : 6 * shoes].reshape(len(x), shoes, 6) for x in (q, q_t, q_tt))
    angles, rates, accelerations = u[..., 3:], v[..., 3:], a[..., 3:]
    position = u[..., :3] + system.contact.shoe_reference[:, :3]
    named = {
        "position": (position, "m", "position of the COM"),
        "velocity": (v[..., :3], "m/s", "velocity of the COM"),
        "acceleration": (a[..., :3], "m/s2", "acceleration of the COM"),
        "angles": (angles, "rad", "angles of successive rotations about x, y, z"),
        "angular_velocity": (angular_velocity(angles, rates), "rad/s", "angular velocity"),
        "angular_acceleration": (
            angular_acceleration(angles, rates, accelerations),
            "rad/s2",
            "angular acceleration",
        ),
    }
    return {
        name: (("time", "shoe", "axis"), values, {"units": unit, "long_name": meaning})
        for name, (values, unit, meaning) in named.items()
    }


def _pin_axes(system: System, q: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Axes y of the rear and x, z of the front shoe of every link: arrays (times, joints, 3)."""
    count = system.case.track.shoe_count
    frames = rotation_matrices(q[:, : 6 * count].reshape(len(q), count, 6)[..., 3:])
    return frames[:, :-1, :, 1], frames[:, 1:, :, 0], frames[:, 1:, :, 2]


def _pin_torque(reaction: NDArray, y0: NDArray, x1: NDArray, z1: NDArray) -> NDArray:
    """Torque on the rear shoe of a joint's multipliers (times, 6): array (times, 3)."""
    return reaction[:, 3, None] * np.cross(x1, y0) + reaction[:, 5, None] * np.cross(z1, y0)


def _reactions(system: System, q: NDArray, multipliers: NDArray) -> dict[str, Variable]:
    """Forces and torques of links and drive.

    A link's equations are ``p_front - p_rear = 0`` and, with the axes of the rear shoe marked 0 and of
    the front one 1, ``y0 . x1 = 0`` and ``y0 . z1 = 0``: the multipliers of the first are the force on
    the rear shoe, those of the others turn it by ``x1 x y0`` and ``z1 x y0``.
    """
    y0, x1, z1 = _pin_axes(system, q)
    force = np.zeros(y0.shape)
    torque = np.zeros_like(force)
    for link, pins in enumerate(system.link_rows):
        for rows in pins:
            reaction = multipliers[:, rows]
            force[:, link] += reaction[:, :3]
            torque[:, link] += _pin_torque(reaction, y0[:, link], x1[:, link], z1[:, link])
    turn = np.zeros(len(q)) if system.turn_row is None else -multipliers[:, system.turn_row]
    return {
        "joint_force": (
            ("time", "joint", "axis"),
            force,
            {"units": "N", "long_name": "force of the spherical joint on the rear shoe"},
        ),
        "joint_torque": (
            ("time", "joint", "axis"),
            torque,
            {"units": "N m", "long_name": "torque of the parallel joint on the rear shoe"},
        ),
        "drive_force": (
            ("time",),
            -multipliers[:, system.drive_row],
            {"units": "N", "long_name": "force of the drive on the front shoe along x"},
        ),
        "drive_point": (
            ("time", "axis"),
            _drive_point(system, q),
            {"units": "m", "long_name": "point of the front shoe that the drive moves"},
        ),
        "drive_torque": (
            ("time",),
            turn,
            {"units": "N m", "long_name": "torque of the turn on the front shoe about its z axis"},
        ),
    }


def _drive_point(system: System, q: NDArray) -> NDArray:
    """Where the drive acts: array (times, 3)."""
    last = 6 * (system.case.track.shoe_count - 1)
    modes = system.point.rows.shape[1]
    # the front shoe's modal coordinates are the last, if it has any
    arm = system.point.arm(q[:, last + 3 : last + 6], q[:, q.shape[1] - modes :])
    return q[:, last : last + 3] + system.contact.shoe_reference[-1, :3] + arm


def _flexible_coordinates(system: System) -> dict[str, object]:
    if system.floating is None:
        return {}
    assert system.case.flexible is not None
    return {
        "flexible_shoe": list(system.case.flexible.shoes),
        "mode": np.arange(1, system.floating.mode_count + 1),
        "frequency": ("mode", system.floating.reduced.frequencies, {"units": "Hz"}),
        "pin": list(SIDES),
    }


def _flexible(system: System, q: NDArray, q_t: NDArray, multipliers: NDArray) -> dict[str, Variable]:
    """Modal coordinates of the flexible shoes and the forces at each pin of their links."""
    if system.floating is None:
        return {}
    assert system.case.flexible is not None
    numbers = system.case.flexible.shoes
    modes = system.floating.mode_count
    bent, bending = (x[:, -len(numbers) * modes :].reshape(len(q), len(numbers), modes) for x in (q, q_t))
    force = np.full((len(q), len(system.link_rows), len(SIDES), 3), np.nan)
    torque = np.full_like(force, np.nan)
    y0, x1, z1 = _pin_axes(system, q)
    for link, pins in enumerate(system.link_rows):
        for side, rows in enumerate(pins):
            force[:, link, side] = multipliers[:, rows[:3]]
            torque[:, link, side] = _pin_torque(multipliers[:, rows], y0[:, link], x1[:, link], z1[:, link])
    return {
        "modal_coordinate": (
            ("time", "flexible_shoe", "mode"),
            bent,
            {"units": "kg0.5 m", "long_name": "modal coordinate"},
        ),
        "modal_velocity": (
            ("time", "flexible_shoe", "mode"),
            bending,
            {"units": "kg0.5 m/s", "long_name": "rate of the modal coordinate"},
        ),
        "pin_force": (
            ("time", "joint", "pin", "axis"),
            force,
            {"units": "N", "long_name": "force at the pin on the rear shoe; rigid links have one joint"},
        ),
        "pin_torque": (
            ("time", "joint", "pin", "axis"),
            torque,
            {"units": "N m", "long_name": "torque at the pin on the rear shoe"},
        ),
    }


def _terrain(system: System, q: NDArray, q_t: NDArray, q_tt: NDArray) -> dict[str, Variable]:
    named: dict[str, Variable] = {}
    for suffix, states, per in (("", q, ""), ("_rate", q_t, "/s"), ("_acceleration", q_tt, "/s2")):
        motion = np.stack([system.contact.unit_motion(row) for row in states])
        for name, column, unit in (("heave", 2, "m"), ("tilt", 3, "rad")):
            named[f"unit_{name}{suffix}"] = (
                ("time", "unit"),
                motion[..., column],
                {
                    "units": unit + per,
                    "long_name": f"{name}{suffix.replace('_', ' ')} of the unit, its springs free",
                },
            )
    return named


def _contacts(system: System, rows: NDArray, q: NDArray, q_t: NDArray) -> tuple[dict[str, Variable], NDArray]:
    """Contacts over time, one column a pair that ever met; zero while the pair is apart."""
    if isinstance(system.contact, SphereContact):
        shoe_forces = rows[:, -system.contact.shoe_reference.size :]
        states = zip(q, q_t, shoe_forces, strict=True)
        found = [system.contact.results(*state) for state in states]
    else:
        found = [system.contact.results(*state) for state in zip(q, q_t, strict=True)]
    rows = np.concatenate(found)
    keys = [
        rows[:, RESULT["shoe"]].astype(int) + 1,
        rows[:, RESULT["unit"]].astype(int) + 1,
    ]
    pairs, column = np.unique(np.column_stack(keys), axis=0, return_inverse=True)
    when = np.repeat(np.arange(len(found)), [len(one) for one in found])
    named = {
        "penetration": ("m", "depth at the centroid of the overlap"),
        "penetration_rate": ("m/s", "sinkage velocity at the centroid"),
        "area": ("m2", "area of the overlap"),
        "point": ("m", "centroid of the overlap, where the contact acts"),
        "normal_force": ("N", "normal force on the shoe"),
        "friction_force": ("N", "friction force on the shoe"),
        "slip_velocity": ("m/s", "slip velocity of the shoe relative to the unit"),
        "friction_torque": ("N m", "friction torque on the shoe"),
    }
    variables: dict[str, Variable] = {}
    for name, (unit, meaning) in named.items():
        values = rows[..., RESULT[name]]
        table = np.zeros((len(found), len(pairs), *values.shape[1:]))
        table[when, column.ravel()] = values
        dims = ("time", "contact", "axis")[: table.ndim]
        variables[name] = (dims, table, {"units": unit, "long_name": meaning})
    return variables, pairs
