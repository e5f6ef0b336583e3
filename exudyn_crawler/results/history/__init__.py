"""History of a run: named variables, catalogue of quantities, files."""

from exudyn_crawler.results.history.history import History, as_history, phases
