"""The handbook's notebooks: kept with what they show, small, and true when they are executed again."""

import ast
import re

import nbformat
import pytest

from docs.notebooks import NOTEBOOKS, executed
from tests.docs.test_examples import public_names_by_module

PATHS = sorted(NOTEBOOKS.glob("*.ipynb"))
NAMES = [path.stem for path in PATHS]
LARGEST = 150_000
"""Bytes of a notebook with its outputs."""
NUMBER = re.compile(r"[-+]?\d+\.?\d*(e[-+]?\d+)?")


def code_of(path):
    return [cell for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code"]


def words_shown(cell):
    """What a cell prints and returns, without its numbers: a bouncing track's differ between machines."""
    texts = [output.get("text") or output.get("data", {}).get("text/plain", "") for output in cell.outputs]
    return [words for text in texts if (words := NUMBER.sub("#", text).split())]


def test_there_are_notebooks():
    assert {"duty_cycle", "stresses", "own_model"} <= set(NAMES)


@pytest.mark.parametrize("path", PATHS, ids=NAMES)
def test_a_notebook_is_kept_executed_and_small(path):
    nbformat.validate(nbformat.read(path, as_version=4))
    assert path.stat().st_size < LARGEST
    cells = code_of(path)
    assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
    assert not [output for cell in cells for output in cell.outputs if output.output_type == "error"]
    assert any("image/png" in output.get("data", {}) for cell in cells for output in cell.outputs)


@pytest.mark.parametrize("path", PATHS, ids=NAMES)
def test_a_notebook_takes_public_names_from_the_package_and_its_links_lead_somewhere(path):
    source = "\n".join(re.sub(r"(?m)^%.*$", "", cell.source) for cell in code_of(path))
    assert not public_names_by_module(list(ast.walk(ast.parse(source))))
    cells = nbformat.read(path, as_version=4).cells
    text = "\n".join(cell.source for cell in cells if cell.cell_type == "markdown")
    assert [link for link in re.findall(r"\]\(([^)]+)\)", text) if not (path.parent / link).exists()] == []


@pytest.mark.slow
@pytest.mark.parametrize("path", PATHS, ids=NAMES)
def test_a_notebook_shows_the_same_when_it_is_executed(path):
    again = [cell for cell in executed(path).cells if cell.cell_type == "code"]
    assert [words_shown(cell) for cell in again] == [words_shown(cell) for cell in code_of(path)]
