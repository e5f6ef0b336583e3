"""Sparse direct solution of symmetric positive definite systems: PARDISO or SuperLU."""

import weakref
from typing import Literal, Protocol

import numpy as np
from scipy.sparse import csc_matrix, csr_array
from scipy.sparse.linalg import splu

from fem.body import pardiso
from fem.body.mesh import Floats

Backend = Literal["pardiso", "superlu"]


def default_backend() -> Backend:
    """Return "pardiso" where its wheel is installed, "superlu" elsewhere."""
    return "superlu" if pardiso.library() is None else "pardiso"


class Solve(Protocol):
    """Solution of a factorized system."""

    def __call__(self, forces: Floats, refined: bool = True) -> Floats:
        """Solve for right-hand sides (n,) or (n, k); two steps of refinement take six times as long.

        Right-hand sides stored column by column need no copy.
        """


def factorized(matrix: csr_array, backend: Backend | None = None) -> Solve:
    """Factorize a symmetric positive definite matrix.

    Parameters
    ----------
    matrix : sparse array (n, n)
    backend : str, optional
        "pardiso" or "superlu"; `default_backend` if left out.

    Returns
    -------
    Solve
        Solver; SuperLU never refines.

    Raises
    ------
    ValueError
        If the back end is unknown or not installed.
    """
    backend = backend or default_backend()
    if backend == "superlu":
        factors = splu(
            csc_matrix(matrix),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )

        def solve_superlu(forces: Floats, refined: bool = True) -> Floats:
            return np.asarray(factors.solve(np.ascontiguousarray(forces, dtype=np.float64)))

        return solve_superlu
    if backend != "pardiso" or pardiso.library() is None:
        raise ValueError(f"backend must be 'superlu' or, where installed, 'pardiso', got {backend!r}")

    held = pardiso.Factors(matrix)

    def solve(forces: Floats, refined: bool = True) -> Floats:
        return held.solve(forces.reshape(len(forces), -1), refined).reshape(forces.shape)

    weakref.finalize(solve, held.release)
    return solve
