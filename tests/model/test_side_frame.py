"""Equations of a side frame against differences of their own residual."""

import numpy as np
import pytest

from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from tests.model.both import check_matrix_at_rest, matrix_errors, residual_of
from tests.rolled import small_case, small_flexible_case

pytestmark = pytest.mark.simulation


@pytest.mark.parametrize(
    "case",
    [small_case(), pytest.param(small_flexible_case(), marks=pytest.mark.slow)],
    ids=["rigid", "flexible"],
)
def test_newtons_matrix_is_the_derivative_of_the_residual(case):
    """At rest, where what it leaves out is small; the frame's rows and columns are nearly exact."""
    check_matrix_at_rest(case, 6, 1e-4)


def test_pull_acts_on_frame_and_chain_alike():
    """A unit of pull: forward on the frame, in sum as much backward on the shoes, all at one place."""
    case = small_case()
    system, q = compiled_system(case), static_equilibrium(case)
    none = np.zeros(len(system.multipliers))
    unit = none.copy()
    unit[system.pin_rows] = -1e6
    base, pulled = (residual_of(system, q, 0.0 * q, multipliers=one) for one in (none, unit))
    forces = -(pulled - base)[: len(q)] / 1e6
    shoes = forces[: 6 * case.track.shoe_count].reshape(-1, 6)
    assert shoes[:, 0].sum() == pytest.approx(-1.0)
    assert np.count_nonzero(np.abs(shoes[:, 0]) > 1e-9) <= 2
    assert forces[-6] == pytest.approx(1.0)
    lever = case.gear.frame_start(case)[2] + q[-4] - (case.shoe.com_height + case.track.pin_height)
    assert -forces[-2] == pytest.approx(lever, abs=0.2)


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(small_case(), id="rigid"),
        pytest.param(small_flexible_case(), id="flexible", marks=pytest.mark.slow),
    ],
)
def test_resistance_of_wheels_takes_power_in_any_motion_and_is_none_at_rest(case):
    """Power of what it adds to the equations, by the rates of all coordinates; the drive is to travel."""
    resisting = compiled_system(case)
    free = compiled_system(case.with_({"gear.rolling_resistance": 0.0}))
    q = static_equilibrium(case)
    assert case.drive.speed.value(0.1) > 0.0
    rng = np.random.default_rng(5)
    powers = []
    for scale in np.repeat([0.0, 1e-4, 1e-2, 0.3], [1, 8, 8, 8]):
        rates = scale * rng.normal(size=len(q))
        state = np.stack((q, rates, np.zeros_like(q)))
        without, whole = (system.residual(state, system.inputs(0.1)) for system in (free, resisting))
        resistance = (without - whole)[: len(q)]
        powers.append(resistance @ rates)
        if not scale:
            assert not resistance.any()
    assert max(powers[1:]) < 0.0


def test_newtons_matrix_has_the_resistance_of_wheels_that_begin_to_roll():
    """Where it rises with the speed, and the frame goes alone."""
    case = small_case(rolling_resistance=0.1)
    q = static_equilibrium(case)
    rates = np.zeros(len(q))
    rates[-6] = 0.2 * case.gear.resistance_speed
    off = matrix_errors(compiled_system(case), q, rates)
    assert off.max() < 0.02
    assert off[-6:, -6:].max() < 1e-4
