"""Flexible shoe alone: a swing about a pin against Exudyn's floating frame, and its stretch as it spins."""

import exudyn as exu
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from exudyn_crawler import Case, FlexibleShoes, StepProfile
from exudyn_crawler.engine.bodies import add_shoe_nodes, add_shoes
from exudyn_crawler.ground import rotations
from exudyn_crawler.ground.packed import nothing
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.assemble import assemble
from exudyn_crawler.model.bodies import Bodies, second_moment
from exudyn_crawler.model.elimination import fronts_of
from exudyn_crawler.model.exudyn import items, newton_settings
from exudyn_crawler.model.flexible_shoes import floating_shoe, shoe_model
from exudyn_crawler.model.forces.loads import Loads
from exudyn_crawler.model.joints.drive import Speeds
from exudyn_crawler.model.joints.hold import Held
from exudyn_crawler.model.joints.pin import ROWS, Pins
from exudyn_crawler.model.kinds import Joints
from exudyn_crawler.model.markers import Markers
from exudyn_crawler.model.tables import FrontRows, Search, Tables
from studies.grounds import plain
from studies.mechanisms import GRAVITY, RADIUS, STILL, integrated
from tests.small_shoe import SMALL_SHOE

pytestmark = pytest.mark.simulation

SHOE = 6
"""Number of the flexible shoe among the case's, from 0."""
COORDINATES = exu.OutputVariableType.Coordinates


def shoe_case(damping):
    """A track whose seventh shoe is flexible, with a damping ratio of its modes."""
    flexible = FlexibleShoes.ph4100c(SMALL_SHOE).with_(
        shoes=(SHOE + 1,), damping=StepProfile.constant(damping)
    )
    return plain(Case.translation()).with_(flexible=flexible)


def shoe_tables(case, pinned):
    """Held ground and the flexible shoe, with its frame at the origin; `pinned` at both of its rear pins."""
    whole = assemble(case).tables
    modes, own = whole.modes, whole.markers
    ends = own.body[whole.joints.pins.markers[:, 1]] == SHOE
    ends = whole.joints.pins.markers[ends, 1] if pinned else np.zeros(0, dtype=int)
    m, pins = len(modes.stiffness), len(ends)
    size = 12 + m
    holds = np.column_stack((np.zeros(6, dtype=np.int64), np.arange(6)))
    first_row = ROWS * pins
    rows = np.arange(first_row + 2 + len(holds))
    # a marker of the ground for the drive, then of ground and shoe at each pin
    body = np.array([0, *[0, 1] * pins])
    position, moved, turned = (
        np.zeros((len(body), 3)),
        np.zeros((len(body), 3, m)),
        np.zeros((len(body), 3, m)),
    )
    position[1::2] = position[2::2] = own.position[ends]
    moved[2::2], turned[2::2] = own.displacement[ends], own.rotation[ends]
    rigid = second_moment(1.0, np.eye(3), np.zeros(3))
    unknowns, last = list(range(size)), (size + rows).tolist()
    none, markers = np.zeros((pins, ROWS)), np.arange(1, 1 + 2 * pins).reshape(-1, 2)
    return nothing(Tables)._replace(
        bodies=Bodies(
            np.array([0, 6]),
            np.array([-1, 12]),
            np.zeros((2, 6)),
            np.array([1.0, whole.bodies.mass[SHOE]]),
            np.array([np.zeros(3), whole.bodies.first[SHOE]]),
            np.array([rigid, whole.bodies.second[SHOE]]),
            np.zeros((2, 2, 3)),
        ),
        modes=modes,
        markers=Markers(body, position, moved, turned, m * body),
        joints=nothing(Joints)._replace(
            pins=Pins(0, markers, none, none, in_plane=False, follows=False),
            drive=Speeds(first_row, marker=0, turning=0),
            holds=Held(first_row + 2, holds),
        ),
        multipliers=len(rows),
        search=Search(0.0, 0.0, 0, False),
        fronts=fronts_of([unknowns, last], [[*unknowns, *last]]),
        rows=FrontRows(
            np.array([[0, 6], [-1, -1]]),
            np.zeros(2, dtype=np.int64),
            np.array([-1, -1]),
            np.array([size + rows, rows]),
        ),
    )


def by_engine(tables, h, steps):
    """Positions (steps, 3), attitudes (steps, 3, 3) and modes (steps, m) of the pinned shoe by Exudyn."""
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    tables = tables._replace(loads=Loads(*np.zeros((2, 0), dtype=int)))
    nodes = add_shoe_nodes(mbs, tables)
    shoes = add_shoes(mbs, tables, nodes, np.array([0.0, 0.0, -GRAVITY]))
    ground = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=mbs.AddObject(items.ObjectGround())))
    held = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[0]))
    mbs.AddObject(items.ObjectJointGeneric(markerNumbers=[ground, held]))
    for pin in tables.joints.pins.markers:
        ends = [shoes.markers[end] for end in pin]
        mbs.AddObject(items.ObjectJointGeneric(markerNumbers=ends, constrainedAxes=[1, 1, 1, 1, 0, 1]))
    mbs.Assemble()
    settings = newton_settings(1e-6, 50)
    time = settings.timeIntegration
    time.endTime, time.numberOfSteps = h * steps, steps
    time.generalizedAlpha.spectralRadius = RADIUS
    # both start from accelerations of zero
    time.generalizedAlpha.computeInitialAccelerations = False
    found = []

    def keep(system, _time):
        found.append(
            (
                system.GetNodeOutput(nodes[1], COORDINATES),
                system.GetNodeOutput(shoes.modal_nodes[0], COORDINATES),
            )
        )
        return True

    mbs.SetPostStepUserFunction(keep)
    mbs.SolveDynamic(settings)
    frames, modes = (np.array(one[-steps:]) for one in zip(*found, strict=True))
    attitudes = Rotation.from_quat(frames[:, 3:] + (1.0, 0.0, 0.0, 0.0), scalar_first=True).as_matrix()
    return frames[:, :3], attitudes, modes


def test_a_swinging_shoe_moves_as_exudyns_floating_frame():
    """By 0.4 rad, with vibrating modes; both start without accelerations."""
    tables = shoe_tables(shoe_case(0.02), pinned=True)
    h, steps = 5e-4, 400
    start = np.zeros((3, 12 + len(tables.modes.stiffness)))
    swing = integrated(tables, start, (0.0, 0.0, -GRAVITY), h, steps)
    places, attitudes, modes = by_engine(tables, h, steps)
    assert np.ptp(swing.q[:, 1, 4]) > 0.4
    np.testing.assert_allclose(swing.q[1:, 1, :3], places, atol=1e-7)
    np.testing.assert_allclose(rotation_matrices(swing.q[1:, 1, 3:]), attitudes, atol=2e-7)
    assert (np.abs(swing.modes[1:] - modes).max(axis=0) < 1e-4 * np.abs(modes).max(axis=0)).all()


def test_a_spinning_shoe_stretches_by_the_centrifugal_forces_of_its_nodes():
    """About its principal axis, once its modes have settled; it spins slower by its stretch."""
    case, omega = shoe_case(0.5), 60.0
    tables = shoe_tables(case, pinned=False)
    body, _ = shoe_model(case.part(FlexibleShoes), case.track)
    reduced = floating_shoe(case).reduced
    axis = np.linalg.eigh(body.inertia)[1][:, 0]
    spin = omega * axis * np.sign(axis[1])
    start = np.zeros((3, 12 + len(tables.modes.stiffness)))
    start[1, 6:9] = -np.cross(spin, body.center_of_mass)
    start[1, 9:12] = rotations.angle_rates(np.zeros(3), spin)
    swing = integrated(tables, start, STILL, 2e-4, 500)
    across = np.eye(3) - np.outer(axis, axis)
    # forces of nodes on the modes, and how these grow with the modes
    shapes, arms = reduced.modes, body.mesh.nodes - body.center_of_mass
    moved = np.einsum("ab,nbk->nak", across, shapes).reshape(-1, shapes.shape[2])
    heavy = (body.mass_matrix @ moved).reshape(shapes.shape)
    forces, growing = np.einsum("nak,na->k", heavy, arms), np.einsum("nak,naj->jk", heavy, shapes)
    known = np.linalg.solve(np.diag(tables.modes.stiffness) / omega**2 - growing, forces)
    np.testing.assert_allclose(swing.modes[-1], known, atol=5e-5 * np.abs(known).max())
    # its moment of momentum stays
    slower = -2.0 * forces @ known / (axis @ body.inertia @ axis)
    spins = rotations.angular_velocity(swing.q[-1, 1, 3:], swing.q_t[-1, 1, 3:])
    assert np.linalg.norm(spins) / omega - 1.0 == pytest.approx(slower, rel=2e-3)
