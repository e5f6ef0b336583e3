"""Disk cache of reductions and static fields, by the digest of everything that they depend on.

Files end in ``.h5`` and may be removed at any time. Several processes may use them at once, and broken ones
are computed again.
"""

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

from fem.body.bores import bore_faces
from fem.body.elastic_body import ElasticBody
from fem.body.elasticity import Material
from fem.body.interfaces import Interface
from fem.body.mesh import Floats
from fem.body.pin_contact import PinContact, pin_contact
from fem.body.reduced import ReducedBody
from fem.body.reduction import Partition, craig_bampton
from fem.files.hdf5 import PIN_PRESSURES, REDUCED_BODY, STATIC_FIELDS
from fem.files.reduced_files import (
    load_fields,
    load_pressures,
    load_reduced,
    save_fields,
    save_pressures,
    save_reduced,
)
from fem.sources import FEM, source_digest
from fem.stress.static_fields import StaticFields, UnitLoads, static_fields

FIELDS_SUFFIX = ".fields"
"""Suffix of files of static fields before ``.h5``; reductions have none."""
PINS_SUFFIX = ".pins"
"""Suffix of files of pressures of pins before ``.h5``."""
LIMIT = 3e9
"""Size of a folder, bytes, above which the least recently used files go. The study mesh takes 0.3e9."""
NAMED_BY = 32
"""Number of characters of a digest in the name of its file."""

Result = TypeVar("Result")

logger = logging.getLogger(__name__)


class CachedReduction(NamedTuple):
    """Reduction and its file.

    Attributes
    ----------
    body : ReducedBody
    path : Path
        File of the reduction.
    existed : bool
        True if the file existed before.
    """

    body: ReducedBody
    path: Path
    existed: bool


class CachedFields(NamedTuple):
    """Static fields and their file.

    Attributes
    ----------
    fields : StaticFields
    path : Path
        File of the fields.
    existed : bool
        True if the file existed before.
    """

    fields: StaticFields
    path: Path
    existed: bool


def reduction_digest(
    body: ElasticBody,
    interfaces: Sequence[Interface],
    n_fixed_modes: int,
    residual_loads: Mapping[str, Floats] | None = None,
) -> str:
    """Return the SHA-256 of everything that a reduction depends on, this package's sources included."""
    sha = hashlib.sha256((REDUCED_BODY + source_digest(FEM)).encode())
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
    partition: Partition | None = None,
) -> CachedReduction:
    """Read a reduced body from a folder, or compute it and save it there, see `_read_or_computed`.

    Parameters
    ----------
    folder : str or Path
        Created if it is missing.
    body, interfaces, n_fixed_modes, residual_loads, partition
        See `craig_bampton`; errors are the same too.
    warn : callable
        Gets a line about a file that is broken or cannot be written.
    """
    digest = reduction_digest(body, interfaces, n_fixed_modes, residual_loads)
    path = _cache_path(folder, digest)
    reduced, existed = _read_or_computed(
        path,
        lambda: load_reduced(path, body.mesh, digest),
        lambda: craig_bampton(body, interfaces, n_fixed_modes, residual_loads, partition=partition),
        lambda computed: save_reduced(path, computed, digest),
        warn,
        "the reduction",
    )
    return CachedReduction(reduced, path, existed)


def cached_static_fields(
    folder: str | Path,
    partition: Partition,
    reduction: CachedReduction,
    families: Mapping[str, UnitLoads],
    warn: Callable[[str], None] = logger.warning,
) -> CachedFields:
    """Read static fields of a cached reduction from a folder, or compute them and save them there.

    Parameters
    ----------
    folder : str or Path
        Created if it is missing.
    partition : Partition
        Partition of the reduced body, with the same interfaces.
    reduction : CachedReduction
        Result of `cached_craig_bampton`.
    families : mapping of str to UnitLoads
        See `static_fields`; errors are the same too.
    warn : callable
        Gets a line about a file that is broken or cannot be written.
    """
    sha = hashlib.sha256((STATIC_FIELDS + reduction.path.name).encode())
    for name, family in families.items():
        sha.update(json.dumps([name, *family.nodal.shape, family.by_mass]).encode())
        for array in (family.nodal.data, family.nodal.indices, family.nodal.indptr, family.centers):
            sha.update(np.ascontiguousarray(array).tobytes())
    digest = sha.hexdigest()
    path = _cache_path(folder, digest, FIELDS_SUFFIX)
    fields, existed = _read_or_computed(
        path,
        lambda: load_fields(path, digest),
        lambda: static_fields(partition, reduction.body, families),
        lambda computed: save_fields(path, computed, digest),
        warn,
        "the file of static fields",
    )
    return CachedFields(fields, path, existed)


def cached_pin_contacts(
    folder: str | Path, partition: Partition, pin: Material, warn: Callable[[str], None] = logger.warning
) -> tuple[PinContact, ...]:
    """Read the pressures of all pins in contact from a folder, or compute them and save them there.

    Parameters
    ----------
    folder : str or Path
        Created if it is missing.
    partition : Partition
        Partition of the body, with its interfaces.
    pin : Material
        Material of the pins.
    warn : callable
        Gets a line about a file that is broken or cannot be written.

    Returns
    -------
    tuple of PinContact
        One for each interface with the spider "contact"; errors are those of `pin_contact`.
    """
    bores = [interface for interface in partition.interfaces if interface.spider == "contact"]
    if not bores:
        return ()
    body = partition.body
    digest = hashlib.sha256(
        (PIN_PRESSURES + reduction_digest(body, partition.interfaces, 0) + json.dumps(asdict(pin))).encode()
    ).hexdigest()
    path = _cache_path(folder, digest, PINS_SUFFIX)
    pressures, _ = _read_or_computed(
        path,
        lambda: load_pressures(path, digest),
        lambda: {bore.name: pin_contact(partition, bore, pin).pressures for bore in bores},
        lambda computed: save_pressures(path, computed, digest),
        warn,
        "the file of pressures of pins",
    )
    return tuple(PinContact(bore.name, bore_faces(body.mesh, bore), pressures[bore.name]) for bore in bores)


def cached_files(folder: str | Path) -> list[Path]:
    """Return the cached files of a folder, the most recently used first."""
    used = {}
    for path in Path(folder).glob("[!.]*.h5"):  # names of unfinished files begin with a dot
        with suppress(FileNotFoundError):  # another process removed it
            used[path] = path.stat().st_mtime
    return sorted(used, key=used.__getitem__, reverse=True)


def _cache_path(folder: str | Path, digest: str, suffix: str = "") -> Path:
    """Return the path of a digest's file in a folder; `suffix` distinguishes kinds of files."""
    return Path(folder) / f"{digest[:NAMED_BY]}{suffix}.h5"


def _read_or_computed(
    path: Path,
    load: Callable[[], Result],
    compute: Callable[[], Result],
    save: Callable[[Result], None],
    warn: Callable[[str], None],
    what: str,
) -> tuple[Result, bool]:
    """Read the content of a file, or compute and save it; return it with True if the file existed.

    Processes that need the same file at the same time wait for the first of them. A broken file is replaced.
    Nothing is saved if the folder is not writable.

    Parameters
    ----------
    path : Path
        Result of `_cache_path`.
    load : callable
        Reads the file; raises `FileNotFoundError` if there is none, `ValueError` if it is broken.
    compute : callable
        Computes the content.
    save : callable
        Writes the content; raises `OSError` if it cannot.
    warn : callable
        Gets a line about a file that is broken or cannot be written.
    what : str
        Description of the content, for these lines.
    """
    with _alone(path, warn):
        try:
            content = load()
        except FileNotFoundError:
            pass
        except ValueError as error:
            warn(f"{what} is computed again: {error}")
        else:
            with suppress(OSError):
                os.utime(path)
            return content, True
        content = compute()
        try:
            save(content)
            _remove_oldest(path.parent)
        except OSError as error:
            warn(f"{what} is not cached, {path} cannot be written: {error}")
    return content, False


@contextmanager
def _alone(path: Path, warn: Callable[[str], None]) -> Iterator[None]:
    """Hold the lock of a file, if possible; the operating system releases it when a process ends."""
    lock = FileLock(path.with_suffix(".lock"))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        lock.acquire()
    except (OSError, NotImplementedError) as error:
        warn(f"nothing can be cached in {path.parent}: {error}")
    try:
        yield
    finally:
        lock.release()


def _remove_oldest(folder: Path) -> None:
    """Remove the least recently used files of a folder that exceeds the size limit."""
    total = 0
    for path in cached_files(folder):
        with suppress(OSError):
            total += path.stat().st_size
            if total > LIMIT:
                path.unlink()
                path.with_suffix(".lock").unlink(missing_ok=True)
