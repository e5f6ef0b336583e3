"""Factors of a symmetric positive definite matrix by MKL's PARDISO, from the library of pypardiso.

PARDISO gets plain addresses. NumPy's pointers to arrays refer to themselves: they would keep the matrix and
both sides of each solution in memory until Python collects such cycles.
"""

import ctypes
import os
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, files
from typing import Any

import numpy as np
from scipy.sparse import csr_array, triu

from fem.body.mesh import Floats

SYMMETRIC_POSITIVE_DEFINITE = 2
ANALYSE_AND_FACTORIZE = 12
SOLVE = 33
RELEASE = -1
BY_DEFAULT, CHOSEN = 0, 1
"""Values of PARDISO's first parameter."""
ARGUMENTS = 16
WORDS = 64
"""Length of PARDISO's handle and of its parameters."""
PATH_OF_MKL = "PYPARDISO_MKL_RT"
"""Variable with the path of MKL, without which pypardiso searches all installed files for 0.5 s."""


@cache
def library() -> Any:
    """Return the library with PARDISO, imported late since that takes long; None without pypardiso."""
    with suppress(PackageNotFoundError):
        for file in files("mkl") or ():
            if "mkl_rt" in file.name:
                os.environ.setdefault(PATH_OF_MKL, str(file.locate()))
    try:
        from pypardiso import ps
    except ImportError:
        return None
    return ps.libmkl


class Factors:
    """Factors of a matrix, in memory that Python does not manage, until they are released.

    Parameters
    ----------
    matrix : sparse array (n, n)
        Symmetric positive definite.

    Raises
    ------
    RuntimeError
        If PARDISO fails.
    """

    def __init__(self, matrix: csr_array) -> None:
        upper = csr_array(triu(matrix, format="csr"))
        upper.sort_indices()
        self._values = upper.data
        # PARDISO counts from 1
        self._rows = upper.indptr.astype(np.int32, copy=False) + np.int32(1)
        self._columns = upper.indices.astype(np.int32, copy=False) + np.int32(1)
        self._handle = np.zeros(WORDS, dtype=np.int64)
        self._parameters = np.zeros(WORDS, dtype=np.int32)
        # an index gives a separate function object with its own argument types
        self._pardiso = library()["pardiso"]
        self._pardiso.argtypes = [ctypes.c_void_p] * ARGUMENTS
        self._pardiso.restype = None
        self._call(ANALYSE_AND_FACTORIZE, np.zeros((upper.shape[0], 1)))

    def solve(self, forces: Floats, refined: bool) -> Floats:
        """Return the solution (n, k) for right-hand sides (n, k)."""
        # with chosen parameters all others are zero, so that there is no refinement
        self._parameters[0] = BY_DEFAULT if refined else CHOSEN
        return np.ascontiguousarray(self._call(SOLVE, np.asfortranarray(forces, dtype=np.float64)))

    def release(self) -> None:
        """Free the factors; no solution is possible afterwards."""
        self._call(RELEASE, np.zeros((len(self._rows) - 1, 1)))

    def _call(self, phase: int, sides: Floats) -> Floats:
        """Run a phase with right-hand sides (n, k) stored by columns; return an array of this shape."""
        answers = np.zeros_like(sides)
        nothing = np.zeros(1, dtype=np.int32)
        error = ctypes.c_int32(0)
        one = ctypes.c_int32(1)
        self._pardiso(
            self._handle.ctypes.data,
            ctypes.byref(one),  # matrices with this sparsity pattern
            ctypes.byref(one),  # number of this one among them
            ctypes.byref(ctypes.c_int32(SYMMETRIC_POSITIVE_DEFINITE)),
            ctypes.byref(ctypes.c_int32(phase)),
            ctypes.byref(ctypes.c_int32(len(sides))),
            self._values.ctypes.data,
            self._rows.ctypes.data,
            self._columns.ctypes.data,
            nothing.ctypes.data,  # permutation, which PARDISO chooses
            ctypes.byref(ctypes.c_int32(sides.shape[1])),
            self._parameters.ctypes.data,
            ctypes.byref(ctypes.c_int32(0)),  # prints nothing
            sides.ctypes.data,
            answers.ctypes.data,
            ctypes.byref(error),
        )
        if error.value:
            raise RuntimeError(f"PARDISO must solve the system, got its error {error.value} in phase {phase}")
        return answers
