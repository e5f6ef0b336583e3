"""Numbers of results on pages are those of the tables in `docs/numbers`."""

import re

import pandas as pd
import pytest

from docs import comparison, numbers


def test_marked_numbers_of_all_pages_are_those_of_the_tables():
    marked = 0
    for path in numbers.PAGES:
        text = path.read_text(encoding="utf-8")
        marked += len(numbers.MARKED.findall(text))
        drift = [
            f"{path.name}: {old} is now {new}"
            for old, new in zip(text.splitlines(), numbers.filled(text).splitlines(), strict=True)
            if old != new
        ]
        assert drift == [], "renew them with: python -m docs.numbers"
        # a mark that is not read would never be renewed
        assert len(re.findall(r"<!-- \w+\.csv:", text)) == len(numbers.MARKED.findall(text)), path
    assert marked > 20


@pytest.fixture
def table(monkeypatch):
    """Table in place of the kept ones."""
    monkeypatch.setattr(numbers, "values", {"stress": {"shoe 13": "199.7996", "rows": "3 of 4"}}.__getitem__)


def test_a_number_keeps_the_decimals_of_the_page(table):
    old = "<!-- stress.csv: shoe 13 -->187<!-- --> MPa, <!-- stress.csv: shoe 13 -->187.1<!-- --> MPa"
    assert numbers.filled(old) == old.replace("187.1", "199.8").replace("187", "200")


def test_words_are_taken_as_they_are(table):
    old = "<!-- stress.csv: rows -->2 of 4<!-- -->, <!-- stress.csv: rows -->?<!-- -->"
    assert numbers.filled(old) == old.replace("2 of 4", "3 of 4").replace("?", "3 of 4")


def test_an_unknown_number_is_refused(table):
    with pytest.raises(KeyError, match="shoe 99"):
        numbers.filled("<!-- stress.csv: shoe 99 -->187<!-- -->")


def test_counts_and_evidence_are_those_of_the_printed_comparison():
    kept = numbers.values("counts")
    evidence = pd.read_csv(numbers.EVIDENCE)
    for study in comparison.STUDIES:
        page = comparison.printed(study)
        for kind, rows in page[page["within"] != ""].groupby("class"):
            assert kept[f"{study} {kind}"] == f"{(rows['within'] == 'yes').sum()} of {len(rows)}"
        of_study = evidence[evidence["study"] == study]
        told = of_study["within"].astype(str) + " of " + of_study["variants"].astype(str)
        assert page["variants"].tolist() == told.tolist()
