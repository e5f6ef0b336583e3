"""The command `exudyn-crawler`: it writes, shows and runs cases and looks at runs."""

from exudyn_crawler.cli import looking, machines, measuring, window  # noqa: F401 - which add their commands
from exudyn_crawler.cli.application import call
from exudyn_crawler.cli.commands import app

__all__ = ["app", "call"]
