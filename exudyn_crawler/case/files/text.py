"""Case files as text: every value with its unit and meaning; and the same as a table."""

from collections.abc import Iterator
from typing import NamedTuple

import tomlkit
from pydantic import BaseModel

import meshes
from exudyn_crawler.case.case import Case
from exudyn_crawler.case.files.case_file import CaseFile
from exudyn_crawler.case.parameters import fields
from exudyn_crawler.case.parameters.base import StepProfile
from meshes.geometry import VOLUMES

HEAD = 'Case of exudyn-crawler, in SI units; "none" stands for no value.'


def case_text(case_file: CaseFile) -> str:
    """Case file as TOML with a comment for every value."""
    lines = [f"# {line}" for line in (HEAD, *_bases((Case,)))] + [""]
    for entry in fields.walk(case_file):
        if fields.is_table(entry.value):
            lines += _head(entry, entry.value)
        else:
            words = ", ".join(part for part in (entry.unit, entry.meaning) if part)
            name = entry.place[-1]
            lines.append(f"{name} = {_plain(entry.value)}" + (f" # {words}" if words else ""))
    return "\n".join(lines) + "\n"


def _head(entry: fields.Entry, table: BaseModel) -> Iterator[str]:
    """Lines that begin a table: its name, what it is, and the named values that its `base` may take."""
    name = ".".join(part for part in entry.place if isinstance(part, str))
    yield ""
    if isinstance(entry.place[-1], int):
        yield f"[[{name}]]"
        return
    yield f"[{name}]"
    yield f"# {entry.field.description or fields.first_line(type(table))}"
    for line in _bases(fields.models_of(entry.field.annotation)):
        yield f"# {line}"


def _bases(kinds: tuple[type[BaseModel], ...]) -> Iterator[str]:
    names = dict.fromkeys(name for kind in kinds for name in fields.named_values(kind))
    if names:
        yield f"{fields.BASE} = " + " or ".join(f'"{name}"' for name in names) + " gives all that is left out"


def _plain(value: object) -> str:
    """Value as TOML."""
    if isinstance(value, StepProfile):
        parts = (f"{name} = {_plain(getattr(value, name))}" for name in StepProfile.model_fields)
        return f"{{{', '.join(parts)}}}"
    if isinstance(value, tuple):
        return f"[{', '.join(map(_plain, value))}]"
    if isinstance(value, float):
        return fields.number_text(value)
    return tomlkit.item(fields.NONE if value is None else value).as_string()


def shoe_weights(case: Case) -> str:
    """What rigid and flexible shoes of a case weigh, in a line; empty without flexible shoes.

    Rigid shoes have the mass that the case says, flexible ones that of their mesh; raises if there is none.
    """
    if case.flexible is None:
        return ""
    mesh = case.flexible.mesh
    # a case without a mesh of its own need not wait for one to be read
    volume = VOLUMES[mesh] if mesh in VOLUMES else meshes.mesh_named(mesh).volume
    mass = volume * case.flexible.density
    more = 100.0 * (mass / case.shoe.mass - 1.0)
    return (
        f"shoes: rigid ones weigh {case.shoe.mass:.6g} kg each, flexible ones {mass:.6g} kg ({more:+.2g} %), "
        f"as their mesh and density make them"
    )


ABSENT = "-"
"""In place of a value that a case does not have."""


class Difference(NamedTuple):
    """A value in which two cases differ."""

    key: str
    first: str
    second: str
    unit: str

    def __str__(self) -> str:
        return f"{self.key} is {self.first}, not {self.second}"


def differences(first: BaseModel, second: BaseModel) -> list[Difference]:
    """Values in which two cases or case files differ."""
    a, b = (
        {entry.path: entry for entry in fields.walk(one) if not fields.is_table(entry.value)}
        for one in (first, second)
    )
    pairs = {key: (a.get(key), b.get(key)) for key in [*a, *b]}
    return [
        Difference(key, *_texts(one, other), (a.get(key) or b[key]).unit)
        for key, (one, other) in pairs.items()
        if one is None or other is None or one.value != other.value
    ]


def _texts(*entries: fields.Entry | None) -> tuple[str, str]:
    """Two values that differ for reading, with all digits where fewer would hide it."""
    one, other = (ABSENT if entry is None else fields.value_text(entry.value) for entry in entries)
    if one == other:
        one, other = (ABSENT if entry is None else repr(entry.value) for entry in entries)
    return one, other


def nearest_base(case: Case) -> tuple[str, dict[str, str]]:
    """Named case from which the fewest values of a case differ, but for its name, and its values of these."""
    from_bases = {
        name: {one.key: one.first for one in differences(make(), case) if one.key != "name"}
        for name, make in fields.named_values(Case).items()
    }
    base = min(from_bases, key=lambda name: len(from_bases[name]))
    return base, from_bases[base]
