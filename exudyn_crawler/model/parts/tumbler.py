"""Tumblers of closed tracks: bodies in bearings of the frame, whose motors drive the chain by its lugs."""

import numpy as np

from exudyn_crawler.case import Closed
from exudyn_crawler.case.gear.base import SIDE_FRAME
from exudyn_crawler.case.parameters.base import inertia_tensor
from exudyn_crawler.ground.laws import Impact
from exudyn_crawler.model.assembler import Assembler, Body
from exudyn_crawler.model.forces.impact import Flange
from exudyn_crawler.model.forces.teeth import Teeth
from exudyn_crawler.model.parts.shoes import joint_marker
from exudyn_crawler.model.state import BEARING, MOTOR

AT_PLANE = 0.5
"""Share of a tumbler's lateral guide at each of its two gear planes."""


def add(assembler: Assembler) -> None:
    """Add a tumbler of each track with bearing and motor, and the teeth that touch lugs of the shoes."""
    case = assembler.case
    gear = case.part(Closed)
    frame = assembler.body_named(SIDE_FRAME)
    # a drawbar test asks what the ground gives at a slip, which a drive that lags would change
    limit = np.inf if gear.torque_limit is None or case.drive.slip is not None else gear.torque_limit
    tumblers = []
    for name, reference in zip(gear.tumblers, gear.tumbler_reference(case), strict=True):
        inertia = inertia_tensor(gear.tumbler.inertia)
        tumbler = assembler.add_body(Body.rigid(name, gear.tumbler.mass, inertia, reference))
        axis = assembler.add_marker(frame, reference[:3] - gear.frame_start(case))
        center = assembler.add_marker(tumbler, np.zeros(3))
        assembler.add_pin(axis, center, BEARING.format(name))
        assembler.add_motor(frame, tumbler, MOTOR.format(name), limit, gear.torque_speed)
        tumblers.append(tumbler)
    assembler.teeth = _teeth(assembler, gear, tumblers)


def _teeth(assembler: Assembler, gear: Closed, tumblers: list[int]) -> Teeth:
    """Return the lugs of the shoes, and their tumblers."""
    chain = assembler.case.track
    lugs = gear.lugs(chain)
    markers = [joint_marker(assembler, shoe, *lug) for shoe in range(assembler.shoes) for lug in lugs]
    met = np.repeat(tumblers, len(markers) // len(tumblers))
    for shoe, tumbler in zip(range(assembler.shoes), met[:: len(lugs)].tolist(), strict=True):
        assembler.couple([shoe, tumbler])
    law = gear.tumbler
    return Teeth(
        markers=np.array(markers),
        tumblers=met,
        side=np.tile([place[1] for _, place in lugs], assembler.shoes),
        profile=law.profile(chain),
        law=Impact(law.stiffness, law.exponent, law.damping, law.damping_depth),
        flange=Flange(gear.guide_play, AT_PLANE * gear.guide_stiffness, AT_PLANE * gear.guide_damping),
    )
