"""Case files as text: every value with its unit and meaning; and the same as a table."""

from collections.abc import Iterator
from typing import NamedTuple

import tomlkit
from pydantic import BaseModel
from tomlkit.items import Array, Float, InlineTable, Item, Trivia

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.files.case_file import CaseFile
from exudyn_crawler.case.parameters.base import StepProfile
from exudyn_crawler.case.parameters.fields import Entry, first_line, is_table, walk
from exudyn_crawler.case.parameters.paths import BASE, NONE, models_of, named_values
from meshes.geometry import VOLUMES

HEAD = 'Case of exudyn-crawler, in SI units; "none" stands for no value.'


def case_text(case_file: CaseFile) -> str:
    """Case file as TOML with a comment for every value."""
    lines = [f"# {line}" for line in (HEAD, *_bases((Case,)))] + [""]
    for entry in walk(case_file):
        if isinstance(entry.value, BaseModel) and is_table(entry.value):
            lines += _head(entry, entry.value)
        else:
            words = ", ".join(part for part in (entry.unit, entry.meaning) if part)
            name = entry.place[-1]
            lines.append(f"{name} = {_plain(entry.value).as_string()}" + (f" # {words}" if words else ""))
    return "\n".join(lines) + "\n"


def _head(entry: Entry, table: BaseModel) -> Iterator[str]:
    """Lines that begin a table: its name, what it is, and the named values that its `base` may take."""
    name = ".".join(part for part in entry.place if isinstance(part, str))
    yield ""
    if isinstance(entry.place[-1], int):
        yield f"[[{name}]]"
        return
    yield f"[{name}]"
    yield f"# {entry.field.description or first_line(type(table))}"
    for line in _bases(models_of(entry.field.annotation)):
        yield f"# {line}"


def _bases(kinds: tuple[type[BaseModel], ...]) -> Iterator[str]:
    names = dict.fromkeys(name for kind in kinds for name in named_values(kind))
    if names:
        yield f"{BASE} = " + " or ".join(f'"{name}"' for name in names) + " gives all that is left out"


def _plain(value: object) -> Item:
    """Value as TOML."""
    if value is None:
        return tomlkit.string(NONE)
    if isinstance(value, bool | int | str):
        return tomlkit.item(value)
    if isinstance(value, float):
        return Float(value, Trivia(), number_text(value))
    if isinstance(value, StepProfile):
        inline: InlineTable = tomlkit.inline_table()
        for name in StepProfile.model_fields:
            inline.append(name, _plain(getattr(value, name)))
        return inline
    if isinstance(value, tuple):
        array: Array = tomlkit.array()
        for one in value:
            array.append(_plain(one))
        return array
    raise TypeError(f"no TOML for {value!r}")


def number_text(value: float) -> str:
    """Shortest text that reads back as the same number: ``20e6`` in place of ``20000000.0``."""
    if abs(value) >= 1e6:
        for power in (9, 6, 3):
            text = f"{value / 10.0**power:.6g}e{power}"
            if abs(value) >= 10.0**power and "e" not in text[:-2] and float(text) == value:
                return text
    return repr(value)


class Row(NamedTuple):
    """A value of a case for reading."""

    key: str
    value: str
    unit: str
    meaning: str


def case_rows(case: BaseModel) -> list[Row]:
    """Every value of a case or a case file."""
    return [
        Row(entry.path, value_text(entry.value), entry.unit, entry.meaning)
        for entry in walk(case)
        if not is_table(entry.value)
    ]


def shoe_weights(case: Case) -> str:
    """What rigid and flexible shoes of a case weigh, in a line; empty without flexible shoes.

    Rigid shoes have the mass that the case says, flexible ones that of their mesh.

    Raises
    ------
    FileNotFoundError, fem.MeshError
        If there is no such mesh.
    """
    if case.flexible is None:
        return ""
    mass = _volume(case.flexible.mesh) * case.flexible.density
    more = 100.0 * (mass / case.shoe.mass - 1.0)
    return (
        f"shoes: rigid ones weigh {case.shoe.mass:.6g} kg each, flexible ones {mass:.6g} kg ({more:+.2g} %), "
        f"as their mesh and density make them"
    )


def _volume(mesh: str) -> float:
    """Volume of a mesh of the shoe, m3."""
    if mesh in VOLUMES:
        return VOLUMES[mesh]
    # an own one is read, which a case without it need not wait for
    from meshes import mesh_named

    return mesh_named(mesh).volume


def value_text(value: object) -> str:
    """Value for reading; equal numbers once."""
    if isinstance(value, StepProfile):
        return ", ".join(f"{v:.8g} at {t:g}" for t, v in zip(value.times, value.values, strict=True))
    if isinstance(value, tuple):
        if len(value) > 3 and len(set(value)) == 1:
            return f"{len(value)} x {value_text(value[0])}"
        return ", ".join(value_text(one) for one in value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return number_text(value) if abs(value) >= 1e6 else f"{value:.8g}"
    return NONE if value is None else str(value)
