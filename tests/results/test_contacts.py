"""Contact by shoe and by pair of shoe and unit, and deformation of the terrain."""

import numpy as np
import pytest

from exudyn_crawler import Case, simulate
from exudyn_crawler.results.history.derived import contact_force, contacts_by_shoe, pair, terrain_deformation
from exudyn_crawler.results.loads.balance import track_imbalance
from studies.comparison import time_mean

WEIGHT = 13 * (386.4e3 + 4681.67 * 9.81)


def test_a_shoe_on_two_units_has_the_sum_of_their_forces_and_the_deeper_penetration(translation):
    shoe = contacts_by_shoe(translation).sel(shoe=7)
    seven, twelve = (translation.dataset.isel(contact=pair(translation, 7, unit)) for unit in (7, 12))
    for name in ("normal_force", "friction_force", "friction_torque"):
        assert shoe[name].values == pytest.approx((seven[name] + twelve[name]).values, abs=1e-9)
    assert (twelve.penetration > seven.penetration).all()
    assert shoe.penetration.values == pytest.approx(twelve.penetration.values, rel=1e-15)
    assert shoe.slip_velocity.values == pytest.approx(twelve.slip_velocity.values, rel=1e-15)


def test_contact_by_shoe_carries_what_contact_by_pair_does(translation):
    by_shoe = contacts_by_shoe(translation).contact_force.sum("shoe")
    by_pair = contact_force(translation).sum("contact")
    assert by_shoe.values == pytest.approx(by_pair.values, abs=1e-6 * WEIGHT)
    assert time_mean(by_shoe).sel(axis="z") == pytest.approx(WEIGHT, rel=1e-3)


def test_a_pair_that_never_met_is_refused(translation):
    with pytest.raises(ValueError, match=r"shoe 7 never met unit 17; it met units \[7, 12\]"):
        pair(translation, 7, 17)


def test_deformation_counts_every_spring_from_equilibrium(translation):
    deformation = terrain_deformation(translation)
    assert float(deformation[0]) == 0.0
    heave = translation.unit_heave - translation.unit_heave.isel(time=0)
    assert deformation.values == pytest.approx(
        2.0 * heave.sum("unit").values, abs=1e-13
    )  # m, rounding of 50 units


def test_the_track_balances_through_stick_slip(longer):
    off = track_imbalance(longer, about=(14.0, 9.29, 0.0))
    assert float(np.abs(off.force).max()) < 1e-6 * WEIGHT


def test_rolling_units_push_a_straight_track_sideways(translation):
    rolling = Case.translation()
    rolling = rolling.with_(terrain=rolling.terrain.with_(tilt="roll"))
    moved = simulate(rolling, 0.4)
    sideways = [float(abs(h.velocity.sel(axis="y")).max()) for h in (translation, moved)]
    assert sideways[0] < 1e-9  # m/s: an even track stays in its plane but for rounding
    assert sideways[1] > 1e-5
