"""Layouts of the numbers of points on cells, and of the shoes' frames: what stands in which row or column."""

from typing import NamedTuple

from exudyn_crawler.ground import columns
from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.frames import Frame, Matrix, Vector, along, turned
from exudyn_crawler.ground.packed import FloatArray

BLOCK = 64
"""Points of a shoe that stand together, a row for each number: processors take several at once."""


class PointRows(NamedTuple):
    """First rows of the numbers of a block of points."""

    place: columns.Triple  # in the shoe's frame, m
    normal: columns.Triple  # of the cell
    ground: columns.Number  # distance of the cell's plane from the origin along its normal, m
    before: columns.Triple  # where the place was when a step was last accepted, m, global
    deepest: columns.Number  # of the cell's memory, as are the next four: greatest sinkage, m
    pressure: columns.Number  # Pa, there
    prepared: columns.Pair  # see `Probe.prepared`
    shear: columns.Triple  # Pa
    mobilized: columns.Number


class TrialColumns(NamedTuple):
    """First columns of a point's memory on trial, and of the normal traction on the shoe."""

    deepest: columns.Number  # m
    pressure: columns.Number  # Pa
    shear: columns.Pair  # along x and y, Pa
    mobilized: columns.Number
    traction: columns.Number  # Pa


class BlockRows(NamedTuple):
    """First rows of the workspace of a block."""

    depth: columns.Number  # as are the next three: see `Probe`
    rate: columns.Number
    slip: columns.Triple
    velocity: columns.Triple
    arm: columns.Triple  # places of the points from their shoe's origin, m, global
    force: columns.Triple  # N
    normal: columns.Number  # as are the next eight: see `Response`
    shear: columns.Triple
    drag: columns.Number
    by_depth: columns.Number
    by_rate: columns.Number
    tangential_by_depth: columns.Triple
    along: columns.Number
    across: columns.Number
    direction: columns.Triple
    slopes: columns.Matrix  # see `ShoePoints.slopes`
    again: columns.Number  # points that the law is asked about again


class FrameColumns(NamedTuple):
    """First columns of a frame, global."""

    r: columns.Triple  # m
    R: columns.Matrix  # row by row
    v: columns.Triple  # m/s
    omega: columns.Triple  # rad/s


class BentRows(NamedTuple):
    """First rows of the motion of points by the modes of flexible shoes, shoes' axes."""

    moved: columns.Triple  # m
    rate: columns.Triple  # m/s


POINT = columns.columns_of(PointRows)
TRIAL = columns.columns_of(TrialColumns)
ROW = columns.columns_of(BlockRows)
IN_FRAME = columns.columns_of(FrameColumns)
BENT = columns.columns_of(BentRows)
FRAME = columns.width_of(FrameColumns)
"""Numbers of a frame."""
POINT_WIDTH = columns.width_of(PointRows)
TRIAL_WIDTH = columns.width_of(TrialColumns)
BLOCK_WIDTH = columns.width_of(BlockRows)
BENT_WIDTH = columns.width_of(BentRows)


@inner
def triple(row: FloatArray, first: int) -> Vector:
    """Return three numbers of a row from a column on."""
    return row[first], row[first + 1], row[first + 2]


@inner
def triple_of(rows: FloatArray, first: int, k: int) -> Vector:
    """Return three numbers of a column k from a row on."""
    return rows[first, k], rows[first + 1, k], rows[first + 2, k]


@inner
def frame_at(row: FloatArray) -> Frame:
    """Return a frame of its numbers (FRAME,)."""
    x = IN_FRAME.R
    return Frame(
        triple(row, IN_FRAME.r),
        (triple(row, x), triple(row, x + 3), triple(row, x + 6)),
        triple(row, IN_FRAME.v),
        triple(row, IN_FRAME.omega),
    )


@inner
def arm_of(points: FloatArray, bent: FloatArray, k: int, R: Matrix) -> Vector:
    """Return the arm from a shoe's origin to a point of a block, m, global."""
    return turned(R, along(triple_of(points, POINT.place, k), 1.0, triple_of(bent, BENT.moved, k)))
