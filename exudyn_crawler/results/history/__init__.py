"""History of a run: named variables, catalogue of quantities, files."""

from exudyn_crawler.results.history.history import History, RunPhase, as_history, common_phases, phases
