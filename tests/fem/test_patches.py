"""Integrated mode shapes of a rectangular surface."""

import numpy as np
import pytest

from fem.patches import CELL, Underside, integrate_underside, mean_rows

FOOTPRINT = np.array([-0.3, 0.4, -1.0, 1.08, -0.2])


@pytest.fixture(scope="module")
def positions() -> np.ndarray:
    """Corners of the rectangle and some nodes within, scattered."""
    rng = np.random.default_rng(8)
    corners = [[x, y] for x in FOOTPRINT[:2] for y in FOOTPRINT[2:4]]
    return np.vstack([corners, rng.uniform(FOOTPRINT[[0, 2]], FOOTPRINT[[1, 3]], (60, 2))])


def sums(under: Underside, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Mean displacements (times, 3, modes) over rectangles by the grid's points."""
    points, weights = under.rectangle_mean(low, high)
    return np.einsum("tj,tjcm->tcm", weights, under.integral.reshape(-1, 3, under.mode_count)[points])


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


def test_means_over_rectangles_are_sums_over_the_grid(positions: np.ndarray) -> None:
    """Linear shapes have the displacement of a rectangle's middle as their mean over it."""
    rng = np.random.default_rng(10)
    constant, slopes = rng.standard_normal((3, 4)), rng.standard_normal((2, 3, 4))
    under = integrate_underside(positions, constant + np.tensordot(positions, slopes, axes=1), FOOTPRINT)
    count = 50
    cells = rng.integers(0, 5, (count, 2))
    low = under.corner + cells * under.cell
    high = low + rng.integers(1, 8, (count, 2)) * under.cell
    expected = constant + np.tensordot((low + high) / 2, slopes, axes=1)
    np.testing.assert_allclose(sums(under, low, high), expected, atol=1e-10)


def test_means_over_any_rectangles_are_those_of_the_equations(positions: np.ndarray) -> None:
    """Also of such that lie partly or wholly beside the underside, or have no area."""
    rng = np.random.default_rng(11)
    under = integrate_underside(positions, rng.standard_normal((len(positions), 3, 4)), FOOTPRINT)
    low = rng.uniform([-0.6, -1.5], [0.5, 1.2], (200, 2))
    high = low + rng.uniform(0.0, 1.0, (200, 2)) * (rng.uniform(size=(200, 1)) > 0.1)
    expected = np.empty((200, 3, 4))
    for rows, (x0, y0), (x1, y1) in zip(expected, low, high, strict=True):
        mean_rows(under.corner, under.cell, under.integral, (x0, x1, y0, y1), rows)
    assert (expected == 0.0).all(axis=(1, 2)).any()
    np.testing.assert_allclose(sums(under, low, high), expected, atol=1e-12)
