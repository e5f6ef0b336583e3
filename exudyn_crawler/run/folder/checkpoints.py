"""Stages of a run kept in a folder, so that a run that was stopped goes on where the last one ended.

A file a stage holds the state at its end, the piece of the history that it gave, what both belong to and a
digest of all of it. Of a run that has ended, the end of its last stage but one and its history are enough for
a longer one to go on with.
"""

import hashlib
import json
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from sys import intern
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.case.files.files import saved_case
from exudyn_crawler.files import whole_file, writable_folder
from exudyn_crawler.results.history.files import Chunk, save_joined

VARIABLE = "history "
"""What the names of the history's arrays begin with in a file."""


@dataclass(frozen=True)
class Checkpoint:
    """End of a stage.

    Attributes
    ----------
    number : int
        Of the stage, from 0.
    time : float
        s.
    layout : str
        What the numbers of a state are, as JSON with its version.
    state : array (size of the layout,)
        From which the run goes on.
    history : xarray.Dataset
        What the stage stored.
    """

    number: int
    time: float
    layout: str
    state: NDArray
    history: xr.Dataset


@dataclass(frozen=True)
class KeptStage:
    """Checkpoint in a file, of which memory holds little however many there are.

    Attributes
    ----------
    number, time, layout
        As of `Checkpoint`.
    path : Path
    piece : Chunk
        Its history, read from the file when it is needed.
    """

    number: int
    time: float
    layout: str
    path: Path
    piece: Chunk

    @property
    def state(self) -> NDArray:
        """As of `Checkpoint`, read from the file; ValueError if that was altered."""
        return _arrays(self.path)["state"]


class Checkpoints:
    """Checkpoints of one run in a folder of their own.

    Parameters
    ----------
    folder : Path
        Made with the first checkpoint.
    tell : callable, optional
        Is told, in a line, where a run goes on and what was left out.
    """

    def __init__(self, folder: Path, tell: Callable[[str], None] = lambda _text: None) -> None:
        self.folder = Path(folder)
        self.tell = tell
        self._found: dict[Path, tuple[tuple[int, int], Case, KeptStage]] = {}
        self._cases: dict[str, Case] = {}
        self._left_out: set[Path] = set()

    @property
    def history(self) -> Path:
        """Where `save_history` writes."""
        return self.folder / "assembled.nc"

    @property
    def _earlier(self) -> Path:
        """History of the shorter run that this one goes on with."""
        return self.folder / "earlier.nc"

    def save(self, case: Case, checkpoint: Checkpoint) -> KeptStage:
        """Keep the end of a stage of a case.

        Raises
        ------
        NotADirectoryError, PermissionError, OSError
            If it cannot be written.
        """
        writable_folder(self.folder)
        path = self._file(checkpoint.number)
        _write(path, case, checkpoint)
        return _kept(path, checkpoint)

    def load(self, case: Case, layout: str | None = None) -> list[KeptStage]:
        """Stages of a case that are there one after the other, from the first or the earlier run's end on.

        Those from an altered one on are left out.

        Raises
        ------
        ValueError
            If one comes from other parameters or, where `layout` is given, has states of another layout; or
            if the first one was altered, naming its file.
        """
        found: list[KeptStage] = []
        for path in self._files():
            try:
                saved, stage = self._read(path)
            except ValueError as error:
                if not found:
                    raise ValueError(f"{error}; delete {self.folder} to begin anew") from error
                if path not in self._left_out:
                    self.tell(f"{error}: left out, and computed anew from t = {found[-1].time:g} s")
                self._left_out.add(path)
                break
            if saved != case:
                raise ValueError(
                    f"checkpoint {path} comes from other parameters: choose another folder "
                    f"or ask for overwriting (--overwrite)"
                )
            if layout is not None and (differences := _differences(stage.layout, layout)):
                raise ValueError(
                    f"checkpoint {path} has states of another layout: {'; '.join(differences)}; "
                    f"delete {self.folder} to begin anew"
                )
            found.append(stage)
        return found

    def pieces(self, stages: Iterable[KeptStage]) -> list[Chunk]:
        """Pieces of the history that stages of `load` gave, the earlier run's among them."""
        kept = list(stages)
        before = [Chunk.of_file(self._earlier, kept[0].time)] if kept and kept[0].number else []
        return before + [stage.piece for stage in kept]

    def save_history(self, case: Case, pieces: list[Chunk]) -> Path:
        """Write the history that pieces make into the folder."""
        writable_folder(self.folder)
        return save_joined(case, pieces, self.history, overwrite=True)

    def begin_from(self, end: Path, history: Path) -> None:
        """Go on behind a shorter run of the same case, of which `settle` kept the end."""
        self.remove()
        writable_folder(self.folder)
        number = int(_arrays(end)["number"])
        for source, path in ((history, self._earlier), (end, self._file(number))):
            with whole_file(path) as temporary:
                shutil.copyfile(source, temporary)

    def settle(self, case: Case, end: Path) -> None:
        """Keep of a run that has ended what a longer one goes on with, in the file `end`; remove the rest."""
        if stages := self.load(case):
            last = stages[-1]
            nothing = next(iter(last.piece.parts())).isel(time=slice(0))
            _write(end, case, Checkpoint(last.number, last.time, last.layout, last.state, nothing))
        self.remove()

    def remove(self) -> None:
        """Remove all of it and, if nothing else is in it, the folder."""
        for path in (*self._all(), self.history, self._earlier):
            path.unlink(missing_ok=True)
        if self.folder.is_dir() and not any(self.folder.iterdir()):
            self.folder.rmdir()

    def _read(self, path: Path) -> tuple[Case, KeptStage]:
        """Case and stage of a file; one that was read and is the same is not read again."""
        found = path.stat()
        stamp = (found.st_mtime_ns, found.st_size)
        if path not in self._found or self._found[path][0] != stamp:
            arrays = _arrays(path)
            if self._file(int(arrays["number"])) != path:
                raise ValueError(f"checkpoint {path} is that of stage {arrays['number']}")
            text = str(arrays["case"])
            if text not in self._cases:
                self._cases[text] = saved_case(text, path)
            self._found[path] = (stamp, self._cases[text], _kept(path, _checkpoint(arrays)))
        return self._found[path][1:]

    def _files(self) -> list[Path]:
        """Files of consecutive stages."""
        first = 0
        if self._earlier.is_file() and not self._file(0).is_file():
            first = min((int(path.stem.removeprefix("stage_")) for path in self._all()), default=0)
        files: list[Path] = []
        while (path := self._file(first + len(files))).is_file():
            files.append(path)
        return files

    def _all(self) -> Iterator[Path]:
        return self.folder.glob("stage_[0-9]*[0-9].npz")

    def _file(self, number: int) -> Path:
        return self.folder / f"stage_{number:04d}.npz"


def _write(path: Path, case: Case, checkpoint: Checkpoint) -> None:
    """Write a checkpoint with the digest of all that it holds."""
    history = checkpoint.history
    arrays: dict[str, Any] = {
        "case": np.array(case.model_dump_json()),
        "number": np.array(checkpoint.number),
        "time": np.array(checkpoint.time),
        "layout": np.array(checkpoint.layout),
        "state": checkpoint.state,
        "variables": np.array(json.dumps(history.to_dict(data=False))),
    }
    arrays |= {f"{VARIABLE}{name}": variable.values for name, variable in history.variables.items()}
    with whole_file(path, overwrite=True) as temporary, temporary.open("wb") as file:
        np.savez(file, digest=np.array(_digest(arrays)), **arrays)


def _digest(arrays: Mapping[str, NDArray]) -> str:
    """SHA-256 of named arrays."""
    digest = hashlib.sha256()
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        digest.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


def _arrays(path: Path) -> dict[str, NDArray]:
    """Arrays of a file, whose digest is right.

    Raises
    ------
    ValueError
        If it is not, or the file cannot be read.
    """
    try:
        with path.open("rb") as file, np.load(file) as content:
            arrays = {name: content[name] for name in content.files}
        digest = str(arrays.pop("digest"))
    # altered bytes make the readers of archives raise all kinds of errors
    except Exception as error:
        raise ValueError(f"checkpoint {path} cannot be read: {' '.join(str(error).split())}") from error
    if digest != _digest(arrays):
        raise ValueError(f"checkpoint {path} was altered: its digest is wrong")
    return arrays


def _checkpoint(arrays: Mapping[str, NDArray]) -> Checkpoint:
    return Checkpoint(
        int(arrays["number"]), float(arrays["time"]), str(arrays["layout"]), arrays["state"], _dataset(arrays)
    )


def _dataset(arrays: Mapping[str, NDArray]) -> xr.Dataset:
    """History among the arrays of a file."""
    content: dict[str, Any] = json.loads(str(arrays["variables"]))

    def filled(kind: str) -> dict[str, tuple[Any, ...]]:
        return {
            name: (tuple(one["dims"]), arrays[f"{VARIABLE}{name}"], one["attrs"])
            for name, one in content[kind].items()
        }

    return xr.Dataset(filled("data_vars"), coords=filled("coords"), attrs=content["attrs"])


def _kept(path: Path, checkpoint: Checkpoint) -> KeptStage:
    """Stage in a file without what is read from there, and checked, when it is needed."""
    whole = Chunk.of(checkpoint.history)
    piece = Chunk(whole.times, whole.pairs, lambda: Chunk.of(_dataset(_arrays(path))).parts())
    return KeptStage(checkpoint.number, checkpoint.time, intern(checkpoint.layout), path, piece)


def _differences(found: str, own: str) -> list[str]:
    """In what a layout differs from the own one, a phrase each, such as "terrain is 15, not 32"."""
    theirs, wanted = json.loads(found), json.loads(own)
    return [
        f"{name} is {theirs.get(name)}, not {wanted.get(name)}"
        for name in sorted(theirs.keys() | wanted.keys())
        if theirs.get(name) != wanted.get(name)
    ]
