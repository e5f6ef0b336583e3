"""Checkpoints of a run's stages in a folder; a stopped run continues at the end of the last one.

The file of a stage holds the state at its end, its chunk of the history, and the case, each with a checksum.
A longer run continues from the end of the last stage but one, with the history of the shorter run.
"""

import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from exudyn_crawler import errors, files
from exudyn_crawler.case import Case
from exudyn_crawler.machines import differences, saved_case
from exudyn_crawler.results.history.files import Chunk, reading_history, save_joined
from exudyn_crawler.results.history.history import History
from exudyn_crawler.run.folder.record import CHECKPOINTS, END, HISTORY, quiet

# prefixes of the names of the history's arrays and of the ground's memory in a file
VARIABLE = "history "
MEMORY = "memory "
STAGES = "stage_[0-9]*[0-9].npz"
"""Pattern of the names of the stages' files."""


class StageEnd(NamedTuple):
    """End of a stage, the content of its file."""

    case: str  # as JSON
    number: int  # number of the stage, from 0
    time: float  # s
    layout: str  # layout of the state, as JSON
    state: np.ndarray  # (size of the layout,)
    memory: dict[str, np.ndarray]  # memory of the ground
    history: xr.Dataset  # chunk of the stage


class Checkpoint(NamedTuple):
    """End of a stage in a file; it takes little memory, so that there may be many."""

    number: int
    time: float
    path: Path
    chunk: Chunk  # chunk of the history, read from the file on demand

    def read(self) -> StageEnd:
        """Read the content of the file; ValueError if it was altered."""
        return _read(self.path)


class Checkpoints:
    """Checkpoints of the run in a folder; `say` gets a line on omitted ones."""

    def __init__(self, run: Path, say: Callable[[str], None] = quiet) -> None:
        self.folder = Path(run) / CHECKPOINTS
        self.say = say
        self._end, self._shorter = Path(run) / END, Path(run) / HISTORY
        self._assembled = self.folder / "assembled.nc"

    def save(self, stage: StageEnd) -> Checkpoint:
        """Save the end of a stage; OSError if it cannot be written."""
        files.writable_folder(self.folder)
        path = self._file(stage.number)
        _write(path, stage)
        return _checkpoint(path, stage)

    def load(self, case: Case, layout: str | None = None) -> list[Checkpoint]:
        """Load consecutive stages of a case, from the first or a shorter run's end, up to an altered one.

        ValueError, with the file, if the first one was altered, or one comes from other parameters. With a
        `layout`, ValueError also for states of another layout.
        """
        stages: list[Checkpoint] = []
        case_json = case.model_dump_json()
        has_shorter = self._end.is_file() and self._shorter.is_file()
        path = self._end if has_shorter else self._file(0)
        again = f"delete {self._end if has_shorter else self.folder} to start again"
        while path.is_file():
            try:
                content = _read(path)
                if path not in (self._end, self._file(content.number)):
                    raise ValueError(f"checkpoint {path} belongs to stage {content.number}")
                saved = case if content.case == case_json else saved_case(content.case)
                stages.append(_checkpoint(path, content, self._shorter if path == self._end else None))
            except ValueError as error:
                if not stages:
                    raise ValueError(f"{error}; {again}") from error
                self.say(f"{error}: removed, computing again from t = {stages[-1].time:g} s")
                path.unlink()
                break
            if saved != case:
                raise ValueError(
                    f"checkpoint {path} belongs to another case ({differences(saved, case)[0]}): choose "
                    f"another folder or {errors.ASK_TO_OVERWRITE}"
                )
            if layout not in (None, content.layout):
                raise ValueError(f"checkpoint {path} has states of another layout; {again}")
            path = self._file(content.number + 1)
        return stages

    def save_history(self, case: Case, chunks: list[Chunk], end: xr.Dataset) -> Path:
        """Write a history for `hand_over`; `end` holds the cells of the ground at its end."""
        files.writable_folder(self.folder)
        return save_joined(case, chunks, self._assembled, overwrite=True, end=end)

    def hand_over(self, path: Path) -> None:
        """Move the written history to its path in the run's folder."""
        self._assembled.replace(path)
        files.note_written(path)

    def settle(self, case: Case) -> None:
        """Keep from a finished run the checkpoint for a longer run; remove the others."""
        if stages := self.load(case):
            last = stages[-1].read()
            _write(self._end, last._replace(history=last.history.isel(time=slice(0))))
        self.remove()

    def remove(self) -> None:
        """Remove all stages and, if it is then empty, their folder."""
        for path in (*self.folder.glob(STAGES), self._assembled):
            path.unlink(missing_ok=True)
        if self.folder.is_dir() and not any(self.folder.iterdir()):
            self.folder.rmdir()

    def _file(self, number: int) -> Path:
        return self.folder / f"stage_{number:04d}.npz"


def stage_files(run: Path) -> list[Path]:
    """Return the files of the stages that a running run has finished, in their order."""
    return sorted((run / CHECKPOINTS).glob(STAGES))


def stage_history(path: Path) -> History:
    """Return a stage's part of the history; ValueError if its file cannot be read, or no longer exists."""
    stage = _read(path)
    return History(saved_case(stage.case), stage.history)


def _write(path: Path, content: StageEnd) -> None:
    """Write a checkpoint."""
    history = content.history
    arrays: dict[str, Any] = {name: np.asarray(getattr(content, name)) for name in StageEnd._fields[:5]}
    arrays |= {f"{MEMORY}{name}": values for name, values in content.memory.items()}
    arrays["variables"] = np.array(json.dumps(history.to_dict(data=False)))
    arrays |= {f"{VARIABLE}{name}": variable.values for name, variable in history.variables.items()}
    with files.whole_file(path, overwrite=True) as temporary, temporary.open("wb") as file:
        np.savez(file, **arrays)


def _read(path: Path) -> StageEnd:
    """Read the content of a checkpoint's file; ValueError if it cannot be read, or a checksum is wrong."""
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
        case, number, time, layout = (arrays[name].item() for name in StageEnd._fields[:4])
        memory = {n.removeprefix(MEMORY): a for n, a in arrays.items() if n.startswith(MEMORY)}
        history = xr.Dataset.from_dict(description)
        return StageEnd(case, number, time, layout, arrays["state"], memory, history)
    # altered bytes make the readers of archives raise all kinds of errors
    except Exception as error:
        raise ValueError(f"checkpoint {path} cannot be read: {' '.join(str(error).split())}") from error


def _checkpoint(path: Path, content: StageEnd, shorter: Path | None = None) -> Checkpoint:
    """Return the checkpoint of a file; its chunk is read on demand, there or in a shorter run's history."""
    if shorter is None:
        chunk = Chunk.of(content.history, lambda: _read(path).history)
    else:
        with reading_history(shorter):
            chunk = Chunk.of_file(shorter, content.time)
    return Checkpoint(content.number, content.time, path, chunk)
