"""Exudyn's contact of spheres on the shoes with triangles on the units' top faces."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.ground.sphere_contact import face_inset, sphere_centers
from exudyn_crawler.model.engine import exu, items

CELL = 1.0
"""m, least side of the cells of the engine's search tree."""
NO_FRICTION = 1e-12
"""In place of zero: without friction Exudyn leaves out the normal forces' moment on the units."""


def add_spheres(
    mbs: "exu.MainSystem", case: Case, bodies: Sequence[int], unit_nodes: Sequence[int], static: bool
) -> "exu.GeneralContact":
    """Spheres of a case on the bodies of its shoes, and faces of its units.

    A face is two triangles. Damping and friction are those of `case.sphere_contact()`, the stiffness is
    `case.sphere_stiffness`.

    Parameters
    ----------
    static : bool
        Leave friction out: at rest there is none, and on the way to it the track would creep.
    """
    spheres, terrain, centers = case.sphere_contact(), case.unit_terrain(), sphere_centers(case)
    friction = NO_FRICTION if static else max(spheres.friction, NO_FRICTION)
    contact = mbs.AddGeneralContact()
    contact.frictionProportionalZone = spheres.friction_speed
    contact.SetFrictionPairings(np.array([[friction]]))
    contact.computeContactForces = True
    contact.sphereSphereContact = False
    # otherwise an edge pushes with half the force, as if two triangles shared it
    contact.excludeDuplicatedTrigSphereContactPoints = True
    (x0, x1), (y0, y1) = terrain.bounds
    tops = terrain.top_heights
    contact.SetSearchTreeCellSize(
        [max(1, math.ceil((x1 - x0) / CELL)), max(1, math.ceil((y1 - y0) / CELL)), 1]
    )
    contact.SetSearchTreeBox([x0, y0, tops.min() - 1.0], [x1, y1, tops.max() + 1.0])
    # the stiffnesses of both partners act in series, their dampings add
    law: dict[str, Any] = {
        "contactStiffness": 2.0 * case.sphere_stiffness,
        "contactDamping": 0.5 * spheres.damping / spheres.count,
        "frictionMaterialIndex": 0,
    }
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width]) - face_inset(case)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    for node, top in zip(unit_nodes, tops, strict=True):
        contact.AddTrianglesRigidBodyBased(
            rigidBodyMarkerIndex=mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node)),
            pointList=np.column_stack((corners, np.full(4, 0.5 * terrain.unit_height + top))).tolist(),
            triangleList=[[0, 1, 2], [0, 2, 3]],
            **law,
        )
    for body in bodies:
        for center in centers:
            marker = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=center.tolist()))
            contact.AddSphereWithMarker(markerIndex=marker, radius=spheres.radius, **law)
    return contact
