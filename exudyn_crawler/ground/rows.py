"""Rows of force elements, and the weights of the derivatives in them.

A force element sees its bodies through a few numbers: the motion of the first body's side of it against the
other side. Its wrench is conjugate to these, so that one Jacobian J makes generalized forces ``J^T w`` of the
wrench and a matrix ``J^T K J`` of its tangent. Residual and matrix know nothing else of it.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.packed import Floats2, Floats3, Floats4, Ints1, Ints2


class Weights(NamedTuple):
    """Weights of the derivatives by coordinates, rates and accelerations.

    With `secant` the ratio of friction to slip is kept as it is instead of derived: Newton's method can cycle
    between the steep rise of the friction curve and its fall beyond, and with the secant it converges more
    slowly, but does. `level` turns the gap of a constraint on velocity into one of position.
    """

    position: float
    velocity: float
    acceleration: float
    secant: bool
    level: float


NO_DERIVATIVES = Weights(0.0, 0.0, 0.0, False, 1.0)
"""Of forces alone."""


class ForceRows(NamedTuple):
    """Elements of one kind with r rows each, as many as act at a state; m modes of a flexible body."""

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
        """Workspace for at most so many elements."""
        return cls(
            acting=np.zeros(1, dtype=np.int64),
            bodies=np.full((elements, 2), -1),
            unit=np.full(elements, -1),
            wrench=np.zeros((elements, rows)),
            tangent=np.zeros((elements, rows, rows)),
            jacobian=np.zeros((elements, 2, rows, 6 + modes)),
            unit_jacobian=np.zeros((elements, rows, 2)),
        )
