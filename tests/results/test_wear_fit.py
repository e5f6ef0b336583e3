"""Laws of wear, lives fitted to readings, and inspections: known answers."""

import numpy as np
import pytest

from exudyn_crawler.results.wear.inspections import read_inspections
from exudyn_crawler.results.wear.laws import PowerLaw, TwoRates
from exudyn_crawler.results.wear.life_fit import fit_by_run, fit_life, wear_coefficient
from exudyn_crawler.results.wear.parts import limit_fraction, parts

HEAD = "date,machine hours,propel hours,part,side,place,value in mm,links\n"


def test_komatsus_example_gives_its_hours():
    """KTPK 3-3: a bush 54 % worn after 2500 h; W = a x^2 gives 3402 h (its chart 3500 h)."""
    fit = fit_life(np.array([2500.0]), np.array([54.0]), PowerLaw(parts()["bush"].exponent))
    assert fit.life == pytest.approx(3402.0, abs=0.5)
    assert wear_coefficient(fit) == pytest.approx(54.0 / 2500.0**2)
    # one reading has no scatter
    assert np.isnan([fit.low, fit.high]).all()


@pytest.mark.parametrize("law", [PowerLaw(1.3), TwoRates(60.0, 3.0)])
def test_true_life_lies_in_the_band_nine_times_of_ten(law):
    rng = np.random.default_rng(7)
    hours = np.linspace(400.0, 2800.0, 6)
    count, life = 300, 4000.0
    fits = [fit_life(hours, law.percent(hours / life) + rng.normal(0.0, 2.0, 6), law) for _ in range(count)]
    inside = np.mean([fit.low <= life <= fit.high for fit in fits])
    # a binomial share has a standard deviation of 1.7 %
    assert 0.85 <= inside <= 0.95
    # a few per cent of scatter at 60 % worn give a life to a few per cent
    assert np.mean([fit.life for fit in fits]) == pytest.approx(life, rel=0.01)


def test_an_exponent_is_found_and_needs_four_inspections():
    hours = np.array([500.0, 1000.0, 1500.0, 2000.0, 2500.0])
    percent = PowerLaw(1.6).percent(hours / 3000.0) + np.array([0.3, -0.2, 0.1, -0.3, 0.2])
    fit = fit_life(hours, percent, None)
    assert fit.law.exponent == pytest.approx(1.6, abs=0.03)
    assert fit.low < 3000.0 < fit.high
    with pytest.raises(ValueError, match="at least 4 inspections at different hours, got 3"):
        fit_life(hours[:3], percent[:3], None)


def test_a_known_error_of_readings_gives_a_band_to_one_reading():
    fit = fit_life(np.array([1000.0]), np.array([40.0]), PowerLaw(1.0), error=2.0)
    half = 1.6449 * 2.0
    assert (fit.low, fit.high) == pytest.approx((1e5 / (40.0 + half), 1e5 / (40.0 - half)), rel=1e-4)


def test_readings_within_the_scatter_exclude_no_long_life():
    fit = fit_life(np.array([100.0, 200.0, 300.0]), np.array([2.0, -1.5, 1.0]), PowerLaw(1.0))
    assert np.isinf(fit.high)
    with pytest.raises(ValueError, match="must show wear"):
        fit_life(np.array([100.0]), np.array([0.0]), PowerLaw(1.0))


def test_two_rates_are_continuous_and_three_times_faster_below_the_case():
    law = TwoRates(60.0, 3.0)
    used = np.array([law.used(value) for value in (30.0, 60.0, 75.0, 90.0)])
    assert law.percent(used) == pytest.approx([30.0, 60.0, 75.0, 90.0])
    assert (used[2] - used[1]) / (used[1] - used[0]) == pytest.approx(15.0 / 3.0 / 30.0)
    assert law.percent(np.array(1.0)) == pytest.approx(100.0)


def test_two_runs_are_told_apart_only_if_their_shares_vary():
    straight = np.array([100.0, 200.0, 320.0, 380.0, 500.0])
    turning = np.array([10.0, 60.0, 70.0, 150.0, 160.0])
    hours = np.column_stack((straight, turning))
    noise = np.array([0.04, -0.03, 0.02, -0.04, 0.01])
    percent = PowerLaw(1.0).percent(straight / 1000.0 + turning / 250.0) + noise
    mixed = fit_by_run(hours, percent, PowerLaw(1.0), ("straight", "turning"))
    alone = mixed.life([1.0, 0.0]), mixed.life([0.0, 1.0])
    assert [fit.life for fit in alone] == pytest.approx([1000.0, 250.0], rel=0.01)
    assert all(fit.low < life < fit.high for fit, life in zip(alone, (1000.0, 250.0), strict=True))
    constant = np.column_stack((straight, 0.1 * straight))
    with pytest.raises(ValueError, match="cannot be told apart: their shares of the hours hardly vary"):
        fit_by_run(constant, percent, PowerLaw(1.0), ("straight", "turning"))


def test_a_known_error_of_readings_gives_the_band_of_each_run():
    """Wear of the power 1 is linear in the rates: their covariance is error^2 (H^T H)^-1 / 100^2."""
    hours = np.array([[100.0, 10.0], [200.0, 60.0], [320.0, 70.0], [380.0, 150.0]])
    rates = np.array([1.0 / 1000.0, 1.0 / 250.0])
    percent = PowerLaw(1.0).percent(hours @ rates)
    error = 2.0
    mixed = fit_by_run(hours, percent, PowerLaw(1.0), ("straight", "turning"), error)
    spread = 1.6449 * error / 100.0 * np.sqrt(np.diag(np.linalg.inv(hours.T @ hours)))
    for shares, rate, half in zip(np.eye(2), rates, spread, strict=True):
        life = mixed.life(shares)
        assert life.life == pytest.approx(1.0 / rate, rel=1e-6)
        assert life.low == pytest.approx(1.0 / (rate + half), rel=1e-3)
        assert life.high == pytest.approx(1.0 / (rate - half) if rate > half else np.inf, rel=1e-3)
        assert life.scatter == error


def test_limits_are_a_default_only_where_makers_agree():
    assert limit_fraction("pitch") == pytest.approx(0.0175, abs=1e-4)
    assert limit_fraction("grouser") == pytest.approx(-0.695, abs=1e-3)
    assert limit_fraction("roller") is None


def test_inspections_count_from_the_last_new_part(tmp_path):
    path = tmp_path / "seen.csv"
    path.write_text(
        HEAD + "2024-01-10,1000,80,pitch,right,,873,4\n"
        "2024-06-10,2000,160,bush,right,,turned,\n"
        "2025-01-10,3000,250,pitch,right,a,866,4\n"
        "2025-01-10,3000,250,pitch,right,b,868,4\n"
        "2025-01-10,3000,250,roller,left,3,178,\n"
        "2025-01-10,3000,250,roller,left,4,177,\n"
    )
    series = {one.name: one for one in read_inspections(path).series()}
    assert [*series] == ["right pitch", "left roller 3", "left roller 4"]
    pitch = series["right pitch"]
    assert pitch.turned
    assert pitch.hours("propel hours") == pytest.approx([90.0, 90.0])
    assert pitch.sizes == pytest.approx([0.2165, 0.2170])
    assert series["left roller 3"].hours("machine hours") == pytest.approx([3000.0])


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("2024-01-10,1000,80,pich,right,,873,4\n", "did you mean 'pitch'"),
        ("10.1.2024,1000,80,pitch,right,,873,4\n", "date must be as 2026-03-01"),
        ("2024-01-10,1000,80,pitch,middle,,873,4\n", "side must be right, left or empty"),
        ("2024-01-10,1000,80,pitch,right,,x,4\n", "value must be a number, 'new' or 'turned'"),
        ("2024-01-10,1000,80,pitch,right,,873,four\n", "links must be a number, got 'four'"),
        ("2024-01-10,1000,80,roller,right,,turned,\n", "only pitch and bush are turned"),
        ("2024-01-10,1000,80,bush,right,,70,4\n", "links are for a pitch"),
        (
            "2024-01-10,1000,80,bush,right,,70,\n2023-01-10,1100,90,bush,right,,70,\n",
            "machine hours must rise with the date",
        ),
        (
            "2024-01-10,1000,80,bush,right,,70,\n2024-03-10,1100,280,bush,right,,70,\n",
            "propel hours must not grow by more than machine hours",
        ),
    ],
)
def test_wrong_inspections_are_refused(tmp_path, rows, said):
    path = tmp_path / "seen.csv"
    path.write_text(HEAD + rows)
    with pytest.raises(ValueError, match=said):
        read_inspections(path)


def test_a_value_without_a_unit_is_refused(tmp_path):
    path = tmp_path / "seen.csv"
    path.write_text("date,machine hours,part,value\n2024-01-10,1000,bush,70\n")
    with pytest.raises(ValueError, match="column 'value': the unit is missing in its head"):
        read_inspections(path)
