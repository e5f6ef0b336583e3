"""Prescribed motion and loads over time: the papers' polynomials and their integrals."""

import math

import numpy as np
import pytest

from exudyn_crawler import Case, Drive, LoadCycle, Phase, StepProfile

EARLY = np.linspace(0.0, 5.0, 21)
LATE = np.linspace(5.0, 12.0, 15)


def test_speed_travel_and_acceleration_are_the_papers_polynomials_and_then_constant():
    speed = Drive.translation().speed
    assert speed.value(EARLY) == pytest.approx(0.012 * EARLY**2 - 0.0016 * EARLY**3, rel=1e-12)
    assert speed.value(LATE) == pytest.approx(np.full(15, 0.1), rel=1e-12)
    assert speed.integral(EARLY) == pytest.approx(0.004 * EARLY**3 - 0.0004 * EARLY**4, rel=1e-12)
    assert speed.integral(LATE) == pytest.approx(0.25 + 0.1 * (LATE - 5.0), rel=1e-12)
    assert speed.rate(EARLY) == pytest.approx(0.024 * EARLY - 0.0048 * EARLY**2, rel=1e-12, abs=1e-15)
    assert speed.rate(2.5) == pytest.approx(0.03, rel=1e-12)  # K-chapter eq. 29
    assert speed.rate(LATE) == pytest.approx(np.zeros(15), abs=1e-15)


def test_turn_rate_is_the_papers_polynomial_in_degrees():
    rate = Drive.turning().turn_rate
    assert np.degrees(rate.value(EARLY)) == pytest.approx(0.12 * EARLY**2 - 0.016 * EARLY**3, rel=1e-12)
    assert np.degrees(rate.value(LATE)) == pytest.approx(np.ones(15), rel=1e-12)
    assert math.degrees(rate.integral(10.0)) == pytest.approx(7.5, rel=1e-12)


def test_stress_paper_comes_to_rest():
    drive = Drive.to_rest()
    t = np.linspace(10.0, 15.0, 11)
    s = (t - 10.0) / 5.0
    assert drive.speed.value(t) == pytest.approx(0.1 - 0.1 * s**2 * (3 - 2 * s), rel=1e-12, abs=1e-15)
    assert drive.speed.integral(40.0) == pytest.approx(1.0, rel=1e-12)  # 0.25 + 0.5 + 0.25 m


def test_a_profile_is_constant_outside_its_times():
    profile = StepProfile(times=(1.0, 2.0, 4.0), values=(3.0, 5.0, -1.0))
    assert profile.value([0.0, 1.0, 2.0, 4.0, 9.0]).tolist() == [3.0, 3.0, 5.0, -1.0, -1.0]
    assert profile.value([1.5, 3.0]).tolist() == pytest.approx([4.0, 2.0], rel=1e-12)
    assert profile.integral(0.0) == pytest.approx(-3.0, rel=1e-12)
    assert profile.integral(5.0) == pytest.approx(4.0 + 4.0 - 1.0, rel=1e-12)
    constant = StepProfile.constant(7.5)
    assert constant.value([-1.0, 0.0, 100.0]).tolist() == [7.5, 7.5, 7.5]
    assert float(constant.rate(3.0)) == 0.0
    assert constant.integral(4.0) == pytest.approx(30.0, rel=1e-12)


def test_loads_follow_steps_between_the_ends_of_phases():
    cycle = LoadCycle(
        phases=(
            Phase(name="propel", end=15.0, loads=(386.4e3, 386.4e3)),
            Phase(name="dig", end=22.5, loads=(384.0e3, 500.0e3)),
        )
    )
    assert cycle.loads([0.0, 15.0, 18.75, 22.5, 30.0]) == pytest.approx(
        np.array([[386.4e3] * 2, [386.4e3] * 2, [385.2e3, 443.2e3], [384e3, 500e3], [384e3, 500e3]]),
        rel=1e-12,
    )
    quarter = 386.4e3 + (500e3 - 386.4e3) * 0.25**2 * 2.5
    assert cycle.of_shoes[1].value(15.0 + 7.5 / 4) == pytest.approx(quarter, rel=1e-12)


def test_the_track_travels_only_while_driven():
    speed = StepProfile(times=(0.0, 0.05, 0.1, 0.15, 0.2), values=(0.0, 0.01, 0.0, 0.0, 0.02))
    case = Case.translation().with_(drive=Drive(speed=speed, on=((0.0, 0.05),)))
    assert case.outline(0.2)[0, 0] - case.outline(0.0)[0, 0] == pytest.approx(0.05 * 0.01 / 2)
