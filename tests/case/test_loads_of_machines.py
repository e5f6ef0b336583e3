"""Loads of machines, whose wheels bring them to the shoes: none on however many there are."""

import pytest

from exudyn_crawler import Case
from exudyn_crawler.case import LoadCycle
from exudyn_crawler.errors import ParameterError


@pytest.mark.parametrize(("base", "more"), [("shovel", 2), ("closed", 1), ("rolled", 2)])
def test_another_number_of_shoes_asks_for_no_loads(read, base, more):
    case = getattr(Case, base)()
    count = case.track.shoe_count + more
    changed = read(f'base = "{base}"\nduration = 0.1\n[track]\nshoe_count = {count}\n').case
    assert changed.loads == LoadCycle.constant([0.0] * count)
    assert case.with_({"track.shoe_count": count}) == changed
    assert case.with_(track=changed.track) == changed


def test_loads_of_a_dragged_track_are_asked_for(refused):
    (fault,) = refused('base = "translation"\n[track]\nshoe_count = 12\n')
    assert "loads must name every shoe of the track (12) or be a number, got loads for 13" in fault
    with pytest.raises(ParameterError, match="got loads for 13"):
        Case.translation().with_({"track.shoe_count": 12})


def test_loads_on_a_machine_are_refused(refused):
    (fault,) = refused('base = "closed"\nloads = 1e5\n')
    assert "loads must be zero on every shoe" in fault
