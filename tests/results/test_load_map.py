"""What acts on the shoes: as data, as coordinates of unit loads, as modes feel it, and exported."""

from dataclasses import replace

import numpy as np
import pytest

from exudyn_crawler import History, simulate
from exudyn_crawler.case.gear.base import WheelLabel
from exudyn_crawler.case.gear.running_gear import RunningGear
from exudyn_crawler.case.parameters.track import FlexibleShoes
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.shoe_mesh import cubic_weights, pulled_node, rail_rows, station_spacing
from exudyn_crawler.results.balance import (
    energies,
    powers,
    shoe_actions,
    shoe_imbalance,
    shoe_momentum_rates,
    track_imbalance,
)
from exudyn_crawler.results.history.states import system_history
from exudyn_crawler.results.loads.actions import (
    Action,
    AtDriveNode,
    AtInterface,
    OnRail,
    OverRectangle,
    OverSurface,
    actions,
)
from exudyn_crawler.results.loads.exports import (
    action_table,
    pin_forces,
    pin_table,
    roller_loads,
    shoe_loads,
)
from exudyn_crawler.results.loads.kinds import Kind
from exudyn_crawler.results.loads.load_map import GROUND, RAILS, coordinates, loads_by_kind, unit_loads
from exudyn_crawler.results.loads.locations import OnTread
from exudyn_crawler.results.stress.basis import ground_grid, rail_stations, static_loads
from fem import Partition
from fem.body.element_stress import von_mises
from tests.modal_loads import modal_loads, whole_coordinates
from tests.rolled import SHOES, small_flexible_case
from tests.states import row_of
from tests.stress_results import short_run

TIME = 0.05
WEIGHT = 13 * 432.3e3  # N, of the loaded track
TURNS = {"level": (0, 0, 0), "pitched": (0, 0.2, 0), "rolled": (0.02, -0.1, 0), "yawed": (0.01, 0.1, 0.1)}
"""rad, about x, y, z: also such that a part of the underside alone touches the ground."""


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
    assert [("drive", "frame") in one for one in (seven, named(translation, 13))] == [False, True]


def test_a_flexible_shoe_is_held_at_both_pins_of_each_link(history):
    right = {"front right", "rear right"}
    for shoe, pins in ((7, right | {"front left", "rear left"}), (2, right)):
        assert {where for kind, where in named(history, shoe) if kind == "joint"} == pins


def test_pins_act_where_they_are_and_with_opposite_forces(history):
    behind, ahead = (named(history, shoe) for shoe in (6, 7))
    for side in ("right", "left"):
        one, other = behind["joint", f"front {side}"], ahead["joint", f"rear {side}"]
        assert np.array_equal((one.force, one.moment), (-other.force, -other.moment))
        # the flexible shoe's pin is that of the unbent shoe
        assert one.point == pytest.approx(other.point, abs=1e-3)


def test_actions_enter_a_flexible_shoe_by_name(history):
    acting = actions(history, 13)
    entries = {one.kind: one.entry for one in acting if (one.kind, one.where) != ("drive", "frame")}
    assert [type(entries[kind]) for kind in ("joint", "contact")] == [AtInterface, OverRectangle]
    assert [entries[kind] for kind in ("load", "weight", "drive")] == [OverSurface(), None, AtDriveNode()]


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
        expected = sum(action.force for action in actions(turning, shoe))
        assert summed[:, shoe - 1] == pytest.approx(expected, abs=1e-6)


def test_flexible_shoes_obey_newton_with_their_own_mass(history):
    off = shoe_imbalance(history)
    assert np.abs(off.force).max() < 1e-6 * WEIGHT
    # residuals of 0.2 N as a root mean square of 300 equations may add up over 13 shoes
    assert np.abs(track_imbalance(history).force).max() < 2e-6 * WEIGHT
    # rigid shoes between them keep their moments, too
    assert np.abs(off.moment.sel(shoe=[1, 6, 8, 12])).max(skipna=False) < 1e-6 * WEIGHT
    assert off.moment.sel(shoe=[7, 13]).isnull().all()


def test_energies_of_flexible_shoes_are_refused(history):
    for function in (energies, powers):
        with pytest.raises(ValueError, match="needs rigid shoes"):
            function(history)


@pytest.mark.simulation
def test_modal_loads_are_the_virtual_work_of_the_actions():
    history = short_run(0.06, shoes=(13,), mesh="coarse")
    whole, shoe, time = unit_loads(history.case).whole, 13, -1
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
        elif isinstance(action.entry, AtDriveNode):
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


@pytest.mark.simulation
@pytest.mark.parametrize("turns", TURNS.values(), ids=TURNS)
def test_modes_feel_the_ground_as_in_the_equations(turns):
    """At rest, with every shoe sunk in the ground and turned."""
    system = compiled_system(small_flexible_case())
    layout, contact = system.layout, system.contact
    q = np.zeros(sum(layout.part(np.zeros((1, layout.size)), "coordinates").shape[1:]))
    places = q[: 6 * SHOES].reshape(-1, 6)
    places[:, 2], places[:, 3:] = -0.03, turns
    history = system_history(system, row_of(layout, {"coordinates": q})[None])
    forces = contact.forces(q[: contact.size], np.zeros(contact.size))
    flexible = history.case.part(FlexibleShoes).shoes
    modal = forces[-len(flexible) * layout.modes :].reshape(len(flexible), -1)
    units = unit_loads(history.case)
    for shoe, expected in zip(flexible, modal, strict=True):
        frames = rotation_matrices(history.angles.sel(shoe=shoe).values)
        contacts = [one for one in actions(history, shoe) if isinstance(one.entry, OverRectangle)]
        loads = sum(coordinates(units, one, frames) @ units.work for one in contacts)
        assert np.abs(expected).max() > 100.0
        # forces have single precision in a history
        found = (loads @ units.integrated.inside)[0]
        np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


def test_patches_of_a_shoe_cover_its_underside(history):
    """But for half a unit's length times its tilt squared, and what its tilt moves the overlap by."""
    own = history.patch.isel(contact=history.contact_shoe.values == 7).values
    pressed = own[..., 1] > own[..., 0]
    assert (pressed.sum(axis=1) > 1).all()
    low_x, high_x, low_y, high_y = history.case.shoe.footprint[:4]
    areas = np.where(pressed, np.prod(own[..., 1::2] - own[..., 0::2], axis=-1), 0.0).sum(axis=1)
    np.testing.assert_allclose(areas, (high_x - low_x) * (high_y - low_y), rtol=0.01)
    for part, end, far in ((own[..., 0], low_x, np.inf), (own[..., 3], high_y, -np.inf)):
        ends = np.where(pressed, part, far)
        nearest = ends.min(axis=1) if far > 0.0 else ends.max(axis=1)
        np.testing.assert_allclose(nearest, end, atol=0.01)


def test_a_force_anywhere_on_a_rail_moves_modes_as_in_the_equations():
    """Cubics between the stations of the equations, whose values at thirds are coordinates."""
    case = small_flexible_case()
    units, rails = unit_loads(case), case.shoe.rails
    x = np.linspace(rails.rear, rails.front, 41)
    force = np.random.default_rng(3).standard_normal((41, 3))
    for line, rows in enumerate(rail_rows(units.whole, case.part(RunningGear), rails)):
        at = cubic_weights((x - rails.rear) / station_spacing(rails)) @ rows.reshape(len(rows), -1)
        expected = np.einsum("tc,tcm->tm", force, at.reshape(41, 3, -1))
        zero, place = np.zeros((41, 3)), OnTread(WheelLabel("roller", 1), "right")
        action = Action(Kind.ROLLER, 5, place, zero, force, zero, OnRail(line, x))
        found = coordinates(units, action, np.tile(np.eye(3), (41, 1, 1))) @ units.work
        np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.slow
def test_static_loads_have_the_forces_and_moments_of_the_unit_loads():
    """Strips press on the middles of their rails: their places across are left out."""
    case = small_flexible_case()
    units, static = unit_loads(case), static_loads(case)
    counts = list(static.fields.families.values())
    starts = dict(zip(static.fields.families, np.cumsum([0, *counts[:-1]]).tolist(), strict=True))
    mesh = units.body.mesh
    places = np.column_stack((np.ones(len(mesh.nodes)), mesh.nodes))
    grid, stations = ground_grid(mesh), rail_stations(mesh)
    rail_weights = np.hstack([one.weights.toarray() for one in stations])
    for name, weights in ((GROUND, grid.weights.toarray()), (RAILS, rail_weights)):
        family, at = units.spread[name], units.families[name]
        # of forces along x alone
        columns = slice(starts[name], starts[name] + 3 * weights.shape[1], 3)
        own = static.shares[at.start : at.stop : 3, columns].toarray()
        found, expected = own @ weights.T @ places, family.weights @ places[family.nodes]
        chosen = [0, 1, 3] if name == RAILS else [0, 1, 2, 3]
        scale = np.abs(expected).max(axis=0)[chosen]
        np.testing.assert_allclose(found[:, chosen] / scale, expected[:, chosen] / scale, atol=1e-3)


@pytest.mark.slow
def test_rollers_are_among_the_loads_of_a_rolled_shoe():
    """What the stations of both rails bear is what the rollers press with."""
    history = simulate(small_flexible_case(), 0.02)
    at = unit_loads(history.case).families[RAILS]
    own = loads_by_kind(history, 5)[Kind.ROLLER][:, at].toarray()
    pressed = roller_loads(history, 5).force.sum(("roller", "rail")).values
    assert np.abs(pressed).max() > 1e5
    np.testing.assert_allclose(own.reshape(len(own), -1, 3).sum(axis=1), pressed, atol=1e-6)


def test_a_unit_that_a_shoe_never_touches_loads_nothing(history):
    """Of a part of a run, in which the shoe stood on other units before."""
    contact = next(one for one in actions(history, 7) if isinstance(one.entry, OverRectangle))
    never = replace(contact, entry=contact.entry._replace(pressed=np.zeros_like(contact.entry.pressed)))
    units, frames = unit_loads(history.case), rotation_matrices(history.angles.sel(shoe=7).values)
    assert coordinates(units, contact, frames).nnz
    assert coordinates(units, never, frames).nnz == 0


@pytest.fixture(scope="module")
def front(history):
    """Loads of the front shoe, which the drive pulls, while it is set going."""
    return shoe_loads(history, 13, TIME)


@pytest.mark.parametrize("shoe", [7, 13])
def test_forces_and_moments_of_a_deck_are_in_balance(history, shoe):
    loads = shoe_loads(history, shoe, TIME)
    assert loads.time == pytest.approx(TIME)
    size = np.abs(loads.nodal).sum() + np.abs(loads.centers).sum()
    assert size > 1e5
    assert np.abs(loads.residual).max() < 1e-10 * size


@pytest.mark.parametrize("shift", [0.0, 0.4])
def test_loads_do_the_elastic_forces_work_on_every_mode(history, shift):
    """Also of a machine's load that acts beside the middle of the shoe."""
    loads = history.case.loads
    phases = tuple(phase.with_(side_shift=shift) for phase in loads.phases)
    history = History(history.case.with_(loads=loads.with_(phases=phases)), history.dataset)
    front = shoe_loads(history, 13, TIME)
    whole = unit_loads(history.case).whole
    row = int(np.abs(history.time.values - TIME).argmin())
    q = whole_coordinates(history, 13)[row]
    elastic = (2.0 * np.pi * whole.frequencies) ** 2 * q
    found = np.einsum("nk,nkm->m", front.nodal, whole.modes)
    found += np.einsum("ik,ikm->m", front.centers, whole.pilots)
    assert found == pytest.approx(elastic, abs=1e-6 * np.abs(elastic).max())


def test_a_static_solution_has_the_stress_of_the_run(history, front):
    whole = unit_loads(history.case).whole
    row = int(np.abs(history.time.values - TIME).argmin())
    modal = von_mises(whole.stress(whole_coordinates(history, 13)[row])[0])
    partition = Partition(front.body, front.interfaces)
    shape = partition.static_response(front.nodal.reshape(-1, 1), front.centers.reshape(-1, 1))
    static = von_mises(front.body.stress(shape.reshape(-1, 3, 1))[:, :, 0])
    # what the modal basis leaves out of the contacts' local stress
    assert np.linalg.norm(modal - static) < 0.06 * np.linalg.norm(static)
    assert modal.max() == pytest.approx(static.max(), rel=0.02)


@pytest.mark.parametrize("shoe", [1, 7, 12, 13])
def test_the_table_sums_to_zero_and_inertia_is_mass_times_acceleration(history, shoe):
    numbers = action_table(history, shoe, TIME).set_index("kind").drop(columns="where")
    assert np.abs(numbers.loc["sum"].to_numpy()).max() < 1e-6 * np.abs(numbers.to_numpy()).max()
    frame = rotation_matrices(history.angles.sel(shoe=shoe, time=TIME, method="nearest").values)
    rate = shoe_momentum_rates(history).force.sel(shoe=shoe, time=TIME, method="nearest").values
    inertia = numbers.loc["inertia", ["Fx in N", "Fy in N", "Fz in N"]].to_numpy(dtype=float)
    assert frame @ inertia == pytest.approx(-rate, abs=5.0)


@pytest.mark.parametrize("program", ["calculix", "abaqus"])
def test_a_deck_is_written_with_its_table(front, tmp_path, program):
    text = front.write(tmp_path / "deck.inp", program).read_text()
    assert text.startswith("** shoe 13 at t = 0.05 s; N, m, Pa")
    assert "com node" in text
    assert text.count("*RIGID BODY") == 4
    with pytest.raises(FileExistsError, match=r"deck\.inp exists"):
        front.write(tmp_path / "deck.inp", program)


def test_what_is_no_shoe_or_time_of_the_run_is_refused(history):
    for function, shoe, time, words in (
        (shoe_loads, 5, 0.0, r"of \[7, 13\], got 5"),
        (shoe_loads, 13, 1.0, r"time must be in 0\.\.0\.06 s, got 1 s"),
        (action_table, 0, 0.0, r"shoe must be in 1\.\.13, got 0"),
    ):
        with pytest.raises(ValueError, match=words):
            function(history, shoe, time)


def test_rigid_links_have_no_pin_forces(history):
    beside = [6, 7, 12]
    for name in ("pin_force", "pin_torque"):
        pins = history.dataset[name]
        assert bool(pins.sel(joint=beside).notnull().all())
        assert bool(pins.drop_sel(joint=beside).isnull().all())
    # and the joint's are there for all
    assert bool(history.joint_force.notnull().all())


def test_pin_forces_are_the_actions_in_the_shoes_axes(history):
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


def test_the_table_names_pin_axis_and_unit(history):
    table = pin_table(history, 7)
    assert list(table.columns[:2]) == ["time in s", "front right Fx in N"]
    assert len(table.columns) == 1 + 2 * 4 * 3
    assert np.array_equal(table["time in s"], history.time.values)
    # a shoe beside a flexible one shares its pins
    assert [name for name in pin_table(history, 12).columns if name.startswith("rear")] == []
