"""Constraints of a field, for prompts and lists: allowed words, bounds, and named tables of a part."""

from typing import Any, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic.fields import FieldInfo

from exudyn_crawler.settings import fields

BOUNDS = {Gt: ("gt", "above"), Ge: ("ge", "at least"), Lt: ("lt", "below"), Le: ("le", "at most")}
"""Attribute of each class of bounds, and the words for it."""
TRUTH = ["true", "false"]


def choices(annotation: Any) -> list[str]:
    """Return the allowed words of a field, in a file's spelling; empty for any other field."""
    if get_origin(annotation) is Literal:
        return [str(choice) for choice in get_args(annotation)]
    if annotation is bool:
        return TRUTH
    several = [choices(part) for part in get_args(annotation) if part is not type(None)]
    return [word for words in several for word in words] if all(several) else []


def range_words(field: FieldInfo) -> str:
    """Describe the plausible range of a field, else its bounds; empty if it has neither."""
    unit = fields.unit_of(field)
    if (span := fields.plausible_range(field)) is not None:
        low, high = (fields.value_text(float(value), unit) for value in span)
        return f"{low} to {high} as a rule"
    parts = []
    for bound in field.metadata:
        if type(bound) in BOUNDS:
            attribute, words = BOUNDS[type(bound)]
            parts.append(f"{words} {fields.value_text(float(getattr(bound, attribute)), unit)}")
    return ", ".join(parts)


def presets(field: FieldInfo) -> dict[str, dict[str, str]]:
    """Return the tables of a file that select named values of a part, by the names for a reader."""
    kinds = fields.models_of(field.annotation)
    found = {}
    for kind in kinds:
        tag = {fields.tag_field(kind): fields.tag_of(kind)} if len(kinds) > 1 else {}
        for name in fields.named_values(kind):
            found[" ".join([*tag.values(), name.replace("_", " ")])] = tag | {fields.BASE: name}
    return found
