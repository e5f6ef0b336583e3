"""Layouts of the numbers of points on cells, and of the shoes' frames: meaning of each row or column."""

from typing import NamedTuple

from exudyn_crawler.ground import columns
from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.frames import Frame, Matrix, Vector, along, turned
from exudyn_crawler.ground.packed import FloatArray

BLOCK = 64
"""Number of points of a shoe in one block, with a row for each number: processors take several points at
once."""


class PointRows(NamedTuple):
    """First rows of the numbers of a block of points."""

    place: columns.Triple  # in the shoe's frame, m
    normal: columns.Triple  # of the cell
    ground: columns.Number  # distance of the cell's plane from the origin along its normal, m
    before: columns.Triple  # the same place at the last accepted step, m, global
    deepest: columns.Number  # of the cell's memory, like the next four: greatest sinkage, m
    pressure: columns.Number  # Pa, there
    prepared: columns.Pair  # see `Probe.prepared`
    shear: columns.Triple  # Pa
    mobilized: columns.Number


class TrialColumns(NamedTuple):
    """First columns of a point's trial memory, and of the normal traction on the shoe."""

    deepest: columns.Number  # m
    pressure: columns.Number  # Pa
    shear: columns.Pair  # along x and y, Pa
    mobilized: columns.Number
    traction: columns.Number  # Pa


class BlockRows(NamedTuple):
    """First rows of the workspace of a block."""

    depth: columns.Number  # like the next three: see `Probe`
    rate: columns.Number
    slip: columns.Triple
    velocity: columns.Triple
    arm: columns.Triple  # places of the points from their shoe's origin, m, global
    force: columns.Triple  # N
    normal: columns.Number  # like the next eight: see `Response`
    shear: columns.Triple
    drag: columns.Number
    by_depth: columns.Number
    by_rate: columns.Number
    tangential_by_depth: columns.Triple
    along: columns.Number
    across: columns.Number
    direction: columns.Triple
    slopes: columns.Matrix  # see `ShoePoints.slopes`
    again: columns.Number  # points at which the law is evaluated again


class FrameColumns(NamedTuple):
    """First columns of a frame, global."""

    r: columns.Triple  # m
    R: columns.Matrix  # row by row
    v: columns.Triple  # m/s
    omega: columns.Triple  # rad/s


class BentRows(NamedTuple):
    """First rows of points' motion by the modes of flexible shoes, in the shoes' axes."""

    moved: columns.Triple  # m
    rate: columns.Triple  # m/s


POINT = columns.columns_of(PointRows)
TRIAL = columns.columns_of(TrialColumns)
ROW = columns.columns_of(BlockRows)
IN_FRAME = columns.columns_of(FrameColumns)
BENT = columns.columns_of(BentRows)
FRAME = columns.width_of(FrameColumns)
"""Number of columns of a frame."""
POINT_WIDTH = columns.width_of(PointRows)
TRIAL_WIDTH = columns.width_of(TrialColumns)
BLOCK_WIDTH = columns.width_of(BlockRows)
BENT_WIDTH = columns.width_of(BentRows)


@inner
def triple(row: FloatArray, first: int) -> Vector:
    """Return three numbers of a row, starting at a column."""
    return row[first], row[first + 1], row[first + 2]


@inner
def triple_of(rows: FloatArray, first: int, k: int) -> Vector:
    """Return three numbers of column k, starting at a row."""
    return rows[first, k], rows[first + 1, k], rows[first + 2, k]


@inner
def frame_at(row: FloatArray) -> Frame:
    """Return the frame in a row (FRAME,)."""
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
