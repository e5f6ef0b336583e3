"""Laws of the cells, one file each: a new law changes no other module."""

import pkgutil
from importlib import import_module
from pathlib import Path

from exudyn_crawler.case.parameters import terrain
from exudyn_crawler.ground.cells.law import CellLaw
from exudyn_crawler.settings import reading


def law_classes() -> list[type[CellLaw]]:
    """Return the parameter classes of the laws in this folder, in the order of their files' names."""
    return [_law_of(module.name) for module in pkgutil.iter_modules(__path__)]


def _law_of(name: str) -> type[CellLaw]:
    """Return the parameter class of the law in the file of this name."""
    members = vars(import_module(f"{__name__}.{name}")).values()
    classes = (member for member in members if isinstance(member, type) and issubclass(member, CellLaw))
    (law,) = (kind for kind in classes if kind is not CellLaw)
    return law


def read_law(path: str | Path) -> terrain.SoilLaw:
    """Read a law from a file (TOML): its `model`, and its differences from a `base` such as "lete_sand".

    Raises `FileNotFoundError` or `CaseFileError`.
    """
    path = Path(path)
    with reading.errors_named(path, CellLaw):
        content = reading.toml_content(path, "law file")
        kind = terrain.law_class(content.get("model"))
    with reading.errors_named(path, kind):
        return reading.from_content(kind, content)
