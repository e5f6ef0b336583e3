"""Where runs are kept: folders, and object storage as fsspec's addresses reach it."""

import json

import pytest

from exudyn_crawler.sweep.storage import (
    OUTCOME,
    check_storage,
    folder_of,
    read_outcome,
    working_folder,
    write_outcome,
)

DIGEST = "0123456789abcdef" * 4
FOUND = {"digest": DIGEST, "status": "done", "answers": {"force": 1.0}}


@pytest.fixture(params=["folder", "address"])
def storage(request, tmp_path):
    return str(tmp_path / "runs") if request.param == "folder" else (tmp_path / "runs").as_uri()


def test_what_a_run_leaves_is_in_the_storage_and_found_again(storage, tmp_path):
    assert read_outcome(storage, DIGEST) is None
    with working_folder(storage, DIGEST) as folder:
        (folder / "checkpoints").mkdir()
        (folder / "checkpoints" / "stage").write_text("half")
        write_outcome(folder, FOUND)
    assert read_outcome(storage, DIGEST) == FOUND
    kept = tmp_path / "runs" / DIGEST[:16]
    assert (kept / "checkpoints" / "stage").read_text() == "half"
    with working_folder(storage, DIGEST) as folder:
        assert (folder / "checkpoints" / "stage").read_text() == "half"


def test_what_a_run_left_that_went_wrong_is_there_too(storage, tmp_path):
    def fail():
        with working_folder(storage, DIGEST) as folder:
            (folder / "run.log").write_text("so far")
            raise KeyError

    with pytest.raises(KeyError):
        fail()
    assert (tmp_path / "runs" / DIGEST[:16] / "run.log").read_text() == "so far"


def test_object_storage_has_no_file_while_a_run_works(tmp_path):
    with working_folder((tmp_path / "runs").as_uri(), DIGEST) as folder:
        write_outcome(folder, FOUND)
        assert not (tmp_path / "runs").exists()
        assert tmp_path not in folder.parents or "exudyn-crawler-" in folder.parent.name


@pytest.mark.parametrize(
    "text",
    ["", "[]", "{", json.dumps(FOUND | {"digest": "another"}), json.dumps(FOUND | {"answers": 1})],
)
def test_outcomes_of_others_and_broken_ones_count_for_nothing(storage, tmp_path, text):
    kept = tmp_path / "runs" / DIGEST[:16]
    kept.mkdir(parents=True)
    (kept / OUTCOME).write_text(text)
    assert read_outcome(storage, DIGEST) is None


def test_storage_that_cannot_be_written_to_is_refused(tmp_path):
    check_storage((tmp_path / "runs").as_uri())
    assert list((tmp_path / "runs").iterdir()) == []
    with pytest.raises(ValueError, match="storage must be an address that can be written to, got nosuch://b"):
        check_storage("nosuch://bucket")
    (tmp_path / "file").touch()
    with pytest.raises(ValueError, match="storage must be an address that can be written to"):
        check_storage((tmp_path / "file" / "runs").as_uri())


def test_folders_are_named_by_the_digest():
    assert folder_of("s3://bucket/runs/", DIGEST) == "s3://bucket/runs/0123456789abcdef"
