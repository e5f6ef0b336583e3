"""Table and figure of modes."""

from itertools import pairwise

import numpy as np
import pytest

from exudyn_crawler import Case
from exudyn_crawler.run.solve.track_modes import track_modes
from exudyn_crawler.views.mode_shapes import mode_figure, mode_table

pytestmark = pytest.mark.simulation


@pytest.fixture(scope="module")
def case():
    case = Case.translation()
    return case.with_(contact=case.contact.with_(static_friction=0.3, dynamic_friction=0.3))


@pytest.fixture(scope="module")
def modes(case):
    return track_modes(case, 0.2)


def test_the_table_names_the_least_stable_modes_first(modes):
    table = mode_table(modes, 4)
    assert list(table["mode"]) == [1, 2, 3, 4]
    assert table["growth rate, 1/s"].is_monotonic_decreasing
    first = modes["shape"].sel(mode=1)
    assert table["z"][0] == pytest.approx(float(np.abs(first.sel(coordinate="z")).max()))
    assert table["roll"][0] == pytest.approx(0.0, abs=1e-6)
    most = np.abs(first.sel(coordinate="z", shoe=table["shoe"][0]))
    assert float(most) == pytest.approx(table["z"][0])


def test_shoes_stay_joined_in_the_figure(case, modes):
    """Pins of neighbours meet to first order: to the square of the drawn pitch."""
    ax = mode_figure(modes, case, (1,)).axes[0]
    pins = [line.get_xydata() for line in ax.lines if line.get_marker() == "o"]
    assert len(pins) == 2 * case.track.shoe_count
    for rear, front in pairwise(pins[: case.track.shoe_count]):
        # two arms of 0.35 m, tilted by a motion of 0.1 m at the end of 0.315 m
        assert np.abs(rear[0] - front[1]).max() < 2 * 0.35 * 0.5 * (0.1 / 0.315) ** 2
    still = [line.get_xydata() for line in ax.lines if line.get_color() == "0.75"]
    assert len(still) == case.track.shoe_count
    assert "growth rate +" in ax.get_title(loc="left")
