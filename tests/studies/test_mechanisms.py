"""Known motions: the pendulum, the N-four-bar through its singular position, a spinning ring."""

import numpy as np
import pytest

from studies import mechanisms

pytestmark = pytest.mark.simulation


def by_quantity(found):
    """Computed and known values by their quantities."""
    return {row.quantity: (row.found, row.known) for row in found}


def test_the_pendulum_swings_by_the_elliptic_function():
    found = by_quantity(mechanisms.pendulum(time=5.0, h=2e-3))
    period, known = found["period"]
    assert period == pytest.approx(known, rel=2e-5)
    # the error of the period, 1e-5 of it, over two periods at up to 4.4 m/s
    assert 1e-5 < found["greatest error of position in 5 s"][0] < 3e-4
    assert found["greatest change of energy"][0] < 1e-4 * mechanisms.GRAVITY


def test_the_error_of_the_pendulum_is_of_second_order():
    errors = [
        by_quantity(mechanisms.pendulum(3.0, h))["greatest error of position in 3 s"][0] for h in (4e-3, 2e-3)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.05)


def test_the_n_four_bar_passes_its_singular_position():
    """Twice a turn, and stays on its branch: its level bars stay level."""
    found = by_quantity(mechanisms.n_four_bar(time=4.0, h=2e-3))
    turns, known = found["turns"]
    assert known > 2.0
    assert turns == pytest.approx(known, abs=1e-5)
    assert found["greatest error of the tip in 4 s"][0] < 5e-4
    assert found["greatest change of energy"][0] < 5e-3
    assert found["greatest tilt of level bars"][0] < 1e-9


def test_a_spinning_ring_has_the_tension_of_its_polygon():
    found = by_quantity(mechanisms.spinning_ring())
    mean, known = found["tension, mean"]
    assert mean == pytest.approx(known, rel=1e-6)
    assert found["tension, farthest from the known one"][0] == pytest.approx(known, rel=1e-4)
    # the load of one link between two pins, from its acceleration
    link = mechanisms.ring(24)[0][1]
    radius = 0.5 * mechanisms.PITCH / np.tan(np.pi / 24)
    assert link.mass * 5.0**2 / radius == pytest.approx(2.0 * known * np.sin(np.pi / 24))


@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
def test_a_chain_round_a_wheel_has_the_pull_of_its_speed_besides():
    (row,) = mechanisms.wheel(speed=12.0, steady=0.5)
    assert row.found == pytest.approx(row.known, rel=0.01)
    # that of the speed, m' v^2, is a fifth of it
    assert 0.2 * row.known < 18.02 / 0.154 * 12.0**2


def test_an_impossible_motion_is_refused():
    with pytest.raises(RuntimeError, match=r"the step from .* s did not converge"):
        mechanisms.n_four_bar(time=10.0, h=5.0)
