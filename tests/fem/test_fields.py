"""Modes and static fields together against the full static answer, and against all modes."""

import numpy as np
import pytest
from scipy.sparse import csr_array, hstack

import fem
from benchmarks.static_fields import EVERY, newmark, newmark_modes
from fem.body.element_stress import von_mises
from fem.body.rectangle_loads import PressureGrid, Stations, flat_parts
from fem.stress.static_fields import UnitLoads
from fem.stress.trust import resolution
from tests.fem.bodies import beam_body, beam_interfaces, static_stress
from tests.fem.refusals import refused


@pytest.fixture(scope="module")
def stations(shoe: fem.ElasticBody) -> Stations:
    return Stations(flat_parts(shoe.mesh, "roller path")[0], 5, 0.1)


@pytest.fixture(scope="module")
def families(shoe: fem.ElasticBody, partition: fem.Partition, stations: Stations) -> dict[str, UnitLoads]:
    grid = PressureGrid(flat_parts(shoe.mesh, "underside")[0], (2, 3))
    return {
        "rail": UnitLoads.spread(stations.weights, partition.interfaces),
        "ground": UnitLoads.spread(grid.weights, partition.interfaces),
        "joints": UnitLoads.at_centers(len(shoe.mesh.nodes), partition.interfaces),
    }


@pytest.fixture(scope="module")
def fields(
    partition: fem.Partition, reduced: fem.ReducedBody, families: dict[str, UnitLoads]
) -> fem.StaticFields:
    return fem.static_fields(partition, reduced, families)


def static(reduced: fem.ReducedBody, fields: fem.StaticFields, loads: np.ndarray) -> np.ndarray:
    """Modal coordinates (t, m) that loads (t, k) hold still."""
    return loads @ fields.work / (2 * np.pi * reduced.frequencies) ** 2


def test_a_unit_has_the_stress_of_its_static_answer_at_a_node(shoe, reduced, fields):
    """What modes and fields of a load make together, recovered at all nodes."""
    answered = reduced.modes @ fields.held(reduced.frequencies).T + fields.displacements
    expected = shoe.stress(answered)
    for node in (0, 7, len(shoe.mesh.nodes) - 1):
        found = fields.stress_at(reduced, node)
        np.testing.assert_allclose(found, expected[node].T, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("name", ["rail", "ground", "joints"])
def test_modes_and_fields_are_the_full_static_answer(partition, reduced, families, fields, name):
    family = families[name]
    load = np.random.default_rng(5).standard_normal(fields.families[name])
    exact = static_stress(partition, family.nodal @ load, family.centers @ load)
    loads = fields.coordinates({name: load[None]})
    q = static(reduced, fields, loads)
    columns = fem.field_columns(partition.body, fields, [loads])
    assert (columns.turn.shape[1], columns.bound) == (1, 0.0)
    found = columns.beside(reduced).stress(np.hstack((q, loads @ columns.turn)))
    peak = von_mises(exact).max()
    assert von_mises(found[0] - exact).max() < 1e-7 * peak
    assert von_mises(reduced.stress(q)[0] - exact).max() > (1e-3 if name == "joints" else 0.1) * peak


def test_rests_are_orthogonal_to_the_modes(shoe, reduced, fields):
    modes = reduced.modes.reshape(-1, len(reduced.frequencies)) / (2 * np.pi * reduced.frequencies)
    # modes have all but the rigid acceleration of loads on joints: those rests are rounding
    kept = slice(fields.families["rail"] + fields.families["ground"])
    rests = fields.displacements[:, :, kept].reshape(len(modes), -1) / np.sqrt(np.diag(fields.energy)[kept])
    assert np.abs(modes.T @ (shoe.stiffness @ rests)).max() < 1e-6
    momentum = shoe.rigid_modes.T @ (shoe.mass_matrix @ rests)
    scale = np.abs(shoe.rigid_modes).T @ (shoe.mass_matrix @ np.abs(rests))
    assert (np.abs(momentum) < 1e-8 * scale).all()


def test_all_modes_leave_nothing_to_fields():
    """A bar of few nodes, whose modes are complete: rests are rounding."""
    body = beam_body(2)
    count, partition = len(body.mesh.nodes), fem.Partition(body, beam_interfaces(body))
    free = np.setdiff1d(np.arange(count), np.concatenate([i.nodes for i in partition.interfaces]))
    weights = np.eye(count, 1, -int(free[0]))
    family = {"push": UnitLoads.spread(weights, partition.interfaces)}
    sizes = []
    for count in (4, partition.of_rest.shape[1]):
        reduced = fem.craig_bampton(body, partition.interfaces, count, partition=partition)
        found = fem.static_fields(partition, reduced, family)
        exact = partition.static_response(family["push"].nodal.toarray())
        sizes.append(np.abs(found.displacements).max() / np.abs(exact).max())
    assert sizes[0] > 0.01
    assert sizes[1] < 1e-9


def test_a_load_in_time_against_the_full_model(beam, held):
    """A beam pushed aside from rest within three periods of its first bending, Newmark's rule for both."""
    partition = held["rigid"]
    reduced = fem.craig_bampton(beam, partition.interfaces, 6, partition=partition)
    weights = np.eye(len(beam.mesh.nodes), 1, -int(np.linalg.norm(beam.mesh.nodes - 0.1, axis=1).argmin()))
    push = UnitLoads.spread(weights, partition.interfaces)
    step, steps = 0.01 / reduced.frequencies[0], 300
    come = 0.5 * (1.0 - np.cos(np.pi * np.arange(steps + 1) / steps))
    loads = 1e5 * come[:, None] * np.array([0.2, 1.0, -1.0])
    free = csr_array(hstack([partition.of_centers, partition.of_rest]))
    mass, stiffness = (csr_array(free.T @ m @ free) for m in (beam.mass_matrix, beam.stiffness))
    u = free @ newmark(mass, stiffness, free.T @ (push.nodal @ loads.T), step)
    exact = beam.stress(u.reshape(-1, 3, u.shape[1]))
    fields = fem.static_fields(partition, reduced, {"push": push})
    q, _ = newmark_modes(reduced.frequencies, loads @ fields.work, step)
    modes = np.tensordot(reduced.stress_modes, q, axes=([2], [1]))
    rest = beam.stress(fields.displacements @ loads[EVERY::EVERY].T)
    peak = von_mises(np.moveaxis(exact, 1, 2)).max()
    assert von_mises(np.moveaxis(modes - exact, 1, 2)).max() > 0.1 * peak
    assert von_mises(np.moveaxis(modes + rest - exact, 1, 2)).max() < 0.01 * peak


def test_what_few_directions_leave_out_is_within_their_bound(shoe, reduced, fields, stations):
    t = np.linspace(0.0, 1.0, 40)
    x = np.linspace(stations.rectangle.low[0], stations.rectangle.high[0], 40)
    force = np.column_stack((0.1 * np.sin(9 * t), 0.0 * t, -1.0 - 0.1 * np.cos(7 * t))) * 1e6
    loads = fields.coordinates({"rail": stations.coordinates(force, x)})
    nodes = np.arange(0, len(reduced.nodes), 50)
    rest = fem.field_columns(shoe, fields, [loads])
    exact = np.tensordot(loads @ rest.turn, rest.stress_modes[nodes], axes=([1], [2]))
    ranks = []
    for tolerance in (1e8, 1e7, 1e5):
        few = fem.field_columns(shoe, fields, [loads[:25], loads[25:]], tolerance)
        ranks.append(few.turn.shape[1])
        found = np.tensordot(loads @ few.turn, few.stress_modes[nodes], axes=([1], [2]))
        assert 0.05 * few.bound < von_mises(found - exact).max() <= few.bound <= tolerance
    assert ranks[0] < ranks[1] < ranks[2]
    capped = fem.field_columns(shoe, fields, [loads], 1e5, most=2)
    assert capped.turn.shape[1] == 2
    assert capped.bound > 1e5


def test_extremes_and_hot_spots_take_fields_as_more_columns(shoe, reduced, fields, stations):
    t = np.linspace(0.0, 1.0, 300)
    x = np.linspace(stations.rectangle.low[0], stations.rectangle.high[0], 300)
    force = -1e6 * np.column_stack((0.1 * np.sin(30 * t), 0.2 * t, 1.0 + 0.3 * np.cos(40 * t)))
    loads = fields.coordinates({"rail": stations.coordinates(force, x)})
    columns = fem.field_columns(shoe, fields, [loads])
    shapes = columns.beside(reduced)
    q = np.hstack((static(reduced, fields, loads), loads @ columns.turn))
    found = fem.recover_extremes(shapes.stress_modes, q)
    rows = np.unique(found.greatest_at[found.peaks.order[:3]])
    np.testing.assert_allclose(found.highest[rows], shapes.von_mises(q[rows]).max(axis=1), rtol=1e-12)
    plain = fem.recover_extremes(np.concatenate(shapes.stress_modes.parts, axis=2), q)
    np.testing.assert_array_equal(found.greatest_at, plain.greatest_at)
    np.testing.assert_allclose(found.greatest, plain.greatest, rtol=1e-12)
    np.testing.assert_array_equal(found.highest_nodes, plain.highest_nodes)
    top = fem.hot_spots(shapes, t, q, 3, peaks=found.peaks).iloc[0]
    assert top["value"] == pytest.approx(found.greatest.max())
    row = int(np.abs(t - top["time"]).argmin())
    resolved = resolution(shoe.mesh, shoe.material, shapes.displacement(q[row])[0])
    assert top["jump"] == pytest.approx(np.sqrt(resolved.jump[top["node"]]), rel=1e-12)


def test_loads_by_mass_are_the_forces_that_accelerate_it(beam, held, small):
    inertia = UnitLoads.of_inertia(small.modes, small.interfaces)
    forces = UnitLoads(csr_array(beam.mass_matrix @ small.modes.reshape(-1, 26)), inertia.centers)
    found, expected = (fem.static_fields(held["rigid"], small, {"inertia": one}) for one in (inertia, forces))
    np.testing.assert_array_equal(found.displacements, expected.displacements)
    # modes are orthonormal in mass: the momentum of one works on itself alone
    np.testing.assert_allclose(found.work, np.eye(26), atol=1e-9)


@pytest.mark.simulation
def test_fields_are_kept_by_all_that_they_depend_on(tmp_path, beam):
    ends = beam_interfaces(beam)
    tied = fem.Partition(beam, ends)
    kept, more = (fem.cached_craig_bampton(tmp_path, beam, ends, count, partition=tied) for count in (4, 5))
    weights = np.eye(len(beam.mesh.nodes), 2, -7)
    push, other = ({"push": UnitLoads.spread(size * weights, ends)} for size in (1.0, 2.0))
    first, again = (fem.cached_static_fields(tmp_path, tied, kept, push) for _ in range(2))
    assert (first.existed, again.existed, again.path) == (False, True, first.path)
    np.testing.assert_array_equal(first.fields.displacements, again.fields.displacements)
    assert again.fields.families == {"push": 6}
    for body, loads in ((more, push), (kept, other)):
        fem.cached_static_fields(tmp_path, tied, body, loads)
    files = sorted(tmp_path.glob("*.fields.h5"))
    assert len(files) == 3
    told: list[str] = []
    files[0].write_bytes(files[0].read_bytes()[:3000])
    for body, loads in ((kept, push), (more, push), (kept, other)):
        fem.cached_static_fields(tmp_path, tied, body, loads, warn=told.append)
    (line,) = told
    assert line.startswith(f"the file of static fields is computed again: {files[0]} must be")


def test_bad_fields(shoe, partition, reduced, fields):
    refused("families must be at least one, got none", fem.static_fields, partition, reduced, {})
    short, one = {"short": UnitLoads.spread(np.ones((4, 1)), partition.interfaces)}, np.zeros((1, 3))
    told = rf"loads of 'short' must be on {shoe.mesh.nodes.size} .* got 12 and 24"
    refused(told, fem.static_fields, partition, reduced, short)
    refused(r"loads must belong to the families .* got \['roof'\]", fields.coordinates, {"roof": one})
    refused("got none", fields.coordinates, {})
    refused("loads of 'rail' must have 15 coordinates, got 3", fields.coordinates, {"rail": one})
    refused("histories must be at least one, got none", fem.field_columns, shoe, fields, [])
    refused(r"histories must be \(times, 57\), got \(1, 3\)", fem.field_columns, shoe, fields, [one])
    refused("histories must be finite", fem.field_columns, shoe, fields, [np.full((1, 57), np.nan)])
    refused("parts must have the same nodes", fem.SideBySide, (np.zeros((3, 6, 1)), np.zeros((4, 6, 1))))
