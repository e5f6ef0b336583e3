"""What a run asks of a multibody system, of Exudyn's items or of compiled equations, and how it fails."""

from abc import ABC, abstractmethod
from collections.abc import Callable

from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.ground.contact import GroundContact
from exudyn_crawler.model.drive_point import DrivePoint
from exudyn_crawler.model.engine import exu
from exudyn_crawler.model.flexible_shoes import FloatingShoe
from exudyn_crawler.model.state import StateLayout


class NewtonError(Exception):
    """Newton's method failed at the least step, or found no equilibrium.

    Attributes
    ----------
    residual : array (equations,)
        Of the last iteration: forces (N), moments (N m) and modal forces, then the gaps of constraints.
    singular : bool
        Whether the equations had no solution.
    """

    def __init__(self, residual: NDArray, singular: bool) -> None:
        super().__init__("Newton's method failed")
        self.residual = residual
        self.singular = singular


class TrackSystem(ABC):
    """Multibody system that Exudyn steps through time.

    Attributes
    ----------
    case : Case
        What it was built of.
    contact : GroundContact
        Contact forces as functions of its coordinates.
    floating : FloatingShoe, optional
        What the flexible shoes share.
    point : DrivePoint
        Point of the front shoe that the drive moves.
    layout : StateLayout
        What the numbers of a state are.
    mbs : exudyn.MainSystem
        The assembled system.
    """

    case: Case
    contact: GroundContact
    floating: FloatingShoe | None
    point: DrivePoint
    layout: StateLayout
    mbs: "exu.MainSystem"

    @property
    def frequencies(self) -> NDArray | None:
        """Of the flexible shoes' modes, Hz: array (modes,); None without flexible shoes."""
        return None if self.floating is None else self.floating.reduced.frequencies

    @property
    def treads(self) -> Callable[[float, NDArray, NDArray], tuple[NDArray, NDArray, NDArray]] | None:
        """Reads the treads of rollers at a time (s), coordinates and rates; None without rollers.

        Gives forces on the shoes and their places, both (rollers, strips of both rails, 2, 3), global, N and
        m, on the shoe behind every roller's axis and on the next, and the former's index (rollers,).
        """
        return None

    def sunken(self) -> list[int]:
        """Numbers of the shoes that have sunk through the ground in the current state."""
        return []

    def after_step(self, report: Callable[[float], bool]) -> None:
        """Call a function with the time after each step; the run ends where it gives False."""
        self.mbs.SetPostStepUserFunction(lambda _mbs, time: report(time))

    @abstractmethod
    def set_initial(self, q: NDArray) -> None:
        """Start from rest at the coordinates `q`."""

    @abstractmethod
    def set_state(self, row: NDArray) -> None:
        """Start from a row as of `state`; its time goes into the solver's settings."""

    @abstractmethod
    def state(self) -> NDArray:
        """Current state in one row, laid out as `layout` says."""

    @abstractmethod
    def switch_drive(self, on: bool) -> None:
        """Move the front shoe from now on, or leave it free."""

    @abstractmethod
    def solve(self, settings: "exu.SimulationSettings") -> None:
        """Integrate between the times of the settings.

        Raises
        ------
        NewtonError
            If Newton's method fails at the least step.
        """
