"""Shoes of case files from a mesh: `[shoe] mesh` gives shoe, pins and the mesh of flexible shoes."""

import os
from pathlib import Path

from exudyn_crawler.case.parameters.track import Track
from exudyn_crawler.machines.datasheet.shoe_mesh import shoe_of_mesh
from exudyn_crawler.settings import fields, reading
from meshes import SHOE_SIZES

KEY = "mesh"


def with_mesh_shoe(content: reading.Content, folder: Path) -> reading.Content:
    """Return the content of a case file in a folder with the shoe of a mesh, if `[shoe]` names one.

    The mesh gives the shoe, the pitch and the pin positions in `[track]`. In a table `[flexible]` it gives
    the mesh, the load surface and whether there are static fields. Values stated in the file stay. Raise
    `ValueError` if the mesh is no shoe, or if it stands beside a `base` of `[shoe]`.
    """
    shoe = content.get("shoe")
    if not isinstance(shoe, dict) or KEY not in shoe:
        return content
    name = shoe[KEY]
    if not isinstance(name, str) or (name not in SHOE_SIZES and not os.path.isfile(folder / name)):
        raise ValueError(
            f"shoe.{KEY} must be one of {', '.join(SHOE_SIZES)} or a file, got {fields.shown(name)}"
        )
    if fields.BASE in shoe:
        raise ValueError(
            f"shoe.{fields.BASE} must be left out beside shoe.{KEY}: the shoe follows from the mesh"
        )
    of_mesh = shoe_of_mesh(name if name in SHOE_SIZES else str((folder / name).resolve()))
    chain = content.get("track", {})
    first = chain.get("first_com", Track.ph4100c().first_com)
    right, left = (first[1] + y for y in of_mesh.joint_y)
    pins = {"pitch": of_mesh.pitch, "pin_ahead": of_mesh.pin_ahead, "pin_height": of_mesh.pin_height}
    pins |= {"spherical_y": right, "parallel_y": left}
    followed = content | {
        "shoe": of_mesh.shoe.model_dump(mode="json")
        | {key: value for key, value in shoe.items() if key != KEY},
        "track": pins | chain,
    }
    flexible = content.get("flexible")
    if isinstance(flexible, dict):
        bent = {KEY: name, "load_surface": of_mesh.surface, "static_fields": of_mesh.is_covered}
        followed["flexible"] = bent | flexible
    return followed
