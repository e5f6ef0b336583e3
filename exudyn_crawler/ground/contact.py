"""Contact between shoes and ground: what every model of it does, and the choice of one for a case."""

from collections.abc import Callable, Sequence
from typing import Protocol

from numpy.typing import NDArray

from exudyn_crawler.case import Case, CellTerrain
from exudyn_crawler.ground.cells.contact import CellGroundContact
from exudyn_crawler.ground.pair_contact import PairGroundContact
from exudyn_crawler.ground.sphere_contact import SphereGroundContact
from exudyn_crawler.ground.terrain import TerrainCoordinates, UnitCoordinates, terrain_coordinates
from fem.patches import Underside


class GroundContact(Protocol):
    """Contacts between all shoes and units, read off a state.

    The coordinates q, with rates q_t: six a shoe (COM displacement from `shoe_reference` and angles), the
    terrain's as `coordinates` has them, the flexible shoes' modes.

    Attributes
    ----------
    coordinates : TerrainCoordinates
        How the terrain's coordinates carry the units.
    shoe_reference : array (shoes, 6)
        COM positions (m, global) and angles where the shoes' coordinates are zero.
    unit_reference : array (units, 4)
        Centres (m, global) and tilt of the units with the springs free.
    """

    coordinates: TerrainCoordinates
    shoe_reference: NDArray
    unit_reference: NDArray

    @property
    def size(self) -> int:
        """Number of generalized coordinates."""
        ...

    @property
    def results(self) -> Callable[..., NDArray]:
        """Contacts (contacts, RESULTS), columns as in `pairs.RESULT`, at coordinates and their rates.

        A third argument is what a state has of them, of contact that does not follow from these.
        """
        ...

    def unit_motion(self, q: NDArray) -> NDArray:
        """Displacement (m) and tilt (rad) of the units from where their springs are free: (units, 4)."""
        ...

    def settled_depth(self, loads: NDArray) -> NDArray:
        """Penetration (m) of shoes that each stand on one unit under these loads (N)."""
        ...

    def ground_below(self, q: NDArray, heights: NDArray) -> NDArray:
        """Height (m) of the ground below each shoe, of the units' heights (units,): array (shoes,)."""
        ...

    def surface(self, x: NDArray) -> NDArray:
        """Height (m) of the ground along the track's middle at places x (m), before a track stands on it."""
        ...

    def sunken(self, q: NDArray) -> list[int]:
        """Numbers of the shoes that have sunk through the ground, where nothing holds them up."""
        ...


def ground_contact(
    case: Case, underside: Underside | None = None, flexible_shoes: Sequence[int] = ()
) -> GroundContact:
    """Contact of a case by the model that it names.

    Parameters
    ----------
    underside, flexible_shoes :
        As for `PairGroundContact`.
    """
    if isinstance(case.terrain, CellTerrain):
        return CellGroundContact(case)
    coordinates = terrain_coordinates(case)
    if isinstance(coordinates, UnitCoordinates) and case.contact.model == "spheres":
        return SphereGroundContact(case, coordinates)
    coms = case.track.com_positions(case.shoe.com_height)
    return PairGroundContact(
        coms, case.shoe, case.unit_terrain(), case.pair_contact(), coordinates, underside, flexible_shoes
    )
