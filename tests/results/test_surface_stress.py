"""Stress on a shoe's surface, and the flat triangles that it is drawn on."""

import numpy as np
import pytest

from exudyn_crawler.results.stress.basis import TOLERANCE
from exudyn_crawler.results.stress.hot_spots import flat_triangles
from exudyn_crawler.results.stress.recovery import surface_stress
from meshes import mesh_named


def volume(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0


def test_flat_triangles_close_the_surface_and_follow_its_round_parts():
    mesh = mesh_named("coarse")
    fine, corners = flat_triangles(mesh.boundary), mesh.boundary[:, :3]
    edges = np.sort(np.concatenate([fine[:, [0, 1]], fine[:, [1, 2]], fine[:, [2, 0]]]))
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert np.array_equal(np.unique(fine), mesh.surface_nodes)
    off = abs(volume(mesh.nodes, fine) - mesh.volume)
    assert off < 0.3 * abs(volume(mesh.nodes, corners) - mesh.volume)
    assert off < 1e-3 * mesh.volume


def test_the_surface_has_the_stresses_of_the_whole_shoe(flexible_run):
    history, stress, _ = flexible_run
    found = surface_stress(history, 13, [0, history.time.size - 1])
    nodes = np.unique(stress.triangle.values)
    own = stress.sel(shoe=13).isel(node=nodes)
    # of one shoe other static fields are left out than of both
    np.testing.assert_allclose(
        found.von_mises.values, own.frame_von_mises.values, rtol=1e-5, atol=2.0 * TOLERANCE
    )
    bend = own.frame_displacement.values
    np.testing.assert_allclose(found.displacement.values, bend, atol=1e-3 * np.abs(bend).max())
    assert np.array_equal(nodes[found.triangle.values], stress.triangle.values)
    with pytest.raises(ValueError, match=r"flexible one of the history, of \[7, 13\], got 5"):
        surface_stress(history, 5, [0])
