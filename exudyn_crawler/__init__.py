"""Simulator of the crawler tracks of mining shovels on oil sand.

>>> from exudyn_crawler import Case, simulate
>>> history = simulate(Case.translation(), duration=0.01)
>>> history.position.sel(shoe=13, axis="x").shape
(6,)
"""

import ast
import importlib.util
from pathlib import Path
from typing import Any


def _check_neighbours() -> None:
    """Refuse to work with other packages of the names of those that are installed beside this one."""
    beside = Path(__file__).resolve().parents[1]
    for name in ("fem", "meshes", "studies"):
        found = importlib.util.find_spec(name)
        origin = None if found is None else found.origin
        if origin is None or Path(origin).resolve().parent != beside / name:
            raise ImportError(
                f"the package {name!r} must be that in {beside}, which comes with {__name__}, got "
                f"{origin or 'none'}: move the other away, or out of the folders where Python looks first"
            )


def _modules_of_names() -> dict[str, str]:
    """Modules of the public names, which the stub beside this file states."""
    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = [line for line in stub.body if isinstance(line, ast.ImportFrom)]
    return {alias.name: str(line.module) for line in imports for alias in line.names}


_check_neighbours()
_MODULES = _modules_of_names()
__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    """Import what is asked for when it is: the engine alone takes a second, and help needs none of it."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    """Public names, for completion: they are not here before they are asked for."""
    return [*__all__, *(name for name in globals() if name.startswith("__"))]
