"""Values of a case by their paths, in a case file's content: ``loads.phases[*].loads``."""

import json
import re
from collections.abc import Callable
from typing import Any

from pydantic import ValidationError

from exudyn_crawler.case import CaseFile
from exudyn_crawler.case.files.faults import faults
from exudyn_crawler.case.files.paths import KeyPath as Place
from exudyn_crawler.case.parameters.fields import Entry, walk
from exudyn_crawler.case.parameters.loads import with_equal_loads

EVERY = "*"
"""In place of a number: all parts of a list."""
PART = re.compile(r"([A-Za-z_]\w*)((?:\[(?:\d+|\*)\])*)", re.ASCII)
INDEX = re.compile(r"\[(\d+|\*)\]")

MOST_FAULTS = 3
"""That are told of a case."""

Content = dict[str, Any]
"""Content of a `CaseFile` as JSON has it."""


def place_of(path: str) -> Place:
    """Names and numbers of a path: ("loads", "phases", "*", "loads").

    Raises
    ------
    ValueError
        If it is no path.
    """
    place: list[int | str] = []
    for part in path.split("."):
        match = PART.fullmatch(part)
        if match is None:
            raise ValueError(f"key must be a path such as terrain.spring_stiffness, got {path!r}")
        place.append(match[1])
        place += [index if index == EVERY else int(index) for index in INDEX.findall(match[2])]
    return tuple(place)


def entry_at(case_file: CaseFile, place: Place) -> Entry | None:
    """Field of a case that a place is of, or that holds the list it is in; None if there is none."""
    wanted = tuple(0 if part == EVERY else part for part in place)
    best: Entry | None = None
    for entry in walk(case_file):
        if wanted[: len(entry.place)] == entry.place and (best is None or len(entry.place) > len(best.place)):
            best = entry
    rest = wanted[len(best.place) :] if best is not None else ()
    return best if best is not None and all(isinstance(part, int) for part in rest) else None


def content_of(case_file: CaseFile) -> Content:
    """Everything of a case file, as JSON has it."""
    content: Content = json.loads(case_file.model_dump_json())
    return content


def change_at(content: Content, place: Place, change: Callable[[Any], Any]) -> None:
    """Put what is at a place, or at each of those that ``*`` means, through a function.

    Raises
    ------
    ValueError
        If the path leads to a part that a list does not have.
    """
    own = place[0] in CaseFile.model_fields and place[0] != "case"
    _change(content, place if own else ("case", *place), change)


def checked_case(content: Content) -> CaseFile:
    """Case file of a content.

    Raises
    ------
    ValueError
        Naming everything at fault by its path, and what is allowed there.
    """
    case = content["case"]
    case["loads"] = with_equal_loads(case["loads"], case["track"]["shoe_count"])
    try:
        # strict JSON takes lists for tuples and whole numbers for any, but no text for numbers
        return CaseFile.model_validate_json(json.dumps(content), strict=True)
    except ValidationError as error:
        told = list(faults(error, CaseFile))
        more = f"; {len(told) - MOST_FAULTS} more" if len(told) > MOST_FAULTS else ""
        raise ValueError("; ".join(told[:MOST_FAULTS]) + more) from error


def _change(parent: Any, place: Place, change: Callable[[Any], Any]) -> None:
    """Put what is at a place below a table or a list through a function."""
    first, rest = place[0], place[1:]
    if isinstance(parent, list):
        keys: list[Any] = list(range(len(parent))) if first == EVERY else [first]
        if any(not isinstance(key, int) or key >= len(parent) for key in keys):
            raise ValueError(f"there is no [{first}]: the list has {len(parent)} parts, counted from 0")
    elif isinstance(parent, dict) and isinstance(first, str) and first != EVERY:
        keys = [first]
    else:
        raise ValueError(f"{first!r} cannot be in {parent!r}")
    for key in keys:
        if not rest:
            parent[key] = change(parent.get(key) if isinstance(parent, dict) else parent[key])
        elif isinstance(parent, list):
            _change(parent[key], rest, change)
        else:
            _change(parent.setdefault(key, {}), rest, change)
