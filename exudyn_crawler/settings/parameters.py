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
"""Of a case, a phase or a run, as tables and pages show it."""


def _rising(values: tuple[Any, ...]) -> tuple[Any, ...]:
    if list(values) != sorted(set(values)):
        raise ValueError(f"must be different and rise, got {fields.shown(values)}")
    return values


Rising = Annotated[tuple[Item, ...], pydantic.AfterValidator(_rising)]


def _from_folder(path: Path, info: pydantic.ValidationInfo) -> Path:
    # that of the file which names it, while it is read
    return path.absolute() if info.context is None else (info.context / path).resolve()


File = Annotated[Path, pydantic.AfterValidator(_from_folder)]


def quantity(
    unit: str,
    description: str,
    plausible: tuple[float, float] | None = None,
    in_place: str = "",
    **bounds: Any,
) -> Any:
    """Pydantic field of a physical quantity.

    A run warns of values outside of those `plausible` of machines and ground as there are. Outside of the
    `bounds` (gt, ge, lt, le of `pydantic.Field`) no machine could be meant, or numbers fail. A file may have
    something else `in_place`, in words.
    """
    extra: dict[str, Any] = {"unit": unit} | ({"plausible": list(plausible)} if plausible else {})
    extra |= {"in_place": in_place} if in_place else {}
    return pydantic.Field(description=description, json_schema_extra=extra, **bounds)


def option(description: str, default: Any = ..., **bounds: Any) -> Any:
    """Pydantic field of what is no quantity."""
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

    # parts that are given as tables are validated in one go, so that their faults have the whole path
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    @pydantic.model_validator(mode="after")
    def _refuse_errors(self) -> Self:
        for error in self._errors():
            raise ValueError(error)
        return self

    def _errors(self) -> Errors:
        """Yield the values that do not fit each other; each check may rely on those before it."""
        yield from ()

    def with_(self, changes: Mapping[str, Any] | None = None, /, **values: Any) -> Self:
        """Copy with some values changed, of fields or by their paths, validated again as when made.

        Paths are as ``{"terrain.spring_stiffness": 1e7, "loads.phases[*].side_shift": 0.1}``.
        """
        # of the fields alone: iterating also gives cached properties
        changed = {name: getattr(self, name) for name in type(self).model_fields} | values
        for path, value in (changes or {}).items():
            with fields.errors_at(path):
                changed = fields.with_value(changed, fields.parse_path(path), value, type(self))
        return type(self)(**self._fitted(changed))

    @classmethod
    def _fitted(cls, values: dict[str, Any]) -> dict[str, Any]:
        """Values of a copy, of which some follow others."""
        return values

    def _repr_html_(self) -> str:
        """Table of every value with unit and meaning, for notebooks."""
        # notebooks alone wait for it
        import pandas as pd

        with pd.option_context("display.max_colwidth", None):
            return pd.DataFrame(fields.case_rows(self)).to_html(index=False, justify="left")
