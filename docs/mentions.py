"""Names in backquotes that pages and docstrings mention, held against the code.

A page may mention a module's path, a file, a class with a member, a key of a case file or a quantity of
histories; all but files that a run leaves are looked up. Nothing is imported: the code is read as text.
"""

import ast
import builtins
import csv
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path, PurePosixPath

from docs import rooms

PAGES = sorted(
    path
    for pattern in ("*.md", "docs/**/*.md", "meshes/**/*.md", "benchmarks/**/*.md")
    for path in rooms.ROOT.glob(pattern)
)
SOURCES = ("exudyn_crawler", "fem", "meshes", "studies", "tests", "docs", "benchmarks", ".ci")
"""Folders whose files exist in a clone; all other paths are those of runs."""
ROOMS = {room for floor in rooms.FLOORS for room in floor} - {"results"}
"""First folders of paths of the code; runs have a folder `results`, too."""
OF_RUNS = [
    "csv",
    "gz",
    "html",
    "json",
    "log",
    "mp4",
    "pdf",
    "nc",
    "npz",
    "png",
    "pvd",
    "toml",
    "vtu",
    "xlsx",
    "inp",
    "frd",
    "msh",
    "med",
    "bdf",
    "cpp",
    "step",
    "stl",
    "asc",
    "npy",
    "tif",
]
"""Endings of files that a run leaves or a user brings."""
FOREIGN = [
    "fmpy",
    "h5netcdf",
    "matplotlib",
    "meshio",
    "mjData",
    "mjModel",
    "netgen",
    "numba",
    "numpy",
    "pandas",
    "plotly",
    "pydantic",
    "pylife",
    "scipy",
    "skfem",
    "xarray",
]
"""First parts of names of other packages."""
OPTIONS = {"Mesh.SaveAll"}
"""Options of gmsh."""
FOREIGN_CLASS = re.compile(
    "(Ch|Object|Node|Marker|MainSolver)[A-Z].*|NodeRecord|GeneralContact|SolveDynamic|SolveSteps|UpdateContacts"
    "|LinAlgError|ValidationError"
)
"""Classes and functions of Chrono, Exudyn and others."""
MENTION = re.compile(r"(?<!`)`([^`\n]+)`(?!`)|``([^`\n]+)``")
DOTTED = re.compile(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)+(?:\(\))?")
PATH = re.compile(r"[\w.-]+(?:/[\w.-]+)*/?")
CLASS = re.compile(r"[A-Z][a-z]+(?:[A-Z][a-z]*)+")
CALL = re.compile(r"[a-z_]\w*\(\)")
FENCE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)


def mentions() -> Iterator[tuple[str, str]]:
    """Names in backquotes: (where, name)."""
    for page in PAGES:
        if page.name != "CHANGELOG.md":  # tells of names that are gone
            yield from _names_of(page, FENCE.sub("", page.read_text(encoding="utf-8")))
    for path in rooms.modules().values():
        for node in ast.walk(rooms.tree(path)):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield from _names_of(path, node.value)


def _names_of(path: Path, text: str) -> Iterator[tuple[str, str]]:
    where = path.relative_to(rooms.ROOT).as_posix()
    yield from ((where, single or double) for single, double in MENTION.findall(text))


def _targets(node: ast.stmt) -> list[str]:
    """Names that a statement of a module's or a class's body binds."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return [node.name]
    if isinstance(node, ast.AnnAssign):
        return [ast.unparse(node.target)]
    if isinstance(node, ast.Assign):
        return [name.id for target in node.targets for name in ast.walk(target) if isinstance(name, ast.Name)]
    if isinstance(node, ast.Import | ast.ImportFrom):
        return [alias.asname or alias.name for alias in node.names]
    if isinstance(node, ast.If):
        return [name for part in node.body for name in _targets(part)]
    return []


@cache
def classes() -> dict[str, ast.ClassDef]:
    """Return the classes of the code by their names, which are unique."""
    nodes = (node for path in rooms.modules().values() for node in ast.walk(rooms.tree(path)))
    return {node.name: node for node in nodes if isinstance(node, ast.ClassDef)}


@cache
def members(name: str) -> frozenset[str]:
    """Attributes of a class and of those classes of the code that it is made from."""
    node = classes()[name]
    names = {target for part in node.body for target in _targets(part)}
    names |= {
        target.attr
        for target in ast.walk(node)
        if isinstance(target, ast.Attribute) and isinstance(target.ctx, ast.Store)
    }
    bases = [ast.unparse(base).split(".")[-1].split("[")[0] for base in node.bases]
    return frozenset(names).union(*(members(base) for base in bases if base in classes()))


@cache
def all_members() -> frozenset[str]:
    """Attributes of all classes."""
    return frozenset().union(*map(members, classes()))


@cache
def module_names(module: str) -> frozenset[str]:
    """Names that a module defines or imports."""
    path = rooms.modules()[module]
    names = [name for node in rooms.tree(path).body for name in _targets(node)]
    stub = path.with_suffix(".pyi")
    if stub.exists():
        names += [name for node in rooms.tree(stub).body for name in _targets(node)]
    return frozenset(names)


@cache
def definitions() -> frozenset[str]:
    """Names that any module defines or imports."""
    return frozenset().union(*map(module_names, rooms.modules()))


@cache
def quantities() -> frozenset[str]:
    """Names of the quantities of histories, and of the contacts' numbers."""
    table = rooms.ROOT / rooms.PACKAGE / "results" / "history" / "quantities.csv"
    with table.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return frozenset(row["name"] for row in rows) | {"contact_shoe", "contact_unit", "contact_finger"}


def is_known(name: str) -> bool:
    """True where a name leads to something of the code, or is none that could be looked up."""
    if PATH.fullmatch(name) and ("/" in name or name.endswith(".py")):
        return _is_file(name)
    if (rooms.ROOT / name).exists():
        return True
    if DOTTED.fullmatch(name):
        parts = name.removesuffix("()").split(".")
        is_foreign = parts[0] in FOREIGN or parts[-1] in OF_RUNS or name in OPTIONS
        return is_foreign or _is_attribute(parts) or _is_in_module(parts)
    if CLASS.fullmatch(name):
        return name in definitions() or hasattr(builtins, name) or bool(FOREIGN_CLASS.fullmatch(name))
    if CALL.fullmatch(name):
        return name.removesuffix("()") in definitions() | all_members()
    return True


def _is_file(name: str) -> bool:
    """True for a path of a clone, which may leave out its first folders, and for one of a run."""
    path = PurePosixPath(name)
    known = [path, *(PurePosixPath(folder) / path for folder in SOURCES)]
    if any((rooms.ROOT / place).exists() for place in known):
        return True
    inside = [found for folder in SOURCES for found in (rooms.ROOT / folder).rglob(path.name)]
    if any(found.as_posix().endswith(f"/{path}") for found in inside):
        return True
    return path.suffix != ".py" and path.parts[0] not in SOURCES and path.parts[0] not in ROOMS


def _is_in_module(parts: list[str]) -> bool:
    """True for a module, which may leave out its first packages, or a name in it with an attribute."""
    for count in range(len(parts), 0, -1):
        tail = ".".join(parts[:count])
        for module in rooms.modules():
            if module == tail or module.endswith(f".{tail}"):
                rest = parts[count:]
                if not rest:
                    return True
                if rest[0] in module_names(module):
                    return len(rest) == 1 or _is_attribute(rest) or rest[1] in all_members()
    return False


def _is_attribute(parts: list[str]) -> bool:
    """True for a class with a member, a quantity of a history, or a member of an object of any class."""
    if parts[0] in classes():
        return parts[1] in members(parts[0])
    if parts[0] == "history":
        return parts[-1] in quantities() | members("History")
    return not parts[0][0].isupper() and all(part in all_members() for part in parts[1:])
