"""Stress of a shoe that is pulled at a node, against a direct solution of the whole finite-element model."""

import numpy as np
import pytest

from exudyn_crawler import Case, Drive, FlexibleShoes, StepProfile, simulate
from exudyn_crawler.model.flexible_shoes import shoe_model
from exudyn_crawler.model.shoe_mesh import pulled_node
from exudyn_crawler.results.history.history import History
from exudyn_crawler.results.loads.load_map import unit_loads
from exudyn_crawler.results.stress.recovery import recover_stresses
from fem import Partition
from fem.body.element_stress import von_mises
from tests.modal_loads import modal_loads, whole_coordinates
from tests.small_shoe import SMALL_SHOE

pytestmark = pytest.mark.simulation

FORCE = 2e6
INNER, OUTER = (8.76, 9.95), (8.59, 10.11)
"""m, y of the side faces of the lugs: those that face each other, and the others."""
CASE = Case.stress(SMALL_SHOE).with_(
    drive=Drive(speed=StepProfile(times=(0.0, 0.1), values=(0.0, 0.05))),
    flexible=FlexibleShoes.ph4100c(SMALL_SHOE).with_(shoes=(13,)),
)


@pytest.fixture(scope="module")
def partition():
    return Partition(*shoe_model(CASE.flexible, CASE.track))


def clamped(partition, forces):
    """Displacements (n, 3) under nodal forces (n, 3), rear joint centres held; reactions (4, 6) of all."""
    rear = [interface.name.startswith("rear") for interface in partition.interfaces]
    free = np.flatnonzero(~np.repeat(rear, 6))
    shapes = partition.constraint_modes
    stiffness = shapes.T @ (partition.body.stiffness @ shapes)
    loads = shapes.T @ forces.ravel()
    centers = np.zeros(len(loads))
    centers[free] = np.linalg.solve(stiffness[np.ix_(free, free)], loads[free])
    answer = shapes @ centers + partition.held_response(forces.reshape(-1, 1))[:, 0]
    return answer.reshape(-1, 3), (stiffness @ centers - loads).reshape(4, 6)


@pytest.fixture(scope="module")
def exact(partition):
    mesh = partition.body.mesh
    forces = np.zeros_like(mesh.nodes)
    forces[pulled_node(CASE, mesh), 0] = FORCE
    return clamped(partition, forces)


@pytest.fixture(scope="module")
def pulled(partition, exact):
    """A history whose front shoe is pulled by the drive and held at its rear pins, without anything else."""
    still = simulate(CASE, 0.02).dataset.isel(time=[0, 1]).copy(deep=True)
    for name in ("angles", "shoe_load", "area", "pin_force", "pin_torque"):
        still[name][:] = 0.0
    still["drive_force"][:] = FORCE
    for interface, reaction in zip(partition.interfaces, exact[1], strict=True):
        end, side = interface.name.split()
        if end == "rear":
            # what a link does to its front shoe is the opposite of what is stored
            still["pin_force"].loc[{"joint": 12, "pin": side}] = -reaction[:3]
            still["pin_torque"].loc[{"joint": 12, "pin": side}] = -reaction[3:]
    history = History(CASE, still)
    inside = unit_loads(CASE).integrated.inside
    own = (2.0 * np.pi * still.frequency.values) ** 2
    still["modal_coordinate"][:] = (modal_loads(history, 13) @ inside / own)[:, None]
    return history


def at_load(mesh):
    return np.unique(mesh.elements[(mesh.elements == pulled_node(CASE, mesh)).any(axis=1)])


def test_forces_balance(exact):
    assert exact[1][:, :3].sum(axis=0) == pytest.approx([-FORCE, 0.0, 0.0], abs=1e-6 * FORCE)


def test_recovered_stress_and_shape_are_those_of_the_whole_model(pulled, partition, exact):
    """Within 1 % of the greatest everywhere but about the node; measured: 0.5 % and 0.24 %."""
    body = partition.body
    whole, q = unit_loads(CASE).whole, whole_coordinates(pulled, 13)[0]
    away = np.setdiff1d(np.arange(len(body.mesh.nodes)), at_load(body.mesh))
    expected = von_mises(body.stress(exact[0][:, :, None])[:, :, 0])[away]
    assert whole.von_mises(q)[0][away] == pytest.approx(expected, abs=0.01 * expected.max())

    rigid = body.rigid_modes
    moved = body.mass_matrix @ rigid
    elastic = exact[0].ravel() - rigid @ np.linalg.solve(rigid.T @ moved, moved.T @ exact[0].ravel())
    elastic = elastic.reshape(-1, 3)[away]
    shape = whole.displacement(q)[0][away]
    assert shape == pytest.approx(elastic, abs=0.01 * np.linalg.norm(elastic, axis=1).max())


def test_hot_spots_of_a_pulled_shoe_lie_on_the_inner_faces_of_its_lugs(pulled):
    """As in the S-paper's table; of the five highest nodes some lie on the fillet beside the face."""
    table = recover_stresses(pulled, (0.0,)).hot_spots[13]
    sides = [min(INNER, key=lambda face, y=y: abs(face - y)) for y in table["y"]]
    assert table["y"].to_numpy() == pytest.approx(sides, abs=0.01)
    assert set(sides) == set(INNER)
    assert (table["flag"] == "").all()


def test_a_force_spread_over_the_shoe_would_stress_the_outer_faces(partition):
    """What tells a drive at a node from one that moves the frame."""
    body = partition.body
    mass = body.mass_matrix @ np.tile([1.0, 0.0, 0.0], len(body.mesh.nodes))
    answer, _ = clamped(partition, FORCE * mass.reshape(-1, 3) / body.mass)
    stress = von_mises(body.stress(answer[:, :, None])[:, :, 0])
    y = body.mesh.nodes[np.argsort(-stress)[:5], 1] + CASE.track.first_com[1]
    assert y == pytest.approx([min(OUTER, key=lambda face, y=v: abs(face - y)) for v in y], abs=0.01)


def test_nodes_about_the_pulled_one_are_marked_and_never_the_highest(pulled, partition):
    dataset = recover_stresses(pulled, (0.0,)).dataset.sel(shoe=13)
    mesh = partition.body.mesh
    marked = np.flatnonzero(dataset.at_load.values)
    assert marked.tolist() == at_load(mesh).tolist()
    assert 10 < len(marked) < 100
    assert not np.isin(dataset.highest_node.values, marked).any()
    highest = dataset.frame_von_mises.values[0][~dataset.at_load.values].max()
    assert dataset.highest_von_mises.values[0] == pytest.approx(highest, rel=1e-6)
