"""Terrain of the multibody system, in either formulation."""

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.ground.coordinates import ConstrainedCoordinates, ReducedCoordinates, TerrainCoordinates
from exudyn_crawler.ground.terrain import localized, terrain_joints, terrain_modes, units_near
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.items import coordinate_marker, hold

REACH = 1.0
"""m round the track at t = 0 within which contact is expected; beyond, only the speed suffers."""


def add_terrain(mbs: "exu.MainSystem", case: Case, ground: int) -> tuple[list[int], TerrainCoordinates]:
    """Add the terrain in the case's formulation: its nodes and how they carry the units' motion."""
    # the engine's own contact needs the units as bodies
    if case.terrain_formulation == "constrained" or case.contact.model == "spheres":
        return _add_constrained_terrain(mbs, case, ground)
    return _add_reduced_terrain(mbs, case)


def reduced_coordinates(case: Case) -> ReducedCoordinates:
    """Independent coordinates of a case's terrain, of which the track moves as few as possible."""
    near = units_near(case.terrain, case.outline(0.0), REACH)
    modes = localized(terrain_modes(case.terrain), near)
    moved = np.any(modes.heave[near] != 0.0, axis=0) | np.any(modes.tilt[near] != 0.0, axis=0)
    reached = int(np.flatnonzero(moved).max()) + 1
    return ReducedCoordinates(modes, case.terrain.tilt_axis, reached)


def _add_reduced_terrain(mbs: "exu.MainSystem", case: Case) -> tuple[list[int], TerrainCoordinates]:
    """Terrain in its independent coordinates."""
    coordinates = reduced_coordinates(case)
    modes = coordinates.modes
    zeros = [0.0] * modes.size
    node = mbs.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=zeros,
            initialCoordinates=zeros,
            initialCoordinates_t=zeros,
            numberOfODE2Coordinates=modes.size,
        )
    )
    mbs.AddObject(
        items.ObjectGenericODE2(
            name="terrain",
            nodeNumbers=[node],
            massMatrix=_sparse(np.eye(modes.size)),
            stiffnessMatrix=_sparse(modes.stiffness),
            dampingMatrix=_sparse(modes.damping),
            forceVector=-case.gravity_vector()[2] * modes.weight,
        )
    )
    return [node], coordinates


def _sparse(values: NDArray) -> "exu.MatrixContainer":
    rows, columns = np.nonzero(values)
    matrix = exu.MatrixContainer()
    triplets = np.column_stack((rows, columns, values[rows, columns]))
    matrix.SetWithSparseMatrix(triplets, *values.shape)
    return matrix


def _add_constrained_terrain(
    mbs: "exu.MainSystem", case: Case, ground: int
) -> tuple[list[int], TerrainCoordinates]:
    """Terrain as rigid units with the papers' joints and held rotations."""
    terrain = case.terrain
    fixed = mbs.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0)
    )
    nodes, bodies = [], []
    # on a slope the ground below holds each unit along it; the joints, which end at the one unit that is
    # held, would hand the whole grid's share from unit to unit
    weight = [0.0, 0.0, terrain.unit_mass * case.gravity_vector()[2]]
    across = np.eye(3)[0 if terrain.tilt == "pitch" else 1]
    springs = [0.0] if terrain.springs_per_unit == 1 else [-terrain.spring_offset, terrain.spring_offset]
    for number, center in enumerate(terrain.centers, start=1):
        node = mbs.AddNode(
            items.NodeRigidBodyRxyz(name=f"unit {number}", referenceCoordinates=[*center, 0.0, 0.0, 0.0])
        )
        body = mbs.AddObject(
            items.ObjectRigidBody(
                name=f"unit {number}",
                mass=terrain.unit_mass,
                inertia=[*terrain.unit_inertia, 0.0, 0.0, 0.0],
                nodeNumber=node,
            )
        )
        nodes.append(node)
        bodies.append(body)
        com = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body))
        mbs.AddLoad(items.LoadForceVector(markerNumber=com, loadVector=weight))
        for offset in springs:
            place = offset * across
            mbs.AddObject(
                items.ObjectConnectorCartesianSpringDamper(
                    markerNumbers=[
                        mbs.AddMarker(
                            items.MarkerBodyPosition(bodyNumber=ground, localPosition=list(center + place))
                        ),
                        mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=list(place))),
                    ],
                    stiffness=[0.0, 0.0, terrain.spring_stiffness],
                    damping=[0.0, 0.0, terrain.spring_damping],
                )
            )
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
            mbs.AddObject(
                items.ObjectConnectorCoordinate(
                    name=f"rotation {axis} of unit {number}",
                    markerNumbers=[fixed, coordinate_marker(mbs, node, 3 + axis)],
                    velocityLevel=True,
                )
            )
    sides = 0.5 * np.array([terrain.unit_length, terrain.unit_width])
    for joint in terrain_joints(terrain):
        face = sides[joint.axis] * np.eye(3)[joint.axis]
        mbs.AddObject(
            items.ObjectJointSpherical(
                name=f"terrain joint {joint.first + 1}-{joint.second + 1}",
                markerNumbers=[
                    mbs.AddMarker(
                        items.MarkerBodyPosition(bodyNumber=bodies[unit], localPosition=list(place))
                    )
                    for unit, place in ((joint.first, face), (joint.second, -face))
                ],
                constrainedAxes=[1, 1, 1] if joint.spherical else [0, 0, 1],
            )
        )
    for axis in (0, 1):
        hold(mbs, fixed, nodes[-1], axis, f"hold of unit {terrain.unit_count}")
    return nodes, ConstrainedCoordinates(terrain.unit_count, terrain.tilt_axis)
