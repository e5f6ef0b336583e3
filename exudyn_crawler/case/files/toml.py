"""TOML that users write."""

import tomllib
from pathlib import Path
from typing import Any


def toml_content(path: str | Path, kind: str) -> dict[str, Any]:
    """Content of a TOML file; `kind` is what a file that is not there was to hold.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If it is not TOML, without the path.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"no {kind} {path}")
    try:
        # some editors put a mark before the text
        return tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"not TOML: {error}") from error
