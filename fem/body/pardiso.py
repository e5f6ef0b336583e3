"""Factors of a symmetric positive definite matrix by PARDISO of MKL, whose library pypardiso brings.

PARDISO gets plain addresses. The pointers that NumPy makes of arrays refer to themselves: with them the
matrix and both sides of each solution would stay in memory until Python searches for such cycles.
"""

import ctypes
from functools import cache
from typing import Any

import numpy as np
from scipy.sparse import csr_array, triu

from fem.body.mesh import Floats

SYMMETRIC_POSITIVE_DEFINITE = 2
ANALYSE_AND_FACTORIZE = 12
SOLVE = 33
RELEASE = -1
BY_DEFAULT, CHOSEN = 0, 1
"""Values of the first of PARDISO's parameters."""
ARGUMENTS = 16
WORDS = 64
"""Length of PARDISO's handle and of its parameters."""


@cache
def library() -> Any:
    """Library that has PARDISO, looked for late since that takes long; None if there is no wheel."""
    try:
        from pypardiso import ps
    except ImportError:
        return None
    return ps.libmkl


class Factors:
    """Factors of a matrix, in memory that Python does not manage until they are released.

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
        # an index gives a function of its own, with types of its own
        self._pardiso = library()["pardiso"]
        self._pardiso.argtypes = [ctypes.c_void_p] * ARGUMENTS
        self._pardiso.restype = None
        self._call(ANALYSE_AND_FACTORIZE, np.zeros((upper.shape[0], 1)))

    def solve(self, forces: Floats, refined: bool) -> Floats:
        """Solution (n, k) for right-hand sides (n, k)."""
        # chosen parameters are zeros but for this one, without refinement among them
        self._parameters[0] = BY_DEFAULT if refined else CHOSEN
        return np.ascontiguousarray(self._call(SOLVE, np.asfortranarray(forces, dtype=np.float64)))

    def release(self) -> None:
        """Free the factors; there is no solution behind it."""
        self._call(RELEASE, np.zeros((len(self._rows) - 1, 1)))

    def _call(self, phase: int, sides: Floats) -> Floats:
        """Right-hand sides (n, k), one column after the other, through a phase: array (n, k) alike."""
        answers = np.zeros_like(sides)
        nothing = np.zeros(1, dtype=np.int32)
        error = ctypes.c_int32(0)
        one = ctypes.c_int32(1)
        self._pardiso(
            self._handle.ctypes.data,
            ctypes.byref(one),  # matrices with these places of entries
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
