"""Sparse direct solution of symmetric positive definite systems: PARDISO or SuperLU."""

import os
import weakref
from collections.abc import Callable
from functools import cache
from typing import Any, Literal

import numpy as np
from scipy.sparse import csc_matrix, csr_array, csr_matrix, triu
from scipy.sparse.linalg import splu

from fem.mesh import Floats

Backend = Literal["pardiso", "superlu"]
SYMMETRIC_POSITIVE_DEFINITE = 2
ANALYSE_AND_FACTORIZE = 12
SOLVE = 33
RELEASE = -1
CHOSEN, NESTED_DISSECTION = 1, 2
"""Values of the first two of PARDISO's parameters: not its defaults, but METIS orders the unknowns, too."""


@cache
def _pardiso() -> Any:
    """Package of PARDISO, imported late since that takes long; None if there is no wheel."""
    try:
        import pypardiso
    except ImportError:
        return None
    # each of its solvers searches the whole installation for the library, half a second, unless it is named
    os.environ.setdefault("PYPARDISO_MKL_RT", pypardiso.ps.libmkl._name)
    return pypardiso


def default_backend() -> Backend:
    """PARDISO where its wheel exists, SuperLU elsewhere."""
    return "superlu" if _pardiso() is None else "pardiso"


def factorized(matrix: csr_array, backend: Backend | None = None) -> Callable[[Floats], Floats]:
    """Factorize a symmetric positive definite matrix.

    Parameters
    ----------
    matrix : sparse array (n, n)
    backend : str, optional
        "pardiso" or "superlu"; `default_backend` if left out.

    Returns
    -------
    callable
        Solution for right-hand sides (n,) or (n, k).

    Raises
    ------
    ValueError
        If the back end is not known or not installed.
    """
    backend = backend or default_backend()
    if backend == "superlu":
        factors = splu(
            csc_matrix(matrix),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        return lambda b: factors.solve(np.ascontiguousarray(b, dtype=np.float64))
    pypardiso = _pardiso()
    if backend != "pardiso" or pypardiso is None:
        raise ValueError(f"backend must be 'superlu' or, where installed, 'pardiso', got {backend!r}")

    upper = csr_matrix(triu(matrix, format="csr"))
    upper.sort_indices()
    solver = pypardiso.PyPardisoSolver(mtype=SYMMETRIC_POSITIVE_DEFINITE)
    # by default it refines each answer twice, for six times the time and a residual as large
    solver.set_iparm(1, CHOSEN)
    solver.set_iparm(2, NESTED_DISSECTION)
    empty = np.zeros((upper.shape[0], 1))
    solver.set_phase(ANALYSE_AND_FACTORIZE)
    solver._call_pardiso(upper, empty)
    solver.set_phase(SOLVE)

    def solve(b: Floats) -> Floats:
        columns = np.asfortranarray(b.reshape(len(b), -1), dtype=np.float64)
        return np.asarray(solver._call_pardiso(upper, columns)).reshape(b.shape)

    weakref.finalize(solve, _release, solver, upper, empty)
    return solve


def _release(solver: Any, upper: csr_matrix, empty: Floats) -> None:
    """Release the memory of PARDISO's factors, which Python does not manage."""
    solver.set_phase(RELEASE)
    solver._call_pardiso(upper, empty)
