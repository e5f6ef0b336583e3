"""Bogies: bodies that swing on pivots of the side frame, each with two of its rollers."""

from exudyn_crawler.case.gear.running_gear import RunningGear
from exudyn_crawler.model.assembler import Assembler
from exudyn_crawler.model.parts.frame import add_pivoted


def add(assembler: Assembler) -> None:
    """Add the bogies of each track, which carry their rollers instead of the frame."""
    case = assembler.case
    gear = case.part(RunningGear)
    reference = gear.bogie_reference(case)
    parts = [(bogie, bogie.rollers) for bogie in gear.bogies]
    add_pivoted(assembler, gear.bogie_names, reference, parts)
