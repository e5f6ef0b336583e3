"""Checks of any shoe mesh: metres as its unit, the surfaces for ground and machine, and complete surfaces."""

import warnings

import numpy as np

from fem.body.mesh import Floats, Integers, Mesh, MeshError, MeshWarning, triangle_normals
from fem.body.surface_edges import BoundaryFaces, bore_beyond, boundary_of, flat_beyond
from fem.body.surfaces import surface_weights
from meshes.geometry import JOINT_CENTERS
from meshes.load_surfaces import LOAD_SURFACES
from meshes.undersides import SAME_HEIGHT

LARGEST = 50.0
"""Greatest extent of any shoe, m."""
LEAST_LIKELY, GREATEST_LIKELY = 0.3, 8.0
"""Usual range of shoe widths, m."""
MISTAKEN = {"mm": 1e-3, "cm": 1e-2, "inch": 0.0254}
"""Units of meshes by mistake, m."""
LOOKS_UP = 0.999
BESIDE_TOP = 0.1
"""Least cosine between a level face's normal and up; area of such faces beside a whole top, fraction of its
area."""
LEAST_WIDTH = 0.5
"""Least plausible width of the whole top, fraction of the shoe's width."""
MENDING = "name all of it in the program that meshed the shoe (docs/howto/own_shoe_mesh.md)"


def check_extent(mesh: Mesh, name: str = "") -> None:
    """Raise `ValueError` for a mesh that is larger than any shoe, with its length and likely unit.

    `name` is that of the mesh in the message.
    """
    extent = float(np.ptp(mesh.nodes, axis=0).max())
    if extent > LARGEST:
        likely = [unit for unit, size in MISTAKEN.items() if LEAST_LIKELY <= extent * size <= GREATEST_LIKELY]
        cause = f"; is it in {' or '.join(likely)}?" if likely else ""
        raise ValueError(
            f"{the_mesh(name)} must be in m and no larger than {LARGEST:g} m, "
            f"but it is {extent:.4g} m long{cause}"
        )


def check_surfaces(mesh: Mesh, load_surface: str, name: str = "") -> None:
    """Raise `ValueError` for a mesh without underside or without the surface of the machine's load.

    `name` is that of the mesh in the message, which lists the surfaces of the mesh.
    """
    if "underside" not in mesh.surfaces:
        raise ValueError(f"{the_mesh(name)} must have the surface 'underside', {named_surfaces(mesh)}")
    if load_surface not in mesh.surfaces:
        follows = ", which follows from 'top'" if load_surface in LOAD_SURFACES else ""
        raise ValueError(
            f"load_surface must be a surface of {the_mesh(name)}, {named_surfaces(mesh)}; "
            f"got {load_surface!r}{follows}"
        )


def check_whole(mesh: Mesh, name: str = "") -> None:
    """Check by geometry that named surfaces are complete.

    Parameters
    ----------
    name : str
        Name of the mesh in messages.

    Raises
    ------
    MeshError
        If the underside ends inside a flat, or a bore's surface inside the bore.

    Warns
    -----
    MeshWarning
        If faces that carry the machine end inside a flat or do not reach over the shoe, or if part of a bore
        belongs to no surface.
    """
    boundary = boundary_of(mesh)
    if "underside" in mesh.surfaces:
        _refuse_beyond(mesh, name, "underside", "a flat", flat_beyond(boundary, mesh.surfaces["underside"]))
    _check_bores(boundary, name)
    for surface in ("top", "roller path"):
        beyond = (
            flat_beyond(boundary, mesh.surfaces[surface]) if surface in mesh.surfaces else mesh.boundary[:0]
        )
        if len(beyond):
            _warn(f"{_ends_inside(mesh, name, surface, 'a flat', beyond)}; if it is larger, {MENDING}")
    if "whole top" in mesh.surfaces and not _is_all_above_pins(mesh):
        width = _width(mesh.nodes[mesh.nodes_of("whole top")])
        if width < LEAST_WIDTH * _width(mesh.nodes):
            _warn(
                f"the surface 'whole top' of {the_mesh(name)}, which follows from 'top', is "
                f"{width:.3g} m wide on a shoe of {_width(mesh.nodes):.3g} m; if a part of 'top' is missing, "
                f"{MENDING}"
            )


def _is_all_above_pins(mesh: Mesh) -> bool:
    """Return True if nothing level lies above the pins beside the whole top, as on shoes bolted to links."""
    bores = [f"bore {joint}" for joint in JOINT_CENTERS]
    if not set(bores) <= set(mesh.surfaces):
        return False
    pins = float(np.mean([mesh.nodes[mesh.nodes_of(bore), 2].mean() for bore in bores]))
    corners = mesh.nodes[mesh.boundary[:, :3]]
    normals = triangle_normals(corners)
    sizes = np.linalg.norm(normals, axis=1)
    # pads of links between the pins are as high as these
    above = (normals[:, 2] > LOOKS_UP * sizes) & (corners[..., 2].mean(axis=1) > pins + SAME_HEIGHT)
    top = set(_keys(mesh.surfaces["whole top"]))
    is_top = np.array([key in top for key in _keys(mesh.boundary)])
    return bool(sizes[above & ~is_top].sum() < BESIDE_TOP * sizes[is_top].sum())


def _check_bores(boundary: BoundaryFaces, name: str) -> None:
    mesh = boundary.mesh
    bores = {surface: faces for surface, faces in mesh.surfaces.items() if surface.startswith("bore ")}
    seen = {face for faces in bores.values() for face in _keys(faces)}
    parts = {}
    for surface, faces in bores.items():
        joined, parts[surface] = bore_beyond(boundary, faces)
        # the bore of a lug in the middle is divided into parts for the right and the left joint
        _refuse_beyond(mesh, name, surface, "the bore", joined[[key not in seen for key in _keys(joined)]])
    if not {f"bore {joint}" for joint in JOINT_CENTERS} <= set(bores):
        return  # an unnamed bore is refused when its pin is looked up
    for surface, apart in parts.items():
        keys = _keys(apart)
        beside = apart[[key not in seen for key in keys]]
        seen |= set(keys)
        if len(beside):
            _warn(
                f"on the axis of the surface {surface!r} of {the_mesh(name)} lies a part of a bore that "
                f"belongs to no surface, {_size_and_place(mesh, beside)}; if the pin is in it, {MENDING}"
            )


def _keys(faces: Integers) -> list[tuple[int, ...]]:
    """Return the corners of each face in ascending order."""
    return list(map(tuple, np.sort(faces[:, :3], axis=1).tolist()))


def _refuse_beyond(mesh: Mesh, name: str, surface: str, inside: str, beyond: Integers) -> None:
    if len(beyond):
        raise MeshError(f"{_ends_inside(mesh, name, surface, inside, beyond)}; {MENDING}")


def _ends_inside(mesh: Mesh, name: str, surface: str, inside: str, beyond: Integers) -> str:
    area = surface_weights(mesh, mesh.surface(surface)).sum()
    return (
        f"the surface {surface!r} of {the_mesh(name)}, {area:.4g} m2, ends inside {inside}, of which it "
        f"leaves out {_size_and_place(mesh, beyond)}"
    )


def _size_and_place(mesh: Mesh, faces: Integers) -> str:
    place = mesh.nodes[faces[0, :3]].mean(axis=0).round(3).tolist()
    return f"{surface_weights(mesh, faces).sum():.4g} m2, at {place} for one"


def _width(nodes: Floats) -> float:
    return float(np.ptp(nodes[:, 1]))


def _warn(text: str) -> None:
    warnings.warn(text, MeshWarning, stacklevel=4)


def the_mesh(name: str) -> str:
    """Return the name of a mesh for messages."""
    return f"the mesh {name!r}" if name else "the mesh"


def named_surfaces(mesh: Mesh) -> str:
    """Return the surfaces of a mesh and the notes of its file, for messages."""
    has = f"which has {sorted(mesh.surfaces) or 'none'}"
    return "; ".join((has, *mesh.notes))
