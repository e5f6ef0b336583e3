"""Energy of a run: what drive and load give is stored, or taken by friction and dampers."""

from types import SimpleNamespace

import numpy as np
import pytest

from exudyn_crawler import Case, simulate
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.results.balance import energies, energy_balance, powers
from studies.grounds import plain
from tests.rolled import small_flexible_case


def test_the_work_of_the_drive_is_accounted_for_and_goes_into_friction(longer):
    balance = energy_balance(longer)
    drive = float(balance.drive[-1])
    assert drive > 1e4
    # the integration's own damping and the trapezoidal rule stay well below
    assert np.abs(balance.imbalance).max() < 0.01 * drive
    # late on, every shoe slides at the drive's mean speed
    assert 0.9 < float(balance.friction[-1]) / drive < 1.0


def test_no_term_of_the_balance_could_be_left_out(longer):
    """On units that pitch: those that roll, on springs at their edges, damp by 6 J of 131 kJ in all."""
    balance = energy_balance(simulate(plain(longer.case), longer.duration)).isel(time=-1)
    # half of the smallest counted work is more than what the balance misses
    damped = ("contact_damping", "terrain_damping")
    for name in ("drive", "friction", *damped, "elastic_contact", "machine_load"):
        assert abs(float(balance[name])) > 2.0 * abs(float(balance.imbalance)), name


def test_friction_and_dampers_only_take(longer):
    power = powers(longer)
    for name in ("friction", "contact_damping", "terrain_damping"):
        least, greatest = float(power[name].min()), float(power[name].max())
        assert least >= -1e-9 * greatest
        assert greatest > 0.0


def test_power_balances_the_rate_of_energy(translation):
    """The same at every instant, from accelerations where the integral uses states."""
    stored = sum(energies(translation).data_vars.values())
    power = powers(translation)
    net = power.drive + power.machine_load - power.friction
    net = net - power.elastic_contact - power.contact_damping - power.terrain_damping
    rate = stored.differentiate("time")
    # differences of 2 ms steps of a smooth start
    assert rate.values[5:-5] == pytest.approx(net.values[5:-5], abs=0.01 * np.abs(net).max().item())


@pytest.fixture(scope="module", params=["rolled", "dragged"])
def on_sand(request):
    """A third of a second on LETE sand: a machine set in motion, and shoes jerked into full slip."""
    if request.param == "rolled":
        return request.getfixturevalue("over_sand")
    jerked = {"drive.speed.times": (0.0, 0.05), "drive.speed.values": (0.0, 0.2)}
    return simulate(Case.translation().with_(jerked).on_cells(BekkerSoil.lete_sand()), 0.3, progress=False)


@pytest.mark.simulation
def test_the_work_on_cells_is_accounted_for_and_no_term_could_be_left_out(on_sand):
    balance = energy_balance(on_sand)
    drive = float(balance.drive[-1])
    assert drive > 1e4
    # found: 3e-4 rolled, 1e-4 dragged
    missed = float(np.abs(balance.imbalance).max())
    assert missed < 1e-3 * drive
    small = {"machine_load", "treads", "tread_damping"}  # of the machine: some 10 J of 104 kJ
    for name in set(balance.data_vars) - small - {"imbalance"}:
        assert float(np.abs(balance[name]).max()) > 2.0 * missed, name


@pytest.mark.simulation
def test_shear_of_cells_takes_friction_times_slip_and_pressure_the_rest(on_sand):
    power, case = powers(on_sand), on_sand.case
    rubbed = (on_sand.friction_force * on_sand.slip_velocity).sum(("contact", "axis")).values
    spun = (on_sand.friction_torque.values * on_sand.angular_velocity.values).sum(axis=(1, 2))
    np.testing.assert_allclose(power.shear, -rubbed - spun, rtol=0.0, atol=1e-5 * np.abs(rubbed).max())
    if case.gear.kind == "dragged":
        # slipped by five shear deformations: nearly all of the strength
        strength = np.tan(np.radians(case.contact.law.friction_angle))
        weight = on_sand.normal_force.isel(time=-1, axis=2).sum().item()
        assert float(power.shear[-1]) == pytest.approx(0.2 * strength * weight, rel=0.05)


def test_powers_of_flexible_shoes_on_cells_are_refused():
    case = small_flexible_case().on_cells(BekkerSoil.lete_sand())
    with pytest.raises(ValueError, match="needs rigid shoes"):
        powers(SimpleNamespace(case=case))
