"""Runs that no machine can hold are refused before anything is made of them."""

import time

import pytest

from exudyn_crawler import Case, CaseFile, SphereContact, simulate
from exudyn_crawler.case.case_file import check_size, machine_memory

STRAIGHT = Case.translation()


def ground(columns, rows, **parts):
    return STRAIGHT.with_(terrain=STRAIGHT.terrain.with_(columns=columns, rows=rows), **parts)


@pytest.mark.parametrize(
    ("case", "duration", "told"),
    [
        (ground(10_000, 10_000), 10.0, "terrain: 100000000 units would take 1.28e+09 GB of memory"),
        (
            ground(10_000, 10_000, contact=SphereContact.oil_sand()),
            10.0,
            "terrain: 100000000 units would take 2e+03 GB of memory",
        ),
        (STRAIGHT, 1e12, "duration: 1e+12 s leave 4.32e+06 TB, allowed is 1 TB"),
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
