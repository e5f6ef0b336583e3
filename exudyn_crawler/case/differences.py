"""What cases have otherwise than others: than the papers' case that is nearest, or than any."""

import pandas as pd

from exudyn_crawler.case.case import Case
from exudyn_crawler.case.case_file import CaseFile
from exudyn_crawler.case.fields import named_values
from exudyn_crawler.case.text import case_table

ABSENT = "-"
"""In place of a value that the base has not."""


def table_beside_base(case_file: CaseFile) -> tuple[str, pd.DataFrame]:
    """Every value of a case file beside that of the named case from which the fewest differ.

    Name, duration and outputs are not compared.

    Returns
    -------
    base : str
        Name of that case, as `base` in a case file.
    table : pandas.DataFrame
        Columns key, value, "in the base" (the base's value where it differs, else empty), unit and meaning.
    """
    own = case_table(case_file)
    compared = (own["key"] != "name") & own["key"].isin(case_table(case_file.case)["key"])
    found: dict[str, tuple[int, pd.Series]] = {}
    for name, make in named_values(Case).items():
        values = case_table(make()).set_index("key")["value"]
        there = own["key"].map(values).fillna(ABSENT)
        differing = compared & (there != own["value"])
        lost = len(set(values.index) - set(own["key"]))
        found[name] = int(differing.sum()) + lost, there.where(differing, "")
    base = min(found, key=lambda name: found[name][0])
    own.insert(2, "in the base", found[base][1])
    return base, own


def parameter_differences(first: Case, second: Case) -> pd.DataFrame:
    """Values in which two cases differ: columns key, A, B, unit; their names are not compared."""
    a, b = (case_table(case).set_index("key") for case in (first, second))
    keys = [key for key in dict.fromkeys([*a.index, *b.index]) if key != "name"]
    table = pd.DataFrame(
        {
            "key": keys,
            "A": a["value"].reindex(keys).fillna(ABSENT).tolist(),
            "B": b["value"].reindex(keys).fillna(ABSENT).tolist(),
            "unit": a["unit"].reindex(keys).fillna(b["unit"].reindex(keys)).tolist(),
        }
    )
    return table[table["A"] != table["B"]].reset_index(drop=True)
