"""What figures, pages of two runs and films draw over time is what histories and stresses hold, by phases."""

from itertools import pairwise

import imageio_ffmpeg
import numpy as np
import pytest
from matplotlib.colors import to_hex
from PIL import Image

from exudyn_crawler.case import MachineCycle, MachinePhase
from exudyn_crawler.results.history.history import History, common_phases
from exudyn_crawler.views.figures import history_series, run_figures, stress_figures
from exudyn_crawler.views.pages.runs import comparison_figures, write_comparison
from exudyn_crawler.views.scenes.films import (
    MOST_PICTURES,
    TrackPicture,
    film_times,
    ground_scale,
    write_animation,
)
from exudyn_crawler.views.style import PHASE_BANDS

BANDS = [(0.0, 0.04), (0.04, 0.08), (0.08, 0.084), (0.084, 0.12)]
PHASES = ["propel <b>", "first $dig", "let the machine settle", "swing & back"]
NAMES = [*PHASES[:2], PHASES[3]]
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
    turning, moved = found["angular velocity"], found["displacement from equilibrium"].values
    assert turning.unit == "deg/s"
    expected = np.degrees(translation.angular_velocity.sel(shoe=7, axis="y").values)
    assert turning.values.sel(item="shoe 7", axis="y").values == pytest.approx(expected)
    assert np.all(moved.isel(time=0) == 0.0)
    position = translation.position.sel(shoe=1, axis="x").values
    assert moved.sel(item="shoe 1", axis="x").values == pytest.approx(position - position[0])
    torque = found["friction torque"].values
    assert torque.axis.values.tolist() == [""]
    about_z = 1e-3 * translation.contacts_by_shoe().friction_torque.sel(axis="z", shoe=4).values
    assert torque.sel(item="shoe 4", axis="").values == pytest.approx(about_z)


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


def test_stress_figures_draw_the_flexible_shoes_and_their_pins(history, stress):
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
    assert frame["z displacement of the side frame in m"]["side frame"] == pytest.approx(heave - heave[0])
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
    assert [to_hex(patch.get_facecolor()) for patch in first.patches] == [*PHASE_BANDS[:2]] * 2
    lowest = min(line.get_zorder() for line in first.lines)
    assert all(patch.get_zorder() < lowest for patch in first.patches)
    # names stand beside each other above all curves
    boxes = [text.get_window_extent() for text in first.texts]
    assert all(one.x1 < other.x0 for one, other in pairwise(boxes))
    assert all(box.y0 > first.get_window_extent().y1 for box in boxes)


def test_a_run_of_one_phase_has_no_bands(translation, history, stress):
    figures = [*run_figures(translation, (1,)).values(), *stress_figures(history, stress).values()]
    assert not any(ax.patches or ax.texts for figure in figures for ax in figure.axes)


def test_curves_of_stresses_have_those_of_the_cycle(phased, history, stress):
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


def test_curves_of_both_runs_stand_in_one_figure(translation, turning):
    figures = comparison_figures({"straight": translation, "curved": turning}, {})
    assert list(figures)[:2] == ["contact force", "velocity"]
    axes = figures["velocity"].axes
    assert len(axes) == 3
    assert [line.get_label() for line in axes[0].lines] == [
        f"shoe {shoe}, {run}" for shoe in (1, 7, 13) for run in ("straight", "curved")
    ]
    x = translation.velocity.sel(shoe=7, axis="x").values
    assert axes[0].lines[2].get_ydata() == pytest.approx(x)


def test_the_page_shows_parameters_results_and_curves(translation, turning, tmp_path):
    runs = {"straight": translation, "curved": turning}
    page = write_comparison(runs, tmp_path / "both.html").read_text(encoding="utf-8")
    assert "A is straight: case &#39;translation&#39;, 0.4 s" in page
    assert all(f"<td>{name}</td>" in page for name in ("drive.turn_rate", "angular_velocity"))
    assert page.count("data:image/png;base64,") == 6
    assert "http" not in page
    with pytest.raises(FileExistsError, match=r"both\.html exists"):
        write_comparison(runs, tmp_path / "both.html")
    with pytest.raises(ValueError, match=r"histories must be two, got \['straight'\]"):
        write_comparison({"straight": translation}, tmp_path / "one.html")


def test_equal_runs_say_so(translation, tmp_path):
    page = write_comparison({"one": translation, "other": translation}, tmp_path / "same.html").read_text()
    assert "<p>Nothing differs in the cases.</p>" in page
    assert "<p>Nothing that both runs have differs in the results, beyond rounding.</p>" in page
    assert "<table" not in page


def test_runs_without_a_common_flexible_shoe_are_compared_by_the_rest(history, stress, bent, bent_stress):
    figures = comparison_figures({"a": history, "b": bent}, {"a": stress, "b": bent_stress})
    assert "highest von Mises stress" not in figures
    assert "velocity" in figures


def test_a_gif_shows_the_run_from_start_to_end(translation, tmp_path):
    path = write_animation(translation, tmp_path / "track.gif", rate=10, start=0.1)
    with Image.open(path) as image:
        assert image.n_frames == 4
        assert image.info["duration"] == 100
        pictures = []
        for number in range(image.n_frames):
            image.seek(number)
            pictures.append(np.asarray(image.convert("RGB")).astype(int))
    changed = [np.abs(b - a).max(axis=2) > 40 for a, b in pairwise(pictures)]
    assert all(0 < change.sum() < 0.2 * change.size for change in changed)
    with pytest.raises(FileExistsError, match=r"track\.gif exists"):
        write_animation(translation, path)


@pytest.mark.slow
def test_an_mp4_plays_slower_when_asked(translation, tmp_path):
    path = write_animation(translation, tmp_path / "track.mp4", rate=10, speed=0.5, end=0.2)
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(path))
    assert frames == 5
    assert seconds == pytest.approx(0.5, abs=0.02)


def test_a_picture_says_time_and_scale(turning):
    scale = ground_scale(turning)
    picture = TrackPicture(turning, scale)
    picture.image(0.2)
    figure = picture.figure
    width = figure.get_window_extent().width
    for ax in figure.axes[:3]:
        # the panels use the width, and what is written over them fits
        assert ax.get_window_extent().width > 0.8 * width
        assert ax._left_title.get_window_extent().x1 < width
        assert ax.yaxis.label.get_window_extent().x0 > 0.0
    assert figure._suptitle.get_text() == "turning: t = 0.20 s"
    assert any(f"ground drawn {scale:g} times larger" in ax.get_title(loc="left") for ax in figure.axes)


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("track.avi", {}, r"\.mp4 or \.gif file, got .*track\.avi"),
        ("track.gif", {"start": 0.3, "end": 0.2}, r"in 0\.\.0\.4 s, got 0\.3\.\.0\.2 s"),
        ("track.gif", {"end": 1.0}, r"got 0\.\.1 s"),
        ("track.gif", {"scale": 0.0}, "scale must be positive, got 0"),
        ("track.mp4", {"speed": -1.0}, "speed must be positive, got -1"),
        ("track.mp4", {"rate": 0}, "rate must be positive, got 0"),
        (
            "track.mp4",
            {"speed": 1e-9},
            r"speed must be at least 0\.0004 .* at most 20000 pictures; got 1e-09",
        ),
    ],
)
def test_what_cannot_be_shown_is_refused_before_work_starts(translation, tmp_path, name, options, words):
    with pytest.raises(ValueError, match=words):
        write_animation(translation, str(tmp_path / name), **options)
    assert not list(tmp_path.iterdir())


def test_a_film_may_be_as_slow_as_the_refusal_says():
    assert len(film_times(0.4, speed=0.0004)) == MOST_PICTURES + 1


def test_a_picture_of_a_rolled_run_has_room_for_what_it_says(rolled):
    picture = TrackPicture(rolled, 10.0)
    picture.image(0.1)
    width = picture.figure.get_window_extent().width
    _, side, forces = picture.figure.axes[:3]
    assert "violet: force of each roller" in side.get_title(loc="left")
    assert side._left_title.get_window_extent().x1 < width
    drawn = forces.lines[1].get_ydata()
    assert drawn == pytest.approx(-1e-3 * rolled.roller_force.sel(roller=2, axis="z").sum("rail").values)
