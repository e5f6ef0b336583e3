"""Friction of link pins: its law, the matrix of its rows, and the moments and energy of a run."""

import math
from functools import cache

import numpy as np
import pytest

from exudyn_crawler import Case, simulate
from exudyn_crawler.case.parameters.pin import LinkPin, PinLaw, kinds
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.joints.friction import pin_moment
from exudyn_crawler.results.balance import energy_balance
from tests import golden
from tests.model.both import compiled_matrix, residual_of

LAW = PinLaw(0.01, 0.02, 900.0, -0.1, 0.2)
"""Friction and a rubber bush together."""
RATES = np.array([-3.0, -0.02, -1e-3, 0.0, 1e-3, 0.02, 3.0])


def moment(law, angle, rate, force, resists=1.0):
    """Moment of a pin, N m."""
    return pin_moment(law, float(angle), float(rate), float(force), resists)[0]


def test_friction_never_adds_energy():
    """Moment less its spring's opposes the rate, whatever angle, force and rate."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        angle, rate, force = rng.normal(), rng.normal() * 10.0 ** rng.uniform(-4, 1), 1e5 * rng.random()
        assert (moment(LAW, angle, rate, force) - moment(LAW, angle, 0.0, force)) * rate > 0.0


def test_moment_of_a_mirrored_state_is_mirrored():
    law = LAW._replace(unloaded=0.0)
    for rate in RATES:
        assert moment(law, -0.3, -rate, 2e4) == -moment(law, 0.3, rate, 2e4)


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("angle", [-0.4, 0.25])
def test_derivatives_of_the_moment_are_its_differences(angle, rate):
    at = np.array([angle, rate, 3e4])
    found = pin_moment(LAW, *at.tolist(), 1.0)[1:]
    for k, step in enumerate((1e-6, 1e-7, 1e-1)):
        above, below = at.copy(), at.copy()
        above[k] += step
        below[k] -= step
        slope = (moment(LAW, *above) - moment(LAW, *below)) / (2.0 * step)
        # moments of 300 N m have 6e-14 N m of rounding, over a step of 1e-7
        assert found[k] == pytest.approx(slope, rel=1e-5, abs=2e-6)


def test_work_of_a_pin_that_turns_under_a_force_is_mu_r_force_times_angle():
    """At 0.5 rad/s, 50 times the rate of 0.7: less by 2e-4."""
    law = LinkPin(kind="greased", radius=0.03, friction_rate=0.01).law(0.2)
    angles = np.linspace(0.0, 0.6, 61)
    work = np.trapezoid([moment(law, angle, 0.5, 4e4) for angle in angles], angles)
    assert work == pytest.approx(0.12 * 0.03 * 4e4 * 0.6, rel=3e-4)


def test_rubber_bush_loses_what_its_loss_factor_says_at_any_rate():
    """In a cycle of amplitude a it loses pi eta k a^2, by the definition of the loss factor."""
    law = LinkPin(kind="rubber", stiffness=800.0, loss=0.2, friction_rate=1e-3).law(0.15)
    time = np.linspace(0.0, 2.0 * math.pi, 20001)
    for rate in (1.0, 10.0):
        angle, speed = 0.3 * np.sin(time), 0.3 * rate * np.cos(time)
        moments = [moment(law, *values, 0.0) for values in zip(angle, speed, strict=True)]
        loss = np.trapezoid(moments, angle)
        assert loss == pytest.approx(math.pi * 0.2 * 800.0 * 0.3**2, rel=2e-3)


def test_only_the_stiffness_acts_in_a_search_for_rest():
    assert moment(LAW, 0.2, 1.0, 5e4, resists=0.0) == pytest.approx(900.0 * 0.3)


def test_every_kind_has_a_range_and_a_source():
    for kind in kinds().values():
        assert kind.friction_low <= kind.friction <= kind.friction_high, kind.kind
        assert kind.loss_low <= kind.loss <= kind.loss_high, kind.kind
        assert kind.source
        assert kind.known in ("remembered", "project")
        assert LinkPin(kind=kind.kind).law(0.2).lever == pytest.approx(0.021 * kind.friction)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"friction": 0.1}, "greased, sealed"),
        ({"kind": "dry", "stiffness": 500.0}, "must go with kind 'rubber'"),
        ({"kind": "wet"}, "kind"),
    ],
)
def test_values_that_do_not_fit_a_kind_are_refused(values, words):
    with pytest.raises(ParameterError, match=words):
        LinkPin(**values)


def test_equations_of_exudyns_items_have_no_friction():
    with pytest.raises(ParameterError, match=r"track\.pin\.kind must be 'ideal'"):
        Case.translation().with_({"track.pin.kind": "dry", "formulation": "engine"})


CHAINS = {
    "open": Case.translation(),
    "closed": Case.closed(),
}


@pytest.mark.simulation
@pytest.mark.parametrize("name", CHAINS)
def test_matrix_has_the_derivatives_of_friction(name):
    """By rates of all shoes and by all multipliers, in the rows of friction, at a random state."""
    case = CHAINS[name].with_({"track.pin": LinkPin(kind="rubber", friction=0.3, stiffness=2e4, loss=0.2)})
    system = compiled_system(case)
    frictions = system.tables.joints.frictions
    assert len(frictions.pins) == len(case.gear.joints(case.track))
    rng = np.random.default_rng(3)
    n = system.layout.coordinate_count
    multipliers = 1e4 * rng.normal(size=system.tables.multipliers)
    q, q_t = np.zeros(n), 0.01 * rng.normal(size=n)
    rows = n + frictions.first + np.arange(len(frictions.pins))
    found = compiled_matrix(system, q, q_t, (0.0, 1.0, 0.0, False, 1.0), multipliers)[rows]
    for column in rng.choice(n, 12, replace=False):
        e = np.zeros(n)
        e[column] = 1e-7
        above = residual_of(system, q, q_t + e, None, multipliers)[rows]
        below = residual_of(system, q, q_t - e, None, multipliers)[rows]
        assert found[:, column] == pytest.approx((above - below) / 2e-7, rel=1e-5, abs=1e-2)
    for column in range(system.tables.multipliers):
        e = np.zeros(system.tables.multipliers)
        e[column] = 1.0
        above = residual_of(system, q, q_t, None, multipliers + e)[rows]
        below = residual_of(system, q, q_t, None, multipliers - e)[rows]
        assert found[:, n + column] == pytest.approx(0.5 * (above - below), rel=1e-5, abs=1e-7)


@cache
def rubbed():
    """Closed track of greased pins with a short start, as of the kept numbers."""
    make, duration = golden.CASES["closed"]
    return simulate(
        make().with_({"track.pin": LinkPin(kind="greased", friction_rate=0.01)}), duration, progress=False
    )


@pytest.mark.simulation
def test_moments_of_a_run_are_mu_r_times_the_force_of_each_pin():
    history = rubbed()
    case = history.case
    data = history.dataset
    links = case.gear.links(case.track) - 1
    axes = rotation_matrices(data["angles"].transpose("time", "shoe", "axis").values)[..., 1]
    across = axes[:, links[:, 0]]
    spin = data.angular_velocity.transpose("time", "shoe", "axis").values
    rate = np.sum((spin[:, links[:, 1]] - spin[:, links[:, 0]]) * across, axis=-1)
    force = data.joint_force.transpose("time", "joint", "axis").values
    radial = np.linalg.norm(force - np.sum(force * across, axis=-1)[..., None] * across, axis=-1)
    found = np.sum(data.joint_torque.transpose("time", "joint", "axis").values * across, axis=-1)
    law = case.track.pin.law(case.track.pitch)
    expected = law.lever * radial * rate / np.hypot(rate, law.fading)
    assert np.abs(expected).max() > 100.0
    # what Newton's method leaves of all equations, root mean square, may be in one of them
    left = case.solver.residual * math.sqrt(compiled_system(case).layout.equation_count)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=left)
    assert np.all(found * rate >= -1e-12)


@pytest.mark.simulation
def test_energy_of_a_run_with_friction_is_balanced():
    balance = energy_balance(rubbed())
    supplied = np.abs(balance.drive.values).max()
    assert np.abs(balance.imbalance.values).max() < 1e-3 * supplied
    taken = balance.pin_losses.values
    assert taken[-1] > 2.0 * np.abs(balance.imbalance.values).max()
