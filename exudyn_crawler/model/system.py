"""Builds the multibody system of a case.

Coordinates: six a shoe (COM displacement from t = 0 and the angles about x, y, z), then the terrain's,
then the flexible shoes' modes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.ground.pair_contact import TrackContact
from exudyn_crawler.ground.sphere_contact import SphereContact
from exudyn_crawler.model.contact import add_contact, add_general_contact
from exudyn_crawler.model.drive import add_drive, add_point_drive, add_turn
from exudyn_crawler.model.drive_point import DrivePoint, drive_point
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.flexible_shoes import FloatingShoe, floating_shoe
from exudyn_crawler.model.items import coordinate_marker, hold
from exudyn_crawler.model.links import add_links
from exudyn_crawler.model.loads import add_loads
from exudyn_crawler.model.shoes import ShoeBody, add_shoe_bodies, add_shoe_nodes
from exudyn_crawler.model.terrain import add_terrain


@dataclass
class System:
    """Multibody system of a case, assembled, with what is needed to read it.

    Attributes
    ----------
    mbs : exudyn.MainSystem
        The assembled system.
    contact : TrackContact or SphereContact
        Contact forces as functions of the system's coordinates.
    general : exudyn.GeneralContact, optional
        The engine's own contact, where it makes the forces.
    floating : FloatingShoe, optional
        What the flexible shoes share.
    point : DrivePoint
        Point of the front shoe that the drive moves.
    link_rows, drive_row, turn_row :
        Indices of the Lagrange multipliers: six for each pin's joint of each link; of the drive; of the turn
        (None without one).
    """

    container: "exu.SystemContainer"
    mbs: "exu.MainSystem"
    case: Case
    contact: TrackContact | SphereContact
    general: "exu.GeneralContact | None"
    floating: FloatingShoe | None
    point: DrivePoint
    link_rows: list[list[list[int]]]
    drive: int
    drive_row: int
    turn: int | None
    turn_row: int | None

    def sunken(self) -> list[int]:
        """Numbers of the shoes with spheres below the ground in the current state; see `SphereContact`."""
        if self.general is None or not isinstance(self.contact, SphereContact):
            return []
        return self.contact.sunken(np.array(self.mbs.systemData.GetODE2Coordinates()))

    def set_initial(self, q: NDArray) -> None:
        """Start from rest at the coordinates `q`."""
        self.mbs.systemData.SetODE2Coordinates(q.tolist(), exu.ConfigurationType.Initial)
        self._find_contacts(q)

    def _find_contacts(self, q: NDArray) -> None:
        if self.general is not None:
            # the engine looked for touching spheres when it was assembled, with none in the ground yet, and
            # would let the track fall through the first step
            self.mbs.systemData.SetODE2Coordinates(q.tolist())
            self.general.UpdateContacts(self.mbs)

    def set_state(self, row: NDArray) -> None:
        """Start from a row as of `state`; its time goes into the solver's settings."""
        q, q_t, q_tt = np.split(row[1 : 1 + 3 * self.contact.size], 3)
        data = self.mbs.systemData
        data.SetODE2Coordinates(q.tolist(), exu.ConfigurationType.Initial)
        data.SetODE2Coordinates_t(q_t.tolist(), exu.ConfigurationType.Initial)
        data.SetODE2Coordinates_tt(q_tt.tolist(), exu.ConfigurationType.Initial)
        self._find_contacts(q)

    def switch_drive(self, on: bool) -> None:
        """Move the front shoe from now on, or leave it free."""
        for item in (self.drive, self.turn):
            if item is not None:
                self.mbs.SetObjectParameter(item, "activeConnector", on)

    def state(self) -> NDArray:
        """Time, coordinates, their first and second rates and the multipliers, in one row.

        After them, with contact model "general", the shoes' generalized contact forces.
        """
        data = self.mbs.systemData
        parts = [
            [data.GetTime()],
            data.GetODE2Coordinates(),
            data.GetODE2Coordinates_t(),
            data.GetODE2Coordinates_tt(),
            data.GetAECoordinates(),
        ]
        if self.general is not None:
            forces = self.general.GetSystemODE2RhsContactForces(copy=True)
            parts.append(forces[: self.contact.shoe_reference.size])
        return np.concatenate(parts)


def build(case: Case, static: bool = False) -> System:
    """Build and assemble the system of a case.

    Parameters
    ----------
    static : bool
        Hold the front shoe in x, y and about z instead of driving it. Nothing else fixes the track in
        the plane, since friction needs slip.
    """
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    ground = mbs.AddObject(items.ObjectGround())
    floating = None
    if case.flexible is not None:
        floating = floating_shoe(case)
    shoe_nodes = add_shoe_nodes(mbs, case)
    terrain_nodes, coordinates = add_terrain(mbs, case, ground)
    shoes = add_shoe_bodies(mbs, case, shoe_nodes, floating)
    add_loads(mbs, case, shoes)
    links = add_links(mbs, shoes)
    contact: TrackContact | SphereContact
    general = None
    if case.contact_model == "general":
        contact = SphereContact(case)
        if not static:
            general = add_general_contact(mbs, case, shoes, terrain_nodes)
    else:
        contact = TrackContact(
            case.track.com_positions(case.shoe.com_height),
            case.shoe,
            case.terrain,
            case.contact,
            coordinates,
            None if floating is None else floating.underside,
            [index for index, shoe in enumerate(shoes) if shoe.is_flexible],
        )
    modal_nodes = [shoe.modal_node for shoe in shoes if shoe.modal_node is not None]
    add_contact(mbs, contact, shoe_nodes + terrain_nodes + modal_nodes, forces=general is None)

    fixed = mbs.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0)
    )
    turn = None
    point = drive_point(case, floating.reduced if floating is not None and shoes[-1].is_flexible else None)
    if static:
        drive, _, _ = (hold(mbs, fixed, shoe_nodes[-1], axis) for axis in (0, 1, 5))
        if case.terrain.heights is not None:
            _add_dashpots(mbs, case, fixed, shoe_nodes)
    else:
        drive = _add_drive(mbs, case, fixed, shoes[-1], point)
        if case.drive.turn_rate is not None:
            turn = add_turn(mbs, case.drive, shoe_nodes[-1])
    mbs.Assemble()
    rows = mbs.systemData.GetObjectLTGAE
    return System(
        container=container,
        mbs=mbs,
        case=case,
        contact=contact,
        general=general,
        link_rows=[[rows(pin) for pin in link] for link in links],
        floating=floating,
        point=point,
        drive=drive,
        drive_row=rows(drive)[0],
        turn=turn,
        turn_row=None if turn is None else rows(turn)[0],
    )


def _add_drive(mbs: "exu.MainSystem", case: Case, fixed: int, shoe: ShoeBody, point: DrivePoint) -> int:
    """Drive of the front shoe, at its frame's own coordinate where that is what moves."""
    if not (point.place.any() or point.rows.any()):
        return add_drive(mbs, case.drive, fixed, shoe.node)
    return add_point_drive(mbs, case.drive, point, shoe.node, shoe.modal_node)


def _add_dashpots(mbs: "exu.MainSystem", case: Case, fixed: int, nodes: Sequence[int]) -> None:
    """Dashpots that damp the shoes on their contact critically; at rest they do nothing."""
    stiffness = case.mean_load / case.settled_penetration
    damping = 2.0 * np.sqrt(case.shoe.mass * stiffness)
    arms = 0.5 * np.array([case.shoe.width, case.shoe.length, case.shoe.width])
    for node in nodes:
        for coordinate in range(6):
            mbs.AddObject(
                items.ObjectConnectorCoordinateSpringDamper(
                    markerNumbers=[fixed, coordinate_marker(mbs, node, coordinate)],
                    damping=damping if coordinate < 3 else damping * arms[coordinate - 3] ** 2,
                )
            )
