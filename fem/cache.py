"""Reductions and static fields kept on disk: a file each, named by the digest of all that it depends on."""

import hashlib
import json
import logging
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np
from filelock import FileLock

from fem.body import ElasticBody
from fem.compiling import FEM, source_digest
from fem.fields import StaticFields, UnitLoads, static_fields
from fem.files import FIELDS_FORMAT, FORMAT, load_fields, load_reduced, save_fields, save_reduced
from fem.interfaces import Interface
from fem.mesh import Floats
from fem.reduced import ReducedBody
from fem.reduction import Partition, craig_bampton

LIMIT = 3e9
"""Bytes that a folder may hold; what was not used for longest goes first. The study mesh takes 0.2e9."""

FIELDS_SUFFIX = ".fields.h5"
"""Ending of files of static fields, which reductions do not have."""

Made = TypeVar("Made")

logger = logging.getLogger(__name__)


class Kept(NamedTuple):
    """A reduction and where it is kept.

    Attributes
    ----------
    body : ReducedBody
    path : Path
        Its file.
    found : bool
        Whether it was there already.
    """

    body: ReducedBody
    path: Path
    found: bool


def reduction_digest(
    body: ElasticBody,
    interfaces: Sequence[Interface],
    n_fixed_modes: int,
    residual_loads: Mapping[str, Floats] | None = None,
) -> str:
    """SHA-256 of everything that a reduction depends on, this package's sources included."""
    sha = hashlib.sha256((FORMAT + source_digest(FEM)).encode())
    sha.update(body.mesh.digest.encode())
    sha.update(json.dumps([asdict(body.material), n_fixed_modes], sort_keys=True).encode())
    for i in interfaces:
        sha.update(json.dumps([i.name, i.spider]).encode())
        sha.update(i.center.tobytes() + i.nodes.tobytes())
    for name, load in (residual_loads or {}).items():
        sha.update(name.encode() + np.ascontiguousarray(load, dtype=np.float64).tobytes())
    return sha.hexdigest()


def cached_craig_bampton(
    folder: str | Path,
    body: ElasticBody,
    interfaces: Sequence[Interface],
    n_fixed_modes: int = 76,
    residual_loads: Mapping[str, Floats] | None = None,
    warn: Callable[[str], None] = logger.warning,
) -> Kept:
    """Reduced body from a folder if it is kept there, else made anew and kept.

    Processes that want the same reduction at the same time wait for the first of them. A broken file is
    replaced. Where the folder cannot be written to, the reduction is made and not kept.

    Parameters
    ----------
    folder : str or Path
        Made where it is missing.
    body, interfaces, n_fixed_modes, residual_loads
        As of `craig_bampton`, whose errors this has too.
    warn : callable
        Gets a line about a file that is broken or cannot be written.
    """
    digest = reduction_digest(body, interfaces, n_fixed_modes, residual_loads)
    path = Path(folder) / f"{digest[:32]}.h5"
    reduced, found = _taken_or_made(
        path,
        lambda: load_reduced(path, body.mesh, digest),
        lambda: craig_bampton(body, interfaces, n_fixed_modes, residual_loads),
        lambda made: save_reduced(path, made, digest),
        warn,
        "the reduction",
    )
    return Kept(reduced, path, found)


def cached_static_fields(
    folder: str | Path,
    body: ElasticBody,
    kept: Kept,
    families: Mapping[str, UnitLoads],
    warn: Callable[[str], None] = logger.warning,
) -> StaticFields:
    """Static fields beside a kept reduction, from a folder if they are there, else made anew and kept.

    What is said of `cached_craig_bampton` goes for them, too.

    Parameters
    ----------
    folder : str or Path
        Made where it is missing.
    body : ElasticBody
        That was reduced.
    kept : Kept
        Of `cached_craig_bampton`.
    families : mapping of str to UnitLoads
        As of `static_fields`, whose errors this has too.
    warn : callable
        Gets a line about a file that is broken or cannot be written.
    """
    sha = hashlib.sha256((FIELDS_FORMAT + kept.path.name).encode())
    for name, family in families.items():
        sha.update(json.dumps([name, *family.nodal.shape, family.by_mass]).encode())
        for array in (family.nodal.data, family.nodal.indices, family.nodal.indptr, family.centers):
            sha.update(np.ascontiguousarray(array).tobytes())
    digest = sha.hexdigest()
    path = Path(folder) / f"{digest[:32]}{FIELDS_SUFFIX}"
    fields, _ = _taken_or_made(
        path,
        lambda: load_fields(path, digest),
        lambda: static_fields(Partition(body, kept.body.interfaces), kept.body, families),
        lambda made: save_fields(path, made, digest),
        warn,
        "the file of static fields",
    )
    return fields


def _taken_or_made(
    path: Path,
    load: Callable[[], Made],
    make: Callable[[], Made],
    save: Callable[[Made], None],
    warn: Callable[[str], None],
    what: str,
) -> tuple[Made, bool]:
    """What a file holds, or what is made anew and kept in it, and whether it was there."""
    with _alone(path, warn):
        try:
            found = load()
        except FileNotFoundError:
            pass
        except ValueError as error:
            warn(f"{what} is made anew: {error}")
        else:
            with suppress(OSError):
                os.utime(path)
            return found, True
        made = make()
        try:
            save(made)
            _make_room(path.parent)
        except OSError as error:
            warn(f"{what} is not kept, {path} cannot be written: {error}")
    return made, False


def kept_reductions(folder: str | Path) -> list[Path]:
    """Files of reductions and their static fields in a folder, those used last first."""
    used = {}
    for path in Path(folder).glob("[!.]*.h5"):  # a dot before what is being written
        with suppress(FileNotFoundError):  # another process made room
            used[path] = path.stat().st_mtime
    return sorted(used, key=used.__getitem__, reverse=True)


@contextmanager
def _alone(path: Path, warn: Callable[[str], None]) -> Iterator[None]:
    """Hold the lock of a file, if there can be one; the operating system releases it when a process ends."""
    lock = FileLock(path.with_suffix(".lock"))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        lock.acquire()
    except (OSError, NotImplementedError) as error:
        warn(f"reductions cannot be kept in {path.parent}: {error}")
    try:
        yield
    finally:
        lock.release()


def _make_room(folder: Path) -> None:
    """Remove what was not used for longest, as far as a folder holds more than its limit."""
    total = 0
    for path in kept_reductions(folder):
        with suppress(OSError):
            total += path.stat().st_size
            if total > LIMIT:
                path.unlink()
                path.with_suffix(".lock").unlink(missing_ok=True)
