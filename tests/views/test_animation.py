"""Animations of short runs, and what their side view shows."""

import itertools

import imageio_ffmpeg
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from exudyn_crawler.views.animation import TrackPicture, write_animation
from exudyn_crawler.views.placement import Pose
from exudyn_crawler.views.track_views import PlanView, SideView, ground_scale, shoe_forces, unloaded_level


def test_a_gif_shows_the_run_from_start_to_end(translation, tmp_path):
    path = write_animation(translation, tmp_path / "track.gif", rate=10, start=0.1)
    with Image.open(path) as image:
        assert image.n_frames == 4
        assert image.info["duration"] == 100
        pictures = []
        for number in range(image.n_frames):
            image.seek(number)
            pictures.append(np.asarray(image.convert("RGB")).astype(int))
    changed = [np.abs(b - a).max(axis=2) > 40 for a, b in itertools.pairwise(pictures)]
    assert all(0 < change.sum() < 0.2 * change.size for change in changed)
    with pytest.raises(FileExistsError, match=r"track\.gif exists"):
        write_animation(translation, path)


def test_an_mp4_plays_slower_when_asked(translation, tmp_path):
    path = write_animation(translation, tmp_path / "track.mp4", rate=10, speed=0.5, end=0.2)
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(path))
    assert frames == 5
    assert seconds == pytest.approx(0.5, abs=0.02)


def corners(collection):
    return np.array([path.vertices[:4] for path in collection.get_paths()])


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


def test_shoes_and_forces_are_where_the_history_has_them(translation):
    now = translation.dataset.isel(time=-1)
    above = PlanView(Figure().subplots(), translation)
    above.show(now)
    underneath = np.array([[0.0, 0.0, -translation.case.shoe.com_height]])
    expected = [Pose.of(now, int(shoe)).place(underneath)[0, :2] for shoe in now.shoe.values]
    assert corners(above._shoes).mean(axis=1) == pytest.approx(np.array(expected), abs=1e-9)
    view = SideView(Figure().subplots(), translation, 1.0, force_scale=1e-6)
    view.show(now)
    centers, forces = shoe_forces(now)
    assert view._forces.get_offsets() == pytest.approx(centers[:, [0, 2]])
    assert pytest.approx(1e-6 * forces[:, 2]) == view._forces.V
    weight = 13 * (386.4e3 + translation.case.shoe.mass * 9.81)
    assert forces[:, 2].sum() == pytest.approx(weight, rel=0.05)


def test_a_picture_says_time_and_scale(turning):
    scale = ground_scale(turning)
    figure = TrackPicture(turning, scale).show(0.2)
    width = figure.get_window_extent().width
    for ax in figure.axes[:3]:
        # the panels use the width, and what is written over them fits
        assert ax.get_window_extent().width > 0.8 * width
        assert ax._left_title.get_window_extent().x1 < width
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
    ],
)
def test_what_cannot_be_shown_is_refused_before_work_starts(translation, tmp_path, name, options, words):
    with pytest.raises(ValueError, match=words):
        write_animation(translation, tmp_path / name, **options)
    assert not list(tmp_path.iterdir())
