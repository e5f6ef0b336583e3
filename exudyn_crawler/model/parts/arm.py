"""Sprung arms: bodies on pivots of the side frame, each with a road wheel and a spring against the frame."""

import numpy as np

from exudyn_crawler.case.gear.base import SIDE_FRAME
from exudyn_crawler.case.gear.running_gear import RunningGear
from exudyn_crawler.model.assembler import Assembler
from exudyn_crawler.model.forces.arms import Arms
from exudyn_crawler.model.parts.frame import add_pivoted


def add(assembler: Assembler) -> None:
    """Add the arms of each track, which carry their rollers instead of the frame."""
    case = assembler.case
    gear = case.part(RunningGear)
    if not gear.arms:
        return
    reference = gear.arm_reference(case)
    parts = [(arm, (arm.roller,)) for arm in gear.arms]
    numbers = add_pivoted(assembler, gear.arm_names, reference, parts)
    frame = assembler.body_named(SIDE_FRAME)
    springs = gear.arms * gear.tracks
    assembler.arms = Arms(
        bodies=np.column_stack((numbers, np.full(len(numbers), frame))),
        up=np.array([1.0 if gear.rollers[arm.roller - 1] < arm.pivot[0] else -1.0 for arm in springs]),
        torque=np.array([arm.torque for arm in springs]),
        stiffness=np.array([arm.stiffness for arm in springs]),
        damping=np.array([arm.damping for arm in springs]),
        stop=np.array([np.inf if arm.stop is None else arm.stop for arm in springs]),
        stop_stiffness=np.array([arm.stop_stiffness for arm in springs]),
    )
