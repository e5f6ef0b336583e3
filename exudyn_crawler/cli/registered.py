"""Commands and cases that packages register, and how a command line is called.

A package, the studies first of all, registers them in the metadata that it is installed with::

    [project.entry-points."exudyn_crawler.commands"]
    stress = "studies.commands:stress"

    [project.entry-points."exudyn_crawler.cases"]
    stress = "studies.cases:stress"

A command is a function as Typer takes it; its options `debug`, `out` and `overwrite` are those of
`cli.options`. A case is a function without arguments that gives a `CaseFile`, to start from with ``init
--study NAME``. Neither is loaded before it is asked for, so that its module of commands should import what
is heavy in its functions.
"""

import signal
import sys
from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any

import typer
from typer.core import TyperGroup

from exudyn_crawler.cli.errors import BAD_INPUT, readable
from exudyn_crawler.cli.options import Debug
from exudyn_crawler.errors import ENDED_FROM_OUTSIDE, GOES_ON, INTERRUPTED

if TYPE_CHECKING:
    from exudyn_crawler.case import CaseFile

COMMANDS = "exudyn_crawler.commands"
CASES = "exudyn_crawler.cases"


def registered(group: str) -> dict[str, EntryPoint]:
    """What installed packages register in a group, by name."""
    return {found.name: found for found in entry_points(group=group)}


def study_case(name: str) -> "CaseFile":
    """Case that a study registers to start from.

    Raises
    ------
    ValueError
        If there is no such study.
    """
    cases = registered(CASES)
    if name not in cases:
        raise ValueError(f"study must be of {sorted(cases)}, got {name!r}")
    return cases[name].load()()


class Commands(TyperGroup):
    """Own commands and those that packages register, which are loaded when one of them is asked for."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of all commands, the own ones first."""
        own = super().list_commands(ctx)
        return [*own, *(name for name in registered(COMMANDS) if name not in own)]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Command of a name; None if there is none."""
        own = super().get_command(ctx, cmd_name)
        if own is not None:
            return own
        found = registered(COMMANDS).get(cmd_name)
        return None if found is None else _command(found)


def _command(found: EntryPoint) -> Any:
    """Registered command; one whose package is broken tells so when it is called, and spoils no other."""
    try:
        function = found.load()
        settings = None
    except Exception as error:
        function = _broken(error)
        settings = {"ignore_unknown_options": True, "allow_extra_args": True}
    single = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    single.command(found.name, rich_help_panel="Studies", context_settings=settings)(readable(function))
    return typer.main.get_command(single)


def _broken(error: Exception) -> Callable[..., None]:
    def broken(debug: Debug = False) -> None:
        """Cannot be loaded."""
        raise error

    return broken


def run_script(reference: str) -> None:
    """Run a command as a script of its own, with its arguments and exit codes.

    Parameters
    ----------
    reference : str
        Module and function as packages register them: ``studies.commands:stress``. Its module may import
        that of the script.
    """
    command = EntryPoint(reference, reference, COMMANDS).load()
    single = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    single.command()(readable(command))
    call(single)


def call(commands: typer.Typer) -> None:
    """Call a command line; what is wrong with its words is told in one line, as all errors are.

    A request to terminate ends a command as Ctrl-C does.
    """
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        code = commands(standalone_mode=False) or 0
        if code != ENDED_FROM_OUTSIDE:
            sys.exit(code)
        # which Typer makes of an interrupt while it reads the words
        raise KeyboardInterrupt
    except KeyboardInterrupt:
        print(f"error: {INTERRUPTED}; {GOES_ON}", file=sys.stderr)
        sys.exit(ENDED_FROM_OUTSIDE)
    except typer.Abort:
        sys.exit(BAD_INPUT)
    except Exception as error:
        # Typer's errors have no public class that all its versions share
        told = getattr(error, "format_message", None)
        if told is None:
            raise
        text = told()
        if text:
            print(f"error: {' '.join(text.split())}; --help shows what is allowed", file=sys.stderr)
        sys.exit(BAD_INPUT)
