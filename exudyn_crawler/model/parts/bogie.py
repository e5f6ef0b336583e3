"""Bogies: bodies that swing on pivots of the side frame, each with two of its rollers."""

import numpy as np

from exudyn_crawler.case.gear.base import SIDE_FRAME
from exudyn_crawler.case.parameters.base import inertia_tensor
from exudyn_crawler.model.assembler import Assembler, Body
from exudyn_crawler.model.parts.frame import carry
from exudyn_crawler.model.state import BEARING


def add(assembler: Assembler) -> None:
    """Add the bogies of each track, which carry their rollers in place of the frame."""
    case = assembler.case
    gear = case.running_gear()
    frame = assembler.body_named(SIDE_FRAME)
    rollers = [k for k, label in enumerate(gear.wheel_labels) if label.kind == "roller"]
    of_tracks = np.reshape(rollers, (gear.tracks, -1))
    carried = [(bogie, wheels) for wheels in of_tracks.tolist() for bogie in gear.bogies]
    reference = gear.bogie_reference(case.shoe, case.track)
    for name, start, (bogie, wheels) in zip(gear.bogie_names, reference, carried, strict=True):
        x, z = bogie.pivot
        com = bogie.com[0], 0.0, bogie.com[1]
        body = assembler.add_body(Body.rigid(name, bogie.mass, inertia_tensor(bogie.inertia), start, com))
        axis = assembler.add_marker(frame, start[:3] - case.frame_start)
        assembler.add_pin(axis, assembler.add_marker(body, np.zeros(3)), BEARING.format(name))
        for number in bogie.rollers:
            carry(assembler, wheels[number - 1], body, (gear.rollers[number - 1] - x, -z))
