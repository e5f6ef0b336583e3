"""Reduced bodies in files: round trips, files of others and broken ones."""

from pathlib import Path

import numpy as np
import pytest

import fem


def test_file_round_trip_and_stale_cache(
    tmp_path: Path, beam: fem.ElasticBody, small: fem.ReducedBody
) -> None:
    path = tmp_path / "beam.h5"
    fem.save_reduced(path, small, "abc")
    back = fem.load_reduced(path, beam.mesh, "abc")
    for name in ("frequencies", "modes", "stress_modes", "pilots", "inertia", "ritz"):
        np.testing.assert_array_equal(getattr(back, name), getattr(small, name))
    assert fem.load_reduced(path).mesh.digest == beam.mesh.digest
    assert [i.name for i in back.interfaces] == ["left", "right"]
    with pytest.raises(fem.StaleCacheError, match="these parameters"):
        fem.load_reduced(path, digest="abd")
    other = fem.Mesh(beam.mesh.nodes * 1.01, beam.mesh.elements, {})
    with pytest.raises(fem.StaleCacheError, match="belong to this mesh"):
        fem.load_reduced(path, other)
    (tmp_path / "no.h5").write_text("nothing")
    with pytest.raises(ValueError, match="must be an HDF5 file"):
        fem.load_reduced(tmp_path / "no.h5")


def test_broken_files_are_named(tmp_path: Path, small: fem.ReducedBody) -> None:
    path = tmp_path / "beam.h5"
    fem.save_reduced(path, small)
    whole = path.read_bytes()
    modes = whole.index(small.modes[0].tobytes())
    changed = whole[: modes + 64] + bytes(8) + whole[modes + 72 :]
    for broken in (
        b"",
        b"nothing",
        whole[: len(whole) // 2],
        whole[:100] + b"x" * 5000 + whole[5100:],
        changed,
    ):
        path.write_bytes(broken)
        with pytest.raises(ValueError, match=r"beam\.h5 must be (an HDF5|whole|a 'fem reduced body 3')"):
            fem.load_reduced(path)


def test_a_file_that_finds_no_room_leaves_the_old_one(
    tmp_path: Path, small: fem.ReducedBody, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "beam.h5"
    fem.save_reduced(path, small)
    whole = path.read_bytes()

    def full(*_args: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(OSError, match="No space left"):
        fem.save_reduced(path, small.with_modes([0]))
    assert path.read_bytes() == whole
    assert list(tmp_path.iterdir()) == [path]
