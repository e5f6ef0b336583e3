"""What elements disagree on."""

import numpy as np

import fem
from meshes import STEEL


def test_jump_tells_a_peak_that_the_mesh_makes(beam: fem.ElasticBody) -> None:
    smooth = beam.mesh.nodes @ np.diag([1e-4, 0.0, 0.0])
    assert fem.stress.stress_jump(beam.mesh, STEEL, smooth).max() < 1e-3  # Pa; rounding
    kinked = np.where(beam.mesh.nodes[:, :1] > 0.3, beam.mesh.nodes - 0.3, 0.0) * [1e-4, 0, 0]
    jump = fem.stress.stress_jump(beam.mesh, STEEL, kinked)
    at_kink = np.abs(beam.mesh.nodes[:, 0] - 0.3) < 1e-9
    assert jump[at_kink].min() > 0.2 * 200e9 * 1e-4
    assert jump[np.abs(beam.mesh.nodes[:, 0] - 0.3) > 0.11].max() < 1e-3
