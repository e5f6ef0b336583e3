"""Words for what is wrong: of every field, in a line, without those of the library, and cut where long."""

import json
import re

import pydantic
import pytest

import exudyn_crawler.results.checks.cases
import exudyn_crawler.sweep.scatter
from exudyn_crawler.case import Case
from exudyn_crawler.case.parameters import loads
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.ground.cells.laws import bekker, rock
from exudyn_crawler.machines import CaseFile, read_case
from exudyn_crawler.settings import fields, reading, sentences
from exudyn_crawler.settings.error_lines import error_lines
from exudyn_crawler.settings.parameters import Parameters

BAD = (
    *("x", "", "386,4 kN", 5, -1, 1.5, True, [], [5], ["x"], [[1, 2]], [None], {}, {"a": 1}, {"model": "x"}),
    *([{}], [{"a": 1}], {"times": [0], "values": ["x"]}, 1e300, [1.0, "x", True], [*range(9)] * 50),
)
LIBRARY = re.compile(
    r"constrained-|function-|literal\[|tuple\[|list\[|NoneType|Input should|valid |validat|instance of|Field "
    r"required|dictionary|_type\b|pydantic|union|callable|parsed|unpack"
)
LONGEST = 450


def classes(kind=Parameters):
    """All parameter classes."""
    assert bekker
    assert rock
    assert exudyn_crawler.results.checks.cases
    assert exudyn_crawler.sweep.scatter
    for below in kind.__subclasses__():
        # the class of a file has its case beside; that of all cycles says nothing of its phases
        if not issubclass(below, CaseFile) and below is not loads.Cycle:
            yield below
        yield from classes(below)


class Wordless:
    """Error of a validation without the library's messages."""

    def __init__(self, error):
        self.error = error

    def errors(self, **options):
        """Faults of the error."""
        return [
            {key: value for key, value in fault.items() if key != "msg"}
            for fault in self.error.errors(**options)
        ]


def lines_of(kind, content):
    """Lines of a file's content, of a class of parameters."""
    try:
        kind.model_validate_json(json.dumps(reading.filled(content, kind)), strict=True)
    except pydantic.ValidationError as error:
        return list(error_lines(Wordless(error), kind))
    return []


@pytest.mark.parametrize("kind", sorted(set(classes()), key=lambda kind: kind.__name__))
def test_what_is_wrong_with_any_field_is_said_in_plain_words(kind):
    for name in kind.model_fields:
        for value in BAD:
            for line in lines_of(kind, {name: value}):
                assert len(line) <= LONGEST
                assert not LIBRARY.search(line.partition("got ")[0]), line


ERRORS = {
    "any": (),
    "bool": ("bool_type", "bool_parsing"),
    "default": (),
    "definition-ref": (),
    "definitions": (),
    "dict": ("dict_type", "invalid_key"),
    "float": ("float_type", "float_parsing", "finite_number"),
    "function-after": ("value_error",),
    "function-before": ("value_error",),
    "function-plain": (),
    "int": ("int_type", "int_parsing", "int_parsing_size", "int_from_float"),
    "is-instance": ("is_instance_of",),
    "json-or-python": (),
    "lax-or-strict": (),
    "literal": ("literal_error",),
    "model": ("model_type",),
    "model-field": (),
    "model-fields": ("missing", "extra_forbidden", "model_attributes_type", "invalid_key"),
    "no-info": (),
    "nullable": (),
    "str": ("string_type", "string_unicode"),
    "tagged-union": ("union_tag_invalid", "union_tag_not_found", "model_attributes_type", "dict_type"),
    "tuple": ("tuple_type", "iteration_error", "missing", "too_long"),
    "union": (),
    "with-info": (),
}
"""Types of errors of each kind of field, as pydantic lists them."""
LIMITS = {"gt": "greater_than", "ge": "greater_than_equal", "lt": "less_than", "le": "less_than_equal"}
LENGTHS = {"min_length": "too_short", "max_length": "too_long"}
WHOLE_LINES = {"value_error", "missing", "extra_forbidden"}
"""Errors whose lines tell more than a sentence about the value."""


def error_types(schema):
    """Types of errors that a field of pydantic's schema can raise."""
    if isinstance(schema, list | tuple):
        return {kind for item in schema for kind in error_types(item)}
    if not isinstance(schema, dict):
        return set()
    found = {kind for key, part in schema.items() if key != "metadata" for kind in error_types(part)}
    if isinstance(kind := schema.get("type"), str):
        found |= set(ERRORS[kind])
        found |= {name for key, name in LIMITS.items() if key in schema}
        of_text = "string_" if kind == "str" else ""
        found |= {f"{of_text}{name}" for key, name in LENGTHS.items() if key in schema}
        found |= {schema["custom_error_type"]} if "custom_error_type" in schema else set()
    return found


def test_every_error_that_a_field_can_have_has_a_sentence():
    raised = {
        found for kind in (*classes(), CaseFile) for found in error_types(kind.__pydantic_core_schema__)
    }
    assert raised - WHOLE_LINES == set(sentences.SENTENCES)


def test_a_bound_has_the_unit_of_its_field(refused):
    assert refused("[shoe]\nmass = -1") == ["shoe.mass: must be greater than or equal to 0.1 kg, got -1"]
    with pytest.raises(ParameterError, match=r"^case: must be a table \(Case\), got 'x'$"):
        CaseFile(case="x")


def test_keys_of_older_files_are_those_of_the_case():
    assert fields.renamed_keys(CaseFile) == Case.renamed
    assert fields.renamed_keys(Parameters) == {}
    assert not set(Case.renamed) & set(Case.model_fields)


@pytest.fixture
def refused(tmp_path):
    """Lines with which a case file of these lines after its base is refused."""

    def lines(text, base="translation"):
        (tmp_path / "case.toml").write_text(f'base = "{base}"\n{text}\n')
        with pytest.raises(reading.CaseFileError) as refusal:
            read_case(tmp_path / "case.toml")
        return refusal.value.errors

    return lines


EQUAL = "or a load in N for all shoes, such as '386.4 kN', got "


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            'loads = "386,4 kN"',
            f"loads: must be a table (LoadCycle), {EQUAL}'386,4 kN'; numbers have a point: '386.4 kN'",
        ),
        ('loads = "386 kX"', f"loads: must be a table (LoadCycle), {EQUAL}'386 kX'"),
        (
            '[[loads.phases]]\nname = "a"\nend = 1\nloads = "4,5 kN"',
            f"loads.phases[0].loads: must be a list of numbers in N, {EQUAL}'4,5 kN'; "
            "numbers have a point: '4.5 kN'",
        ),
        (
            '[shoe]\nmass = "4,5 t"',
            "shoe.mass: must be a number in kg, or such as '1 t', got '4,5 t'; numbers have a point: '4.5 t'",
        ),
        (
            '[shoe]\nmass = "4,682 kg"',
            "shoe.mass: must be a number in kg, or such as '1 t', got '4,682 kg'; "
            "numbers have no commas: '4682 kg', or '4.682 kg'",
        ),
    ],
)
def test_a_comma_in_a_number_is_named(refused, text, line):
    assert refused(text) == [line]


def test_laws_of_soil_take_no_truth_value_or_text_for_a_number(refused):
    ground = (
        '[terrain]\nmodel = "cells"\norigin = [0, 0]\nlength = 40\nwidth = 20\n[contact]\nmodel = "cells"\n'
    )
    law = '[contact.law]\nbase = "lete_sand"\nmodel = "bekker"\nk_c = true\nk_phi = "3"\n'
    assert refused(ground + law, "rolled") == [
        "contact.law.k_c: must be a number, got True",
        "contact.law.k_phi: must be a number in N/m^(exponent+2), got '3'; "
        "without quotes it is 3 N/m^(exponent+2), within them it needs a unit",
    ]
    # classes of a law have bases, whose values stand among its own in the order of faults
    lacking, value = refused(ground + '[contact.law]\nmodel = "bekker"\nk_phi = "5 MPa"\n', "rolled")
    assert lacking.startswith("contact.law.shear_deformation, k_c, exponent, reload_stiffness")
    assert "are missing" in lacking
    assert value == "contact.law.k_phi: must be a number in N/m^(exponent+2), got '5 MPa'"
    unknown = "contact.law.model: must be 'bekker' or 'rock', got 'mud'"
    assert refused(ground + '[contact.law]\nmodel = "mud"', "rolled") == [unknown]


def test_long_lists_are_cut(refused):
    (line,) = refused("[gear]\nslides = [[-2.7, 2.7, 1.3]]\ncarriers = []\nslide_step = 0.001", "closed")
    assert "got three at x = -2.7, -2.699, -2.698 m; lines at least 0.31 m apart do" in line
    (line,) = refused(f"[drive.speed]\ntimes = {[0.0] * 9000}\nvalues = {[0.0] * 9000}")
    assert line.startswith("drive.speed: times must increase, got (0.0, 0.0, 0.0,")
    assert line.endswith(", 0.0, ... (9000 values)")
    assert len(line) < 150


def test_equal_faults_of_neighbours_in_a_list_are_one_line():
    content = {"phases": [{"name": "a", "end": 1.0, "loads": [1e30, 1e30, 5.0, 1e30, -1e30, -1e30]}]}
    assert [line.partition(":")[0] for line in lines_of(loads.LoadCycle, content)] == [
        "phases[0].loads[0..1]",
        "phases[0].loads[3]",
        "phases[0].loads[4..5]",
    ]


def test_a_value_of_several_kinds_has_one_line():
    vary = exudyn_crawler.sweep.scatter.DutyScatter.model_fields["vary"]
    (kind,) = fields.models_of(vary.annotation)
    assert lines_of(kind, {"key": 5}) == ["key: must be a text or a list, got 5"]
    assert lines_of(kind, {"key": [5]}) == ["key[0]: must be a text, got 5"]
    assert lines_of(kind, {"key": ""}) == ["key: must have at least 1 character, got ''"]
