"""Build the API reference from the docstrings: `python -m docs.build_api FOLDER [PACKAGE ...]`."""

import importlib
import inspect
import pkgutil
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

import pdoc
import pdoc.extract
import pdoc.render
from pydantic import BaseModel
from pydantic_core import PydanticUndefined

PACKAGES = ("exudyn_crawler", "fem", "meshes")


def module_names(packages: Sequence[str]) -> list[str]:
    """Names of packages and of all modules in them, each package before its modules."""
    names = []
    for package in packages:
        names.append(package)
        path = getattr(importlib.import_module(package), "__path__", [])
        names += [found.name for found in pkgutil.walk_packages(path, f"{package}.")]
    return names


def tell_units(module: ModuleType) -> None:
    """Let a module's parameter classes tell types and units of their fields and which have no default.

    It changes the classes' own descriptions, so a process that does this does nothing else with them.
    """
    for _, kind in inspect.getmembers(module, inspect.isclass):
        if not issubclass(kind, BaseModel) or kind.__module__ != module.__name__:
            continue
        for name, field in kind.__pydantic_fields__.items():
            # the bare type, without the bounds that pydantic keeps beside it
            kind.__annotations__[name] = field.annotation
            extra = field.json_schema_extra
            if isinstance(extra, dict) and extra.get("unit") and field.description:
                unit = "dimensionless" if extra["unit"] == "1" else extra["unit"]
                field.description = f"{field.description} [{unit}]"
            if field.default is PydanticUndefined:
                field.default = inspect.Parameter.empty


def fetch_lazy_names(module: ModuleType) -> None:
    """Import what a module offers but imports only when it is asked for; pdoc does not ask."""
    for name in getattr(module, "__all__", ()):
        setattr(module, name, getattr(module, name))


def build(folder: Path, packages: Sequence[str] = PACKAGES) -> None:
    """Write the reference of packages into a folder; nothing is fetched."""
    names = module_names(packages)
    for name in names:
        module = importlib.import_module(name)
        fetch_lazy_names(module)
        tell_units(module)
    # pdoc leaves out the modules that a package's __all__ does not name, and takes no module twice
    wanted: list[str] = []
    covered: set[str] = set()
    for name in names:
        if name not in covered:
            wanted.append(name)
            covered.update(pdoc.extract.walk_specs([name]))
    pdoc.render.configure(docformat="numpy")
    pdoc.pdoc(*wanted, output_directory=folder)


if __name__ == "__main__":
    build(Path(sys.argv[1]), sys.argv[2:] or PACKAGES)
