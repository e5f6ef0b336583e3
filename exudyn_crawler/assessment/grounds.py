"""Named grounds with bearing pressure, friction and rolling resistance, from a data file with sources."""

import tomllib
from functools import cache
from importlib.resources import files
from typing import NamedTuple

from exudyn_crawler.errors import did_you_mean


class NamedGround(NamedTuple):
    """Ground with its allowed pressure; `mark` is S (seen in the source), R (remembered) or D (derived)."""

    name: str
    allowed_pressure: float
    """Allowed pressure, Pa, including the safety factor of its source."""
    friction: float
    """Traction of steel tracks over their load."""
    rolling: float
    """Resistance to straight travel over the load, sinkage included."""
    source: str
    mark: str
    cohesion: float = 0.0
    """Cohesion beside the friction, Pa; 0 if a coefficient of traction includes it."""


@cache
def grounds() -> dict[str, NamedGround]:
    """Return all named grounds by name, from `grounds.toml` beside this module."""
    text = files("exudyn_crawler.assessment").joinpath("grounds.toml").read_text(encoding="utf-8")
    rows = [NamedGround(**row) for row in tomllib.loads(text)["grounds"]]
    return {row.name: row for row in rows}


def ground(name: str) -> NamedGround:
    """Return the ground of a name; raise a `ValueError` that lists the known names."""
    known = grounds()
    if name not in known:
        hint = did_you_mean(name, known)
        raise ValueError(f"ground must be one of {', '.join(known)}, {hint}got {name!r}")
    return known[name]
