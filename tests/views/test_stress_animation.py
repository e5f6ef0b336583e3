"""Animation of a flexible shoe with its stress under rollers, in a short run."""

import numpy as np
import pytest
from PIL import Image

from exudyn_crawler import History
from exudyn_crawler.views.placement import Pose
from exudyn_crawler.views.stress_animation import NEAR, ShoePicture, write_stress_animation
from exudyn_crawler.views.undercarriage import acting, tread_centers

SHOE = 5


@pytest.fixture(scope="module")
def by_modes(bent):
    """Static fields would take ten seconds, and are not what is looked at."""
    modes = bent.case.flexible_shoes().with_(static_fields=False)
    return History(bent.case.with_(flexible=modes), bent.dataset)


@pytest.fixture(scope="module")
def picture(by_modes):
    return ShoePicture(by_modes, SHOE, np.array([0.0, 0.03, 0.06]))


def test_rollers_near_the_shoe_are_where_the_history_has_them(picture, by_modes):
    now = by_modes.dataset.isel(time=-1)
    pose = Pose.of(now, SHOE)
    inside = pose.inside(tread_centers(now, by_modes.case).reshape(-1, 3))
    near = inside[np.abs(inside[:, 0]) < NEAR]
    drawn = np.array([body.points.mean(axis=0) for body in picture.scene(now).bodies])
    assert len(drawn) >= 2
    assert drawn == pytest.approx(near, abs=1e-9)


def test_the_shoe_bends_and_is_pressed_as_its_stresses_say(picture, by_modes, bent_stress):
    now = by_modes.dataset.isel(time=-1)
    scene = picture.scene(now)
    nodes = np.unique(bent_stress.triangle.values)
    own = bent_stress.sel(shoe=SHOE).isel(frame=-1, node=nodes)
    assert scene.values == pytest.approx(own.frame_von_mises.values / 1e6, rel=1e-5, abs=1e-6)
    moved = scene.points - own.node_position.values
    assert moved == pytest.approx(picture._bend * own.frame_displacement.values, rel=1e-4, abs=1e-9)
    pushes = (scene.arrows[:, 1] - scene.arrows[:, 0]) / picture._force_scale
    _, forces = acting(now, SHOE)
    assert Pose.of(now, SHOE).turn(pushes).sum(axis=0) == pytest.approx(forces.sum(axis=0), rel=1e-6, abs=1.0)
    assert picture._limits[1] >= float(picture._stress.von_mises.max()) / 1e6


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


def test_a_film_has_a_picture_for_each_time(by_modes, tmp_path):
    path = write_stress_animation(by_modes, SHOE, tmp_path / "shoe.gif", rate=10, speed=0.5)
    with Image.open(path) as film:
        assert film.n_frames == 2
        assert film.info["duration"] == 100


def test_what_cannot_be_shown_is_refused(by_modes, tmp_path):
    with pytest.raises(ValueError, match=r"of \[5, 6\], got 2"):
        write_stress_animation(by_modes, 2, tmp_path / "shoe.mp4")
    with pytest.raises(ValueError, match=r"\.mp4 or \.gif file"):
        write_stress_animation(by_modes, SHOE, tmp_path / "shoe.png")
    with pytest.raises(ValueError, match="speed must be positive, got 0"):
        write_stress_animation(by_modes, SHOE, tmp_path / "shoe.gif", speed=0.0)
    assert not list(tmp_path.iterdir())
