"""Values of the base that a case file keeps in tables of changed scale, as text."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from exudyn_crawler.case.case import Case
from exudyn_crawler.machines.case_files import read_case
from exudyn_crawler.settings import fields, reading

SCALES = ("mass", "length", "width", "pitch", "radius", "gauge")
"""Endings of the names of quantities that give the size of a part."""
CHANGED = 1.5  # ratio to the base's value, or its inverse, above which a part has another scale
OF_NO_MACHINE = ("terrain", "contact", "drive", "loads", "solver", "flexible", "machine")
"""Tables of a case that do not scale with its machine."""


def unscaled_lines(path: str | Path, changes: Iterable[str] = ()) -> list[str]:
    """Return the unchanged quantities of a file's base in parts of changed scale, a line for each part.

    Parts of the machine that such a file does not mention stay as a whole. The result is empty for a file
    without a base, or with a scale near to that of its base. For `changes` and errors see `read_case`.
    """
    path = Path(path)
    changes = list(changes)
    content = reading.toml_content(path, "case file")
    name = content.get(fields.BASE)
    if name not in fields.named_values(Case):
        return []
    case = read_case(path, changes).case
    base = fields.named_values(Case)[name]()
    in_file = {fields.present_path(Case, place) for place in reading.stated(content)}
    tables = _tables(case)
    of_base = {entry.path: entry for entry in fields.values_of(base)}
    scaled = {table: _scaled(entries, of_base) for table, entries in tables.items()}
    if not any(scaled.values()):
        return []
    lines = []
    for table, entries in tables.items():
        stays = [entry for entry in entries if _is_kept(entry, of_base, in_file)]
        names = ", ".join(str(entry.place[-1]) for entry in stays)
        if stays and scaled[table]:
            other = ", ".join(_in_both(entry, of_base[entry.path]) for entry in scaled[table])
            lines.append(f"{table}: {other}; from the base {name!r} stay {names}")
        elif stays and len(stays) == sum(_is_size(entry) for entry in entries):
            lines.append(f"{table}: all of it stays that of the base {name!r}")
    return lines


def _tables(case: Case) -> dict[str, list[fields.Item]]:
    """Return the values of the machine's parts by the paths of their tables."""
    tables: dict[str, list[fields.Item]] = {}
    for entry in fields.values_of(case):
        if len(entry.place) > 1 and entry.place[0] not in OF_NO_MACHINE:
            tables.setdefault(fields.path_text(entry.place[:-1]), []).append(entry)
    return tables


def _scaled(entries: Iterable[fields.Item], of_base: Mapping[str, fields.Item]) -> list[fields.Item]:
    """Return the sizes that differ much from those of the base."""
    others = []
    for entry in entries:
        before = of_base.get(entry.path)
        is_scale = str(entry.place[-1]).endswith(SCALES) and fields.is_number(entry.value)
        if before is None or not is_scale or not fields.is_number(before.value) or not before.value:
            continue
        ratio = abs(entry.value / before.value)
        if not 1.0 / CHANGED <= ratio <= CHANGED:
            others.append(entry)
    return others


def _is_size(entry: fields.Item) -> bool:
    """Return True for a nonzero quantity with a unit, other than a turning rate: no size gives it."""
    numbers = entry.value if isinstance(entry.value, tuple) else (entry.value,)
    return entry.unit not in ("", None, "rad/s") and any(number not in (None, 0.0, 0) for number in numbers)


def _is_kept(entry: fields.Item, of_base: Mapping[str, fields.Item], in_file: set[fields.KeyPath]) -> bool:
    """Return True for a quantity of the base that the file does not state."""
    before = of_base.get(entry.path)
    return (
        before is not None and _is_size(entry) and entry.value == before.value and entry.place not in in_file
    )


def _in_both(entry: fields.Item, before: fields.Item) -> str:
    """Return the values in the file and in the base as text."""
    texts = (fields.value_text(each.value, each.unit) for each in (entry, before))
    return f"{entry.place[-1]} {' in place of '.join(texts)}"
