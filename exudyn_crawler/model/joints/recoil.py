"""Recoil springs: a bearing's row along the frame holds an idler up to a preload, and yields beyond it."""

from typing import NamedTuple

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.packed import Floats1, Ints1
from exudyn_crawler.model.bodies import Bodies
from exudyn_crawler.model.markers import Markers
from exudyn_crawler.model.rows import JointRows, Motion


class Recoils(NamedTuple):
    """Recoil springs, each on the row of a bearing along the frame; k of them.

    A row of a bearing with compliance is that of a spring without stops: its gap counts from the free length
    of the spring. The travel s of the idler follows from ``s + c d ds/dt = c (F - F0)`` with the push F, the
    compliance c and the damping d. At stops the right side is zero or the stroke: it is continuous in
    position, speed and force, and the damper brings the idler to rest there. If the stop alone did this,
    there might be no state at the end of a step in which the spring and the stop both agree with their force.
    """

    rows: Ints1  # (k,): written by the pins
    preload: Floats1  # (k,): N
    compliance: Floats1  # (k,): m/N
    stroke: Floats1  # (k,): m


@inner
def write_rows(recoils: Recoils, bodies: Bodies, markers: Markers, motion: Motion, rows: JointRows) -> None:
    """Turn the written rows of springs at a stop into those of stops."""
    for k in range(recoils.rows.shape[0]):
        row = recoils.rows[k]
        # the multiplier is the push with the other sign
        way = recoils.compliance[k] * (-motion.multipliers[row] - recoils.preload[k])
        if 0.0 < way < recoils.stroke[k]:
            continue
        rows.gap[row] += recoils.preload[k] * recoils.compliance[k]
        if way > 0.0:
            rows.gap[row] += recoils.stroke[k]
        rows.share[row] = 0.0
