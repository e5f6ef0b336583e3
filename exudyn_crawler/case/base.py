"""Base of the parameter classes: frozen, closed to unknown names, finite numbers only."""

from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field

from exudyn_crawler.case.html import parameter_html


class Parameters(BaseModel):
    """Frozen, validated group of parameters.

    Raises
    ------
    pydantic.ValidationError
        On construction, naming each field at fault, its value and what is allowed.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def with_(self, **changes: Any) -> Self:
        """Copy with some fields changed, validated anew."""
        values = {name: getattr(self, name) for name in type(self).model_fields}
        return type(self)(**(values | changes))

    def _repr_html_(self) -> str:
        """Table of every value with unit and meaning, for notebooks."""
        return parameter_html(self)


def quantity(unit: str, description: str, **bounds: Any) -> Any:
    """Pydantic field of a physical quantity; `bounds` as of `pydantic.Field` (gt, ge, lt, le)."""
    return Field(description=description, json_schema_extra={"unit": unit}, **bounds)
