"""Loads of a history as coordinates of static fields."""

import numpy as np
import pytest

from exudyn_crawler import simulate
from exudyn_crawler.model.load_places import RAILS, shoe_fields
from exudyn_crawler.results.field_loads import field_loads
from exudyn_crawler.results.modal_coordinates import coordinates_and_momentum, stress_basis
from exudyn_crawler.results.rollers import roller_loads
from tests.rolled import small_flexible_case


@pytest.mark.simulation
def test_rollers_are_among_the_loads_of_a_rolled_shoe():
    """What the stations of both rails bear is what the rollers press with."""
    history = simulate(small_flexible_case(), 0.02)
    fields, basis = shoe_fields(history.case, rails=True), stress_basis(history)
    ends = np.cumsum(list(fields.families.values()))[:-1]
    _, momentum = coordinates_and_momentum(history, basis, 5)
    loads = field_loads(history, fields, basis.whole, momentum, 5)
    own = dict(zip(fields.families, np.split(loads, ends, axis=1), strict=True))[RAILS]
    pressed = roller_loads(history, 5).force.sum(("roller", "rail")).values
    assert np.abs(pressed).max() > 1e5
    np.testing.assert_allclose(own.reshape(len(own), -1, 3).sum(axis=1), pressed, atol=1e-6)
