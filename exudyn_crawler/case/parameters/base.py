"""Base of all parameter classes: checked, frozen, with units."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self, TypeVar

import numpy as np
import pydantic
from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen

from exudyn_crawler.case.parameters import fields
from exudyn_crawler.case.parameters.faults import error_lines
from exudyn_crawler.errors import ParameterError

FAR = 1e6  # m, beyond which places are no longer exact to a tenth of a micrometre

Errors = Iterator[str]  # a line each
# bounds beyond which no machine could be meant, or numbers fail
Place = Annotated[float, Ge(-FAR), Le(FAR)]
Component = Annotated[float, Ge(-1e12), Le(1e12)]  # of a force, a moment or an inertia
Length = Annotated[float, Ge(1e-3), Le(100.0)]
Extent = Annotated[float, Ge(0.0), Le(100.0)]
Width = Annotated[float, Ge(1e-9), Le(100.0)]
Depth = Annotated[float, Ge(1e-9), Le(10.0)]
Speed = Annotated[float, Ge(1e-9), Le(100.0)]
Stiffness = Annotated[float, Ge(1.0), Le(1e18)]
Exponent = Annotated[float, Ge(1.0), Le(10.0)]
Damping = Annotated[float, Ge(0.0), Le(1e12)]
Coefficient = Annotated[float, Ge(0.0), Le(10.0)]  # of friction or resistance
Slope = Annotated[float, Gt(-1.0), Lt(1.0)]
Mass = Annotated[float, Ge(1.0), Le(1e9)]  # of a machine's parts
Load = Annotated[float, Ge(-1e10), Le(1e10)]  # on a shoe, N
Roller = Annotated[float, Ge(-1e3), Le(1e3)]  # place of a roller along the frame, m
Survival = Annotated[float, Gt(0.0), Lt(1.0)]  # part of shoes that survives
Two = tuple[Place, Place]
Three = tuple[Place, Place, Place]
Item = TypeVar("Item")
Several = Annotated[tuple[Item, ...], MinLen(1)]
Vector = tuple[Component, Component, Component]
Six = tuple[Component, Component, Component, Component, Component, Component]


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


def _of_a_body(inertia: Six) -> Six:
    principal = np.linalg.eigvalsh(inertia_tensor(inertia))
    if principal[0] <= 0.0 or principal[2] > principal[0] + principal[1]:
        of_body = "principal moments positive, none above the sum of the other two"
        raise ValueError(f"must be that of a body ({of_body}), got principal moments {principal.tolist()}")
    return inertia


Inertia = Annotated[Six, pydantic.AfterValidator(_of_a_body)]
"""Ixx, Iyy, Izz, Iyz, Ixz, Ixy (tensor components), kg m2."""


def inertia_tensor(inertia: Six) -> np.ndarray:
    """Tensor of its components: array (3, 3)."""
    xx, yy, zz, yz, xz, xy = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


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


class PH4100C(Parameters):
    """Parameters whose `values` for the P&H 4100C BOSS a class names."""

    _of_ph4100c: ClassVar[Mapping[str, Any]]

    def __init_subclass__(cls, values: Mapping[str, Any], **of_model: Any) -> None:
        super().__init_subclass__(**of_model)
        cls._of_ph4100c = values

    @classmethod
    def ph4100c(cls) -> Self:
        """Those of the P&H 4100C BOSS; `case.ph4100c` has their sources and marks what is assumed."""
        return cls(**cls._of_ph4100c)
