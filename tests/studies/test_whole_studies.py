"""The studies at their full length against what the documentation prints of them."""

import re
from pathlib import Path

import pandas as pd
import pytest

from docs.comparison import STUDIES, printed
from exudyn_crawler.views.tables import within_by_class
from studies import forces, kinematics, stress

SUMMARY = (Path(__file__).parents[2] / "docs" / "studies.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def tables(tmp_path_factory) -> dict[str, pd.DataFrame]:
    """Comparison of every study by its name."""
    out = tmp_path_factory.mktemp("results")
    runs, table = kinematics.study(out / "kinematics")
    _, of_forces = forces.study(out / "forces", reuse=out / "kinematics")
    _, of_stress = stress.study(out / "stress")
    assert set(runs) == {"translation", "turning"}
    return {"kinematics": table, "forces": of_forces, "stress": of_stress}


@pytest.mark.slow
@pytest.mark.parametrize("study", list(STUDIES))
def test_every_row_has_the_verdict_that_is_printed(tables, study):
    found, page = tables[study], printed(study)
    names = ["case", "quantity", "statistic"]
    assert found[names].astype(str).to_numpy().tolist() == page[names].to_numpy().tolist()
    assert found["within"].tolist() == page["within"].tolist()


@pytest.mark.slow
@pytest.mark.parametrize("study", list(STUDIES))
def test_the_summary_of_the_studies_counts_these_rows(tables, study):
    line = next(one for one in SUMMARY.splitlines() if one.startswith(f"| {study}, "))
    counted = [
        f"{int(row['within'])} of {int(row['of'])}" for _, row in within_by_class(tables[study]).iterrows()
    ]
    assert sorted(re.findall(r"\d+ of \d+", line)) == sorted(counted)
