"""Pages and docstrings mention only modules, files, classes and members that there are."""

import importlib.util
import re

import pytest
import typer

from docs import mentions, rooms
from exudyn_crawler import cli


def test_every_name_that_pages_and_docstrings_mention_exists():
    assert sorted({where for where in mentions.mentions() if not mentions.is_known(where[1])}) == []


@pytest.mark.parametrize(
    "name",
    [
        "model/nowhere.py",
        "tests/run/test_nothing.py",
        "ground.nowhere",
        "fem.Nothing",
        "Case.nothing()",
        "Nothing.mass",
        "history.nothing",
        "solver.nothing_of_the_kind",
    ],
)
def test_names_that_lead_nowhere_are_found(name):
    assert not mentions.is_known(name)


@pytest.mark.parametrize(
    "name", ["model/state.py", "fem.read_mesh", "Case.shoe", "solver.step", "history.position", "results.csv"]
)
def test_names_of_the_code_are_known(name):
    assert mentions.is_known(name)


def test_commands_that_docstrings_mention_exist():
    commands = typer.main.get_command(cli.app)
    known = set(commands.list_commands(typer.Context(commands)))
    targets = set(re.findall(r"^([a-z-]+):", (rooms.ROOT / "Makefile").read_text(), re.MULTILINE))
    for where, name in mentions.mentions():
        if match := re.match(r"(exudyn-crawler|make|python -m) ([a-z][\w.-]*)", name):
            program, word = match.groups()
            if program == "python -m":
                assert importlib.util.find_spec(word) is not None, f"{where}: {name}"
            else:
                assert word in (known if program == "exudyn-crawler" else targets), f"{where}: {name}"
