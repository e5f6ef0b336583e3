"""Shoes with the pins of their chain: rigid shoes, and flexible shoes in floating frames."""

import math

import numpy as np

from exudyn_crawler.case import Case, CellTerrain
from exudyn_crawler.case.parameters.track import MIDWAY, SIDES, FlexibleShoes
from exudyn_crawler.ground.cells.ground import COARSE
from exudyn_crawler.model import shoe_mesh
from exudyn_crawler.model.assembler import DRIVE, TURN, Assembler, Body
from exudyn_crawler.model.bodies import Modes
from exudyn_crawler.model.flexible_shoes import FloatingShoe, shoe_model
from exudyn_crawler.model.forces.cells import CellTable
from exudyn_crawler.model.state import pin_name
from fem.body.rectangle_motion import hat_grid

ACROSS_CHAIN = np.array([0.0, 1.0, 0.0, 1.0, 1.0])
"""Mask of the equations of a pin that are redundant in a closed chain."""


def add(assembler: Assembler) -> None:
    """Add shoes, their pins, loads and undersides, and the drive of the front one."""
    case = assembler.case
    if assembler.floating is not None:
        assembler.modes = _modes(case, assembler.floating)
    for body in _bodies(assembler):
        assembler.add_body(body)
    _add_pins(assembler)
    for shoe in range(assembler.shoes):
        _add_load(assembler, shoe)
    last = assembler.shoes - 1
    point = assembler.point
    marker = assembler.add_marker(last, point.place, point.rows if point.rows.size else None)
    assembler.drive = marker, last
    moves, turns = case.gear.active(True, True)
    if moves:
        assembler.couple([last], [DRIVE])
    if turns:
        assembler.couple([last], [TURN])
    if isinstance(case.terrain, CellTerrain):
        assembler.cells = _undersides(assembler)


def _modes(case: Case, floating: FloatingShoe) -> Modes:
    """Return the modes of flexible shoes, with their integrals by the mass matrix of the finite elements."""
    body, _ = shoe_model(case.part(FlexibleShoes), case.track)
    # the mass of a node is the same along x, y and z
    mass = body.mass_matrix[0::3, 0::3]
    places = body.mesh.nodes
    shapes = floating.reduced.modes
    count = shapes.shape[2]
    heavy = np.stack([mass @ shapes[:, c] for c in range(3)], axis=1)
    products = np.einsum("naj,nck->jack", shapes, heavy, optimize=True)
    omega = 2.0 * np.pi * floating.reduced.frequencies
    ratio = case.part(FlexibleShoes).damping.value(floating.reduced.frequencies)
    return Modes(
        stiffness=omega**2,
        damping=2.0 * ratio * omega,
        shapes=np.ascontiguousarray(heavy.sum(axis=0)),
        places=np.einsum("na,nck->ack", places, heavy).reshape(9, count),
        products=products.reshape(count, 9 * count),
    )


def _bodies(assembler: Assembler) -> list[Body]:
    """Return the bodies of the shoes; flexible ones have the mass of their finite elements."""
    case = assembler.case
    shoe = case.shoe
    reference = case.gear.shoe_reference(case)
    names = [f"shoe {number}" for number in case.track.shoes]
    bodies = [
        Body.rigid(name, float(shoe.mass), shoe.inertia_tensor, row)
        for name, row in zip(names, reference, strict=True)
    ]
    if assembler.floating is None:
        return bodies
    body, _ = shoe_model(case.part(FlexibleShoes), case.track)
    places = body.mesh.nodes
    heavy_places = body.mass_matrix[0::3, 0::3] @ places
    first = heavy_places.sum(axis=0)
    second = places.T @ heavy_places
    for k in np.flatnonzero(assembler.flexible):
        bodies[k] = Body(names[k], body.mass, first, second, reference[k], bends=True)
    return bodies


def joint_marker(assembler: Assembler, shoe: int, name: str, place: np.ndarray | None = None) -> int:
    """Add a marker at a joint centre of a shoe, or at a location (3,), m, that moves with its bore."""
    case = assembler.case
    center = _joint_center(case, name) if place is None else place
    if assembler.floating is None or not assembler.flexible[shoe]:
        return assembler.add_marker(shoe, center)
    reduced = assembler.floating.reduced
    joint = [interface.name for interface in reduced.interfaces].index(name)
    moved = reduced.pilots[joint, :3]
    turned = reduced.pilots[joint, 3:]
    arm = center - case.track.joint_centers[name]
    bore = reduced.interfaces[joint].center
    return assembler.add_marker(shoe, bore + arm, moved + np.cross(turned.T, arm).T, turned)


def _joint_center(case: Case, name: str) -> np.ndarray:
    """Return the joint centre of a shoe, or the middle of two; the pins of a worn chain are farther apart."""
    end, side = name.split()
    centers = [case.track.joint_centers[f"{end} {pin}"] for pin in SIDES]
    center = np.mean(centers, axis=0) if side == MIDWAY else centers[SIDES.index(side)]
    worn = case.gear.shoe_pitch(case.track) - case.track.pitch if end == "rear" else 0.0
    return np.array(center) - np.array([worn, 0.0, 0.0])


def middle_marker(assembler: Assembler, shoe: int, end: str) -> int:
    """Add a marker in the middle of the rear or the front pins of a shoe."""
    floating = assembler.floating
    reduced = floating.reduced if floating is not None and assembler.flexible[shoe] else None
    return assembler.add_marker(shoe, *shoe_mesh.pin_middle(assembler.case.track, reduced, end))


def _add_pins(assembler: Assembler) -> None:
    """Add the pins of all links: one between rigid shoes, two if a shoe is flexible."""
    case = assembler.case
    compliance = case.gear.pin_compliance * ACROSS_CHAIN
    for rear, front in (case.gear.links(case.track) - 1).tolist():
        bends = assembler.flexible[rear] or assembler.flexible[front]
        for side in SIDES if bends else SIDES[:1]:
            where = side if bends else case.gear.rigid_joint
            behind = joint_marker(assembler, rear, f"front {where}")
            ahead = joint_marker(assembler, front, f"rear {where}")
            name = pin_name(side, rear + 1)
            if case.gear.pin_play is None:
                assembler.add_pin(behind, ahead, name, rear + 1, compliance)
            else:
                assembler.add_play(behind, ahead, name, rear + 1, _contact_arm(assembler, side, bends))


def _contact_arm(assembler: Assembler, side: str, bends: bool) -> float:
    """Return the distance (m) of both contacts of a link with play from its marker.

    Rigid shoes have one at each pin. A pin of flexible shoes has both in its own bore, where two springs
    resist rotation like an even bedding: half the length of the bore over the root of three.
    """
    if not bends or assembler.floating is None:
        track = assembler.case.track
        return 0.5 * abs(track.parallel_y - track.spherical_y)
    reduced = assembler.floating.reduced
    interface = next(one for one in reduced.interfaces if one.name == f"rear {side}")
    mesh = shoe_model(assembler.case.part(FlexibleShoes), assembler.case.track)[0].mesh
    return 0.5 * float(np.ptp(mesh.nodes[interface.nodes, 1])) / math.sqrt(3.0)


def _add_load(assembler: Assembler, shoe: int) -> None:
    """Add the machine's load on a shoe, with its marker a metre to the left."""
    floating = assembler.floating
    if floating is not None and assembler.flexible[shoe]:
        marker = assembler.add_marker(shoe, floating.load_point, floating.load_rows)
        beside = assembler.add_marker(shoe, floating.beside, floating.beside_rows)
    else:
        marker = assembler.add_marker(shoe, assembler.case.shoe.load_point)
        beside = assembler.add_marker(shoe, (0.0, 1.0, 0.0))
    assembler.add_load(marker, beside)


def _undersides(assembler: Assembler) -> CellTable:
    """Return the undersides on cells, with a grid of nodes under the flexible shoes."""
    flexible = assembler.flexible
    row = np.where(flexible, np.cumsum(flexible) - 1, -1)
    if assembler.floating is None:
        return CellTable(row, np.zeros((*COARSE, 3)), np.zeros((*COARSE, 3, 0)))
    nodes, rows = hat_grid(assembler.floating.underside, COARSE)
    height = np.full((*COARSE, 1), assembler.case.shoe.footprint[4])
    return CellTable(row, np.concatenate((nodes, height), axis=2), rows)
