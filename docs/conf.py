"""Sphinx' settings of the site: ``sphinx-build -W -c docs . site`` (`make docs`).

The source folder is the whole tree, so that links between files are the same here and where code is read.
"""

import inspect
import sys
import tomllib
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic_core import PydanticUndefined

ROOT = Path(__file__).parents[1]
CONSTANTS, COLON = ("data", "attribute", "property"), "\u2236"
"""Of autodoc; a character in place of a colon that no docstring has."""
sys.path.insert(0, str(ROOT))

project = "exudyn-crawler"
author = project_copyright = "The exudyn-crawler developers"
release = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx-mathjax-offline",
    "sphinx_copybutton",
]
root_doc = "docs/README"
include_patterns = ["*.md", "docs/**", "meshes/*.md", "benchmarks/*.md"]
exclude_patterns = ["docs/site"]
templates_path = ["site/templates"]
html_theme = "furo"
html_title = f"exudyn-crawler {release}"
html_extra_path = ["site/index.html"]
html_static_path: list[str] = []

myst_enable_extensions = ["dollarmath"]
myst_fence_as_directive = ["math"]
myst_heading_anchors = 4
nb_execution_mode = "off"  # notebooks are kept executed, and the tests execute them again

default_role = "py:obj"
autodoc_default_options = {"members": True, "show-inheritance": True, "exclude-members": "model_config"}
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autosummary_imported_members = False
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
napoleon_use_param = False  # words of a description of a type are no references
# a public name stands at its package and in its module, and both are right
suppress_warnings = ["ref.python"]


def _fields(kind: type[BaseModel]) -> list[str]:
    """Parameters of a class with type, unit, default and meaning, as a section of its docstring."""
    lines = ["", "Parameters", "----------"]
    for name, field in kind.__pydantic_fields__.items():
        extra = field.json_schema_extra
        unit = extra.get("unit") if isinstance(extra, dict) else None
        told = [inspect.formatannotation(field.annotation)]
        if unit:
            told.append("dimensionless" if unit == "1" else f"[{unit}]")
        if field.default not in (PydanticUndefined, None):
            told.append(f"default {field.default}")
        lines += [f"{name} : {', '.join(told)}", f"    {field.description or ''}"]
    return [*lines, ""]


def tell_parameters(_app: Any, what: str, _name: str, value: Any, _options: Any, lines: list[str]) -> None:
    """Add the parameters of a class to its docstring, and hide colons of constants from napoleon."""
    if what == "class" and getattr(value, "__pydantic_fields__", None):
        lines += _fields(value)
    if what in CONSTANTS:
        lines[:1] = [line.replace(":", COLON) for line in lines[:1]]


def restore_colons(_app: Any, what: str, _name: str, _value: Any, _options: Any, lines: list[str]) -> None:
    """Restore the colons of constants; napoleon would read the first one as the end of a type."""
    if what in CONSTANTS:
        lines[:] = [line.replace(COLON, ":") for line in lines]


def short_signature(_app: Any, what: str, _name: str, value: Any, *_: Any) -> tuple[str, None] | None:
    """Leave the parameters of a class to the section of its parameters."""
    return ("(**values)", None) if what == "class" and getattr(value, "__pydantic_fields__", None) else None


def setup(app: Any) -> None:
    """Connect both functions: one before numpy's sections are read, one after."""
    app.connect("autodoc-process-docstring", tell_parameters, priority=400)
    app.connect("autodoc-process-docstring", restore_colons, priority=600)
    app.connect("autodoc-process-signature", short_signature)
