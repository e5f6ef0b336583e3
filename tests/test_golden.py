"""Kept numbers of short runs; `tests/golden.py` says when they may be renewed."""

import json

import numpy as np
import pytest

from exudyn_crawler.results.balance import energy_balance, frame_imbalance
from exudyn_crawler.run.solve.rest import RESIDUAL
from tests import golden

pytestmark = pytest.mark.simulation

TOLERANCE = 1e-5
"""Of a variable's greatest magnitude: rounding differs between processors and grows in slip."""


@pytest.mark.parametrize("name", list(golden.CASES))
def test_short_runs_keep_their_numbers(name):
    kept = json.loads(golden.KEPT.read_text(encoding="utf-8"))[name]
    found = golden.run(name)
    assert found.keys() == kept.keys()
    for variable, values in kept.items():
        # forces below what the search for rest leaves out of balance have no digits to keep
        least = RESIDUAL / TOLERANCE if variable.endswith(("force", "torque")) else 1e-6
        scale = max(abs(values[0]), least)
        np.testing.assert_allclose(
            found[variable], values, rtol=0.0, atol=TOLERANCE * scale, err_msg=variable
        )


@pytest.mark.parametrize("name", ["closed", "machine", "machine on sand", "arms", "bogies"])
def test_energy_and_momentum_of_machines_are_balanced(name):
    """The work of the drive, and of a drawbar, is stored or taken; the frame's weight is carried."""
    history = golden.history_of(name)
    balance = energy_balance(history)
    supplied = np.abs(balance.drive.values).max()
    if history.has("drawbar_pull"):
        supplied += np.abs(balance.drawbar.values).max()
    assert np.abs(balance.imbalance.values).max() < 1e-3 * supplied
    # accelerations of bogies are differences of their angles
    imbalance = frame_imbalance(history).isel(time=slice(5, -5))
    weight = history.case.gear.carried_mass * history.case.gravity
    for freedom in ("travel", "heave"):
        assert np.abs(imbalance[freedom].values).max() < 1e-3 * weight, freedom


def test_no_term_of_arms_and_drawbar_could_be_left_out():
    balance = energy_balance(golden.history_of("arms")).isel(time=-1)
    for term in ("arm_springs", "arm_damping", "drawbar"):
        assert abs(float(balance[term])) > 2.0 * abs(float(balance.imbalance)), term
