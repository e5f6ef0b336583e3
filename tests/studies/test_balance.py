"""Energy of a run: what drive and load give is stored, or taken by friction and dampers."""

import numpy as np
import pytest

from exudyn_crawler import simulate
from studies.balance import energies, energy_balance, powers
from studies.grounds import plain


def test_the_work_of_the_drive_is_accounted_for(longer):
    balance = energy_balance(longer)
    drive = float(balance.drive[-1])
    assert drive > 1e4
    # 1 % of the issue; the integration's own damping and the trapezoidal rule stay well below
    assert np.abs(balance.imbalance).max() < 0.01 * drive


@pytest.mark.simulation
def test_no_term_of_the_balance_could_be_left_out(longer):
    """On units that pitch: those that roll, on springs at their edges, damp by 6 J of 131 kJ in all."""
    balance = energy_balance(simulate(plain(longer.case), longer.duration)).isel(time=-1)
    # half of the smallest counted work is more than what the balance misses
    for name in (
        "drive",
        "friction",
        "contact_damping",
        "terrain_damping",
        "elastic_contact",
        "machine_load",
    ):
        assert abs(float(balance[name])) > 2.0 * abs(float(balance.imbalance))


def test_friction_and_dampers_only_take(longer):
    power = powers(longer)
    for name in ("friction", "contact_damping", "terrain_damping"):
        least, greatest = float(power[name].min()), float(power[name].max())
        assert least >= -1e-9 * greatest
        assert greatest > 0.0


def test_steady_sliding_costs_friction_times_travel(longer):
    """Late on, every shoe slides at the drive's mean speed and friction takes all of the work."""
    balance = energy_balance(longer)
    share = float(balance.friction[-1] / balance.drive[-1])
    assert 0.9 < share < 1.0


def test_power_balances_the_rate_of_energy(translation):
    """The same at every instant, from accelerations where the integral uses states."""
    stored = sum(energies(translation).data_vars.values())
    power = powers(translation)
    net = power.drive + power.machine_load - power.friction
    net = net - power.elastic_contact - power.contact_damping - power.terrain_damping
    rate = stored.differentiate("time")
    # differences of 2 ms steps of a smooth start
    assert rate.values[5:-5] == pytest.approx(net.values[5:-5], abs=0.01 * np.abs(net).max().item())
