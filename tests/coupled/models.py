"""Small models of Exudyn on a side frame that stands on a few shoes."""

import numpy as np
from exudyn.utilities import InertiaCuboid
from scipy.spatial.transform import Rotation

from exudyn_crawler import StepProfile, dynamic_settings
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


def add_box(mbs, track, mass, place, side=1.0, **about):
    """A cube at a place in the axes of the car body at rest; its number."""
    about = {"referenceRotationMatrix": track.axes} | about
    return mbs.CreateRigidBody(
        inertia=cuboid(mass, side), referencePosition=track.place(place), gravity=track.gravity, **about
    )


def add_hinge(mbs, track, bodies, place, axis):
    """A hinge of two bodies at a place, about an axis, in the axes of the car body at rest."""
    where = {"position": track.place(place), "axis": track.axes @ np.array(axis, dtype=float)}
    mbs.CreateRevoluteJoint(itemNumbers=bodies, useGlobalFrame=True, **where)


def add_pendulum(mbs, track, mass, length, height, angle):
    """A pendulum on a pivot above the origin of the car body; the number of its bob."""
    turn = track.axes @ Rotation.from_euler("y", -angle).as_matrix()
    place = [np.sin(angle) * length, 0.0, height - np.cos(angle) * length]
    bob = add_box(mbs, track, mass, place, referenceRotationMatrix=turn)
    add_hinge(mbs, track, [track.body, bob], [0.0, 0.0, height], [0, 1, 0])
    return bob


def add_sensor(mbs, body, quantity):
    """A sensor of a body's quantity, which stores its values."""
    kind = getattr(exu.OutputVariableType, quantity)
    return mbs.AddSensor(items.SensorBody(bodyNumber=body, outputVariableType=kind, storeInternal=True))


