"""Case files: everything that a run depends on, as TOML.

A file gives the fields of `Case` and, beside them, `duration` and `[outputs]`. It may say only what differs
from a `base`: a named case such as "translation" at the top of the file, a named constructor such as "stress"
in the table of a part. Names, units and bounds are those of the parameter classes, here and in the errors.
"""

import difflib
import json
import os
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from pydantic import BaseModel, ValidationError

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.files.case_file import CaseFile, case_text
from exudyn_crawler.case.files.errors import error_lines, toml_content
from exudyn_crawler.case.parameters import fields
from exudyn_crawler.case.parameters.fields import KeyPath
from exudyn_crawler.case.parameters.loads import LoadCycle, cycle_content, with_equal_loads
from exudyn_crawler.case.parameters.track import MOST_SHOES
from exudyn_crawler.errors import CaseFileError, ParameterError
from exudyn_crawler.files import whole_file
from meshes import SHOE_SIZES

Model = TypeVar("Model", bound=BaseModel)

CYCLE = "file"
"""Key of the loads that names a file with their cycle."""

__all__ = ["CaseFile", "case_of", "read_case", "saved_case", "write_case"]


def read_case(path: str | Path, changes: Iterable[str] = ()) -> CaseFile:
    """Read a case file; paths of a mesh and of a load cycle count from the file's folder.

    Parameters
    ----------
    changes : iterable of str
        Values in place of the file's, each as ``terrain.spring_stiffness=1e7`` or, of an item of a list that
        the file or a base has, ``loads.phases[0].end=15``.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    CaseFileError
        Naming every key at fault by its path, and what is allowed there.
    """
    path = Path(path)
    with errors_named(path, CaseFile):
        asked = [_change(change) for change in changes]
        return case_of(toml_content(path, "case file"), path, asked)


class Change(NamedTuple):
    """A value and its path in a case file; `key` is the path as it was written."""

    key: str
    path: KeyPath
    value: Any

    def made_in(self, content: dict[str, Any], kind: type[CaseFile] | None = None) -> dict[str, Any]:
        """Content with the change: tables of a file or, of a `kind`, with what bases give."""
        try:
            changed: dict[str, Any] = fields.with_value(content, self.path, self.value, kind)
        except ValueError as error:
            raise ValueError(f"{self.key}: {error}") from error
        return changed


def case_of(content: dict[str, Any], path: Path, changes: Iterable[Change] = ()) -> CaseFile:
    """Case file of a content that stands in the file `path`; raises `CaseFileError` as `read_case`."""
    with errors_named(path, CaseFile):
        # lists may come from a base
        of_items = [change for change in changes if len(fields.names_of(change.path)) < len(change.path)]
        for change in changes:
            content = content if change in of_items else change.made_in(content)
        return from_content(CaseFile, _resolved(content, path.parent, of_items))


@contextmanager
def errors_named(path: Path, kind: type[BaseModel]) -> Iterator[None]:
    """Make what is wrong with the content of a file, of a parameter class, a `CaseFileError`."""
    try:
        yield
    except ValidationError as error:
        raise CaseFileError(path, list(error_lines(error, kind))) from None
    except CaseFileError:  # of another file that this one names
        raise
    except (ValueError, RecursionError) as error:
        raise CaseFileError(path, [str(error)]) from error


def from_content(kind: type[Model], content: dict[str, Any]) -> Model:
    """Parameter object of the values of a file; `ValidationError` for what is not allowed."""
    # strict JSON takes lists for tuples and whole numbers for any, but no text for numbers
    return kind.model_validate_json(json.dumps(content, default=_untyped), strict=True)


def write_case(case_file: CaseFile, path: str | Path, overwrite: bool = False) -> Path:
    """Write all values with units and meanings; read back, the file gives an equal object.

    Raises
    ------
    FileExistsError
        If the file exists and `overwrite` is false.
    """
    path = Path(path)
    with whole_file(path, overwrite) as temporary:
        temporary.write_text(case_text(case_file), encoding="utf-8")
    return path


def saved_case(text: str | bytes) -> Case:
    """Case from the JSON in a history or a checkpoint; `ParameterError` if it is none."""
    try:
        return Case.model_validate_json(text)
    except ValidationError as error:
        raise ParameterError("\n".join(error_lines(error, Case))) from None


def _change(text: str) -> Change:
    """Change from a key, "=" and a value as TOML writes it; text needs no quotes.

    A key is the path of a value, or its last names where no other value of a case has them.
    """
    key, equals, value = text.partition("=")
    key = key.strip()
    try:
        path = fields.parse_path(key)
    except ValueError:
        equals = ""
    if not equals:
        raise ValueError(
            f"a change must be like terrain.spring_stiffness=1e7 or loads.phases[0].end=15, got {text!r}"
        )
    known = list(fields.key_paths(CaseFile))
    if path[0] not in {fields.BASE, *Case.model_fields, *CaseFile.model_fields}:
        end = "." + ".".join(fields.names_of(path))
        meant = [one for one in known if one.endswith(end)]
        if len(meant) > 1:
            raise ValueError(f"{key}: which one is meant? {', '.join(meant)}")
        path = (*fields.parse_path(meant[0].removesuffix(end)), *path) if meant else path
    # up to the first name that no case file has, of which the check of the content tells
    for count, part in enumerate(path, 1):
        above = ".".join(fields.names_of(path[:count])) + "."
        if part != fields.BASE and not any(f"{one}.".startswith(above) for one in known):
            path = path[:count]
            break
    return Change(key, path, _value(value.strip()))


def _value(text: str) -> Any:
    try:
        content = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    # a line break could hide more
    return content["value"] if len(content) == 1 else text


def _resolved(content: dict[str, Any], folder: Path, of_items: Iterable[Change] = ()) -> dict[str, Any]:
    """Values of a file as `CaseFile` takes them: bases filled in, "none" replaced, items of lists changed."""
    cycle = _cycle_file(content.get("loads"), folder)
    if cycle is not None:
        try:
            content["loads"] = cycle_content(cycle)
        except OSError as error:
            raise ValueError(f"loads.{CYCLE}: {error}") from error
    content = with_base(content, (CaseFile,), {}, ())
    if _spread_equal_loads(content["case"]) and cycle is not None:
        with errors_named(cycle, LoadCycle):
            from_content(LoadCycle, content["case"]["loads"])
    for change in of_items:
        content = change.made_in(content, CaseFile)
        _spread_equal_loads(content["case"])
    flexible = content["case"].get("flexible")
    if isinstance(flexible, dict) and isinstance(flexible.get("mesh"), str):
        flexible["mesh"] = _mesh(flexible["mesh"], folder)
    return content


def _cycle_file(loads: object, folder: Path) -> Path | None:
    """File of the cycle that a table of the loads names."""
    if not isinstance(loads, dict) or CYCLE not in loads:
        return None
    if len(loads) > 1 or not isinstance(loads[CYCLE], str):
        raise ValueError(f"loads.{CYCLE} must be the name of a load cycle and stand alone, got {loads!r}")
    return folder / loads[CYCLE]


def _spread_equal_loads(case: dict[str, Any]) -> bool:
    """Put the one number that a phase, or all of the loads, gives for all shoes on each of them.

    Returns whether the case says how many shoes there are.
    """
    track = case.get("track")
    count = track.get("shoe_count") if isinstance(track, dict) else None
    if "loads" not in case or not isinstance(count, int) or not 0 < count <= MOST_SHOES:
        return False
    case["loads"] = with_equal_loads(case["loads"], count)
    return True


def _mesh(name: str, folder: Path) -> str:
    if name in SHOE_SIZES:
        return name
    # for any text, where Path.is_file raises
    if not os.path.isfile(folder / name):
        raise ValueError(f"flexible.mesh: neither one of {', '.join(SHOE_SIZES)} nor a file: {name!r}")
    return str((folder / name).resolve())


def with_base(
    given: dict[str, Any], kinds: tuple[type[BaseModel], ...], below: Mapping[str, Any], path: KeyPath
) -> dict[str, Any]:
    """What a table of one of the classes gives over its base, or over the values `below` it."""
    given = dict(given)
    tag = given.get(fields.TAG, below.get(fields.TAG))
    kind = next((one for one in kinds if len(kinds) > 1 and fields.tag_of(one) == tag), kinds[0])
    # values of another class say nothing of this one
    values = dict(below) if len(kinds) == 1 or below.get(fields.TAG) == fields.tag_of(kind) else {}
    for beside, part in kind.model_fields.items():
        if fields.is_beside(part):
            inner = {key: given.pop(key) for key in [*given] if key == beside or key not in kind.model_fields}
            values[beside] = with_base(inner, fields.models_of(part.annotation), {}, path)
    name = given.pop(fields.BASE, None)
    if name is not None:
        values = _named(name, kind, path)
    if len(kinds) > 1:
        values.setdefault(fields.TAG, fields.tag_of(kind))
    for key, value in given.items():
        field = kind.model_fields.get(key)
        parts = fields.models_of(field.annotation) if field else ()
        if field and value == fields.NONE and fields.allows_none(field.annotation):
            values[key] = None
        elif parts and isinstance(value, dict):
            under = values.get(key)
            under = under if isinstance(under, dict) else {}  # none, or the list of a table given by mistake
            values[key] = with_base(value, parts, under, (*path, key))
        elif parts and isinstance(value, list):
            values[key] = [
                with_base(one, parts, {}, (*path, key, number)) if isinstance(one, dict) else one
                for number, one in enumerate(value)
            ]
        else:
            values[key] = value
    return values


def _named(name: object, kind: type[BaseModel], path: KeyPath) -> dict[str, Any]:
    """Values of a named constructor."""
    constructors = fields.named_values(kind)
    if not isinstance(name, str) or name not in constructors:
        names = list(constructors)
        near = difflib.get_close_matches(str(name), names, n=1)
        hint = f"did you mean {near[0]!r}? " if near else ""
        allowed = ", ".join(map(repr, names)) or "no names at all"
        raise ValueError(f"{fields.path_text((*path, fields.BASE))}: no {name!r}; {hint}There is {allowed}")
    return constructors[name]().model_dump(mode="json")


def _untyped(value: object) -> object:
    """Stand-in for what JSON has no type for: TOML's dates and times, which no field takes."""
    return {"date or time": str(value)}
