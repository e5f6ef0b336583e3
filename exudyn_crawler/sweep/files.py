"""Sweep files: TOML with the case, what of it varies, the design and the answers."""

from pathlib import Path
from typing import Any

from exudyn_crawler.case import Case, CaseFile, read_case
from exudyn_crawler.case.files.errors import toml_content
from exudyn_crawler.case.files.files import case_of, faults_named, from_content, with_base
from exudyn_crawler.case.parameters.paths import BASE, TAG, named_values
from exudyn_crawler.results.life.fatigue_material import FatigueMaterial
from exudyn_crawler.sweep.definition import Sweep
from exudyn_crawler.sweep.vary import content_of
from meshes import SHOE_SIZES

MESH = "flexible.mesh"


def read_sweep(path: str | Path) -> Sweep:
    """Read a sweep file; paths of cases and meshes count from its folder.

    `case` is a case file, the name of a case such as "translation", or a table with the content of a case
    file; the other keys are those of `Sweep`, tables ``[[vary]]`` and ``[[answers]]`` among them.

    Raises
    ------
    FileNotFoundError
        If there is no such file, or no such case file.
    CaseFileError
        Naming everything at fault by its path, and what is allowed there.
    """
    path = Path(path)
    with faults_named(path, Sweep):
        content = toml_content(path, "sweep file")
        if "case" not in content:
            raise ValueError("case must be a case file, the name of a case, or a table of one")
        case_file = _case(content["case"], path)
        for one in content["vary"] if isinstance(content.get("vary"), list) else ():
            _resolve_meshes(one, path.parent)
        whole = content | {"case": content_of(case_file)}
        if isinstance(content.get("answers"), list):
            whole["answers"] = [_answer(one, number) for number, one in enumerate(content["answers"])]
        return from_content(Sweep, whole)


def _case(entry: Any, path: Path) -> CaseFile:
    """Case of a sweep file."""
    if isinstance(entry, str) and entry in named_values(Case):
        entry = {BASE: entry}
    if isinstance(entry, dict):
        return case_of(entry, path)
    if not isinstance(entry, str):
        raise ValueError(f"case must be a case file, the name of a case, or a table of one, got {entry!r}")
    return read_case(path.parent / entry)


def _answer(entry: Any, number: int) -> Any:
    """Answer of a sweep file; one that does not say what it is, is a quantity."""
    if not isinstance(entry, dict):
        return entry
    if isinstance(entry.get("material"), dict):
        place = ("answers", number, "material")
        entry = entry | {"material": with_base(entry["material"], (FatigueMaterial,), {}, place)}
    return {TAG: "quantity", **entry}


def _resolve_meshes(varied: Any, folder: Path) -> None:
    """Put whole paths in place of names of mesh files that vary."""
    if not isinstance(varied, dict):
        return
    if varied.get("key") == MESH and isinstance(varied.get("values"), list):
        varied["values"] = [_resolved(one, folder) for one in varied["values"]]
    if isinstance(varied.get("key"), list) and MESH in varied["key"]:
        place = varied["key"].index(MESH)
        for row in varied["settings"] if isinstance(varied.get("settings"), list) else ():
            if isinstance(row, list) and len(row) > place:
                row[place] = _resolved(row[place], folder)


def _resolved(mesh: Any, folder: Path) -> Any:
    """Whole path of a mesh that is a file."""
    return mesh if mesh in SHOE_SIZES or not isinstance(mesh, str) else str((folder / mesh).resolve())
