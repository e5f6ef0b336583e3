"""What all parameter classes are: checked, frozen, with units; quantities over time among them."""

from collections.abc import Mapping
from functools import lru_cache
from html import escape
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from annotated_types import Ge, Le, MaxLen, MinLen
from numpy.typing import ArrayLike, NDArray
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator

from exudyn_crawler.case.files.errors import error_lines, shown
from exudyn_crawler.case.parameters.fields import case_rows, parse_path, with_value
from exudyn_crawler.errors import ParameterError

FAR = 1e6
"""m, beyond which places are no longer exact to a tenth of a micrometre."""
Place = Annotated[float, Ge(-FAR), Le(FAR)]
"""Coordinate of a place."""
Component = Annotated[float, Ge(-1e12), Le(1e12)]
"""Of a force, a moment or an inertia."""
FORMULA = ("=", "+", "-", "@")
"""What a cell of a table begins with that spreadsheets take for a formula."""


def _fit_for_tables(name: str) -> str:
    if not name.isprintable():
        raise ValueError(f"must be printable, got {name!r}")
    if name.startswith(FORMULA):
        raise ValueError(
            f"must not begin with {' '.join(FORMULA)}, as formulas of spreadsheets do, got {shown(name)}"
        )
    return name


Name = Annotated[str, MinLen(1), MaxLen(100), AfterValidator(_fit_for_tables)]
"""Of a case, a phase or a run, as tables and pages show it."""
Six = tuple[Component, Component, Component, Component, Component, Component]


def _of_a_body(inertia: Six) -> Six:
    principal = np.linalg.eigvalsh(inertia_tensor(inertia))
    if principal[0] <= 0.0 or principal[2] > principal[0] + principal[1]:
        raise ValueError(
            f"must be that of a body (principal moments positive, none above the sum of the other two), "
            f"got principal moments {principal.tolist()}"
        )
    return inertia


Inertia = Annotated[Six, AfterValidator(_of_a_body)]
"""Ixx, Iyy, Izz, Iyz, Ixz, Ixy (tensor components), kg m2."""


def inertia_tensor(inertia: Six) -> NDArray:
    """Tensor of its components: array (3, 3)."""
    xx, yy, zz, yz, xz, xy = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


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
            raise ParameterError("\n".join(error_lines(error, type(self), in_file=False))) from None

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
        # of its pairs: a class may have a property `keys`
        values = dict(iter(self)) | fields
        for path, value in (changes or {}).items():
            try:
                values = with_value(values, parse_path(path), value, type(self))
            except ValueError as error:
                raise ParameterError(f"{path}: {error}") from None
        return type(self)(**values)

    def _repr_html_(self) -> str:
        """Table of every value with unit and meaning, for notebooks."""
        head = "".join(f"<th>{name}</th>" for name in ("", "value", "unit", "meaning"))
        rows = "".join(
            "<tr>" + "".join(f'<td style="text-align: left">{escape(cell)}</td>' for cell in row) + "</tr>"
            for row in case_rows(self)
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


def quantity(unit: str, description: str, plausible: tuple[float, float] | None = None, **bounds: Any) -> Any:
    """Pydantic field of a physical quantity.

    A run warns of values outside of those `plausible` of machines and ground as there are. Outside of the
    `bounds` (gt, ge, lt, le of `pydantic.Field`) no machine could be meant, or numbers fail.
    """
    extra: dict[str, Any] = {"unit": unit}
    if plausible is not None:
        extra["plausible"] = list(plausible)
    return Field(description=description, json_schema_extra=extra, **bounds)


class StepProfile(Parameters):
    """Values at increasing times, joined by cubic STEPs, constant before and after.

    With ``s = (t - t0) / (t1 - t0)`` the value runs as ``v0 + (v1 - v0) s**2 (3 - 2 s)``, so its rate
    is zero at every given time (ADAMS STEP).
    """

    is_value: ClassVar[bool] = True

    times: Annotated[tuple[float, ...], Field(min_length=1, description="increasing times, s")]
    values: Annotated[
        tuple[Component, ...],
        Field(min_length=1, description="value at each time"),
    ]

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(self.times) != len(self.values):
            raise ValueError(
                f"times and values must be equally many: {len(self.times)} != {len(self.values)}"
            )
        if np.any(np.diff(self.times) <= 0.0):
            raise ValueError(f"times must increase, got {self.times}")
        with np.errstate(all="ignore"):
            cubes = np.diff(self.times) ** 3
            joined = np.isfinite(cubes) & np.isfinite(np.diff(self.values) / cubes)
        if not joined.all():
            raise ValueError(f"times must be apart enough to be joined in numbers, got {self.times}")
        return self

    def __str__(self) -> str:
        return ", ".join(f"{v:.8g} at {t:g}" for t, v in zip(self.times, self.values, strict=True))

    @classmethod
    def constant(cls, value: float) -> Self:
        """Same value at all times."""
        return cls(times=(0.0,), values=(value,))

    def _at(self, time: ArrayLike) -> tuple[NDArray, NDArray]:
        """Number of the STEP that each time lies in, and the share of it that is over; 0 before the first."""
        times, _, lengths, _ = _steps(self.times, self.values)
        inside = np.minimum(np.maximum(time, times[0]), times[-1])
        step = times.searchsorted(inside, side="right") - 1
        return step, (inside - times[step]) / lengths[step]

    def value(self, time: ArrayLike) -> NDArray:
        """Value at each time."""
        _, values, _, rises = _steps(self.times, self.values)
        step, s = self._at(time)
        return values[step] + rises[step] * s**2 * (3.0 - 2.0 * s)

    def rate(self, time: ArrayLike) -> NDArray:
        """Time derivative at each time."""
        _, _, lengths, rises = _steps(self.times, self.values)
        step, s = self._at(time)
        return 6.0 * rises[step] / lengths[step] * s * (1.0 - s)

    def integral(self, time: ArrayLike) -> NDArray:
        """Integral from the first given time to each time (negative before it)."""
        times, values, lengths, rises = _steps(self.times, self.values)
        step, s = self._at(time)
        before = np.append(0.0, np.cumsum(lengths * (values + 0.5 * rises))[:-1])
        within = lengths[step] * s * (values[step] + rises[step] * s**2 * (1.0 - 0.5 * s))
        beyond = time - np.minimum(np.maximum(time, times[0]), times[-1])
        return before[step] + within + beyond * self.value(time)


@lru_cache(maxsize=256)
def _steps(times: tuple[float, ...], values: tuple[float, ...]) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """Start (s), first value, length (s) and rise of every STEP, a flat one last."""
    starts, firsts = np.array(times), np.array(values)
    return starts, firsts, np.append(np.diff(starts), 1.0), np.append(np.diff(firsts), 0.0)
