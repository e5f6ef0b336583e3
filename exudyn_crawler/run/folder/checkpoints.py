"""Stages of a run kept in a folder, so that a run that was stopped goes on where the last one ended.

A file a stage holds the state at its end, the chunk of the history that it gave, and the case of both, each
with a checksum. A longer run goes on with the end of the last stage but one and the history.
"""

import json
import shutil
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from exudyn_crawler.case import Case, differences, saved_case
from exudyn_crawler.errors import ASK_TO_OVERWRITE
from exudyn_crawler.files import whole_file, writable_folder
from exudyn_crawler.results.history.files import Chunk, save_joined

# what the names of the history's arrays and of the ground's memory begin with in a file
VARIABLE, MEMORY = "history ", "memory "


@dataclass(frozen=True)
class Checkpoint:
    """End of a stage in a file, of which memory holds little however many there are."""

    number: int  # of the stage, from 0
    time: float  # s
    path: Path
    chunk: Chunk  # what the stage stored, read from the file when it is needed

    def end(self) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """State (size of the layout,) and memory of the ground to go on from; ValueError if altered."""
        content = _read(self.path)
        return content.state, content.memory


class Checkpoints:
    """Checkpoints of one run in a folder of their own; `say` gets a line on what was left out."""

    def __init__(self, folder: Path, say: Callable[[str], None] = lambda _text: None) -> None:
        self.folder, self.say = Path(folder), say
        self._left_out: set[Path] = set()
        self.history = self.folder / "assembled.nc"
        """Where `save_history` writes."""
        self._earlier = self.folder / "earlier.nc"
        """History of the shorter run that this one goes on with."""

    def save(
        self,
        case: Case,
        number: int,
        time: float,
        layout: str,
        state: np.ndarray,
        memory: dict[str, np.ndarray],
        history: xr.Dataset,
    ) -> Checkpoint:
        """Keep the end of a stage of a case; OSError if it cannot be written."""
        writable_folder(self.folder)
        path = self._file(number)
        content = _Content(case.model_dump_json(), number, time, layout, state, memory, history)
        _write(path, content)
        return _checkpoint(path, content)

    def load(self, case: Case, layout: str | None = None) -> list[Checkpoint]:
        """Consecutive stages of a case, from the first or the earlier run's end to one that was altered.

        ValueError, naming the file, if the first one was altered, or if one comes from other parameters or,
        where `layout` is given, has states of another layout.
        """
        found: list[Checkpoint] = []
        own = case.model_dump_json()
        for path in self._files():
            try:
                content = _read(path)
                if self._file(content.number) != path:
                    raise ValueError(f"checkpoint {path} is that of stage {content.number}")
                saved = case if content.case == own else saved_case(content.case)
            except ValueError as error:
                if not found:
                    raise ValueError(f"{error}; delete {self.folder} to start again") from error
                if path not in self._left_out:
                    self.say(f"{error}: ignored, computing again from t = {found[-1].time:g} s")
                self._left_out.add(path)
                break
            if saved != case:
                raise ValueError(
                    f"checkpoint {path} comes from other parameters ({differences(saved, case)[0]}): choose "
                    f"another folder or {ASK_TO_OVERWRITE}"
                )
            if layout is not None and (others := _other_parts(content.layout, layout)):
                raise ValueError(
                    f"checkpoint {path} has states of another layout: {'; '.join(others)}; "
                    f"delete {self.folder} to start again"
                )
            found.append(_checkpoint(path, content))
        return found

    def chunks(self, stages: Sequence[Checkpoint]) -> list[Chunk]:
        """Chunks of the history of stages, with the earlier run's before them."""
        there = stages and self._earlier.is_file()
        earlier = [Chunk.of_file(self._earlier, stages[0].time)] if there else []
        return earlier + [stage.chunk for stage in stages]

    def save_history(self, case: Case, chunks: Sequence[Chunk], end: xr.Dataset) -> Path:
        """Write a history into the folder; `end` are the cells of the ground as of its end."""
        writable_folder(self.folder)
        return save_joined(case, chunks, self.history, overwrite=True, end=end)

    def begin_from(self, end: Path, history: Path) -> None:
        """Go on behind a shorter run of the same case, of which `settle` kept the end."""
        self.remove()
        writable_folder(self.folder)
        for source, path in ((history, self._earlier), (end, self._file(_read(end).number))):
            with whole_file(path) as temporary:
                shutil.copyfile(source, temporary)

    def settle(self, case: Case, end: Path) -> None:
        """Keep of a run that has ended what a longer one goes on with, in the file `end`; remove the rest."""
        if stages := self.load(case):
            last = _read(stages[-1].path)
            _write(end, last._replace(history=last.history.isel(time=slice(0))))
        self.remove()

    def remove(self) -> None:
        """Remove all of it and, if nothing else is in it, the folder."""
        for path in (*self._all(), self.history, self._earlier):
            path.unlink(missing_ok=True)
        if self.folder.is_dir() and not any(self.folder.iterdir()):
            self.folder.rmdir()

    def _files(self) -> list[Path]:
        """Files of consecutive stages."""
        first = 0
        if self._earlier.is_file() and not self._file(0).is_file():
            first = min((int(path.stem.removeprefix("stage_")) for path in self._all()), default=0)
        found: list[Path] = []
        while (path := self._file(first + len(found))).is_file():
            found.append(path)
        return found

    def _all(self) -> Iterator[Path]:
        return self.folder.glob("stage_[0-9]*[0-9].npz")

    def _file(self, number: int) -> Path:
        return self.folder / f"stage_{number:04d}.npz"


class _Content(NamedTuple):
    """What a file holds: as of `Checkpoint`, the case as JSON."""

    case: str
    number: int
    time: float
    layout: str
    state: np.ndarray
    memory: dict[str, np.ndarray]
    history: xr.Dataset


def _write(path: Path, content: _Content) -> None:
    """Write a checkpoint."""
    history = content.history
    arrays: dict[str, Any] = {name: np.asarray(getattr(content, name)) for name in _Content._fields[:5]}
    arrays |= {f"{MEMORY}{name}": values for name, values in content.memory.items()}
    arrays["variables"] = np.array(json.dumps(history.to_dict(data=False)))
    arrays |= {f"{VARIABLE}{name}": variable.values for name, variable in history.variables.items()}
    with whole_file(path, overwrite=True) as temporary, temporary.open("wb") as file:
        np.savez(file, **arrays)


def _read(path: Path) -> _Content:
    """Content of a checkpoint's file; ValueError if it cannot be read, or a checksum is wrong."""
    try:
        # numpy alone would not notice that an array was made smaller
        with zipfile.ZipFile(path) as archive:
            if wrong := archive.testzip():
                raise ValueError(f"the checksum of {wrong} is wrong")
        with path.open("rb") as file, np.load(file) as stored:
            arrays = {name: stored[name] for name in stored.files}
        description: dict[str, Any] = json.loads(str(arrays["variables"]))
        for kind in ("coords", "data_vars"):
            for name, variable in description[kind].items():
                variable["data"] = arrays[f"{VARIABLE}{name}"]
        case, number, time, layout = (arrays[name].item() for name in _Content._fields[:4])
        memory = {n.removeprefix(MEMORY): a for n, a in arrays.items() if n.startswith(MEMORY)}
        history = xr.Dataset.from_dict(description)
        return _Content(case, number, time, layout, arrays["state"], memory, history)
    # altered bytes make the readers of archives raise all kinds of errors
    except Exception as error:
        raise ValueError(f"checkpoint {path} cannot be read: {' '.join(str(error).split())}") from error


def _checkpoint(path: Path, content: _Content) -> Checkpoint:
    """Checkpoint in a file without what is read from there, and checked, when it is needed."""
    whole = Chunk.of(content.history)
    chunk = Chunk(whole.times, whole.pairs, lambda: Chunk.of(_read(path).history).parts())
    return Checkpoint(content.number, content.time, path, chunk)


def _other_parts(found: str, own: str) -> list[str]:
    """In what a layout differs from that of the run, a phrase each, such as "terrain is 15, not 32"."""
    theirs, wanted = json.loads(found), json.loads(own)
    pairs = {name: (theirs.get(name), wanted.get(name)) for name in sorted(theirs.keys() | wanted.keys())}
    return [f"{name} is {one}, not {other}" for name, (one, other) in pairs.items() if one != other]
