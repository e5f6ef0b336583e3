"""Laws of the cells, a file each: adding one changes no other module."""

import pkgutil
from importlib import import_module

from exudyn_crawler.ground.cells.law import CellLaw


def law_class(model: str) -> type[CellLaw]:
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
