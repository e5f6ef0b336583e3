"""Named grounds: what each bears and gives, from a file of data with sources."""

import difflib
import tomllib
from functools import cache
from importlib.resources import files
from typing import NamedTuple


class NamedGround(NamedTuple):
    """Ground with what it bears; `mark` is S (seen in the source), R (remembered) or D (derived)."""

    name: str
    allowed_pressure: float
    """Pa, with the safety that its source has in it."""
    friction: float
    """Of steel tracks, traction over load."""
    rolling: float
    """Resistance to straight travel over the load; sinkage is in it."""
    source: str
    mark: str
    cohesion: float = 0.0
    """Pa, beside the friction; 0 where a coefficient of traction has it."""


@cache
def grounds() -> dict[str, NamedGround]:
    """All named grounds by name, of `grounds.toml` beside this module."""
    text = files("exudyn_crawler.assessment").joinpath("grounds.toml").read_text(encoding="utf-8")
    rows = [NamedGround(**row) for row in tomllib.loads(text)["grounds"]]
    return {row.name: row for row in rows}


def ground(name: str) -> NamedGround:
    """Ground of a name; a ValueError names those that there are."""
    known = grounds()
    if name not in known:
        near = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        raise ValueError(f"ground must be of {list(known)}, {hint}got {name!r}")
    return known[name]
