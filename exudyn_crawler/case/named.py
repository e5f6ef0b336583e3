"""Named cases: those of the papers, and machines that roll on an open track or stand on closed ones.

A case file may name a case without required arguments as its `base`. `Case` inherits all constructors, as in
``Case.translation()``.
"""

from typing import Any, Literal, Self

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.gear.machine import Machine
from exudyn_crawler.case.gear.rolled import Rolled, ground_below
from exudyn_crawler.case.parameters.contact import PairContact
from exudyn_crawler.case.parameters.drive import Drive, Solver
from exudyn_crawler.case.parameters.heights import Heights
from exudyn_crawler.case.parameters.loads import LoadCycle
from exudyn_crawler.case.parameters.terrain import CellContact, CellTerrain, SoilLaw, Terrain
from exudyn_crawler.case.parameters.track import FlexibleShoes, Rails, Shoe, Track
from exudyn_crawler.case.sections import Sections


class NamedCases(Sections):
    """Constructors of named cases."""

    @classmethod
    def translation(cls, shoe: Literal["even", "uneven"] = "even") -> Self:
        """Return the straight propel of K-chapter, K-paper, F-paper; `Shoe.uneven` is fitted to the turn."""
        return cls(
            name="translation" if shoe == "even" else "uneven translation",
            shoe=Shoe.kinematics() if shoe == "even" else Shoe.uneven(),
            track=Track.ph4100c(),
            terrain=Terrain.kinematics(),
            contact=PairContact.adams(),
            drive=Drive.translation(),
            loads=LoadCycle.propel(),
        )

    @classmethod
    def turning(cls, shoe: Literal["even", "uneven"] = "even") -> Self:
        """Return the turning propel of K-chapter, K-paper and F-paper; for `shoe` see `translation`."""
        name = "turning" if shoe == "even" else "uneven turning"
        return cls.translation(shoe).with_(name=name, drive=Drive.turning())

    @classmethod
    def stress(cls, mesh: str = "study", seams: Literal["margin", "fitted"] = "margin") -> Self:
        """Return propel and loading cycle of the S-paper, with six flexible shoes.

        Each pair of shoe and unit has a whole contact law, as the paper states it. On 1 m units a shoe then
        stands on 4 to 8 of them. Its stiffness and its share of the load therefore change at seams; with
        ``PairContact.oil_sand(sharing="area")`` they do not. For `mesh` see `FlexibleShoes`, for `seams` see
        `Terrain.stress`.
        """
        return cls(
            name="stress",
            shoe=Shoe.ph4100c().of_mass(ph4100c.STRESS_SHOE_MASS),
            track=Track.ph4100c(),
            terrain=Terrain.stress(seams),
            contact=PairContact.oil_sand(),
            drive=Drive.to_rest(),
            loads=LoadCycle.shovel_cycle(),
            flexible=FlexibleShoes.ph4100c(mesh),
        )

    @classmethod
    def rolled(cls, shoe_count: int = 24) -> Self:
        """Return the straight propel of a side frame over rigid shoes before it; 24 allow 5 m of travel."""
        track = Track.ph4100c().with_(shoe_count=shoe_count)
        return cls(
            name="rolled",
            shoe=Shoe.ph4100c().with_(rails=Rails.ph4100c()),
            track=track,
            terrain=ground_below(track, Terrain.stress()),
            # shoes that tilt under the rollers stand on several units
            contact=PairContact.oil_sand(sharing="area"),
            drive=Drive.translation(),
            loads=LoadCycle.constant([0.0] * shoe_count),
            gear=Rolled.ph4100c(),
            # the shoes stand still: steps of 2 ms give the same pull within 0.5 %
            solver=Solver(step=5e-3, output_interval=5e-3),
        )

    @classmethod
    def closed(cls, shoe_count: int = ph4100c.CLOSED_SHOES) -> Self:
        """Return the straight propel of half a machine on a closed track of rigid shoes.

        The chain has `drive.speed`.
        """
        return cls.translation().with_(
            name="closed",
            shoe=Shoe.ph4100c().with_(rails=Rails.ph4100c()),
            track=Track.ph4100c().with_(shoe_count=shoe_count),
            loads=LoadCycle.constant([0.0] * shoe_count),
            gear=Closed.ph4100c(),
        )

    @classmethod
    def shovel(cls, shoe_count: int = ph4100c.CLOSED_SHOES) -> Self:
        """Return the straight propel of the machine on two closed tracks of `shoe_count` rigid shoes each."""
        half = cls.closed(shoe_count)
        return half.with_(
            name="shovel",
            track=half.track.with_(shoe_count=2 * shoe_count),
            loads=LoadCycle.constant([0.0] * (2 * shoe_count)),
            gear=Machine.ph4100c(),
        )

    def on_cells(self, law: SoilLaw, heights: Heights | None = None, cell: float = 0.1) -> Self:
        """Return the case on cells of a size (m), flat or with heights; extent and slopes stay the same."""
        (x0, x1), (y0, y1) = self.terrain.bounds
        same: dict[str, Any] = {"grade": self.terrain.grade, "side_slope": self.terrain.side_slope}
        same |= {"origin": (x0, y0), "length": x1 - x0, "width": y1 - y0}
        terrain = CellTerrain(**same, cell=cell, relief=heights or Heights())
        return self.with_(terrain=terrain, contact=CellContact(law=law))
