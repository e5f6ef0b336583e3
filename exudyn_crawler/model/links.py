"""Hinges between neighbouring shoes."""

from collections.abc import Sequence
from itertools import pairwise

from exudyn_crawler.case.track import SIDES
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.shoes import ShoeBody


def add_links(mbs: "exu.MainSystem", shoes: Sequence[ShoeBody]) -> list[list[int]]:
    """Hinges between neighbours: for every link its joints, right pin first.

    Two rigid shoes have one: a spherical joint and a parallel axis in one item, five equations; the
    parallel axis has no place of its own, where its marker sits changes neither the motion nor the torque.
    Where a shoe is flexible each pin is a revolute joint.
    """
    links = []
    for number, (rear, front) in enumerate(pairwise(shoes), start=1):
        sides = SIDES if rear.is_flexible or front.is_flexible else SIDES[:1]
        links.append(
            [
                mbs.AddObject(
                    items.ObjectJointGeneric(
                        name=f"{side} pin of link {number}",
                        markerNumbers=[rear.pins["front", side], front.pins["rear", side]],
                        constrainedAxes=[1, 1, 1, 1, 0, 1],
                    )
                )
                for side in sides
            ]
        )
    return links
