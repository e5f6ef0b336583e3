"""Simulator of the crawler tracks of mining shovels on oil sand.

>>> from exudyn_crawler import Case, simulate
>>> history = simulate(Case.translation(), duration=0.01)
>>> history.position.sel(shoe=13, axis="x").shape
(6,)
"""

import importlib.util
from pathlib import Path

import lazy_loader


def _check_neighbours() -> None:
    """Refuse to work with other packages of the names of those that are installed beside this one."""
    beside = Path(__file__).resolve().parents[1]
    for name in ("fem", "meshes", "studies"):
        spec = importlib.util.find_spec(name)
        origin = None if spec is None else spec.origin
        if origin is None or Path(origin).resolve().parent != beside / name:
            raise ImportError(
                f"the package {name!r} must be that in {beside}, which comes with {__name__}, got "
                f"{origin or 'none'}: move the other away, or out of the folders where Python looks first"
            )


_check_neighbours()
# the engine alone takes a second, and help needs none of it
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
