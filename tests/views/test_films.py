"""Films of short runs."""

import itertools

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from exudyn_crawler.views.scenes.films import (
    MOST_PICTURES,
    TrackPicture,
    film_times,
    ground_scale,
    write_animation,
)

TOO_SLOW = r"speed must be at least 0\.0004 .* at most 20000 pictures; got 1e-09"


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
        ("track.mp4", {"speed": 1e-9}, TOO_SLOW),
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
