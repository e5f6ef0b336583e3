"""Direct solvers agree."""

import numpy as np
import pytest

import fem
from fem.solver import default_backend, factorized


def test_solvers_agree(beam: fem.ElasticBody) -> None:
    matrix = beam.stiffness + beam.shift * beam.mass_matrix
    b = np.random.default_rng(0).standard_normal((matrix.shape[0], 3))
    superlu = factorized(matrix, "superlu")(b)
    other = factorized(matrix, default_backend())(b)
    assert np.abs(other - superlu).max() < 1e-8 * np.abs(superlu).max()
    np.testing.assert_array_equal(factorized(matrix)(b[:, 0]).shape, (len(b),))


def test_unknown_solver(beam: fem.ElasticBody) -> None:
    with pytest.raises(ValueError, match=r"backend must be .* got 'magic'"):
        factorized(beam.stiffness, "magic")  # type: ignore[arg-type]
