"""The crawler shoe: its dimensions, the script that meshes it and the ready meshes."""

from meshes.geometry import (
    COM_HEIGHT,
    FRONT_PIN_X,
    JOINT_CENTERS,
    PIN_HEIGHT,
    PIN_Y,
    PITCH,
    REAR_PIN_X,
    ShoeDimensions,
)
from meshes.load_surfaces import LOAD_SURFACES, with_load_surfaces
from meshes.shoe import SHOE_SIZES, STEEL, joint_interfaces, mesh_named, shoe_mesh, shoe_path

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
    "shoe_mesh",
    "shoe_path",
    "with_load_surfaces",
]
