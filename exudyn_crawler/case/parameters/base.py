"""Base of the parameter classes: frozen, closed to unknown names, finite numbers only."""

from collections.abc import Mapping
from typing import Annotated, Any, Self

from annotated_types import Ge, Le, MaxLen, MinLen
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from exudyn_crawler.case.files.faults import faults, shown
from exudyn_crawler.case.files.html import parameter_html
from exudyn_crawler.case.files.paths import fields_of, parse_path
from exudyn_crawler.case.parameters.kinds import with_value_in
from exudyn_crawler.errors import ParameterError

FAR = 1e6
"""m, beyond which places are no longer exact to a tenth of a micrometre."""
Place = Annotated[float, Ge(-FAR), Le(FAR)]
"""Coordinate of a place."""
Name = Annotated[str, MinLen(1), MaxLen(100)]


class Parameters(BaseModel):
    """Frozen, validated group of parameters.

    Raises
    ------
    ParameterError
        On construction, naming each field at fault, its value and what is allowed.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __init__(self, /, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise ParameterError("\n".join(faults(error, type(self), in_file=False))) from None

    # parts that are given as tables are validated in one go, so that their faults have the whole path
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    def __setattr__(self, name: str, value: Any) -> None:
        try:
            super().__setattr__(name, value)
        except ValidationError:
            raise ParameterError(
                f"{name}: parameters do not change, got {shown(value)}; with_({name}=...) gives a copy"
            ) from None

    def with_(self, changes: Mapping[str, Any] | None = None, /, **fields: Any) -> Self:
        """Copy with some values changed, validated again.

        Parameters
        ----------
        changes : mapping, optional
            Values by their paths: ``{"terrain.spring_stiffness": 1e7, "loads.phases[*].side_shift": 0.1}``.
        **fields
            Values of fields.

        Raises
        ------
        ParameterError
            Naming each field at fault, its value and what is allowed.
        """
        values = fields_of(self) | fields
        for path, value in (changes or {}).items():
            try:
                values = with_value_in(type(self), values, parse_path(path), value)
            except ValueError as error:
                raise ParameterError(f"{path}: {error}") from None
        return type(self)(**values)

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
