"""Where the drive's work goes: every place has its part, and nothing is left over."""

import numpy as np
import pytest

from exudyn_crawler import Case, History, simulate
from exudyn_crawler.results import balance, drive_work
from exudyn_crawler.results.drive_work import DRIVE, LOAD, MISSED, POWER, SHARE, STEADY, WORK
from tests.rolled import small_flexible_case

pytestmark = pytest.mark.simulation


@pytest.fixture(scope="module")
def driven():
    """A closed track with greased pins in motion, every step stored."""
    case = Case.closed()
    moved = {
        "drive.speed.times": (0.0, 0.1),
        "drive.speed.values": (0.0, 0.3),
        "track.pin.kind": "greased",
        "solver.output_interval": case.solver.step,
    }
    return simulate(case.with_(moved), 0.3, progress=False)


def test_the_rows_are_the_whole_work_of_the_drive(driven):
    table = drive_work.drive_work(driven).set_index("where")
    given = table.loc[[DRIVE, LOAD]].sum()
    taken = table.drop([DRIVE, LOAD]).sum()
    assert taken[WORK] == pytest.approx(given[WORK], rel=1e-12)
    assert taken[SHARE] == pytest.approx(100.0)
    assert abs(table.loc[MISSED, WORK]) < 1e-3 * given[WORK]
    assert {"pins", "teeth", "rollers", "idler", "inertia"} <= set(table.index)
    assert (table.loc[["pins", "rollers", "idler"], STEADY] > 0.0).all()
    # power after the ramp is that of torque and speed
    late = driven.dataset.isel(time=driven.time >= 0.1)
    power = (late.drive_moment * late.tumbler_speed).integrate("time") / (late.time[-1] - late.time[0])
    assert table.loc[DRIVE, POWER] == pytest.approx(1e-3 * float(power), rel=1e-9)


def test_wheels_by_place_take_what_all_wheels_take(driven):
    by_kind = balance.wheel_powers(driven)
    stored = np.gradient(balance.energies(driven).treads.values, driven.time.values)
    total = sum(by_kind.data_vars.values()).values
    np.testing.assert_allclose(total, balance.powers(driven).wheel_losses.values + stored, rtol=1e-9)


def test_a_long_run_in_pieces_gives_the_same_work(driven, monkeypatch):
    whole = drive_work.drive_work(driven).set_index("where")
    monkeypatch.setattr(drive_work, "TIMES_AT_ONCE", 40)
    pieces = drive_work.drive_work(driven).set_index("where")
    # rates at the ends of pieces are one-sided differences
    assert (pieces[WORK] - whole[WORK]).abs().max() < 2e-3 * whole.loc[DRIVE, WORK]


def test_open_tracks_have_their_places_and_what_stands_has_none(longer):
    table = drive_work.drive_work(longer).set_index("where")
    assert table.loc["ground, slip", SHARE] > 80.0
    assert abs(table.loc[MISSED, SHARE]) < 1.0
    still = longer.case.with_(drive=longer.case.drive.with_({"speed.values": (0.0, 0.0)}))
    assert not drive_work.has_works(History(still, longer.dataset))


def test_histories_without_powers_have_no_works(longer):
    assert not drive_work.has_works(History(small_flexible_case(), longer.dataset))
