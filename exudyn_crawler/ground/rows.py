"""Rows of force elements, and the weights of the derivatives in them.

A force element depends on its bodies through a few numbers: the motion of its side on the first body against
the other side. Its wrench is conjugate to these motions. One Jacobian J therefore makes generalized forces
``J^T w`` of the wrench and a matrix ``J^T K J`` of its tangent. Residual and matrix use nothing else of it.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.packed import Floats2, Floats3, Floats4, Ints1, Ints2


class Weights(NamedTuple):
    """Weights of the derivatives by coordinates, rates and accelerations.

    With `secant` the ratio of friction to slip is kept constant, not differentiated. Newton's method can
    cycle between the steep rise of the friction curve and its fall beyond; with the secant it converges, but
    more slowly. `level` turns the gap of a constraint on velocity into one of position.
    """

    position: float
    velocity: float
    acceleration: float
    secant: bool
    level: float


NO_DERIVATIVES = Weights(0.0, 0.0, 0.0, False, 1.0)
"""Weights that give forces without derivatives."""


class ForceRows(NamedTuple):
    """Elements of one kind with r rows each, at most as many as can act; m modes of a flexible body."""

    acting: Ints1  # (1,): number of those that act
    bodies: Ints2  # (elements, 2): numbers of the bodies; -1 where there is no second one
    unit: Ints1  # (elements,): unit of the terrain on the other side, -1 for none
    wrench: Floats2  # (elements, r): on the first body
    # (elements, r, r): weighted derivative of the negative wrench, which is in the residual, by the motions
    # and their rates
    tangent: Floats3
    jacobian: Floats4  # (elements, 2, r, 6 + m): the motions by the coordinates of both bodies
    unit_jacobian: Floats3  # (elements, r, 2): the motions by heave and tilt of the unit

    @classmethod
    def allocate(cls, elements: int, rows: int, modes: int) -> "ForceRows":
        """Return a workspace for at most `elements` elements."""
        return cls(
            acting=np.zeros(1, dtype=np.int64),
            bodies=np.full((elements, 2), -1),
            unit=np.full(elements, -1),
            wrench=np.zeros((elements, rows)),
            tangent=np.zeros((elements, rows, rows)),
            jacobian=np.zeros((elements, 2, rows, 6 + modes)),
            unit_jacobian=np.zeros((elements, rows, 2)),
        )
