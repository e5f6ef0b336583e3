"""Loads on level rectangles: resultants, places between elements' edges, rectangles that are none."""

import numpy as np
import pytest

import fem
from fem.places import FlatRectangle, PressureGrid, Stations, flat_parts


@pytest.fixture(scope="module")
def underside(shoe: fem.ElasticBody) -> FlatRectangle:
    (found,) = flat_parts(shoe.mesh, "underside")
    return found


def assert_resultants(mesh: fem.Mesh, weights, loads: np.ndarray, forces: np.ndarray, at: np.ndarray) -> None:
    """Nodal forces, weights (n, p) of loads (t, p, 3), are one force (t, 3) each at a place (t, 3)."""
    nodal = np.einsum("np,tpc->tnc", weights.toarray(), loads)
    np.testing.assert_allclose(nodal.sum(axis=1), forces, atol=1e-12)
    moments = np.einsum("tnc,nd->tdc", nodal, mesh.nodes)
    np.testing.assert_allclose(moments, at[:, :, None] * forces[:, None], atol=1e-9)


def test_rails_are_found_by_their_surface(shoe: fem.ElasticBody) -> None:
    right, left = flat_parts(shoe.mesh, "roller path")
    np.testing.assert_allclose([right.low[1], right.high[1]], [-0.35, -0.13], atol=1e-9)
    np.testing.assert_allclose([left.low[1], left.high[1]], [0.13, 0.35], atol=1e-9)
    assert right.height == pytest.approx(0.2235)


def test_samples_are_the_elements_shape_functions(underside: FlatRectangle) -> None:
    """Quadratic ones: they give the places, and their products, of any point."""
    rng = np.random.default_rng(1)
    x, y = rng.uniform(underside.low, underside.high, (200, 2)).T
    shapes = underside.samples(x, y)
    nodes = underside.mesh.nodes
    for field in (lambda x, y: 1.0 + 0.0 * x, lambda x, y: x, lambda x, y: x * y, lambda x, y: y**2):
        np.testing.assert_allclose(shapes @ field(nodes[:, 0], nodes[:, 1]), field(x, y), atol=1e-8)


def test_a_grids_tractions_have_the_resultants_of_a_rectangle(underside: FlatRectangle) -> None:
    rng = np.random.default_rng(2)
    grid = PressureGrid(underside, (3, 9))
    assert grid.weights.sum() == pytest.approx(np.prod(underside.high - underside.low))
    forces = rng.standard_normal((6, 3))
    corners = np.sort(rng.uniform(underside.low, underside.high, (2, 6, 2)), axis=0)
    middles = np.column_stack((corners.mean(axis=0), np.full(6, underside.height)))
    assert_resultants(underside.mesh, grid.weights, grid.coordinates(forces, *corners), forces, middles)


def test_what_has_no_width_on_the_grid_is_a_line_on_its_edge(underside: FlatRectangle) -> None:
    grid = PressureGrid(underside, (3, 4))
    low, force = np.array([[underside.high[0] + 0.001, -0.5]]), np.ones((1, 3))
    tractions = grid.coordinates(force, low, low + np.array([0.01, 0.3]))
    on_edge = np.array([[underside.high[0], -0.35, underside.height]])
    assert_resultants(underside.mesh, grid.weights, tractions, force, on_edge)
    assert grid.coordinates(np.empty((0, 3)), low[:0], low[:0]).shape == (0, 12, 3)


@pytest.mark.parametrize("count", [2, 3, 9])
def test_stations_carry_forces_between_them_with_their_moment(shoe: fem.ElasticBody, count: int) -> None:
    rail = flat_parts(shoe.mesh, "roller path")[0]
    stations = Stations(rail, count, 0.1)
    x = np.linspace(rail.low[0], rail.high[0], 11)
    forces = np.random.default_rng(3).standard_normal((11, 3))
    middle = 0.5 * (rail.low[1] + rail.high[1])
    places = np.column_stack((x, np.full(11, middle), np.full(11, rail.height)))
    assert_resultants(shoe.mesh, stations.weights, stations.coordinates(forces, x), forces, places)
    at_x = np.eye(11)[:, :, None] * forces
    assert_resultants(shoe.mesh, stations.weights_at(x), at_x, forces, places)


def test_bad_places(shoe: fem.ElasticBody, underside: FlatRectangle) -> None:
    mesh = shoe.mesh
    with pytest.raises(ValueError, match="low must be below high"):
        FlatRectangle(mesh, "underside", [0.1, 0.0], [0.1, 1.0])
    with pytest.raises(ValueError, match=r"'top' must be level .* faces of heights"):
        FlatRectangle(mesh, "top", [-0.2, -0.9], [0.2, 0.9])
    with pytest.raises(ValueError, match=r"must be level .* got 0 faces"):
        FlatRectangle(mesh, "roller path", [1.0, 1.0], [2.0, 2.0])
    with pytest.raises(ValueError, match=r"'roller path' must cover .* got a gap"):
        FlatRectangle(mesh, "roller path", [-0.2, -0.35], [0.2, 0.5])
    with pytest.raises(ValueError, match=r"counts must be at least 2 .* got \(1, 4\)"):
        PressureGrid(underside, (1, 4))
    with pytest.raises(ValueError, match="count must be at least 2, got 1"):
        Stations(underside, 1, 0.1)
    with pytest.raises(ValueError, match=r"reach must lie in \(0, 0.315\] m.* got 0.4"):
        Stations(underside, 3, 0.4)
    stations = Stations(underside, 3, 0.1)
    with pytest.raises(ValueError, match=r"x must lie in -0.315..0.315 m, got 0.1..0.4"):
        stations.weights_at(np.array([0.1, 0.4]))
    with pytest.raises(ValueError, match=r"x must lie in .* where a force acts, got 0.4"):
        stations.coordinates(np.ones((2, 3)), np.array([0.1, 0.4]))
    assert not stations.coordinates(np.zeros((1, 3)), np.array([0.4])).any()
