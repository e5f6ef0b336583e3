"""Recovered histories against brute force, hot spots on a body small enough to check, and files."""

from pathlib import Path

import meshio
import numpy as np
import pytest

import fem
from fem.recovery import shares
from fem.stress import CRITERIA, evaluate
from tests.fem.conftest import STEEL, beam_interfaces


@pytest.fixture(scope="module")
def small(beam: fem.ElasticBody) -> fem.ReducedBody:
    return fem.craig_bampton(beam, beam_interfaces(beam), 20)


@pytest.fixture(scope="module")
def history(small: fem.ReducedBody) -> np.ndarray:
    rng = np.random.default_rng(4)
    return rng.standard_normal((700, len(small.frequencies))) / small.frequencies**2


@pytest.mark.parametrize("criterion", CRITERIA)
def test_peaks_against_brute_force(
    small: fem.ReducedBody, history: np.ndarray, criterion: fem.stress.Criterion
) -> None:
    values = evaluate(criterion, small.stress(history))
    least = criterion == "least principal"
    at = values.argmin(axis=0) if least else values.argmax(axis=0)
    blocks = iter([history[:100], history[100:101], history[101:]])
    for q in (history, blocks):
        peaks = fem.recover_peaks(small.stress_modes, q, criterion)
        np.testing.assert_array_equal(peaks.time_indices, at)
        expected = np.take_along_axis(values, at[None], axis=0)[0]
        np.testing.assert_allclose(peaks.values, expected, rtol=1e-9)


def test_faulty_histories(small: fem.ReducedBody, history: np.ndarray) -> None:
    with pytest.raises(ValueError, match="history has 3 modal coordinates"):
        fem.recover_peaks(small.stress_modes, history[:, :3])
    with pytest.raises(ValueError, match="no rows"):
        fem.recover_peaks(small.stress_modes, history[:0])
    spoilt = history.copy()
    spoilt[300, 2] = np.inf
    with pytest.raises(ValueError, match="not finite between rows 256 and 511"):
        fem.recover_peaks(small.stress_modes, spoilt)
    with pytest.raises(ValueError, match="criterion = 'tresca'"):
        fem.recover_peaks(small.stress_modes, history, "tresca")  # type: ignore[arg-type]


def test_shares_add_up(small: fem.ReducedBody, history: np.ndarray) -> None:
    parts = shares(small.stress_modes, history[5], 17)
    assert parts.sum() == pytest.approx(small.von_mises(history[5], np.array([17]))[0, 0])


def test_hot_spots_rank_flag_and_separate(small: fem.ReducedBody, history: np.ndarray) -> None:
    times = 0.001 * np.arange(len(history))
    table = fem.hot_spots(small, times, history, 10)
    assert list(table["rank"]) == list(range(1, 11))
    assert table["value"].is_monotonic_decreasing
    top = table.iloc[0]
    row = round(top["time"] / 0.001)
    assert small.von_mises(history[row])[0, top["node"]] == pytest.approx(top["value"])
    assert small.von_mises(history).max() == pytest.approx(top["value"])
    inside = np.isin(table["node"], small.spider_nodes)
    assert (inside == (table["flag"] == "in spider")).all()

    apart = fem.hot_spots(small, times, history, 4, separation="radius", radius=0.2)
    places = apart[["x", "y", "z"]].to_numpy()
    gaps = np.linalg.norm(places[:, None] - places[None], axis=2)[np.triu_indices(len(apart), 1)]
    assert (gaps > 0.2).all()

    free = fem.hot_spots(small, times, history, 5, with_spiders=False, window=(0.1, 0.2))
    assert (free["flag"] == "").all()
    assert free["time"].between(0.1, 0.2).all()


def test_regions_have_one_peak_each(small: fem.ReducedBody) -> None:
    # pure bending is greatest at opposite faces, with a calm core in between
    mode = np.zeros(len(small.frequencies))
    mode[0] = 1.0
    table = fem.hot_spots(small, [0.0], mode, 10, separation="regions", fraction=0.7, criterion="von mises")
    assert len(table) == 2


def test_jump_tells_a_peak_that_the_mesh_makes(beam: fem.ElasticBody) -> None:
    smooth = beam.mesh.nodes @ np.diag([1e-4, 0.0, 0.0])
    assert fem.stress.stress_jump(beam.mesh, STEEL, smooth).max() < 1e-3  # Pa; rounding
    kinked = np.where(beam.mesh.nodes[:, :1] > 0.3, beam.mesh.nodes - 0.3, 0.0) * [1e-4, 0, 0]
    jump = fem.stress.stress_jump(beam.mesh, STEEL, kinked)
    at_kink = np.abs(beam.mesh.nodes[:, 0] - 0.3) < 1e-9
    assert jump[at_kink].min() > 0.2 * 200e9 * 1e-4
    assert jump[np.abs(beam.mesh.nodes[:, 0] - 0.3) > 0.11].max() < 1e-3


def test_bad_requests(small: fem.ReducedBody, history: np.ndarray) -> None:
    times = np.arange(len(history))
    with pytest.raises(ValueError, match="nothing to look at: 0 times"):
        fem.hot_spots(small, times, history, window=(-2, -1))
    with pytest.raises(ValueError, match="count = 0"):
        fem.hot_spots(small, times, history, 0)


def test_file_round_trip_and_stale_cache(
    tmp_path: Path, beam: fem.ElasticBody, small: fem.ReducedBody
) -> None:
    path = tmp_path / "beam.h5"
    fem.save_reduced(path, small, "abc")
    back = fem.load_reduced(path, beam.mesh, "abc")
    for name in ("frequencies", "modes", "stress_modes", "pilots", "inertia"):
        np.testing.assert_array_equal(getattr(back, name), getattr(small, name))
    assert fem.load_reduced(path).mesh.digest == beam.mesh.digest
    assert [i.name for i in back.interfaces] == ["left", "right"]
    with pytest.raises(fem.StaleCacheError, match="other parameters"):
        fem.load_reduced(path, digest="abd")
    other = fem.Mesh(beam.mesh.nodes * 1.01, beam.mesh.elements, {})
    with pytest.raises(fem.StaleCacheError, match="another mesh"):
        fem.load_reduced(path, other)
    (tmp_path / "no.h5").write_text("nothing")
    with pytest.raises(ValueError, match="no HDF5 file"):
        fem.load_reduced(tmp_path / "no.h5")


def test_cache_is_used_only_if_all_matches(tmp_path: Path, beam: fem.ElasticBody) -> None:
    path, ends = tmp_path / "cache.h5", beam_interfaces(beam)
    first = fem.cached_craig_bampton(path, beam, ends, 4)
    stamp = path.stat().st_mtime_ns
    again = fem.cached_craig_bampton(path, beam, ends, 4)
    np.testing.assert_array_equal(first.modes, again.modes)
    assert path.stat().st_mtime_ns == stamp
    more = fem.cached_craig_bampton(path, beam, ends, 5)
    assert len(more.frequencies) == len(first.frequencies) + 1


def test_a_broken_cache_is_named_and_left_as_it_is(tmp_path: Path, beam: fem.ElasticBody) -> None:
    path, ends = tmp_path / "cache.h5", beam_interfaces(beam)
    fem.cached_craig_bampton(path, beam, ends, 4)
    whole = path.read_bytes()
    for broken in (b"", b"nothing", whole[: len(whole) // 2], whole[:100] + b"x" * 5000 + whole[5100:]):
        path.write_bytes(broken)
        with pytest.raises(ValueError, match=r"cache\.h5 is (no HDF5 file|broken|no 'fem reduced body 1')"):
            fem.cached_craig_bampton(path, beam, ends, 4)
        assert path.read_bytes() == broken
    assert list(tmp_path.iterdir()) == [path]


def test_a_cache_that_finds_no_room_leaves_the_old_one(
    tmp_path: Path, beam: fem.ElasticBody, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, ends = tmp_path / "cache.h5", beam_interfaces(beam)
    fem.cached_craig_bampton(path, beam, ends, 4)
    whole = path.read_bytes()

    def full(*_args: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(OSError, match="No space left"):
        fem.cached_craig_bampton(path, beam, ends, 5)
    assert path.read_bytes() == whole
    assert list(tmp_path.iterdir()) == [path]


def test_vtu_of_a_frame(tmp_path: Path, small: fem.ReducedBody, history: np.ndarray) -> None:
    fem.write_frame_vtu(tmp_path / "frame.vtu", small, history[3])
    fem.write_modes_vtu(tmp_path / "modes.vtu", small, [0, 2])
    frame = meshio.read(tmp_path / "frame.vtu")
    np.testing.assert_allclose(frame.point_data["von mises"], small.von_mises(history[3])[0], rtol=1e-12)
    np.testing.assert_allclose(
        meshio.read(tmp_path / "modes.vtu").point_data["stress 2"], small.stress_modes[:, :, 2]
    )


def test_extremes_are_those_of_the_whole_field(reduced: fem.ReducedBody) -> None:
    q = np.random.default_rng(5).normal(size=(600, len(reduced.frequencies)))
    q /= (2 * np.pi * reduced.frequencies) ** 2
    found = fem.recover_extremes(reduced.stress_modes, q)
    field = np.concatenate([reduced.von_mises(part) for part in np.array_split(q, 12)])
    np.testing.assert_allclose(found.greatest, field.max(axis=0), rtol=1e-9)
    np.testing.assert_array_equal(found.greatest_at, field.argmax(axis=0))
    np.testing.assert_allclose(found.least, field.min(axis=0), rtol=1e-6, atol=1.0)
    np.testing.assert_allclose(found.highest, field.max(axis=1), rtol=1e-9)
    np.testing.assert_array_equal(found.highest_nodes, field.argmax(axis=1))
    table = fem.hot_spots(reduced, np.arange(600.0), q)
    known = fem.hot_spots(reduced, np.arange(600.0), q, peaks=found.peaks)
    np.testing.assert_array_equal(known["node"], table["node"])
    np.testing.assert_allclose(known["value"], table["value"], rtol=1e-9)
