"""Base of the parameter classes: frozen, closed to unknown names, finite numbers only."""

import difflib
from typing import Annotated, Any, Self

from annotated_types import Ge, Le, MaxLen, MinLen
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from exudyn_crawler.case.html import parameter_html

FAR = 1e6
"""m, beyond which places are no longer exact to a tenth of a micrometre."""
Place = Annotated[float, Ge(-FAR), Le(FAR)]
"""Coordinate of a place."""
Name = Annotated[str, MinLen(1), MaxLen(100)]


class Parameters(BaseModel):
    """Frozen, validated group of parameters.

    Raises
    ------
    pydantic.ValidationError
        On construction, naming each field at fault, its value and what is allowed.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def with_(self, **changes: Any) -> Self:
        """Copy with some fields changed, validated anew; a note of the error has the nearest name."""
        values = {name: getattr(self, name) for name in type(self).model_fields}
        try:
            return type(self)(**(values | changes))
        except ValidationError as error:
            for name in changes.keys() - values.keys():
                for near in difflib.get_close_matches(name, values, n=1):
                    error.add_note(f"{name}: did you mean {near}?")
            raise

    def _repr_html_(self) -> str:
        """Table of every value with unit and meaning, for notebooks."""
        return parameter_html(self)


def quantity(unit: str, description: str, plausible: tuple[float, float] | None = None, **bounds: Any) -> Any:
    """Pydantic field of a physical quantity.

    Parameters
    ----------
    plausible : tuple of float, optional
        Least and greatest value of machines and ground as there are; beyond, a run warns.
    bounds :
        As of `pydantic.Field` (gt, ge, lt, le): beyond, no machine could be meant or numbers fail.
    """
    extra: dict[str, Any] = {"unit": unit}
    if plausible is not None:
        extra["plausible"] = list(plausible)
    return Field(description=description, json_schema_extra=extra, **bounds)
