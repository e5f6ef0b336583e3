"""Modes of flexible shoes, and their damping."""

import json

import pytest

from exudyn_crawler import Case, FlexibleShoes, StepProfile
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.machines import saved_case
from exudyn_crawler.results.checks.cases import ShoeCheck, check_of
from studies.stress import with_modes

COARSE = FlexibleShoes.ph4100c("coarse")


def test_modes_are_chosen_by_kind_or_number():
    assert COARSE.mode_count == 30
    assert with_modes(COARSE, "all").mode_count == 94
    assert with_modes(COARSE, "20 fixed").mode_count == 38
    assert with_modes(COARSE, "1-094").modes == tuple(range(1, 95))


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ("some", "modes must be like"),
        ("0-3", r"modes must be in 1\.\.94"),
        ("95", r"modes must be in 1\.\.94, got 95$"),
        ("3,1-95", r"modes must be in 1\.\.94, got 95$"),
        # refused before they are listed
        ("1-9999999999", r"modes must be in 1\.\.94, got 9+$"),
        ("1-" + "9" * 5000, r"modes must be in 1\.\.94, got 9+$"),
        ("77 fixed", "fixed_modes must not exceed recovered_modes"),
    ],
)
def test_modes_that_do_not_exist_are_refused(choice, message):
    with pytest.raises(ValueError, match=message):
        with_modes(COARSE, choice)


@pytest.mark.parametrize(
    ("profile", "told"),
    [
        (
            StepProfile(times=(-1000.0, 10000.0), values=(0.005, 1.0)),
            "damping frequencies must not be negative",
        ),
        (StepProfile(times=(1000.0, 10000.0), values=(-0.005, 1.0)), "damping ratios must not be negative"),
    ],
)
def test_damping_has_neither_negative_frequencies_nor_ratios(profile, told):
    with pytest.raises(ParameterError, match=told):
        COARSE.with_(damping=profile)


def test_pins_are_averaging_where_no_paper_says_rigid():
    stated = COARSE.model_dump()
    assert stated.pop("pins") == "rigid"
    assert FlexibleShoes(**stated).pins == ShoeCheck().pins == "averaging"
    assert check_of(Case.stress("coarse")).pins == "rigid"
    assert ShoeCheck(spider="rigid").pins == "rigid"  # a file of an earlier version


def test_a_stored_case_of_an_earlier_version_has_rigid_pins():
    earlier = json.loads(Case.stress("coarse").model_dump_json())
    del earlier["flexible"]["pins"]
    assert saved_case(json.dumps(earlier)) == Case.stress("coarse")
