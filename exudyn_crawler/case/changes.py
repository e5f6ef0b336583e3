"""Single values of a case file changed from outside, as ``terrain.spring_stiffness=1e7``."""

import re
import tomllib
from collections.abc import Iterable
from typing import Any

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.case_file import CaseFile
from exudyn_crawler.case.kinds import key_paths

KEY = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", re.ASCII)


def changed(content: dict[str, Any], changes: Iterable[str]) -> dict[str, Any]:
    """Content of a case file with some values changed, to be checked like the file.

    Parameters
    ----------
    content : dict
        Tables of the file.
    changes : iterable of str
        Each a key, "=" and a value as TOML writes it; text needs no quotes. A key is the path of a value, or
        its last name where no other value of a case has that.

    Raises
    ------
    ValueError
        If a change is none, or its key could be several.
    """
    for change in changes:
        key, equals, text = change.partition("=")
        key = key.strip()
        if not equals or not KEY.fullmatch(key):
            raise ValueError(f"a change must be like terrain.spring_stiffness=1e7, got {change!r}")
        *tables, name = _whole_path(key).split(".")
        table = content
        for one in tables:
            below = table.setdefault(one, {})
            if not isinstance(below, dict):
                raise ValueError(f"{key}: {one} must be a table to change a value of it, got {below!r}")
            table = below
        table[name] = _value(text.strip())
    return content


def _whole_path(key: str) -> str:
    """Path of the one value that a last name alone means; any other key as it is."""
    top = {"base", *Case.model_fields, *CaseFile.model_fields}
    if key.partition(".")[0] in top:
        return key
    paths = [path for path in key_paths(CaseFile) if path.endswith(f".{key}")]
    if len(paths) > 1:
        raise ValueError(f"{key}: which one is meant? {', '.join(paths)}")
    return paths[0] if paths else key


def _value(text: str) -> Any:
    try:
        content = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    # a line break could hide more
    return content["value"] if len(content) == 1 else text
