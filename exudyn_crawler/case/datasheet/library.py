"""Machines as files: datasheets with their sources, to begin with and to look at."""

import difflib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from exudyn_crawler.case.parameters import reading
from exudyn_crawler.errors import ParameterError

FOLDER = Path(__file__).with_name("library")


@cache
def machines() -> dict[str, Path]:
    """Files of the library by name."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.toml"))}


def machine_content(name: object) -> reading.Content:
    """Content of a machine's file; a ParameterError with the names that there are if there is none."""
    known = machines()
    if isinstance(name, str) and name in known:
        return reading.toml_content(known[name], "datasheet")
    near = difflib.get_close_matches(str(name), known, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    raise ParameterError(f"datasheet.base: no {name!r}; {hint}allowed are {', '.join(map(repr, known))}")


def over(content: Mapping[str, Any], below: Mapping[str, Any]) -> dict[str, Any]:
    """Content of a file over that of the machine that it begins with: tables go into each other."""
    merged = dict(below)
    for name, value in content.items():
        before = merged.get(name)
        merged[name] = over(value, before) if isinstance(value, dict) and isinstance(before, dict) else value
    return merged
