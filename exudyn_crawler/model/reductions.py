"""Caches of reductions of flexible shoes and of their static fields between runs."""

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from platformdirs import user_cache_path

VARIABLE = "EXUDYN_CRAWLER_CACHE"
"""Environment variable with the folder of caches, which replaces the user's cache folder."""

warn = logging.getLogger("exudyn_crawler").warning
"""Function that writes a cache's messages to the log."""

_chosen: ContextVar[Path | None] = ContextVar("folder of reductions", default=None)


def reductions_folder() -> Path:
    """Return the folder of cached reductions.

    It is that of `reductions_in`, of the environment, or in the user's cache folder.
    """
    chosen = _chosen.get()
    if chosen is not None:
        return chosen
    named = os.environ.get(VARIABLE)
    base = Path(named) if named else user_cache_path("exudyn-crawler", appauthor=False)
    return base / "reductions"


@contextmanager
def reductions_in(folder: str | Path | None) -> Iterator[None]:
    """Cache reductions in another folder within the context; None changes nothing."""
    token = _chosen.set(_chosen.get() if folder is None else Path(folder))
    try:
        yield
    finally:
        _chosen.reset(token)


def program_digest() -> str:
    """Return the SHA-256 of all sources that affect results."""
    # `reductions_line` must not wait for finite elements
    from fem.sources import source_digest

    package = Path(__file__).parents[1]
    return source_digest(package, *(package.parent / name for name in ("fem", "meshes")))


def reductions_line() -> str:
    """Return the content of the cache in one line."""
    folder = reductions_folder()
    sizes = {path: path.stat().st_size for path in folder.glob("[!.]*.h5")}  # a dot: being written
    shoes = [path for path in sizes if path.suffixes == [".h5"]]  # static fields have one more
    size = sum(sizes.values()) / 1e6
    return (
        f"{len(shoes)} reduced shoes are cached in {folder} ({size:.0f} MB); you may remove them at any time"
    )
