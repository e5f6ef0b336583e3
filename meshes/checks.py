"""What the mesh of any shoe has to be: in m, with the surfaces that meet the ground and the machine."""

import numpy as np

from fem.mesh import Mesh
from meshes.load_surfaces import LOAD_SURFACES

LARGEST = 50.0
"""m, beyond which no shoe extends."""
LEAST_LIKELY, GREATEST_LIKELY = 0.3, 8.0
"""m, between which shoes are wide."""
MISTAKEN = {"mm": 1e-3, "cm": 1e-2, "inch": 0.0254}
"""Units that meshes come in by mistake, m."""


def check_extent(mesh: Mesh, name: str = "") -> None:
    """Refuse a mesh that is larger than any shoe.

    Parameters
    ----------
    name : str
        Of the mesh, for what is refused.

    Raises
    ------
    ValueError
        With its length and the units that it likely is in.
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
    """Refuse a mesh without underside or without the surface that the machine's load is spread over.

    Parameters
    ----------
    name : str
        Of the mesh, for what is refused.

    Raises
    ------
    ValueError
        Naming what it lacks and what it has.
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
