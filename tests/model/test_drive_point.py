"""The drive at a point of the front shoe: its kinematics, and that a run moves the point as told."""

import numpy as np
import pytest

from exudyn_crawler import Case, Drive, FlexibleShoes, StepProfile, Terrain, simulate
from exudyn_crawler.errors import ParameterError
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.flexible_shoes import floating_shoe, shoe_model
from exudyn_crawler.model.shoe_mesh import drive_point, pulled_node
from exudyn_crawler.results.balance import powers, shoe_imbalance
from studies.grounds import plain

QUICK = StepProfile(times=(0.0, 0.1), values=(0.0, 0.05))
FRONT_PINS = Case.translation().with_(drive=Drive(speed=QUICK, point="front pins"))
PULLED = plain(FRONT_PINS).with_(
    terrain=Terrain.stress(),
    drive=Drive(speed=QUICK),
    flexible=FlexibleShoes.ph4100c("coarse").with_(shoes=(13,)),
)


@pytest.fixture(scope="module")
def pulled():
    return simulate(PULLED, 0.1)


def point_motion(history, point):
    """Place and velocity of a point of the front shoe from the shoe's coordinates and their rates."""
    shoe = history.dataset.sel(shoe=13)
    frames = rotation_matrices(shoe.angles.values)
    if "modal_coordinate" in history.dataset:
        front = history.dataset.sel(flexible_shoe=13)
        bent, bending = front.modal_coordinate.values, front.modal_velocity.values
    else:
        bent = bending = np.zeros((len(frames), 0))
    arm = np.einsum("tij,tj->ti", frames, point.place + bent @ point.rows.T)
    turned = np.cross(shoe.angular_velocity.values, arm)
    within = np.einsum("tij,tj->ti", frames, bending @ point.rows.T)
    return shoe.position.values + arm, shoe.velocity.values + turned + within


@pytest.mark.simulation
@pytest.mark.slow
def test_the_com_node_has_the_drives_speed_and_the_frame_has_not(pulled):
    point = drive_point(PULLED, floating_shoe(PULLED).reduced)
    place, velocity = point_motion(pulled, point)
    speed = QUICK.value(pulled.time.values)
    # what Newton's method leaves of the constraint
    assert velocity[:, 0] == pytest.approx(speed, abs=1e-8)
    assert np.abs(pulled.velocity.sel(shoe=13, axis="x").values - speed).max() > 1e-4
    assert pulled.drive_point.values == pytest.approx(place, abs=1e-12)


@pytest.mark.simulation
@pytest.mark.slow
def test_the_force_on_a_node_keeps_the_momentum_of_the_track(pulled):
    """The drive's force alone moves and bends: what it lacks or adds would stand in the balance."""
    mass = np.full(13, PULLED.shoe.mass)
    mass[-1] = floating_shoe(PULLED).reduced.mass
    rate = (mass[:, None] * pulled.acceleration).sum("shoe").sel(axis="x").values
    ground = (pulled.friction_force + pulled.normal_force).sel(axis="x").sum("contact")
    force = (ground + pulled.drive_force).values
    assert np.abs(pulled.drive_force).max() > 1e5
    # the mesh's COM lies 1 mm beside its frame's origin, the frame pitches at up to 10 rad/s2
    assert np.abs(rate - force).max() < 1e-4 * np.abs(pulled.drive_force.values).max()


@pytest.mark.simulation
def test_a_rigid_front_shoe_is_pulled_at_its_pins():
    history = simulate(FRONT_PINS, 0.1)
    place, velocity = point_motion(history, drive_point(FRONT_PINS, None))
    middle = np.mean([c for n, c in FRONT_PINS.track.joint_centers.items() if n.startswith("front")], axis=0)
    assert place[0] - history.position.sel(shoe=13).values[0] == pytest.approx(middle, abs=0.01)
    assert velocity[:, 0] == pytest.approx(QUICK.value(history.time.values), abs=1e-8)
    force = history.drive_force.values
    assert powers(history).drive.values == pytest.approx(force * velocity[:, 0], rel=1e-6, abs=1e-3)
    balance = shoe_imbalance(history).sel(shoe=13).isel(time=slice(1, None))
    # its lever about the COM is 0.05 m: a moment left out would be 5 % of the force
    assert np.abs(balance.moment.sel(axis="y")).max() < 1e-4 * np.abs(force).max()


def test_a_rigid_front_shoe_has_its_com_in_place_of_a_node():
    translation = Case.translation()
    assert translation.drive.point == "com node"
    point = drive_point(translation, None)
    assert (point.place.any(), point.rows.shape) == (False, (3, 0))
    assert pulled_node(translation, shoe_model(PULLED.flexible, PULLED.track)[0].mesh) is None


def test_the_pulled_node_is_the_nearest_to_the_com_node():
    mesh = shoe_model(PULLED.flexible, PULLED.track)[0].mesh
    node = pulled_node(PULLED, mesh)
    distance = np.linalg.norm(mesh.nodes - np.array(PULLED.flexible.com_node), axis=1)
    assert distance[node] == distance.min() < 0.05
    there = PULLED.with_(flexible=PULLED.flexible.with_(com_node=tuple(mesh.nodes[17])))
    assert pulled_node(there, mesh) == 17
    middle = PULLED.with_(flexible=PULLED.flexible.with_(shoes=(7,)))
    assert pulled_node(middle, mesh) is None


def test_an_unknown_point_is_refused():
    with pytest.raises(ParameterError, match="point"):
        Drive(speed=QUICK, point="rear pins")
