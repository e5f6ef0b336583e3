"""Regions of a shoe by which hot spots and lives are told apart."""

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case.parameters.track import Track
from fem import Shapes

Region = Literal["roller path", "lugs", "bores", "web", "wings"]
REGIONS: tuple[Region, ...] = get_args(Region)
BORES: Region = "bores"
"""Nodes that a joint's rigid spider holds, whose stress is none to use."""
LUG_RADIUS, LUG_HALF_WIDTH = 0.24, 0.2
"""m, from a pin's axis to behind the fillets at a lug's root, and to either side of its middle."""
WING_BESIDE = 0.5
"""m, from the outer side of a rail."""
EDGE = 0.01
"""m, by which the roller path is wider than the rails above it."""


def shoe_regions(whole: Shapes, track: Track) -> NDArray:
    """Region of every node of a shoe: array (n,) of str, of `REGIONS`.

    Bores are what joints hold, lugs what else is about the pins, with the lugs' roots. The roller path is
    what lies below the surface "rails", from the height of the pins up; wings begin 0.5 m beside the rails.
    The web is the rest; without a surface "rails" there is neither roller path nor wing.
    """
    nodes, mesh = whole.nodes, whole.mesh
    x, y, z = nodes.T
    regions = np.full(len(nodes), "web", dtype=object)
    rails = nodes[mesh.nodes_of("rails"), 1] if "rails" in mesh.surfaces else np.empty(0)
    for rail in (rails[rails < 0.0], rails[rails >= 0.0]):
        if len(rail):
            within = (y >= rail.min() - EDGE) & (y <= rail.max() + EDGE)
            regions[within & (z > track.pin_height)] = "roller path"
    if len(rails):
        regions[(y < rails.min() - WING_BESIDE) | (y > rails.max() + WING_BESIDE)] = "wings"
    for center in track.joint_centers.values():
        near = np.hypot(x - center[0], z - center[2]) < LUG_RADIUS
        regions[near & (np.abs(y - center[1]) < LUG_HALF_WIDTH)] = "lugs"
    regions[whole.spider_nodes] = BORES
    return regions
