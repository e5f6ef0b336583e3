"""Reductions and static fields kept on disk, by the digest of all that each of them depends on."""

import hashlib
import json
import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fem.body import ElasticBody
from fem.fields import StaticFields, UnitLoads, static_fields
from fem.files import load_fields, load_reduced, save_fields, save_reduced
from fem.hdf5 import REDUCED_BODY, STATIC_FIELDS
from fem.interfaces import Interface
from fem.keeping import kept_path, taken_or_made
from fem.mesh import Floats
from fem.reduced import ReducedBody
from fem.reduction import Partition, craig_bampton
from fem.sources import FEM, source_digest

FIELDS_SUFFIX = ".fields"
"""Of files of static fields, before the ending; reductions have none."""

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


class KeptFields(NamedTuple):
    """Static fields and where they are kept.

    Attributes
    ----------
    fields : StaticFields
    path : Path
        Their file.
    found : bool
        Whether it was there already.
    """

    fields: StaticFields
    path: Path
    found: bool


def reduction_digest(
    body: ElasticBody,
    interfaces: Sequence[Interface],
    n_fixed_modes: int,
    residual_loads: Mapping[str, Floats] | None = None,
) -> str:
    """SHA-256 of everything that a reduction depends on, this package's sources included."""
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
) -> Kept:
    """Reduced body from a folder if it is kept there, else made anew and kept.

    How it is kept is what `keeping.taken_or_made` says.

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
    path = kept_path(folder, digest)
    reduced, found = taken_or_made(
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
) -> KeptFields:
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
    sha = hashlib.sha256((STATIC_FIELDS + kept.path.name).encode())
    for name, family in families.items():
        sha.update(json.dumps([name, *family.nodal.shape, family.by_mass]).encode())
        for array in (family.nodal.data, family.nodal.indices, family.nodal.indptr, family.centers):
            sha.update(np.ascontiguousarray(array).tobytes())
    digest = sha.hexdigest()
    path = kept_path(folder, digest, FIELDS_SUFFIX)
    fields, found = taken_or_made(
        path,
        lambda: load_fields(path, digest),
        lambda: static_fields(Partition(body, kept.body.interfaces), kept.body, families),
        lambda made: save_fields(path, made, digest),
        warn,
        "the file of static fields",
    )
    return KeptFields(fields, path, found)
