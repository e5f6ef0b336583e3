"""The ready meshes meet what the papers say of the shoe."""

import numpy as np
import pytest

import fem
import meshes
from meshes import STEEL
from meshes.geometry import NODES, VOLUMES


@pytest.fixture(scope="module", params=["coarse", "study"])
def shoe(request: pytest.FixtureRequest) -> fem.ElasticBody:
    return fem.ElasticBody(meshes.shoe_mesh(request.param), STEEL)


@pytest.mark.parametrize("size", meshes.SHOE_SIZES)
def test_volumes_and_nodes_are_those_of_the_files(size: str) -> None:
    assert list(VOLUMES) == list(NODES) == list(meshes.SHOE_SIZES)
    mesh = meshes.shoe_mesh(size)
    assert mesh.volume == pytest.approx(VOLUMES[size], rel=1e-12)
    assert len(mesh.nodes) == NODES[size]


def test_mass_and_center(shoe: fem.ElasticBody) -> None:
    assert shoe.mass == pytest.approx(4489.63, rel=0.01)
    x, y, z = shoe.center_of_mass
    assert abs(x) < 0.002
    assert abs(y) < 0.002
    height = z + meshes.COM_HEIGHT
    assert 0.2025 * 0.99 <= height <= 0.204 * 1.01


def assert_bores_at_pins(mesh: fem.Mesh) -> list[np.ndarray]:
    """Bores have the radius and middles of the pins; distances of their nodes from the axes."""
    distances = []
    for name, center in meshes.JOINT_CENTERS.items():
        bore = mesh.nodes[mesh.nodes_of(f"bore {name}")]
        distances.append(np.hypot(bore[:, 0] - center[0], bore[:, 2] - center[2]))
        assert np.median(distances[-1]) == pytest.approx(meshes.ShoeDimensions.bore_radius, abs=1e-6)
        assert (bore[:, 1].min() + bore[:, 1].max()) / 2 == pytest.approx(center[1], abs=1e-6)
    return distances


def test_bores_are_where_the_pins_are(shoe: fem.ElasticBody) -> None:
    for distance in assert_bores_at_pins(shoe.mesh):
        # mid-side nodes leave the arc only where an edge was straightened: a sixth of a circle at most
        assert distance.min() > np.cos(np.pi / 6) * meshes.ShoeDimensions.bore_radius


def test_pins_of_neighbours_coincide() -> None:
    for side in ("left", "right"):
        front, rear = (np.array(meshes.JOINT_CENTERS[f"{end} {side}"]) for end in ("front", "rear"))
        np.testing.assert_allclose(front - rear, [meshes.PITCH, 0, 0], atol=1e-12)
        assert front[1] + 9.2901 == pytest.approx({"right": 8.68, "left": 10.03}[side])


def test_underside_is_flat_and_as_wide_as_the_paper_says(shoe: fem.ElasticBody) -> None:
    under = shoe.mesh.nodes[shoe.mesh.nodes_of("underside")]
    np.testing.assert_allclose(under[:, 2], -meshes.COM_HEIGHT, atol=1e-9)
    assert np.ptp(under[:, 1]) == pytest.approx(3.505)
    assert shoe.surface_weights("underside").sum() == pytest.approx(3.505 * 0.63)


def test_named_surfaces(shoe: fem.ElasticBody) -> None:
    names = {"underside", "top", "roller path"} | {f"bore {n}" for n in meshes.JOINT_CENTERS}
    assert set(shoe.mesh.surfaces) == names
    top = {tuple(sorted(f)) for f in shoe.mesh.surface("top").tolist()}
    assert {tuple(sorted(f)) for f in shoe.mesh.surface("roller path").tolist()} < top
    weights = shoe.surface_weights("top")
    centroid = weights @ shoe.mesh.nodes / weights.sum()
    assert np.abs(centroid[:2]).max() < 0.015


@pytest.mark.simulation
def test_neighbours_do_not_overlap() -> None:
    # not the coarse mesh: its chords cut more than the clearances off throat and nose
    mesh = meshes.shoe_mesh("study")
    corners, low, high = mesh.nodes[mesh.elements[:, :4]], mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
    for pitch in (meshes.PITCH, -meshes.PITCH):
        points = mesh.nodes[mesh.surface_nodes] + [pitch, 0.0, 0.0]
        points = points[((points > low) & (points < high)).all(axis=1)]
        assert len(points) > 100
        near = corners[
            (corners.max(axis=1) > points.min(axis=0)).all(axis=1)
            & (corners.min(axis=1) < points.max(axis=0)).all(axis=1)
        ]
        frames = np.linalg.inv((near[:, 1:] - near[:, :1]).transpose(0, 2, 1))
        for chunk in np.array_split(points, max(1, len(points) // 200)):
            local = np.einsum("eij,epj->epi", frames, chunk[None] - near[:, :1])
            inside = (local > 1e-6).all(axis=2) & (local.sum(axis=2) < 1 - 1e-6)
            assert not inside.any()


def test_unknown_size() -> None:
    with pytest.raises(ValueError, match=r"size must be one of .* got 'huge'"):
        meshes.shoe_path("huge")


@pytest.mark.slow
def test_study_and_fine_mesh_bend_at_178_hz() -> None:
    for size in ("study", "fine"):
        found = fem.ElasticBody(meshes.shoe_mesh(size), STEEL).natural_frequencies(7)[6]
        assert found == pytest.approx(178.07, rel=0.02)
