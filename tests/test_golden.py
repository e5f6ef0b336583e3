"""Kept numbers of short runs; `tests/golden.py` says when they may be renewed."""

import json

import numpy as np
import pytest

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
