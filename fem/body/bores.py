"""Round bores of a body: their faces, axes and the forces of pressures in them."""

from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.sparse import csc_array

from fem.body.interfaces import Interface
from fem.body.mesh import Floats, Mesh
from fem.body.surfaces import triangle_rule, triangle_shapes

AROUND = 24
"""Least number of nodes around a bore that resolve the stress at it."""


class BoreFaces(NamedTuple):
    """Faces of a bore: f faces with q points each.

    Attributes
    ----------
    axes : array (3, 3)
        Unit vectors in rows: direction of the angle 0 (near x), that of 90 degrees, and the axis of the bore.
    radius : float
        In m.
    loads : sparse array (3n, f)
        Nodal forces of a unit pressure on each face, m2.
    resultants : array (f, 6)
        Resultants of these: force (m2) and moment about the centre (m3), along body axes.
    areas, angles, along : array (f, q)
        Area (m2), angle (rad) and position along the axis (m) of each point.
    ends : array (2,)
        Positions of both ends of the bore along the axis, m.
    around : float
        Mean number of nodes around the bore.
    """

    axes: Floats
    radius: float
    loads: csc_array
    resultants: Floats
    areas: Floats
    angles: Floats
    along: Floats
    ends: Floats
    around: float

    @property
    def length(self) -> float:
        """Distance between both ends of the bore, m."""
        return float(self.ends[1] - self.ends[0])


def bore_faces(mesh: Mesh, interface: Interface) -> BoreFaces:
    """Integrate pressures over the faces of an interface, a round bore.

    Raises
    ------
    ValueError
        If the interface has no faces.
    """
    inside = np.zeros(len(mesh.nodes), dtype=bool)
    inside[interface.nodes] = True
    faces = mesh.boundary[inside[mesh.boundary].all(axis=1)]
    if not len(faces):
        raise ValueError(f"interface {interface.name!r} must have faces for the contact of a pin, got none")
    points, weights = triangle_rule()
    values, slopes = triangle_shapes(points, faces.shape[1])
    corners = mesh.nodes[faces]
    places = np.einsum("qa,fac->fqc", values, corners) - interface.center
    tangents = np.einsum("qas,fac->fqsc", slopes, corners)
    normals = weights[:, None] * np.cross(tangents[:, :, 0], tangents[:, :, 1])
    axis = _axis(np.unique(corners[:, :3].reshape(-1, 3), axis=0) - interface.center, normals)
    first = np.eye(3)[0] if abs(axis[0]) < 0.9 else np.eye(3)[2]
    first = first - (first @ axis) * axis
    first = first / np.linalg.norm(first)
    axes = np.stack((first, np.cross(first, axis), axis))
    local = places @ axes.T
    radial = local[..., :2] @ axes[:2]
    normals *= np.sign(np.einsum("fqc,fqc->fq", normals, radial))[..., None]
    forces = np.einsum("qa,fqc->fac", values, normals)
    rows = 3 * faces[:, :, None] + np.arange(3)
    columns = np.broadcast_to(np.arange(len(faces))[:, None, None], rows.shape)
    loads = csc_array((forces.ravel(), (rows.ravel(), columns.ravel())), shape=(mesh.nodes.size, len(faces)))
    moments = np.cross(places, normals).sum(axis=1)
    at_corners = (corners[:, :3] - interface.center) @ axes.T
    ends = np.array([at_corners[..., 2].min(), at_corners[..., 2].max()])
    bearing = np.arctan2(at_corners[..., 1], at_corners[..., 0])
    reach = np.ptp(np.unwrap(bearing, axis=1), axis=1).mean()
    return BoreFaces(
        axes,
        float(np.linalg.norm(local[..., :2], axis=-1).mean()),
        loads,
        np.concatenate((normals.sum(axis=1), moments), axis=1),
        np.linalg.norm(normals, axis=-1),
        np.arctan2(local[..., 1], local[..., 0]),
        local[..., 2],
        ends,
        float(2.0 * np.pi / reach) * (1 if faces.shape[1] == 3 else 2),
    )


def _axis(places: Floats, normals: Floats) -> Floats:
    """Return the axis (3,) of the cylinder about the origin through places (k, 3)."""
    # hardly any normal has a part along the axis
    near = np.linalg.svd(normals.reshape(-1, 3), full_matrices=False)[2]
    near = near * np.sign(near[2][np.abs(near[2]).argmax()])

    def off(tilt: Floats) -> Floats:
        axis = near[2] + tilt[:2] @ near[:2]
        return np.linalg.norm(np.cross(places, axis), axis=1) / np.linalg.norm(axis) - tilt[2]

    radius = float(np.linalg.norm(np.cross(places, near[2]), axis=1).mean())
    found = near[2] + least_squares(off, [0.0, 0.0, radius], x_scale=[1.0, 1.0, radius]).x[:2] @ near[:2]
    return np.asarray(found / np.linalg.norm(found))
