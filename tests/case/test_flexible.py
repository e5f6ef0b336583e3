"""Choice of the modes of flexible shoes."""

import pytest

from exudyn_crawler import FlexibleShoes
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
