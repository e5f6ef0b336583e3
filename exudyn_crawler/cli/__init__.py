"""The command `exudyn-crawler`: it writes, shows and runs cases and looks at runs; studies add to it."""

from exudyn_crawler.cli.application import call, run_script
from exudyn_crawler.cli.options import RESULTS, Debug, Out, Overwrite
from exudyn_crawler.cli.several import app

__all__ = ["RESULTS", "Debug", "Out", "Overwrite", "app", "main", "run_script"]


def main() -> None:
    """Entry point of `exudyn-crawler`."""
    call(app)
