"""Reduction: spiders, solvers, exact statics, modes, convergence from above, residual modes."""

import gc
import tracemalloc
import weakref

import numpy as np
import pytest
import scipy.linalg

import fem
from fem.body.eigen import lowest_modes
from fem.body.element_stress import von_mises
from fem.body.interfaces import averaging_rows, rigid_motion_of_centers
from fem.body.pardiso import Factors
from fem.body.solver import default_backend, factorized
from meshes import STEEL, joint_interfaces
from tests.fem.bodies import BACKWARD, DOWN, beam_interfaces, box_mesh, static_stress
from tests.fem.refusals import refused


def test_averaging_rows_see_a_rigid_motion():
    rng = np.random.default_rng(3)
    positions, center = rng.standard_normal((9, 3)), rng.standard_normal(3)
    translation, rotation = rng.standard_normal(3), rng.standard_normal(3)
    u = translation + np.cross(rotation, positions - center)
    rows = averaging_rows(positions, rng.random(9), center)
    np.testing.assert_allclose(rows @ u.ravel(), np.r_[translation, rotation], rtol=1e-10)


def test_faulty_interfaces(shoe):
    bores = joint_interfaces(shoe.mesh)
    refused("'empty': nodes must be at least one", fem.Interface, "empty", (0, 0, 0), [])
    refused("three finite numbers", fem.Interface, "odd", (0, np.nan, 0), [1, 2, 3])
    shared = fem.Interface("double", bores[0].center, bores[0].nodes[:5])
    line = fem.Interface("line", (0, 0, 0), shoe.mesh.elements[0, [0, 1, 4]])
    far = fem.Interface("far", (0, 0, 0), [0, 1, 10**7])
    refused(r"got .* in 'front right' and 'double'", fem.Partition, shoe, [*bores, shared])
    refused("'line': nodes must not lie on a line", fem.Partition, shoe, [line])
    refused(r"'far': nodes must lie in 0\.\.", fem.Partition, shoe, [far])
    refused("twice", fem.Partition, shoe, [bores[0], bores[0]])


def test_loads_on_centres_are_placed_by_name(beam):
    ends = beam_interfaces(beam)
    loads = fem.center_loads(ends, {"right": [1.0, 2.0, 3.0]})
    np.testing.assert_array_equal(loads[:, 0], [0, 0, 0, 0, 0, 0, 1, 2, 3, 0, 0, 0])
    with pytest.raises(KeyError, match=r"interfaces of \['left', 'right'\], got \['middle'\]"):
        fem.center_loads(ends, {"middle": [1.0, 0.0, 0.0]})


def test_solvers_agree(beam):
    matrix = beam.stiffness + beam.shift * beam.mass_matrix
    b = np.random.default_rng(0).standard_normal((matrix.shape[0], 3))
    superlu, other = (factorized(matrix, backend)(b) for backend in ("superlu", default_backend()))
    assert np.abs(other - superlu).max() < 1e-8 * np.abs(superlu).max()
    np.testing.assert_array_equal(factorized(matrix)(b[:, 0]).shape, (len(b),))


def test_a_solution_leaves_neither_matrix_nor_sides_in_memory(beam):
    """Nothing waits for a search for cycles, such as pointers to arrays are."""
    solve = factorized(beam.stiffness + beam.shift * beam.mass_matrix)
    forces = np.ones((beam.stiffness.shape[0], 30))
    solve(forces)
    gc.disable()
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        for _ in range(3):
            solve(forces)
        assert tracemalloc.get_traced_memory()[0] - before < forces.nbytes
    finally:
        tracemalloc.stop()
        gc.enable()


def test_factors_go_with_the_last_that_holds_them(beam, monkeypatch):
    released = []
    release = Factors.release
    monkeypatch.setattr(Factors, "release", lambda factors: released.append(release(factors)))
    tied = fem.Partition(beam, beam_interfaces(beam))
    held = weakref.ref(tied._solver)
    assert held() is not None
    del tied
    assert held() is None
    assert len(released) == (default_backend() == "pardiso")


def test_block_lanczos_against_dense():
    body = fem.ElasticBody(box_mesh((8, 2, 2), (1.0, 0.2, 0.25)), STEEL)
    found, modes = body.free_modes(40)
    k, m = body.stiffness.toarray(), body.mass_matrix.toarray()
    exact = scipy.linalg.eigh(k, m, eigvals_only=True, subset_by_index=(0, 39))
    np.testing.assert_allclose(found[6:], exact[6:], rtol=1e-10)
    np.testing.assert_allclose(modes.T @ m @ modes, np.eye(40), atol=1e-12)


def test_unknown_solvers_and_too_many_modes_are_refused(beam):
    k, m, size = beam.stiffness, beam.mass_matrix, beam.stiffness.shape[0]
    refused(r"backend must be .* got 'magic'", factorized, k, "magic")
    refused(f"count must be in 1..{size}, .* got {size + 1}", lowest_modes, k, m, size + 1)
    refused(r"n_fixed_modes must lie in .* got 5000", fem.craig_bampton, beam, beam_interfaces(beam), 5000)


def stress_error(reduced: fem.ReducedBody, load: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Von Mises stress (n,) that a static modal load's modes are off by, of the greatest exact one."""
    found = reduced.stress(load / (2 * np.pi * reduced.frequencies) ** 2)[0]
    return von_mises(found - exact) / von_mises(exact).max()


def pull_error(partition: fem.Partition, reduced: fem.ReducedBody, forces: dict) -> np.ndarray:
    """The same (n,) of forces on the pins."""
    pull = fem.center_loads(reduced.interfaces, forces)
    load = reduced.pilots.reshape(24, -1).T @ pull[:, 0]
    return stress_error(reduced, load, static_stress(partition, None, pull))


@pytest.mark.simulation
def test_shoe_modes_are_orthonormal(shoe, enriched):
    assert len(enriched.frequencies) == 95
    modes = enriched.modes.reshape(-1, 95)
    np.testing.assert_allclose(modes.T @ (shoe.mass_matrix @ modes), np.eye(95), atol=1e-10)
    omega = 2 * np.pi * enriched.frequencies
    stiffness = modes.T @ (shoe.stiffness @ modes) / np.outer(omega, omega)
    np.testing.assert_allclose(stiffness, np.eye(95), atol=1e-8)
    assert np.abs(shoe.rigid_modes.T @ (shoe.mass_matrix @ modes)).max() < 1e-9 * shoe.mass


def test_pilots_are_the_motion_of_the_bores(reduced):
    for interface, pilot in zip(reduced.interfaces, reduced.pilots, strict=True):
        weights = np.isin(np.arange(len(reduced.nodes)), interface.nodes).astype(float)
        rows = reduced.motion_rows(weights, interface.center)
        np.testing.assert_allclose(pilot, rows, atol=1e-9 * np.abs(rows).max())


def test_a_shoes_reduction_is_the_projection_of_a_greater_one(shoe, partition, reduced):
    """Mode by mode and sign by sign."""
    direct = fem.craig_bampton(shoe, partition.interfaces, 10, partition=partition)
    inside = fem.nested_reduction(reduced, 10).body
    np.testing.assert_allclose(inside.frequencies, direct.frequencies, rtol=1e-9)
    for name in ("modes", "stress_modes", "pilots"):
        expected = getattr(direct, name)
        np.testing.assert_allclose(getattr(inside, name), expected, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize("spider", ["rigid", "averaging"])
def test_fewer_modes_lie_inside_more_of_them(beam, held, spider):
    partition, interfaces = held[spider], held[spider].interfaces
    loads = {name: np.zeros_like(beam.mesh.nodes) for name in ("pull", "push")}
    loads["pull"][7, 0] = loads["push"][31, 2] = 1.0
    whole = fem.craig_bampton(beam, interfaces, 12, loads, partition=partition)
    push = {"push": loads["push"]}
    for count, kept in ((5, {}), (0, {}), (5, push), (12, push)):
        direct = fem.craig_bampton(beam, interfaces, count, kept, partition=partition)
        nested = fem.nested_reduction(whole, count, list(kept))
        inside, again = nested.body, fem.nested_reduction(nested.body, 0).body
        modes = whole.modes.reshape(-1, len(whole.frequencies))
        products = modes.T @ (beam.mass_matrix @ inside.modes.reshape(len(modes), -1))
        np.testing.assert_allclose(nested.inside, products, atol=1e-9)
        few = nested.with_modes([2, 0])
        np.testing.assert_array_equal(few.body.modes, inside.modes[:, :, [2, 0]])
        np.testing.assert_array_equal(few.inside, nested.inside[:, [2, 0]])
        np.testing.assert_allclose(inside.frequencies, direct.frequencies, rtol=1e-7)
        assert inside.parameters == direct.parameters
        constraints_alone = fem.nested_reduction(whole, 0).body.frequencies
        np.testing.assert_allclose(again.frequencies, constraints_alone, rtol=1e-7)
    all_of_it = fem.nested_reduction(whole, 12, ["pull", "push"])
    assert all_of_it.body is whole
    np.testing.assert_array_equal(all_of_it.inside, np.eye(len(whole.frequencies)))
    refused(r"n_fixed_modes must lie in 0\.\.12, those of the body, got 13", fem.nested_reduction, whole, 13)
    refused(r"residual_loads must be among .* got \['lift'\]", fem.nested_reduction, whole, 5, ["lift"])
    refused("without some of them", fem.nested_reduction, whole.with_modes([0, 1]), 5)


@pytest.mark.parametrize("spider", ["rigid", "averaging"])
def test_statics_of_interface_loads_are_exact(held, spider):
    partition, beam = held[spider], held[spider].body
    loads = np.random.default_rng(2).standard_normal((12, 2))
    motion = rigid_motion_of_centers(partition.interfaces, beam.center_of_mass)
    loads -= motion @ np.linalg.solve(motion.T @ motion, motion.T @ loads)  # self-equilibrated
    exact = partition.static_response(center_loads=loads)
    reduced = fem.craig_bampton(beam, partition.interfaces, 0, partition=partition)
    q = np.linalg.solve(reduced.modal_stiffness, reduced.pilots.reshape(12, -1).T @ loads)
    found = reduced.modes.reshape(-1, q.shape[0]) @ q
    assert np.abs(found - exact).max() < 1e-9 * np.abs(exact).max()


def test_averaging_spider_keeps_the_bodys_own_stiffness(held):
    partition, beam = held["averaging"], held["averaging"].body
    loads = np.zeros((12, 1))
    loads[0], loads[6] = -1e5, 1e5
    forces = np.zeros((len(beam.mesh.nodes), 3))
    for interface, sign in zip(partition.interfaces, (-1.0, 1.0), strict=True):
        forces[interface.nodes, 0] = sign * 1e5 / len(interface.nodes)
    free = beam.displacement_under(forces.reshape(-1, 1))
    tied = partition.static_response(center_loads=loads)
    assert np.abs(tied - free).max() < 1e-9 * np.abs(free).max()


def test_frequencies_converge_from_above(held):
    whole = held["rigid"]
    counts = (2, 6, 18, 54, 162, whole.of_rest.shape[1])
    bodies = [fem.craig_bampton(whole.body, whole.interfaces, one, partition=whole) for one in counts]
    *found, exact = (body.frequencies[:6] for body in bodies)
    errors = found / exact - 1
    assert (errors >= -1e-9).all()
    assert (np.diff(errors.max(axis=1)) < 0).all()
    assert errors[-1].max() < 1e-4


def test_reduced_stress_is_that_of_the_full_model(partition, reduced):
    error = pull_error(partition, reduced, BACKWARD)
    # inertia of the balancing acceleration is what 76 fixed-interface modes leave out
    assert np.delete(error, np.r_[reduced.spider_nodes, reduced.nodes_beside_spiders]).max() < 0.03


def test_stress_of_loads_at_the_pins_is_exact_beside_the_spiders_too(partition, reduced):
    """A chain's pull through the shoe: the constraint modes hold it, whatever the fixed modes leave out."""
    sense = {"front": 1.0, "rear": -1.0}
    forces = {i.name: [0.7e6 * sense[i.name.split()[0]], 0.0, 0.0] for i in reduced.interfaces}
    assert pull_error(partition, reduced, forces).max() < 1e-6


@pytest.mark.parametrize("kind", ["push", "nothing"])
def test_a_residual_load_that_bends_nothing_is_refused(shoe, partition, kind):
    """What is left of a push of all masses beside their inertia is rounding, and no mode."""
    push = (shoe.mass_matrix @ np.tile([1.0, 0.0, 0.0], len(shoe.mesh.nodes))).reshape(-1, 3)
    load = push if kind == "push" else np.zeros_like(push)
    with pytest.raises(ValueError, match=f"residual load '{kind}' must deform the body"):
        fem.craig_bampton(shoe, partition.interfaces, 0, residual_loads={kind: load}, partition=partition)


def test_residual_mode_restores_the_stress_of_its_load(partition, reduced, enriched):
    assert len(reduced.frequencies) == len(enriched.frequencies) - 1 == 94
    exact = static_stress(partition, partition.body.surface_load("top", DOWN))
    assert stress_error(enriched, enriched.load("top", DOWN), exact).max() < 1e-6
    assert stress_error(reduced, reduced.load("top", DOWN), exact).max() > 0.02


def test_load_of_a_patch(reduced):
    half = reduced.polygon_weights("underside", [[-1, 0], [1, 0], [1, 2], [-1, 2]])
    assert (reduced.nodes[np.flatnonzero(half), 1] > -1e-9).all()
    assert half.sum() == pytest.approx(0.63 * 3.505 / 2, rel=0.1)  # whole nodes only
    of_middle = reduced.motion_rows(half, half @ reduced.nodes / half.sum())
    np.testing.assert_allclose(of_middle[:3], reduced.mean_rows(half), atol=1e-9)


def test_some_modes_alone(reduced):
    few = reduced.with_modes([0, 5, 11])
    assert few.modes.shape[2] == few.stress_modes.shape[2] == few.pilots.shape[2] == 3
    np.testing.assert_array_equal(few.modes[:, :, 1], reduced.modes[:, :, 5])
    refused(r"0\.\.93", reduced.with_modes, [94])
    refused("different", reduced.with_modes, [1, 1])
