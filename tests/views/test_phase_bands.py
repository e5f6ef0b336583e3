"""Bands of the phases of a run stand behind its curves."""

from itertools import pairwise

import pytest
from matplotlib.colors import to_hex

from exudyn_crawler.case import MachineCycle, MachinePhase
from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.results.stress.recovery import StressResults
from exudyn_crawler.views.animation import TrackPicture
from exudyn_crawler.views.colours import PHASE_BANDS
from exudyn_crawler.views.comparison import comparison_figures
from exudyn_crawler.views.curves import kinematic_figure
from exudyn_crawler.views.force_figures import force_figures
from exudyn_crawler.views.roller_figures import roller_figures
from exudyn_crawler.views.stress_figures import stress_figures

BANDS = [(0.0, 0.04), (0.04, 0.08), (0.08, 0.084), (0.084, 0.12)]
NAMES = ["propel <b>", "first $dig", "swing & back"]
"""Those that fit; the third is wider than its band."""


def bands(ax):
    """Begin and end of every band of a panel, s."""
    boxes = [patch.get_bbox() for patch in ax.patches]
    return [(box.x0, box.x1) for box in boxes]


def names(ax):
    return [text.get_text() for text in ax.texts]


def assert_banded(figure):
    for ax in figure.axes:
        assert [pytest.approx(one) for one in bands(ax)] == BANDS
        assert ax.get_xlim() == pytest.approx((-0.006, 0.126))
    assert [names(ax) for ax in figure.axes] == [NAMES, *[[]] * (len(figure.axes) - 1)]


def test_every_figure_over_time_has_a_band_a_phase_with_its_name(phased):
    figures = force_figures(phased, shoes=(1, 13), joints=(1,))
    figures["velocity"] = kinematic_figure(phased, "velocity", (1, 13))
    for figure in figures.values():
        assert_banded(figure)
    first = figures["velocity"].axes[0]
    colours = [to_hex(patch.get_facecolor()) for patch in first.patches]
    assert colours == [PHASE_BANDS[0], PHASE_BANDS[1]] * 2
    lowest = min(line.get_zorder() for line in first.lines)
    assert all(patch.get_zorder() < lowest for patch in first.patches)
    # names stand beside each other above all curves
    boxes = [text.get_window_extent() for text in first.texts]
    assert all(one.x1 < other.x0 for one, other in pairwise(boxes))
    assert all(box.y0 > first.get_window_extent().y1 for box in boxes)


def test_a_run_of_one_phase_has_no_bands(translation, flexible_run):
    history, stress, hot_spots = flexible_run
    figures = [
        *force_figures(translation, shoes=(1,), joints=(1,)).values(),
        kinematic_figure(translation, "velocity"),
        *stress_figures(history, StressResults(stress, hot_spots, {}, whole=None)).values(),
    ]
    assert not any(ax.patches or ax.texts for figure in figures for ax in figure.axes)


def test_curves_of_stresses_have_those_of_the_cycle(phased, flexible_run):
    history, stress, hot_spots = flexible_run
    bent = History(history.case.with_(loads=phased.case.loads), history.dataset)
    for figure in stress_figures(bent, StressResults(stress, hot_spots, {}, whole=None)).values():
        assert [pytest.approx(one) for one in bands(figure.axes[0])] == [(0.0, 0.04), (0.04, 0.06)]
        assert names(figure.axes[0]) == NAMES[:2]


def test_a_rolled_run_has_the_phases_of_its_machine(rolled):
    nothing = {"force": (0.0, 0.0, 0.0), "moment": (0.0, 0.0, 0.0)}
    phases = [MachinePhase(name=name, end=end, **nothing) for name, end in (("roll", 0.1), ("dig", 0.3))]
    digging = History(rolled.case.with_(machine=MachineCycle(phases=tuple(phases))), rolled.dataset)
    for figure in roller_figures(digging, (4,)).values():
        assert [pytest.approx(one) for one in bands(figure.axes[0])] == [(0.0, 0.1), (0.1, 0.2)]
        assert names(figure.axes[0]) == ["roll", "dig"]
    assert not any(ax.patches for figure in roller_figures(rolled, (4,)).values() for ax in figure.axes)


def test_two_runs_have_the_bands_that_both_have(phased, translation):
    again = History(phased.case.with_(name="again"), phased.dataset.sel(time=slice(0.0, 0.1)))
    assert common_phases(phased, again) == common_phases(phased)
    assert_banded(comparison_figures({"one": phased, "other": again}, {})["velocity"])
    assert common_phases(phased, translation) == []
    different = comparison_figures({"one": phased, "other": translation}, {})["velocity"]
    assert not any(ax.patches for ax in different.axes)


def test_curves_of_an_animation_have_them_too(phased):
    speeds = TrackPicture(phased, 10.0).figure.axes[2]
    assert [pytest.approx(one) for one in bands(speeds)] == BANDS
    assert names(speeds) == NAMES
