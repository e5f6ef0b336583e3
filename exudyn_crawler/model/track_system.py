"""Interface of a run to a multibody system of Exudyn's items or of compiled equations."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from exudyn_crawler.case import Case, Terrain, statics
from exudyn_crawler.case.gear.base import POSTS
from exudyn_crawler.model.assemble import Assembly
from exudyn_crawler.model.exudyn import exu
from exudyn_crawler.model.forces.cells import TrackOnCells
from exudyn_crawler.model.state import RATES, StateLayout

if TYPE_CHECKING:
    from exudyn_crawler.model.gear import GearForces

FIRST_DEPTH = 1e-5
"""Initial depth (m) of all rollers in their rails: enough for a contact force."""


class TrackSystem(ABC):
    """Multibody system of a case that Exudyn steps through time."""

    layout: StateLayout  # meaning of the numbers of a state

    def __init__(self, case: Case, assembly: Assembly) -> None:
        self.case = case
        self.contact = assembly.contact  # contact forces as functions of its coordinates
        self.floating = assembly.floating  # shared data of the flexible shoes
        self.mass = float(assembly.tables.bodies.mass.sum())  # of all bodies but the ground, kg
        self.point = assembly.point  # point of the front shoe that the drive moves
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.cells: TrackOnCells | None = None  # cells under the track, where the ground is of cells

    @property
    def frequencies(self) -> np.ndarray | None:
        """Frequencies (Hz) of the flexible shoes' modes: array (modes,); None without flexible shoes."""
        return None if self.floating is None else self.floating.reduced.frequencies

    def gear_forces(self, times: np.ndarray, q: np.ndarray, q_t: np.ndarray) -> "GearForces":
        """Return forces of a running gear on shoes at times (t,), s, coordinates and rates (t, coordinates).

        Forces are separate for all shoes of an open track, and for the flexible shoes of a closed one.
        """
        raise NotImplementedError("gear.kind must be 'rolled', 'closed' or 'machine' here")

    @property
    def sticks(self) -> bool:
        """True if the ground holds shoes at rest by its shear, without slip."""
        return self.cells is not None

    def first_guess(self) -> np.ndarray:
        """Return coordinates to start the search for rest: units sunk by their weight, shoes by their loads.

        On ground that sticks the shoes are put down there, and shear starts there. A closed track is put on
        the ground as it was assembled.
        """
        case = self.case
        sag = 0.0
        q = np.zeros(self.layout.coordinate_count)
        shoes = q[: 6 * case.track.shoe_count].reshape(-1, 6)
        if case.gear.holds == POSTS:
            return q
        if isinstance(case.terrain, Terrain):
            sag = -case.terrain.unit_mass * case.gravity_vector()[2] / case.terrain.heave_stiffness
            terrain = q[shoes.size : shoes.size + self.contact.coordinates.size]
            terrain[:] = self.contact.coordinates.sunk_evenly(-sag)
        # a view of the other bodies, whose coordinates come last
        others = q[len(q) - 6 * len(self.layout.bodies) :].reshape(-1, 6)
        if case.gear.loops:
            loaded = float(
                statics.settled_depths(case, statics.pressed(case, case.gear.first_loads(case))).max()
            )
            shoes[:, 2] = -sag - loaded
            others[:, 2] = -sag - loaded
            return q
        # rails of neighbours at one height: rollers may be on either
        loads = statics.pressed(case, case.loads.loads(0.0)[0])
        shoes[:, 2] = -sag - statics.settled_depths(case, loads)
        x = self.contact.shoe_reference[:, 0]
        half = 0.5 * case.shoe.length
        rear = self.contact.surface(x - half)
        front = self.contact.surface(x + half)
        shoes[:, 2] += 0.5 * (rear + front)
        shoes[:, 4] = -np.arctan((front - rear) / case.shoe.length)
        others[:, 2] = shoes[0, 2] - FIRST_DEPTH
        return q

    def after_step(self, report: Callable[[float], bool] | None) -> None:
        """Call a function with the time after each step; the run ends if it returns False.

        None releases the last function: the engine does not free the objects of its functions before.
        """
        # Exudyn's stub does not know that zero is none
        function: Any = 0 if report is None else lambda _mbs, time: report(time)
        self.mbs.SetPostStepUserFunction(function)

    def memory(self) -> dict[str, np.ndarray]:
        """Return the ground's memory after the last step, as arrays by name; empty if it has none."""
        return {} if self.cells is None else self.cells.ground.state()

    def remember(self, memory: Mapping[str, np.ndarray]) -> None:
        """Set the memory of cells, see `memory`; other ground has none."""
        if self.cells is not None:
            self.cells.ground.restore(memory)

    @abstractmethod
    def set_initial(self, q: np.ndarray, q_t: np.ndarray | None = None) -> None:
        """Start from coordinates, and from rest or from rates."""

    def set_state(self, row: np.ndarray, memory: Mapping[str, np.ndarray] | None = None) -> None:
        """Start from a row, see `state`, and a memory; the row's time goes into the solver's settings.

        Without a memory the ground keeps its present one.
        """
        if memory is not None:
            self.remember(memory)
        state = np.stack([self.layout.part(row, f"coordinates{rate}") for rate in RATES])
        self._start(state, self.layout.part(row, "multipliers"))

    @abstractmethod
    def _start(self, state: np.ndarray, multipliers: np.ndarray) -> None:
        """Start from coordinates, rates and accelerations (3, coordinates); slip counts from there."""

    def state(self) -> np.ndarray:
        """Return the current state in one row, in the order of `layout`."""
        time = self.mbs.systemData.GetTime()
        contacts = self.stored_contacts()
        return np.concatenate(((time,), *self.coordinates(), self.multipliers, contacts.ravel()))

    @abstractmethod
    def coordinates(self) -> Sequence[np.ndarray]:
        """Return the current coordinates, rates and accelerations, in the layout's order."""

    @property
    @abstractmethod
    def multipliers(self) -> np.ndarray:
        """Multipliers of all constraints, in the layout's order: N and N m."""

    def stored_contacts(self) -> np.ndarray:
        """Return values of contacts (shoes, layout.contact) that do not follow from the rest of a state."""
        if self.cells is None:
            return np.zeros((self.layout.shoes, 0))
        return self.cells.contacts(self.layout.contact)

    @abstractmethod
    def switch_drive(self, on: bool) -> None:
        """Drive the front shoe from now on, or leave it free."""

    @abstractmethod
    def solve(
        self, settings: "exu.SimulationSettings", next_end: Callable[[float], float] | None = None
    ) -> None:
        """Integrate between the times of the settings; raise `NewtonError` if a step fails at its least size.

        `next_end` gives, for a time (s), the next time (s) at which a step has to end; None leaves it to
        Exudyn.
        """
