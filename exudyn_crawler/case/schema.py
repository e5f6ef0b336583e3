"""JSON schema of case files, by which editors complete and check them as they are written."""

from typing import Any

from pydantic import BaseModel

from exudyn_crawler.case.case_file import CaseFile
from exudyn_crawler.case.parameters import fields
from exudyn_crawler.case.parameters.cells import SoilLaw

TEXT = {"type": "string", "description": "a number with its unit, such as '20 MN/m'"}
DRAFT = "https://json-schema.org/draft/2020-12/schema"


def case_schema() -> dict[str, Any]:
    """JSON schema of what a case file may hold.

    Every key may be left out, a table may name a `base`, a number may be a text with its unit, and "none"
    says that there is none. What values have to be to each other is left to the program.
    """
    whole = CaseFile.model_json_schema()
    kinds = _kinds(CaseFile)
    laws = {one.__name__: one for one in SoilLaw.plugged_in()}
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
