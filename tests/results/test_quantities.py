"""One catalogue of quantities: stored ones are in files as it says, derived ones follow from them."""

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import exudyn_crawler.results
from exudyn_crawler import Case, simulate
from exudyn_crawler.results.balance import track_imbalance
from exudyn_crawler.results.history.catalogue import DERIVED, NEEDS, QUANTITIES, select
from exudyn_crawler.results.history.files import packed
from exudyn_crawler.results.history.quantities import TABLE
from exudyn_crawler.results.loads.exports import roller_loads
from exudyn_crawler.settings.fields import key_paths
from studies.comparison import time_mean
from studies.grounds import plain

WEIGHT = 13 * (386.4e3 + 4681.67 * 9.81)
KINDS = {"double": "f8", "single": "f4"}
LOOSE = {"integer": "iu", "truth": "b", "text": "OUT"}
"""Kinds of numpy's types that files may have."""


def test_every_variable_of_a_history_is_in_the_catalogue(history, stress, rolled):
    for dataset in (history.dataset, rolled.dataset, stress):
        for name, values in dataset.data_vars.items():
            quantity = QUANTITIES[str(name)]
            assert set(values.dims) == set(quantity.dimensions), name
            assert values.attrs == quantity.attributes, name
            assert ("stress" if dataset is stress else "history") in quantity.files
    for dataset in (packed(history.dataset), packed(rolled.dataset), stress):
        for name, values in dataset.data_vars.items():
            numbers = QUANTITIES[str(name)].numbers
            assert values.dtype == KINDS.get(numbers, values.dtype), name
            assert numbers in KINDS or values.dtype.kind in LOOSE[numbers], name


def test_rows_say_where_each_quantity_comes_from():
    with TABLE.open(encoding="utf-8", newline="") as file:
        names = [row["name"] for row in csv.DictReader(file)]
    assert names == list(QUANTITIES)
    assert set(DERIVED) == set(select(derived_from=True))
    for name, quantity in QUANTITIES.items():
        assert quantity.name == name
        assert (quantity.key_place is None) == (not quantity.key_result)
        assert quantity.by_shoe in ("sum", "deepest", "")
        assert all((quantity.label, quantity.meaning, quantity.per, quantity.files or quantity.derived_from))
        paths = set(quantity.needs) - set(NEEDS)
        assert all(any(key.startswith(f"{path}.") for key in key_paths(Case)) for path in paths)
        assert set(quantity.derived_from) <= set(QUANTITIES)


def test_derived_quantities_are_attributes_as_the_catalogue_tells(translation, rolled, bent):
    for history in (translation, rolled, bent):
        derived = [name for name in DERIVED if history.has(name)]
        assert set(derived) <= set(dir(history))
        assert ("rail_force" in derived) == (history is not translation)
        for name in derived:
            values, quantity = getattr(history, name), QUANTITIES[name]
            assert (values.dims, values.attrs) == (quantity.dimensions, quantity.attributes)
            assert values.identical(history.quantity(name))


def test_what_a_history_cannot_give_is_refused_with_what_it_needs(translation, rolled):
    for history, name, told in (
        (
            translation,
            "rail_force",
            r"rail_force needs a side frame on an open track, the case has another gear\.kind",
        ),
        (rolled, "drive_force", r"drive_force needs a dragged front shoe, the case has another gear\.kind"),
        (translation, "highest_von_mises", "highest_von_mises needs flexible shoes, the case has none"),
        (translation, "rail_forc", "there is no quantity 'rail_forc'; the nearest is 'rail_force'"),
    ):
        with pytest.raises(ValueError, match=told):
            history.quantity(name)


def test_stresses_are_quantities_where_they_are_given(history, stress):
    with pytest.raises(ValueError, match="highest_von_mises needs more than a history: stresses, say"):
        history.quantity("highest_von_mises")
    assert history.quantity("highest_von_mises", stress).identical(stress.highest_von_mises)
    found = history.over_time(("joint_force", "highest_von_mises", "penetration"), stress)
    assert found["penetration"].identical(history.contacts_by_shoe().penetration)
    assert found["joint_force"].identical(history.joint_force)


def test_axes_of_shoes_turn_as_their_angular_velocity_says(turning):
    axes = turning.axes
    products = xr.dot(axes, axes.rename(body_axis="other"), dim="axis")
    assert products.values == pytest.approx(np.broadcast_to(np.eye(3), products.shape), abs=1e-14)
    rate = axes.differentiate("time")
    turned = xr.cross(turning.angular_velocity, axes, dim="axis").transpose(*axes.dims)
    assert rate[1:-1].values == pytest.approx(turned[1:-1].values, abs=0.02 * float(abs(turned).max()))


@pytest.mark.simulation
def test_results_are_read_without_the_engine():
    room = Path(exudyn_crawler.results.__file__).parent
    modules = [".".join(path.relative_to(room).with_suffix("").parts) for path in room.glob("*/[a-z]*.py")]
    assert "history.states" in modules
    imports = "".join(f"import exudyn_crawler.results.{name}\n" for name in sorted(modules))
    script = f"{imports}import sys\nassert not [one for one in sys.modules if one.split('.')[0] == 'exudyn']"
    subprocess.run([sys.executable, "-c", script], check=True, timeout=120)


def test_a_shoe_on_two_units_has_the_sum_of_their_forces_and_the_deeper_penetration(translation):
    shoe = translation.contacts_by_shoe().sel(shoe=7)
    on_units = translation.dataset.isel(contact=(translation.contact_shoe == 7).values)
    assert on_units.contact_unit.values.tolist() == [7, 12]
    seven, twelve = (on_units.isel(contact=one) for one in (0, 1))
    for name in ("normal_force", "friction_force", "friction_torque"):
        assert shoe[name].values == pytest.approx((seven[name] + twelve[name]).values, abs=1e-9)
    assert (twelve.penetration > seven.penetration).all()
    assert shoe.penetration.values == pytest.approx(twelve.penetration.values, rel=1e-15)
    assert shoe.slip_velocity.values == pytest.approx(twelve.slip_velocity.values, rel=1e-15)


def test_contact_by_shoe_carries_what_contact_by_pair_does(translation):
    by_shoe = translation.contacts_by_shoe().contact_force.sum("shoe")
    assert by_shoe.values == pytest.approx(translation.contact_force.sum("contact").values, abs=1e-6 * WEIGHT)
    assert time_mean(by_shoe).sel(axis="z") == pytest.approx(WEIGHT, rel=1e-3)


def test_deformation_counts_every_spring_from_equilibrium(translation):
    deformation = translation.terrain_deformation
    assert float(deformation[0]) == 0.0
    heave = translation.unit_heave - translation.unit_heave.isel(time=0)
    rounding = 1e-13  # m, of 50 units
    assert deformation.values == pytest.approx(2.0 * heave.sum("unit").values, abs=rounding)


def test_the_track_balances_through_stick_slip(longer):
    off = track_imbalance(longer, about=(14.0, 9.29, 0.0))
    assert float(np.abs(off.force).max()) < 1e-6 * WEIGHT


def test_rolling_units_push_a_straight_track_sideways(translation):
    pitching = simulate(plain(translation.case), 0.4)
    sideways = [float(abs(h.velocity.sel(axis="y")).max()) for h in (pitching, translation)]
    assert sideways[0] < 1e-9  # m/s: an even track stays in its plane but for rounding
    assert sideways[1] > 1e-5


def test_shoes_together_carry_what_the_rollers_press_and_each_has_its_own_loads(rolled):
    found = rolled.rail_force
    assert found.dims == ("time", "shoe", "axis")
    pressed = rolled.roller_force.sum(("roller", "rail"))
    np.testing.assert_allclose(found.sum("shoe").values, pressed.values, rtol=1e-12, atol=1e-6)
    loaded = np.flatnonzero((found.sel(axis="z") < 0.0).any("time")) + 1
    assert len(loaded) == 3
    for shoe in (*loaded, loaded[0] + 1):
        own = roller_loads(rolled, int(shoe)).force.values
        size = np.linalg.norm(own.sum(axis=(1, 2)), axis=-1)
        np.testing.assert_allclose(np.linalg.norm(found.sel(shoe=shoe), axis=-1), size, rtol=1e-9, atol=1e-6)
