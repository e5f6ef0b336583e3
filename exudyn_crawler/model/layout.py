"""Layout of a case's states, from the assembly of its machine."""

from exudyn_crawler.case import Case
from exudyn_crawler.ground import pairs
from exudyn_crawler.model import state
from exudyn_crawler.model.assemble import Assembly


def layout_of(case: Case, assembly: Assembly) -> state.StateLayout:
    """Return the layout of the states of a case."""
    tables = assembly.tables
    cells = tables.forces.cells
    contact = pairs.RESULTS if len(cells.flexible) > 0 else 0
    if case.flexible:
        contact += cells.nodes.size
    return state.StateLayout(
        shoes=case.track.shoe_count,
        terrain=tables.terrain.heave.shape[1],
        flexible_shoes=() if case.flexible is None else tuple(case.flexible.shoes),
        modes=len(tables.modes.stiffness),
        contact=contact,
        multipliers=assembly.rows,
        bodies=assembly.bodies,
    )
