"""Named cases by their sections: those of the papers, and machines on an open track or on closed ones.

`Case` has a constructor of each name, as in ``Case.translation()``.
"""

from typing import Any, Literal

from exudyn_crawler.case import ph4100c
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.gear.machine import Machine
from exudyn_crawler.case.gear.rolled import Rolled, ground_below
from exudyn_crawler.case.parameters.contact import PairContact
from exudyn_crawler.case.parameters.drive import Drive, Solver
from exudyn_crawler.case.parameters.loads import LoadCycle
from exudyn_crawler.case.parameters.terrain import Terrain
from exudyn_crawler.case.parameters.track import FlexibleShoes, Rails, Shoe, Track

Sections = dict[str, Any]
Underside = Literal["even", "uneven"]
Seams = Literal["margin", "fitted"]


def translation(shoe: Underside = "even") -> Sections:
    """Return the straight propel of a dragged track, see `Case.translation`."""
    return {
        "name": "translation" if shoe == "even" else "uneven translation",
        "shoe": Shoe.kinematics() if shoe == "even" else Shoe.uneven(),
        "track": Track.ph4100c(),
        "terrain": Terrain.kinematics(),
        "contact": PairContact.adams(),
        "drive": Drive.translation(),
        "loads": LoadCycle.propel(),
    }


def turning(shoe: Underside = "even") -> Sections:
    """Return the turning propel of a dragged track, see `Case.turning`."""
    name = "turning" if shoe == "even" else "uneven turning"
    return translation(shoe) | {"name": name, "drive": Drive.turning()}


def stress(mesh: str = "study", seams: Seams = "margin") -> Sections:
    """Return propel and loading cycle with flexible shoes, see `Case.stress`."""
    return {
        "name": "stress",
        "shoe": Shoe.ph4100c().of_mass(ph4100c.STRESS_SHOE_MASS),
        "track": Track.ph4100c(),
        "terrain": Terrain.stress(seams),
        "contact": PairContact.oil_sand(),
        "drive": Drive.to_rest(),
        "loads": LoadCycle.shovel_cycle(),
        "flexible": FlexibleShoes.ph4100c(mesh),
    }


def rolled(shoe_count: int = 24) -> Sections:
    """Return the straight propel of a side frame over shoes before it, see `Case.rolled`."""
    track = Track.ph4100c().with_(shoe_count=shoe_count)
    return {
        "name": "rolled",
        "shoe": Shoe.ph4100c().with_(rails=Rails.ph4100c()),
        "track": track,
        "terrain": ground_below(track, Terrain.stress()),
        # shoes that tilt under the rollers stand on several units
        "contact": PairContact.oil_sand(sharing="area"),
        "drive": Drive.translation(),
        "loads": LoadCycle.constant([0.0] * shoe_count),
        "gear": Rolled.ph4100c(),
        # the shoes stand still: steps of 2 ms give the same pull within 0.5 %
        "solver": Solver(step=5e-3, output_interval=5e-3),
    }


def closed(shoe_count: int = ph4100c.CLOSED_SHOES) -> Sections:
    """Return the straight propel of half a machine on a closed track, see `Case.closed`."""
    return translation() | {
        "name": "closed",
        "shoe": Shoe.ph4100c().with_(rails=Rails.ph4100c()),
        "track": Track.ph4100c().with_(shoe_count=shoe_count),
        "loads": LoadCycle.constant([0.0] * shoe_count),
        "gear": Closed.ph4100c(),
    }


def shovel(shoe_count: int = ph4100c.CLOSED_SHOES) -> Sections:
    """Return the straight propel of the machine on two closed tracks, see `Case.shovel`."""
    return closed(shoe_count) | {
        "name": "shovel",
        "track": Track.ph4100c().with_(shoe_count=2 * shoe_count),
        "loads": LoadCycle.constant([0.0] * (2 * shoe_count)),
        "gear": Machine.ph4100c(),
    }
