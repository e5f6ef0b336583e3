"""Rows of joints: the terms that constraints of any kind add to the equations, which use nothing else.

A constraint is a force and a moment on a body, or opposite ones on two. Its row of the Jacobian, over the
coordinates of a body, maps their rates to the rate of the gap, and its multiplier to generalized forces.
"""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.compiled import inner
from exudyn_crawler.ground.packed import FloatArray, Floats1, Floats2, Floats3, Floats4, Ints1, Ints2
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model.bodies import Bodies
from exudyn_crawler.model.inputs import Inputs

STIFFNESS = 1e9
"""Factor (N/m and N m/rad) from a gap of a constraint to a residual comparable with forces: about the force
per gap that closes it within a step of some ms for a shoe's mass."""

ALONG_JACOBIAN = -1
"""Flag instead of a row of directions: the multiplier acts along the Jacobian."""

ACTED_ON = 3
"""Largest number of bodies on which the multiplier of a row of directions acts."""


class Motion(NamedTuple):
    """Inputs of a joint's rows beside its bodies: state, multipliers, prescribed motion, and weights."""

    state: FloatArray  # (3, coordinates): coordinates, rates and accelerations
    multipliers: FloatArray  # (rows,): of all joints, N and N m
    inputs: Inputs
    weights: Weights


class JointRows(NamedTuple):
    """Constraints of all joints at a state, r of them; m modes of a flexible body; workspace.

    The residual of a row is ``scale gap + share multiplier``; if `relaxation` is not zero, `STIFFNESS` times
    `relaxation` times the rate of the gap is added. Its derivative by the coordinates is `slope` times the
    Jacobian, without that of the relaxation.
    """

    bodies: Ints2  # (r, 2): -1 for none; a constraint that does not act has none
    jacobian: Floats3  # (r, 2, 6 + m): of the gap, by the coordinates of both bodies
    gap: Floats1  # (r,): m or rad, m/s or rad/s of a constraint on speed, N m of a law
    scale: Floats1  # (r,)
    slope: Floats1  # (r,)
    share: Floats1  # (r,): zero, -`STIFFNESS` times the compliance, 1 where a law gives the multiplier
    relaxation: Floats1  # (r,): s
    directed: Ints1  # (r,): row of the next two, or `ALONG_JACOBIAN`
    acted_on: Ints2  # (d, ACTED_ON): bodies on which a multiplier acts that is not along its Jacobian
    directions: Floats3  # (d, ACTED_ON, 6 + m): generalized forces of a multiplier of 1
    # (t, 2) and (t, 2, 3, 3): bodies of pins, and derivatives of the moments of the pins' forces by the
    # bodies' angles
    turned: Ints2
    turning: Floats4
    # (k, 2) and (k, 3): rows of laws that depend on the force of a pin, each with the first row of that
    # force, and the derivatives of their residuals by its three multipliers
    loaded: Ints2
    by_load: Floats2
    scratch: Floats2  # (2, 6 + m)

    @classmethod
    def allocate(cls, rows: int, directed: int, turned: int, loaded: int, modes: int) -> "JointRows":
        """Return a workspace for `rows` rows.

        `directed` is the number of directions, `turned` that of pairs of rotating bodies, `loaded` that of
        rows that depend on a force.
        """
        width = 6 + modes
        return cls(
            bodies=np.full((rows, 2), -1),
            jacobian=np.zeros((rows, 2, width)),
            gap=np.zeros(rows),
            scale=np.zeros(rows),
            slope=np.zeros(rows),
            share=np.zeros(rows),
            relaxation=np.zeros(rows),
            directed=np.full(rows, ALONG_JACOBIAN),
            acted_on=np.full((directed, ACTED_ON), -1),
            directions=np.zeros((directed, ACTED_ON, width)),
            turned=np.full((turned, 2), -1),
            turning=np.zeros((turned, 2, 3, 3)),
            loaded=np.zeros((loaded, 2), dtype=np.int64),
            by_load=np.zeros((loaded, 3)),
            scratch=np.zeros((2, width)),
        )


@inner
def gap_rate(bodies: Bodies, rows: JointRows, r: int, state: FloatArray) -> float:
    """Return the rate (m/s or rad/s) of the gap of a constraint between two rigid bodies."""
    rate = 0.0
    for side in range(2):
        first = bodies.coordinate[rows.bodies[r, side]]
        for c in range(6):
            rate += rows.jacobian[r, side, c] * state[1, first + c]
    return rate
