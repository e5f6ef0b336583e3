"""Runs that no machine can hold are refused before anything is made of them."""

import time

import pytest

from exudyn_crawler import Case, CaseFile, SphereContact, simulate
from exudyn_crawler.case.case_file import check_modes, check_size, machine_memory
from studies.stress import with_modes

STRAIGHT = Case.translation()


def ground(columns, rows, **parts):
    return STRAIGHT.with_(terrain=STRAIGHT.terrain.with_(columns=columns, rows=rows), **parts)


@pytest.mark.parametrize(
    ("case", "duration", "told"),
    [
        (ground(10_000, 10_000), 10.0, "terrain: 10000 x 10000 units would take 1.28e+03 PB of memory"),
        (
            ground(10_000, 10_000, contact=SphereContact.oil_sand()),
            10.0,
            "terrain: 10000 x 10000 units would take 2 TB of memory",
        ),
        (STRAIGHT, 1e12, "duration: 1e+12 s would leave 5e+14 stored states of 4.32e+03 PB, allowed is 1 TB"),
    ],
)
def test_what_no_machine_holds_is_refused_at_once(case, duration, told):
    begun = time.perf_counter()
    for refuse in (
        lambda: check_size(case, duration),
        lambda: simulate(case, duration),
        lambda: CaseFile(case=case, duration=duration),
    ):
        with pytest.raises(ValueError, match=told.replace("+", r"\+")):
            refuse()
    assert time.perf_counter() - begun < 2.0


def test_what_machines_hold_is_not_refused():
    """An hour of duty, and ground as fine as any of the papers'."""
    assert machine_memory() > 1e8
    check_size(Case.stress(), 3600.0)
    check_size(ground(50, 20), 10.0)
    check_modes(30_000, 100)


def test_more_modes_than_memory_holds_are_refused():
    with pytest.raises(ValueError, match=r"recovered_modes: 10024 modes of 10000000 nodes would take"):
        check_modes(10_000_000, 10_024)


@pytest.mark.parametrize("choice", ["1-9999999999", "1-" + "9" * 5000, "95", "3,1-95"])
def test_modes_that_are_not_there_are_refused_before_they_are_listed(choice):
    flexible = Case.stress().flexible_shoes()
    with pytest.raises(ValueError, match=r"modes must be in 1\.\.94, got (9+|95)$"):
        with_modes(flexible, choice)
    assert with_modes(flexible, "1-094").modes == tuple(range(1, 95))
