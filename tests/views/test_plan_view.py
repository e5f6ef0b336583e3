"""Plan view of a short run."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from exudyn_crawler.views.placement import Pose
from exudyn_crawler.views.plan_view import PlanView
from tests.views.drawn import corners


def test_shoes_are_where_the_history_has_them(translation):
    now = translation.dataset.isel(time=-1)
    above = PlanView(Figure().subplots(), translation)
    above.show(now)
    underneath = np.array([[0.0, 0.0, -translation.case.shoe.com_height]])
    expected = [Pose.of(now, int(shoe)).place(underneath)[0, :2] for shoe in now.shoe.values]
    assert corners(above._shoes).mean(axis=1) == pytest.approx(np.array(expected), abs=1e-9)
    assert np.asarray(above.ground.get_array()) == pytest.approx(1e3 * now.unit_heave.values)
