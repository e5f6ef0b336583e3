"""Force elements as rows: two bodies, how their coordinates move the element, its wrench and its tangent.

An element sees its bodies through a few numbers: the motion of the first body's side of it against the other
side. Its wrench is conjugate to these, so that one Jacobian J makes generalized forces ``J^T w`` of the
wrench and a matrix ``J^T K J`` of its tangent. Residual and matrix know nothing else of it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.ground.rotations import FloatArray

IntArray = NDArray[np.int64]


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


class ForceRows(NamedTuple):
    """Elements of one kind with r rows each, as many as act at a state; m modes of a flexible body.

    Attributes
    ----------
    bodies : array (elements, 2)
        Numbers of the bodies; -1 where there is no second one.
    unit : array (elements,)
        Unit of the terrain on the other side, -1 for none.
    wrench : array (elements, r)
        On the first body.
    tangent : array (elements, r, r)
        Weighted derivative of the negative wrench, which is in the residual, by the motions and their rates.
    jacobian : array (elements, 2, r, 6 + m)
        The motions by the coordinates of both bodies.
    unit_jacobian : array (elements, r, 2)
        The motions by heave and tilt of the unit.
    """

    bodies: IntArray
    unit: IntArray
    wrench: FloatArray
    tangent: FloatArray
    jacobian: FloatArray
    unit_jacobian: FloatArray

    @classmethod
    def allocate(cls, elements: int, rows: int, modes: int) -> "ForceRows":
        """Workspace for so many elements."""
        return cls(
            np.full((elements, 2), -1),
            np.full(elements, -1),
            np.zeros((elements, rows)),
            np.zeros((elements, rows, rows)),
            np.zeros((elements, 2, rows, 6 + modes)),
            np.zeros((elements, rows, 2)),
        )
