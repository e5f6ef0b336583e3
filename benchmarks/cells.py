"""Steps on ground of cells beside steps on the papers' ground."""

from collections.abc import Iterator

import pandas as pd

from benchmarks.growth import longer, timed
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.views.tables import print_table
from studies.ground import PAPERS, study_cases

SHOES = 16


def steps() -> Iterator[dict[str, object]]:
    """Milliseconds a step: dragged rigid shoes, and the machine that rolls over one flexible shoe."""
    dragged = longer(SHOES)
    grounds = {
        "papers' units": dragged,
        "LETE sand": dragged.on_cells(BekkerSoil.lete_sand()),
        "hard floor": dragged.on_cells(RockFloor.hard_floor()),
    }
    for name, case in grounds.items():
        yield {"what": f"{SHOES} rigid shoes, dragged", "ground": name} | timed(case, 1.0)[0]
    rolled = study_cases()
    for name in (PAPERS, "LETE sand", "oil sand, soft end", "hard floor"):
        yield {"what": "rolled, one of 38 shoes flexible", "ground": name} | timed(rolled[name].case, 1.0)[0]


def main() -> None:
    """Print the table."""
    print_table(pd.DataFrame(steps()), "A step on cells beside one on the papers' ground")


if __name__ == "__main__":
    main()
