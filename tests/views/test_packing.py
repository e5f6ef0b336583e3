"""Scenes as pages have them: what is packed is what the histories of short runs hold."""

import base64
import json
import re

import numpy as np
import pytest
from hypothesis import example, given, strategies as st
from hypothesis.extra.numpy import arrays

from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.views.pages.packing import SceneArrays, bin_width, packed_scene, thinned
from exudyn_crawler.views.pages.report import INSTANTS, packed_track, report_page
from exudyn_crawler.views.scenes.shoes import stress_scene
from exudyn_crawler.views.scenes.track import forces_on, roller_forces, shoe_forces


def data_of(page):
    return json.loads(re.search(r'id="page-data">(.*?)</script>', page, re.DOTALL)[1])


def unpacked(text, kind):
    return np.frombuffer(base64.b64decode(text), dtype=f"<{kind}")


def over_time(packed, number):
    """Array of a page by its number, a row a time that it holds."""
    one = packed[number]
    return unpacked(one["data"], one["kind"]).reshape(one["rows"], -1) * one.get("step", 1)


def named(parts, name):
    return next(one for one in parts if one["name"] == name)


@pytest.fixture(scope="module")
def moving(translation):
    shared = SceneArrays()
    track = packed_track(translation, shared)
    times = np.linspace(0.0, translation.duration, INSTANTS)
    return track, shared.packed, translation.dataset.sel(time=times, method="nearest")


@example(np.where(np.arange(20_000) == 12_831, 7.0, np.sin(np.arange(20_000) * 1e-3)), 900)
@given(arrays(np.float64, st.integers(1, 500), elements=st.floats(-1e6, 1e6)), st.integers(10, 300))
def test_a_thinned_series_keeps_ends_and_extremes(values, points):
    kept = thinned(values, bin_width(len(values), points))
    assert np.all(np.diff(kept) > 0)
    assert {0, len(values) - 1} <= set(kept.tolist())
    assert (values[kept].min(), values[kept].max()) == (values.min(), values.max())
    assert len(kept) <= max(points, 3)
    if len(values) <= points:
        assert len(kept) == len(values)


def test_shoes_and_forces_are_where_the_history_has_them(moving):
    track, packed, shown = moving
    assert len(track["titles"]) == INSTANTS
    assert track["titles"][-1] == "t = 0.40 s"
    assert [one["name"] for one in track["solids"]] == ["rigid shoes", "ground"]
    shoes, forces = track["solids"][0], named(track["arrows"], "contact forces")
    now = shown.isel(time=50)
    assert over_time(packed, shoes["origin"])[50] == pytest.approx(now.position.values.ravel(), rel=1e-6)
    turned = rotation_matrices(now.angles.values).ravel()
    assert over_time(packed, shoes["turn"])[50] == pytest.approx(turned, abs=1e-6)
    centers, pushes = shoe_forces(shown)
    assert over_time(packed, forces["forces"])[50] == pytest.approx(pushes[50].ravel(), rel=1e-6, abs=1e-2)
    assert over_time(packed, forces["heads"])[50] == pytest.approx(centers[50].ravel(), rel=1e-6)


def test_ground_moves_as_the_history_says(moving, translation):
    track, packed, _ = moving
    ground, terrain = named(track["solids"], "ground"), translation.case.terrain
    heave = over_time(packed, ground["lift"])
    x, half = terrain.middles[:, 0], 0.5 * terrain.unit_length
    low, high = track["window"][0]
    near = (x + half >= low) & (x - half <= high)
    step = packed[ground["lift"]]["step"]
    assert heave[-1] == pytest.approx(translation.unit_heave.isel(time=-1).values[near], abs=step)
    (colours,) = ground["colourings"]
    assert over_time(packed, colours["values"])[-1] == pytest.approx(1e3 * heave[-1], abs=2e3 * step)
    places = over_time(packed, ground["origin"]).reshape(-1, 3)
    assert places[:, 0] == pytest.approx(x[near], abs=1e-5)
    # no shoe leaves the window
    origin = over_time(packed, track["solids"][0]["origin"])[:, ::3]
    assert ((low < origin) & (origin < high)).all()


def test_side_frame_and_rollers_are_packed_with_a_rolled_track(rolled):
    shared = SceneArrays()
    track = packed_track(rolled, shared)
    frame, treads = (named(track["solids"], name) for name in ("side frame", "rollers"))
    assert treads["labels"] == ("roller 1", "roller 1", "roller 2", "roller 2", "roller 3", "roller 3")
    now = rolled.dataset.isel(time=[-1])
    origin = over_time(shared.packed, frame["origin"])[-1]
    assert origin == pytest.approx(now.side_frame_position.values[0], rel=1e-6)
    beam = over_time(shared.packed, frame["points"]).reshape(-1, 3)
    assert np.prod(np.ptp(beam, axis=0)) > 0.0
    places, forces = (one[0] for one in roller_forces(now))
    packed = named(track["arrows"], "forces of rollers")
    assert over_time(shared.packed, packed["heads"])[-1] == pytest.approx(places.ravel(), rel=1e-6)
    assert over_time(shared.packed, packed["forces"])[-1] == pytest.approx(forces.ravel(), rel=1e-6, abs=1e-2)


def test_flexible_shoes_of_a_rolled_track_have_its_rollers(bent, bent_stress):
    shared = SceneArrays()
    scene = packed_scene(stress_scene(bent_stress, bent), shared)
    treads = named(scene["solids"], "rollers")
    # those that are far from the shoes are left out
    assert np.isnan(over_time(shared.packed, treads["origin"])).any()
    now = bent.dataset.sel(time=[float(bent_stress.frame[-1])], method="nearest")
    for shoe in (5, 6):
        forces = next(one["forces"] for one in scene["arrows"] if one["solid"] == f"shoe {shoe}")
        packed = over_time(shared.packed, forces)[-1].reshape(-1, 3)
        assert np.nansum(packed, axis=0) == pytest.approx(forces_on(now, shoe)[1][0].sum(axis=0), rel=1e-5)
    # both are the same shape
    assert len({named(scene["solids"], f"shoe {shoe}")["points"] for shoe in (5, 6)}) == 1


def test_a_rolled_run_is_reported_with_its_rollers(rolled, tmp_path):
    rolled.save(tmp_path / "history.nc")
    page = report_page(tmp_path)
    data = data_of(page)
    assert data["first"] == ["pull of the drive", "roller force"]
    (quantities,) = (one["quantities"] for one in data["cases"].values())
    labels = {quantity["label"] for quantity in quantities}
    assert {"roller force", "force of all rollers", "angle of the side frame"} <= labels
    # they are zero for all times
    assert not labels & {"drive force", "machine and dipper load", "force of the drive"}
    assert all(words in page for words in ("greatest pull of the drive", "each roller on the rails"))
    assert [one["drawn"] for one in quantities if one["label"] == "roller force"] == [[1, 2, 3]]
    (track,) = data["scenes"]["track"].values()
    assert {"side frame", "rollers"} <= {one["name"] for one in track["solids"]}
