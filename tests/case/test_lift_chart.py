"""Front and COM of a machine from its lift chart, against a chart of a known machine and a maker's."""

import pytest

from exudyn_crawler.errors import ParameterError
from exudyn_crawler.machines import read_case
from exudyn_crawler.machines.datasheet import library
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.lift_chart import com_ahead, fit_of
from exudyn_crawler.machines.datasheet.sheet import Datasheet, LiftChart


def chart_of(front, moment, line, radii, share=0.75):
    """Chart of a machine whose front and moment are known."""
    loads = [share * (moment - front * radius) / (radius - line) for radius in radii]
    points = [{"radius": radius, "load": load} for radius, load in zip(radii, loads, strict=True)]
    return LiftChart(points=points, tipping_share=share)


def test_front_and_com_of_a_chart_are_those_of_the_machine_that_it_is_of():
    fit = fit_of(chart_of(2.5e3, 70e3, 1.3, [4.0, 6.0, 8.0], 0.8), 1.3)
    assert fit.front == pytest.approx(2.5e3)
    assert fit.moment == pytest.approx(70e3)
    assert fit.error < 1e-9
    # 35 t with the front at the axis: x = 1.3 - 70 / 35; at 5 m it brings 2.5 t x 5 m
    assert com_ahead(fit, 35e3, 1.3, 0.0) == pytest.approx(-0.7)
    assert com_ahead(fit, 35e3, 1.3, 5.0) == pytest.approx(-0.7 + 12.5 / 35.0)


def test_komatsu_pc300lc_has_a_front_of_two_tonnes_and_its_com_behind():
    sheet = read_case(library.machines()["pc300lc"]).datasheet
    fit = fit_of(sheet.lift_chart, 0.5 * sheet.gauge)
    assert fit.front == pytest.approx(2.10e3, rel=0.01)
    assert fit.moment == pytest.approx(65.7e3, rel=0.005)
    assert fit.error < 0.0065
    assert com_ahead(fit, sheet.operating_weight, 0.5 * sheet.gauge, 0.0) == pytest.approx(-0.56, abs=0.005)
    case = derived(sheet).case
    ahead = sum(part.mass * part.com[0] for part in case.gear.frame_parts) / sheet.operating_weight
    assert ahead == pytest.approx(com_ahead(fit, sheet.operating_weight, 0.5 * sheet.gauge, 0.6 * 9.1))


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ([(1.0, 3e3), (6.0, 2e3)], "lift_chart has a load at 1 m, within the tipping line 1.29 m"),
        ([(5.0, 2e3), (6.0, 4e3)], "lift_chart gives a front of -"),
    ],
)
def test_charts_that_are_of_no_machine_are_refused(points, words):
    chart = LiftChart(points=[{"radius": radius, "load": load} for radius, load in points])
    sheet = Datasheet(
        operating_weight=35e3, gauge=2.59, length_on_ground=4.0, shoe_width=0.6, lift_chart=chart
    )
    with pytest.raises(ParameterError, match=words):
        derived(sheet)
