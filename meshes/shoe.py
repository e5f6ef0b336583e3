"""The ready meshes of the shoe, its steel and the interfaces at its joints."""

from pathlib import Path

import numpy as np

from fem.elasticity import Material
from fem.interfaces import Interface, Spider
from fem.mesh import Mesh
from fem.mesh_files import read_mesh
from meshes.geometry import JOINT_CENTERS, SHOE_SIZES
from meshes.load_surfaces import with_load_surfaces

STEEL = Material(youngs_modulus=200e9, poissons_ratio=0.3, density=7847.25)
"""Steel to which all numbers of the meshes' README belong."""


def shoe_path(size: str = "study") -> Path:
    """Path of a ready mesh of the shoe: "coarse", "study" or "fine".

    Raises
    ------
    ValueError
        If there is no such size.
    """
    if size not in SHOE_SIZES:
        raise ValueError(f"size must be one of {SHOE_SIZES}, got {size!r}")
    return Path(__file__).parent / f"shoe_{size}.msh.gz"


def shoe_mesh(size: str = "study") -> Mesh:
    """Ready mesh of the shoe in shoe axes, in m, with the surfaces of its file."""
    return read_mesh(shoe_path(size))


def mesh_named(name: str) -> Mesh:
    """Ready mesh of the shoe by its size, or any mesh by its path, with `LOAD_SURFACES`.

    Errors are those of `fem.read_mesh`.
    """
    return with_load_surfaces(shoe_mesh(name) if name in SHOE_SIZES else read_mesh(name))


def joint_interfaces(mesh: Mesh, spider: Spider = "rigid") -> list[Interface]:
    """Interfaces at the four joint centres of a mesh of the shoe, each tied to its bore.

    Parameters
    ----------
    mesh : Mesh
        With the surfaces "bore front right" and so on.
    spider : str
        "rigid" or "averaging".
    """
    return [
        Interface(name, np.array(center), mesh.nodes_of(f"bore {name}"), spider)
        for name, center in JOINT_CENTERS.items()
    ]
