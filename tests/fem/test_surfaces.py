"""Faces found by where they look, on a step small enough to see through, and what is integrated over them."""

import numpy as np
import pytest

import fem
from tests.fem.bodies import box_mesh, tube


@pytest.fixture(scope="module")
def overhang() -> fem.Mesh:
    """Cubes of 1 m as a C seen from the side: floor 2 m long, pillar at x in 0..1, roof 2 m long."""
    mesh = box_mesh((4, 2, 6), (2.0, 1.0, 3.0))
    centers = mesh.nodes[mesh.elements[:, :4]].mean(axis=1)
    room = (centers[:, 0] > 1.0) & (centers[:, 2] > 1.0) & (centers[:, 2] < 2.0)
    used, elements = np.unique(mesh.elements[~room], return_inverse=True)
    return fem.Mesh(mesh.nodes[used], elements.reshape(-1, 10), {})


def area(mesh: fem.Mesh, faces: np.ndarray) -> float:
    return float(fem.surfaces.surface_weights(mesh, faces).sum())


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("direction", [[0, 0, 1], [0, -3, 0], [1, 0, 0]])
def test_one_side_of_a_box(order: int, direction: list[float]) -> None:
    mesh = box_mesh((3, 2, 2), (1.2, 0.7, 0.4), order=order)
    faces = fem.faces_seen_from(mesh, np.array(direction))
    axis = int(np.flatnonzero(direction)[0])
    assert area(mesh, faces) == pytest.approx(np.prod(np.delete([1.2, 0.7, 0.4], axis)))
    side = [0.0, 0.7, 0.4][axis] if axis != 0 else 1.2
    np.testing.assert_allclose(mesh.nodes[faces][..., axis], 0.0 if axis == 1 else side, atol=1e-12)


def test_what_lies_under_something_is_not_seen(overhang: fem.Mesh) -> None:
    above = fem.faces_seen_from(overhang, np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(overhang.nodes[above][..., 2], 3.0)
    assert area(overhang, above) == pytest.approx(2.0)
    # from the open side both the ends of floor and roof and the pillar between them are seen
    ahead = fem.faces_seen_from(overhang, np.array([1.0, 0.0, 0.0]))
    assert area(overhang, ahead) == pytest.approx(3.0)
    assert sorted(set(overhang.nodes[ahead][..., 0].ravel().round(9).tolist())) == [1.0, 2.0]


def test_a_slanted_line_of_sight_reaches_under_a_roof(overhang: fem.Mesh) -> None:
    # the room is 1 m high under 1 m of roof: at 45 degrees all of its floor is seen, at twice the rise half
    for rise, seen_area in ((1.0, 1.0), (2.0, 0.5)):
        seen = fem.faces_seen_from(overhang, np.array([1.0, 0.0, rise]), 0.5)
        floor = seen[np.isclose(overhang.nodes[seen][..., 2], 1.0).all(axis=1)]
        assert area(overhang, floor) == pytest.approx(seen_area)
        assert overhang.nodes[floor][..., 0].min() == pytest.approx(2.0 - seen_area)


def test_curved_sides_are_told_by_their_slope() -> None:
    half_ring = box_mesh((1, 36, 1), (1.0, 1.0, 1.0), tube(1.0, 2.0, np.pi))
    steep = np.cos(np.radians(62.0))
    outside = fem.faces_seen_from(half_ring, np.array([0.0, 1.0, 0.0]), steep)
    # 24 of 36 sectors of 5 degrees lie within 60 degrees of the crown
    assert area(half_ring, outside) == pytest.approx(2.0 * np.pi * 24 / 36, rel=1e-4)


def test_faces_that_hang_together_with_a_seed(overhang: fem.Mesh) -> None:
    level = overhang.boundary[np.isin(overhang.nodes[overhang.boundary[:, :3], 2], [1.0, 3.0]).all(axis=1)]
    flat = np.ptp(overhang.nodes[level[:, :3], 2], axis=1) == 0.0
    roof = level[flat & (overhang.nodes[level[:, 0], 2] == 3.0)]
    joined = fem.faces_joined_to(level[flat], roof[:1])
    assert {tuple(f) for f in joined.tolist()} == {tuple(f) for f in roof.tolist()}
    assert len(fem.faces_joined_to(level[flat], overhang.boundary[:0])) == 0
    assert len(fem.faces_joined_to(overhang.boundary[:0], roof)) == 0


@pytest.mark.parametrize(
    ("direction", "cosine", "words"),
    [
        ([0, 0, 0], 0.5, "direction must be three finite numbers other than zero"),
        ([0, 0, np.nan], 0.5, "direction must be three finite numbers other than zero"),
        ([1, 0], 0.5, "direction must be three finite numbers other than zero"),
        ([0, 0, 1], 0.0, r"least_cosine must lie in \(0, 1\], got 0"),
    ],
)
def test_faulty_views(overhang: fem.Mesh, direction: list[float], cosine: float, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        fem.faces_seen_from(overhang, np.array(direction), cosine)
