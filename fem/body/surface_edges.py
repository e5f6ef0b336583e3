"""Borders of named surfaces: a surface that ends within a flat or a bore is seldom complete."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fem.body.mesh import Floats, Integers, Mesh, sorted_rows, triangle_normals

SAME_PLANE = np.radians(0.1)
"""Largest angle between faces of one flat, rad; the ready shoe's wings bend by 0.3 degrees."""
STRAIGHT = 1e-3
"""Greatest distance of a flat face's mid-side node from its corners' plane, fraction of its longest edge."""
ROUND = 0.05
"""Greatest distance of corners of a bore's faces from its circle, fraction of the radius."""
INWARD = 0.75
"""Least cosine of the angle between a bore's normals and the direction to its axis; a chamfer has less."""
ALIKE = 1.5
"""Allowed deviation of further faces from circle and direction, over that of the surface's own faces."""
EXACT = 0.01
STEEP = np.radians(8.0)
"""Deviation from circle (fraction of the radius) and direction (rad) that is allowed on any surface."""
HOLLOW_BEND = np.radians(65.0)
"""Greatest inward bend between neighbouring faces of a bore, rad: six faces around it."""
MOSTLY = 0.5
"""Least fraction of a bore's hollow on its cylinder; the wall of a pocket beside a bore has less."""

TINY = 1e-300


class BoundaryFaces(NamedTuple):
    """Faces of a mesh's boundary.

    Attributes
    ----------
    mesh : Mesh
    corners : array (k, 3, 3)
        m.
    normals : array (k, 3)
        Unit length, outward.
    pairs : int array (p, 2)
        Numbers of two faces that share an edge.
    hollows : int array (k,)
        Number of each face's hollow: a region that nowhere bends outwards, such as a bore or a flat.
    """

    mesh: Mesh
    corners: Floats
    normals: Floats
    pairs: Integers
    hollows: Integers


def boundary_of(mesh: Mesh) -> BoundaryFaces:
    """Return the faces of a mesh's boundary with their neighbours."""
    corners = mesh.nodes[mesh.boundary[:, :3]]
    normals = triangle_normals(corners)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    edges = np.sort(mesh.boundary[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(corners)), 3)
    order, same = sorted_rows(edges)
    pairs = np.column_stack((owner[order[:-1]], owner[order[1:]]))[same]
    return BoundaryFaces(mesh, corners, normals, pairs, _hollows(corners, normals, pairs))


def _hollows(corners: Floats, normals: Floats, pairs: Integers) -> Integers:
    """Number the regions (k,) with neighbours in one plane or bent inwards, no more than in bores."""
    first, second = pairs.T
    cosines = np.einsum("pc,pc->p", normals[first], normals[second])
    above = np.einsum("pc,pc->p", normals[first], corners[second].mean(axis=1) - corners[first].mean(axis=1))
    linked = (cosines > np.cos(HOLLOW_BEND)) & ((above > 0.0) | (cosines > np.cos(SAME_PLANE)))
    return _labels(pairs[linked], len(corners))


def _labels(pairs: Integers, count: int) -> Integers:
    """Number the connected parts (count,) that pairs (p, 2) link."""
    ones = np.ones(len(pairs), dtype=np.int8)
    links = coo_array((ones, (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def flat_beyond(boundary: BoundaryFaces, faces: Integers) -> Integers:
    """Find the faces that continue a flat beyond the end of a surface.

    Parameters
    ----------
    boundary : BoundaryFaces
    faces : int array (k, 3 or 6)
        Faces of the surface.

    Returns
    -------
    int array (j, 3 or 6)
        Rows of `Mesh.boundary`; none if the surface ends at edges.
    """
    mesh = boundary.mesh
    flat = _is_flat(boundary)
    cosines = np.einsum("pc,pc->p", *(boundary.normals[boundary.pairs[:, side]] for side in (0, 1)))
    level = flat[boundary.pairs].all(axis=1) & (cosines > np.cos(SAME_PLANE))
    return _beyond(mesh, faces, boundary.pairs[level])


def bore_beyond(
    boundary: BoundaryFaces, faces: Integers, axis: ArrayLike = (0.0, 1.0, 0.0)
) -> tuple[Integers, Integers]:
    """Find the faces of a bore that a surface leaves out: faces joined to it, and faces apart from it.

    Parameters
    ----------
    boundary : BoundaryFaces
    faces : int array (k, 3 or 6)
        Faces of a part of a bore.
    axis : array (3,)
        Direction of the bore's axis.

    Returns
    -------
    joined, apart : int arrays (j, 3 or 6)
        Rows of `Mesh.boundary` on the same cylinder that face its axis. A bore ends at a pocket or a hole:
        walls of these are not part of it, even if they touch the cylinder.
    """
    mesh = boundary.mesh
    on_bore = _is_on_bore(boundary, faces, np.asarray(axis, dtype=float))
    inside = _is_among(mesh, faces)
    joined = _beyond(mesh, faces, boundary.pairs[(on_bore | inside)[boundary.pairs].all(axis=1)])
    apart = on_bore & ~inside & ~_is_among(mesh, joined)
    return joined, mesh.boundary[apart]


def _is_flat(boundary: BoundaryFaces) -> np.ndarray:
    """Return True for faces (k,) with mid-side nodes in the plane of their corners."""
    middles = boundary.mesh.nodes[boundary.mesh.boundary[:, 3:]] - boundary.corners[:, :1]
    off = np.abs(np.einsum("kmc,kc->km", middles, boundary.normals)).max(axis=1, initial=0.0)
    edges = np.linalg.norm(boundary.corners - np.roll(boundary.corners, 1, axis=1), axis=2)
    return np.asarray(off <= STRAIGHT * edges.max(axis=1))


def _is_on_bore(boundary: BoundaryFaces, faces: Integers, axis: Floats) -> np.ndarray:
    """Return True for faces (k,) of the boundary on the cylinder through the nodes of given faces.

    They deviate from it about as little as the given faces: chords of few facets, or faces beside cross
    holes. They belong to a region that is mostly on the cylinder.
    """
    across = np.linalg.svd(axis[None])[2][1:].T
    circle = boundary.mesh.nodes[np.unique(faces[:, :3])] @ across
    # x^2 + y^2 = 2 a x + 2 b y + c of all nodes, by least squares
    terms = np.column_stack((2.0 * circle, np.ones(len(circle))))
    a, b, c = np.linalg.lstsq(terms, (circle**2).sum(axis=1), rcond=None)[0]
    radius = np.sqrt(max(c + a * a + b * b, 0.0))
    ways = np.array([a, b]) - boundary.corners @ across
    off = np.abs(np.linalg.norm(ways, axis=2) - radius).max(axis=1) / max(radius, TINY)
    middle = ways.mean(axis=1)
    inward = np.einsum("kc,kc->k", boundary.normals @ across, middle)
    turned = np.arccos(np.clip(inward / np.maximum(np.linalg.norm(middle, axis=1), TINY), -1.0, 1.0))
    inside = _is_among(boundary.mesh, faces)
    farthest = np.clip(ALIKE * off[inside].max(initial=0.0), EXACT, ROUND)
    steepest = np.clip(ALIKE * turned[inside].max(initial=0.0), STEEP, np.arccos(INWARD))
    on_cylinder = (off < farthest) & (turned < steepest)
    edges = boundary.corners[:, 1:] - boundary.corners[:, :1]
    areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    shares = np.bincount(boundary.hollows, areas * on_cylinder) / np.bincount(boundary.hollows, areas)
    return np.asarray(on_cylinder & (shares[boundary.hollows] > MOSTLY))


def _is_among(mesh: Mesh, faces: Integers) -> np.ndarray:
    """Return True for faces (k,) of the boundary that are among the given ones."""
    return np.isin(_face_numbers(mesh, mesh.boundary), _face_numbers(mesh, faces))


def _face_numbers(mesh: Mesh, faces: Integers) -> Integers:
    """Return a unique number for each face (k,) from its corners."""
    count = len(mesh.nodes)
    low, middle, high = np.sort(faces[:, :3], axis=1).T
    return (low * count + middle) * count + high


def _beyond(mesh: Mesh, faces: Integers, pairs: Integers) -> Integers:
    """Return the faces outside a surface that pairs of neighbours link with it."""
    inside = _is_among(mesh, faces)
    outer = pairs[~inside[pairs].any(axis=1)]
    label = _labels(outer, len(inside))
    across = pairs[inside[pairs].sum(axis=1) == 1]
    first = across[~inside[across]]
    return mesh.boundary[~inside & np.isin(label, label[first])]
