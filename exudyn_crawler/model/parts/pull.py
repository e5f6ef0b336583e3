"""Pull of a side frame's drive on the chain that lies before it, and the tension at the chain's ends."""

import numpy as np

from exudyn_crawler.case import Rolled
from exudyn_crawler.case.gear.base import SIDE_FRAME
from exudyn_crawler.model.assembler import DRIVE, Assembler
from exudyn_crawler.model.joints.pull import Pull
from exudyn_crawler.model.parts.shoes import middle_marker


def add(assembler: Assembler) -> None:
    """Add the pull, which acts on the frame and two shoes, and loads at the chain's ends."""
    case = assembler.case
    gear = case.part(Rolled)
    shoes = range(assembler.shoes)
    assembler.pull = Pull(
        row=0,
        frame=assembler.body_named(SIDE_FRAME),
        tumbler=float(gear.tumbler),
        pitch=float(case.track.pitch),
        ahead=float(case.track.pin_ahead),
        markers=np.array([middle_marker(assembler, shoe, "front") for shoe in shoes]),
    )
    for shoe in shoes:
        assembler.couple([shoe], [DRIVE])
    assembler.add_load(middle_marker(assembler, 0, "rear"))
    assembler.add_load(middle_marker(assembler, shoes[-1], "front"))
