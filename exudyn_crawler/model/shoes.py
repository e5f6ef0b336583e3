"""Rigid and flexible shoes as bodies of the multibody system, seen alike by joints and loads."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.flexible_shoes import NODES_A_JOINT, FloatingShoe

REACH = 1.0
"""m, of the points on a rigid shoe that share a load beside its load point."""


@dataclass(frozen=True)
class ShoeBody:
    """A shoe in the multibody system: its body and the markers that others attach to.

    `pins` holds a marker for each (end, side), end being "front" or "rear"; `top` the marker of the machine
    load; `sides` those at the right and at the left that share a load which acts beside it, `reach` (m) away
    from it; `modal_node` the node of the modal coordinates, None for a rigid shoe.
    """

    node: int
    body: int
    top: int
    sides: tuple[int, int]
    reach: float
    pins: dict[tuple[str, str], int]
    modal_node: int | None

    @property
    def is_flexible(self) -> bool:
        """Whether the shoe has modal coordinates."""
        return self.modal_node is not None


def add_shoe_nodes(mbs: "exu.MainSystem", case: Case) -> list[int]:
    """Rigid-body nodes of all shoes at their places at t = 0."""
    return [
        mbs.AddNode(
            items.NodeRigidBodyRxyz(name=f"shoe {number}", referenceCoordinates=[*position, 0.0, 0.0, 0.0])
        )
        for number, position in enumerate(case.track.com_positions(case.shoe.com_height), start=1)
    ]


def add_shoe_bodies(
    mbs: "exu.MainSystem", case: Case, nodes: Sequence[int], floating: FloatingShoe | None
) -> list[ShoeBody]:
    """Bodies of all shoes with their weights; the flexible ones share one reduction."""
    chosen = () if floating is None else case.flexible_shoes().shoes
    bodies = []
    for number, node in enumerate(nodes, start=1):
        if floating is not None and number in chosen:
            bodies.append(add_flexible(mbs, case, number, node, floating))
        else:
            bodies.append(_add_rigid(mbs, case, number, node))
    return bodies


def _add_rigid(mbs: "exu.MainSystem", case: Case, number: int, node: int) -> ShoeBody:
    shoe = case.shoe
    body = mbs.AddObject(
        items.ObjectRigidBody(
            name=f"shoe {number}", mass=shoe.mass, inertia=list(shoe.inertia), nodeNumber=node
        )
    )
    com = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body))
    weight = shoe.mass * case.gravity_vector()
    mbs.AddLoad(items.LoadForceVector(markerNumber=com, loadVector=weight.tolist()))
    pins = {}
    for joint, place in case.track.joint_centers.items():
        end, side = joint.split()
        pins[end, side] = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=place.tolist()))
    x, y, z = shoe.load_point
    top, right, left = (
        mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[x, y + beside, z]))
        for beside in (0.0, -REACH, REACH)
    )
    return ShoeBody(node, body, top, (right, left), REACH, pins, None)


def add_flexible(
    mbs: "exu.MainSystem", case: Case, number: int, node: int, floating: FloatingShoe
) -> ShoeBody:
    """One flexible shoe on its rigid-body node, with its own modal node."""
    count = floating.mode_count
    modal = mbs.AddNode(
        items.NodeGenericODE2(
            name=f"modes of shoe {number}",
            referenceCoordinates=[0.0] * count,
            initialCoordinates=[0.0] * count,
            initialCoordinates_t=[0.0] * count,
            numberOfODE2Coordinates=count,
        )
    )
    frequencies = floating.reduced.frequencies
    omega = 2.0 * np.pi * frequencies
    ratio = case.flexible_shoes().damping.value(frequencies)
    body = mbs.AddObject(
        items.ObjectFFRFreducedOrder(
            name=f"shoe {number}",
            nodeNumbers=[node, modal],
            massMatrixReduced=_diagonal(np.ones(count)),
            stiffnessMatrixReduced=_diagonal(omega**2),
            dampingMatrixReduced=_diagonal(2.0 * ratio * omega),
            modeBasis=floating.modes,
            referencePositions=floating.positions.ravel(),
            **floating.integrals,
        )
    )
    weight = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=body))
    mbs.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=case.gravity_vector().tolist()))
    pins = {}
    for joint in floating.joints:
        end, side = joint.split()
        pins[end, side] = mbs.AddMarker(
            items.MarkerSuperElementRigid(
                bodyNumber=body,
                meshNodeNumbers=floating.joint_nodes(joint),
                weightingFactors=[1.0 / NODES_A_JOINT] * NODES_A_JOINT,
            )
        )
    top, right, left = (
        mbs.AddMarker(
            items.MarkerSuperElementPosition(
                bodyNumber=body, meshNodeNumbers=[node_number], weightingFactors=[1.0]
            )
        )
        for node_number in (floating.top_node, *floating.side_nodes)
    )
    return ShoeBody(node, body, top, (right, left), floating.reach, pins, modal)


def _diagonal(values: NDArray) -> "exu.MatrixContainer":
    index = np.arange(len(values))
    matrix = exu.MatrixContainer()
    matrix.SetWithSparseMatrix(np.column_stack((index, index, values)), len(values), len(values))
    return matrix
