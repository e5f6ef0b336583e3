"""Exudyn's own contact of spheres on the shoes with faces of the terrain's units."""

import numpy as np

from exudyn_crawler.case import Case, statics
from exudyn_crawler.case.parameters.contact import SphereContact
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.ground import sphere_contact
from exudyn_crawler.model.exudyn import exu, items

CELL = 1.0
"""Least side of the cells of the engine's search tree, m."""
NO_FRICTION = 1e-12
"""Coefficient in place of zero: without friction Exudyn omits the normal forces' moment on the units."""


def add_spheres(
    mbs: "exu.MainSystem", case: Case, bodies: list[int], unit_nodes: list[int], static: bool
) -> "exu.GeneralContact":
    """Add spheres on the bodies of a case's shoes, and faces of its units, two triangles each.

    Damping and friction are those of `case.part(SphereContact)`, the stiffness is `statics.sphere_stiffness`.
    `static` omits friction: there is none at rest, and the track would creep on the way to it.
    """
    spheres = case.part(SphereContact)
    terrain = case.part(Terrain)
    contact = mbs.AddGeneralContact()
    contact.frictionProportionalZone = spheres.friction_speed
    contact.SetFrictionPairings(np.array([[NO_FRICTION if static else max(spheres.friction, NO_FRICTION)]]))
    contact.computeContactForces = True
    contact.sphereSphereContact = False
    # otherwise an edge pushes with half the force, as if two triangles shared it
    contact.excludeDuplicatedTrigSphereContactPoints = True
    low, high = np.transpose(terrain.bounds)
    tops = terrain.top_heights
    contact.SetSearchTreeCellSize([*np.ceil((high - low) / CELL).astype(int), 1])
    contact.SetSearchTreeBox([*low, tops.min() - 1.0], [*high, tops.max() + 1.0])
    # the stiffnesses of both partners act in series, their dampings add; the last is their friction's number
    law = 2.0 * statics.sphere_stiffness(case, spheres), 0.5 * spheres.damping / spheres.count, 0
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width]) - sphere_contact.face_inset(case)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    for node, top, slope in zip(unit_nodes, tops, terrain.slopes, strict=True):
        z = 0.5 * terrain.unit_height + top + slope * corners[:, 0]
        marker = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node))
        faces = np.column_stack((corners, z)).tolist(), [[0, 1, 2], [0, 2, 3]]
        contact.AddTrianglesRigidBodyBased(marker, *law, *faces)
    for body in bodies:
        for center in sphere_contact.sphere_centers(case):
            marker = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=center))
            contact.AddSphereWithMarker(marker, spheres.radius, *law)
    return contact
