"""Stages of a run kept in a folder, so that a run that was stopped goes on where the last one ended.

A file a stage holds the state at its end, the chunk of the history that it gave, and the case of both;
zip archives have a checksum of every array. Of a run that has ended, the end of its last stage but one and
its history are enough for a longer one to go on with.
"""

import json
import shutil
import zipfile
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
from exudyn_crawler.case.files.text import differences
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
class StoredStage:
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
        return _read(self.path)[1].state


class Checkpoints:
    """Checkpoints of one run in a folder of their own.

    Parameters
    ----------
    folder : Path
        Made with the first checkpoint.
    say : callable, optional
        Gets a line on where a run goes on and what was left out.
    """

    def __init__(self, folder: Path, say: Callable[[str], None] = lambda _text: None) -> None:
        self.folder = Path(folder)
        self.say = say
        self._found: dict[Path, tuple[tuple[int, int], Case, StoredStage]] = {}
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

    def save(self, case: Case, checkpoint: Checkpoint) -> StoredStage:
        """Keep the end of a stage of a case.

        Raises
        ------
        NotADirectoryError, PermissionError, OSError
            If it cannot be written.
        """
        writable_folder(self.folder)
        path = self._file(checkpoint.number)
        _write(path, case, checkpoint)
        return _stored(path, checkpoint)

    def load(self, case: Case, layout: str | None = None) -> list[StoredStage]:
        """Stages of a case that are there one after the other, from the first or the earlier run's end on.

        Those from an altered one on are left out.

        Raises
        ------
        ValueError
            If one comes from other parameters or, where `layout` is given, has states of another layout; or
            if the first one was altered, naming its file.
        """
        found: list[StoredStage] = []
        for path in self._files():
            try:
                saved, stage = self._read(path)
            except ValueError as error:
                if not found:
                    raise ValueError(f"{error}; delete {self.folder} to begin anew") from error
                if path not in self._left_out:
                    self.say(f"{error}: left out, and computed anew from t = {found[-1].time:g} s")
                self._left_out.add(path)
                break
            if saved != case:
                raise ValueError(
                    f"checkpoint {path} comes from other parameters ({differences(saved, case)[0]}): choose "
                    f"another folder or ask for overwriting (--overwrite)"
                )
            if layout is not None and (others := _other_parts(stage.layout, layout)):
                raise ValueError(
                    f"checkpoint {path} has states of another layout: {'; '.join(others)}; "
                    f"delete {self.folder} to begin anew"
                )
            found.append(stage)
        return found

    def pieces(self, stages: Iterable[StoredStage]) -> list[Chunk]:
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
        number = _read(end)[1].number
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

    def _read(self, path: Path) -> tuple[Case, StoredStage]:
        """Case and stage of a file; one that was read and is the same is not read again."""
        found = path.stat()
        stamp = (found.st_mtime_ns, found.st_size)
        if path not in self._found or self._found[path][0] != stamp:
            text, checkpoint = _read(path)
            if self._file(checkpoint.number) != path:
                raise ValueError(f"checkpoint {path} is that of stage {checkpoint.number}")
            if text not in self._cases:
                self._cases[text] = saved_case(text)
            self._found[path] = (stamp, self._cases[text], _stored(path, checkpoint))
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
    """Write a checkpoint."""
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
        np.savez(file, **arrays)


def _read(path: Path) -> tuple[str, Checkpoint]:
    """Case, as JSON, and checkpoint of a file.

    Raises
    ------
    ValueError
        If the file cannot be read, or a checksum is wrong.
    """
    try:
        # numpy alone would not notice that an array was made smaller
        with zipfile.ZipFile(path) as archive:
            wrong = archive.testzip()
        if wrong is not None:
            raise ValueError(f"the checksum of {wrong} is wrong")
        with path.open("rb") as file, np.load(file) as content:
            arrays = {name: content[name] for name in content.files}
        number, time, layout = int(arrays["number"]), float(arrays["time"]), str(arrays["layout"])
        return str(arrays["case"]), Checkpoint(number, time, layout, arrays["state"], _dataset(arrays))
    # altered bytes make the readers of archives raise all kinds of errors
    except Exception as error:
        raise ValueError(f"checkpoint {path} cannot be read: {' '.join(str(error).split())}") from error


def _dataset(arrays: Mapping[str, NDArray]) -> xr.Dataset:
    """History among the arrays of a file."""
    content: dict[str, Any] = json.loads(str(arrays["variables"]))

    def filled(kind: str) -> dict[str, tuple[Any, ...]]:
        return {
            name: (tuple(one["dims"]), arrays[f"{VARIABLE}{name}"], one["attrs"])
            for name, one in content[kind].items()
        }

    return xr.Dataset(filled("data_vars"), coords=filled("coords"), attrs=content["attrs"])


def _stored(path: Path, checkpoint: Checkpoint) -> StoredStage:
    """Stage in a file without what is read from there, and checked, when it is needed."""
    whole = Chunk.of(checkpoint.history)
    piece = Chunk(whole.times, whole.pairs, lambda: Chunk.of(_read(path)[1].history).parts())
    return StoredStage(checkpoint.number, checkpoint.time, intern(checkpoint.layout), path, piece)


def _other_parts(found: str, own: str) -> list[str]:
    """In what a layout differs from the own one, a phrase each, such as "terrain is 15, not 32"."""
    theirs, wanted = json.loads(found), json.loads(own)
    return [
        f"{name} is {theirs.get(name)}, not {wanted.get(name)}"
        for name in sorted(theirs.keys() | wanted.keys())
        if theirs.get(name) != wanted.get(name)
    ]
