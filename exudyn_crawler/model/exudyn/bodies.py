"""Shoes and terrain as Exudyn's bodies, with their weights."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.ground.terrain import terrain_joints
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.exudyn.euler_parameters import UNTURNED
from exudyn_crawler.model.forces.units import TerrainTable
from exudyn_crawler.model.state import BODY_COORDINATES
from exudyn_crawler.model.tables import Tables

ARM = 0.05
"""m, distance of a joint's massless nodes from its centre."""
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
    """Points that pins and loads attach to: both ends of every pin, then both `SIDES` of every load."""
    markers, loads = tables.markers, tables.loads
    columns = (markers.position, markers.displacement, markers.rotation)
    points = [
        Point(int(markers.body[k]), *(values[k] for values in columns)) for k in tables.joints.pins.ravel()
    ]
    for place, beside in zip(loads.marker, loads.beside, strict=True):
        for side in SIDES:
            moved = (values[place] + side * values[beside] for values in columns)
            points.append(Point(int(markers.body[place]), *moved))
    return points


def coordinate_marker(mbs: "exu.MainSystem", node: int, coordinate: int) -> int:
    """Marker of one coordinate of a node."""
    return mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))


def hold(
    mbs: "exu.MainSystem", fixed: int, node: int, coordinate: int, name: str, velocity_level: bool = False
) -> int:
    """Constraint that keeps one coordinate of a node where it is; `fixed` is a marker of the ground."""
    return mbs.AddObject(
        items.ObjectConnectorCoordinate(
            name=name,
            markerNumbers=[fixed, coordinate_marker(mbs, node, coordinate)],
            velocityLevel=velocity_level,
        )
    )


def _generic_node(mbs: "exu.MainSystem", name: str, size: int) -> int:
    zeros = [0.0] * size
    return mbs.AddNode(
        items.NodeGenericODE2(
            name=name,
            referenceCoordinates=zeros,
            initialCoordinates=zeros,
            initialCoordinates_t=zeros,
            numberOfODE2Coordinates=size,
        )
    )


def _sparse(values: np.ndarray) -> "exu.MatrixContainer":
    rows, columns = np.nonzero(values)
    container = exu.MatrixContainer()
    triplets = np.column_stack((rows, columns, values[rows, columns]))
    container.SetWithSparseMatrix(triplets, *values.shape)
    return container


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
    shoes = Shoes(nodes, [], [], [0] * len(points))
    for b, node in enumerate(nodes):
        own = {k: point for k, point in enumerate(points) if point.body == b}
        if tables.bodies.modal[b] >= 0:
            modal = _generic_node(mbs, f"modes of shoe {b + 1}", len(tables.modes.stiffness))
            shoes.modal_nodes.append(modal)
            body, markers = _floating_body(mbs, tables, b, (node, modal), list(own.values()))
        else:
            body, markers = _rigid_body(mbs, tables, b, node, list(own.values()))
        shoes.bodies.append(body)
        for k, marker in zip(own, markers, strict=True):
            shoes.markers[k] = marker
        weight = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=body))
        mbs.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=gravity.tolist()))
    return shoes


def _inertia(tables: Tables, b: int) -> tuple[np.ndarray, np.ndarray]:
    """Inertia (3, 3) of a body about its frame's origin, kg m2, and its COM (3,), m."""
    second = tables.bodies.second[b]
    return np.trace(second) * np.eye(3) - second, tables.bodies.first[b] / tables.bodies.mass[b]


def _rigid_body(
    mbs: "exu.MainSystem", tables: Tables, b: int, node: int, points: list[Point]
) -> tuple[int, list[int]]:
    inertia, com = _inertia(tables, b)
    body = mbs.AddObject(
        items.ObjectRigidBody(
            name=f"shoe {b + 1}",
            mass=tables.bodies.mass[b],
            inertia=[inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))],
            centerOfMass=com.tolist(),
            nodeNumber=node,
        )
    )
    markers = [
        mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=point.position.tolist()))
        for point in points
    ]
    return body, markers


def _floating_body(
    mbs: "exu.MainSystem", tables: Tables, b: int, nodes: tuple[int, int], points: list[Point]
) -> tuple[int, list[int]]:
    """Floating frame of reference, with massless nodes that move as its points do by the modes."""
    inertia, com = _inertia(tables, b)
    modes = tables.modes
    positions: list[np.ndarray] = []
    rows, massless = [], []
    for point in points:
        offsets = CORNERS if point.rotation.any() else np.zeros((1, 3))
        massless.append(list(range(len(positions), len(positions) + len(offsets))))
        for offset in offsets:
            positions.append(point.position + offset)
            rows.append(point.displacement + np.cross(point.rotation, offset, axisa=0, axisc=0))
    body = mbs.AddObject(
        items.ObjectFFRFreducedOrder(
            name=f"shoe {b + 1}",
            nodeNumbers=list(nodes),
            massMatrixReduced=_sparse(np.eye(len(modes.stiffness))),
            stiffnessMatrixReduced=_sparse(np.diag(modes.stiffness)),
            dampingMatrixReduced=_sparse(np.diag(modes.damping)),
            modeBasis=np.concatenate(rows),
            referencePositions=np.concatenate(positions),
            mass=tables.bodies.mass[b],
            inertia=inertia,
            centerOfMass=com,
            **floating_integrals(tables),
        )
    )
    markers = []
    for numbers in massless:
        kind = items.MarkerSuperElementRigid if len(numbers) > 1 else items.MarkerSuperElementPosition
        weights = [1.0 / len(numbers)] * len(numbers)
        markers.append(
            mbs.AddMarker(kind(bodyNumber=body, meshNodeNumbers=numbers, weightingFactors=weights))
        )
    return body, markers


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
    node = _generic_node(mbs, "terrain", size)
    mbs.AddObject(
        items.ObjectGenericODE2(
            name="terrain",
            nodeNumbers=[node],
            massMatrix=_sparse(np.eye(size)),
            stiffnessMatrix=_sparse(terrain.stiffness),
            dampingMatrix=_sparse(terrain.damping),
            forceVector=-gravity[2] * terrain.weight,
        )
    )
    return [node]


def add_units(mbs: "exu.MainSystem", case: Case, fixed: int) -> list[int]:
    """Terrain as rigid units with springs, the papers' joints and held rotations; gives the units' nodes.

    Units only tilt, so that angles serve them. `fixed` is a marker of the ground.
    """
    terrain = case.unit_terrain()
    ground = mbs.AddObject(items.ObjectGround())
    # on a slope the ground below holds each unit along it; the joints, which end at the one unit that is
    # held, would hand the whole grid's share from unit to unit
    weight = [0.0, 0.0, terrain.unit_mass * case.gravity_vector()[2]]
    nodes, bodies = [], []
    for number, center in enumerate(terrain.even_centers, start=1):
        name = f"unit {number}"
        node = mbs.AddNode(items.NodeRigidBodyRxyz(name=name, referenceCoordinates=[*center, 0.0, 0.0, 0.0]))
        inertia = [*terrain.unit_inertia, 0.0, 0.0, 0.0]
        body = mbs.AddObject(
            items.ObjectRigidBody(name=name, mass=terrain.unit_mass, inertia=inertia, nodeNumber=node)
        )
        com = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body))
        mbs.AddLoad(items.LoadForceVector(markerNumber=com, loadVector=weight))
        _add_springs(mbs, case, (ground, body), center)
        if terrain.column_tilt:
            stiffness = terrain.springs_per_unit * terrain.column_tilt_stiffness
            mbs.AddObject(
                items.ObjectConnectorCoordinateSpringDamper(
                    markerNumbers=[fixed, coordinate_marker(mbs, node, 3 + terrain.tilt_axis)],
                    stiffness=stiffness,
                    damping=terrain.damping_time * stiffness,
                )
            )
        for axis in {0, 1, 2} - {terrain.tilt_axis}:
            hold(mbs, fixed, node, 3 + axis, f"rotation {axis} of {name}", velocity_level=True)
        nodes.append(node)
        bodies.append(body)
    _add_unit_joints(mbs, case, bodies)
    for axis in (0, 1):
        hold(mbs, fixed, nodes[-1], axis, f"hold of unit {len(nodes)} ({BODY_COORDINATES[axis]})")
    return nodes


def _add_springs(mbs: "exu.MainSystem", case: Case, bodies: tuple[int, int], center: np.ndarray) -> None:
    """Springs between the ground and a unit, one or two across it."""
    terrain = case.unit_terrain()
    across = np.eye(3)[0 if terrain.tilt == "pitch" else 1]
    springs = [0.0] if terrain.springs_per_unit == 1 else [-terrain.spring_offset, terrain.spring_offset]
    for offset in springs:
        ends = zip(bodies, (center + offset * across, offset * across), strict=True)
        markers = [
            mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=place.tolist()))
            for body, place in ends
        ]
        mbs.AddObject(
            items.ObjectConnectorCartesianSpringDamper(
                markerNumbers=markers,
                stiffness=[0.0, 0.0, terrain.spring_stiffness],
                damping=[0.0, 0.0, terrain.spring_damping],
            )
        )


def _add_unit_joints(mbs: "exu.MainSystem", case: Case, bodies: Sequence[int]) -> None:
    """Spherical and in-plane joints at the middle of shared faces."""
    sides = 0.5 * np.array([case.unit_terrain().unit_length, case.unit_terrain().unit_width])
    for joint in terrain_joints(case.unit_terrain()):
        face = sides[joint.axis] * np.eye(3)[joint.axis]
        ends = ((joint.first, face), (joint.second, -face))
        markers = [
            mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=bodies[unit], localPosition=place.tolist()))
            for unit, place in ends
        ]
        mbs.AddObject(
            items.ObjectJointSpherical(
                name=f"terrain joint {joint.first + 1}-{joint.second + 1}",
                markerNumbers=markers,
                constrainedAxes=[1, 1, 1] if joint.spherical else [0, 0, 1],
            )
        )
