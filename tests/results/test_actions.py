"""Actions as data: what acts on the shoes, where, and that balances and modal loads see all of it."""

import numpy as np
import pytest

from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.shoe_mesh import pulled_node
from exudyn_crawler.results.loads.actions import (
    AtDrivePoint,
    AtInterface,
    OverRectangle,
    OverSurface,
    actions,
)
from exudyn_crawler.results.loads.load_map import unit_loads
from studies.balance import energies, powers, shoe_actions, shoe_imbalance, track_imbalance
from tests.modal_loads import modal_loads

WEIGHT = 13 * 432.3e3  # N, of the loaded track


def named(history, shoe):
    return {(action.kind, action.where): action for action in actions(history, shoe)}


def test_every_shoe_of_a_rigid_track_has_its_actions(translation):
    assert set(named(translation, 1)) == {
        ("joint", "front right"), ("weight", "COM"), ("load", "top"), ("contact", "unit 7")
    }  # fmt: skip
    seven = named(translation, 7)
    assert {("joint", "rear right"), ("contact", "unit 7"), ("contact", "unit 12")} < set(seven)
    # contacts enter a rigid shoe as a whole
    assert {action.entry for (kind, _), action in seven.items() if kind == "contact"} == {None}
    assert ("drive", "frame") not in seven
    assert ("drive", "frame") in named(translation, 13)


def test_a_flexible_shoe_is_held_at_both_pins_of_each_link(flexible_run):
    right = {"front right", "rear right"}
    for shoe, pins in ((7, right | {"front left", "rear left"}), (2, right)):
        assert {where for kind, where in named(flexible_run[0], shoe) if kind == "joint"} == pins


def test_pins_act_where_they_are_and_with_opposite_forces(flexible_run):
    behind, ahead = (named(flexible_run[0], shoe) for shoe in (6, 7))
    for side in ("right", "left"):
        one, other = behind["joint", f"front {side}"], ahead["joint", f"rear {side}"]
        assert np.array_equal(one.force, -other.force)
        assert np.array_equal(one.moment, -other.moment)
        # the flexible shoe's pin is that of the unbent shoe
        assert one.point == pytest.approx(other.point, abs=1e-3)


def test_actions_enter_a_flexible_shoe_by_name(flexible_run):
    entries = {
        kind: action.entry
        for (kind, where), action in named(flexible_run[0], 13).items()
        if (kind, where) != ("drive", "frame")
    }
    assert isinstance(entries["joint"], AtInterface)
    assert entries["load"] == OverSurface()
    assert isinstance(entries["contact"], OverRectangle)
    assert (entries["weight"], entries["drive"]) == (None, AtDrivePoint())


def test_contacts_are_those_by_shoe(translation):
    by_shoe = translation.contacts_by_shoe()
    for shoe in (1, 7):
        force = sum(action.force for action in actions(translation, shoe) if action.kind == "contact")
        assert force == pytest.approx(by_shoe.contact_force.sel(shoe=shoe).values, abs=1e-9)


def test_a_moment_counts_the_arm_of_the_force(turning):
    load = named(turning, 5)["load", "top"]
    position = turning.position.sel(shoe=5).values
    arm = rotation_matrices(turning.angles.sel(shoe=5).values) @ np.array(turning.case.shoe.load_point)
    assert load.moment_about(position) == pytest.approx(np.cross(arm, load.force), abs=1e-6)


def test_balances_sum_over_every_action(turning):
    summed = shoe_actions(turning).sum("source").force.values
    for shoe in (1, 7, 13):
        assert summed[:, shoe - 1] == pytest.approx(
            sum(action.force for action in actions(turning, shoe)), abs=1e-6
        )


def test_flexible_shoes_obey_newton_with_their_own_mass(flexible_run):
    history = flexible_run[0]
    off = shoe_imbalance(history)
    assert np.abs(off.force).max() < 1e-6 * WEIGHT
    # residuals of 0.2 N as a root mean square of 300 equations may add up over 13 shoes
    assert np.abs(track_imbalance(history).force).max() < 2e-6 * WEIGHT
    # rigid shoes between them keep their moments, too
    rigid = off.moment.sel(shoe=[1, 6, 8, 12])
    assert np.abs(rigid).max(skipna=False) < 1e-6 * WEIGHT
    assert off.moment.sel(shoe=[7, 13]).isnull().all()


def test_energies_of_flexible_shoes_are_refused(flexible_run):
    for function in (energies, powers):
        with pytest.raises(ValueError, match="must have rigid shoes"):
            function(flexible_run[0])


def test_modal_loads_are_the_virtual_work_of_the_actions(flexible_run):
    """Each action's force and moment times what every mode moves and turns its place by."""
    history = flexible_run[0]
    whole = unit_loads(history.case).whole
    shoe, time = 13, -1
    frame = rotation_matrices(history.angles.sel(shoe=shoe).values)[time]
    weights = whole.weights("underside")
    expected, contact = np.zeros((2, len(whole.frequencies)))
    for action in actions(history, shoe):
        force, moment = frame.T @ action.force[time], frame.T @ action.moment[time]
        if isinstance(action.entry, AtInterface):
            names = [interface.name for interface in whole.interfaces]
            rows = whole.pilots[names.index(action.entry.name)]
            expected += force @ rows[:3] + moment @ rows[3:]
        elif isinstance(action.entry, OverSurface):
            expected += whole.load(history.case.flexible.load_surface, force)
        elif isinstance(action.entry, AtDrivePoint):
            expected += force @ whole.modes[pulled_node(history.case, whole.mesh)]
        elif isinstance(action.entry, OverRectangle):
            # the faces that the rectangle cuts are left to the nodes within, or less than 1 cm beside it
            low, high = action.entry.low[time], action.entry.high[time]
            nodes = whole.mesh.nodes_of("underside")
            places = whole.nodes[nodes, :2]
            inside = nodes[np.all((places >= low - 0.01) & (places <= high + 0.01), axis=1)]
            shares = weights[inside] / weights[inside].sum()
            contact += force @ np.tensordot(shares, whole.modes[inside], axes=1)
    found = modal_loads(history, shoe)[time]
    # 4 % by the cut faces; all else is exact
    assert np.linalg.norm(found - expected - contact) < 0.1 * np.linalg.norm(contact)
