"""The case in the file of a history, which is known before any of its results is read."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.case.files.files import saved_case
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.model.state import VERSION
from fem.interrupts import interrupts_wait

if TYPE_CHECKING:
    import xarray as xr

CASE = "case"
"""Attribute of a file."""
LAYOUT_VERSION = "layout_version"
"""Attribute of the version of the states that a history was made of; the first histories have none."""
UNSIGNED = 1
"""Version whose modes had the signs that rounding gave them: of flexible shoes it says nothing."""


def with_case(dataset: "xr.Dataset", case: Case) -> "xr.Dataset":
    """Dataset of a history as a file holds it: with its case."""
    # ASCII, so that the text has a checksum
    return dataset.assign_attrs({CASE: json.dumps(case.model_dump(mode="json"))})


def without_case(dataset: "xr.Dataset") -> "xr.Dataset":
    """Dataset of a history from that of a file."""
    attributes = {name: value for name, value in dataset.attrs.items() if name != CASE}
    return dataset.drop_attrs(deep=False).assign_attrs(attributes)


@contextmanager
def reading_history(path: Path) -> Iterator[None]:
    """Say of whatever goes wrong in the block that the file does not hold a history, and why.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        For all else.
    """
    if not path.is_file():
        raise FileNotFoundError(f"no history at {path}")
    try:
        yield
    except ParameterError as error:
        raise _no_history(path, "; ".join(error.faults)) from error
    # altered bytes make the readers raise all kinds of errors
    except Exception as error:
        raise _no_history(path, str(error) or repr(error)) from error


def _no_history(path: Path, reason: str) -> ValueError:
    return ValueError(f"{path} does not hold a history: {' '.join(reason.split())}")


@interrupts_wait()
def case_in_file(path: Path) -> Case:
    """Case of a history's file.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If the file does not hold a history, or one of states laid out in another version.
    """
    with reading_history(path):
        return _case_of(path)


def _case_of(path: Path) -> Case:
    with h5py.File(path, "r") as file:
        version = np.asarray(file.attrs.get(LAYOUT_VERSION, UNSIGNED)).item()
        if version != VERSION and (version != UNSIGNED or "modal_coordinate" in file):
            raise ValueError(f"its states have layout version {version}, this program reads {VERSION}")
        return saved_case(file.attrs[CASE])
