"""Checks of the mesh of any shoe: in m, with the surfaces for the ground and the machine."""

import numpy as np

from fem.mesh import Mesh
from meshes.load_surfaces import LOAD_SURFACES

LARGEST = 50.0
"""m, greatest extent of any shoe."""
LEAST_LIKELY, GREATEST_LIKELY = 0.3, 8.0
"""m, usual range of the width of shoes."""
MISTAKEN = {"mm": 1e-3, "cm": 1e-2, "inch": 0.0254}
"""Units of meshes by mistake, m."""


def check_extent(mesh: Mesh, name: str = "") -> None:
    """Check that a mesh is not larger than any shoe.

    Parameters
    ----------
    name : str
        Of the mesh, for the message.

    Raises
    ------
    ValueError
        If it is, with its length and its likely unit.
    """
    extent = float(np.ptp(mesh.nodes, axis=0).max())
    if extent > LARGEST:
        likely = [unit for unit, size in MISTAKEN.items() if LEAST_LIKELY <= extent * size <= GREATEST_LIKELY]
        cause = f"; is it in {' or '.join(likely)}?" if likely else ""
        raise ValueError(
            f"{_the_mesh(name)} must be in m and no larger than {LARGEST:g} m, "
            f"it is {extent:.4g} m long{cause}"
        )


def check_surfaces(mesh: Mesh, load_surface: str, name: str = "") -> None:
    """Check that a mesh has an underside and the surface that carries the machine's load.

    Parameters
    ----------
    name : str
        Of the mesh, for the message.

    Raises
    ------
    ValueError
        If one is missing, with the surfaces that it has.
    """
    if "underside" not in mesh.surfaces:
        raise ValueError(f"{_the_mesh(name)} must have the surface 'underside', {_has(mesh)}")
    if load_surface not in mesh.surfaces:
        follows = ", which follows from 'top'" if load_surface in LOAD_SURFACES else ""
        raise ValueError(
            f"load_surface must be a surface of {_the_mesh(name)}, {_has(mesh)}; "
            f"got {load_surface!r}{follows}"
        )


def _the_mesh(name: str) -> str:
    return f"the mesh {name!r}" if name else "the mesh"


def _has(mesh: Mesh) -> str:
    return f"which has {sorted(mesh.surfaces) or 'none'}"
