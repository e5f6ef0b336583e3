"""Small models of Exudyn on a side frame that stands on a few shoes."""

import numpy as np
from exudyn.utilities import InertiaCuboid
from scipy.spatial.transform import Rotation

from exudyn_crawler import StepProfile, dynamic_settings
from exudyn_crawler.coupled.tracks import UNTURNED
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
