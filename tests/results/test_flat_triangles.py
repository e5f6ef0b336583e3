"""Flat triangles that the stress on a shoe's surface is drawn on."""

import numpy as np

from exudyn_crawler.results.stress.hot_spots import flat_triangles
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
