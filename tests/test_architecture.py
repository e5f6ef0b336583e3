"""The rooms of the code: imports go one way, no circle, a picture that is true."""

import ast
import itertools
import re
from pathlib import Path

from docs import rooms

PICKLES = {"pickle", "cloudpickle", "dill", "joblib", "marshal", "shelve"}


def trees() -> dict[str, ast.Module]:
    """Syntax trees of all modules by their names."""
    return {name: rooms.tree(path) for name, path in rooms.modules().items()}


def test_rooms_import_only_what_lies_below_them():
    wrong = [
        f"{a} -> {b}"
        for a, b in rooms.imports()
        if rooms.room_of(a) != rooms.room_of(b) and rooms.room_of(b) not in rooms.allowed(rooms.room_of(a))
    ]
    assert wrong == []


def imported(node: ast.AST) -> list[str]:
    """Modules that a node of a module's tree imports."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    return [node.module or ""] if isinstance(node, ast.ImportFrom) else []


def test_no_module_reads_pickles_or_runs_text():
    """Files of others, such as checkpoints, meshes and maps, may hold anything."""
    wrong = []
    for name, tree in trees().items():
        for node in ast.walk(tree):
            wrong += [
                f"{name} imports {module}" for module in imported(node) if module.split(".")[0] in PICKLES
            ]
            if isinstance(node, ast.keyword) and node.arg == "allow_pickle":
                wrong.append(f"{name} has allow_pickle")
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("eval", "exec"):
                wrong.append(f"{name} calls {node.func.id}")
    assert wrong == []


def test_no_modules_import_each_other_in_a_circle():
    below: dict[str, set[str]] = {}
    for a, b in rooms.imports():
        if not b.endswith("__init__"):
            below.setdefault(a, set()).add(b)

    def reached(start: str) -> set[str]:
        found, todo = set(), list(below.get(start, ()))
        while todo:
            one = todo.pop()
            if one not in found:
                found.add(one)
                todo += below.get(one, ())
        return found

    assert [module for module in rooms.modules() if module in reached(module)] == []


def test_every_room_stands_on_a_floor():
    known = {room for floor in rooms.FLOORS for room in floor} | set(rooms.SHARED) | {rooms.FACE}
    assert {rooms.room_of(module) for module in rooms.modules()} == known


def test_engine_is_imported_in_one_place():
    found = []
    for module, tree in trees().items():
        for node in ast.walk(tree):
            found += [module for name in imported(node) if name.split(".")[0] == "exudyn"]
    assert set(found) == {"exudyn_crawler.model.exudyn"}


def test_texts_that_name_modules_count_as_imports():
    assert ("tests.one", "fem.body.mesh") in rooms.imports_of(
        "tests.one", ast.parse("NAME = 'fem.body.mesh'")
    )


def test_the_table_of_rooms_names_all_that_a_room_imports():
    """Named rooms, with "below" all floors below the highest named one, and what any room may import."""
    head = "| room | content | imports from |"
    rows = Path("docs/architecture.md").read_text(encoding="utf-8").partition(head)[2].splitlines()[2:]
    cells = {}
    for row in itertools.takewhile(lambda line: line.startswith("|"), rows):
        names, *_, cell = row.strip("| ").split("|")
        cells |= dict.fromkeys(re.findall(r"`(\w+)(?:/|\.py)`", names), cell)
    assert set(cells) == {room for floor in rooms.FLOORS for room in floor} | set(rooms.SHARED)
    floor = {room: k for k, row in enumerate(rooms.FLOORS) for room in row}
    for room, cell in cells.items():
        named = set(re.findall(r"`(\w+)`", cell))
        if "below" in cell:
            highest = min((floor[one] for one in named), default=floor[room])
            named |= {one for one, k in floor.items() if k > highest}
        found = {b for a, b in rooms.arrows() if a == room}
        assert found <= named | set(rooms.SHARED) | {rooms.FACE}, (room, found - named)
        assert named <= set(floor) | set(rooms.SHARED), room


SUMS = ("exudyn_crawler.model.equations", "exudyn_crawler.model.newton")
"""Sums over rows, which know no kind of joint or force."""


def test_sums_name_no_kind_of_joint_or_force():
    files = {
        module.rpartition(".")[2]
        for module, tree in trees().items()
        if module.startswith(("exudyn_crawler.model.joints.", "exudyn_crawler.model.forces."))
        if any(isinstance(node, ast.FunctionDef) and node.name == "write_rows" for node in tree.body)
    }
    assert {"pin", "drive", "motor", "units", "cells", "teeth", "wheels"} <= files
    nodes = [node for module in SUMS for node in ast.walk(trees()[module])]
    names = {node.id for node in nodes if isinstance(node, ast.Name)}
    names |= {node.attr for node in nodes if isinstance(node, ast.Attribute)}
    names |= {node.arg for node in nodes if isinstance(node, ast.arg)}
    names |= {alias.name for node in nodes if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert {name for name in names for kind in files if kind in name.lower()} == set()


def test_the_handbooks_picture_of_the_rooms_is_up_to_date():
    assert rooms.PICTURE.read_text(encoding="utf-8") == rooms.picture(), "run: python -m docs.rooms"
