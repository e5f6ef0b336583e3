"""Pin forces: both sides of a flexible shoe's links, in the shoe's axes."""

import numpy as np
import pytest

from exudyn_crawler import actions, pin_forces
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.loads.exports import pin_table


def test_rigid_links_have_no_pin_forces(flexible_run):
    history = flexible_run[0]
    beside = {6, 7, 12}
    for joint in history.case.track.joints.tolist():
        for name in ("pin_force", "pin_torque"):
            pins = history.dataset[name].sel(joint=joint)
            assert bool(pins.notnull().all()) if joint in beside else bool(pins.isnull().all())
    # and the joint's are there for all
    assert bool(history.joint_force.notnull().all())


def test_the_pins_of_a_link_add_up_to_its_joint(flexible_run):
    history = flexible_run[0]
    both = history.pin_force.sel(joint=12).sum("pin")
    assert both.values == pytest.approx(history.joint_force.sel(joint=12).values, abs=1e-6)


def test_pin_forces_are_the_actions_in_the_shoes_axes(flexible_run):
    history = flexible_run[0]
    found = pin_forces(history, 13)
    frames = rotation_matrices(history.angles.sel(shoe=13).values)
    assert found.force.sel(pin=["front right", "front left"]).isnull().all()
    for action in actions(history, 13):
        if action.kind == "joint":
            own = found.sel(pin=action.where)
            assert (frames @ own.force.values[..., None])[..., 0] == pytest.approx(action.force, abs=1e-6)
            assert (frames @ own.moment.values[..., None])[..., 0] == pytest.approx(action.moment, abs=1e-6)


def test_rigid_tracks_have_none(turning):
    assert pin_forces(turning, 5).force.isnull().all()
    with pytest.raises(ValueError, match="shoe must be flexible, or beside one that is"):
        pin_table(turning, 5)
    with pytest.raises(ValueError, match=r"shoe must be in 1\.\.13, got 14"):
        pin_forces(turning, 14)


def test_the_table_names_pin_axis_and_unit(flexible_run):
    history = flexible_run[0]
    table = pin_table(history, 7)
    assert list(table.columns[:2]) == ["time in s", "front right Fx in N"]
    assert len(table.columns) == 1 + 2 * 4 * 3
    assert np.array_equal(table["time in s"], history.time.values)
    # a shoe beside a flexible one shares its pins
    assert [name for name in pin_table(history, 12).columns if name.startswith("rear")] == []
