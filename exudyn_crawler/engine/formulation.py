"""Multibody system of a case, in the case's formulation."""

from exudyn_crawler.case import Case
from exudyn_crawler.engine.system import ExudynSystem
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.track_system import TrackSystem


def track_system(case: Case) -> TrackSystem:
    """Build the multibody system of a case."""
    return compiled_system(case) if case.is_compiled else ExudynSystem(case)
