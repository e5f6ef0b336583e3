"""Sprung arms: bodies on pivots of the side frame, each with a road wheel and a spring against the frame."""

import numpy as np

from exudyn_crawler.case.gear.base import SIDE_FRAME
from exudyn_crawler.case.parameters.base import inertia_tensor
from exudyn_crawler.model.assembler import Assembler, Body
from exudyn_crawler.model.forces.arms import Arms
from exudyn_crawler.model.parts.frame import carry
from exudyn_crawler.model.state import BEARING


def add(assembler: Assembler) -> None:
    """Add the arms of each track, which carry their rollers in place of the frame."""
    case = assembler.case
    gear = case.running_gear()
    if not gear.arms:
        return
    frame = assembler.body_named(SIDE_FRAME)
    rollers = [k for k, label in enumerate(gear.wheel_labels) if label.kind == "roller"]
    of_tracks = np.reshape(rollers, (gear.tracks, -1))
    carried = [(arm, wheels) for wheels in of_tracks.tolist() for arm in gear.arms]
    reference = gear.arm_reference(case.shoe, case.track)
    numbers = []
    for name, start, (arm, wheels) in zip(gear.arm_names, reference, carried, strict=True):
        x, z = arm.pivot
        com = arm.com[0], 0.0, arm.com[1]
        body = assembler.add_body(Body.rigid(name, arm.mass, inertia_tensor(arm.inertia), start, com))
        axis = assembler.add_marker(frame, start[:3] - case.frame_start)
        assembler.add_pin(axis, assembler.add_marker(body, np.zeros(3)), BEARING.format(name))
        carry(assembler, wheels[arm.roller - 1], body, (gear.rollers[arm.roller - 1] - x, -z))
        numbers.append(body)
    springs = [arm for arm, _ in carried]
    assembler.arms = Arms(
        bodies=np.column_stack((numbers, np.full(len(numbers), frame))),
        up=np.array([1.0 if gear.rollers[arm.roller - 1] < arm.pivot[0] else -1.0 for arm in springs]),
        torque=np.array([arm.torque for arm in springs]),
        stiffness=np.array([arm.stiffness for arm in springs]),
        damping=np.array([arm.damping for arm in springs]),
        stop=np.array([np.inf if arm.stop is None else arm.stop for arm in springs]),
        stop_stiffness=np.array([arm.stop_stiffness for arm in springs]),
    )
