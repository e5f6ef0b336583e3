"""Variants and starts of the studies: what counts as an input, and when a run is repeated."""

import numpy as np
import pandas as pd
import pytest

from studies import comparison, variants
from studies.variants import FIRST, STUDIES, counts, evidence, is_within, write_rows

ROWS = pd.DataFrame(
    [
        ("kinematics", "turning", "an input", "max", "m", "statics", 1.0),
        ("kinematics", "turning", "a bounce", "max", "m", "fluctuation", 1.0),
        ("kinematics", "turning", "sideways", "max", "m", "lateral", -1.0),
    ],
    columns=variants.ROW,
)


@pytest.fixture
def table():
    """All runs agree; but one variant bounces three times as much, and the third start twice as much."""
    runs = {run: [1.0, 1.0, 0.1] for run in STUDIES["rigid"].runs}
    runs["no friction"] = [1.05, 3.0, 0.6]
    runs["start 3"] = [1.0, 2.0, 0.1]
    return ROWS.assign(**runs)


def test_a_row_that_all_variants_pass_and_one_that_could_fail_are_told_apart(table):
    told = evidence("rigid", table)
    count = 1 + len(STUDIES["rigid"].variants)
    assert told["within"].tolist() == [count, count - 1, 1]  # lateral: 0.6 of the paper's magnitude
    assert (told["variants"] == count).all()
    assert told["outside"].tolist()[:2] == ["", "no friction"]
    assert (told["starts"] == 16).all()
    assert told[["median", "least", "greatest"]].to_numpy()[1].tolist() == [1.0, 1.0, 2.0]


def test_counts_are_those_of_each_run(table):
    by_run = counts(table).set_index("variant")
    assert by_run.loc[FIRST, "turning fluctuation"] == "1 of 1"
    assert by_run.loc["no friction", "turning fluctuation"] == "0 of 1"
    assert by_run.loc["no friction", "turning lateral"] == "1 of 1"


@pytest.mark.parametrize(("computed", "within"), [(0.6, True), (-1.9, True), (2.1, False), (0.4, False)])
def test_lateral_rows_count_by_their_magnitude_within_a_factor_of_2(computed, within):
    assert is_within(-1.0, computed, "lateral", "m") == within


@pytest.mark.parametrize("name", STUDIES)
@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
def test_every_run_has_another_case(name):
    study = STUDIES[name]
    for make in study.cases.values():
        case = make()
        found = [change(case).model_dump_json() for change in study.runs.values()]
        assert len(set(found)) == len(found)
    assert len(study.runs) == len(study.variants) + study.starts


def test_a_run_is_repeated_only_if_its_cases_have_changed(tmp_path):
    path = tmp_path / "default.json"
    assert not variants._is_of(path, STUDIES["rigid"], FIRST)
    write_rows("rigid", FIRST, ROWS.assign(computed=np.nan), path)
    assert variants._is_of(path, STUDIES["rigid"], FIRST)
    assert not variants._is_of(path, STUDIES["rigid"], "start 2")


def test_every_row_of_the_papers_has_evidence():
    reported = pd.concat([comparison.reported_values(study) for study in ("kinematics", "forces", "stress")])
    kept = pd.read_csv(variants.__file__.replace("variants.py", "evidence.csv"))
    assert kept["quantity"].tolist() == reported["quantity"].tolist()
    assert kept["paper"].tolist() == reported["value"].tolist()
    assert (kept["within"] <= kept["variants"]).all()
    assert ((kept["least"] <= kept["median"]) & (kept["median"] <= kept["greatest"])).all()
