"""Order of convergence of smooth motions: two, as that of the generalized-alpha method."""

import numpy as np
import pytest

from exudyn_crawler import Case, StepProfile
from exudyn_crawler.run.solve.simulation import set_times, solver_settings, started
from tests.rolled import small_case

pytestmark = pytest.mark.simulation

SLOW = StepProfile(times=(0.0, 1.0), values=(0.0, 0.1))
"""m/s: the drive's ramp goes on over the whole motion."""
BEGIN = 0.1
"""Time after which the motion is compared, s: what is left of the search for rest has died away."""
RATES = ("coordinates", "coordinates rate")


def ends(case, length, steps):
    """States at the end of a motion from `BEGIN`, one for each number of steps, and their layout."""
    # the least residual that rounding lets Newton's method reach: what it leaves is 2 N of multipliers,
    # a tenth of what steps of 1 ms and 0.5 ms differ by
    case = case.with_(drive=case.drive.with_(speed=SLOW), solver=case.solver.with_(residual=1e-6))
    system = started(case, progress=False)

    def go_on(start, end, step):
        settings = solver_settings(case.solver)
        settings.timeIntegration.generalizedAlpha.computeInitialAccelerations = start == 0.0
        system.solve(
            settings, set_times(settings, case.solver.with_(step=step, output_interval=1.0), start, end)
        )
        return system.state()

    begin = go_on(0.0, BEGIN, 5e-4)
    found = []
    for count in steps:
        system.set_state(begin)
        found.append(go_on(BEGIN, BEGIN + length, length / count))
    return found, system.layout


@pytest.mark.parametrize("radius", [0.6, 0.9])
@pytest.mark.parametrize(
    ("make", "length", "steps", "parts"),
    [
        (Case.translation, 0.16, (40, 80, 160), (*RATES, "multipliers")),
        (small_case, 0.08, (80, 160, 320), RATES),
        pytest.param(Case.closed, 0.08, (40, 80, 160), RATES, marks=pytest.mark.slow),
    ],
    ids=["dragged", "rolled", "closed"],
)
def test_halving_the_step_quarters_the_error(make, length, steps, parts, radius):
    case = make()
    states, layout = ends(case.with_(solver=case.solver.with_(spectral_radius=radius)), length, steps)
    coarse, fine = np.diff(states, axis=0)
    for part in parts:
        ratio = np.linalg.norm(layout.part(coarse, part)) / np.linalg.norm(layout.part(fine, part))
        assert np.log2(ratio) == pytest.approx(2.0, abs=0.1), part
