"""Lowest modes of K u = w^2 M u by shift-inverted block Lanczos.

Single solves dominate the usual Lanczos iteration. The direct solver needs about a third of their time for
as many right-hand sides in a block. Two passes of Gram-Schmidt keep the basis orthonormal in mass (Golub
and Van Loan, Matrix Computations, 10.3). The modes come from a Rayleigh-Ritz projection, so that they are
orthonormal to rounding.
"""

import numpy as np
import scipy.linalg
from scipy.sparse import csr_array

from fem.body.mesh import Floats
from fem.body.solver import Backend, Solve, factorized

BLOCK = 12
DENSE = 1000
"""Number of unknowns up to which dense algebra is faster."""
RESIDUAL = 1e-8
SEED = 6_2016


def _orthonormal_in_mass(
    block: Floats, mass: csr_array, basis: Floats, mass_basis: Floats
) -> tuple[Floats, Floats]:
    """Make a block orthonormal in mass, also to a basis; drop its dependent columns."""
    for _ in range(2):
        block = block - basis @ (mass_basis.T @ block)
        moved = mass @ block
        gram = block.T @ moved
        size = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
        values, vectors = np.linalg.eigh(gram / np.outer(size, size))
        keep = values > 1e-13 * values[-1]
        turn = (vectors[:, keep] / np.sqrt(values[keep])) / size[:, None]
        block = block @ turn
        moved = moved @ turn
    return block, moved


def is_small(size: int, count: int) -> bool:
    """Return True if dense algebra finds `count` modes of a system of this size faster than the iteration."""
    return size <= max(DENSE, _capacity(count))


def _capacity(count: int) -> int:
    """Return the greatest number of vectors in the iteration's basis."""
    return 4 * count + 12 * BLOCK


def lowest_modes(
    stiffness: csr_array,
    mass: csr_array,
    count: int,
    shift: float = 0.0,
    backend: Backend | None = None,
) -> tuple[Floats, Floats]:
    """Find the lowest eigenvalues and modes of a symmetric pencil.

    Parameters
    ----------
    stiffness, mass : sparse array (n, n)
        Positive semidefinite stiffness and positive definite mass.
    count : int
        Number of modes.
    shift : float
        Positive number in 1/s2 that makes K + shift M definite; 0 if K is.
    backend : str, optional
        See `solver.factorized`.

    Returns
    -------
    eigenvalues : array (count,)
        In 1/s2, ascending.
    modes : array (n, count)
        Orthonormal in mass.

    Raises
    ------
    ValueError
        If count is not between 1 and n.
    RuntimeError
        If the iteration does not converge.
    """
    n = stiffness.shape[0]
    if not 1 <= count <= n:
        raise ValueError(f"count must be in 1..{n}, the degrees of freedom, got {count}")
    if is_small(n, count):
        values, vectors = scipy.linalg.eigh(
            stiffness.toarray(), mass.toarray(), subset_by_index=(0, count - 1)
        )
        return values, vectors
    solve = factorized(csr_array(stiffness + shift * mass) if shift else stiffness, backend)
    return iterated_modes(solve, mass, count, shift)


def iterated_modes(solve: Solve, mass: csr_array, count: int, shift: float = 0.0) -> tuple[Floats, Floats]:
    """Find the lowest eigenvalues and modes of a system that is not small, see `is_small`.

    The stiffness matrix itself is not needed, only its factors: these take most of the memory.

    Parameters
    ----------
    solve : Solve
        Solution of (K + shift M) x = b.
    mass, count, shift
        See `lowest_modes`; results and errors are the same.
    """
    n = mass.shape[0]
    block = np.random.default_rng(SEED).standard_normal((n, BLOCK))
    capacity = _capacity(count)
    basis = np.empty((n, capacity), order="F")
    mass_basis = np.empty((n, capacity), order="F")
    projected = np.zeros((capacity, capacity))
    block, moved = _orthonormal_in_mass(solve(mass @ block), mass, basis[:, :0], basis[:, :0])
    size = 0
    while True:
        width = block.shape[1]
        if size + width > capacity:
            raise RuntimeError(f"{count} modes did not converge within a basis of {size} vectors")
        new = slice(size, size + width)
        basis[:, new] = block
        mass_basis[:, new] = moved
        size += width
        image = solve(moved)
        overlap = mass_basis[:, :size].T @ image
        projected[:size, new] = overlap
        projected[new, :size] = overlap.T
        block, moved = _orthonormal_in_mass(image, mass, basis[:, :size], mass_basis[:, :size])
        if size < count + BLOCK:
            continue
        inverse, coefficients = np.linalg.eigh(projected[:size, :size])
        coupling = moved.T @ image
        residual = np.linalg.norm(coupling @ coefficients[size - width :, -count:], axis=0)
        if (residual <= RESIDUAL * inverse[-count:]).all():
            break
    chosen = slice(size - 1, size - count - 1, -1) if size > count else slice(None, None, -1)
    del mass_basis
    modes = basis[:, :size] @ coefficients[:, chosen]
    return 1.0 / inverse[chosen] - shift, modes
