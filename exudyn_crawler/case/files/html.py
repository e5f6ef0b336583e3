"""Parameter objects as HTML, for notebooks."""

from collections.abc import Iterator
from html import escape

from pydantic import BaseModel

LONGEST = 80
"""Characters of a value; longer ones are cut."""


def parameter_html(model: BaseModel) -> str:
    """Table of every field with its value, unit and meaning, those of parts after the model's own."""
    rows = "".join(
        "<tr>" + "".join(f'<td style="text-align: left">{escape(cell)}</td>' for cell in row) + "</tr>"
        for row in _rows(model)
    )
    head = "".join(f"<th>{name}</th>" for name in ("", "value", "unit", "meaning"))
    return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


def _rows(model: BaseModel, start: str = "") -> Iterator[tuple[str, str, str, str]]:
    """Path, value, unit and meaning of every field."""
    parts: list[tuple[str, BaseModel]] = []
    for name, field in type(model).model_fields.items():
        value = getattr(model, name)
        if isinstance(value, BaseModel):
            parts.append((f"{start}{name}.", value))
        elif isinstance(value, tuple) and value and all(isinstance(one, BaseModel) for one in value):
            parts += [(f"{start}{name}[{number}].", one) for number, one in enumerate(value)]
        else:
            extra = field.json_schema_extra
            unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
            text = str(value)
            shown = text if len(text) <= LONGEST else f"{text[:LONGEST]} ..."
            yield f"{start}{name}", shown, unit, field.description or ""
    for prefix, part in parts:
        yield from _rows(part, prefix)
