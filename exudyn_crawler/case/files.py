"""Case files: everything that a run depends on, as TOML, and their schema, by which editors check them.

A file gives the fields of `Case` and, beside them, `duration` and `[outputs]`, or what of them differs from a
`base`: a named case such as "translation" at its top, a constructor such as "stress" in the table of a part.
"""

import os
import tomllib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError
from pydantic.json_schema import GenerateJsonSchema

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


class _FileSchema(GenerateJsonSchema):
    """Schema of files whose tables have a `base`, texts with units for numbers, and "none" for no value."""

    def model_schema(self, schema: Any) -> dict[str, Any]:
        """Table of a class, all of whose keys may be left out."""
        kind = schema["cls"]
        if kind is terrain.SoilLaw:
            laws = kind.plugged_in()
            return {"anyOf": [self.generate_inner(law.__pydantic_core_schema__) for law in laws]}
        found = super().model_schema(schema)
        found.pop("required", None)
        if names := sorted(fields.named_values(kind)):
            found["properties"][fields.BASE] = {"enum": names, "description": "gives all that is left out"}
        return found

    def float_schema(self, schema: Any) -> dict[str, Any]:
        """Number, or a text with its unit."""
        return {"anyOf": [super().float_schema(schema), TEXT]}

    def tuple_schema(self, schema: Any) -> dict[str, Any]:
        """List; one load stands for those of all shoes."""
        found = super().tuple_schema(schema)
        return found if "prefixItems" in found else {"anyOf": [found, {"type": "number"}, TEXT]}

    def nullable_schema(self, schema: Any) -> dict[str, Any]:
        """Value, or "none"."""
        return {"anyOf": [self.generate_inner(schema["schema"]), {"const": fields.NONE}]}

    def tagged_union_schema(self, schema: Any) -> dict[str, Any]:
        """Table of any of several classes: what tells them apart may come from the base."""
        return {"anyOf": super().tagged_union_schema(schema)["oneOf"]}

    def encode_default(self, dft: Any) -> Any:
        """Default as a file has it."""
        return fields.NONE if dft is None else super().encode_default(dft)


def case_schema() -> dict[str, Any]:
    """JSON schema of what a case file may hold.

    Every key may be left out, a table may name a `base`, a number may be a text with its unit, and "none"
    says that there is none. What values have to be to each other is left to the program.
    """
    whole = CaseFile.model_json_schema(schema_generator=_FileSchema)
    case, beside = whole["$defs"].pop("Case")["properties"], whole["properties"]
    about = {"$schema": DRAFT, "title": "case file of exudyn-crawler", "type": "object"}
    properties = case | {name: one for name, one in beside.items() if name not in ("case", fields.BASE)}
    return about | {"properties": properties, "additionalProperties": False, "$defs": whole["$defs"]}
