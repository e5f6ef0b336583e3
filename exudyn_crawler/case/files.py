"""Case files: everything that a run depends on, as TOML, and their schema, by which editors check them.

A file gives the fields of `Case` and, beside them, `duration` and `[outputs]`, or what of them differs from a
`base`: a named case such as "translation" at its top, a constructor such as "stress" in the table of a part.
"""

import os
import tomllib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import BaseModel, ValidationError

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.case_file import CaseFile, case_text
from exudyn_crawler.case.parameters import base, fields, loads, reading, terrain, track
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.files import whole_file
from meshes import SHOE_SIZES

CYCLE = "file"  # key of the loads that names a file with their cycle
TEXT = {"type": "string", "description": "a number with its unit, such as '20 MN/m'"}
DRAFT = "https://json-schema.org/draft/2020-12/schema"


def read_case(path: str | Path, changes: Iterable[str] = ()) -> CaseFile:
    """Read a case file; paths of mesh, load cycle, measured heights and ruts count from the file's folder.

    `changes` are values in place of the file's, each as ``terrain.spring_stiffness=1e7`` or, of an item of a
    list that the file or a base has, ``loads.phases[0].end=15``. A FileNotFoundError if there is no such
    file, a CaseFileError that names every key at fault by its path, and what is allowed there.
    """

    def values(content: reading.Content) -> reading.Content:
        return _resolved(content, Path(path).parent, [_change(change) for change in changes])

    return reading.read_parameters(path, CaseFile, "case file", values)


def case_of(entry: Any, path: Path) -> CaseFile:
    """Case that a file `path` names, of `Case` or a case file, or has as a table; raises as `read_case`."""
    if isinstance(entry, str) and entry in fields.named_values(Case):
        entry = {fields.BASE: entry}
    if isinstance(entry, str):
        return read_case(path.parent / entry)
    if not isinstance(entry, dict):
        got = "" if entry is None else f", got {entry!r}"
        raise ValueError(f"case must be a case file, the name of a case, or a table of one{got}")
    with reading.errors_named(path, CaseFile):
        return reading.from_content(CaseFile, _resolved(entry, path.parent))


def write_case(
    case_file: CaseFile, path: str | Path, overwrite: bool = False, *, by_hand: bool = False
) -> Path:
    """Write all values with units and meanings; read back, the file gives an equal object.

    One to be changed `by_hand` has units in words and numbers of ten digits. A FileExistsError if the file
    exists and `overwrite` is false.
    """
    path = Path(path)
    with whole_file(path, overwrite) as temporary:
        temporary.write_text(case_text(case_file, by_hand), encoding="utf-8")
    return path


def saved_case(text: str | bytes) -> Case:
    """Case from the JSON in a history or a checkpoint; `ParameterError` if it is none."""
    try:
        return Case.model_validate_json(text)
    except ValidationError as error:
        raise ParameterError("\n".join(base.error_lines(error, Case))) from None


class _Change(NamedTuple):
    """A value and its path in a case file; `key` is the path as it was written."""

    key: str
    path: fields.KeyPath
    value: Any

    def made_in(self, content: reading.Content, kind: type[CaseFile] | None = None) -> reading.Content:
        """Content with the change: tables of a file or, of a `kind`, with what bases give."""
        with fields.errors_at(self.key):
            return fields.with_value(content, self.path, self.value, kind)


def _change(text: str) -> _Change:
    """Change from "key = value" as TOML has it; a key is a path, or its last names where they are unique."""
    key, equals, value = (part.strip() for part in text.partition("="))
    try:
        path = fields.parse_path(key)
    except ValueError:
        equals = ""
    if not equals:
        like = "terrain.spring_stiffness=1e7 or loads.phases[0].end=15"
        raise ValueError(f"a change must be like {like}, got {text!r}")
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
    try:
        content = tomllib.loads(f"value = {value}")
    except (ValueError, RecursionError):
        content = {}
    # a line break could hide more
    return _Change(key, path, content["value"] if len(content) == 1 else value)


def _resolved(content: reading.Content, folder: Path, changes: Sequence[_Change] = ()) -> reading.Content:
    """Values of a file as `CaseFile` takes them: bases filled in, "none" replaced, and changes made."""
    # lists may come from a base
    of_items = [change for change in changes if len(fields.names_of(change.path)) < len(change.path)]
    for change in changes:
        content = content if change in of_items else change.made_in(content)
    table, cycle = content.get("loads"), None
    if isinstance(table, dict) and CYCLE in table:
        if len(table) > 1 or not isinstance(table[CYCLE], str):
            raise ValueError(f"loads.{CYCLE} must be the name of a load cycle and stand alone, got {table!r}")
        cycle = folder / content.pop("loads")[CYCLE]
    content = reading.with_base(content, CaseFile)
    if cycle is not None:
        try:
            read = loads.LoadCycle.from_toml(cycle, _shoe_count(content["case"]))
        except OSError as error:
            raise ValueError(f"loads.{CYCLE}: {error}") from error
        content["case"]["loads"] = read.model_dump(mode="json")
    _spread_equal_loads(content["case"])
    for change in of_items:
        content = change.made_in(content, CaseFile)
        _spread_equal_loads(content["case"])
    flexible = content["case"].get("flexible")
    name = flexible.get("mesh") if isinstance(flexible, dict) else None
    if isinstance(name, str) and name not in SHOE_SIZES:
        # for any text, where Path.is_file raises
        if not os.path.isfile(folder / name):
            raise ValueError(f"flexible.mesh: neither one of {', '.join(SHOE_SIZES)} nor a file: {name!r}")
        flexible["mesh"] = str((folder / name).resolve())
    for key in ("ruts", "relief.measured.file"):
        *tables, last = ("terrain", *key.split("."))
        found = content["case"]
        for table in tables:
            found = (found.get(table) if isinstance(found, dict) else None) or {}
        if isinstance(found, dict) and isinstance(found.get(last), str):
            found[last] = str((folder / found[last]).resolve())
    return content


def _spread_equal_loads(case: reading.Content) -> None:
    """Put one number for the loads on all shoes on each of them."""
    if "loads" in case:
        case["loads"] = loads.with_equal_loads(case["loads"], _shoe_count(case))


def _shoe_count(case: reading.Content) -> int:
    """Number of shoes of the values of a case; one where it is none, which is refused with all else."""
    chain = case.get("track")
    count = chain.get("shoe_count") if isinstance(chain, dict) else None
    return count if isinstance(count, int) and 0 < count <= track.MOST_SHOES else 1


def case_schema() -> dict[str, Any]:
    """JSON schema of what a case file may hold.

    Every key may be left out, a table may name a `base`, a number may be a text with its unit, and "none"
    says that there is none. What values have to be to each other is left to the program.
    """
    whole = CaseFile.model_json_schema()
    kinds = _kinds(CaseFile)
    laws = {one.__name__: one for one in terrain.SoilLaw.plugged_in()}
    parts = whole["$defs"] | {name: one.model_json_schema() for name, one in laws.items()}
    definitions = {name: _table(part, kinds[name]) for name, part in parts.items() if name in kinds}
    definitions["SoilLaw"] = {"anyOf": [{"$ref": f"#/$defs/{name}"} for name in laws]}
    case = definitions.pop("Case")
    properties = case["properties"] | {
        name: _lenient(one) for name, one in whole["properties"].items() if name != "case"
    }
    about = {"$schema": DRAFT, "title": "case file of exudyn-crawler", "type": "object"}
    return about | {"properties": properties, "additionalProperties": False, "$defs": definitions}


def _kinds(kind: type[BaseModel]) -> dict[str, type[BaseModel]]:
    """Parameter classes below one, by name."""
    below = {
        part.__name__: part
        for field in kind.model_fields.values()
        for part in fields.models_of(field.annotation)
    }
    return below | {name: one for part in below.values() for name, one in _kinds(part).items()}


def _table(schema: dict[str, Any], kind: type[BaseModel]) -> dict[str, Any]:
    """Schema of a table of a class: all keys may be left out, and `base` names what gives them."""
    properties = {name: _lenient(one) for name, one in schema["properties"].items()}
    if names := sorted(fields.named_values(kind)):
        properties[fields.BASE] = {"enum": names, "description": "gives all that is left out"}
    kept = {name: one for name, one in schema.items() if name not in ("required", "properties")}
    return kept | {"properties": properties}


def _lenient(schema: Any) -> Any:
    """Schema in which numbers may be texts, "none" is null, and one of several classes any of them."""
    if isinstance(schema, list):
        return [_lenient(one) for one in schema]
    if not isinstance(schema, dict):
        return schema
    changed = {"anyOf" if name == "oneOf" else name: _lenient(one) for name, one in schema.items()}
    if changed.get("default", 0) is None:
        changed["default"] = fields.NONE
    match changed.get("type"):
        case "null":
            return {"const": fields.NONE}
        case "number":
            return {"anyOf": [changed, TEXT], "description": changed.get("description", "")}
        case "array" if "prefixItems" not in changed:
            # one load stands for those of all shoes
            return {
                "anyOf": [changed, {"type": "number"}, TEXT],
                "description": changed.get("description", ""),
            }
    return changed
