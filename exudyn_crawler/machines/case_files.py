"""Case files: all inputs of a run as TOML, and their schema for checks in editors.

A file gives the fields of `Case` and, beside them, `duration` and `[outputs]`, or only the differences from a
`base`. At the top of a file the base is a named case such as "translation". In the table of a part it is a
constructor such as "stress".
"""

import difflib
import json
import tomllib
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Any

from pydantic.json_schema import GenerateJsonSchema

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.gear.dragged import Dragged
from exudyn_crawler.case.parameters import loads, terrain, track
from exudyn_crawler.files import whole_file
from exudyn_crawler.machines import mesh_shoe
from exudyn_crawler.machines.case_file import CaseFile, case_text
from exudyn_crawler.machines.datasheet import files as datasheets
from exudyn_crawler.settings import fields, reading, units

BESIDE = ("duration", "outputs", datasheets.KEY)
"""Keys of a case file beside those of its case."""
FILE_KEY = "file"  # key of the load cycle's file in the loads, and of the law file in a soil law
TEXT = {"type": "string", "description": "a number with its unit, such as '20 MN/m'"}
DRAFT = "https://json-schema.org/draft/2020-12/schema"


def read_case(path: str | Path, changes: Iterable[str] = ()) -> CaseFile:
    """Read a case file; paths of mesh, load cycle, measured heights and ruts start at the file's folder.

    `changes` replace values of the file, each as ``terrain.spring_stiffness=1e7``. For an item of a list in
    the file or a base, the form is ``loads.phases[0].end=15``. Raise `FileNotFoundError` if the file does not
    exist. Raise `CaseFileError` with the path of every wrong key and its allowed values.
    """
    resolved = partial(_resolved, folder=Path(path).parent, changes=changes)
    return reading.read_parameters(path, CaseFile, "case file", resolved)


def case_of(entry: Any, path: Path) -> CaseFile:
    """Return the case named by a file `path`, as a `Case`, a case file or a table; raises as `read_case`."""
    if isinstance(entry, str) and entry in fields.named_values(Case):
        entry = {fields.BASE: entry}
    if isinstance(entry, str):
        named = path.parent / entry
        if not named.exists():
            raise FileNotFoundError(f"{path}: there is no case file {named}")
        return read_case(named)
    if not isinstance(entry, dict):
        got = "" if entry is None else f", got {entry!r}"
        raise ValueError(f"case must be a case file, the name of a case, or a table of one{got}")
    with reading.errors_named(path, CaseFile):
        return reading.from_content(CaseFile, _resolved(entry, path.parent), path.parent)


def write_case(
    case_file: CaseFile, path: str | Path, overwrite: bool = False, *, by_hand: bool = False
) -> Path:
    """Write all values with units and meanings; reading the file gives an equal object.

    A file to be changed `by_hand` has units as text and numbers of ten digits. Raise `FileExistsError` if the
    file exists and `overwrite` is false.
    """
    path = Path(path)
    with whole_file(path, overwrite) as temporary:
        temporary.write_text(case_text(case_file, by_hand), encoding="utf-8")
    return path


def saved_case(text: str | bytes) -> Case:
    """Return the case from the JSON in a history or a checkpoint; raise `ValueError` for other content.

    A case of an earlier version, without the coupling of its pins, had rigid ones.
    """
    content = json.loads(text)
    if isinstance(content, dict) and isinstance(content.get("flexible"), dict):
        content["flexible"].setdefault("pins", "rigid")
    return Case(**content)


def _change(text: str) -> tuple[str, fields.KeyPath, Any]:
    """Return key, path and value of a TOML text "key = value"; unique last names of a path are a key too."""
    key, equals, value = (part.strip() for part in text.partition("="))
    try:
        path = fields.parse_path(key)
    except ValueError:
        equals = ""
    if not equals:
        like = "terrain.spring_stiffness=1e7 or loads.phases[0].end=15"
        raise ValueError(f"a change must be like {like}, got {text!r}")
    return key, _whole_path(key, fields.present_path(CaseFile, path)), typed_value(value)


def typed_value(text: str) -> Any:
    """Return a typed value: a TOML value, or else the text itself, such as a number with a unit."""
    try:
        content = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        content = {}
    # a line break could hide further keys
    return content["value"] if len(content) == 1 else text


def case_of_text(text: str, folder: Path, name: str = "case") -> CaseFile:
    """Return the case of a case file's text, for a name in a folder; raises as `read_case`."""
    path = folder / f"{name}.toml"
    with reading.errors_named(path, CaseFile):
        content = reading.content_of(text)
    return case_of(content, path)


def _whole_path(key: str, path: fields.KeyPath) -> fields.KeyPath:
    """Return the full path of a key in a case file, which may give the last names alone."""
    names = ".".join(fields.names_of(path))
    known = list(fields.key_paths(CaseFile))
    if path[-1] in (fields.BASE, FILE_KEY) or any(f"{choice}.".startswith(f"{names}.") for choice in known):
        return path
    # a datasheet has some names of its own: keys of its values must include the table
    meant = [
        choice
        for choice in known
        if choice.endswith(f".{names}") and not choice.startswith(f"{datasheets.KEY}.")
    ]
    if len(meant) > 1:
        raise ValueError(f"{key}: ambiguous key; give one of {', '.join(meant)}")
    if meant:
        return (*fields.parse_path(meant[0].removesuffix(f".{names}")), *path)
    if renamed := fields.renamed_keys(CaseFile).get(str(path[0])):
        raise ValueError(f"{path[0]}: {renamed}")
    near = difflib.get_close_matches(names, known, n=1)
    raise ValueError(f"{key}: unknown key" + (f"; did you mean {near[0]}?" if near else ""))


def _resolved(content: reading.Content, folder: Path, changes: Iterable[str] = ()) -> reading.Content:
    """Return the values of a file in a folder for `CaseFile`: bases filled in, and changes made."""
    content = dict(content)
    of_items = []
    cycle = None
    if datasheets.has_datasheet(content):
        content = datasheets.with_machine(content)
    for key, path, value in map(_change, changes):
        # lists may come from a base
        if len(fields.names_of(path)) < len(path):
            of_items.append((key, path, value))
        else:
            with fields.errors_at(key):
                content = fields.with_value(content, path, value)
    table = content.get("loads")
    if isinstance(table, dict) and FILE_KEY in table:
        if len(table) > 1 or not isinstance(table[FILE_KEY], str):
            raise ValueError(
                f"loads.{FILE_KEY} must be the name of a load cycle, without other keys, got {table!r}"
            )
        cycle = folder / content.pop("loads")[FILE_KEY]
    beside = {name: content.pop(name) for name in BESIDE if name in content}
    below: reading.Content | None = None
    if datasheets.has_datasheet(beside):
        sheet = datasheets.datasheet_of(beside[datasheets.KEY], folder)
        beside[datasheets.KEY] = sheet.model_dump(mode="json")
        below = datasheets.case_values(sheet, content.get("flexible", fields.NONE) != fields.NONE)
    else:
        content = mesh_shoe.with_mesh_shoe(content, folder)
    content = _with_law(content, folder)
    case = reading.filled(content, Case, below=below)
    if cycle is not None:
        try:
            case["loads"] = loads.LoadCycle.from_file(cycle, _shoe_count(case)).model_dump(mode="json")
        except OSError as error:
            raise ValueError(f"loads.{FILE_KEY}: {error}") from error
    whole = beside | {"case": with_equal_loads(case)}
    for key, path, value in of_items:
        with fields.errors_at(key):
            # the other numbers have the fields' own units by now
            unit = fields.unit_at(CaseFile, path)
            number = value if unit is None else units.number_of(value, unit)
            whole = fields.with_value(whole, path, number, CaseFile)
        whole["case"] = with_equal_loads(whole["case"])
    return whole


def _with_law(content: reading.Content, folder: Path) -> reading.Content:
    """Return the values of a case with its soil law completed from the law file that it names."""
    contact = content.get("contact")
    law = contact.get("law") if isinstance(contact, dict) else None
    if not isinstance(contact, dict) or not isinstance(law, dict) or FILE_KEY not in law:
        return content
    name = f"contact.law.{FILE_KEY}"
    if not isinstance(law[FILE_KEY], str):
        raise ValueError(f"{name} must be the name of a law file, got {law[FILE_KEY]!r}")
    try:
        of_file = reading.toml_content(folder / law[FILE_KEY], "law file")
    except (OSError, ValueError) as error:
        raise ValueError(f"{name}: {error}") from error
    rest = {key: value for key, value in law.items() if key != FILE_KEY}
    return content | {"contact": contact | {"law": of_file | rest}}


def with_equal_loads(case: reading.Content) -> reading.Content:
    """Return the values of a case with a single number of loads applied to each of its shoes.

    The loads of a machine act through its wheels; its shoes have no loads, at any number of shoes.
    """
    if "loads" not in case:
        return case
    count = _shoe_count(case)
    content = loads.with_equal_loads(case["loads"], count)
    gear = case.get("gear")
    if isinstance(gear, dict) and gear.get("kind") not in (None, fields.tag_of(Dragged)):
        content = loads.follow_shoes(content, count)
    return case | {"loads": content}


def _shoe_count(case: reading.Content) -> int:
    """Return the number of shoes in the values of a case; 1 for an invalid one, refused later."""
    chain = case.get("track")
    count = chain.get("shoe_count") if isinstance(chain, dict) else None
    return count if isinstance(count, int) and 0 < count <= track.MOST_SHOES else 1


class _FileSchema(GenerateJsonSchema):
    """Schema of files with a `base` in tables, texts with units for numbers, and "none" for no value."""

    def model_schema(self, schema: Any) -> dict[str, Any]:
        """Return the table of a class with only optional keys."""
        kind = schema["cls"]
        if kind is terrain.SoilLaw:
            laws = kind.plugged_in()
            return {"anyOf": [self.generate_inner(law.__pydantic_core_schema__) for law in laws]}
        table = super().model_schema(schema)
        table.pop("required", None)
        if issubclass(kind, terrain.SoilLaw):
            table["properties"][FILE_KEY] = {
                "type": "string",
                "description": "law file with the values that are not stated",
            }
        if kind is track.Shoe:
            words = (
                "coarse, study, fine or a mesh's file: shoe, pins and flexible shoes are those of the mesh"
            )
            table["properties"][mesh_shoe.KEY] = {"type": "string", "description": words}
        if names := sorted(fields.named_values(kind)):
            table["properties"][fields.BASE] = {
                "enum": names,
                "description": "gives all values that are not stated",
            }
        return table

    def float_schema(self, schema: Any) -> dict[str, Any]:
        """Return the schema of a number or a text with its unit."""
        return {"anyOf": [super().float_schema(schema), TEXT]}

    def tuple_schema(self, schema: Any) -> dict[str, Any]:
        """Return the schema of a list; a single load applies to all shoes."""
        array = super().tuple_schema(schema)
        return array if "prefixItems" in array else {"anyOf": [array, {"type": "number"}, TEXT]}

    def nullable_schema(self, schema: Any) -> dict[str, Any]:
        """Return the schema of a value or "none"."""
        return {"anyOf": [self.generate_inner(schema["schema"]), {"const": fields.NONE}]}

    def tagged_union_schema(self, schema: Any) -> dict[str, Any]:
        """Return the schema of a table of any of several classes; the base may give the tag."""
        return {"anyOf": super().tagged_union_schema(schema)["oneOf"]}

    def encode_default(self, dft: Any) -> Any:
        """Return a default as written in a file."""
        return fields.NONE if dft is None else super().encode_default(dft)


def case_schema() -> dict[str, Any]:
    """Return the JSON schema of a case file.

    Every key may be left out, and a table may name a `base`. A number may be a text with its unit, and "none"
    stands for no value. The program itself checks relations between values.
    """
    whole = CaseFile.model_json_schema(schema_generator=_FileSchema)
    case = whole["$defs"].pop("Case")["properties"]
    beside = whole["properties"]
    about = {"$schema": DRAFT, "title": "case file of exudyn-crawler", "type": "object"}
    properties = case | {name: schema for name, schema in beside.items() if name not in ("case", fields.BASE)}
    return about | {"properties": properties, "additionalProperties": False, "$defs": whole["$defs"]}
