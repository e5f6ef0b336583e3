"""Modes and flutter of the sliding track: by hand, in the plane without the program, and in simulations."""

from itertools import pairwise

import numpy as np
import pytest

from exudyn_crawler import Case, SphereContact
from exudyn_crawler.engine.formulation import track_system
from studies import sliding_modes as study
from studies.flutter import flutter
from studies.grounds import plain
from studies.sliding import eigenmodes, integrated_from, linearized, steady_sliding
from studies.sliding_modes import SPEED, sliding_modes
from tests import states
from tests.studies.planar_track import PlanarTrack

pytestmark = pytest.mark.simulation


def sliding_case(friction, shoes=13, **track):
    """Even ground without seams that hardly moves, constant friction."""
    case = study.with_friction(study.with_shoes(study.even_ground(1e13), shoes), friction, friction)
    return case.with_(track=case.track.with_(**track))


def with_steady_drive(case):
    """At the speed from 1 s on, in steps that damp nothing."""
    speed = {"drive.speed.times": (0.0, 1.0), "drive.speed.values": (0.0, SPEED)}
    steps = {"solver.step": 5e-4, "solver.output_interval": 1e-2, "solver.residual": 1e-3}
    return case.with_(speed | steps)


def in_plane(dataset):
    """Eigenvalues of the swinging modes in the middle plane below the ground's own, 1/s."""
    swings = dataset.where((dataset.frequency > 0.1) & (dataset.frequency < 50.0), drop=True)
    aside = np.abs(swings["shape"].sel(coordinate=["y", "roll", "yaw"])).max(("shoe", "coordinate"))
    kept = swings.where(aside < 1e-3, drop=True)
    return np.sort_complex((kept.growth_rate + 2j * np.pi * kept.frequency).values)


def test_two_shoes_without_friction_are_three_swings_by_hand():
    """Heave of both, pitch against each other, and both pitching round the pin between them.

    A level shoe has the heave stiffness 2 k d. Pitched by p, its ground reaction N moves by p L**2 / (12 d)
    to the side that sinks, while the underside swings the other way under the COM and the load P over it.
    """
    case = sliding_case(0.0, shoes=2, pin_ahead=0.5 * 0.655742, pin_height=0.0)
    shoe, law = case.shoe, case.contact
    load = case.loads.loads(0.0)[0, 0]
    weight = load + shoe.mass * case.gravity
    depth = np.sqrt(weight / law.stiffness)
    heave = 2.0 * law.stiffness * depth
    pitch = weight * (shoe.length**2 / (12.0 * depth) - shoe.com_height) - load * shoe.load_point[2]
    arm, inertia = case.track.pin_ahead, shoe.inertia[1]
    swings = [
        (shoe.mass, law.damping, heave),
        (inertia, 0.0, pitch),
        (inertia + shoe.mass * arm**2, law.damping * arm**2, pitch + heave * arm**2),
    ]
    by_hand = [-c / (2 * m) + 1j * np.sqrt(k / m - (c / (2 * m)) ** 2) for m, c, k in swings]
    assert in_plane(sliding_modes(case, SPEED)) == pytest.approx(np.sort_complex(by_hand), rel=2e-5)


@pytest.mark.parametrize(("friction", "shoes"), [(0.3, 2), (0.2, 13), (0.4, 13)])
def test_modes_with_friction_are_those_of_the_planar_track(friction, shoes):
    """They flutter: equations without engine, kernel and constraints give the same growth."""
    case = sliding_case(friction, shoes)
    values = in_plane(sliding_modes(case, SPEED))
    by_hand = np.sort_complex(PlanarTrack(case).eigenvalues())
    assert len(values) == len(by_hand)
    for value in by_hand:
        assert np.abs(values - value).min() < 1e-3
    assert (values.real.max() > 0.5) == (shoes == 13)


def test_travel_moves_the_track_over_the_seams():
    """A pitch further, on units as long as a pitch, the track stands on the same ground."""
    case, pitch = plain(Case.translation()), Case.translation().track.pitch
    units = {"columns": 30, "unit_length": pitch, "origin": (3.0, 0.0), "spring_offset": pitch / 12.0**0.5}
    terrain = case.terrain.with_(**units, spring_stiffness=1e11)
    law = case.contact.with_(static_friction=0.1, dynamic_friction=0.1, sharing="area")
    case = case.with_(terrain=terrain, contact=law)
    steady = [steady_sliding(case, SPEED, share * pitch) for share in (0.0, 0.5, 1.0)]
    here, between, there = (one.normal_force for one in steady)
    assert there == pytest.approx(here, rel=1e-4)
    assert np.abs(between / here - 1.0).max() > 1e-3


def test_tension_is_the_friction_behind_the_link():
    state = steady_sliding(sliding_case(0.3), SPEED)
    assert state.tension == pytest.approx(0.3 * np.cumsum(state.normal_force)[:-1], rel=1e-6)
    case = state.system.case
    total = case.loads.loads(0.0).sum() + case.track.shoe_count * case.shoe.mass * case.gravity
    assert state.normal_force.sum() == pytest.approx(total, rel=1e-9)


def row_of(case, q, q_t, q_tt):
    """Row of a state at 2 s; a run finds its multipliers itself."""
    parts = {"time": 2.0, "coordinates": q, "coordinates rate": q_t, "coordinates acceleration": q_tt}
    return states.row_of(track_system(case).layout, parts)


def test_a_run_from_steady_sliding_stays_there():
    case = with_steady_drive(sliding_case(0.3))
    state = steady_sliding(case, SPEED)
    run = integrated_from(case, row_of(case, state.q, state.q_t, np.zeros_like(state.q)), 0.02).dataset
    assert run.joint_force.sel(axis="x")[-1].values == pytest.approx(state.tension, rel=1e-4)
    assert np.abs(run.velocity.sel(axis="z").values).max() < 1e-4
    assert run.velocity.sel(axis="x").values == pytest.approx(SPEED, abs=1e-4)


def test_all_matrices_are_symmetric_without_friction_and_only_then():
    free, rough = (linearized(steady_sliding(sliding_case(mu), SPEED)) for mu in (0.0, 0.3))

    def asymmetry(matrix):
        return np.abs(matrix - matrix.T).max() / np.abs(matrix[np.abs(matrix) < 1e10]).max()

    for matrix in (free.mass, free.damping, free.stiffness):
        assert asymmetry(matrix) < 1e-6
    assert asymmetry(rough.stiffness) > 0.01


def test_the_track_is_stable_without_friction_and_free_across():
    modes = sliding_modes(sliding_case(0.0), SPEED)
    assert modes.growth_rate.where(modes.frequency > 0.1, drop=True).max() < 1e-6
    assert np.abs(modes.growth_rate.where(modes.frequency < 1e-6, drop=True)).min() < 1e-3


def test_modes_are_sorted_and_solve_their_equation():
    linear = linearized(steady_sliding(sliding_case(0.2, shoes=4), SPEED))
    values, shapes = eigenmodes(linear)
    assert np.all(np.diff(values.real) <= 0.0)
    assert values.imag.min() > -1e-6
    inner = linear.basis.T @ shapes
    for value, shape in zip(values, inner.T, strict=True):
        matrix = value**2 * linear.mass + value * linear.damping + linear.stiffness
        assert np.abs(matrix @ shape).max() < 1e-9 * np.abs(matrix).max() * np.abs(shape).max()


def test_a_small_disturbance_grows_in_the_simulation_as_predicted():
    """The least stable pair, pushed by 10 um, over 0.8 s of integration: size, phase and shape."""
    case = with_steady_drive(sliding_case(0.2))
    state = steady_sliding(case, SPEED)
    values, shapes = eigenmodes(linearized(state))
    value, shape = values[0], shapes[:, 0] / np.abs(shapes[:, 0]).max()
    assert value.real > 1.0
    assert 8.0 < value.imag / (2.0 * np.pi) < 10.0

    def heights(size):
        q, q_t, q_tt = (size * (value**k * shape).real for k in range(3))
        row = row_of(case, state.q + q, state.q_t + q_t, q_tt)
        return integrated_from(case, row, 0.8).dataset.position.sel(axis="z")

    size = 1e-5
    grown = (heights(size) - heights(0.0)) / size
    time = grown.time.values - 2.0
    predicted = (np.exp(value * time)[:, None] * shape[2 : 6 * 13 : 6]).real
    envelope = np.exp(value.real * time) * np.abs(shape[2 : 6 * 13 : 6]).max()
    assert envelope[-1] > 2.0 * envelope[0]
    assert np.abs(grown.values - predicted).max(axis=1) == pytest.approx(0.0, abs=0.03 * envelope.max())


def least_stable_swing(modes):
    """Growth rate (1/s) and frequency (Hz) of the least stable mode that swings."""
    swings = np.flatnonzero(modes.frequency.values > 1.0)
    return float(modes.growth_rate[swings[0]]), float(modes.frequency[swings[0]])


@pytest.mark.parametrize(("sharing", "grows"), [("area", True), ("pair", False)])
def test_a_flexible_shoe_has_the_modes_of_a_rigid_one_and_its_own(sharing, grows):
    """Its bending, from 180 Hz on, hardly changes how the track swings.

    Growth and frequency differ by 0.2 % and 0.01 % at 8 Hz where the units under a shoe share one law; by
    0.7 % and 0.4 % at 12 Hz where each has its own, so that the ground is stiffer and nothing grows.
    """
    case = Case.stress("coarse").with_({"contact.sharing": sharing, "flexible.shoes": (13,)})
    soft, rigid = (sliding_modes(one, SPEED) for one in (case, case.with_(flexible=None)))
    growth, frequency = least_stable_swing(rigid)
    assert (growth > 0.5) == grows
    assert least_stable_swing(soft) == (pytest.approx(growth, rel=0.02), pytest.approx(frequency, rel=0.01))
    assert soft.sizes["mode"] > rigid.sizes["mode"] + 20
    assert float(soft.frequency.max()) > 170.0


def test_what_has_no_steady_sliding_is_refused():
    with pytest.raises(ValueError, match=r"speed must be positive and finite, got 0\.0"):
        sliding_modes(Case.translation(), 0.0)
    with pytest.raises(ValueError, match=r"contact\.model must be 'pair', got 'spheres'"):
        steady_sliding(Case.translation().with_(contact=SphereContact.oil_sand()), SPEED)
    with pytest.raises(ValueError, match=r"drive\.turn_rate must be none"):
        steady_sliding(Case.turning(), SPEED)
    with pytest.raises(ValueError, match=r"terrain\.tilt must be 'pitch'"):
        steady_sliding(Case.translation(), SPEED)


@pytest.fixture(scope="module")
def rubbed():
    """The papers' track with constant friction, and its modes."""
    case = study.with_friction(plain(Case.translation()), 0.3, 0.3)
    return case, sliding_modes(case, SPEED)


def test_the_table_names_the_least_stable_modes_first(rubbed):
    modes = rubbed[1]
    table = study.mode_table(modes, 4)
    assert list(table["mode"]) == [1, 2, 3, 4]
    assert table["growth rate, 1/s"].is_monotonic_decreasing
    first = modes["shape"].sel(mode=1)
    assert table["z"][0] == pytest.approx(float(np.abs(first.sel(coordinate="z")).max()))
    assert table["roll"][0] == pytest.approx(0.0, abs=1e-6)
    assert np.abs(first.sel(coordinate="z", shoe=table["shoe"][0])) == pytest.approx(table["z"][0])


def test_shoes_stay_joined_in_the_figure(rubbed):
    """Pins of neighbours meet to first order: to the square of the drawn pitch."""
    case, modes = rubbed
    ax = study.mode_figure(modes, case, (1,)).axes[0]
    pins = [line.get_xydata() for line in ax.lines if line.get_marker() == "o"]
    assert len(pins) == 2 * case.track.shoe_count
    for rear, front in pairwise(pins[: case.track.shoe_count]):
        # two arms of 0.35 m, tilted by a motion of 0.1 m at the end of 0.315 m
        assert np.abs(rear[0] - front[1]).max() < 2 * 0.35 * 0.5 * (0.1 / 0.315) ** 2
    still = [line.get_xydata() for line in ax.lines if line.get_color() == "0.75"]
    assert len(still) == case.track.shoe_count
    assert "growth rate +" in ax.get_title(loc="left")


def test_the_page_prints_what_a_table_of_the_study_has():
    """Docs: damping ends the bounce between 3 and 10 times that of the papers."""
    row = study.growth_over("damping factor", [10]).iloc[0]
    printed = {"even": "-0.12 at 10.6", "7 m units": "-0.08 at 10.6", "1 m units": "-2.32 at 11.1"}
    assert {name: row[name][: len(text)] for name, text in printed.items()} == printed


def test_a_track_flutters_beyond_a_threshold_of_unevenness():
    table = flutter([0.0, 0.17, 0.25]).set_index("unevenness")
    assert table.growth[0.0] < 0.0
    assert 0.1 < table.growth[0.17] < 1.0
    assert table.growth[0.25] > 2.0
    # two swings of a shoe on the ground meet: heave at 53 rad/s and roll at 41 rad/s, alone
    assert 41.0 < 2.0 * 3.14159 * table.frequency[0.25] < 53.0
    # 12 d e / W**2 by closed form for small rolls, beside what the unit rolls the other way
    assert table.roll[0.25] + table.roll[0.0] == pytest.approx(12.0 * 0.0657 * 0.25 / 3.505**2, rel=0.1)
