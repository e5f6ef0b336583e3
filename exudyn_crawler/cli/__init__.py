"""Command line `exudyn-crawler`: commands that write, show and run cases and evaluate runs."""

from exudyn_crawler.cli import looking, machines, measuring, window  # noqa: F401 - which add their commands
from exudyn_crawler.cli.application import call
from exudyn_crawler.cli.commands import app

__all__ = ["app", "call"]
