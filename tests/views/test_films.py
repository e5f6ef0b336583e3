"""Films of short runs: of the track, and of a flexible shoe with its stress under rollers."""

import itertools

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from exudyn_crawler import History
from exudyn_crawler.views.scenes.films import (
    MOST_PICTURES,
    ShoePicture,
    TrackPicture,
    film_times,
    ground_scale,
    write_animation,
)
from exudyn_crawler.views.scenes.gear import wheel_solids
from exudyn_crawler.views.scenes.scene import SIDES
from exudyn_crawler.views.scenes.shoes import BESIDE
from exudyn_crawler.views.scenes.track import acting, instants, shoe_pose

SHOE = 5


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
    ],
)
def test_what_cannot_be_shown_is_refused_before_work_starts(translation, tmp_path, name, options, words):
    with pytest.raises(ValueError, match=words):
        write_animation(translation, tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_a_film_of_very_many_pictures_is_refused_with_what_is_allowed(translation, tmp_path):
    with pytest.raises(
        ValueError, match=r"speed must be at least 0\.0004 .* at most 20000 pictures; got 1e-09"
    ):
        write_animation(translation, str(tmp_path / "track.mp4"), speed=1e-9)
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


@pytest.fixture(scope="module")
def by_modes(bent):
    """Static fields would take ten seconds, and are not what is looked at."""
    modes = bent.case.flexible_shoes().with_(static_fields=False)
    return History(bent.case.with_(flexible=modes), bent.dataset)


@pytest.fixture(scope="module")
def picture(by_modes):
    return ShoePicture(by_modes, SHOE, np.array([0.0, 0.03, 0.06]))


def test_rollers_near_the_shoe_are_where_the_history_has_them(picture, by_modes):
    now = instants(by_modes, [by_modes.duration])
    place = shoe_pose(now.dataset.isel(time=0), SHOE)
    centers = wheel_solids(now)[0].origin[0]
    near = centers[np.abs(centers[:, 0] - place.origin[0]) < BESIDE]
    drawn = picture.scene(now).solids[1].at().points.reshape(-1, 2 * SIDES, 3).mean(axis=1)
    assert len(drawn) >= 2
    assert drawn == pytest.approx(near, abs=1e-9)


def test_the_shoe_bends_and_is_pressed_as_its_stresses_say(picture, by_modes, bent_stress):
    now = by_modes.dataset.isel(time=-1)
    scene = picture.scene(instants(by_modes, [by_modes.duration]))
    surface, arrows = scene.solids[0].at(), scene.arrows[0].at()
    nodes = np.unique(bent_stress.triangle.values)
    own = bent_stress.sel(shoe=SHOE).isel(frame=-1, node=nodes)
    assert surface.values == pytest.approx(own.frame_von_mises.values / 1e6, rel=1e-5, abs=1e-6)
    place = shoe_pose(now, SHOE)
    moved = (surface.points - place.origin) @ place.turn - own.node_position.values
    assert moved == pytest.approx(
        picture.scales.displacement * own.frame_displacement.values, rel=1e-4, abs=1e-9
    )
    pushes = (arrows[:, 1] - arrows[:, 0]) / picture.scales.pair_force
    _, forces = acting(now, SHOE)
    total = pushes.sum(axis=0)
    assert total == pytest.approx(forces.sum(axis=0), rel=1e-6, abs=1.0)
    assert picture.scales.stress >= float(picture.stress.frame_von_mises.max())


def test_pictures_differ_in_the_shoe_alone_and_share_one_scale(picture):
    first, last = (picture.image(time).astype(int) for time in (0.0, 0.06))
    changed = np.abs(last - first).max(axis=2) > 10
    height, width = changed.shape
    assert 0.0 < changed[: height // 2, : int(0.86 * width)].mean() < 0.3
    # the bar of the colours stays
    assert not changed[int(0.15 * height) : int(0.65 * height), int(0.88 * width) :].any()
    # greenish rollers are seen above the shoe
    red, green, blue = (first[: height // 2, :, k] for k in range(3))
    assert ((green > red + 3) & (green > blue + 10)).mean() > 0.01


def test_a_film_of_a_shoe_has_a_picture_for_each_time(by_modes, tmp_path):
    path = write_animation(by_modes, tmp_path / "shoe.gif", shoe=SHOE, rate=10, speed=0.5)
    with Image.open(path) as film:
        assert film.n_frames == 2
        assert film.info["duration"] == 100


def test_what_cannot_be_shown_of_a_shoe_is_refused(by_modes, tmp_path):
    with pytest.raises(ValueError, match=r"of \[5, 6\], got 2"):
        write_animation(by_modes, tmp_path / "shoe.mp4", shoe=2)
    with pytest.raises(ValueError, match=r"\.mp4 or \.gif file"):
        write_animation(by_modes, tmp_path / "shoe.png", shoe=SHOE)
    with pytest.raises(ValueError, match="speed must be positive, got 0"):
        write_animation(by_modes, tmp_path / "shoe.gif", shoe=SHOE, speed=0.0)
    assert not list(tmp_path.iterdir())
