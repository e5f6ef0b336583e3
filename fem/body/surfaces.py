"""Parts of a boundary: search by direction, and integration.

The search treats a face as flat between its corners; integration includes curved edges.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from fem.body.mesh import Floats, Integers, Mesh, triangle_normals

LEAST_COSINE = 0.9
"""Least cosine of the angle between a direction and normals of faces that point along it: 26 degrees."""

UPRIGHT = 1e-6
"""Cosine below which a face is parallel to a line of sight; the line then passes beside it."""


def faces_seen_from(mesh: Mesh, direction: Floats, least_cosine: float = LEAST_COSINE) -> Integers:
    """Find the faces of the boundary that point along a direction and are not covered by another face.

    A face is covered if another one lies between its centroid and an observer far away.

    Parameters
    ----------
    mesh : Mesh
    direction : array (3,)
        Towards the observer, of any length, body axes.
    least_cosine : float
        Least cosine of the angle between the direction and a face's outward normal, in (0, 1].

    Returns
    -------
    int array (k, 3 or 6)
        Faces as in `Mesh.boundary` and in its order.

    Raises
    ------
    ValueError
        If the direction is not three finite numbers other than zero, or the cosine is out of range.
    """
    towards = np.asarray(direction, dtype=float)
    if towards.shape != (3,) or not np.isfinite(towards).all() or not towards.any():
        raise ValueError(f"direction must be three finite numbers other than zero, got {direction}")
    if not 0.0 < least_cosine <= 1.0:
        raise ValueError(f"least_cosine must lie in (0, 1], got {least_cosine}")
    towards = towards / np.linalg.norm(towards)
    corners = mesh.nodes[mesh.boundary[:, :3]]
    normals = triangle_normals(corners)
    cosines = normals @ towards / np.linalg.norm(normals, axis=1)
    looking = mesh.boundary[cosines >= least_cosine]
    # a line of sight that meets the body enters it through a face that points the other way
    covers = corners[cosines < -UPRIGHT]
    return looking[~_covered(mesh.nodes[looking[:, :3]].mean(axis=1), covers, towards)]


def _covered(points: Floats, triangles: Floats, towards: Floats) -> np.ndarray:
    """Return True for points (p, 3) with a triangle (t, 3, 3) before them in a unit direction (3,)."""
    covered = np.zeros(len(points), dtype=bool)
    if len(points) == 0 or len(triangles) == 0:
        return covered
    across = np.linalg.svd(towards[None])[2][1:].T
    seen = points @ across
    flat = triangles @ across
    centers = flat.mean(axis=1)
    radii = np.linalg.norm(flat - centers[:, None], axis=2).max(axis=1)
    near = cKDTree(seen).query_ball_point(centers, radii)
    triangle = np.repeat(np.arange(len(triangles)), [len(places) for places in near])
    point = np.concatenate([np.asarray(places, dtype=np.int64) for places in near])
    sides = (flat[:, 1:] - flat[:, :1]).transpose(0, 2, 1)
    shares = np.linalg.solve(sides[triangle], (seen[point] - flat[triangle, 0])[:, :, None])[:, :, 0]
    inside = (shares >= 0.0).all(axis=1) & (shares.sum(axis=1) <= 1.0)
    depths = triangles @ towards
    depth = depths[triangle, 0] + np.einsum("ps,ps->p", shares, depths[triangle, 1:] - depths[triangle, :1])
    before = inside & (depth > points[point] @ towards)
    covered[point[before]] = True
    return covered


def faces_joined_to(faces: Integers, seed: Integers) -> Integers:
    """Select the faces that are connected, edge by edge, with a face of a seed.

    Parameters
    ----------
    faces, seed : int array (k, 3 or 6), (s, 3 or 6)
        Triangles of nodes; faces of the seed that are not among `faces` are left out.

    Returns
    -------
    int array (j, 3 or 6)
        In the order of `faces`; empty if no face of the seed is among them.
    """
    if len(faces) == 0:
        return faces
    corners = np.sort(faces[:, :3], axis=1)
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [0, 2]]])
    _, number = np.unique(edges, axis=0, return_inverse=True)
    owner = np.tile(np.arange(len(faces)), 3)
    count = len(faces)
    links = coo_array(
        (np.ones(3 * count), (owner, count + number.ravel())), shape=(count + len(edges), count + len(edges))
    )
    _, label = connected_components(links, directed=False)
    wanted = {tuple(face) for face in np.sort(seed[:, :3], axis=1).tolist()}
    of_seed = [place for place, face in enumerate(corners.tolist()) if tuple(face) in wanted]
    return faces[np.isin(label[:count], label[of_seed])]


def surface_weights(mesh: Mesh, faces: Integers) -> Floats:
    """Integrate the shape functions over faces: (n,) in m2; their sum is the faces' area.

    Parameters
    ----------
    mesh : Mesh
    faces : int array (k, 3 or 6)
        Triangles of nodes; curved edges are kept.
    """
    barycentric, parts = triangle_rule()
    values, slopes = triangle_shapes(barycentric, faces.shape[1])
    tangents = np.einsum("qas,kac->kqsc", slopes, mesh.nodes[faces])
    area = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2) * parts
    shares: Floats = (area @ values).ravel()
    return np.asarray(np.bincount(faces.ravel(), shares, len(mesh.nodes)), dtype=np.float64)


def triangle_shapes(barycentric: Floats, width: int) -> tuple[Floats, Floats]:
    """Return shape functions (q, width) and slopes (q, width, 2) of 3- or 6-node triangles at (q, 3)."""
    a, b, c = barycentric.T
    if width == 3:
        slopes = np.broadcast_to(np.array([[-1, -1], [1, 0], [0, 1]], dtype=float), (len(a), 3, 2))
        return barycentric, slopes
    values = np.column_stack(
        [a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a]
    )
    slopes = np.stack(
        [
            np.column_stack([1 - 4 * a, 4 * b - 1, 0 * c, 4 * (a - b), 4 * c, -4 * c]),
            np.column_stack([1 - 4 * a, 0 * b, 4 * c - 1, -4 * b, 4 * b, 4 * (a - c)]),
        ],
        axis=2,
    )
    return values, slopes


def triangle_rule() -> tuple[Floats, Floats]:
    """Return barycentric points (q, 3) and weights (q,) of a rule of order 6 on the unit triangle."""
    from skfem import ElementTriP1  # takes 0.1 s; naming surfaces does not need it
    from skfem.quadrature import get_quadrature

    points, weights = get_quadrature(ElementTriP1, 6)
    return np.column_stack([1 - points.sum(axis=0), points[0], points[1]]), weights
