"""What figures show of rollers and side frame is what the history of a short run holds."""

import numpy as np
import pytest

from exudyn_crawler.views.roller_figures import roller_figures
from exudyn_crawler.views.series import history_series
from tests.views.drawn import curves


def test_rolled_runs_offer_their_rollers_and_frame(rolled):
    found = history_series(rolled)
    assert found["roller force"].values["item"].values.tolist() == ["roller 1", "roller 2", "roller 3"]
    turned = found["angle of the side frame"]
    expected = np.degrees(rolled.side_frame_angles.sel(axis="y").values)
    assert (turned.unit, turned.values.axis.values.tolist()) == ("deg", ["roll", "pitch"])
    assert turned.values.sel(axis="pitch").values[:, 0] == pytest.approx(expected)


def test_dragged_runs_have_none_of_it(translation):
    assert not {one.group for one in history_series(translation).values()} & {"rollers", "side frame"}


def test_figures_draw_forces_on_both_sides_and_the_motion_of_the_frame(rolled):
    figures = roller_figures(rolled, (4, 5))
    assert set(figures) == {"roller force", "force of all rollers", "side frame"}
    forces = curves(figures["roller force"])
    both, right, left = (panel["roller 2"] for panel in forces.values())
    assert both == pytest.approx(right + left)
    assert left == pytest.approx(rolled.roller_force.sel(roller=2, rail="left", axis="z").values)
    shoes = curves(figures["force of all rollers"])["z force of all rollers in N"]
    assert list(shoes) == ["shoe 4", "shoe 5"]
    assert shoes["shoe 5"] == pytest.approx(rolled.rail_force.sel(shoe=5, axis="z").values)
    frame = curves(figures["side frame"])
    heave = rolled.side_frame_position.sel(axis="z").values
    assert frame["z way of the side frame in m"]["side frame"] == pytest.approx(heave - heave[0])
    assert frame["pull of the drive in N"]["side frame"] == pytest.approx(rolled.drive_pull.values)
