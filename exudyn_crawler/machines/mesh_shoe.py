"""Shoes of case files by a mesh: `[shoe] mesh`, of which shoe, pins and the mesh of flexible shoes follow."""

import os
from pathlib import Path

from exudyn_crawler.case.parameters.track import Track
from exudyn_crawler.machines.datasheet.shoe_mesh import shoe_of_mesh
from exudyn_crawler.settings import fields, reading
from meshes import SHOE_SIZES

KEY = "mesh"


def with_mesh_shoe(content: reading.Content, folder: Path) -> reading.Content:
    """Content of a case file in a folder whose shoes are those of a mesh, if its `[shoe]` names one.

    Of the mesh follow the shoe, the pitch, the pins' places in `[track]` and, where there is a table
    `[flexible]`, its mesh, what bears the load and whether it has static fields; what the file says itself
    stays. A ValueError says if the mesh is none of a shoe, or stands beside a `base` of `[shoe]`.
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
        raise ValueError(f"shoe.{fields.BASE} must be left out beside shoe.{KEY}, of which the shoe follows")
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
