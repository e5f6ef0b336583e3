"""The map of the ground: it remembers where steps are accepted alone, and goes on bit for bit."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from exudyn_crawler.case.parameters.heights import Heights, Roughness
from exudyn_crawler.ground.cells.tiles import SIDE
from tests.ground.cells.driving import ROCK, SAND, frame, ground, turn

HEIGHTS = Heights(roughness=Roughness(spectrum=64e-6, seed=2))
R = turn([0.0, 0.0, 0.05])


def frames(step):
    """Two shoes that sink, slide, turn and leave tiles behind."""
    t = 0.02 * step
    depth = -0.01 * (1.0 + np.sin(3.0 * t))
    return np.concatenate(
        [frame([x + 2.0 * t, -0.1 + 0.3 * np.sin(t), depth], turn([0.0, 0.0, 0.1 * t])) for x in (-1.0, -0.3)]
    )


def walk(cells, first, last):
    """Wrenches of accepted steps."""
    out = []
    for step in range(first, last):
        cells.cover(frames(step + 1), frames(step))
        out.append(cells.press(frames(step + 1)).copy())
        cells.commit()
    return np.array(out)


@pytest.mark.parametrize("law", [SAND, ROCK], ids=["sand", "rock"])
def test_a_restored_ground_goes_on_bit_for_bit(law):
    whole, first = (ground(law, HEIGHTS, shoes=2) for _ in range(2))
    wrenches = walk(whole, 0, 80)
    walk(first, 0, 37)
    state = {name: values.copy() for name, values in first.state().items()}
    assert len(state["cells"]) == len(np.unique(state["cells"], axis=0)) == len(state["memory"])
    second = ground(law, HEIGHTS, shoes=2)
    second.restore(state)
    assert_array_equal(walk(second, 37, 80), wrenches[37:])
    for name, values in whole.state().items():
        other = second.state()[name]
        order = [np.lexsort(one["cells"].T) for one in (whole.state(), second.state())]
        if name != "held":
            assert_array_equal(values[order[0]], other[order[1]])
    # a run that went on after a checkpoint, and one that is set back to it
    walk(first, 37, 60)
    first.restore(state)
    assert_array_equal(walk(first, 37, 80), wrenches[37:])


def test_only_accepted_steps_are_remembered():
    one, other = (ground(SAND, HEIGHTS, shoes=2) for _ in range(2))
    walk(one, 0, 10), walk(other, 0, 10)
    other.cover(frames(30), frames(10))
    for step in (25, 30, 28):
        other.press(frames(step), (1.0, 10.0))
    assert_array_equal(walk(one, 10, 20), walk(other, 10, 20))


def test_tiles_are_made_where_shoes_come_alone():
    cells = ground(SAND, shoes=1)
    for x in (0.0, 500.0, -300.0):
        cells.cover(frame([x + 1.0, 1.0, -0.01]), frame([x + 1.0, 1.0, -0.01]))
        cells.press(frame([x + 1.0, 1.0, -0.01]))
        cells.commit()
    assert len(cells.tiles.planes) <= 12
    state = cells.state()
    assert state["memory"].nbytes < 3 * 48 * (0.65 / 0.1 + 2) * (3.505 / 0.1 + 2)
    assert len(state["held"]) < len(state["cells"])
    x = cells.tiles.cell * (state["cells"][:, 0] + 0.5)
    assert set(np.round(x, -2)) == {-300.0, 0.0, 500.0}
    assert SIDE == 32
