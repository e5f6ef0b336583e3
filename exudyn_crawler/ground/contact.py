"""Contact between shoes and ground: what every model of it does, and the choice of one for a case."""

from collections.abc import Sequence
from typing import Protocol

from numpy.typing import NDArray

from exudyn_crawler.case import Case
from exudyn_crawler.ground.coordinates import TerrainCoordinates
from exudyn_crawler.ground.pair_contact import PairGroundContact
from exudyn_crawler.ground.sphere_contact import SphereField, SphereGroundContact, sphere_field
from exudyn_crawler.ground.triplets import Weights
from fem.patches import Underside


class GroundContact(Protocol):
    """Forces between all shoes and units as functions of the generalized coordinates.

    The coordinates q, with rates q_t: six a shoe (COM displacement from `shoe_reference` and the angles
    about x, y, z), the terrain's as `coordinates` has them, the flexible shoes' modes.

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
    def spheres(self) -> SphereField | None:
        """Spheres of which the engine's own contact makes the forces in motion; None where these are it."""
        ...

    def forces(self, q: NDArray, q_t: NDArray) -> NDArray:
        """Generalized contact forces: array (size,)."""
        ...

    def derivatives(self, q: NDArray, q_t: NDArray, weights: Weights) -> NDArray:
        """Triplets (row, column, value) of the weighted sum of both derivatives of the forces.

        ``weights.position * d(forces)/dq + weights.velocity * d(forces)/dq_t``, array (entries, 3); with
        ``weights.secant`` the ratio of friction to slip is kept as it is instead of derived.
        """
        ...

    def results(self, q: NDArray, q_t: NDArray, shoe_forces: NDArray | None = None) -> NDArray:
        """Contacts at a state: array (contacts, RESULTS), columns as in `pairs.RESULT`.

        `shoe_forces` (6 shoes,) are the generalized contact forces on the shoes where the engine made them.
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

    def sunken(self, q: NDArray) -> list[int]:
        """Numbers of the shoes that have sunk through the ground, where nothing holds them up."""
        ...


def ground_contact(
    case: Case,
    coordinates: TerrainCoordinates,
    underside: Underside | None = None,
    flexible_shoes: Sequence[int] = (),
) -> GroundContact:
    """Contact of a case by the model that it names.

    Parameters
    ----------
    coordinates : TerrainCoordinates
        Formulation of the terrain.
    underside, flexible_shoes :
        As for `PairGroundContact`.
    """
    if case.contact.model == "spheres":
        coms = case.track.com_positions(case.shoe.com_height)
        return SphereGroundContact(coms, case.terrain, coordinates, sphere_field(case))
    return pair_ground_contact(case, coordinates, underside, flexible_shoes)


def pair_ground_contact(
    case: Case,
    coordinates: TerrainCoordinates,
    underside: Underside | None = None,
    flexible_shoes: Sequence[int] = (),
) -> PairGroundContact:
    """Contact of a case by the pair law; parameters as for `ground_contact`."""
    coms = case.track.com_positions(case.shoe.com_height)
    return PairGroundContact(
        coms, case.shoe, case.terrain, case.pair_contact(), coordinates, underside, flexible_shoes
    )
