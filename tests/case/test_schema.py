"""The schema of case files takes what the program takes, and finds mistakes of writing."""

import tomllib
from itertools import chain

import pytest
from jsonschema import Draft202012Validator

from exudyn_crawler import Case, CaseFile
from exudyn_crawler.case.case_file import case_text
from exudyn_crawler.case.files import case_schema
from exudyn_crawler.case.parameters.fields import named_values
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil

CASES = {name: make() for name, make in named_values(Case).items()}
CASES["cells"] = Case.rolled().on_cells(BekkerSoil.lete_sand())


@pytest.fixture(scope="module")
def schema() -> Draft202012Validator:
    found = case_schema()
    Draft202012Validator.check_schema(found)
    return Draft202012Validator(found)


def told(schema: Draft202012Validator, text: str) -> str:
    errors = schema.iter_errors(tomllib.loads(text))
    return " ".join(one.message for error in errors for one in chain([error], error.context))


@pytest.mark.parametrize("name", CASES)
def test_every_case_that_is_written_fits(schema, name):
    assert told(schema, case_text(CaseFile(case=CASES[name]))) == ""


@pytest.mark.parametrize(
    "text",
    [
        "base = 'translation'\n[terrain]\nspring_stiffness = '10 MN/m'",
        "base = 'rolled'\n[contact]\nmodel = 'cells'\n[contact.law]\nmodel = 'bekker'\nbase = 'lete_sand'",
        "base = 'stress'\nduration = 2\n[[loads.phases]]\nname = 'dig'\nend = 3\nloads = '450 kN'",
        "flexible = 'none'",
    ],
)
def test_files_that_hold_little_fit(schema, text):
    assert told(schema, text) == ""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("terain = 1", "'terain' was unexpected"),
        ("[terrain]\nspring_stifness = 1", "'spring_stifness' was unexpected"),
        ("base = 'stres'", "'stres' is not one of"),
        ("[shoe]\nmass = -1", "-1 is less than the minimum"),
        ("drive = 3", "3 is not of type 'object'"),
    ],
)
def test_mistakes_are_found(schema, text, words):
    assert words in told(schema, text)
