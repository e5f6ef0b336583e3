"""Shoes and terrain as Exudyn's bodies, with their weights."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.ground.terrain import terrain_joints
from exudyn_crawler.model.engine import RigidBodyInertia, exu, generic_node, items, sparse
from exudyn_crawler.model.exudyn.euler_parameters import UNTURNED
from exudyn_crawler.model.forces.units import TerrainTable
from exudyn_crawler.model.state import BODY_COORDINATES
from exudyn_crawler.model.tables import Tables

ARM = 0.05
"""m, distance of a point's massless nodes from it."""
CORNERS = ARM * np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
"""Of a tetrahedron: their mean is the centre, and no axis of rotation is preferred."""
SIDES = (-1.0, 1.0)
"""m, beside the place of a load: where its two shares act, to the right and to the left."""


class Point(NamedTuple):
    """A point of a body that joints or loads attach to, as of `joints.Markers`."""

    body: int
    position: np.ndarray
    displacement: np.ndarray
    rotation: np.ndarray


class Shoes(NamedTuple):
    """Shoes in Exudyn: nodes and bodies of all, nodes of the flexible ones' modes, markers of points."""

    nodes: list[int]
    bodies: list[int]
    modal_nodes: list[int]
    markers: list[int]


def points_of(tables: Tables) -> list[Point]:
    """Both ends of every pin, then both `SIDES` of every load, and last the drive's."""
    markers, loads, drive = tables.markers, tables.loads, tables.joints.drive
    loaded = zip(loads.marker.tolist(), loads.beside.tolist(), strict=True)
    places = [(k, k, 0.0) for k in tables.joints.pins.ravel().tolist()]
    places += [(k, by, side) for k, by in loaded for side in SIDES]
    places += [(drive, drive, 0.0)]
    columns = (markers.position, markers.displacement, markers.rotation)
    return [
        Point(int(markers.body[k]), *(values[k] + side * values[by] for values in columns))
        for k, by, side in places
    ]


def add_shoe_nodes(mbs: "exu.MainSystem", tables: Tables) -> list[int]:
    """Nodes of all shoes, with Euler parameters."""
    return [
        mbs.AddNode(items.NodeRigidBodyEP(name=f"shoe {s}", referenceCoordinates=[*row[:3], *UNTURNED]))
        for s, row in enumerate(tables.bodies.reference, start=1)
    ]


def add_shoes(
    mbs: "exu.MainSystem", tables: Tables, nodes: list[int], points: Sequence[Point], gravity: np.ndarray
) -> Shoes:
    """Rigid bodies and floating frames of the tables on their nodes, with their weights.

    `points` get markers, `gravity` (3,) is in m/s2, global.
    """
    shoes, bodies = Shoes(nodes, [], [], [0] * len(points)), tables.bodies
    for b, node in enumerate(nodes):
        name, is_rigid = f"shoe {b + 1}", bodies.modal[b] < 0
        own = {k: point for k, point in enumerate(points) if point.body == b}
        mass, com = bodies.mass[b], bodies.first[b] / bodies.mass[b]
        inertia = np.trace(bodies.second[b]) * np.eye(3) - bodies.second[b]
        if is_rigid:
            six = RigidBodyInertia(mass, inertia, com).GetInertia6D()
            body = mbs.AddObject(
                items.ObjectRigidBody(name=name, mass=mass, inertia=six, centerOfMass=com, nodeNumber=node)
            )
        else:
            shoes.modal_nodes.append(generic_node(mbs, f"modes of {name}", len(tables.modes.stiffness)))
            body = mbs.AddObject(
                items.ObjectFFRFreducedOrder(
                    name=name,
                    nodeNumbers=[node, shoes.modal_nodes[-1]],
                    mass=mass,
                    inertia=inertia,
                    centerOfMass=com,
                    **_elasticity(tables, list(own.values())),
                )
            )
        shoes.bodies.append(body)
        for n, (k, point) in enumerate(own.items()):
            corners, shares = [*range(4 * n, 4 * n + 4)], [0.25] * 4
            shoes.markers[k] = mbs.AddMarker(
                items.MarkerBodyRigid(bodyNumber=body, localPosition=point.position)
                if is_rigid
                else items.MarkerSuperElementRigid(
                    bodyNumber=body, meshNodeNumbers=corners, weightingFactors=shares
                )
            )
        weight = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=body))
        mbs.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=gravity))
    return shoes


def _elasticity(tables: Tables, points: list[Point]) -> dict[str, object]:
    """Modes of a floating frame of reference; they move four massless nodes about each point as it moves."""
    modes = tables.modes
    position, displacement, rotation = (np.stack(one)[:, None] for one in list(zip(*points, strict=True))[1:])
    rows = displacement + np.cross(rotation, CORNERS[None, :, :, None], axis=2)
    return {
        "massMatrixReduced": sparse(np.eye(len(modes.stiffness))),
        "stiffnessMatrixReduced": sparse(np.diag(modes.stiffness)),
        "dampingMatrixReduced": sparse(np.diag(modes.damping)),
        "modeBasis": rows.reshape(-1, len(modes.stiffness)),
        "referencePositions": (position + CORNERS).ravel(),
        **floating_integrals(tables),
    }


def floating_integrals(tables: Tables) -> dict[str, np.ndarray]:
    """Integrals over a flexible body as `ObjectFFRFreducedOrder` names them, of those of the tables.

    They are those of the nodal-based floating frame of reference formulation with modal reduction (Zwölfer
    and Gerstmayr, Acta Mechanica 2020, doi 10.1007/s00707-020-02886-2), made of ``a~^T b = -a x b`` and
    ``a~^T b~ = (a . b) 1 - b a^T`` for places and mode shapes a and b.
    """
    modes, m = tables.modes, len(tables.modes.stiffness)
    places = modes.places.reshape(3, m, 3)  # x_a Psi_ck over (a, k, c)
    products = modes.products.reshape(m, 3, m, 3)  # Psi_aj Psi_ck over (j, a, k, c)
    cross = np.zeros((3, 3, 3))
    cross[[0, 1, 2], [1, 2, 0], [2, 0, 1]], cross[[0, 1, 2], [2, 0, 1], [1, 2, 0]] = 1.0, -1.0

    def both_skew(pairs: np.ndarray) -> np.ndarray:
        return np.einsum("...aka,rs->...rks", pairs, np.eye(3)) - np.einsum("...skr->...rks", pairs)

    return {
        "mPhitTPsi": modes.shapes,
        "mPhitTPsiTilde": np.einsum("rds,dk->rks", cross, modes.shapes).reshape(3, 3 * m),
        "mPsiTildePsi": -np.einsum("rac,jakc->jrk", cross, products).reshape(3 * m, m),
        "mPsiTildePsiTilde": both_skew(products).reshape(3 * m, 3 * m),
        "mXRefTildePsi": -np.einsum("rac,akc->rk", cross, places),
        "mXRefTildePsiTilde": both_skew(places).reshape(3, 3 * m),
    }


def add_terrain_modes(mbs: "exu.MainSystem", terrain: TerrainTable, gravity: np.ndarray) -> list[int]:
    """Terrain in its independent coordinates; gives their node."""
    size = len(terrain.stiffness)
    nodes = [generic_node(mbs, "terrain", size)]
    mbs.AddObject(
        items.ObjectGenericODE2(
            name="terrain",
            nodeNumbers=nodes,
            massMatrix=sparse(np.eye(size)),
            stiffnessMatrix=sparse(terrain.stiffness),
            dampingMatrix=sparse(terrain.damping),
            forceVector=-gravity[2] * terrain.weight,
        )
    )
    return nodes


def add_units(mbs: "exu.MainSystem", case: Case) -> list[int]:
    """Terrain as rigid units with springs, the papers' joints and held rotations; gives the units' nodes.

    Units only tilt, so that angles serve them.
    """
    terrain, ground = case.unit_terrain(), mbs.CreateGround()
    axes, tilt = np.eye(3), terrain.tilt_axis
    offset = terrain.spring_offset * axes[1 - tilt]
    nodes, bodies = [], []
    for number, center in enumerate(terrain.even_centers, start=1):
        name = f"unit {number}"
        made = mbs.CreateRigidBody(
            name=name,
            referencePosition=center,
            inertia=RigidBodyInertia(terrain.unit_mass, np.diag(terrain.unit_inertia)),
            # on a slope the ground below holds each unit along it; the joints, which end at the one unit
            # that is held, would hand the whole grid's share from unit to unit
            gravity=[0.0, 0.0, case.gravity_vector()[2]],
            nodeType=exu.NodeType.RotationRxyz,
            returnDict=True,
        )
        body = made["bodyNumber"]
        for place in (0.0 * offset,) if terrain.springs_per_unit == 1 else (-offset, offset):
            mbs.CreateCartesianSpringDamper(
                itemNumbers=[ground, body],
                localPosition0=center + place,
                localPosition1=place,
                stiffness=[0.0, 0.0, terrain.spring_stiffness],
                damping=[0.0, 0.0, terrain.spring_damping],
            )
        if terrain.column_tilt:
            stiffness = terrain.springs_per_unit * terrain.column_tilt_stiffness
            mbs.CreateTorsionalSpringDamper(
                itemNumbers=[ground, body],
                position=center,
                axis=axes[tilt],
                stiffness=stiffness,
                damping=terrain.damping_time * stiffness,
                unlimitedRotations=False,
            )
        for axis in {0, 1, 2} - {tilt}:
            hold(mbs, made["nodeNumber"], 3 + axis, f"rotation {axis} of {name}", velocity_level=True)
        nodes.append(made["nodeNumber"])
        bodies.append(body)
    sides = 0.5 * np.array([terrain.unit_length, terrain.unit_width, 0.0])
    for joint in terrain_joints(terrain):
        mbs.CreateSphericalJoint(
            name=f"terrain joint {joint.first + 1}-{joint.second + 1}",
            itemNumbers=[bodies[joint.first], bodies[joint.second]],
            position=terrain.even_centers[joint.first] + sides * axes[joint.axis],
            constrainedAxes=[1, 1, 1] if joint.spherical else [0, 0, 1],
        )
    for axis in (0, 1):
        hold(mbs, nodes[-1], axis, f"hold of unit {len(nodes)} ({BODY_COORDINATES[axis]})")
    return nodes


def hold(mbs: "exu.MainSystem", node: int, coordinate: int, name: str, velocity_level: bool = False) -> int:
    """Constraint that keeps one coordinate of a node where it is."""
    return mbs.CreateCoordinateConstraint(
        name, itemNumbers=[None, node], coordinates=[None, coordinate], velocityLevel=velocity_level
    )
