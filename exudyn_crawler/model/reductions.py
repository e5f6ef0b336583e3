"""Where reductions of flexible shoes, and what is made with them, are kept between runs."""

import logging
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING

from platformdirs import user_cache_path

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from fem import ElasticBody, Interface, Kept, KeptFields, UnitLoads

VARIABLE = "EXUDYN_CRAWLER_CACHE"
"""Environment variable that names the folder of caches in place of the user's own."""

logger = logging.getLogger("exudyn_crawler")

_chosen: ContextVar[Path | None] = ContextVar("folder of reductions", default=None)


def reductions_folder() -> Path:
    """Folder that reductions are kept in: that of `reductions_in`, of the environment, or the user's own."""
    chosen = _chosen.get()
    if chosen is not None:
        return chosen
    named = os.environ.get(VARIABLE)
    base = Path(named) if named else user_cache_path("exudyn-crawler", appauthor=False)
    return base / "reductions"


@contextmanager
def reductions_in(folder: str | Path | None) -> Iterator[None]:
    """Keep reductions in another folder meanwhile; None changes nothing."""
    token = _chosen.set(_chosen.get() if folder is None else Path(folder))
    try:
        yield
    finally:
        _chosen.reset(token)


def program_digest() -> str:
    """SHA-256 of all sources that results are made with."""
    from fem.sources import source_digest

    package = Path(__file__).parents[1]
    return source_digest(package, *(package.parent / name for name in ("fem", "meshes")))


def cached_reduction(
    body: "ElasticBody",
    interfaces: "Sequence[Interface]",
    fixed_modes: int,
    loads: "Mapping[str, NDArray]",
) -> "Kept":
    """Reduction of a body as of `fem.cached_craig_bampton`; what is wrong with a kept one goes to the log."""
    # saying what is kept must not wait for finite elements
    from fem import cached_craig_bampton

    return cached_craig_bampton(
        reductions_folder(), body, interfaces, fixed_modes, loads, warn=logger.warning
    )


def cached_fields(body: "ElasticBody", kept: "Kept", families: "Mapping[str, UnitLoads]") -> "KeptFields":
    """Static fields as of `fem.cached_static_fields`; what is wrong with kept ones goes to the log."""
    from fem import cached_static_fields

    return cached_static_fields(reductions_folder(), body, kept, families, warn=logger.warning)


def reductions_line() -> str:
    """What is kept, in a line."""
    folder = reductions_folder()
    sizes = {path: path.stat().st_size for path in folder.glob("[!.]*.h5")}  # a dot: being written
    shoes = [path for path in sizes if path.suffixes == [".h5"]]  # static fields and loads have one more
    size = sum(sizes.values()) / 1e6
    return f"{len(shoes)} reduced shoes are kept in {folder} ({size:.0f} MB), to be removed at will"
