"""Steel of the ready meshes and interfaces at their joints."""

import numpy as np

from fem.body.elasticity import Material
from fem.body.interfaces import Interface, Spider
from fem.body.mesh import Mesh
from meshes.geometry import JOINT_CENTERS

STEEL = Material(youngs_modulus=200e9, poissons_ratio=0.3, density=7847.25)
"""Steel of all numbers of the meshes' README."""


def joint_interfaces(mesh: Mesh, spider: Spider = "rigid") -> list[Interface]:
    """Return the interfaces at the four joint centres of a shoe's mesh, each tied to its bore.

    Parameters
    ----------
    mesh : Mesh
        Mesh with the surfaces "bore front right" and so on.
    spider : str
        "rigid" or "averaging".
    """
    return [
        Interface(name, np.array(center), mesh.nodes_of(f"bore {name}"), spider)
        for name, center in JOINT_CENTERS.items()
    ]
