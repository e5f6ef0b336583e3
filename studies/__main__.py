"""``python -m studies NAME`` runs a study, as its script does, also one that registers no command."""

import sys

import typer

from exudyn_crawler.cli.application import call, readable
from studies import commands

FUNCTIONS = (
    *(commands.kinematics, commands.forces, commands.stress, commands.uneven, commands.rollers),
    *(commands.closed, commands.grounds, commands.shovel_life, commands.plate_sweep),
    *(commands.sliding_modes, commands.verify),
)
STUDIES = {one.__name__.replace("_", "-"): one for one in FUNCTIONS}
"""By the names of their commands."""

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False)
for name, one in STUDIES.items():
    app.command(name)(readable(one))


def run(name: str) -> None:
    """Run the study of a name as a script, with the words of the command line."""
    sys.argv.insert(1, name)
    call(app)


if __name__ == "__main__":
    call(app)
