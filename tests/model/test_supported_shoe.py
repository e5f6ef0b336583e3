"""One flexible shoe on supports at its pins, in the engine and in the full finite-element model."""

import exudyn as exu
import exudyn.itemInterface as items
import numpy as np
import pytest

from exudyn_crawler import Case
from exudyn_crawler.model.build import parts_of
from exudyn_crawler.model.exudyn.bodies import add_shoe_nodes, add_shoes
from exudyn_crawler.model.flexible_shoes import floating_shoe, shoe_model
from exudyn_crawler.model.forces.loads import Loads
from exudyn_crawler.model.joints import Markers
from fem import Partition
from fem.stress import von_mises
from studies.stress import with_modes

pytestmark = pytest.mark.simulation

LOAD = 386.4e3
"""N, evenly spread over the loaded surface."""
HELD = {"front right": (1, 1, 1), "front left": (1, 0, 1), "rear right": (0, 0, 1), "rear left": (0, 0, 1)}
"""Directions x, y, z in which each joint centre is held; all its rotations are free."""


def supported_case(load_mode=False):
    case = Case.stress("coarse")
    flexible = with_modes(case.flexible.with_(shoes=(7,), load_mode=load_mode), "all")
    return case.with_(gravity=0.0, flexible=flexible)


def in_engine(case):
    """Displacements (nodes, 3) and stress (nodes, 6) of the reduced shoe as the engine's body carries it."""
    floating = floating_shoe(case)
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    tables, ground = parts_of(case).tables, mbs.AddObject(items.ObjectGround())
    reduced, nodes = floating.reduced, add_shoe_nodes(mbs, tables)
    points = [
        (6, interface.center, pilot[:3], pilot[3:], floating.mode_count)
        for interface, pilot in zip(reduced.interfaces, reduced.pilots, strict=True)
    ]
    rows = floating.load_rows
    points.append((6, floating.load_point, rows, np.zeros_like(rows), floating.mode_count))
    markers = Markers(*(np.array(one) for one in zip(*points, strict=True)))
    tables = tables._replace(markers=markers, loads=Loads(*np.zeros((2, 0), dtype=int)))
    shoes = add_shoes(mbs, tables, nodes, np.zeros(3))
    for other in (*nodes[:6], *nodes[7:]):
        at = mbs.GetNode(other)["referenceCoordinates"][:3]
        base = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=at))
        marker = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=other))
        mbs.AddObject(items.ObjectJointGeneric(markerNumbers=[base, marker]))
    place = np.array(case.track.com_positions(case.shoe.com_height)[6])
    for interface, marker in zip(reduced.interfaces, shoes.markers[:-1], strict=True):
        center = (place + case.track.joint_centers[interface.name]).tolist()
        base = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=center))
        axes = [*HELD[interface.name], 0, 0, 0]
        mbs.AddObject(items.ObjectJointGeneric(markerNumbers=[base, marker], constrainedAxes=axes))
    mbs.AddLoad(items.LoadForceVector(markerNumber=shoes.markers[-1], loadVector=[0.0, 0.0, -LOAD]))
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    settings.staticSolver.useLoadFactor = False
    newton = settings.staticSolver.newton
    newton.absoluteTolerance = 1e-3
    newton.relativeTolerance = 1e-16
    newton.weightTolerancePerCoordinate = True
    newton.maxIterations = 50
    mbs.SolveStatic(settings)
    moved = np.array(mbs.GetNodeOutput(nodes[6], exu.OutputVariableType.Coordinates))
    q = np.array(mbs.GetNodeOutput(shoes.modal_nodes[0], exu.OutputVariableType.Coordinates))
    # e1 to e3 are half the small angles
    rigid = moved[:3] + np.cross(2.0 * moved[4:7], reduced.nodes)
    return rigid + reduced.displacement(q)[0], reduced.stress(q)[0]


@pytest.fixture(scope="module")
def full():
    """The same of the full model with its spiders, by a direct solution."""
    case = supported_case()
    body, interfaces = shoe_model(case.flexible, case.track)
    partition = Partition(body, interfaces)
    modes = partition.constraint_modes
    forces = body.surface_load(case.flexible.load_surface, np.array([0.0, 0.0, -LOAD])).reshape(-1, 1)
    stiffness = modes.T @ (body.stiffness @ modes)
    held = np.concatenate([[*HELD[interface.name], 0, 0, 0] for interface in interfaces]).astype(bool)
    centers = np.zeros((len(held), 1))
    centers[~held] = np.linalg.solve(stiffness[np.ix_(~held, ~held)], (modes.T @ forces)[~held])
    answer = (modes @ centers + partition.held_response(forces)).reshape(-1, 3)
    return answer, body.stress(answer[:, :, None])[:, :, 0]


def relative_difference(one, exact):
    return float(np.sqrt(np.mean((one - exact) ** 2) / np.mean(exact**2)))


@pytest.mark.slow
def test_a_simply_supported_shoe_with_a_mode_for_its_load_is_the_full_model(full):
    displacement, stress = in_engine(supported_case(load_mode=True))
    assert np.abs(full[0][:, 2]).max() > 3e-5
    assert von_mises(full[1]).max() > 15e6
    assert relative_difference(displacement, full[0]) < 0.002
    # the mode balances the load by the shoe's own inertia, the supports here do it at the pins
    assert relative_difference(stress, full[1]) < 0.01


@pytest.mark.slow
def test_the_94_modes_lose_what_the_load_bends_between_them(full):
    """Measured: 0.3 % of the displacements and 2 % of the stresses in the mean, 0.3 % of the greatest."""
    displacement, stress = in_engine(supported_case())
    assert 0.001 < relative_difference(displacement, full[0]) < 0.01
    assert 0.01 < relative_difference(von_mises(stress), von_mises(full[1])) < 0.05
    assert von_mises(stress).max() == pytest.approx(von_mises(full[1]).max(), rel=0.01)
