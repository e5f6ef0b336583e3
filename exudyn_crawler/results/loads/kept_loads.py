"""Loads on the flexible shoes of saved histories, kept on disk: who looks again does not read the history."""

import hashlib
import logging
from pathlib import Path
from typing import NamedTuple

import h5py
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.model.reductions import program_digest, reductions_folder
from exudyn_crawler.netcdf import sealed_digest
from fem.hdf5 import read_whole, write_rows, write_whole
from fem.keeping import kept_path, taken_or_made
from meshes import mesh_path

KIND = "exudyn crawler shoe loads 1"
SUFFIX = ".loads"
"""Of these files among the reductions, before the ending."""
MOST_KEPT = 3e8
"""Bytes of loads that are kept at most, a tenth of a folder: those of a shoe in 400 s of the stress study."""

logger = logging.getLogger("exudyn_crawler")


class KeptLoads(NamedTuple):
    """Loads on a flexible shoe over a run, and where the stress is that a unit of each makes.

    Attributes
    ----------
    time : array (times,)
        s
    loads : array (times, k)
        As of `stress_columns.acting_loads`.
    reduction : Path
        File of the shoe's `fem.ReducedBody`, of all modes.
    fields : Path or None
        File of its static fields, if the case asks for them.
    """

    time: NDArray
    loads: NDArray
    reduction: Path
    fields: Path | None


def kept_loads(path: Path, case: Case, shoe: int) -> KeptLoads:
    """Loads on a flexible shoe of a history in a file, from the folder of reductions if they are kept there.

    They are kept by the digests of the history, of the shoe's mesh and of this program's sources.

    Parameters
    ----------
    path : Path
        File of the history.
    case : Case
        Its case, of `case_in_file`.
    shoe : int
        One of its flexible shoes.

    Raises
    ------
    FileNotFoundError, ValueError
        As of `History.load` and `acting_loads`.
    """
    kept = kept_path(reductions_folder(), _digest(path, mesh_path(case.flexible_shoes().mesh), shoe), SUFFIX)
    found, _ = taken_or_made(
        kept,
        lambda: _load(kept),
        lambda: _made(path, shoe),
        lambda made: _save(kept, made),
        logger.warning,
        f"the file of shoe {shoe}'s loads",
    )
    return found


def _digest(history: Path, mesh: Path, shoe: int) -> str:
    """SHA-256 of all that loads depend on."""
    sha = hashlib.sha256(f"{KIND} {program_digest()} {shoe}".encode())
    if not mesh.is_file():
        raise FileNotFoundError(f"no mesh file {mesh}")
    # the seal of the history was proved when its case was read
    sha.update(sealed_digest(history) or _file_digest(history))
    sha.update(_file_digest(mesh))
    return sha.hexdigest()


def _file_digest(path: Path) -> bytes:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").digest()


def _made(path: Path, shoe: int) -> KeptLoads:
    # what is kept must not wait for what makes it
    from exudyn_crawler.model.flexible_shoes import whole_reduction
    from exudyn_crawler.results.history.history import History
    from exudyn_crawler.results.stress.stress_columns import acting_loads, fields_of

    history = History.load(path)
    fields = fields_of(history.case)
    return KeptLoads(
        history.time.values,
        acting_loads(history, shoe),
        whole_reduction(history.case).path,
        None if fields is None else fields.path,
    )


def _save(path: Path, made: KeptLoads) -> None:
    def fill(file: h5py.File) -> None:
        write_rows(file, "time", made.time)
        write_rows(file, "loads", made.loads)
        file.attrs["reduction"] = made.reduction.name
        file.attrs["fields"] = "" if made.fields is None else made.fields.name

    if made.loads.nbytes <= MOST_KEPT:
        write_whole(path, KIND, fill)


def _load(path: Path) -> KeptLoads:
    def read(file: h5py.File) -> KeptLoads:
        fields = file.attrs["fields"]
        return KeptLoads(
            file["time"][()],
            file["loads"][()],
            path.parent / file.attrs["reduction"],
            path.parent / fields if fields else None,
        )

    return read_whole(path, KIND, read)
