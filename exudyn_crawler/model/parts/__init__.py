"""Parts of a machine, one file each, named by the gear of a case.

A part adds its bodies, markers, joints and couplings to an `Assembler`.
"""

from importlib import import_module

from exudyn_crawler.model.assembler import Assembler


def add_part(name: str, assembler: Assembler) -> None:
    """Add a part by the name of its file."""
    import_module(f"{__name__}.{name}").add(assembler)
