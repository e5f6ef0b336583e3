"""Sparse direct solution of symmetric positive definite systems: PARDISO or SuperLU."""

import os
import weakref
from functools import cache
from typing import Any, Literal, Protocol

import numpy as np
from scipy.sparse import csc_matrix, csr_array, csr_matrix, triu
from scipy.sparse.linalg import splu

from fem.mesh import Floats

Backend = Literal["pardiso", "superlu"]
SYMMETRIC_POSITIVE_DEFINITE = 2
ANALYSE_AND_FACTORIZE = 12
SOLVE = 33
RELEASE = -1
BY_DEFAULT, CHOSEN = 0, 1
"""Values of the first of PARDISO's parameters."""


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


class Solve(Protocol):
    """Solution of a factorized system."""

    def __call__(self, forces: Floats, refined: bool = True) -> Floats:
        """Solution for right-hand sides (n,) or (n, k); two steps of refinement take six times as long."""


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
        SuperLU refines no answer.

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

        def solve_superlu(forces: Floats, refined: bool = True) -> Floats:
            return np.asarray(factors.solve(np.ascontiguousarray(forces, dtype=np.float64)))

        return solve_superlu
    pypardiso = _pardiso()
    if backend != "pardiso" or pypardiso is None:
        raise ValueError(f"backend must be 'superlu' or, where installed, 'pardiso', got {backend!r}")

    upper = csr_matrix(triu(matrix, format="csr"))
    upper.sort_indices()
    solver = pypardiso.PyPardisoSolver(mtype=SYMMETRIC_POSITIVE_DEFINITE)
    empty = np.zeros((upper.shape[0], 1))
    solver.set_phase(ANALYSE_AND_FACTORIZE)
    solver._call_pardiso(upper, empty)
    solver.set_phase(SOLVE)

    def solve(forces: Floats, refined: bool = True) -> Floats:
        # chosen parameters are zeros but for this one, without refinement among them
        solver.set_iparm(1, BY_DEFAULT if refined else CHOSEN)
        columns = np.asfortranarray(forces.reshape(len(forces), -1), dtype=np.float64)
        return np.asarray(solver._call_pardiso(upper, columns)).reshape(forces.shape)

    weakref.finalize(solve, _release, solver, upper, empty)
    return solve


def _release(solver: Any, upper: csr_matrix, empty: Floats) -> None:
    """Release the memory of PARDISO's factors, which Python does not manage."""
    solver.set_phase(RELEASE)
    solver._call_pardiso(upper, empty)
