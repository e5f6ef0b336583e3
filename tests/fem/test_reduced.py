"""Loads and modes of a reduced body."""

import numpy as np
import pytest

import fem


def test_load_of_a_patch(reduced: fem.ReducedBody) -> None:
    half = reduced.polygon_weights("underside", [[-1, 0], [1, 0], [1, 2], [-1, 2]])
    nodes = np.flatnonzero(half)
    assert (reduced.nodes[nodes, 1] > -1e-9).all()
    assert half.sum() == pytest.approx(0.63 * 3.505 / 2, rel=0.1)  # whole nodes only
    rows = reduced.mean_rows(half)
    of_middle = reduced.motion_rows(half, half @ reduced.nodes / half.sum())
    np.testing.assert_allclose(of_middle[:3], rows, atol=1e-9)


def test_some_modes_alone(reduced: fem.ReducedBody) -> None:
    few = reduced.with_modes([0, 5, 11])
    assert few.modes.shape[2] == few.stress_modes.shape[2] == few.pilots.shape[2] == 3
    np.testing.assert_array_equal(few.modes[:, :, 1], reduced.modes[:, :, 5])
    with pytest.raises(ValueError, match=r"0\.\.93"):
        reduced.with_modes([94])
    with pytest.raises(ValueError, match="different"):
        reduced.with_modes([1, 1])
