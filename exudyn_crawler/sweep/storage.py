"""Where the runs of a sweep are kept: a folder a run, on a file system or on object storage.

A run needs a file system while it works. On object storage (any address that fsspec knows, ``s3://...``) it
works in a folder of its worker's and is copied there when it has ended; what a worker had that died is lost.
"""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from exudyn_crawler.files import whole_file
from exudyn_crawler.sweep.definition import FOLDER_DIGITS

OUTCOME = "outcome.json"
"""What became of a run of a sweep, in its folder."""

Outcome = dict[str, Any]
"""Of a run: digest, status ("done" or "failed"), reason, answers by name, asked (definitions of the answers),
wall_time_s, host, process and finished."""


def is_address(storage: str) -> bool:
    """Whether runs are kept on object storage."""
    return "://" in storage


def folder_of(storage: str, digest: str) -> str:
    """Folder of a run: a path, or an address."""
    return f"{storage.rstrip('/')}/{digest[:FOLDER_DIGITS]}"


@contextmanager
def working_folder(storage: str, digest: str) -> Iterator[Path]:
    """Folder in which a run works; what it leaves is in the storage after the block, however that ends."""
    place = folder_of(storage, digest)
    if not is_address(storage):
        path = Path(place)
        path.mkdir(parents=True, exist_ok=True)
        yield path
        return
    files, root = _file_system(place)
    with TemporaryDirectory(prefix="exudyn-crawler-") as name:
        path = Path(name) / "run"
        if files.exists(root):
            files.get(root, str(path), recursive=True)
        path.mkdir(exist_ok=True)
        try:
            yield path
        finally:
            # the outcome last: who finds it finds the rest
            for one in sorted(path.rglob("*"), key=lambda one: one.name == OUTCOME):
                if one.is_file():
                    target = f"{root}/{one.relative_to(path).as_posix()}"
                    files.makedirs(target.rpartition("/")[0], exist_ok=True)
                    files.put_file(str(one), target)


def read_outcome(storage: str, digest: str) -> Outcome | None:
    """Outcome of a run; None if it has none that can be read, or it is that of another one."""
    place = f"{folder_of(storage, digest)}/{OUTCOME}"
    try:
        if is_address(storage):
            files, path = _file_system(place)
            text = files.cat_file(path).decode()
        else:
            text = Path(place).read_text(encoding="utf-8")
        found = json.loads(text)
    except (OSError, ValueError):
        return None
    whole = isinstance(found, dict) and found.get("digest") == digest
    return found if whole and isinstance(found.get("answers"), dict) else None


def write_outcome(folder: Path, outcome: Outcome) -> None:
    """Write the outcome of a run into the folder in which it works."""
    with whole_file(folder / OUTCOME, overwrite=True) as temporary:
        temporary.write_text(json.dumps(outcome, indent=2) + "\n", encoding="utf-8")


def check_storage(storage: str) -> None:
    """Refuse object storage that cannot be written to.

    Raises
    ------
    ValueError
        With what is wrong.
    """
    if not is_address(storage):
        return
    try:
        files, root = _file_system(storage)
        files.makedirs(root, exist_ok=True)
        files.pipe_file(f"{root.rstrip('/')}/.written", b"")
        files.rm_file(f"{root.rstrip('/')}/.written")
    # every kind of storage has errors of its own
    except Exception as error:
        reason = " ".join(str(error).split()) or repr(error)
        raise ValueError(
            f"storage must be an address that can be written to, got {storage}: {reason}"
        ) from error


def _file_system(address: str) -> tuple[Any, str]:
    """File system of an address and the path in it."""
    import fsspec  # sweeps into folders do without

    files, path = fsspec.core.url_to_fs(address)
    return files, str(path)
