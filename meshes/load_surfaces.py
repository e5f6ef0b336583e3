"""Surfaces of a shoe's top that may carry the machine: its rails, its plateau or the whole of it.

All three follow from the surface "top" and the shape, so that any mesh with that surface has them.
"""

import numpy as np

from fem.mesh import Integers, Mesh
from fem.surfaces import faces_joined_to, faces_seen_from

LOAD_SURFACES = ("rails", "plateau", "whole top")

LEVEL = 1e-3
"""m, difference up to which heights are equal."""

_UP = np.array([0.0, 0.0, 1.0])


def with_load_surfaces(mesh: Mesh) -> Mesh:
    """Name the surfaces that may carry the machine; those that the mesh names itself stay.

    Parameters
    ----------
    mesh : Mesh
        Of a shoe, z up.

    Returns
    -------
    Mesh
        With up to three more surfaces, or none if there is no surface "top":

        - "rails": the surface "roller path"; without one, the level faces of "top" at its greatest height
        - "plateau": the surface "top"
        - "whole top": all upward faces with nothing above them that are as high as "top" or connected by
          edges with such faces, over the full width
    """
    if "top" not in mesh.surfaces:
        return mesh
    top = mesh.surface("top")
    found = {
        "rails": mesh.surfaces["roller path"] if "roller path" in mesh.surfaces else _highest(mesh, top),
        "plateau": top,
        "whole top": _whole_top(mesh, top),
    }
    return mesh.with_surfaces(
        {name: faces for name, faces in found.items() if len(faces) and name not in mesh.surfaces}
    )


def _highest(mesh: Mesh, faces: Integers) -> Integers:
    """Level faces at the height of the highest node."""
    heights = mesh.nodes[faces, 2]
    return faces[heights.min(axis=1) >= heights.max() - LEVEL]


def _whole_top(mesh: Mesh, top: Integers) -> Integers:
    """Faces seen from above that are connected with those as high as `top`: no bottom plate, no lugs."""
    seen = faces_seen_from(mesh, _UP)
    lowest = mesh.nodes[top, 2].min() - LEVEL
    return faces_joined_to(seen, seen[mesh.nodes[seen, 2].min(axis=1) >= lowest])
