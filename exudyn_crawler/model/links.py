"""Hinges between neighbouring shoes."""

from collections.abc import Sequence
from itertools import pairwise

from exudyn_crawler.case.parameters.track import SIDES
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.shoes import ShoeBody
from exudyn_crawler.model.state import pin_name


def add_links(mbs: "exu.MainSystem", shoes: Sequence[ShoeBody]) -> None:
    """Hinges between neighbours, their joints named by `state.pin_name`.

    Two rigid shoes have one joint, at the right pin: a spherical joint and a parallel axis in one item, five
    equations; the parallel axis has no place of its own, where its marker sits changes neither the motion nor
    the torque. Where a shoe is flexible each pin is a revolute joint.
    """
    for number, (rear, front) in enumerate(pairwise(shoes), start=1):
        for side in SIDES if rear.is_flexible or front.is_flexible else SIDES[:1]:
            mbs.AddObject(
                items.ObjectJointGeneric(
                    name=pin_name(side, number),
                    markerNumbers=[rear.pins["front", side], front.pins["rear", side]],
                    constrainedAxes=[1, 1, 1, 1, 0, 1],
                )
            )
