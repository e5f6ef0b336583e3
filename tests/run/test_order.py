"""Order of convergence of smooth motions: two, as that of the generalized-alpha method."""

import numpy as np
import pytest

from exudyn_crawler import Case
from exudyn_crawler.model.state import StateLayout
from studies import order
from tests.rolled import small_case

pytestmark = pytest.mark.simulation

RATES = ("coordinates", "coordinates rate")


@pytest.mark.parametrize("radius", order.RADII)
@pytest.mark.parametrize(
    ("make", "length", "steps", "parts"),
    [
        # steps of 1 ms and 0.5 ms differ by ten times as much of multipliers as Newton's residual leaves
        (Case.translation, 0.16, (40, 80, 160), (*RATES, "multipliers")),
        (small_case, 0.08, (80, 160, 320), RATES),
        pytest.param(Case.closed, 0.08, (40, 80, 160), RATES, marks=pytest.mark.slow),
    ],
    ids=["dragged", "rolled", "closed"],
)
def test_halving_the_step_quarters_the_error(make, length, steps, parts, radius):
    states, layout = order.states_at_end(make(), length, steps, radius)
    for part in parts:
        assert order.orders(states, layout, part) == pytest.approx([2.0], abs=0.1), part


def test_ground_of_cells_is_of_first_order():
    states, layout = order.states_at_end(
        order.MOTIONS["closed on hard floor"].make(), 0.04, (20, 40, 80), 0.6
    )
    assert order.orders(states, layout, "coordinates rate") == pytest.approx([1.0], abs=0.2)


def test_orders_are_those_of_a_known_error():
    """Of the error 3 h^2 beside the part with 5 h."""
    layout = StateLayout(shoes=0, terrain=1, multipliers=(("drive", 1),))
    steps = np.array([0.4, 0.2, 0.1, 0.05])
    states = np.column_stack((np.ones(4), 1.0 + 3.0 * steps**2, *np.zeros((2, 4)), 2.0 + 5.0 * steps))
    assert order.orders(states, layout, "coordinates") == pytest.approx([2.0, 2.0])
    assert order.orders(states, layout, "multipliers") == pytest.approx([1.0, 1.0])


def test_an_unknown_motion_is_refused():
    with pytest.raises(ValueError, match=r"motions must be among dragged.* got walked"):
        order.study(names=["walked"])
