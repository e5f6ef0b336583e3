"""What figures and pages draw over time is what histories and stresses hold, with the phases of a run."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.colors import to_hex

from exudyn_crawler.case.parameters.undercarriage import MachineCycle, MachinePhase
from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.views.figures import history_series, run_figures, stress_figures
from exudyn_crawler.views.pages.runs import comparison_figures
from exudyn_crawler.views.scenes.films import TrackPicture
from exudyn_crawler.views.style import PHASE_BANDS

BANDS = [(0.0, 0.04), (0.04, 0.08), (0.08, 0.084), (0.084, 0.12)]
NAMES = ["propel <b>", "first $dig", "swing & back"]
"""Those that fit; the third is wider than its band."""
OF_ANY_RUN = {
    "displacement", "velocity", "acceleration", "angular velocity", "angular acceleration",
    "normal force", "slip velocity", "friction force", "contact force", "sinkage and friction torque",
    "spherical joint reaction", "parallel joint torque", "terrain deformation",
}  # fmt: skip


def curves(figure):
    """Labels of the panels, and values by curve of each."""
    return {
        ax.get_ylabel().replace("\n", " "): {line.get_label(): line.get_ydata() for line in ax.lines}
        for ax in figure.axes
    }


def test_series_are_in_the_units_that_they_name(translation):
    found = history_series(translation)
    turning = found["angular velocity"]
    assert turning.unit == "deg/s"
    expected = np.degrees(translation.angular_velocity.sel(shoe=7, axis="y").values)
    assert turning.values.sel(item="shoe 7", axis="y").values == pytest.approx(expected)
    moved = found["displacement from equilibrium"].values
    assert np.all(moved.isel(time=0) == 0.0)
    position = translation.position.sel(shoe=1, axis="x").values
    assert moved.sel(item="shoe 1", axis="x").values == pytest.approx(position - position[0])
    torque = found["friction torque"]
    assert torque.values.axis.values.tolist() == [""]
    about_z = 1e-3 * translation.contacts_by_shoe().friction_torque.sel(axis="z", shoe=4).values
    assert torque.values.sel(item="shoe 4", axis="").values == pytest.approx(about_z)


def test_panels_have_a_curve_for_each_item_that_is_asked_for(translation):
    series = history_series(translation)["spherical joint reaction"]
    panels = series.panels(["link 1-2", "link 12-13"])
    assert [panel.label for panel in panels] == [f"{axis} spherical joint reaction" for axis in "xyz"]
    assert [list(panel.curves) for panel in panels] == [["link 1-2", "link 12-13"]] * 3
    drawn = panels[2].curves["link 12-13"].values
    assert drawn == pytest.approx(1e-3 * translation.joint_force.sel(joint=12, axis="z").values)
    assert series.values.isel(time=0).size == len(series.panels()) * len(series.panels()[0].curves) == 36


def test_force_figures_draw_the_chosen_shoes_and_links(translation):
    figures = run_figures(translation, (2, 5, 13))
    assert set(figures) == OF_ANY_RUN
    together = curves(figures["sinkage and friction torque"])
    assert list(together) == ["penetration depth in m", "sinkage velocity in m/s", "friction torque in kN m"]
    depth = translation.contacts_by_shoe().penetration.sel(shoe=5).values
    assert together["penetration depth in m"]["shoe 5"] == pytest.approx(depth)
    assert list(curves(figures["parallel joint torque"])["z parallel joint torque in kN m"]) == [
        *("link 2-3", "link 5-6", "link 12-13")
    ]
    (deformation,) = curves(figures["terrain deformation"])["deformation in m"].values()
    assert deformation == pytest.approx(translation.terrain_deformation.values)


def test_stress_figures_draw_the_flexible_shoes_and_their_pins(flexible_run):
    history, stress, _ = flexible_run
    figures = stress_figures(history, stress)
    for name in ("displacement", "velocity", "angular velocity", "contact force"):
        panels = curves(figures[name])
        assert len(panels) == 3
        assert all(list(panel) == ["shoe 7", "shoe 13"] for panel in panels.values())
    for side in ("right", "left"):
        force = curves(figures[f"{side} revolute joint reaction"])["x pin force in kN"]
        assert list(force) == ["link 6-7", "link 7-8", "link 12-13"]
        expected = 1e-3 * history.pin_force.sel(joint=12, pin=side, axis="x").values
        assert force["link 12-13"] == pytest.approx(expected)
        assert f"{side} revolute joint torque" in figures
    modes = curves(figures["modal coordinates"])
    assert [len(panel) for panel in modes.values()] == [6, 6]
    highest = curves(figures["highest von Mises stress"])
    assert list(highest) == ["shoe 7 in MPa", "shoe 13 in MPa"]
    expected = stress.highest_von_mises.sel(shoe=13).values / 1e6
    assert highest["shoe 13 in MPa"]["shoe 13"] == pytest.approx(expected)


def test_rolled_runs_offer_their_rollers_and_frame_dragged_ones_do_not(rolled, translation):
    found = history_series(rolled)
    assert found["roller force"].values["item"].values.tolist() == ["roller 1", "roller 2", "roller 3"]
    turned = found["angle of the side frame"]
    expected = np.degrees(rolled.side_frame_angles.sel(axis="y").values)
    assert (turned.unit, turned.values.axis.values.tolist()) == ("deg", ["roll", "pitch"])
    assert turned.values.sel(axis="pitch").values[:, 0] == pytest.approx(expected)
    assert not {one.group for one in history_series(translation).values()} & {"rollers", "side frame"}


def test_figures_draw_forces_on_both_sides_and_the_motion_of_the_frame(rolled):
    figures = run_figures(rolled, (4, 5))
    assert set(figures) == OF_ANY_RUN | {"roller force", "force of all rollers", "side frame"}
    forces = curves(figures["roller force"])
    both, right, left = (panel["roller 2"] for panel in forces.values())
    assert both == pytest.approx(right + left)
    assert left == pytest.approx(1e-3 * rolled.roller_force.sel(roller=2, rail="left", axis="z").values)
    shoes = curves(figures["force of all rollers"])["z force of all rollers in kN"]
    assert list(shoes) == ["shoe 4", "shoe 5"]
    assert shoes["shoe 5"] == pytest.approx(1e-3 * rolled.rail_force.sel(shoe=5, axis="z").values)
    frame = curves(figures["side frame"])
    heave = rolled.side_frame_position.sel(axis="z").values
    assert frame["z way of the side frame in m"]["side frame"] == pytest.approx(heave - heave[0])
    assert frame["pull of the drive in kN"]["side frame"] == pytest.approx(1e-3 * rolled.drive_pull.values)


def assert_banded(ax, expected=BANDS, names=NAMES):
    """A panel has bands with these begins and ends, and these names above."""
    boxes = [patch.get_bbox() for patch in ax.patches]
    assert [pytest.approx((box.x0, box.x1)) for box in boxes] == expected
    assert [text.get_text() for text in ax.texts] == names


def assert_all_banded(figure):
    """All panels over time have the bands, the first one their names."""
    for number, ax in enumerate(figure.axes):
        assert_banded(ax, names=[] if number else NAMES)
        assert ax.get_xlim() == pytest.approx((-0.006, 0.126))


def test_every_figure_over_time_has_a_band_a_phase_with_its_name(phased):
    figures = run_figures(phased, (1, 13))
    for figure in figures.values():
        assert_all_banded(figure)
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
    history, stress, _ = flexible_run
    figures = [*run_figures(translation, (1,)).values(), *stress_figures(history, stress).values()]
    assert not any(ax.patches or ax.texts for figure in figures for ax in figure.axes)


def test_curves_of_stresses_have_those_of_the_cycle(phased, flexible_run):
    history, stress, _ = flexible_run
    bent = History(history.case.with_(loads=phased.case.loads), history.dataset)
    for figure in stress_figures(bent, stress).values():
        assert_banded(figure.axes[0], [(0.0, 0.04), (0.04, 0.06)], NAMES[:2])


def test_a_rolled_run_has_the_phases_of_its_machine(rolled):
    nothing = {"force": (0.0, 0.0, 0.0), "moment": (0.0, 0.0, 0.0)}
    phases = [MachinePhase(name=name, end=end, **nothing) for name, end in (("roll", 0.1), ("dig", 0.3))]
    digging = History(rolled.case.with_(machine=MachineCycle(phases=tuple(phases))), rolled.dataset)
    for figure in run_figures(digging, (4,)).values():
        assert_banded(figure.axes[0], [(0.0, 0.1), (0.1, 0.2)], ["roll", "dig"])
    assert not any(ax.patches for figure in run_figures(rolled, (4,)).values() for ax in figure.axes)


def test_two_runs_have_the_bands_that_both_have(phased, translation):
    again = History(phased.case.with_(name="again"), phased.dataset.sel(time=slice(0.0, 0.1)))
    assert common_phases(phased, again) == common_phases(phased)
    assert_all_banded(comparison_figures({"one": phased, "other": again}, {})["velocity"])
    assert common_phases(phased, translation) == []
    different = comparison_figures({"one": phased, "other": translation}, {})["velocity"]
    assert not any(ax.patches for ax in different.axes)


def test_curves_of_an_animation_have_them_too(phased):
    assert_banded(TrackPicture(phased, 10.0).figure.axes[2])
