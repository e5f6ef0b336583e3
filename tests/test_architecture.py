"""The rooms of the code: arrows one way, no circle, functions that fit a screen, a picture that is true."""

import ast
from collections import Counter

import pytest

from docs import rooms

LONGEST = 80
"""Lines of a function, its docstring included."""
ARGUMENTS = 8
"""Of a compiled function."""
TREES = {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in rooms.modules().items()}


def test_rooms_import_only_what_lies_below_them():
    wrong = [
        f"{a} -> {b}"
        for a, b in rooms.imports()
        if rooms.room_of(a) != rooms.room_of(b) and rooms.room_of(b) not in rooms.allowed(rooms.room_of(a))
    ]
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


def test_no_class_name_stands_twice():
    names = [
        node.name for tree in TREES.values() for node in ast.walk(tree) if isinstance(node, ast.ClassDef)
    ]
    assert {name for name, number in Counter(names).items() if number > 1} == set()


def test_engine_is_imported_in_one_place():
    found = []
    for module, tree in TREES.items():
        for node in ast.walk(tree):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            found += [module for name in names if name.split(".")[0] == "exudyn"]
    assert set(found) == {"exudyn_crawler.model.engine"}


@pytest.mark.parametrize("module", sorted(TREES))
def test_functions_fit_a_screen_and_compiled_ones_take_few_arguments(module):
    functions = [node for node in ast.walk(TREES[module]) if isinstance(node, ast.FunctionDef)]
    assert [one.name for one in functions if one.end_lineno - one.lineno >= LONGEST] == []
    marks = [" ".join(map(ast.unparse, one.decorator_list)) for one in functions]
    compiled = [
        one for one, mark in zip(functions, marks, strict=True) if "compile" in mark or "inlined" in mark
    ]
    assert [one.name for one in compiled if len(one.args.args) > ARGUMENTS] == []


def test_the_handbooks_picture_of_the_rooms_is_up_to_date():
    assert rooms.PICTURE.read_text(encoding="utf-8") == rooms.picture(), "run: python -m docs.rooms"
