"""What acts on a shoe in its axes: at one instant in balance, with the run's stress, and at its pins."""

import numpy as np
import pytest

from exudyn_crawler import History
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.results.loads.actions import actions
from exudyn_crawler.results.loads.exports import action_table, pin_forces, pin_table, shoe_loads
from exudyn_crawler.results.loads.load_map import unit_loads
from exudyn_crawler.results.stress.recovery import peak_time
from fem import Partition
from fem.stress import von_mises
from studies.balance import shoe_momentum_rates
from tests.modal_loads import whole_coordinates

TIME = 0.05


@pytest.fixture(scope="module")
def front(flexible_run):
    """Loads of the front shoe, which the drive pulls, while it is set going."""
    return shoe_loads(flexible_run[0], 13, TIME)


@pytest.mark.parametrize("shoe", [7, 13])
def test_forces_and_moments_of_a_deck_are_in_balance(flexible_run, shoe):
    loads = shoe_loads(flexible_run[0], shoe, TIME)
    assert loads.time == pytest.approx(TIME)
    size = np.abs(loads.nodal).sum() + np.abs(loads.centers).sum()
    assert size > 1e5
    assert np.abs(loads.residual).max() < 1e-10 * size


@pytest.mark.parametrize("shift", [0.0, 0.4])
def test_loads_do_the_elastic_forces_work_on_every_mode(flexible_run, shift):
    """Also of a machine's load that acts beside the middle of the shoe."""
    case = flexible_run[0].case
    phases = tuple(phase.with_(side_shift=shift) for phase in case.loads.phases)
    shifted = case.with_(loads=case.loads.with_(phases=phases))
    history = History(shifted, flexible_run[0].dataset)
    front = shoe_loads(history, 13, TIME)
    whole = unit_loads(history.case).whole
    row = int(np.abs(history.time.values - TIME).argmin())
    q = whole_coordinates(history, 13)[row]
    elastic = (2.0 * np.pi * whole.frequencies) ** 2 * q
    found = np.einsum("nk,nkm->m", front.nodal, whole.modes)
    found += np.einsum("ik,ikm->m", front.centers, whole.pilots)
    assert found == pytest.approx(elastic, abs=1e-6 * np.abs(elastic).max())


def test_a_static_solution_has_the_stress_of_the_run(flexible_run, front):
    history = flexible_run[0]
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
def test_the_table_sums_to_zero_and_inertia_is_mass_times_acceleration(flexible_run, shoe):
    history = flexible_run[0]
    table = action_table(history, shoe, TIME).set_index("kind")
    numbers = table.drop(columns="where")
    assert np.abs(numbers.loc["sum"].to_numpy()).max() < 1e-6 * np.abs(numbers.to_numpy()).max()
    frame = rotation_matrices(history.angles.sel(shoe=shoe, time=TIME, method="nearest").values)
    rate = shoe_momentum_rates(history).force.sel(shoe=shoe, time=TIME, method="nearest").values
    inertia = numbers.loc["inertia", ["Fx in N", "Fy in N", "Fz in N"]].to_numpy(dtype=float)
    assert frame @ inertia == pytest.approx(-rate, abs=5.0)


def test_the_peak_is_that_of_the_recovered_stress(flexible_run):
    history, stress, _ = flexible_run
    highest = stress.highest_von_mises.sel(shoe=7)
    assert peak_time(history, 7) == pytest.approx(float(highest.time[int(highest.values.argmax())]))


@pytest.mark.parametrize("program", ["calculix", "abaqus"])
def test_a_deck_is_written_with_its_table(front, tmp_path, program):
    text = front.write(tmp_path / "deck.inp", program).read_text()
    assert text.startswith("** shoe 13 at t = 0.05 s; N, m, Pa")
    assert "com node" in text
    assert text.count("*RIGID BODY") == 4
    with pytest.raises(FileExistsError, match=r"deck\.inp exists"):
        front.write(tmp_path / "deck.inp", program)


def test_what_is_no_shoe_or_time_of_the_run_is_refused(flexible_run):
    history = flexible_run[0]
    with pytest.raises(ValueError, match=r"of \[7, 13\], got 5"):
        shoe_loads(history, 5, 0.0)
    with pytest.raises(ValueError, match=r"time must be in 0\.\.0\.06 s, got 1 s"):
        shoe_loads(history, 13, 1.0)
    with pytest.raises(ValueError, match=r"shoe must be in 1\.\.13, got 0"):
        action_table(history, 0, 0.0)


def test_rigid_links_have_no_pin_forces(flexible_run):
    history = flexible_run[0]
    beside = [6, 7, 12]
    for name in ("pin_force", "pin_torque"):
        pins = history.dataset[name]
        assert bool(pins.sel(joint=beside).notnull().all())
        assert bool(pins.drop_sel(joint=beside).isnull().all())
    # and the joint's are there for all
    assert bool(history.joint_force.notnull().all())


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
