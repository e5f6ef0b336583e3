"""Datasheets at random: each is refused in a sentence, or a machine follows that weighs what it says."""

import numpy as np
import pytest

from exudyn_crawler.case.parameters import checks
from exudyn_crawler.case.ph4100c import GRAVITY
from exudyn_crawler.errors import EquilibriumError, ParameterError
from exudyn_crawler.machines.datasheet import chain as chains, figures, plausible
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.sheet import Datasheet
from tests.case.random_datasheets import drawn

MOST_WORDS = 60
MOST_TEETH = 30  # of any sprocket


def check_sentence(error):
    """Check that a refusal is a sentence in the datasheet's own words, below lines on odd figures."""
    *odd, text = str(error).splitlines()
    assert all("is outside of" in line for line in odd), odd
    assert len(text.split()) <= MOST_WORDS, text
    # words of the construction are none of a datasheet
    assert not any(word in text for word in ("gear.", "tumbler", "flank", "cannot be built: ")), text


def case_of(seed):
    """Case and datasheet of a seed; None where it is refused."""
    try:
        sheet = Datasheet(**drawn(seed))
        case = derived(sheet).case
    except ParameterError as error:
        check_sentence(error)
        return None
    return case, sheet


def odd_lines(sheet):
    """Return the keys of a datasheet, and lines on what follows from it, that are implausible."""
    follows = plausible.following(sheet, chains.chain_of(sheet, GRAVITY))
    return [*(key for key, _ in plausible.odd_printed(sheet)), *plausible.odd_following(sheet, follows)]


def check(seeds):
    """Check the machines of some seeds; the number that is refused."""
    refused = 0
    for seed in seeds:
        found = case_of(seed)
        if found is None:
            refused += 1
            continue
        case, sheet = found
        assert figures.machine_mass(case) == pytest.approx(sheet.operating_weight, rel=1e-9), seed
        on_ground, over_shoes = figures.lengths(case, sheet)
        if sheet.length_on_ground is not None:
            assert on_ground == pytest.approx(sheet.length_on_ground, rel=0.01), seed
        if sheet.crawler_length is not None:
            assert over_shoes == pytest.approx(sheet.crawler_length, rel=0.05), seed
        if sheet.shoes is not None:
            assert case.gear.loop(case.track).shoe_count == sheet.shoes, seed
    return refused


def test_some_machines_at_random_are_assembled_or_refused_in_a_sentence():
    assert check(range(25)) < 6


def test_a_sprocket_of_few_gaps_is_no_heavier_than_solid_steel():
    case, sheet = case_of(76)
    tumbler = case.gear.tumbler
    pins = 0.5 * case.track.pitch / np.sin(np.pi * tumbler.gaps_per_shoe / tumbler.teeth)
    assert tumbler.mass == pytest.approx(7850.0 * np.pi * 0.8 * pins**3, rel=1e-3)
    assert tumbler.mass < case.track.pitch**3 * sheet.typical_value("sprocket_mass")
    assert not [line for line in checks.implausible(case, 2.0) if "tumbler" in line]


@pytest.mark.slow
def test_200_machines_at_random_are_assembled_or_refused_in_a_sentence():
    assert check(range(200)) < 30


@pytest.mark.slow
def test_machines_at_random_are_odd_only_where_their_datasheets_are():
    odd = {}
    for seed in range(200):
        found = case_of(seed)
        if found is None:
            continue
        case, sheet = found
        lines = [line for line in checks.implausible(case, 2.0) if "gear.tumbler.teeth" not in line]
        assert lines == [], seed
        if case.gear.tumbler.teeth > MOST_TEETH:
            # gaps are not compared where the weight already is none of its kind
            names = ("operating_weight", "sprocket_gaps that follows")
            odd[seed] = [line for line in odd_lines(sheet) if line.startswith(names)]
    assert odd
    assert all(odd.values()), odd


@pytest.mark.slow
# of lengths that contradict each other follow more teeth than any sprocket has
@pytest.mark.filterwarnings("ignore:gear.tumbler.teeth")
def test_200_machines_at_random_run_for_2_s():
    from exudyn_crawler import simulate

    without_rest = 0
    for seed in range(200):
        found = case_of(seed)
        if found is None:
            continue
        case = found[0]
        try:
            history = simulate(case, 2.0, progress=False)
        except EquilibriumError as error:
            # a sag that no take-up gives
            check_sentence(error)
            without_rest += 1
            continue
        # the chain's way: the speed rises by a cubic STEP in a second
        way = history.side_frame_position.values[-1, 0] - history.side_frame_position.values[0, 0]
        assert way == pytest.approx(case.drive.travel(2.0), rel=0.15), seed
    assert without_rest < 3
