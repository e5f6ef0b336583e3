"""Case files: everything that a run depends on, as TOML.

A file gives the fields of `Case` and, beside them, `duration` and `[outputs]`. It may say only what differs
from a `base`: a named case such as "translation" at the top of the file, a named constructor such as "stress"
in the table of a part. Names, units and bounds are those of the parameter classes, here and in the errors.
"""

import difflib
import inspect
import json
import math
import re
import tomllib
import typing
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import UnionType
from typing import Any, Self

from pydantic import BaseModel, ValidationError, model_validator

from exudyn_crawler.case import Case
from exudyn_crawler.case.base import Parameters, quantity
from exudyn_crawler.case.outputs import Outputs
from exudyn_crawler.errors import CaseFileError
from exudyn_crawler.files import whole_file

NONE = "none"
"""What a file says where a field has no value, which TOML cannot."""
BASE = "base"
SHOWN = 60
"""Characters of a refused value that an error shows."""


class CaseFile(Parameters):
    """Case with the duration of its run and what the run leaves.

    Raises
    ------
    pydantic.ValidationError
        Where the duration or the outputs do not fit the case.
    """

    case: Case
    duration: float = quantity("s", "simulated time", default=10.0, allow_inf_nan=True)
    outputs: Outputs = Outputs()

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not (math.isfinite(self.duration) and self.duration > 0.0):
            raise ValueError(f"duration must be positive and finite, got {self.duration!r} s")
        beyond = [shoe for shoe in self.outputs.shoes or () if not 1 <= shoe <= self.case.track.shoe_count]
        if beyond:
            raise ValueError(f"outputs.shoes must be in 1..{self.case.track.shoe_count}, got {beyond}")
        times = self.outputs.picture_times
        if times is not None and times[-1] > self.duration:
            raise ValueError(f"outputs.picture_times must lie in 0..{self.duration:g} s, got {list(times)}")
        self.case.check_support(self.duration)
        return self

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a case file; the path of a mesh counts from the file's folder.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        CaseFileError
            Naming every key at fault by its path, and what is allowed there.
        """
        path = Path(path)
        if not path.is_file():
            raise FileNotFoundError(f"no case file {path}")
        try:
            # some editors put a mark before the text
            content = tomllib.loads(path.read_bytes().decode("utf-8-sig"))
        except (ValueError, RecursionError) as error:
            raise CaseFileError(path, [f"not TOML: {error}"]) from error
        try:
            # strict JSON takes lists for tuples and whole numbers for any, but no text for numbers
            text = json.dumps(_resolved(content, path.parent), default=_untyped)
            return cls.model_validate_json(text, strict=True)
        except ValidationError as error:
            raise CaseFileError(path, list(faults(error, cls))) from error
        except (ValueError, RecursionError) as error:
            raise CaseFileError(path, [str(error)]) from error

    def write(self, path: str | Path, overwrite: bool = False) -> Path:
        """Write all values with units and meanings; read back, the file gives an equal object.

        Raises
        ------
        FileExistsError
            If the file exists and `overwrite` is false.
        """
        from exudyn_crawler.case.text import case_text

        path = Path(path)
        with whole_file(path, overwrite) as temporary:
            temporary.write_text(case_text(self), encoding="utf-8")
        return path


def read_case(path: str | Path) -> CaseFile:
    """Read a case file; as `CaseFile.read`."""
    return CaseFile.read(path)


def write_case(case_file: CaseFile, path: str | Path, overwrite: bool = False) -> Path:
    """Write a case file; as `CaseFile.write`."""
    return case_file.write(path, overwrite)


def named_values(kind: type[BaseModel]) -> dict[str, Callable[[], BaseModel]]:
    """Constructors of a parameter class that need no argument, by name: ``Terrain.stress``, say."""
    found: dict[str, Callable[[], BaseModel]] = {}
    for name, attribute in vars(kind).items():
        if name.startswith("_") or not isinstance(attribute, classmethod):
            continue
        method = getattr(kind, name)
        arguments = inspect.signature(method).parameters.values()
        if all(argument.default is not inspect.Parameter.empty for argument in arguments):
            found[name] = method
    return found


def model_of(annotation: Any) -> type[BaseModel] | None:
    """Parameter class that a field holds, or holds many or perhaps none of; None if it holds plain values."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for part in typing.get_args(annotation):
        if found := model_of(part):
            return found
    return None


def allows_none(annotation: Any) -> bool:
    """Whether a field may have no value."""
    is_union = typing.get_origin(annotation) in (typing.Union, UnionType)
    return is_union and type(None) in typing.get_args(annotation)


def _resolved(content: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Values of a file as `CaseFile` takes them: bases filled in, "none" replaced."""
    own = {name: content.pop(name) for name in CaseFile.model_fields if name in content and name != "case"}
    case = _with_base(content, Case, {}, ())
    for name, field in CaseFile.model_fields.items():
        kind = model_of(field.annotation)
        if kind and isinstance(own.get(name), dict):
            own[name] = _with_base(own[name], kind, {}, (name,))
    flexible = case.get("flexible")
    if isinstance(flexible, dict) and isinstance(flexible.get("mesh"), str):
        flexible["mesh"] = _mesh(flexible["mesh"], folder)
    return {**own, "case": case}


def _mesh(name: str, folder: Path) -> str:
    from meshes import SHOE_SIZES

    if name in SHOE_SIZES:
        return name
    try:
        path = (folder / name).resolve()
        there = path.is_file()
    except (OSError, ValueError):
        there = False
    if not there:
        raise ValueError(f"flexible.mesh: neither one of {', '.join(SHOE_SIZES)} nor a file: {name!r}")
    return str(path)


def _with_base(
    given: dict[str, Any], kind: type[BaseModel], below: Mapping[str, Any], place: tuple[str, ...]
) -> dict[str, Any]:
    """What a table gives over its base, or over the values `below` it, field by field."""
    given = dict(given)
    name = given.pop(BASE, None)
    values = dict(below)
    if name is not None:
        constructors = named_values(kind)
        if not isinstance(name, str) or name not in constructors:
            names = list(constructors)
            near = difflib.get_close_matches(str(name), names, n=1)
            hint = f"did you mean {near[0]!r}? " if near else ""
            allowed = ", ".join(map(repr, names)) or "no names at all"
            raise ValueError(f"{'.'.join((*place, BASE))}: no {name!r}; {hint}There is {allowed}")
        values = constructors[name]().model_dump(mode="json")
    for key, value in given.items():
        field = kind.model_fields.get(key)
        part = model_of(field.annotation) if field else None
        if field and value == NONE and allows_none(field.annotation):
            values[key] = None
        elif part and isinstance(value, dict):
            values[key] = _with_base(value, part, values.get(key) or {}, (*place, key))
        else:
            values[key] = value
    return values


def _untyped(value: object) -> object:
    """Stand-in for what JSON has no type for: TOML's dates and times, which no field takes."""
    return {"date or time": str(value)}


def faults(error: ValidationError, model: type[BaseModel] = Case) -> Iterator[str]:
    """Every fault that a validation found, a line each: the key's path, what is wrong and what is allowed."""
    found = error.errors(include_url=False)
    for one in found:
        place = tuple(one["loc"])
        within = [other for other in found if other["loc"][: len(place)] == place and other is not one]
        if one["type"] == "too_short" and within:
            continue  # what is in the list is at fault, not how much
        path = key_path(place[1:] if model is CaseFile and place[:1] == ("case",) else place)
        message = one["msg"].removeprefix("Value error, ").replace("be an object", "be a table")
        if one["type"] == "extra_forbidden":
            yield f"{path}: unknown key; {_nearest(place, model)}"
        elif one["type"] == "missing":
            yield f"{path}: missing; give it, or a {BASE} for what is left out"
        elif one["type"] == "value_error":
            yield f"{path}: {message}" if path else message
        else:
            yield f"{path}: {message}, got {shown(one['input'])}"


def validated_model(error: ValidationError) -> type[BaseModel]:
    """Parameter class whose construction failed."""
    kinds: list[type[BaseModel]] = [CaseFile, *Parameters.__subclasses__()]
    return next((kind for kind in kinds if kind.__name__ == error.title), Case)


def key_path(place: tuple[int | str, ...]) -> str:
    """Place of a value as it is written: ``loads.phases[2].end``."""
    text = ""
    for part in place:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            # keys that need quotes in TOML have them here, and cannot break the line
            text += "." + (part if re.fullmatch(r"[\w-]+", part, re.ASCII) else json.dumps(part))
    return text.lstrip(".")


def shown(value: object) -> str:
    """Value as an error shows it, on one line and cut where it is long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= SHOWN else text[: SHOWN - 4] + " ..."


def _nearest(place: tuple[int | str, ...], model: type[BaseModel]) -> str:
    """Hint at the name that was meant: of the same table if one is near, else of another."""
    wrong = str(place[-1])
    table: type[BaseModel] | None = model
    for part in place[:-1]:
        if isinstance(part, str):
            field = table.model_fields.get(part) if table else None
            table = model_of(field.annotation) if field else None
    names = list(table.model_fields) if table else []
    if table is Case and model is CaseFile:
        names += [name for name in CaseFile.model_fields if name != "case"]
    if near := difflib.get_close_matches(wrong, names, n=1, cutoff=0.7):
        start = place[1:-1] if model is CaseFile else place[:-1]
        return f"did you mean {key_path((*start, near[0]))}?"
    elsewhere = {path.rpartition(".")[2]: path for path in key_paths(Case)}
    if near := difflib.get_close_matches(wrong, elsewhere, n=1, cutoff=0.7):
        return f"did you mean {elsewhere[near[0]]}?"
    near = difflib.get_close_matches(wrong, names, n=1, cutoff=0.0) or names[:1]
    return f"the nearest is {near[0]}, allowed are {', '.join(names)}"


def key_paths(model: type[BaseModel], start: str = "") -> Iterator[str]:
    """Paths of all values of a parameter class."""
    for name, field in model.model_fields.items():
        part = model_of(field.annotation)
        if part:
            yield from key_paths(part, f"{start}{name}.")
        else:
            yield f"{start}{name}"
