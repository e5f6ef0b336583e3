"""Forces of all rollers by shoe, in short runs."""

import numpy as np

from exudyn_crawler.results.history.derived import rail_force
from exudyn_crawler.results.loads.rollers import roller_loads


def test_shoes_together_carry_what_the_rollers_press(rolled):
    found = rail_force(rolled.dataset)
    assert found.dims == ("time", "shoe", "axis")
    pressed = rolled.roller_force.sum(("roller", "rail"))
    np.testing.assert_allclose(found.sum("shoe").values, pressed.values, rtol=1e-12, atol=1e-6)


def test_a_shoe_has_the_forces_of_its_own_loads(rolled):
    found = rail_force(rolled.dataset)
    loaded = np.flatnonzero((found.sel(axis="z") < 0.0).any("time")) + 1
    assert len(loaded) == 3
    for shoe in (*loaded, loaded[0] + 1):
        own = roller_loads(rolled, int(shoe)).force.values
        size = np.linalg.norm(own.sum(axis=(1, 2)), axis=-1)
        np.testing.assert_allclose(np.linalg.norm(found.sel(shoe=shoe), axis=-1), size, rtol=1e-9, atol=1e-6)
