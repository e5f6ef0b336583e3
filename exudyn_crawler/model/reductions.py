"""Where reductions of flexible shoes and their static fields are cached between runs."""

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from platformdirs import user_cache_path

VARIABLE = "EXUDYN_CRAWLER_CACHE"
"""Environment variable that names the folder of caches in place of the user's cache folder."""

warn = logging.getLogger("exudyn_crawler").warning
"""What a cache has to tell goes to the log."""

_chosen: ContextVar[Path | None] = ContextVar("folder of reductions", default=None)


def reductions_folder() -> Path:
    """Folder of cached reductions: of `reductions_in`, of the environment, or in the user's cache folder."""
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
    """SHA-256 of all sources that results are made with."""
    # `reductions_line` must not wait for finite elements
    from fem.sources import source_digest

    package = Path(__file__).parents[1]
    return source_digest(package, *(package.parent / name for name in ("fem", "meshes")))


def reductions_line() -> str:
    """Content of the cache, in a line."""
    folder = reductions_folder()
    sizes = {path: path.stat().st_size for path in folder.glob("[!.]*.h5")}  # a dot: being written
    shoes = [path for path in sizes if path.suffixes == [".h5"]]  # static fields have one more
    size = sum(sizes.values()) / 1e6
    return (
        f"{len(shoes)} reduced shoes are cached in {folder} ({size:.0f} MB); you may remove them at any time"
    )
