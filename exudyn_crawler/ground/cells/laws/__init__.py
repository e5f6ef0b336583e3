"""Laws of the cells, a file each: adding one changes no other module."""

import pkgutil
from importlib import import_module
from pathlib import Path

from exudyn_crawler.case.parameters import reading
from exudyn_crawler.ground.cells.law import CellLaw


def law_classes() -> list[type[CellLaw]]:
    """Classes of parameters of all laws."""
    return [law_class(module.name) for module in pkgutil.iter_modules(__path__)]


def law_class(model: object) -> type[CellLaw]:
    """Class of parameters of the law in the file of this name.

    Raises
    ------
    ValueError
        If there is none.
    """
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    if model not in names:
        raise ValueError(f"model: must be one of {', '.join(names)}, got {model!r}")
    found = vars(import_module(f"{__name__}.{model}")).values()
    (law,) = (
        one for one in found if isinstance(one, type) and issubclass(one, CellLaw) and one is not CellLaw
    )
    return law


def read_law(path: str | Path) -> CellLaw:
    """Law of a file (TOML): its `model`, and what differs from a `base` such as "lete_sand".

    Raises `FileNotFoundError` or `CaseFileError`.
    """
    path = Path(path)
    with reading.errors_named(path, CellLaw):
        content = reading.toml_content(path, "law file")
        kind = law_class(content.get("model"))
    with reading.errors_named(path, kind):
        return reading.from_content(kind, content)
