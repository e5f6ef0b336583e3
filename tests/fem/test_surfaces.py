"""Surfaces: faces found by where they look, loads on level rectangles, means of mode shapes over them."""

import numpy as np
import pytest

import fem
from fem.body.rectangle_loads import FlatRectangle, PressureGrid, Stations, flat_parts
from fem.body.rectangle_motion import CELL, Underside, hat_grid, integrate_underside, mean_rows
from tests.fem.bodies import box_mesh, tube
from tests.fem.refusals import refused


@pytest.fixture(scope="module")
def overhang() -> fem.Mesh:
    """Cubes of 1 m as a C seen from the side: floor 2 m long, pillar at x in 0..1, roof 2 m long."""
    mesh = box_mesh((4, 2, 6), (2.0, 1.0, 3.0))
    centers = mesh.nodes[mesh.elements[:, :4]].mean(axis=1)
    room = (centers[:, 0] > 1.0) & (centers[:, 2] > 1.0) & (centers[:, 2] < 2.0)
    used, elements = np.unique(mesh.elements[~room], return_inverse=True)
    return fem.Mesh(mesh.nodes[used], elements.reshape(-1, 10), {})


def area(mesh: fem.Mesh, faces: np.ndarray) -> float:
    return float(fem.body.surfaces.surface_weights(mesh, faces).sum())


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize(("direction", "side"), [([0, 0, 1], 0.4), ([0, -3, 0], 0.0), ([1, 0, 0], 1.2)])
def test_one_side_of_a_box(order, direction, side):
    mesh = box_mesh((3, 2, 2), (1.2, 0.7, 0.4), order=order)
    faces = fem.faces_seen_from(mesh, np.array(direction))
    axis = int(np.flatnonzero(direction)[0])
    assert area(mesh, faces) == pytest.approx(np.prod(np.delete([1.2, 0.7, 0.4], axis)))
    np.testing.assert_allclose(mesh.nodes[faces][..., axis], side, atol=1e-12)


def test_what_lies_under_something_is_not_seen(overhang):
    above = fem.faces_seen_from(overhang, np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(overhang.nodes[above][..., 2], 3.0)
    assert area(overhang, above) == pytest.approx(2.0)
    # from the open side both the ends of floor and roof and the pillar between them are seen
    ahead = fem.faces_seen_from(overhang, np.array([1.0, 0.0, 0.0]))
    assert area(overhang, ahead) == pytest.approx(3.0)
    assert sorted(set(overhang.nodes[ahead][..., 0].ravel().round(9).tolist())) == [1.0, 2.0]


def test_a_slanted_line_of_sight_reaches_under_a_roof(overhang):
    # the room is 1 m high under 1 m of roof: at 45 degrees all of its floor is seen, at twice the rise half
    for rise, seen_area in ((1.0, 1.0), (2.0, 0.5)):
        seen = fem.faces_seen_from(overhang, np.array([1.0, 0.0, rise]), 0.5)
        floor = seen[np.isclose(overhang.nodes[seen][..., 2], 1.0).all(axis=1)]
        assert area(overhang, floor) == pytest.approx(seen_area)
        assert overhang.nodes[floor][..., 0].min() == pytest.approx(2.0 - seen_area)


def test_curved_sides_are_told_by_their_slope():
    half_ring = box_mesh((1, 36, 1), (1.0, 1.0, 1.0), tube(1.0, 2.0, np.pi))
    outside = fem.faces_seen_from(half_ring, np.array([0.0, 1.0, 0.0]), np.cos(np.radians(62.0)))
    # 24 of 36 sectors of 5 degrees lie within 60 degrees of the crown
    assert area(half_ring, outside) == pytest.approx(2.0 * np.pi * 24 / 36, rel=1e-4)


def test_faces_that_hang_together_with_a_seed(overhang):
    level = overhang.boundary[np.isin(overhang.nodes[overhang.boundary[:, :3], 2], [1.0, 3.0]).all(axis=1)]
    flat = np.ptp(overhang.nodes[level[:, :3], 2], axis=1) == 0.0
    roof = level[flat & (overhang.nodes[level[:, 0], 2] == 3.0)]
    joined = fem.faces_joined_to(level[flat], roof[:1])
    assert {tuple(f) for f in joined.tolist()} == {tuple(f) for f in roof.tolist()}
    assert len(fem.faces_joined_to(level[flat], overhang.boundary[:0])) == 0
    assert len(fem.faces_joined_to(overhang.boundary[:0], roof)) == 0


def test_faulty_views(overhang):
    told = "direction must be three finite numbers other than zero"
    for direction in ([0, 0, 0], [0, 0, np.nan], [1, 0]):
        refused(told, fem.faces_seen_from, overhang, np.array(direction), 0.5)
    up = np.array([0, 0, 1])
    refused(r"least_cosine must lie in \(0, 1\], got 0", fem.faces_seen_from, overhang, up, 0.0)


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


def test_rails_are_found_by_their_surface(shoe):
    right, left = flat_parts(shoe.mesh, "roller path")
    np.testing.assert_allclose([right.low[1], right.high[1]], [-0.35, -0.13], atol=1e-9)
    np.testing.assert_allclose([left.low[1], left.high[1]], [0.13, 0.35], atol=1e-9)
    assert right.height == pytest.approx(0.2235)


def test_samples_are_the_elements_shape_functions(underside):
    """Quadratic ones: they give the places, and their products, of any point."""
    rng = np.random.default_rng(1)
    x, y = rng.uniform(underside.low, underside.high, (200, 2)).T
    shapes = underside.samples(x, y)
    nodes = underside.mesh.nodes
    for field in (lambda x, y: 1.0 + 0.0 * x, lambda x, y: x, lambda x, y: x * y, lambda x, y: y**2):
        np.testing.assert_allclose(shapes @ field(nodes[:, 0], nodes[:, 1]), field(x, y), atol=1e-8)


def test_a_grids_tractions_have_the_resultants_of_a_rectangle(underside):
    rng = np.random.default_rng(2)
    grid = PressureGrid(underside, (3, 9))
    assert grid.weights.sum() == pytest.approx(np.prod(underside.high - underside.low))
    forces = rng.standard_normal((6, 3))
    corners = np.sort(rng.uniform(underside.low, underside.high, (2, 6, 2)), axis=0)
    middles = np.column_stack((corners.mean(axis=0), np.full(6, underside.height)))
    assert_resultants(underside.mesh, grid.weights, grid.coordinates(forces, *corners), forces, middles)


def test_what_has_no_width_on_the_grid_is_a_line_on_its_edge(underside):
    grid = PressureGrid(underside, (3, 4))
    low, force = np.array([[underside.high[0] + 0.001, -0.5]]), np.ones((1, 3))
    tractions = grid.coordinates(force, low, low + np.array([0.01, 0.3]))
    on_edge = np.array([[underside.high[0], -0.35, underside.height]])
    assert_resultants(underside.mesh, grid.weights, tractions, force, on_edge)
    assert grid.coordinates(np.empty((0, 3)), low[:0], low[:0]).shape == (0, 12, 3)


@pytest.mark.parametrize("count", [2, 3, 9])
def test_stations_carry_forces_between_them_with_their_moment(shoe, count):
    rail = flat_parts(shoe.mesh, "roller path")[0]
    stations = Stations(rail, count, 0.1)
    x = np.linspace(rail.low[0], rail.high[0], 11)
    forces = np.random.default_rng(3).standard_normal((11, 3))
    middle = 0.5 * (rail.low[1] + rail.high[1])
    places = np.column_stack((x, np.full(11, middle), np.full(11, rail.height)))
    assert_resultants(shoe.mesh, stations.weights, stations.coordinates(forces, x), forces, places)
    at_x = np.eye(11)[:, :, None] * forces
    assert_resultants(shoe.mesh, stations.weights_at(x), at_x, forces, places)


def test_bad_places(shoe, underside):
    for told, name, low, high in (
        ("low must be below high", "underside", [0.1, 0.0], [0.1, 1.0]),
        (r"'top' must be level .* faces of heights", "top", [-0.2, -0.9], [0.2, 0.9]),
        (r"must be level .* got 0 faces", "roller path", [1.0, 1.0], [2.0, 2.0]),
        (r"'roller path' must cover .* got a gap", "roller path", [-0.2, -0.35], [0.2, 0.5]),
    ):
        refused(told, FlatRectangle, shoe.mesh, name, low, high)
    refused(r"counts must be at least 2 .* got \(1, 4\)", PressureGrid, underside, (1, 4))
    refused("count must be at least 2, got 1", Stations, underside, 1, 0.1)
    refused(r"reach must lie in \(0, 0.315\] m.* got 0.4", Stations, underside, 3, 0.4)
    stations, x = Stations(underside, 3, 0.1), np.array([0.1, 0.4])
    refused(r"x must lie in -0.315..0.315 m, got 0.1..0.4", stations.weights_at, x)
    refused(r"x must lie in .* at which a force acts, got 0.4", stations.coordinates, np.ones((2, 3)), x)
    assert not stations.coordinates(np.zeros((1, 3)), np.array([0.4])).any()


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


def test_linear_shapes_are_integrated_exactly(positions):
    """Their mean over a rectangle is the displacement of its middle."""
    rng = np.random.default_rng(9)
    constant, slopes = rng.standard_normal((3, 4)), rng.standard_normal((2, 3, 4))

    def shapes(places):
        return constant + np.tensordot(places, slopes, axes=1)

    found = integrate_underside(positions, shapes(positions), FOOTPRINT)
    assert found.mode_count == 4
    # 70 cells of 30 mm to rounding
    assert (found.cell <= CELL * (1.0 + 1e-12)).all()
    columns, rows = found.integral.shape[0] - 1, found.integral.shape[1] - 1
    for i, j in ((columns, rows), (columns // 3, rows // 2), (1, rows)):
        sides = np.array([i, j]) * found.cell
        expected = sides.prod() * shapes(found.corner + sides / 2)
        np.testing.assert_allclose(found.integral[i, j], expected, atol=1e-12)
    low = found.corner + rng.integers(0, 5, (50, 2)) * found.cell
    high = low + rng.integers(1, 8, (50, 2)) * found.cell
    np.testing.assert_allclose(sums(found, low, high), shapes((low + high) / 2), atol=1e-10)


def test_nodes_that_leave_a_part_out_are_refused(positions):
    wider = FOOTPRINT + np.array([0.0, 0.2 * (FOOTPRINT[1] - FOOTPRINT[0]), 0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match=r"surround the rectangle .* got \d+ of its \d+ cells outside"):
        integrate_underside(positions, np.zeros((len(positions), 3, 1)), wider)


def test_cells_beside_the_nodes_move_with_the_nearest_one(positions):
    length = FOOTPRINT[1] - FOOTPRINT[0]
    wider = FOOTPRINT + np.array([0.0, 0.05 * length, 0.0, 0.0, 0.0])
    shift = np.broadcast_to([[[1.0], [2.0], [3.0]]], (len(positions), 3, 1))
    found = integrate_underside(positions, shift, wider)
    area = 1.05 * length * (FOOTPRINT[3] - FOOTPRINT[2])
    np.testing.assert_allclose(found.integral[-1, -1, :, 0], area * np.array([1.0, 2.0, 3.0]), rtol=1e-9)


def test_means_over_any_rectangles_are_those_of_the_equations(positions):
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


def test_hats_over_a_narrow_underside_are_those_of_an_even_motion():
    """Over the tips of a grouser, which is narrower than a cell is elsewhere."""
    x, y = (side.ravel() for side in np.meshgrid([-0.01, 0.01], np.linspace(-0.35, 0.35, 8)))
    modes = np.zeros((len(x), 3, 1))
    modes[:, 2, 0] = 0.3 + 2.0 * x - 0.7 * y
    underside = integrate_underside(np.column_stack((x, y)), modes, np.array([-0.01, 0.01, -0.35, 0.35, 0.0]))
    nodes, rows = hat_grid(underside, (3, 9))
    np.testing.assert_allclose(rows[..., 2, 0], nodes @ (2.0, -0.7) + 0.3, atol=1e-9)
