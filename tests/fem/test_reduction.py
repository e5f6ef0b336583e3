"""Reduction: exact statics, rigid-body modes, convergence from above, spiders, residual modes."""

import itertools

import numpy as np
import pytest

import fem
from fem.interfaces import rigid_motion_of_centers
from fem.stress import von_mises
from tests.fem.bodies import DOWN, static_stress

BACKWARD = {f"rear {side}": [-1.3e6, 0.0, 0.0] for side in ("left", "right")}
"""N, a chain's pull on the rear pins."""


def spring_response(reduced: fem.ReducedBody, load: np.ndarray) -> np.ndarray:
    """Solve for the static modal coordinates (m,) of a modal load (m,)."""
    return load / (2 * np.pi * reduced.frequencies) ** 2


@pytest.mark.simulation
def test_shoe_modes_are_orthonormal(shoe: fem.ElasticBody, enriched: fem.ReducedBody) -> None:
    assert len(enriched.frequencies) == 95
    modes = enriched.modes.reshape(-1, 95)
    np.testing.assert_allclose(modes.T @ (shoe.mass_matrix @ modes), np.eye(95), atol=1e-10)
    omega = 2 * np.pi * enriched.frequencies
    stiffness = modes.T @ (shoe.stiffness @ modes) / np.outer(omega, omega)
    np.testing.assert_allclose(stiffness, np.eye(95), atol=1e-8)
    momentum = shoe.rigid_modes.T @ (shoe.mass_matrix @ modes)
    assert np.abs(momentum).max() < 1e-9 * shoe.mass


def test_pilots_are_the_motion_of_the_bores(reduced: fem.ReducedBody) -> None:
    for interface, pilot in zip(reduced.interfaces, reduced.pilots, strict=True):
        weights = np.zeros(len(reduced.nodes))
        weights[interface.nodes] = 1.0
        rows = reduced.motion_rows(weights, interface.center)
        np.testing.assert_allclose(pilot, rows, atol=1e-9 * np.abs(rows).max())


def test_a_shoes_reduction_is_the_projection_of_a_greater_one(
    shoe: fem.ElasticBody, partition: fem.Partition, reduced: fem.ReducedBody
) -> None:
    """Mode by mode and sign by sign."""
    direct = fem.craig_bampton(shoe, partition.interfaces, 10, partition=partition)
    inside = fem.nested_reduction(reduced, 10).body
    np.testing.assert_allclose(inside.frequencies, direct.frequencies, rtol=1e-9)
    for name in ("modes", "stress_modes", "pilots"):
        expected = getattr(direct, name)
        np.testing.assert_allclose(getattr(inside, name), expected, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize("spider", ["rigid", "averaging"])
def test_fewer_modes_lie_inside_more_of_them(
    beam: fem.ElasticBody, held: dict[str, fem.Partition], spider: str
) -> None:
    partition = held[spider]
    interfaces = partition.interfaces
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
    with pytest.raises(ValueError, match=r"n_fixed_modes must lie in 0\.\.12, those of the body, got 13"):
        fem.nested_reduction(whole, 13)
    with pytest.raises(ValueError, match=r"residual_loads must be among .* got \['lift'\]"):
        fem.nested_reduction(whole, 5, ["lift"])
    with pytest.raises(ValueError, match="without some of them"):
        fem.nested_reduction(whole.with_modes([0, 1]), 5)


@pytest.mark.parametrize("spider", ["rigid", "averaging"])
def test_statics_of_interface_loads_are_exact(held: dict[str, fem.Partition], spider: str) -> None:
    partition, beam = held[spider], held[spider].body
    loads = np.random.default_rng(2).standard_normal((12, 2))
    motion = rigid_motion_of_centers(partition.interfaces, beam.center_of_mass)
    loads -= motion @ np.linalg.solve(motion.T @ motion, motion.T @ loads)  # self-equilibrated
    exact = partition.static_response(center_loads=loads)
    reduced = fem.craig_bampton(beam, partition.interfaces, 0, partition=partition)
    q = np.linalg.solve(reduced.modal_stiffness, reduced.pilots.reshape(12, -1).T @ loads)
    found = reduced.modes.reshape(-1, q.shape[0]) @ q
    assert np.abs(found - exact).max() < 1e-9 * np.abs(exact).max()


def test_averaging_spider_keeps_the_bodys_own_stiffness(held: dict[str, fem.Partition]) -> None:
    partition, beam = held["averaging"], held["averaging"].body
    loads = np.zeros((12, 1))
    loads[0], loads[6] = -1e5, 1e5
    forces = np.zeros((len(beam.mesh.nodes), 3))
    for interface, sign in zip(partition.interfaces, (-1.0, 1.0), strict=True):
        forces[interface.nodes, 0] = sign * 1e5 / len(interface.nodes)
    free = beam.displacement_under(forces.reshape(-1, 1))
    tied = partition.static_response(center_loads=loads)
    assert np.abs(tied - free).max() < 1e-9 * np.abs(free).max()


def test_frequencies_converge_from_above(held: dict[str, fem.Partition]) -> None:
    def lowest(count: int) -> np.ndarray:
        whole = held["rigid"]
        return fem.craig_bampton(whole.body, whole.interfaces, count, partition=whole).frequencies[:6]

    exact = lowest(held["rigid"].of_rest.shape[1])
    errors = []
    for count in (2, 6, 18, 54, 162):
        found = lowest(count)
        assert (found >= exact * (1 - 1e-9)).all()
        errors.append(np.max(found / exact - 1))
    assert all(b < a for a, b in itertools.pairwise(errors))
    assert errors[-1] < 1e-4


def test_reduced_stress_is_that_of_the_full_model(partition: fem.Partition, reduced: fem.ReducedBody) -> None:
    pulls = fem.center_loads(reduced.interfaces, BACKWARD)
    exact = static_stress(partition, None, pulls)
    q = spring_response(reduced, reduced.pilots.reshape(24, -1).T @ pulls[:, 0])
    found = reduced.stress(q)[0]
    away = np.setdiff1d(np.arange(len(exact)), np.r_[reduced.spider_nodes, reduced.nodes_beside_spiders])
    # inertia of the balancing acceleration is what 76 fixed-interface modes leave out
    assert von_mises(found - exact)[away].max() < 0.03 * von_mises(exact).max()


def test_stress_of_loads_at_the_pins_is_exact_beside_the_spiders_too(
    partition: fem.Partition, reduced: fem.ReducedBody
) -> None:
    """A chain's pull through the shoe: the constraint modes hold it, whatever the fixed modes leave out."""
    sense = {"front": 1.0, "rear": -1.0}
    forces = {i.name: [0.7e6 * sense[i.name.split()[0]], 0.0, 0.0] for i in reduced.interfaces}
    pull = fem.center_loads(reduced.interfaces, forces)
    exact = static_stress(partition, None, pull)
    found = reduced.stress(spring_response(reduced, reduced.pilots.reshape(24, -1).T @ pull[:, 0]))[0]
    assert von_mises(found - exact).max() < 1e-6 * von_mises(exact).max()


@pytest.mark.parametrize("kind", ["push", "nothing"])
def test_a_residual_load_that_bends_nothing_is_refused(
    shoe: fem.ElasticBody, partition: fem.Partition, kind: str
) -> None:
    """What is left of a push of all masses beside their inertia is rounding, and no mode."""
    push = (shoe.mass_matrix @ np.tile([1.0, 0.0, 0.0], len(shoe.mesh.nodes))).reshape(-1, 3)
    load = push if kind == "push" else np.zeros_like(push)
    with pytest.raises(ValueError, match=f"residual load '{kind}' must bend the body"):
        fem.craig_bampton(shoe, partition.interfaces, 0, residual_loads={kind: load}, partition=partition)


def test_residual_mode_restores_the_stress_of_its_load(
    partition: fem.Partition, reduced: fem.ReducedBody, enriched: fem.ReducedBody
) -> None:
    assert len(reduced.frequencies) == len(enriched.frequencies) - 1 == 94
    exact = static_stress(partition, partition.body.surface_load("top", DOWN))

    def error(body: fem.ReducedBody) -> float:
        found = body.stress(spring_response(body, body.load("top", DOWN)))[0]
        return float(von_mises(found - exact).max() / von_mises(exact).max())

    assert error(enriched) < 1e-6
    assert error(reduced) > 0.02
