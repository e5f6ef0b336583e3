"""The crawler shoe: its dimensions, its mesher and the ready meshes."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from meshes.geometry import (
    COM_HEIGHT,
    FRONT_PIN_X,
    JOINT_CENTERS,
    PIN_HEIGHT,
    PIN_Y,
    PITCH,
    REAR_PIN_X,
    SHOE_SIZES,
    ShoeDimensions,
)

if TYPE_CHECKING:
    from meshes.build_shoe import mesh_shoe
    from meshes.load_surfaces import LOAD_SURFACES, with_load_surfaces
    from meshes.ready import mesh_named, mesh_path, shoe_mesh, shoe_path
    from meshes.shoe import STEEL, joint_interfaces

_HOMES = {
    "LOAD_SURFACES": "load_surfaces",
    "STEEL": "shoe",
    "joint_interfaces": "shoe",
    "mesh_named": "ready",
    "mesh_path": "ready",
    "mesh_shoe": "build_shoe",
    "shoe_mesh": "ready",
    "shoe_path": "ready",
    "with_load_surfaces": "load_surfaces",
}
"""Modules of the names that are imported on first use."""

__all__ = [
    "COM_HEIGHT",
    "FRONT_PIN_X",
    "JOINT_CENTERS",
    "LOAD_SURFACES",
    "PIN_HEIGHT",
    "PIN_Y",
    "PITCH",
    "REAR_PIN_X",
    "SHOE_SIZES",
    "STEEL",
    "ShoeDimensions",
    "joint_interfaces",
    "mesh_named",
    "mesh_path",
    "mesh_shoe",
    "shoe_mesh",
    "shoe_path",
    "with_load_surfaces",
]


def __getattr__(name: str) -> Any:
    """Import finite elements when a mesh is needed: dimensions alone load fast."""
    if home := _HOMES.get(name):
        return getattr(import_module(f"{__name__}.{home}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
