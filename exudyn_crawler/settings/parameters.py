"""Base of all parameter classes: checked, frozen, with units."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

import pydantic
from annotated_types import MaxLen, MinLen

from exudyn_crawler.errors import ParameterError
from exudyn_crawler.settings import fields
from exudyn_crawler.settings.error_lines import error_lines

Errors = Iterator[str]
"""Errors of values, a line each."""
Item = TypeVar("Item")
Several = Annotated[tuple[Item, ...], MinLen(1)]


def _printable(name: str) -> str:
    if not name.isprintable():
        raise ValueError(f"must be printable, got {name!r}")
    return name


Name = Annotated[str, MinLen(1), MaxLen(100), pydantic.AfterValidator(_printable)]
"""Name of a case, a phase or a run in tables and pages."""


def _rising(values: tuple[Any, ...]) -> tuple[Any, ...]:
    if list(values) != sorted(set(values)):
        raise ValueError(f"must be different and rise, got {fields.shown(values)}")
    return values


Rising = Annotated[tuple[Item, ...], pydantic.AfterValidator(_rising)]


def _from_folder(path: Path, info: pydantic.ValidationInfo) -> Path:
    # relative to the folder of the file that names the path, while that file is read
    return path.absolute() if info.context is None else (info.context / path).resolve()


File = Annotated[Path, pydantic.AfterValidator(_from_folder)]


def quantity(
    unit: str,
    description: str,
    plausible: tuple[float, float] | None = None,
    in_place: str = "",
    **bounds: Any,
) -> Any:
    """Return the pydantic field of a physical quantity.

    A run warns of values outside the range `plausible` of real machines and ground. The `bounds` (gt, ge, lt,
    le of `pydantic.Field`) exclude values that no machine has or that make the numerics fail. `in_place`
    describes what a file may have in place of the value.
    """
    extra: dict[str, Any] = {"unit": unit} | ({"plausible": list(plausible)} if plausible else {})
    extra |= {"in_place": in_place} if in_place else {}
    return pydantic.Field(description=description, json_schema_extra=extra, **bounds)


def option(description: str, default: Any = ..., **bounds: Any) -> Any:
    """Return the pydantic field of a value that is not a physical quantity."""
    return pydantic.Field(default, description=description, **bounds)


class Parameters(pydantic.BaseModel):
    """Frozen, validated group of parameters; what does not fit each other is what `_errors` yields first.

    A ParameterError on construction names each field at fault, its value and what is allowed.
    """

    model_config = pydantic.ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __init__(self, /, **values: Any) -> None:
        try:
            super().__init__(**values)
        except pydantic.ValidationError as error:
            raise ParameterError("\n".join(error_lines(error, type(self)))) from None

    # pydantic validates nested tables together with their owner, so that errors have the whole path
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    @pydantic.model_validator(mode="after")
    def _refuse_errors(self) -> Self:
        for error in self._errors():
            raise ValueError(error)
        return self

    def _errors(self) -> Errors:
        """Yield an error for each contradiction between values; a check may rely on those before it."""
        yield from ()

    def with_(self, changes: Mapping[str, Any] | None = None, /, **values: Any) -> Self:
        """Return a copy with changed values, by field or by path, which is validated like a new object.

        Paths are as ``{"terrain.spring_stiffness": 1e7, "loads.phases[*].side_shift": 0.1}``. Raises
        `ParameterError`, with the path, for a change that cannot be made.
        """
        # fields only: an iteration over the object also gives cached properties
        changed = {name: getattr(self, name) for name in type(self).model_fields} | values
        for path, value in (changes or {}).items():
            with fields.errors_at(path):
                changed = fields.with_value(changed, fields.parse_path(path), value, type(self))
        return type(self)(**self._fitted(changed))

    @classmethod
    def _fitted(cls, values: dict[str, Any]) -> dict[str, Any]:
        """Return the values of a copy, with dependent values adapted."""
        return values

    def _repr_html_(self) -> str:
        """Return the table of every value with unit and meaning, for notebooks."""
        # a slow import that only notebooks need
        import pandas as pd

        with pd.option_context("display.max_colwidth", None):
            return pd.DataFrame(fields.case_rows(self)).to_html(index=False, justify="left")
