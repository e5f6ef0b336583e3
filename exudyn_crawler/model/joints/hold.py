"""Holds: constant coordinates of bodies."""

from typing import NamedTuple

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.packed import Ints2
from exudyn_crawler.model.bodies import Bodies
from exudyn_crawler.model.markers import Markers
from exudyn_crawler.model.rows import ALONG_JACOBIAN, STIFFNESS, JointRows, Motion


class Held(NamedTuple):
    """Coordinates that are held constant, one row each; h of them."""

    first: int  # row of the first one
    coordinates: Ints2  # (h, 2): body, and which of its six coordinates


@inner
def write_rows(holds: Held, bodies: Bodies, markers: Markers, motion: Motion, rows: JointRows) -> None:
    """Write the rows of all holds."""
    for k in range(holds.coordinates.shape[0]):
        row = holds.first + k
        body = holds.coordinates[k, 0]
        coordinate = holds.coordinates[k, 1]
        rows.bodies[row, 0] = body
        rows.bodies[row, 1] = -1
        rows.gap[row] = motion.state[0, bodies.coordinate[body] + coordinate]
        rows.jacobian[row, 0].fill(0.0)
        rows.jacobian[row, 0, coordinate] = 1.0
        rows.scale[row] = STIFFNESS
        rows.slope[row] = STIFFNESS
        rows.share[row] = 0.0
        rows.relaxation[row] = 0.0
        rows.directed[row] = ALONG_JACOBIAN
