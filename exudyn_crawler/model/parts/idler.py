"""Idlers on springs: bodies that slide in the frame and carry its front wheel."""

import numpy as np

from exudyn_crawler.case import Closed
from exudyn_crawler.case.gear.base import SIDE_FRAME
from exudyn_crawler.model.assembler import Assembler, Body
from exudyn_crawler.model.joints.pin import ROWS
from exudyn_crawler.model.parts.frame import carry
from exudyn_crawler.model.state import BEARING, MOTOR

ALONG = np.eye(ROWS)[0]
"""Equation of a bearing that the spring replaces, as a mask."""


def add(assembler: Assembler) -> None:
    """Add the idler of each track if it slides on a spring; other idlers are wheels of the frame."""
    case = assembler.case
    gear = case.part(Closed)
    spring = gear.idler.slide
    if spring is None:
        return
    recoil = gear.idler.recoil
    frame = assembler.body_named(SIDE_FRAME)
    # where its spring would not push it: a recoil spring is installed where the idler stands
    beyond = spring.preload / spring.stiffness - (gear.assembled(case).take_up if recoil is None else 0.0)
    inertia = spring.inertia_tensor(gear.idler.radius)
    wheels = [k for k, label in enumerate(gear.wheel_labels) if label.kind == "idler"]
    rows = zip(gear.sliding_idlers, gear.idler_reference(case), wheels, strict=True)
    for name, reference, wheel in rows:
        idler = assembler.add_body(Body.rigid(name, spring.mass, inertia, reference))
        unpushed = reference[:3] + np.array([beyond, 0.0, 0.0])
        axis = assembler.add_marker(frame, unpushed - gear.frame_start(case))
        assembler.add_pin(
            axis,
            assembler.add_marker(idler, np.zeros(3)),
            BEARING.format(name),
            compliance=ALONG / spring.stiffness,
            relaxation=ALONG * spring.relaxation,
        )
        if recoil is not None:
            assembler.add_recoil(recoil.preload, 1.0 / recoil.stiffness, recoil.stroke)
        # keeps it from spinning
        assembler.add_motor(frame, idler, MOTOR.format(name), np.inf, gear.torque_speed)
        carry(assembler, wheel, idler, (0.0, 0.0))
