"""Sentences for refused values: a row for each of pydantic's types of errors, filled from the field.

This table gives the words, independent of those of the library. Bounds and counts come from the library's
error; unit and choices come from the field.
"""

from collections.abc import Mapping
from typing import Any

from pydantic.fields import FieldInfo

from exudyn_crawler.settings import fields

LIST = "must be a list"
NUMBER = "must be a number"
TABLE = "must be a table"
TEXT = "must be a text"
TRUTH = "must be true or false"
WHOLE_NUMBER = "must be a whole number"
OF_KIND = {
    **dict.fromkeys(("float_type", "float_parsing"), NUMBER),
    **dict.fromkeys(("int_type", "int_parsing", "int_from_float"), WHOLE_NUMBER),
    **dict.fromkeys(("bool_type", "bool_parsing"), TRUTH),
    **dict.fromkeys(("string_type", "string_unicode"), TEXT),
    **dict.fromkeys(("tuple_type", "iteration_error"), LIST),
    **dict.fromkeys(("model_type", "model_attributes_type", "dict_type"), TABLE),
    **dict.fromkeys(("union_tag_invalid", "union_tag_not_found"), TABLE),
    "literal_error": "must be {choices}",
    "is_instance_of": "must be a {class}",
    "path_type": "must be a path",
    "invalid_key": "must have texts for keys",
    "int_parsing_size": "must be a whole number of fewer digits",
}
"""Sentences for a value of another kind than the field's."""
OF_SIZE = {
    "greater_than": "must be greater than {gt}{unit}",
    "greater_than_equal": "must be greater than or equal to {ge}{unit}",
    "less_than": "must be less than {lt}{unit}",
    "less_than_equal": "must be less than or equal to {le}{unit}",
    "finite_number": "must be a finite number",
    "too_short": "must have at least {min_length} item{plural}",
    "too_long": "must have at most {max_length} item{plural}",
    "string_too_short": "must have at least {min_length} character{plural}",
    "string_too_long": "must have at most {max_length} character{plural}",
}
"""Sentences for a value of the right kind that is too small, too large, too short or too long."""
SENTENCES = OF_KIND | OF_SIZE
BOUNDED = ("greater_than", "greater_than_equal", "less_than", "less_than_equal")
"""Types of errors of a number out of its bounds."""
UNREAD = ("float_type", "int_type", "tuple_type", "model_type", "model_attributes_type")
"""Types of errors of a text in place of a number, a list or a table."""
OTHER = "must be another value"
"""Sentence for a type of error that no field of this program raises."""


def sentence(error_type: str, context: Mapping[str, Any], field: FieldInfo | None) -> str:
    """Return the sentence on the allowed value of a field, from the type and the context of its error."""
    counts = [context[name] for name in ("min_length", "max_length") if name in context]
    unit = fields.unit_of(field) if field else ""
    values = {name: f"{value:.12g}" if fields.is_number(value) else value for name, value in context.items()}
    values |= {"unit": f" {unit}" if unit else "", "plural": "" if counts == [1] else "s"}
    values |= {"choices": _either([repr(choice) for choice in fields.literals(field and field.annotation)])}
    return SENTENCES.get(error_type, OTHER).format_map(values)


def _either(words: list[str]) -> str:
    """Join words as alternatives: a, b or c."""
    return " or ".join(filter(None, (", ".join(words[:-1]), *words[-1:])))
