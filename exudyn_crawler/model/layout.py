"""Layout of the states of a case, from its tables."""

from exudyn_crawler.case import Case
from exudyn_crawler.ground import pairs
from exudyn_crawler.model import state
from exudyn_crawler.model.joints.pin import ROWS
from exudyn_crawler.model.tables import Tables


def layout_of(case: Case, tables: Tables, pins: list[tuple[int, str]]) -> state.StateLayout:
    """Layout of the states of a case; `pins` name link (from 1) and side of each."""
    turned = case.gear.tumblers + case.gear.sliding_idlers
    others = case.gear.bodies
    names = [*(f"shoe {number}" for number in case.track.shoes), *others]

    def pin(link: int, side: str) -> str:
        return state.pin_name(side, link) if link > 0 else state.BEARING.format(turned[-link - 1])

    contact = pairs.RESULTS if len(tables.forces.cells.flexible) > 0 else 0
    if case.flexible:
        contact += tables.forces.cells.nodes.size
    return state.StateLayout(
        shoes=case.track.shoe_count,
        terrain=tables.terrain.heave.shape[1],
        flexible_shoes=() if case.flexible is None else tuple(case.flexible.shoes),
        modes=len(tables.modes.stiffness),
        contact=contact,
        multipliers=(
            *((pin(link, side), ROWS) for link, side in pins),
            ("drive", 1),
            ("turn", 1),
            *(
                (f"hold of {names[body]} ({state.BODY_COORDINATES[coordinate]})", 1)
                for body, coordinate in tables.joints.holds.coordinates.tolist()
            ),
            *((state.MOTOR.format(name), 1) for name in turned),
        ),
        bodies=others,
    )
