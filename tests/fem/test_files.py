"""Reduced bodies in files: round trips, stale and broken caches."""

from pathlib import Path

import numpy as np
import pytest

import fem
from tests.fem.bodies import beam_interfaces


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
    with pytest.raises(ValueError, match="must be an HDF5 file"):
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
        with pytest.raises(ValueError, match=r"cache\.h5 must be (an HDF5|whole|a 'fem reduced body 1')"):
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
