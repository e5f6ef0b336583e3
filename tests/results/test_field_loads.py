"""Loads of a history as coordinates of static fields."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_crawler import simulate
from exudyn_crawler.model.load_places import RAILS, shoe_fields
from exudyn_crawler.results.loads.actions import OverRectangle, actions
from exudyn_crawler.results.loads.field_loads import field_loads, loads_by_kind
from exudyn_crawler.results.loads.modal_coordinates import coordinates_and_momentum, stress_basis
from exudyn_crawler.results.loads.rollers import roller_loads
from tests.rolled import small_flexible_case


@pytest.mark.slow
def test_rollers_are_among_the_loads_of_a_rolled_shoe():
    """What the stations of both rails bear is what the rollers press with."""
    history = simulate(small_flexible_case(), 0.02)
    fields, basis = shoe_fields(history.case, rails=True).fields, stress_basis(history)
    ends = np.cumsum(list(fields.families.values()))[:-1]
    _, momentum = coordinates_and_momentum(history, basis, 5)
    loads = field_loads(fields, loads_by_kind(history, fields, basis.whole, momentum, 5, actions(history, 5)))
    own = dict(zip(fields.families, np.split(loads, ends, axis=1), strict=True))[RAILS]
    pressed = roller_loads(history, 5).force.sum(("roller", "rail")).values
    assert np.abs(pressed).max() > 1e5
    np.testing.assert_allclose(own.reshape(len(own), -1, 3).sum(axis=1), pressed, atol=1e-6)


def test_a_unit_that_a_shoe_never_touches_loads_nothing(flexible_run):
    """Of a part of a run, in which the shoe stood on other units before."""
    history = flexible_run[0]
    fields, basis = shoe_fields(history.case).fields, stress_basis(history)
    _, momentum = coordinates_and_momentum(history, basis, 7)
    found = actions(history, 7)
    place, entry = next((k, one.entry) for k, one in enumerate(found) if isinstance(one.entry, OverRectangle))
    never = replace(found[place], entry=replace(entry, pressed=np.zeros_like(entry.pressed)))
    loads = []
    for acting in ([*found[:place], never, *found[place + 1 :]], [*found[:place], *found[place + 1 :]]):
        by_kind = loads_by_kind(history, fields, basis.whole, momentum, 7, acting)
        loads.append(field_loads(fields, by_kind))
    np.testing.assert_array_equal(*loads)
