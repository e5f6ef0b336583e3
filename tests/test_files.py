"""Files appear whole or not at all, and nothing is overwritten unasked."""

import os
import tempfile

import pytest

from exudyn_crawler.files import clear_partial_files, whole_file, writable_folder


def test_a_file_takes_its_place_when_the_block_ends(tmp_path):
    path = tmp_path / "table.csv"
    with whole_file(path) as temporary:
        temporary.write_text("whole")
        assert not path.exists()
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".csv"
    assert path.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("old", [None, "old"])
def test_a_file_that_fails_halfway_leaves_nothing_but_the_old_one(tmp_path, old):
    path = tmp_path / "table.csv"
    if old:
        path.write_text(old)

    def fail_halfway():
        with whole_file(path, overwrite=bool(old)) as temporary:
            temporary.write_text("half")
            raise RuntimeError("halfway")

    with pytest.raises(RuntimeError, match="halfway"):
        fail_halfway()
    assert {one.name: one.read_text() for one in tmp_path.iterdir()} == ({"table.csv": old} if old else {})


def test_an_existing_file_is_refused_before_the_block(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("old")
    reached = False
    with pytest.raises(FileExistsError, match=r"table\.csv exists"), whole_file(path):
        reached = True
    assert not reached
    with whole_file(path, overwrite=True) as temporary:
        temporary.write_text("new")
    assert path.read_text() == "new"


def test_a_file_that_appears_in_the_meantime_is_kept(tmp_path):
    path = tmp_path / "table.csv"

    def two_write():
        with whole_file(path) as temporary:
            temporary.write_text("mine")
            path.write_text("theirs")

    with pytest.raises(FileExistsError, match="somebody else in the meantime"):
        two_write()
    assert path.read_text() == "theirs"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("mask", [0o022, 0o077])
def test_a_file_has_the_rights_of_any_new_one(tmp_path, mask):
    before = os.umask(mask)
    try:
        with whole_file(tmp_path / "table.csv") as temporary:
            temporary.write_text("whole")
    finally:
        os.umask(before)
    assert (tmp_path / "table.csv").stat().st_mode & 0o777 == 0o666 & ~mask


def test_a_folder_is_made_with_its_parents_and_not_below_a_file(tmp_path):
    path, file = tmp_path / "a" / "b", tmp_path / "file"
    assert writable_folder(path) == path
    assert list(path.iterdir()) == []
    file.touch()
    for wrong in (file, file / "below"):
        with pytest.raises(NotADirectoryError, match=f"output folder {wrong} is not a folder"):
            writable_folder(wrong)


def test_a_folder_without_rights_is_refused(tmp_path, monkeypatch):
    # a chmod would not stop a superuser
    def refused(*_args, **_options):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(tempfile, "TemporaryFile", refused)
    with pytest.raises(PermissionError, match=f"output folder {tmp_path} cannot be written to: .*denied"):
        writable_folder(tmp_path)


def test_what_a_killed_process_left_half_is_cleared(tmp_path):
    (tmp_path / "below").mkdir()
    for name in (
        ".partial-a1b2c3d4-history.nc",
        "below/.partial-a1b2c3d4-x.csv",
        ".own-a1b2c3d4.csv",
        "a.csv",
    ):
        (tmp_path / name).touch()
    clear_partial_files(tmp_path, below=False)
    assert (tmp_path / "below" / ".partial-a1b2c3d4-x.csv").exists()
    clear_partial_files(tmp_path)
    assert {path.name for path in tmp_path.rglob("*")} == {"below", ".own-a1b2c3d4.csv", "a.csv"}
