"""Time the finite-element reduction and the stress recovery on the shoe's study mesh.

The reference of the reduction is Exudyn's own RBE2 Craig-Bampton routine on the same matrices; the
reference of the recovery is its bare matrix product.
"""

import os
import sys
import tempfile
import time

import numpy as np
from scipy.sparse import csr_matrix

import fem
import meshes

ROWS = 4000


def exudyn_craig_bampton(body: fem.ElasticBody, interfaces: list[fem.Interface]) -> float:
    """Wall time in s of Exudyn's reduction with 24 constraint and 76 fixed-interface modes."""
    from exudyn.FEM import FEMinterface, HCBstaticModeSelection

    interface = FEMinterface()
    interface.nodes = {"Position": np.array(body.mesh.nodes)}
    interface.massMatrix = csr_matrix(body.mass_matrix)
    interface.stiffnessMatrix = csr_matrix(body.stiffness)
    started = time.perf_counter()
    interface.ComputeHurtyCraigBamptonModes(
        boundaryNodesList=[i.nodes.tolist() for i in interfaces],
        nEigenModes=76,
        computationMode=HCBstaticModeSelection.RBE2,
        verboseMode=False,
    )
    return time.perf_counter() - started


def main(*, yardstick: bool = True, size: str = "study") -> None:
    """Print the timings.

    Parameters
    ----------
    yardstick : bool
        Also run Exudyn's routine, which takes minutes on the study mesh.
    size : str
        Of the shoe's mesh.
    """
    print(f"threads: OMP_NUM_THREADS={os.environ.get('OMP_NUM_THREADS', 'unset')}")
    body = fem.ElasticBody(meshes.shoe_mesh(size), meshes.STEEL)
    started = time.perf_counter()
    dofs = max(body.stiffness.shape[0], body.mass_matrix.shape[0])
    print(f"assembly, {dofs} DOF: {time.perf_counter() - started:.1f} s")
    interfaces = meshes.joint_interfaces(body.mesh)
    started = time.perf_counter()
    reduced = fem.craig_bampton(body, interfaces, 76)
    own = time.perf_counter() - started
    print(f"94 modes and stress modes: {own:.1f} s")
    if yardstick:
        theirs = exudyn_craig_bampton(body, interfaces)
        print(f"Exudyn's modes without stress: {theirs:.1f} s, ratio {own / theirs:.2f}")

    rng = np.random.default_rng(0)
    q = rng.standard_normal((ROWS, len(reduced.frequencies))) / reduced.frequencies**2
    fem.recover_peaks(reduced.stress_modes, q[:300])  # compiles the kernel
    started = time.perf_counter()
    fem.recover_peaks(reduced.stress_modes, q)
    recovery = time.perf_counter() - started
    shapes = reduced.stress_modes.reshape(-1, q.shape[1])
    started = time.perf_counter()
    for first in range(0, ROWS, 256):
        shapes @ np.asfortranarray(q[first : first + 256].T)
    product = time.perf_counter() - started
    print(
        f"peaks of {ROWS} rows: {recovery:.2f} s, bare product of the six components "
        f"{product:.2f} s, ratio {recovery / product:.2f}"
    )
    extremes(reduced)
    stored_reduction(body, interfaces)


def extremes(reduced: fem.ReducedBody) -> None:
    """Print the time of a search for extremes at low rank and at full rank, and their difference."""
    rng = np.random.default_rng(1)
    t = np.linspace(0.0, 1.0, ROWS)[:, None]
    slow = np.sin(2 * np.pi * (t * np.arange(1, 31) + rng.random(30))) @ rng.standard_normal(
        (30, len(reduced.frequencies))
    )
    q = (slow + 1e-3 * rng.standard_normal(slow.shape)) / reduced.frequencies**2
    found, spent = {}, {}
    for tolerance in (1e-3, None):
        fem.recover_extremes(reduced.stress_modes[:600], q[:600], tolerance=tolerance)  # compiles
        started = time.process_time()
        found[tolerance] = fem.recover_extremes(reduced.stress_modes, q, tolerance=tolerance)
        spent[tolerance] = time.process_time() - started
    off = np.abs(found[1e-3].greatest / found[None].greatest - 1.0).max()
    print(
        f"extremes of {ROWS} rows, processor time: {spent[1e-3]:.2f} s at low rank, "
        f"{spent[None]:.2f} s at full rank, ratio {spent[None] / spent[1e-3]:.1f}; peaks agree to {off:.0e}"
    )


def stored_reduction(body: fem.ElasticBody, interfaces: list[fem.Interface]) -> None:
    """Print the time to read a reduction from disk, and to derive one with fewer modes from it."""
    with tempfile.TemporaryDirectory() as folder:
        fem.cached_craig_bampton(folder, body, interfaces, 76)
        started = time.perf_counter()
        whole = fem.cached_craig_bampton(folder, body, interfaces, 76).body
        taken = time.perf_counter() - started
    started = time.perf_counter()
    fem.nested_reduction(whole, 10)
    nested = time.perf_counter() - started
    print(f"94 modes from disk: {taken:.2f} s; 28 modes out of them: {nested:.2f} s")


if __name__ == "__main__":
    main(yardstick="--no-yardstick" not in sys.argv)
