"""``python -m studies NAME`` runs a study, as its script does, also one that registers no command."""

import typer

from exudyn_crawler.cli.application import call, readable
from studies import commands

STUDIES = (
    *(commands.kinematics, commands.forces, commands.stress, commands.uneven, commands.rollers),
    *(commands.closed, commands.grounds, commands.shovel_life, commands.plate_sweep),
    *(commands.sliding_modes, commands.verify),
)

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False)
for one in STUDIES:
    app.command()(readable(one))


if __name__ == "__main__":
    call(app)
