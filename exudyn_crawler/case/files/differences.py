"""What cases have otherwise than others: than the papers' case that is nearest, or than any."""

from typing import NamedTuple

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.files.case_file import CaseFile
from exudyn_crawler.case.files.text import Row, case_rows
from exudyn_crawler.case.parameters.kinds import named_values

ABSENT = "-"
"""In place of a value that the base has not."""


class Beside(NamedTuple):
    """A value of a case beside that of its base, which is empty where it is the same."""

    key: str
    value: str
    in_the_base: str
    unit: str
    meaning: str


class Difference(NamedTuple):
    """A value in which two cases differ."""

    key: str
    first: str
    second: str
    unit: str


def rows_beside_base(case_file: CaseFile) -> tuple[str, list[Beside]]:
    """Every value of a case file beside that of the named case from which the fewest differ.

    Name, duration and outputs are not compared.

    Returns
    -------
    base : str
        Name of that case, as `base` in a case file.
    rows : list of Beside
    """
    own = case_rows(case_file)
    compared = {row.key for row in case_rows(case_file.case)} - {"name"}
    found: dict[str, tuple[int, dict[str, str]]] = {}
    for name, make in named_values(Case).items():
        values = {row.key: row.value for row in case_rows(make())}
        differing = {
            row.key: there
            for row in own
            if row.key in compared and (there := values.get(row.key, ABSENT)) != row.value
        }
        lost = len(values.keys() - {row.key for row in own})
        found[name] = len(differing) + lost, differing
    base = min(found, key=lambda name: found[name][0])
    return base, [Beside(*row[:2], found[base][1].get(row.key, ""), *row[2:]) for row in own]


def parameter_differences(first: Case, second: Case) -> list[Difference]:
    """Values in which two cases differ; their names are not compared."""
    a, b = ({row.key: row for row in case_rows(case)} for case in (first, second))
    rows = []
    for key in dict.fromkeys([*a, *b]):
        row = a.get(key) or b[key]
        one, other = (_value(rows_of, key) for rows_of in (a, b))
        if key != "name" and one != other:
            rows.append(Difference(key, one, other, row.unit))
    return rows


def _value(rows: dict[str, Row], key: str) -> str:
    return rows[key].value if key in rows else ABSENT
