"""Flutter of an uneven track on rolling units: growth of its least stable swing by unevenness.

The law of a pair is not conservative. An underside has depth d, roll a and width W. Its penetration is
``d + a**2 W**2 / (12 d)``, and its force acts ``a W**2 / (12 d)`` beside the middle. Heave and roll of a
rolled shoe couple more in one direction than in the other. Beyond a threshold their swings feed each other.
Here the equations of the whole track are linearized about its equilibrium without friction.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
import pandas as pd
import scipy.linalg

from exudyn_crawler import Case, Shoe
from exudyn_crawler.case.parameters.contact import PairContact
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from studies.sliding import LinearTrack, derivative, eigenmodes

UNEVENNESS = (0.0, 0.05, 0.1, 0.12, 0.14, 0.16, 0.17, 0.18, 0.2, 0.25, 0.3)  # m
STEP = 1e-7
"""Step of central differences, m, rad and their rates: far below the 0.1 mm of the contact's damping law."""


def swings(case: Case) -> np.ndarray:
    """Return the `eigenmodes` eigenvalues of a rigid track at rest without friction, its front shoe held."""
    contact = case.part(PairContact).with_(static_friction=0.0, dynamic_friction=0.0)
    case = case.with_(contact=contact)
    system = compiled_system(case)
    n = system.layout.coordinate_count
    state = np.zeros((3, n))
    state[0] = static_equilibrium(case)
    inputs = system.inputs(0.0)._replace(active=np.array([1.0, 0.0]), speeds=np.zeros(2))

    def residual(values: np.ndarray, row: int, multipliers: np.ndarray) -> np.ndarray:
        moved = state.copy()
        moved[row] = values
        return system.residual(moved, inputs, multipliers)[:n]

    none = np.zeros(len(system.multipliers))
    force = residual(state[0], 0, none)
    directions = np.column_stack([residual(state[0], 0, unit) - force for unit in np.eye(len(none))])
    holding = np.linalg.lstsq(directions, -force, rcond=None)[0]
    by_row = (partial(residual, row=row, multipliers=holding) for row in range(3))
    by_place, by_rate, mass = (derivative(function, state[row], STEP) for row, function in enumerate(by_row))
    lengths = np.linalg.norm(directions, axis=0)
    free = scipy.linalg.null_space((directions[:, lengths > 0.0] / lengths[lengths > 0.0]).T)
    m, c, k = (free.T @ matrix @ free for matrix in (mass, by_rate, by_place))
    return eigenmodes(LinearTrack(m, c, k, free))[0]


def flutter(unevenness: Sequence[float] = UNEVENNESS) -> pd.DataFrame:
    """Tabulate the least stable swing of the straight track by the unevenness of its shoes.

    Columns unevenness (m), roll of the shoes at rest (rad), growth (1/s) and frequency (Hz).
    """
    rows = []
    for e in unevenness:
        case = Case.translation().with_(shoe=Shoe.uneven(e))
        values = swings(case)
        worst = values[values.imag > 1.0][0]
        roll = static_equilibrium(case)[: 6 * case.track.shoe_count].reshape(-1, 6)[:, 3]
        rows.append((e, np.abs(roll).mean(), worst.real, worst.imag / (2.0 * np.pi)))
    return pd.DataFrame(rows, columns=["unevenness", "roll", "growth", "frequency"])


if __name__ == "__main__":
    print(flutter().to_string(index=False, float_format=lambda value: f"{value:.4g}"))
