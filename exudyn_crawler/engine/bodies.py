"""Exudyn's bodies for shoes and terrain, with their weights."""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.engine.euler_parameters import UNTURNED
from exudyn_crawler.ground.terrain import terrain_joints
from exudyn_crawler.model.exudyn import RigidBodyInertia, add_coordinates, exu, generic_node, items, sparse
from exudyn_crawler.model.tables import Tables

CORNERS = 0.05 * np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
"""Corners of a tetrahedron, m; their mean is the centre, and no axis of rotation is preferred."""


class Shoes(NamedTuple):
    """Numbers of Exudyn's items for shoes: nodes, bodies, nodes of flexible shoes' modes, and markers."""

    nodes: list[int]
    bodies: list[int]
    modal_nodes: list[int]
    markers: list[int]


def add_shoe_nodes(mbs: "exu.MainSystem", tables: Tables) -> list[int]:
    """Add the nodes of all shoes, with Euler parameters; return their numbers."""
    return [
        mbs.AddNode(items.NodeRigidBodyEP(name=f"shoe {s}", referenceCoordinates=[*row[:3], *UNTURNED]))
        for s, row in enumerate(tables.bodies.reference, start=1)
    ]


def add_shoes(mbs: "exu.MainSystem", tables: Tables, nodes: list[int], gravity: np.ndarray) -> Shoes:
    """Add the tables' rigid bodies and floating frames on their nodes, with their weights.

    The bodies get the tables' markers; a marker beside a load becomes the point a metre to the left of the
    load. `gravity` (3,) is in m/s2, global.
    """
    tables = _with_points(tables)
    shoes = Shoes(nodes, [], [], [])
    bodies = tables.bodies
    markers = tables.markers
    for b, node in enumerate(nodes):
        mass = bodies.mass[b]
        inertia = np.trace(bodies.second[b]) * np.eye(3) - bodies.second[b]
        values = {"name": f"shoe {b + 1}", "mass": mass, "centerOfMass": bodies.first[b] / mass}
        if bodies.modal[b] < 0:
            six = RigidBodyInertia(mass, inertia).GetInertia6D()
            body = mbs.AddObject(items.ObjectRigidBody(nodeNumber=node, inertia=six, **values))
        else:
            modal = generic_node(mbs, f"modes of shoe {b + 1}", len(tables.modes.stiffness))
            values |= {"nodeNumbers": [node, modal], "inertia": inertia, **_elasticity(tables)}
            body = mbs.AddObject(items.ObjectFFRFreducedOrder(**values))
            shoes.modal_nodes.append(modal)
        shoes.bodies.append(body)
        weight = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=body))
        mbs.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=gravity))
    for k, (b, place) in enumerate(zip(markers.body, markers.position, strict=True)):
        body = shoes.bodies[b]
        if bodies.modal[b] < 0:
            marker = items.MarkerBodyRigid(bodyNumber=body, localPosition=place)
        else:
            mesh = [*range(4 * k, 4 * k + 4)]
            marker = items.MarkerSuperElementRigid(
                bodyNumber=body, meshNodeNumbers=mesh, weightingFactors=[0.25] * 4
            )
        shoes.markers.append(mbs.AddMarker(marker))
    return shoes


def _with_points(tables: Tables) -> Tables:
    """Return tables with points as markers: a marker beside a load is added to the marker of the load."""
    markers = tables.markers
    added = np.eye(len(markers.body))
    shifts = tables.loads.beside >= 0
    added[tables.loads.beside[shifts], tables.loads.marker[shifts]] = 1.0
    points = markers._replace(
        position=np.tensordot(added, markers.position, axes=1),
        displacement=np.tensordot(added, markers.displacement, axes=1),
        rotation=np.tensordot(added, markers.rotation, axes=1),
    )
    return tables._replace(markers=points)


def _elasticity(tables: Tables) -> dict[str, object]:
    """Return a floating frame's modes and integrals, by the parameters' names of `ObjectFFRFreducedOrder`.

    The modes move four massless nodes about each point rigidly with it. Every frame has the nodes of all
    points; those on other bodies are unused. The integrals are those of the nodal-based floating frame of
    reference formulation with modal reduction (Zwölfer and Gerstmayr, Acta Mechanica 2020, doi
    10.1007/s00707-020-02886-2). They follow from ``a~^T b = -a x b`` and ``a~^T b~ = (a . b) 1 - b a^T`` for
    places and mode shapes a and b.
    """
    points = tables.markers
    modes = tables.modes
    m = len(modes.stiffness)
    turned = np.cross(points.rotation[:, None], CORNERS[None, :, :, None], axis=2)
    cross = np.cross(np.eye(3)[:, None], np.eye(3))
    # x_a Psi_ck over (0, a, c, k), then Psi_aj Psi_ck over (j, a, c, k)
    pairs = np.concatenate((modes.places[None], modes.products.reshape(m, 9, m))).reshape(1 + m, 3, 3, m)
    once = -np.einsum("rac,jack->jrk", cross, pairs)
    twice = np.einsum("jaak,rs->jrks", pairs, np.eye(3)) - np.einsum("jsrk->jrks", pairs)
    return {
        "massMatrixReduced": sparse(np.eye(m)),
        "stiffnessMatrixReduced": sparse(np.diag(modes.stiffness)),
        "dampingMatrixReduced": sparse(np.diag(modes.damping)),
        "modeBasis": (points.displacement[:, None] + turned).reshape(-1, m),
        "referencePositions": (points.position[:, None] + CORNERS).ravel(),
        "mPhitTPsi": modes.shapes,
        "mPhitTPsiTilde": np.einsum("rds,dk->rks", cross, modes.shapes).reshape(3, 3 * m),
        "mXRefTildePsi": once[0],
        "mXRefTildePsiTilde": twice[0].reshape(3, 3 * m),
        "mPsiTildePsi": once[1:].reshape(3 * m, m),
        "mPsiTildePsiTilde": twice[1:].reshape(3 * m, 3 * m),
    }


def add_terrain_modes(mbs: "exu.MainSystem", tables: Tables, gravity: np.ndarray) -> list[int]:
    """Add the terrain in its independent coordinates; return their node."""
    terrain = tables.terrain
    acting = {
        "stiffnessMatrix": sparse(terrain.stiffness),
        "dampingMatrix": sparse(terrain.damping),
        "forceVector": -gravity[2] * terrain.weight,
    }
    return [add_coordinates(mbs, "terrain", len(terrain.stiffness), **acting)]


def add_units(mbs: "exu.MainSystem", case: Case) -> list[int]:
    """Add the terrain as rigid units with springs, the papers' joints and held rotations; return the nodes.

    Units only tilt, so that angles are sufficient as coordinates.
    """
    terrain = case.part(Terrain)
    ground = mbs.CreateGround()
    axes = np.eye(3)
    tilt = terrain.tilt_axis
    support = np.zeros((6, 6))
    support[2, 2] = terrain.spring_stiffness
    support[3 + tilt, 3 + tilt] = terrain.column_tilt_stiffness
    offset = terrain.spring_offset * axes[1 - tilt]
    nodes = []
    bodies = []
    for number, center in enumerate(terrain.even_centers, start=1):
        made = mbs.CreateRigidBody(
            name=f"unit {number}",
            referencePosition=center,
            inertia=RigidBodyInertia(terrain.unit_mass, np.diag(terrain.unit_inertia)),
            # on a slope the ground below holds each unit along it; otherwise the joints would pass the whole
            # grid's share from unit to unit to the single held one
            gravity=[0.0, 0.0, case.gravity_vector()[2]],
            nodeType=exu.NodeType.RotationRxyz,
            returnDict=True,
        )
        node = made["nodeNumber"]
        body = made["bodyNumber"]
        for place in (0.0 * offset,) if terrain.springs_per_unit == 1 else (-offset, offset):
            mbs.CreateRigidBodySpringDamper(
                itemNumbers=[ground, body],
                localPosition0=center + place,
                localPosition1=place,
                stiffness=support,
                damping=terrain.damping_time * support,
                useIntrinsicFormulation=False,
            )
        for axis in {0, 1, 2} - {tilt}:
            held = f"rotation {axis} of unit {number}"
            mbs.CreateCoordinateConstraint(held, [None, node], [None, 3 + axis], velocityLevel=True)
        nodes.append(node)
        bodies.append(body)
    sides = 0.5 * np.array([terrain.unit_length, terrain.unit_width, 0.0])
    for joint in terrain_joints(terrain):
        mbs.CreateSphericalJoint(
            name=f"terrain joint {joint.first + 1}-{joint.second + 1}",
            itemNumbers=[bodies[joint.first], bodies[joint.second]],
            position=terrain.even_centers[joint.first] + sides * axes[joint.axis],
            constrainedAxes=[1, 1, 1] if joint.spherical else [0, 0, 1],
        )
    for axis, name in enumerate("xy"):
        held = f"hold of unit {len(nodes)} ({name})"
        mbs.CreateCoordinateConstraint(held, [None, nodes[-1]], [None, axis])
    return nodes
