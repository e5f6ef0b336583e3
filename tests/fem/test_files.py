"""Reduced bodies in files: round trips, files of others and broken ones."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fem


def test_file_round_trip_and_stale_cache(tmp_path: Path, small: fem.ReducedBody) -> None:
    mesh = small.mesh
    path = tmp_path / "beam.h5"
    fem.save_reduced(path, small, "abc")
    back = fem.load_reduced(path, mesh, "abc")
    for name in ("frequencies", "modes", "stress_modes", "pilots", "inertia", "ritz"):
        np.testing.assert_array_equal(getattr(back, name), getattr(small, name))
    assert fem.load_reduced(path).mesh.digest == mesh.digest
    assert [i.name for i in back.interfaces] == ["left", "right"]
    with pytest.raises(fem.StaleCacheError, match="these parameters"):
        fem.load_reduced(path, digest="abd")
    with pytest.raises(fem.StaleCacheError, match="belong to this mesh"):
        fem.load_reduced(path, replace(mesh, nodes=1.01 * mesh.nodes))


def test_broken_files_are_named(tmp_path: Path, small: fem.ReducedBody) -> None:
    path = tmp_path / "beam.h5"
    fem.save_reduced(path, small)
    whole = path.read_bytes()
    modes = whole.index(small.modes[0].tobytes())
    for broken, words in (
        (b"", "an HDF5 file"),
        (b"nothing", "an HDF5 file"),
        (whole[: len(whole) // 2], "an HDF5 file"),
        (whole[:100] + b"x" * 5000 + whole[5100:], "whole|an HDF5 file"),
        (whole[: modes + 64] + bytes(8) + whole[modes + 72 :], "whole"),
    ):
        path.write_bytes(broken)
        with pytest.raises(ValueError, match=rf"beam\.h5 must be ({words})"):
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
