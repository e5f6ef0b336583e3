"""Integrated mode shapes of a rectangular surface."""

import numpy as np
import pytest

from fem.patches import CELL, integrate_underside, rectangle_loads

FOOTPRINT = np.array([-0.3, 0.4, -1.0, 1.08, -0.2])


@pytest.fixture(scope="module")
def positions() -> np.ndarray:
    """Corners of the rectangle and some nodes within, scattered."""
    rng = np.random.default_rng(8)
    corners = [[x, y] for x in FOOTPRINT[:2] for y in FOOTPRINT[2:4]]
    return np.vstack([corners, rng.uniform(FOOTPRINT[[0, 2]], FOOTPRINT[[1, 3]], (60, 2))])


def test_linear_shapes_are_integrated_exactly(positions: np.ndarray) -> None:
    rng = np.random.default_rng(9)
    constant, slopes = rng.standard_normal((3, 4)), rng.standard_normal((2, 3, 4))
    modes = constant + np.tensordot(positions, slopes, axes=1)
    found = integrate_underside(positions, modes, FOOTPRINT)
    assert found.mode_count == 4
    # 70 cells of 30 mm to rounding
    assert (found.cell <= CELL * (1.0 + 1e-12)).all()
    columns, rows = found.integral.shape[0] - 1, found.integral.shape[1] - 1
    for i, j in ((columns, rows), (columns // 3, rows // 2), (1, rows)):
        sides = np.array([i, j]) * found.cell
        middle = found.corner + sides / 2
        expected = sides.prod() * (constant + np.tensordot(middle, slopes, axes=1))
        np.testing.assert_allclose(found.integral[i, j], expected, atol=1e-12)


def test_nodes_that_leave_a_part_out_are_refused(positions: np.ndarray) -> None:
    wider = FOOTPRINT + np.array([0.0, 0.1, 0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match=r"surround the rectangle .* got \d+ of its \d+ cells outside"):
        integrate_underside(positions, np.zeros((len(positions), 3, 1)), wider)


def test_forces_spread_over_rectangles_do_the_work_of_their_means(positions: np.ndarray) -> None:
    """Linear shapes have the displacement of a rectangle's middle as their mean over it."""
    rng = np.random.default_rng(10)
    constant, slopes = rng.standard_normal((3, 4)), rng.standard_normal((2, 3, 4))
    under = integrate_underside(positions, constant + np.tensordot(positions, slopes, axes=1), FOOTPRINT)
    count = 50
    cells = rng.integers(0, 5, (count, 2))
    low = under.corner + cells * under.cell
    high = low + rng.integers(1, 8, (count, 2)) * under.cell
    forces = rng.standard_normal((count, 3))
    means = constant + np.tensordot((low + high) / 2, slopes, axes=1)
    expected = np.einsum("tc,tcm->tm", forces, means)
    for at_once in (7, 1000):
        found = rectangle_loads(under, forces, low, high, at_once)
        np.testing.assert_allclose(found, expected, atol=1e-10)
    assert rectangle_loads(under, forces[:0], low[:0], high[:0]).shape == (0, 4)
