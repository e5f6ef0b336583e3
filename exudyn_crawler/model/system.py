"""Multibody system of a case of Exudyn's own bodies, joints and contacts: the reference formulation.

Its coordinates are those of `state.StateLayout`. It carries every case;
`model.compiled_system` carries most of them in less time.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.ground.contact import GroundContact, ground_contact
from exudyn_crawler.model.contact import add_contact, add_general_contact
from exudyn_crawler.model.drive import add_drives, add_holds
from exudyn_crawler.model.drive_point import DrivePoint, drive_point
from exudyn_crawler.model.engine import exu, items
from exudyn_crawler.model.failure import engine_failure
from exudyn_crawler.model.flexible_shoes import FloatingShoe, floating_shoe
from exudyn_crawler.model.integrated import Integrated
from exudyn_crawler.model.items import coordinate_marker
from exudyn_crawler.model.links import add_links
from exudyn_crawler.model.loads import add_grip, add_loads
from exudyn_crawler.model.shoes import add_shoe_bodies, add_shoe_nodes
from exudyn_crawler.model.state import RATES, StateLayout
from exudyn_crawler.model.terrain import add_terrain


@dataclass
class System(Integrated):
    """Multibody system of a case, assembled, with what is needed to read it.

    Attributes
    ----------
    mbs : exudyn.MainSystem
        The assembled system.
    contact : GroundContact
        Contact forces as functions of the system's coordinates.
    general : exudyn.GeneralContact, optional
        The engine's own contact, where it makes the forces.
    floating : FloatingShoe, optional
        What the flexible shoes share.
    point : DrivePoint
        Point of the front shoe that the drive moves.
    layout : StateLayout
        What the numbers of a state are.
    drives : tuple of int
        Items that move the front shoe: drive and, where there is one, turn.
    """

    container: "exu.SystemContainer"
    mbs: "exu.MainSystem"
    case: Case
    contact: GroundContact
    general: "exu.GeneralContact | None"
    floating: FloatingShoe | None
    point: DrivePoint
    layout: StateLayout
    drives: tuple[int, ...]

    treads = None

    def sunken(self) -> list[int]:
        """Numbers of the shoes that have sunk through the ground in the current state."""
        if self.contact.spheres is None:
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
        q, q_t, q_tt = (self.layout.part(row, f"coordinates{rate}") for rate in RATES)
        data = self.mbs.systemData
        data.SetODE2Coordinates(q.tolist(), exu.ConfigurationType.Initial)
        data.SetODE2Coordinates_t(q_t.tolist(), exu.ConfigurationType.Initial)
        data.SetODE2Coordinates_tt(q_tt.tolist(), exu.ConfigurationType.Initial)
        self._find_contacts(q)

    def solve(self, settings: "exu.SimulationSettings") -> None:
        """Integrate between the times of the settings; errors as of `formulation.TrackSystem.solve`."""
        try:
            self.mbs.SolveDynamic(settings)
        except exu.SolverError as error:
            raise engine_failure(self.mbs.sys["dynamicSolver"], self.layout) from error

    def rest(self, settings: "exu.SimulationSettings") -> NDArray:
        """Coordinates at rest of a system built for statics, from its initial ones.

        Raises
        ------
        NewtonError
            If Newton's method finds none.
        """
        try:
            self.mbs.SolveStatic(settings)
        except exu.SolverError as error:
            raise engine_failure(self.mbs.sys["staticSolver"], self.layout) from error
        return np.asarray(self.mbs.systemData.GetODE2Coordinates())

    def switch_drive(self, on: bool) -> None:
        """Move the front shoe from now on, or leave it free."""
        for item in self.drives:
            self.mbs.SetObjectParameter(item, "activeConnector", on)

    def state(self) -> NDArray:
        """Current state in one row, laid out as `layout` says."""
        data = self.mbs.systemData
        rates = (data.GetODE2Coordinates(), data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt())
        parts: dict[str, ArrayLike] = {
            f"coordinates{rate}": values for rate, values in zip(RATES, rates, strict=True)
        }
        parts |= {"time": data.GetTime(), "multipliers": data.GetAECoordinates()}
        if self.general is not None:
            forces = self.general.GetSystemODE2RhsContactForces(copy=True)
            parts["contact forces"] = np.reshape(forces[: self.contact.shoe_reference.size], (-1, 6))
        return self.layout.pack(parts)


def build(case: Case, static: bool = False) -> System:
    """Build and assemble the system of a case.

    Parameters
    ----------
    static : bool
        Hold the front shoe in x, y and about z instead of driving it. Nothing else fixes the track in
        the plane, since friction needs slip.

    Raises
    ------
    ValueError
        If the case has a side frame, which the compiled equations alone carry.
    """
    if case.undercarriage is not None:
        raise ValueError("undercarriage must be None for a system of Exudyn's items")
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    ground = mbs.AddObject(items.ObjectGround())
    floating = None
    if case.flexible is not None:
        floating = floating_shoe(case)
    shoe_nodes = add_shoe_nodes(mbs, case)
    terrain_nodes, coordinates = add_terrain(mbs, case, ground)
    shoes = add_shoe_bodies(mbs, case, shoe_nodes, floating)
    add_loads(mbs, case, shoes, static)
    add_links(mbs, shoes)
    contact = ground_contact(
        case,
        coordinates,
        None if floating is None else floating.underside,
        [index for index, shoe in enumerate(shoes) if shoe.is_flexible],
    )
    general = None
    if contact.spheres is not None and not static:
        general = add_general_contact(mbs, case.terrain, contact.spheres, shoes, terrain_nodes)
    modal_nodes = [shoe.modal_node for shoe in shoes if shoe.modal_node is not None]
    add_contact(mbs, contact, shoe_nodes + terrain_nodes + modal_nodes, forces=general is None)

    fixed = mbs.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0)
    )
    point = drive_point(case, floating.reduced if floating is not None and shoes[-1].is_flexible else None)
    if static:
        drives = add_holds(mbs, fixed, shoes[-1], point)
        if case.terrain.down[2] > -1.0:
            mass = case.shoe.mass if floating is None else floating.mass
            add_grip(mbs, case, shoes, mass)
        if case.terrain.heights is not None:
            _add_dashpots(mbs, case, fixed, shoe_nodes)
    else:
        drives = add_drives(mbs, case.drive, fixed, shoes[-1], point)
    mbs.Assemble()
    return System(
        container=container,
        mbs=mbs,
        case=case,
        contact=contact,
        general=general,
        floating=floating,
        point=point,
        layout=_layout(mbs, case, contact, floating, general is not None),
        drives=drives,
    )


def _layout(
    mbs: "exu.MainSystem",
    case: Case,
    contact: GroundContact,
    floating: FloatingShoe | None,
    contact_forces: bool,
) -> StateLayout:
    """Layout of the states of an assembled system."""
    held = [
        (rows[0], mbs.GetObject(number)["name"], len(rows))
        for number in range(mbs.systemData.NumberOfObjects())
        if (rows := mbs.systemData.GetObjectLTGAE(number))
    ]
    return StateLayout(
        shoes=case.track.shoe_count,
        terrain=contact.coordinates.size,
        terrain_bodies=contact.coordinates.shapes is None,
        flexible_shoes=() if case.flexible is None else tuple(case.flexible.shoes),
        modes=0 if floating is None else floating.mode_count,
        multipliers=tuple((name, size) for _, name, size in sorted(held)),
        contact_forces=contact_forces,
    )


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
