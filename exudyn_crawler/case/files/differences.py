"""In what cases differ: from the papers' case that is nearest, or from any."""

from typing import NamedTuple

from pydantic import BaseModel

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.files.case_file import CaseFile
from exudyn_crawler.case.files.text import case_rows, value_text
from exudyn_crawler.case.parameters.fields import Entry, is_table, walk
from exudyn_crawler.case.parameters.kinds import named_values

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


class Beside(NamedTuple):
    """A value of a case beside that of its base, which is empty where it is the same."""

    key: str
    value: str
    in_the_base: str
    unit: str
    meaning: str


def differences(first: BaseModel, second: BaseModel) -> list[Difference]:
    """Values in which two cases or case files differ."""
    a, b = (
        {entry.path: entry for entry in walk(one) if not is_table(entry.value)} for one in (first, second)
    )
    found = []
    for key in dict.fromkeys([*a, *b]):
        one, other = a.get(key), b.get(key)
        if one is None or other is None or one.value != other.value:
            found.append(Difference(key, *_texts(one, other), (a.get(key) or b[key]).unit))
    return found


def _texts(*entries: Entry | None) -> tuple[str, str]:
    """Two values that differ for reading, with all digits where fewer would hide it."""
    one, other = (ABSENT if entry is None else value_text(entry.value) for entry in entries)
    if one == other:
        one, other = (ABSENT if entry is None else repr(entry.value) for entry in entries)
    return one, other


def parameter_differences(first: BaseModel, second: BaseModel) -> list[Difference]:
    """Values in which two cases differ but for their names."""
    return [one for one in differences(first, second) if one.key != "name"]


def rows_beside_base(case_file: CaseFile) -> tuple[str, list[Beside]]:
    """Every value of a case file beside that of the named case from which the fewest differ.

    Name, duration and outputs are not compared.

    Returns
    -------
    base : str
        Name of that case, as `base` in a case file.
    rows : list of Beside
    """
    from_bases = {
        name: {one.key: one.first for one in parameter_differences(make(), case_file.case)}
        for name, make in named_values(Case).items()
    }
    base = min(from_bases, key=lambda name: len(from_bases[name]))
    return base, [
        Beside(*row[:2], from_bases[base].get(row.key, ""), *row[2:]) for row in case_rows(case_file)
    ]
