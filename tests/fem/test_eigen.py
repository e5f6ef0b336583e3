"""Block Lanczos against dense algebra."""

import numpy as np
import pytest
import scipy.linalg

import fem
from fem.eigen import lowest_modes
from meshes import STEEL
from tests.fem.bodies import beam_interfaces, box_mesh


def test_block_lanczos_against_dense() -> None:
    body = fem.ElasticBody(box_mesh((8, 2, 2), (1.0, 0.2, 0.25)), STEEL)
    found, modes = body.free_modes(40)
    k, m = body.stiffness.toarray(), body.mass_matrix.toarray()
    exact = scipy.linalg.eigh(k, m, eigvals_only=True, subset_by_index=(0, 39))
    np.testing.assert_allclose(found[6:], exact[6:], rtol=1e-10)
    np.testing.assert_allclose(modes.T @ m @ modes, np.eye(40), atol=1e-12)


def test_too_many_modes(beam: fem.ElasticBody) -> None:
    size = beam.stiffness.shape[0]
    with pytest.raises(ValueError, match=f"count must be in 1..{size}, .* got {size + 1}"):
        lowest_modes(beam.stiffness, beam.mass_matrix, size + 1)
    with pytest.raises(ValueError, match=r"n_fixed_modes must lie in .* got 5000"):
        fem.craig_bampton(beam, beam_interfaces(beam), 5000)
