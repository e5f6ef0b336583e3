"""Public measurements beside the program."""

import pytest

from studies import measurements
from studies.comparison import reported_values


def test_reported_pressures_are_those_of_the_tests():
    reported = reported_values("measured").set_index(["case", "quantity"])["value"]
    small = measurements.plates("small")
    for width in small.widths:
        pressure = measurements.measured_pressure(small.of(small.width == width))
        name = f"pressure below a {1e3 * width:.0f} mm plate"
        assert reported.xs(name, level="quantity").to_numpy() == pytest.approx(1e-3 * pressure, rel=1e-3)


def test_predicted_pressures_of_plates_are_those_that_the_page_has():
    table = measurements.compare_plates()
    ratios = {case: rows["ratio"].to_numpy() for case, rows in table.groupby("case")}
    assert ratios["law of the same plate"] == pytest.approx([1.11, 1.04, 1.10], abs=0.01)
    assert ratios["law of all plates"] == pytest.approx([1.53, 1.02, 0.82], abs=0.01)
    assert ratios["law of the same tests"] == pytest.approx([1.06, 1.02, 1.06], abs=0.01)
    assert (table["within"] == "").all()


def test_stress_in_the_subsoil_follows_the_load_and_not_the_pressure():
    trend = measurements.wheel_trend()
    assert trend.agrees, trend.here
