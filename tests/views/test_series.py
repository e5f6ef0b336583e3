"""What figures and report draw over time is what histories and stresses hold."""

import numpy as np
import pytest

from exudyn_crawler.results.stress.recovery import StressResults
from exudyn_crawler.views.force_figures import force_figures
from exudyn_crawler.views.series import Series, history_series, link_names, shoe_names
from exudyn_crawler.views.stress_figures import stress_figures
from tests.views.drawn import curves


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
    about_z = translation.contacts_by_shoe().friction_torque.sel(axis="z", shoe=4).values
    assert torque.values.sel(item="shoe 4", axis="").values == pytest.approx(about_z)


def test_panels_have_a_curve_for_each_item_that_is_asked_for(translation):
    series = history_series(translation)["spherical joint reaction"]
    panels = series.panels(link_names((1, 12)))
    assert [panel.label for panel in panels] == [f"{axis} spherical joint reaction" for axis in "xyz"]
    assert [list(panel.curves) for panel in panels] == [["link 1-2", "link 12-13"]] * 3
    drawn = panels[2].curves["link 12-13"].values
    assert drawn == pytest.approx(translation.joint_force.sel(joint=12, axis="z").values)
    assert isinstance(series, Series)
    assert series.count == len(series.panels()) * len(series.panels()[0].curves) == 36


def test_force_figures_draw_the_chosen_shoes_and_links(translation):
    figures = force_figures(translation, shoes=(2, 5), joints=(3,))
    assert set(figures) == {
        "normal force", "slip velocity", "friction force", "contact force", "sinkage and friction torque",
        "spherical joint reaction", "parallel joint torque", "terrain deformation",
    }  # fmt: skip
    together = curves(figures["sinkage and friction torque"])
    assert list(together) == ["penetration depth in m", "sinkage velocity in m/s", "friction torque in N m"]
    depth = translation.contacts_by_shoe().penetration.sel(shoe=5).values
    assert together["penetration depth in m"]["shoe 5"] == pytest.approx(depth)
    assert list(curves(figures["parallel joint torque"])["z parallel joint torque in N m"]) == ["link 3-4"]
    (deformation,) = curves(figures["terrain deformation"])["deformation in m"].values()
    assert deformation == pytest.approx(translation.terrain_deformation.values)


def test_stress_figures_draw_the_flexible_shoes_and_their_pins(flexible_run):
    history, stress, hot_spots = flexible_run
    figures = stress_figures(history, StressResults(stress, hot_spots, {}, whole=None))
    for name in ("displacement", "velocity", "angular velocity", "contact force"):
        panels = curves(figures[name])
        assert len(panels) == 3
        assert all(list(panel) == shoe_names((7, 13)) for panel in panels.values())
    for side in ("right", "left"):
        force = curves(figures[f"{side} revolute joint reaction"])["x pin force in N"]
        assert list(force) == link_names((6, 7, 12))
        expected = history.pin_force.sel(joint=12, pin=side, axis="x").values
        assert force["link 12-13"] == pytest.approx(expected)
        assert f"{side} revolute joint torque" in figures
    modes = curves(figures["modal coordinates"])
    assert [len(panel) for panel in modes.values()] == [6, 6]
    highest = curves(figures["highest von Mises stress"])
    assert list(highest) == ["shoe 7 in MPa", "shoe 13 in MPa"]
    expected = stress.highest_von_mises.sel(shoe=13).values / 1e6
    assert highest["shoe 13 in MPa"]["shoe 13"] == pytest.approx(expected)
