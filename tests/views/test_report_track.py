"""The report's moving track and its rollers: what is packed is what the history of a short run holds."""

import json
import re

import numpy as np
import pytest

from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.views.placement import instant, shoe_forces
from exudyn_crawler.views.report.page import report_page
from exudyn_crawler.views.report.shoes import packed_shoes
from exudyn_crawler.views.report.track import INSTANTS, packed_track
from exudyn_crawler.views.undercarriage import acting, roller_presses
from tests.views.test_report import unpacked


def over_time(track, key):
    return unpacked(track[key], "f4").reshape(len(track["times"]), -1)


def test_shoes_and_forces_are_where_the_history_has_them(translation):
    track = packed_track(translation)
    assert len(track["times"]) == INSTANTS
    assert track["times"][-1] == translation.duration
    assert track["undercarriage"] is None
    now = instant(translation, track["times"][50])
    assert over_time(track, "origin")[50] == pytest.approx(now.position.values.ravel(), rel=1e-6)
    turned = rotation_matrices(now.angles.values).ravel()
    assert over_time(track, "turn")[50] == pytest.approx(turned, abs=1e-6)
    centers, forces = shoe_forces(now)
    assert over_time(track, "forces")[50] == pytest.approx(forces.ravel(), rel=1e-6, abs=1e-2)
    assert over_time(track, "points")[50] == pytest.approx(centers.ravel(), rel=1e-6)


def test_ground_moves_as_the_history_says(translation):
    track = packed_track(translation)
    ground = track["ground"]
    heave = ground["step"] * unpacked(ground["heave"], "i2").reshape(len(track["times"]), -1)
    x = translation.case.terrain.middles[:, 0]
    low, high = track["window"][0]
    near = (x >= low) & (x <= high)
    expected = translation.unit_heave.isel(time=-1).values[near]
    assert heave[-1] == pytest.approx(expected, abs=ground["step"])
    corners = unpacked(ground["corners"], "f4").reshape(-1, 4, 3)
    assert corners.mean(axis=1)[:, 0] == pytest.approx(x[near], abs=1e-5)
    # no shoe leaves the window
    assert (over_time(track, "origin")[:, ::3] > low).all()
    assert (over_time(track, "origin")[:, ::3] < high).all()


def test_side_frame_and_rollers_are_packed_with_a_rolled_track(rolled):
    track = packed_track(rolled)
    frame = track["undercarriage"] | {"times": track["times"]}
    assert frame["rollers"] == list(rolled.case.undercarriage.rollers)
    now = instant(rolled, track["times"][-1])
    assert over_time(frame, "origin")[-1] == pytest.approx(now.side_frame_position.values, rel=1e-6)
    places, forces = roller_presses(now)
    assert over_time(frame, "points")[-1] == pytest.approx(places.ravel(), rel=1e-6)
    assert over_time(frame, "forces")[-1] == pytest.approx(forces.ravel(), rel=1e-6, abs=1e-2)
    assert forces.sum(axis=0) == pytest.approx(now.roller_force.sum(("roller", "rail")).values)


def test_flexible_shoes_of_a_rolled_track_have_its_rollers(bent, bent_stress):
    packed = packed_shoes(bent_stress, bent)
    frame = packed["frames"][-1]
    now = instant(bent, float(bent_stress.frame[-1]))
    assert frame["side_frame"]["origin"] == pytest.approx(now.side_frame_position.values)
    for place, shoe in enumerate(packed["shoes"]):
        _, forces = acting(now, shoe)
        total = unpacked(frame["forces"][place], "f4").reshape(-1, 3).sum(axis=0)
        assert total == pytest.approx(forces.sum(axis=0), rel=1e-5)


def test_a_rolled_run_is_reported_with_its_rollers(rolled, tmp_path):
    rolled.save(tmp_path / "history.nc")
    page = report_page(tmp_path)
    data = json.loads(re.search(r'id="report-data">(.*?)</script>', page, re.DOTALL)[1])
    assert data["first"] == ["pull of the drive", "roller force"]
    (quantities,) = (one["quantities"] for one in data["cases"].values())
    labels = {quantity["label"] for quantity in quantities}
    assert {"roller force", "force of all rollers", "angle of the side frame"} <= labels
    # they are zero for all times
    assert not labels & {"drive force", "machine and dipper load", "force of the drive"}
    assert "greatest pull of the drive" in page
    assert "each roller on the rails" in page
    forces = next(quantity for quantity in quantities if quantity["label"] == "roller force")
    assert forces["drawn"] == [1, 2, 3]
    (track,) = data["tracks"].values()
    assert np.prod(np.diff(track["undercarriage"]["beam"], axis=0)) > 0.0
