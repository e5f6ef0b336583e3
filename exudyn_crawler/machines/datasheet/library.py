"""Library of machines as files: datasheets with their sources, as starting points and examples."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from exudyn_crawler.errors import ParameterError, did_you_mean
from exudyn_crawler.machines.datasheet.sheet import FIGURES, Datasheet
from exudyn_crawler.settings import fields, reading

NAME = re.compile(r"^name\s*=.*$")
FOLDER = Path(__file__).with_name("library")
ANOTHER = 0.2
"""Relative change of weight or shoe above which a machine differs from the library's."""
SCALES = ("operating_weight", "shoe_width", "pitch", "shoe_weight")
"""Figures that give the size of a machine and its shoe."""


@cache
def machines() -> dict[str, Path]:
    """Return the files of the library by name."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.toml"))}


def machine_content(name: object) -> reading.Content:
    """Return the content of a machine's file; raise a `ParameterError` that lists the known names."""
    known = machines()
    if isinstance(name, str) and name in known:
        return reading.toml_content(known[name], "datasheet")
    hint = did_you_mean(name, known)
    raise ParameterError(f"datasheet.base: no {name!r}; {hint}allowed are {', '.join(map(repr, known))}")


@dataclass(frozen=True)
class LibraryMachine:
    """Machine of the library, as the origin of values in a file that began as it."""

    title: str
    sheet: Datasheet
    content: reading.Content

    @property
    def source(self) -> str:
        """Title of the machine, and the source of its figures."""
        source = self.sheet.source
        return source if source.startswith(self.title) else f"{self.title}: {source}"


@cache
def library_machine(name: str) -> LibraryMachine:
    """Return a machine of the library by its name."""
    content = machine_content(name)
    return LibraryMachine(content["name"], reading.from_content(Datasheet, content["datasheet"]), content)


def beginning(sheet: Datasheet) -> LibraryMachine | None:
    """Return the library's machine that a datasheet began as: the named one, or the one of its source."""
    if sheet.began_as is not None:
        return library_machine(sheet.began_as)
    known = map(library_machine, machines())
    return next((machine for machine in known if machine.sheet.source == sheet.source), None)


def text_of(machine: str, name: str) -> str:
    """Return the text of a case file of a name that begins as a machine of the library."""
    lines = machines()[machine].read_text(encoding="utf-8").splitlines()
    about = next(number for number, line in enumerate(lines) if not line.startswith("#"))
    head = [
        f"# {name}, begun as the library's {library_machine(machine).title}: what you change is yours.",
        *(["# Of that machine:", *lines[:about]] if about else []),
    ]
    rest = [NAME.sub(f'name = "{name}"', line) for line in lines[about:]]
    rest.insert(rest.index("[datasheet]") + 1, f'began_as = "{machine}"')
    return "\n".join([*head, *rest]) + "\n"


def over(content: Mapping[str, Any], below: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of a file merged over that of its base machine; tables are merged key by key."""
    merged = dict(below)
    for name, value in content.items():
        before = merged.get(name)
        merged[name] = over(value, before) if isinstance(value, dict) and isinstance(before, dict) else value
    return merged


def left_of_library(sheet: Datasheet) -> Iterator[str]:
    """Yield a line on figures left from the library's machine in the datasheet of another machine."""
    machine = beginning(sheet)
    if machine is None:
        return
    changes = []
    for name in SCALES:
        own, before = getattr(sheet, name), getattr(machine.sheet, name)
        if own and before and not 1.0 / (1.0 + ANOTHER) <= own / before <= 1.0 + ANOTHER:
            unit = fields.unit_of(Datasheet.model_fields[name])
            texts = (fields.quantity_text(value, unit) for value in (own, before))
            changes.append(f"{name} {' in place of '.join(texts)}")
    stays = [
        name
        for name in FIGURES
        if getattr(sheet, name) not in (None, Datasheet.model_fields[name].default)
        and getattr(sheet, name) == getattr(machine.sheet, name)
    ]
    if changes and stays:
        yield (
            f"this is another machine than the library's {machine.title} ({', '.join(changes)}), of which "
            f"are left: {', '.join(stays)}; give this machine's own, or leave them out"
        )
