"""The coarse shoe against CalculiX 2.20, whose numbers `calculix_reference.py` makes."""

import json
from collections.abc import Callable

import numpy as np
import pytest

import fem
from fem.stress import von_mises
from tests.fem.calculix_reference import REFERENCE, pull_forces, roller_forces


@pytest.mark.simulation
def test_first_twenty_elastic_frequencies(shoe: fem.ElasticBody) -> None:
    reference = json.loads(REFERENCE.read_text())
    assert reference["mesh"] == shoe.mesh.digest
    found = shoe.natural_frequencies(26)[6:]
    np.testing.assert_allclose(found, reference["frequencies"][6:], rtol=1e-3)


@pytest.mark.simulation
@pytest.mark.parametrize(
    ("load", "stress"), [(pull_forces, "stress"), (roller_forces, "roller stress")], ids=["bores", "roller"]
)
def test_von_mises_stress_away_from_the_bores(
    shoe: fem.ElasticBody, load: Callable[[fem.ElasticBody], np.ndarray], stress: str
) -> None:
    reference = json.loads(REFERENCE.read_text())
    displacement = shoe.displacement_under(load(shoe).reshape(-1, 1)).reshape(-1, 3, 1)
    found = von_mises(shoe.stress(displacement, np.array(reference["nodes"]))[:, :, 0])
    expected = von_mises(np.array(reference[stress]))
    # six digits in CalculiX's file
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-5 * expected.max())
