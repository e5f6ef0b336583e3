"""Contact in the multibody system: one item for all pairs, or the engine's own contact of spheres."""

import math
from collections.abc import Sequence

import numpy as np

from exudyn_crawler.case import Terrain
from exudyn_crawler.ground.contact import GroundContact
from exudyn_crawler.ground.sphere_contact import SphereField
from exudyn_crawler.ground.triplets import Weights
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.shoes import ShoeBody

CELL = 1.0
"""m, least side of the cells of the engine's search tree."""

NO_FRICTION = 1e-12
"""In place of zero: without friction the engine leaves out the normal forces' moment on the units."""


def add_general_contact(
    mbs: "exu.MainSystem",
    terrain: Terrain,
    spheres: SphereField,
    shoes: Sequence[ShoeBody],
    unit_nodes: Sequence[int],
) -> "exu.GeneralContact":
    """Spheres on the shoes and triangles on the units' top faces, in the engine's own contact."""
    law = spheres.law
    contact = mbs.AddGeneralContact()
    contact.frictionProportionalZone = law.friction_speed
    contact.SetFrictionPairings(np.array([[max(law.friction, NO_FRICTION)]]))
    contact.computeContactForces = True
    # spheres do not touch each other; this also takes the engine's derivatives of spheres on triangles away
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
    stiffness = 2.0 * law.stiffness
    damping = 0.5 * law.damping
    half = 0.5 * np.array([terrain.unit_length, terrain.unit_width]) - spheres.inset
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    for node, top in zip(unit_nodes, tops, strict=True):
        contact.AddTrianglesRigidBodyBased(
            rigidBodyMarkerIndex=mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node)),
            contactStiffness=stiffness,
            contactDamping=damping,
            frictionMaterialIndex=0,
            pointList=np.column_stack((corners, np.full(4, 0.5 * terrain.unit_height + top))).tolist(),
            triangleList=[[0, 1, 2], [0, 2, 3]],
        )
    for shoe in shoes:
        for place in spheres.places:
            marker = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=shoe.body, localPosition=place.tolist()))
            contact.AddSphereWithMarker(
                markerIndex=marker,
                radius=spheres.radius,
                contactStiffness=stiffness,
                contactDamping=damping,
                frictionMaterialIndex=0,
            )
    return contact


TANGENTS_A_STEP = 2
"""Jacobians with the tangent of the friction curve in one step; later ones take the secant."""


def add_contact(
    mbs: "exu.MainSystem", contact: GroundContact, nodes: Sequence[int], forces: bool = True
) -> None:
    """All contacts as one item over the shoes' and the terrain's nodes.

    Without `forces` it gives their derivatives only, the forces being another's.
    """
    size = contact.size
    asked_time, asked = -1.0, 0

    def force(_mbs, _t, _item, q, q_t):
        return contact.forces(np.array(q), np.array(q_t))

    def jacobian(_mbs, t, _item, q, q_t, position_factor, velocity_factor):
        nonlocal asked_time, asked
        asked_time, asked = (t, asked + 1) if t == asked_time else (t, 1)
        # Exudyn asks for the derivative of the left-hand side, where forces stand negative
        weights = Weights(-position_factor, -velocity_factor, secant=asked > TANGENTS_A_STEP)
        triplets = contact.derivatives(np.array(q), np.array(q_t), weights)
        matrix = exu.MatrixContainer()
        matrix.SetWithSparseMatrix(triplets, size, size)
        return matrix

    mbs.AddObject(
        items.ObjectGenericODE2(
            name="contact",
            nodeNumbers=list(nodes),
            massMatrix=exu.MatrixContainer(),
            forceUserFunction=force if forces else 0,
            jacobianUserFunction=jacobian,
        )
    )
