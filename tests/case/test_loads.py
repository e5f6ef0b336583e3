"""Load cycles: the shovel's, and a user's own from a file."""

import numpy as np
import pytest

from exudyn_crawler import LoadCycle


def test_the_shovel_cycle_keeps_every_sum_and_the_printed_loads():
    cycle = LoadCycle.shovel_cycle()
    loads = {phase.name: np.array(phase.loads) for phase in cycle.phases}
    machine, dipper = 13 * 386.4e3, 445e3
    sums = {"propel": machine, "dig": machine + dipper, "hoist and swing": machine + dipper}
    sums |= {"dump": machine, "return": machine}
    for name, total in sums.items():
        assert loads[name].sum() == pytest.approx(total, rel=1e-12)
    printed = {"propel": 386.4e3, "dig": 384e3, "hoist and swing": 732e3, "dump": 541e3, "return": 386.4e3}
    for name, load in printed.items():
        assert loads[name][6] == pytest.approx(load, rel=1e-9)
    assert loads["dump"][[0, 12]] == pytest.approx([253.9e3, 253.9e3], rel=1e-3)
    for name in ("hoist and swing", "dump"):
        assert loads[name] == pytest.approx(loads[name][::-1], rel=1e-12)
        assert loads[name].argmax() == 6
    assert cycle.loads(18.75)[0, 6] == pytest.approx((386.4e3 + 384e3) / 2, rel=1e-12)


def test_a_cycle_is_read_from_toml(tmp_path):
    path = tmp_path / "cycle.toml"
    path.write_text(
        '[[phases]]\nname = "propel"\nend = 2.0\nloads = [1e5, 2e5]\n'
        '[[phases]]\nname = "dig"\nend = 4.0\nloads = [3e5, 1e5]\n'
    )
    cycle = LoadCycle.from_toml(path)
    assert cycle.loads(3.0)[0] == pytest.approx([2e5, 1.5e5])
    path.write_text("drive_on = [[0.0, 15.0]]\n" + path.read_text())
    with pytest.raises(ValueError, match=r"drive_on must not be in a load cycle.* on = \[\[0\.0, 15"):
        LoadCycle.from_toml(path)
    path.write_text("phases = 1")
    with pytest.raises(ValueError, match="phases"):
        LoadCycle.from_toml(path)
    path.write_text("[[phases")
    with pytest.raises(ValueError, match="is not TOML"):
        LoadCycle.from_toml(path)
