"""Recoil springs: a bearing's row along the frame holds an idler up to a preload, and gives way beyond."""

from typing import NamedTuple

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.packed import FloatArray, Floats1, Ints1
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model.bodies import Bodies
from exudyn_crawler.model.inputs import Inputs
from exudyn_crawler.model.markers import Markers
from exudyn_crawler.model.rows import JointRows, gap_rate

SETTLING = 2e-3
"""s in which an idler comes to rest at a stop that it meets: its row keeps its speed there, too. A row of its
place alone would throw it back and forth by forces that grow as steps become shorter."""


class Recoils(NamedTuple):
    """Recoil springs, each on the row of a bearing along the frame; k of them.

    A row of a bearing with compliance is that of a spring without stops: its gap counts from where the spring
    is free. How far the spring gives way, ``s = c (F - F0) - c d ds/dt`` with the push F of the chain, the
    compliance c and the damping d, is at least nothing and at most the stroke. Where it is between these the
    row stays; else a stop holds the idler, at which ``s + SETTLING ds/dt`` is nothing, or the stroke.
    """

    rows: Ints1  # (k,): written by the pins
    preload: Floats1  # (k,): N
    compliance: Floats1  # (k,): m/N
    stroke: Floats1  # (k,): m


@inner
def write_rows(
    recoils: Recoils,
    bodies: Bodies,
    markers: Markers,
    state: FloatArray,
    multipliers: FloatArray,
    inputs: Inputs,
    weights: Weights,
    rows: JointRows,
) -> None:
    """Turn the rows of springs that are at a stop, which are written, into those of stops."""
    for k in range(recoils.rows.shape[0]):
        row = recoils.rows[k]
        # the multiplier is the push with the other sign
        excess = -multipliers[row] - recoils.preload[k]
        back = recoils.compliance[k] * excess + rows.relaxation[row] * gap_rate(bodies, rows, row, state)
        if 0.0 < back < recoils.stroke[k]:
            continue
        rows.gap[row] += recoils.preload[k] * recoils.compliance[k]
        if back > 0.0:
            rows.gap[row] += recoils.stroke[k]
        rows.share[row] = 0.0
        rows.relaxation[row] = SETTLING
