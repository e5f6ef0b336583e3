"""The command `exudyn-crawler`: it writes, shows and runs cases and looks at runs; studies add to it."""

from exudyn_crawler.cli import looking  # noqa: F401 - which adds its commands
from exudyn_crawler.cli.application import RESULTS, Out, Overwrite, run_script
from exudyn_crawler.cli.commands import app, main

__all__ = ["RESULTS", "Out", "Overwrite", "app", "main", "run_script"]
