"""The crawler shoe: its dimensions, the script that meshes it and the ready meshes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .geometry import (
    COM_HEIGHT,
    FRONT_PIN_X,
    JOINT_CENTERS,
    PIN_HEIGHT,
    PIN_Y,
    PITCH,
    REAR_PIN_X,
    ShoeDimensions,
)

if TYPE_CHECKING:
    from fem.mesh import Mesh

SHOE_SIZES = ("coarse", "study", "fine")


def shoe_path(size: str = "study") -> Path:
    """Path of a ready mesh of the shoe: "coarse", "study" or "fine".

    Raises
    ------
    ValueError
        If there is no such size.
    """
    if size not in SHOE_SIZES:
        raise ValueError(f"size = {size!r} must be one of {SHOE_SIZES}")
    return Path(__file__).parent / f"shoe_{size}.msh.gz"


def shoe_mesh(size: str = "study") -> Mesh:
    """Ready mesh of the shoe in shoe axes, in m."""
    return mesh_named(str(shoe_path(size)))


def mesh_named(name: str) -> Mesh:
    """Ready mesh of the shoe by its size, or any mesh by its path; as `fem.read_mesh`."""
    from fem.mesh import read_mesh  # whoever only wants dimensions does not wait for finite elements

    return read_mesh(shoe_path(name) if name in SHOE_SIZES else name)


__all__ = [
    "COM_HEIGHT",
    "FRONT_PIN_X",
    "JOINT_CENTERS",
    "PIN_HEIGHT",
    "PIN_Y",
    "PITCH",
    "REAR_PIN_X",
    "SHOE_SIZES",
    "ShoeDimensions",
    "mesh_named",
    "shoe_mesh",
    "shoe_path",
]
