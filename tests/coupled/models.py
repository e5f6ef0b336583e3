"""Small models of Exudyn on a side frame that stands on a few shoes."""

from typing import NamedTuple

import numpy as np
from exudyn.utilities import InertiaCuboid
from scipy.spatial.transform import Rotation

from exudyn_crawler import StepProfile, add_track, dynamic_settings, solve_dynamic
from exudyn_crawler.coupled.tracks import UNTURNED, CoupledTrack
from exudyn_crawler.model.exudyn import exu, items
from tests.rolled import small_case

STEP = 2e-3  # s


def still_case(**frame):
    """Three rollers on ten shoes, whose drive stands still."""
    case = small_case(**frame)
    return case.with_(drive=case.drive.with_(speed=StepProfile.constant(0.0)))


def model():
    """A container, which has to live as long, and an empty model."""
    container = exu.SystemContainer()
    return container, container.AddSystem()


def settings(case, end, start=0.0):
    """Settings whose sensors write every step."""
    made = dynamic_settings(case, end, start)
    made.solution.sensors.writePeriod = case.solver.step
    return made


def cuboid(mass, side=1.0):
    """Inertia of a cube of a mass (kg)."""
    return InertiaCuboid(mass / side**3, [side, side, side])


def add_box(mbs, track, mass, place, side=1.0, axes=UNTURNED, **about):
    """A cube at a place in the axes of the car body at rest, and turned against these; its number."""
    return mbs.CreateRigidBody(inertia=cuboid(mass, side), **track.at(place, axes) | about)


def add_hinge(mbs, track, bodies, place, axis):
    """A hinge of two bodies at a place, about an axis, in the axes of the car body at rest."""
    where = {"position": track.place(place), "axis": track.axes @ np.array(axis, dtype=float)}
    mbs.CreateRevoluteJoint(itemNumbers=bodies, useGlobalFrame=True, **where)


def add_pendulum(mbs, track, mass, length, height, angle):
    """A pendulum on a pivot above the origin of the car body; the number of its bob."""
    turn = Rotation.from_euler("y", -angle).as_matrix()
    place = [np.sin(angle) * length, 0.0, height - np.cos(angle) * length]
    bob = add_box(mbs, track, mass, place, axes=turn)
    add_hinge(mbs, track, [track.body, bob], [0.0, 0.0, height], [0, 1, 0])
    return bob


def add_sensor(mbs, body, quantity):
    """A sensor of a body's quantity, which stores its values."""
    kind = getattr(exu.OutputVariableType, quantity)
    return mbs.AddSensor(items.SensorBody(bodyNumber=body, outputVariableType=kind, storeInternal=True))


class Swing(NamedTuple):
    """Second of a pendulum on a track, beside the known swing on a fixed pivot."""

    track: CoupledTrack
    steps: int
    lowest: int  # number of the last stored time before the bob is at its lowest
    period: float  # four quarters, s
    pulls: np.ndarray  # on the car body, upward, less what carries the car body's Exudyn part, N
    known_period: float
    known_pull: float  # at the lowest place


def swing(case, mass, length, height, angle):
    """Let a pendulum swing on a track for a second."""
    _container, mbs = model()
    track = add_track(mbs, case, carried_mass=mass, carried_com=(0.0, 0.0, height))
    bob = add_pendulum(mbs, track, mass, length, height, angle)
    angles = add_sensor(mbs, bob, "Rotation")
    load = mbs.AddSensor(items.SensorLoad(loadNumber=track.car.force, storeInternal=True))
    mbs.Assemble()
    solve_dynamic(mbs, settings(case, 1.0))
    time, _, turned, _ = mbs.GetSensorStoredData(angles).T
    k = int(np.flatnonzero(np.diff(np.sign(turned)))[0])
    quarter = time[k] - turned[k] * (time[k + 1] - time[k]) / (turned[k + 1] - turned[k])
    start = abs(turned[0])
    gravity = np.linalg.norm(track.gravity)
    radius = length + 1.0 / (6.0 * length)  # a cube of 1 m
    period = 2.0 * np.pi * np.sqrt(radius / gravity) * (1.0 + start**2 / 16.0 + 11.0 * start**4 / 3072.0)
    own = mbs.GetObject(track.body)["mass"] * gravity
    pulls = mbs.GetSensorStoredData(load)[:, 3] - own
    pull = mass * gravity + mass * length * 2.0 * gravity * (1.0 - np.cos(start)) / radius
    return Swing(track, len(time) - 1, k, 4.0 * quarter, pulls, period, pull)
