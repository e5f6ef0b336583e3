"""Stages of a run kept in a folder, so that a run that was killed goes on where the last one ended."""

from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.case.files import saved_case
from exudyn_crawler.files import whole_file, writable_folder
from exudyn_crawler.model.state import StateLayout


@dataclass(frozen=True)
class Checkpoint:
    """End of a stage.

    Attributes
    ----------
    layout : StateLayout
        What the numbers of a state are.
    state : array (layout.size,)
        From which the run goes on.
    rows : array (times, layout.size)
        States that the stage stored.
    """

    layout: StateLayout
    state: NDArray
    rows: NDArray

    @property
    def time(self) -> float:
        """End of the stage, s."""
        return float(self.layout.part(self.state, "time"))


class Checkpoints:
    """Checkpoints of one run in a folder of their own, one file a stage.

    Parameters
    ----------
    folder : Path
        Made with the first checkpoint.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = Path(folder)

    def save(self, case: Case, number: int, checkpoint: Checkpoint) -> None:
        """Keep the checkpoint of stage `number` (from 0) of a case.

        Raises
        ------
        NotADirectoryError, PermissionError
            If the folder cannot be written to.
        """
        writable_folder(self.folder)
        with whole_file(self._file(number), overwrite=True) as temporary:
            np.savez(
                temporary,
                case=np.array(case.model_dump_json()),
                layout=np.array(checkpoint.layout.to_json()),
                state=checkpoint.state,
                rows=checkpoint.rows,
            )

    def load(self, case: Case, layout: StateLayout | None = None) -> list[Checkpoint]:
        """Checkpoints of a case from the first stage on, as far as there are any.

        Raises
        ------
        ValueError
            If one comes from other parameters, cannot be read, has states of another version or, where
            `layout` is given, of another layout, naming its file and what differs.
        """
        found: list[Checkpoint] = []
        while (path := self._file(len(found))).is_file():
            try:
                with path.open("rb") as file, np.load(file) as content:
                    saved = saved_case(str(content["case"]), path)
                    own = StateLayout.from_json(str(content["layout"]))
                    found.append(Checkpoint(own, content["state"], content["rows"]))
            except (OSError, KeyError, ValueError, BadZipFile, EOFError) as error:
                raise ValueError(f"checkpoint {path} cannot be read: {error}; delete it to go on") from error
            if saved != case:
                raise ValueError(
                    f"checkpoint {path} comes from other parameters: choose another folder "
                    f"or ask for overwriting (--overwrite)"
                )
            if layout is not None and (differences := layout.differences(own)):
                raise ValueError(
                    f"checkpoint {path} has states of another layout: {'; '.join(differences)}; "
                    f"delete it to go on"
                )
        return found

    def clear(self) -> None:
        """Remove all checkpoints."""
        for path in self.folder.glob("stage_*.npz"):
            path.unlink()

    def remove(self) -> None:
        """Remove all checkpoints and, if nothing else is in it, their folder."""
        self.clear()
        if self.folder.is_dir() and not any(self.folder.iterdir()):
            self.folder.rmdir()

    def _file(self, number: int) -> Path:
        return self.folder / f"stage_{number:04d}.npz"
