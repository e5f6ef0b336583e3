"""Load surfaces of a shoe's top: its rails, its plateau or the whole top.

All three follow from the surface "top" and the shape, so that any mesh with this surface has them. Surface
names are recognized in any spelling that a program makes of them.
"""

import numpy as np

from fem.body.mesh import Integers, Mesh, MeshError
from fem.body.surfaces import faces_joined_to, faces_seen_from
from meshes.geometry import JOINT_CENTERS

LOAD_SURFACES = ("rails", "plateau", "whole top")

SHOE_SURFACES = (
    "underside",
    "top",
    "roller path",
    *(f"bore {name}" for name in JOINT_CENTERS),
    *LOAD_SURFACES,
)
"""Names of the surfaces known to the program."""

LEVEL = 1e-3
"""Tolerance of equal heights, m."""

_UP = np.array([0.0, 0.0, 1.0])


def with_load_surfaces(mesh: Mesh) -> Mesh:
    """Name the surfaces that may carry the machine; surfaces already named by the mesh stay.

    Parameters
    ----------
    mesh : Mesh
        Mesh of a shoe, z up.

    Returns
    -------
    Mesh
        Mesh with the program's spelling of `SHOE_SURFACES`, and with up to three more surfaces, or none
        without a surface "top":

        - "rails": the surface "roller path"; without one, the level faces of "top" at its greatest height
        - "plateau": the surface "top"
        - "whole top": all upward faces with nothing above them that are as high as "top" or connected by
          edges with such faces, over the full width

    Raises
    ------
    MeshError
        If two surfaces have a name that is one of `SHOE_SURFACES` in two spellings.
    """
    mesh = with_known_names(mesh)
    if "top" not in mesh.surfaces:
        return mesh
    top = mesh.surface("top")
    surfaces = {
        "rails": mesh.surfaces["roller path"] if "roller path" in mesh.surfaces else _highest(mesh, top),
        "plateau": top,
        "whole top": _whole_top(mesh, top),
    }
    return mesh.with_surfaces(
        {name: faces for name, faces in surfaces.items() if len(faces) and name not in mesh.surfaces}
    )


def with_known_names(mesh: Mesh) -> Mesh:
    """Return a mesh with the program's spelling of `SHOE_SURFACES`, instead of BORE_REAR_LEFT, say.

    Raises
    ------
    MeshError
        If two surfaces have a name that is one of `SHOE_SURFACES` in two spellings.
    """
    known = {_letters(name): name for name in SHOE_SURFACES}
    spelt = {name: known.get(_letters(name), name) for name in mesh.surfaces}
    if all(name == spelling for spelling, name in spelt.items()):
        return mesh
    for name in set(spelt.values()):
        spellings = [spelling for spelling, meant in spelt.items() if meant == name]
        if len(spellings) > 1:
            raise MeshError(
                f"the mesh must have one surface {name!r}, got {' and '.join(map(repr, spellings))}"
            )
    surfaces = {spelt[name]: faces for name, faces in mesh.surfaces.items()}
    return Mesh(mesh.nodes, mesh.elements, surfaces, mesh.notes)


def _letters(name: str) -> str:
    return "".join(filter(str.isalnum, name)).casefold()


def _highest(mesh: Mesh, faces: Integers) -> Integers:
    """Return the level faces at the height of the highest node."""
    heights = mesh.nodes[faces, 2]
    return faces[heights.min(axis=1) >= heights.max() - LEVEL]


def _whole_top(mesh: Mesh, top: Integers) -> Integers:
    """Return the faces seen from above that join those as high as `top`: no bottom plate, no lugs."""
    seen = faces_seen_from(mesh, _UP)
    lowest = mesh.nodes[top, 2].min() - LEVEL
    return faces_joined_to(seen, seen[mesh.nodes[seen, 2].min(axis=1) >= lowest])
