"""Side view of short runs, on even and on uneven ground."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from exudyn_crawler import simulate
from exudyn_crawler.views.ground_figures import ground_figure
from exudyn_crawler.views.placement import shoe_forces, unloaded_level
from exudyn_crawler.views.side_view import DEPTH, SideView
from studies.grounds import STEP_HEIGHT, STEP_PLACE, uneven_case
from tests.views.drawn import corners

pytestmark = pytest.mark.simulation


@pytest.fixture(scope="module")
def step():
    return simulate(uneven_case("step"), 0.05)


def test_magnified_ground_lifts_the_shoes_with_it(translation):
    """Their depth in the ground is the same at every scale; the ground's own displacement is not."""
    now = translation.dataset.isel(time=-1)
    drawn = {}
    for scale in (1.0, 5.0):
        view = SideView(Figure().subplots(), translation, scale, force_scale=1e-6)
        view.show(now)
        shoes, ground = corners(view._shoes), corners(view._ground)
        surface = np.concatenate(ground[:, [3, 2]]).T
        depth = np.interp(shoes[:, 0, 0], *surface) - shoes[:, 0, 1]
        drawn[scale] = (depth, ground[:, 2:, 1] - unloaded_level(translation.case))
    assert drawn[1.0][0] == pytest.approx(drawn[5.0][0], abs=1e-12)
    # shoes stand 6 to 7 cm deep (F-paper)
    assert np.all((drawn[1.0][0] > 0.03) & (drawn[1.0][0] < 0.09))
    assert drawn[5.0][1] == pytest.approx(5.0 * drawn[1.0][1], abs=1e-12)


def test_forces_are_where_the_history_has_them(translation):
    now = translation.dataset.isel(time=-1)
    view = SideView(Figure().subplots(), translation, 1.0, force_scale=1e-6)
    view.show(now)
    centers, forces = shoe_forces(now)
    assert view._forces.get_offsets() == pytest.approx(centers[:, [0, 2]])
    assert pytest.approx(1e-6 * forces[:, 2]) == view._forces.V
    weight = 13 * (386.4e3 + translation.case.shoe.mass * 9.81)
    assert forces[:, 2].sum() == pytest.approx(weight, rel=0.05)


def test_a_shoe_without_contact_gets_no_arrow(translation):
    now = translation.dataset.isel(time=-1).copy()
    lifted = now.assign(area=now.area.where(now.contact_shoe != 7, 0.0))
    view = SideView(Figure().subplots(), translation, force_scale=1e-6)
    view.show(lifted)
    assert view._forces.Umask.tolist() == [shoe == 7 for shoe in translation.case.track.shoes]


def test_faces_of_uneven_ground_lie_at_their_heights(step):
    """Shoes stand as deep in the upper units as in the lower ones, at every scale of displacement."""
    now = step.dataset.isel(time=-1)
    for scale in (1.0, 20.0):
        ax = Figure().subplots()
        view = SideView(ax, step, scale)
        view.show(now)
        ground = corners(view._ground)
        assert len(ground) == 13
        raised = ground[:, 0, 0] >= STEP_PLACE - 1e-9
        level = unloaded_level(step.case)
        heave = level + scale * (now.unit_heave.values - level)
        assert ground[:, 2:, 1].mean(axis=1) == pytest.approx(heave + STEP_HEIGHT * raised)
        surface = ground[:, [3, 2]]
        shoes = corners(view._shoes)
        for shoe in (0, 1, 2, 10, 11, 12):
            middle = shoes[shoe, :2].mean(axis=0)
            unit = np.flatnonzero((surface[:, 0, 0] <= middle[0]) & (middle[0] < surface[:, 1, 0]))[0]
            depth = np.interp(middle[0], *surface[unit].T) - middle[1]
            assert 0.03 < depth < 0.09
        assert ax.get_ylim()[0] == -DEPTH


def test_a_ground_figure_shows_what_every_shoe_carries(step):
    figure = ground_figure(step, 0.05)
    side, carried = figure.axes
    assert side.get_title() == "step, t = 0.05 s"
    assert [text.get_text() for text in side.get_legend().get_texts()] == ["units", "shoes", "link pins"]
    heights = [bar.get_height() for bar in carried.patches]
    _, forces = shoe_forces(step.dataset.isel(time=-1))
    assert heights == pytest.approx(1e-3 * forces[:, 2])
    assert np.mean(heights) == pytest.approx(1e-3 * step.case.mean_load, rel=0.1)
    figure.draw_without_rendering()
    left, right = (ax.get_window_extent() for ax in (side, carried))
    assert left.width == pytest.approx(right.width, rel=0.02)
