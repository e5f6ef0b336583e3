"""A side frame that rolls over shoes: mechanics of short runs, and its rest against a chain of beams."""

import numpy as np
import pytest

from exudyn_crawler import Case, StepProfile, simulate
from exudyn_crawler.case import MachineCycle
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.results.balance import energy_balance, frame_imbalance, shoe_imbalance, track_imbalance
from exudyn_crawler.results.loads.exports import roller_loads, shoe_loads
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from tests.modal_loads import kinds_of_gear_on_modes
from tests.rolled import ROLLERS, small_case, small_flexible_case

pytestmark = pytest.mark.simulation


def weight(history):
    return history.case.gear.mass * history.case.gravity


@pytest.fixture(scope="module")
def on_sand():
    """Two flexible shoes, their first step from rest included."""
    return simulate(small_flexible_case().on_cells(BekkerSoil.lete_sand()), 0.03, progress=False)


@pytest.fixture(scope="module")
def on_sandy_slope():
    """The same on sand that rises along the track and across it."""
    case = small_flexible_case().with_({"terrain.grade": 0.05, "terrain.side_slope": 0.05})
    return simulate(case.on_cells(BekkerSoil.lete_sand()), 0.03, progress=False)


@pytest.mark.parametrize("name", ["rolled", "bent", "on_sand", "on_sandy_slope"])
def test_frame_and_shoes_are_in_balance_at_every_stored_instant(name, request):
    history = request.getfixturevalue(name)
    off = frame_imbalance(history)
    assert set(off.data_vars) == {"travel", "heave", "roll", "pitch"}
    for direction, values in off.data_vars.items():
        assert np.abs(values).max() < 1e-6 * weight(history), direction
    assert np.abs(shoe_imbalance(history)["force"]).max() < 3e-6 * weight(history)


def test_rigid_shoes_and_track_are_in_balance_and_rollers_carry_the_frame_from_the_start(rolled):
    assert -rolled.roller_force.values[0, ..., 2].sum() == pytest.approx(weight(rolled), rel=1e-3)
    for off in (shoe_imbalance(rolled), track_imbalance(rolled, (12.0, 9.3, 0.0))):
        assert np.abs(off["force"]).max() < 2e-6 * weight(rolled)
        assert np.abs(off["moment"]).max() < 2e-6 * weight(rolled)


def test_work_of_the_drive_goes_into_resistance_friction_damping_and_energy(rolled):
    balance = energy_balance(rolled)
    end = balance.isel(time=-1)
    assert float(end["drive"]) > 1e4
    assert np.abs(balance["imbalance"]).max() < 0.01 * float(end["drive"])
    for taken in ("rolling_resistance", "tread_damping"):
        assert float(end[taken]) > 0.0, taken


def test_the_machine_starts_at_rest():
    """Creeping for 6 s in place of 30 s, it would fall at 4e-3 of gravity."""
    case = Case.rolled()
    still = StepProfile(times=(0.0, 1.0), values=(0.0, 0.0))
    history = simulate(case.with_(drive=case.drive.with_(speed=still)), 0.01, progress=False)
    assert abs(history.side_frame_acceleration.values[0]).max() < 1e-4 * case.gravity
    assert abs(history.side_frame_velocity.values).max() < 1e-5


def test_shoes_that_no_roller_is_on_carry_themselves():
    """The last shoe lies ahead of the front roller by more than a shoe, and no tension lifts its end."""
    history = simulate(small_case(end_tension=0.0), 0.004, progress=False)
    assert history.roller_shoe.values.max() <= 7
    level = history.case.shoe.mass * history.case.gravity
    contact = history.normal_force.values[0, history.contact_shoe.values == 10, 2].sum()
    assert contact == pytest.approx(level, rel=0.1)


def test_loads_of_a_shoe_are_those_of_its_rails(rolled, bent):
    for history in (rolled, bent):
        found = roller_loads(history, 5)
        rails = history.case.shoe.rails
        pressed = np.abs(found["force"].values).sum(axis=-1) > 0.0
        assert pressed.any()
        x, y = (found["place"].values[..., k][pressed] for k in (0, 1))
        assert ((x > rails.rear - 1e-6) & (x < rails.front + 1e-6)).all()
        np.testing.assert_allclose(np.abs(y), rails.left, atol=0.05)
        assert (found["force"].values[..., 2][pressed] < 0.0).all()
    # those of an instant have the rollers, too
    loads = shoe_loads(bent, 5, 0.04)
    assert (loads.table["kind"] == "roller").sum() >= 2
    assert np.abs(loads.residual).max() < 1e-3 * weight(bent)


def test_machine_presses_and_tilts_the_frame():
    """Its force and moment go into the balance, and the front rollers carry more than the rear ones."""
    start = {"name": "straight", "end": 0.0, "force": (0.0, 0.0, 0.0), "moment": (0.0, 0.0, 0.0)}
    dig = {"name": "dig", "end": 0.04, "force": (-2e4, 0.0, -3e5), "moment": (0.0, 6e5, 0.0)}
    history = simulate(small_case().with_(machine=MachineCycle(phases=(start, dig))), 0.06, progress=False)
    for direction, values in frame_imbalance(history).data_vars.items():
        assert np.abs(values).max() < 1e-6 * weight(history), direction
    carried = -history.roller_force.values[..., 2].sum(axis=2)
    assert carried[-1, -1] - carried[0, -1] > 1e5
    assert carried[-1, -1] - carried[0, -1] > carried[-1, 0] - carried[0, 0]


def test_symmetric_machine_gives_symmetric_results():
    case = small_case()
    middle = case.track.first_com[1]
    pins = {"track.spherical_y": middle - 0.7, "track.parallel_y": middle + 0.7}
    units = {"terrain.rows": 1, "terrain.origin": (0.0, middle - 0.5 * case.terrain.unit_width)}
    history = simulate(case.with_(pins | units), 0.05, progress=False)
    force = history.roller_force.values
    np.testing.assert_allclose(force[:, :, 0], force[:, :, 1], atol=1e-6 * weight(history))


def test_modes_feel_in_the_stresses_what_they_feel_in_the_run():
    """Roller forces on the modes by the records of a history are those that leave with a lifted frame."""
    case = small_flexible_case()
    q = static_equilibrium(case)
    lifted = q.copy()
    lifted[-4] += 0.1
    assert kinds_of_gear_on_modes(case, q, lifted) == {"roller"}


def beams(case, k, weight_of_shoe):
    """Depths of pins and frame, places of pins, forces of rollers: hinged beams on springs, solved directly.

    Each shoe is a beam from pin to pin on an even bed of stiffness k; rollers are springs between it and the
    frame. Unknown are the depth of every pin, with the track's two free ends, and the frame's motion.
    """
    frame, track, shoe = case.gear, case.track, case.shoe
    n = track.shoe_count
    pins = track.first_com[0] + track.pin_ahead + track.pitch * np.arange(-1, n)
    matrix, load, rows = np.zeros((n + 3, n + 3)), np.zeros(n + 3), []
    for s in range(n):
        at = lambda x, s=s: np.array([(pins[s + 1] - x), (x - pins[s])]) / track.pitch  # noqa: E731
        center = track.first_com[0] + s * track.pitch
        mean, slope = at(center), np.array([-1.0, 1.0]) / track.pitch
        bed = k * np.outer(mean, mean) + k * shoe.length**2 / 12.0 * np.outer(slope, slope)
        matrix[s : s + 2, s : s + 2] += bed
        load[s : s + 2] += weight_of_shoe * mean
    for x in frame.rollers:
        place = frame.start + x
        s = int(np.searchsorted(pins, place)) - 1
        row = np.zeros(n + 3)
        row[s : s + 2] = [(pins[s + 1] - place) / track.pitch, (place - pins[s]) / track.pitch]
        row[n + 1], row[n + 2] = -1.0, -x
        rows.append(2.0 * frame.stiffness * row)
        matrix += np.outer(rows[-1], row)
    load[n + 1] = frame.mass * case.gravity
    found = np.linalg.solve(matrix, load)
    return found, pins, -np.array(rows) @ found


def test_rest_is_that_of_hinged_beams_on_springs():
    """Heavy shoes under a light frame on linear ground, so that no edge of a shoe leaves it."""
    k, frame_mass, shoe_mass = 2e8, 6e3, 60e3
    light = {"mass": frame_mass, "inertia": (1e4, 1e4, 1e4, 0.0, 0.0, 0.0), "com": (0.0, 0.0, 0.0)}
    case = small_case(**light, end_tension=0.0)
    ground = {"contact.stiffness": k, "contact.exponent": 1.0, "terrain.spring_stiffness": 1e14}
    case = case.with_(ground, shoe=case.shoe.of_mass(shoe_mass))
    q = static_equilibrium(case)
    shoes, frame = q[: 6 * case.track.shoe_count].reshape(-1, 6), q[-4:]
    found, pins, rollers = beams(case, k, shoe_mass * case.gravity)
    share = (case.track.com_positions(0.0)[:, 0] - pins[:-1]) / case.track.pitch
    depth = found[:-3] * (1.0 - share) + found[1:-2] * share
    tilt = np.diff(found[:-2]) / case.track.pitch
    level = shoe_mass * case.gravity / k
    np.testing.assert_allclose(-shoes[:, 2] - level, depth - level, atol=0.02 * np.ptp(depth))
    np.testing.assert_allclose(shoes[:, 4], tilt, atol=0.02 * np.abs(tilt).max())
    assert -frame[0] == pytest.approx(found[-2], rel=0.01)
    found = compiled_system(case).gear_forces(np.zeros(1), q[None], np.zeros((1, len(q))))
    pressed = -found.strip_force[..., 2].sum(axis=-1)
    single = [pressed[found.strip_wheel == roller].sum() for roller in range(len(ROLLERS))]
    np.testing.assert_allclose(single, rollers, rtol=3e-3)
