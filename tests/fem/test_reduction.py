"""Reduction: exact statics, rigid-body modes, convergence from above, spiders, residual modes."""

import itertools

import numpy as np
import pytest
import scipy.linalg

import fem
from fem.eigen import lowest_modes
from fem.interfaces import averaging_rows, rigid_motion_of_centers
from fem.solver import default_backend, factorized
from fem.stress import von_mises
from tests.fem.conftest import STEEL, beam_interfaces, box_mesh, shoe_interfaces


def spring_response(reduced: fem.ReducedBody, load: np.ndarray) -> np.ndarray:
    """Solve for the static modal coordinates (m,) of a modal load (m,)."""
    return load / (2 * np.pi * reduced.frequencies) ** 2


def test_solvers_agree(beam: fem.ElasticBody) -> None:
    matrix = beam.stiffness + beam.shift * beam.mass_matrix
    b = np.random.default_rng(0).standard_normal((matrix.shape[0], 3))
    superlu = factorized(matrix, "superlu")(b)
    other = factorized(matrix, default_backend())(b)
    assert np.abs(other - superlu).max() < 1e-8 * np.abs(superlu).max()
    np.testing.assert_array_equal(factorized(matrix)(b[:, 0]).shape, (len(b),))


def test_unknown_solver(beam: fem.ElasticBody) -> None:
    with pytest.raises(ValueError, match="backend = 'magic'"):
        factorized(beam.stiffness, "magic")  # type: ignore[arg-type]


def test_block_lanczos_against_dense() -> None:
    body = fem.ElasticBody(box_mesh((8, 2, 2), (1.0, 0.2, 0.25)), STEEL)
    found, modes = body.free_modes(40)
    k, m = body.stiffness.toarray(), body.mass_matrix.toarray()
    exact = scipy.linalg.eigh(k, m, eigvals_only=True, subset_by_index=(0, 39))
    np.testing.assert_allclose(found[6:], exact[6:], rtol=1e-10)
    np.testing.assert_allclose(modes.T @ m @ modes, np.eye(40), atol=1e-12)


def test_too_many_modes(beam: fem.ElasticBody) -> None:
    size = beam.stiffness.shape[0]
    with pytest.raises(ValueError, match=f"count = {size + 1} modes"):
        lowest_modes(beam.stiffness, beam.mass_matrix, size + 1)
    with pytest.raises(ValueError, match="n_fixed_modes = 5000"):
        fem.craig_bampton(beam, beam_interfaces(beam), 5000)


def test_shoe_modes_are_orthonormal(shoe: fem.ElasticBody, reduced: fem.ReducedBody) -> None:
    assert len(reduced.frequencies) == 94
    modes = reduced.modes.reshape(-1, 94)
    np.testing.assert_allclose(modes.T @ (shoe.mass_matrix @ modes), np.eye(94), atol=1e-10)
    omega = 2 * np.pi * reduced.frequencies
    stiffness = modes.T @ (shoe.stiffness @ modes) / np.outer(omega, omega)
    np.testing.assert_allclose(stiffness, np.eye(94), atol=1e-8)
    momentum = shoe.rigid_modes.T @ (shoe.mass_matrix @ modes)
    assert np.abs(momentum).max() < 1e-9 * shoe.mass


def test_pilots_are_the_motion_of_the_bores(reduced: fem.ReducedBody) -> None:
    for interface, pilot in zip(reduced.interfaces, reduced.pilots, strict=True):
        weights = np.zeros(len(reduced.nodes))
        weights[interface.nodes] = 1.0
        rows = reduced.motion_rows(weights, interface.center)
        np.testing.assert_allclose(pilot, rows, atol=1e-9 * np.abs(rows).max())


@pytest.mark.parametrize("spider", ["rigid", "averaging"])
def test_statics_of_interface_loads_are_exact(beam: fem.ElasticBody, spider: str) -> None:
    interfaces = beam_interfaces(beam, spider)
    partition = fem.Partition(beam, interfaces)
    loads = np.random.default_rng(2).standard_normal((12, 2))
    motion = rigid_motion_of_centers(interfaces, beam.center_of_mass)
    loads -= motion @ np.linalg.solve(motion.T @ motion, motion.T @ loads)  # self-equilibrated
    exact = partition.static_response(center_loads=loads)
    reduced = fem.craig_bampton(beam, interfaces, 0)
    q = np.linalg.solve(
        reduced.modal_stiffness, np.tensordot(reduced.pilots.reshape(12, -1), loads, ((0,), (0,)))
    )
    found = reduced.modes.reshape(-1, q.shape[0]) @ q
    assert np.abs(found - exact).max() < 1e-9 * np.abs(exact).max()


def test_averaging_spider_keeps_the_bodys_own_stiffness(beam: fem.ElasticBody) -> None:
    interfaces = beam_interfaces(beam, "averaging")
    partition = fem.Partition(beam, interfaces)
    loads = np.zeros((12, 1))
    loads[0], loads[6] = -1e5, 1e5
    forces = np.zeros((len(beam.mesh.nodes), 3))
    for interface, sign in zip(interfaces, (-1.0, 1.0), strict=True):
        forces[interface.nodes, 0] = sign * 1e5 / len(interface.nodes)
    free = beam.displacement_under(forces.reshape(-1, 1))
    tied = partition.static_response(center_loads=loads)
    assert np.abs(tied - free).max() < 1e-9 * np.abs(free).max()


def test_averaging_rows_see_a_rigid_motion() -> None:
    rng = np.random.default_rng(3)
    positions, center = rng.standard_normal((9, 3)), rng.standard_normal(3)
    translation, rotation = rng.standard_normal(3), rng.standard_normal(3)
    u = translation + np.cross(rotation, positions - center)
    rows = averaging_rows(positions, rng.random(9), center)
    np.testing.assert_allclose(rows @ u.ravel(), np.r_[translation, rotation], rtol=1e-10)


def test_frequencies_converge_from_above(beam: fem.ElasticBody) -> None:
    interfaces = beam_interfaces(beam)
    full = fem.craig_bampton(beam, interfaces, fem.Partition(beam, interfaces).of_rest.shape[1])
    exact = full.frequencies[:6]
    errors = []
    for count in (2, 6, 18, 54, 162):
        found = fem.craig_bampton(beam, interfaces, count).frequencies[:6]
        assert (found >= exact * (1 - 1e-9)).all()
        errors.append(np.max(found / exact - 1))
    assert all(b < a for a, b in itertools.pairwise(errors))
    assert errors[-1] < 1e-4


def test_reduced_stress_is_that_of_the_full_model(
    shoe: fem.ElasticBody, partition: fem.Partition, reduced: fem.ReducedBody
) -> None:
    pulls = np.zeros((24, 1))
    names = [i.name for i in reduced.interfaces]
    for side in ("left", "right"):
        pulls[6 * names.index(f"rear {side}")] = -1.3e6
    full = partition.static_response(center_loads=pulls).reshape(-1, 3, 1)
    exact = shoe.stress(full)[:, :, 0]
    q = spring_response(reduced, reduced.pilots.reshape(24, -1).T @ pulls[:, 0])
    found = reduced.stress(q)[0]
    away = np.setdiff1d(np.arange(len(exact)), np.r_[reduced.spider_nodes, reduced.nodes_beside_spiders])
    # inertia of the balancing acceleration is what 76 fixed-interface modes leave out
    assert von_mises(found - exact)[away].max() < 0.03 * von_mises(exact).max()


def test_stress_of_loads_at_the_pins_is_exact_beside_the_spiders_too(
    shoe: fem.ElasticBody, partition: fem.Partition, reduced: fem.ReducedBody
) -> None:
    """A chain's pull through the shoe: the constraint modes hold it, whatever the fixed modes leave out."""
    pull = np.zeros((24, 1))
    for place, interface in enumerate(reduced.interfaces):
        pull[6 * place] = 0.7e6 if interface.name.startswith("front") else -0.7e6
    exact = shoe.stress(partition.static_response(center_loads=pull).reshape(-1, 3, 1))[:, :, 0]
    found = reduced.stress(spring_response(reduced, reduced.pilots.reshape(24, -1).T @ pull[:, 0]))[0]
    assert von_mises(found - exact).max() < 1e-6 * von_mises(exact).max()


def test_residual_mode_of_inertia_completes_an_unbalanced_pull(
    shoe: fem.ElasticBody, partition: fem.Partition
) -> None:
    """Two pins pulled and the body's inertia in answer: within 1 % away from the spiders."""
    push = (shoe.mass_matrix @ np.tile([1.0, 0.0, 0.0], len(shoe.mesh.nodes))).reshape(-1, 3)
    body = fem.craig_bampton(
        shoe, partition.interfaces, 76, residual_loads={"inertia": push}, partition=partition
    )
    pulls = np.zeros((24, 1))
    for place, interface in enumerate(body.interfaces):
        if interface.name.startswith("rear"):
            pulls[6 * place] = -1.3e6
    exact = shoe.stress(partition.static_response(center_loads=pulls).reshape(-1, 3, 1))[:, :, 0]
    found = body.stress(spring_response(body, body.pilots.reshape(24, -1).T @ pulls[:, 0]))[0]
    away = np.setdiff1d(np.arange(len(exact)), np.r_[body.spider_nodes, body.nodes_beside_spiders])
    assert von_mises(found - exact)[away].max() < 0.01 * von_mises(exact).max()


def test_a_peak_splits_into_the_shares_of_its_loads(
    shoe: fem.ElasticBody, partition: fem.Partition, reduced: fem.ReducedBody
) -> None:
    forces = [shoe.surface_load(name, np.array([0.0, 0.0, -1e5])) for name in ("top", "roller path")]
    static = partition.static_response(np.stack([f.ravel() for f in forces], axis=1))
    stress = shoe.stress(static.reshape(len(shoe.mesh.nodes), 3, 2))
    sizes = np.array([3.0, 0.5])
    node = int(von_mises(stress @ sizes).argmax())
    parts = fem.shares(stress, sizes, node)
    assert parts.shape == (2,)
    assert parts.sum() == pytest.approx(von_mises((stress @ sizes)[node]), rel=1e-9)
    assert abs(parts[0]) > abs(parts[1])


def test_residual_mode_restores_the_stress_of_its_load(
    shoe: fem.ElasticBody, partition: fem.Partition, reduced: fem.ReducedBody
) -> None:
    force = np.array([0.0, 0.0, -386.4e3])
    load = shoe.surface_load("top", force)
    enriched = fem.craig_bampton(
        shoe, partition.interfaces, 76, residual_loads={"machine": load}, partition=partition
    )
    assert len(enriched.frequencies) == 95
    full = partition.static_response(load.reshape(-1, 1)).reshape(-1, 3, 1)
    exact = shoe.stress(full)[:, :, 0]

    def error(body: fem.ReducedBody) -> float:
        found = body.stress(spring_response(body, body.load("top", force)))[0]
        return float(von_mises(found - exact).max() / von_mises(exact).max())

    assert error(enriched) < 1e-6
    assert error(reduced) > 0.02


def test_load_of_a_patch(reduced: fem.ReducedBody) -> None:
    half = reduced.polygon_weights("underside", [[-1, 0], [1, 0], [1, 2], [-1, 2]])
    nodes = np.flatnonzero(half)
    assert (reduced.nodes[nodes, 1] > -1e-9).all()
    assert half.sum() == pytest.approx(0.63 * 3.505 / 2, rel=0.1)  # whole nodes only
    rows = reduced.mean_rows(half)
    np.testing.assert_allclose(
        reduced.motion_rows(half, half @ reduced.nodes / half.sum())[:3], rows, atol=1e-9
    )


def test_some_modes_alone(reduced: fem.ReducedBody) -> None:
    few = reduced.with_modes([0, 5, 11])
    assert few.modes.shape[2] == few.stress_modes.shape[2] == few.pilots.shape[2] == 3
    np.testing.assert_array_equal(few.modes[:, :, 1], reduced.modes[:, :, 5])
    with pytest.raises(ValueError, match=r"0\.\.93"):
        reduced.with_modes([94])
    with pytest.raises(ValueError, match="different"):
        reduced.with_modes([1, 1])


def test_faulty_interfaces(shoe: fem.ElasticBody) -> None:
    bores = shoe_interfaces(shoe)
    with pytest.raises(ValueError, match="'empty' has no nodes"):
        fem.Interface("empty", (0, 0, 0), [])
    with pytest.raises(ValueError, match="three finite numbers"):
        fem.Interface("odd", (0, np.nan, 0), [1, 2, 3])
    shared = fem.Interface("double", bores[0].center, bores[0].nodes[:5])
    with pytest.raises(ValueError, match="'front right' and 'double' share node"):
        fem.Partition(shoe, [*bores, shared])
    ends = shoe.mesh.elements[0, [0, 1, 4]]
    with pytest.raises(ValueError, match="'line': its 3 nodes lie on a line"):
        fem.Partition(shoe, [fem.Interface("line", (0, 0, 0), ends)])
    with pytest.raises(ValueError, match="outside"):
        fem.Partition(shoe, [fem.Interface("far", (0, 0, 0), [0, 1, 10**7])])
    with pytest.raises(ValueError, match="twice"):
        fem.Partition(shoe, [bores[0], bores[0]])
