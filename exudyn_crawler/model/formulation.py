"""The multibody system of a case, in the formulation that the case asks for."""

from collections.abc import Callable
from typing import Protocol

from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.ground.contact import GroundContact
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.drive_point import DrivePoint
from exudyn_crawler.model.engine import exu
from exudyn_crawler.model.equations import residual
from exudyn_crawler.model.exudyn.system import ExudynSystem
from exudyn_crawler.model.state import StateLayout

EQUATIONS = (residual,)
"""Compiled functions of which every run needs one; each is made of many others."""


class TrackSystem(Protocol):
    """What a run asks of a multibody system, of Exudyn's items or of compiled equations."""

    @property
    def case(self) -> Case:
        """What it was built of."""
        ...

    @property
    def contact(self) -> GroundContact:
        """Contact forces as functions of its coordinates."""
        ...

    @property
    def point(self) -> DrivePoint:
        """Point of the front shoe that the drive moves."""
        ...

    @property
    def layout(self) -> StateLayout:
        """What the numbers of a state are."""
        ...

    @property
    def frequencies(self) -> NDArray | None:
        """Of the flexible shoes' modes, Hz: array (modes,); None without flexible shoes."""
        ...

    @property
    def treads(self) -> Callable[[float, NDArray, NDArray], tuple[NDArray, NDArray, NDArray]] | None:
        """Reads the treads of a side frame at a time (s), coordinates and rates; None without a frame.

        Gives forces on the shoes and their places, both (rollers, strips of both rails, 2, 3), global, N and
        m, on the shoe behind every roller's axis and on the next, and the former's index (rollers,).
        """
        ...

    def set_initial(self, q: NDArray) -> None:
        """Start from rest at the coordinates `q`."""
        ...

    def set_state(self, row: NDArray) -> None:
        """Start from a row as of `state`; its time goes into the solver's settings."""
        ...

    def state(self) -> NDArray:
        """Current state in one row, laid out as `layout` says."""
        ...

    def switch_drive(self, on: bool) -> None:
        """Move the front shoe from now on, or leave it free."""
        ...

    def sunken(self) -> list[int]:
        """Numbers of the shoes that have sunk through the ground in the current state."""
        ...

    def after_step(self, told: Callable[[float], bool]) -> None:
        """Call a function with the time after each step; the run ends where it gives False."""
        ...

    def solve(self, settings: "exu.SimulationSettings") -> None:
        """Integrate between the times of the settings.

        Raises
        ------
        NewtonError
            If Newton's method fails at the least step.
        """
        ...


def track_system(case: Case) -> TrackSystem:
    """Build the multibody system of a case."""
    return compiled_system(case) if case.is_compiled else ExudynSystem(case)
