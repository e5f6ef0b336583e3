"""What all parameter classes are: checked, frozen, with units; and the words for what is wrong with one."""

import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, NamedTuple, Self, TypeVar

import numpy as np
import pydantic
from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from pydantic.fields import FieldInfo

from exudyn_crawler.case.parameters import fields
from exudyn_crawler.errors import ParameterError

FAR = 1e6  # m, beyond which places are no longer exact to a tenth of a micrometre
SHOWN = 60  # characters of a refused value that an error shows
MOST_ERRORS = 100  # that are named
WORDS = (
    *(("a valid number", "a number"), ("a valid integer", "a whole number"), ("a valid string", "a text")),
    *(("a valid boolean", "true or false"), ("a valid array", "a list"), ("a valid tuple", "a list")),
    *(("a valid list", "a list"), (" after validation", ""), ("be an object", "be a table")),
)
"""Those of pydantic, and what an engineer says."""
PROFILE = "values over time, such as {times = [0, 5], values = [0, 0.1]} (numbers in s and {unit})"

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
        raise ValueError(f"must be different and rise, got {values}")
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


def quantity(unit: str, description: str, plausible: tuple[float, float] | None = None, **bounds: Any) -> Any:
    """Pydantic field of a physical quantity.

    A run warns of values outside of those `plausible` of machines and ground as there are. Outside of the
    `bounds` (gt, ge, lt, le of `pydantic.Field`) no machine could be meant, or numbers fail.
    """
    extra: dict[str, Any] = {"unit": unit} | ({"plausible": list(plausible)} if plausible else {})
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
        """What of the values does not fit each other; each may take for granted what stands before it."""
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
        return type(self)(**changed)

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
        """Those of the P&H 4100C BOSS; `case.ph4100c` has their sources and says what is open."""
        return cls(**cls._of_ph4100c)


def shown(value: object) -> str:
    """Value as an error shows it, on one line and cut where it is long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= SHOWN else text[: SHOWN - 4] + " ..."


def error_lines(error: pydantic.ValidationError, model: type[pydantic.BaseModel]) -> Iterator[str]:
    """Errors of a validation of the values of `model`, a line each with its path."""
    found = error.errors(include_url=False)
    for one in found[:MOST_ERRORS]:
        loc = one["loc"]
        inside = (other for other in found if other["loc"][: len(loc)] == loc and other is not one)
        # what is in a list may be wrong, and not how much
        if one["type"] != "too_short" or not any(inside):
            yield " ".join(_message(one, model).split())
    if len(found) > MOST_ERRORS:
        yield f"{len(found) - MOST_ERRORS} more errors"


class _Spot(NamedTuple):
    """Where an error is."""

    place: fields.KeyPath  # as a file has it
    table: type[pydantic.BaseModel]  # class of the table there
    field: FieldInfo | None
    held: tuple[type[pydantic.BaseModel], ...]  # one of which the field holds


def _spot(loc: fields.KeyPath, model: type[pydantic.BaseModel]) -> _Spot:
    """Where pydantic's place is, which names the tag of a part that may be of several classes, too."""
    spot = _Spot((), model, None, (model,))
    for part in loc:
        tagged = [kind for kind in spot.held if len(spot.held) > 1 and fields.tag_of(kind) == part]
        if tagged:
            spot = spot._replace(held=tuple(tagged))
        elif isinstance(part, int):
            spot = spot._replace(place=(*spot.place, part))
        else:
            table = spot.held[0] if spot.held else spot.table
            field = table.model_fields.get(part)
            is_beside = part and part == fields.beside(table)
            place = spot.place if is_beside else (*spot.place, part)
            spot = _Spot(place, table, field, fields.models_of(field.annotation) if field else ())
    return spot


def _message(one: Mapping[str, Any], model: type[pydantic.BaseModel]) -> str:
    spot, kind, given = _spot(one["loc"], model), one["type"], one["input"]
    path, unit = fields.path_text(spot.place), fields.unit_of(spot.field) if spot.field else ""
    head = f"{path}: " if path else ""
    message, cause = one["msg"].removeprefix("Value error, ").partition(", unable to ")[0], ""
    if kind == "extra_forbidden":
        allowed = fields.file_fields(model) if len(spot.place) == 1 else spot.table.model_fields
        return head + unknown_key(spot.place, [*allowed])
    if kind == "missing":
        names = " or ".join(f'"{name}"' for name in fields.named_values(spot.table))
        is_item = isinstance(spot.place[-1], int)
        remedy = f"; give it, or start from {names}" if names else ""
        return f"{head}missing" + (f", got {shown(given)}" if is_item else remedy)
    if kind == "value_error":
        return head + message
    if kind.startswith("union_tag") and isinstance(given, dict):
        tags = " or ".join(repr(fields.tag_of(held)) for held in spot.held)
        tag = fields.tag_field(spot.held[0])
        return f"{path}.{tag}: must be {tags}, got {shown(given.get(tag))}"
    if kind.startswith(("model", "union_tag")):
        is_profile = any(getattr(held, "is_value", False) for held in spot.held)
        table = f"a table ({' or '.join(held.__name__ for held in spot.held)})"
        message = f"must be {PROFILE.replace('{unit}', unit) if is_profile else table}"
    elif kind == "float_type" and isinstance(given, str):
        example = f", or such as '1 {next(iter(fields.MISTAKEN[unit]))}'" if unit in fields.MISTAKEN else ""
        message = f"must be a number{f' in {unit}' if unit else ''}{example}"
    for word, plain in WORDS:
        message = message.replace(word, plain)
    message = re.sub("^[A-Z][a-z]+ should", "must", message)
    if kind.startswith(("less_than", "greater_than")) and spot.field and isinstance(given, int | float):
        cause = fields.likely_cause(float(given), spot.field)
    return f"{head}{message}, got {shown(given)}{cause}"


RENAMED = {
    "undercarriage": "is now [gear] with kind = 'rolled'",
    "closed_track": "is now [gear] with kind = 'closed', or 'machine' for two tracks",
    "car_body": "is now [gear.car_body] of a [gear] with kind = 'machine'",
}
"""Keys of older case files, and where their values are now."""


def unknown_key(path: fields.KeyPath, allowed: Sequence[str]) -> str:
    """Say what is wrong with a path whose last name is none of those that are allowed there."""
    if len(path) == 1 and path[0] in RENAMED:
        return RENAMED[str(path[0])]
    near = difflib.get_close_matches(str(path[-1]), allowed, n=1)
    meant = fields.path_text((*path[:-1], *near))
    return f"unknown key; did you mean {meant}?" if near else f"unknown key; allowed are {', '.join(allowed)}"
