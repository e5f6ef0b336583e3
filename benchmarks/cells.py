"""Steps on ground of cells beside steps on the papers' ground, and the parts of a step that cells take."""

import time as clock
from collections.abc import Callable, Iterator

import numpy as np
import pandas as pd

from benchmarks.growth import longer, timed
from exudyn_crawler.case import statics
from exudyn_crawler.ground.cells.contact import CellGroundContact
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.cells.laws.rock import RockFloor
from exudyn_crawler.views.tables import print_table
from studies.ground import PAPERS, study_cases

SHOES = 16
CALLS = 300
DEEPER, SLIP = 1e-5, 2e-4
"""m, by which a step presses and drags the shoes on."""
GROUNDS = {"LETE sand": BekkerSoil.lete_sand(), "hard floor": RockFloor.hard_floor()}


def steps() -> Iterator[dict[str, object]]:
    """Milliseconds a step: dragged rigid shoes, and the machine that rolls over one flexible shoe."""
    dragged = longer(SHOES)
    grounds = {"papers' units": dragged} | {name: dragged.on_cells(law) for name, law in GROUNDS.items()}
    for name, case in grounds.items():
        yield {"what": f"{SHOES} rigid shoes, dragged", "ground": name} | timed(case, 1.0)[0]
    rolled = study_cases()
    for name in (PAPERS, "LETE sand", "oil sand, soft end", "hard floor"):
        yield {"what": "rolled, one of 38 shoes flexible", "ground": name} | timed(rolled[name].case, 1.0)[0]


def least(call: Callable[..., object], *values: object) -> float:
    """Milliseconds of the quickest of many calls with some values."""
    spent = []
    for _ in range(CALLS):
        begin = clock.perf_counter()
        call(*values)
        spent.append(clock.perf_counter() - begin)
    return 1e3 * min(spent)


def parts() -> Iterator[dict[str, object]]:
    """Milliseconds of what cells do in a step, under shoes that slide and press deeper than ever before."""
    for name, law in GROUNDS.items():
        case = longer(SHOES).on_cells(law)
        ground = CellGroundContact(case).ground
        depth = law.sinkage(statics.mean_load(case) / (case.shoe.length * case.shoe.width), case.shoe.length)
        before = np.zeros((SHOES, 18))
        before[:, :3], before[:, 3:12] = case.gear.shoe_reference(case)[:, :3], np.eye(3).ravel()
        before[:, 2] = case.shoe.com_height - depth
        frames = before.copy()
        frames[:, 0] += SLIP
        frames[:, 2] -= DEEPER
        for now in (before, frames):
            ground.cover(now, before)
            ground.press(now)
            if now is before:
                ground.commit()
        shoes = ground.shoes
        timings = {
            "residual": least(ground.press, frames),
            "with tangents": least(ground.press, frames, (1.0, 500.0)),
            "cover": least(ground.cover, frames, before),
            "commit": least(ground.commit),
        }
        for what, spent in timings.items():
            points = int(shoes.counts.sum())
            yield {"what": what, "ground": name, "points": points, "ms": spent}


def main() -> None:
    """Print both tables."""
    print_table(
        pd.DataFrame(parts()), f"What cells take of a step of {SHOES} shoes, the least of {CALLS} calls"
    )
    print_table(pd.DataFrame(steps()), "A step on cells beside one on the papers' ground")


if __name__ == "__main__":
    main()
