"""Short runs: the drive is exact, mechanics holds, stops are kept, and failures name what they hang on."""

import gc
import itertools
import pkgutil
import signal
import sys
import time as clock
import weakref

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from exudyn_crawler import Case, LoadCycle, simulate
from exudyn_crawler.engine.system import ExudynSystem
from exudyn_crawler.errors import EquilibriumError, SimulationStopped
from exudyn_crawler.ground.contact import PairGroundContact
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model import newton
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.diagnostics import NewtonError
from exudyn_crawler.model.exudyn import exu
from exudyn_crawler.results.balance import shoe_imbalance, track_imbalance
from exudyn_crawler.run.solve import simulation, stages
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.run.solve.simulation import integrate
from studies.grounds import plain
from tests.rolled import small_case

pytestmark = pytest.mark.simulation

WEIGHT = 13 * 432.3e3  # N, of the loaded track
LEAST = 1e-3
"""s, least step of Exudyn's items."""


@pytest.fixture(params=["translation", "turning", "constrained"])
def run(request):
    return request.getfixturevalue(request.param)


def test_the_front_shoe_follows_the_drive(run):
    t = run.time.values
    front = {name: run.dataset[name].sel(shoe=13, axis="x").values for name in ("position", "velocity")}
    assert front["velocity"] == pytest.approx(0.012 * t**2 - 0.0016 * t**3, abs=1e-9)
    # the drive holds on velocity level; its integral may drift by the integration's error
    assert front["position"] - front["position"][0] == pytest.approx(0.004 * t**3 - 0.0004 * t**4, abs=1e-8)


def test_the_front_shoe_accelerates_as_the_drive(longer):
    t = longer.time.values[50:]
    given = longer.acceleration.sel(shoe=13, axis="x").values[50:]
    assert given == pytest.approx(0.024 * t - 0.0048 * t**2, abs=3e-4)  # 1 % of the greatest, 0.03


def test_the_front_shoe_turns_at_the_prescribed_rate_about_its_own_axis(turning):
    front = turning.dataset.sel(shoe=13)
    axis = rotation_matrices(front.angles.values)[..., 2]
    rate = np.degrees(np.sum(axis * front.angular_velocity.values, axis=-1))
    t = turning.time.values
    assert rate == pytest.approx(0.12 * t**2 - 0.016 * t**3, abs=1e-8)
    assert rate[-1] > 0.01


def test_without_a_turn_nothing_turns_the_front_shoe(translation):
    assert not translation.drive_torque.values.any()
    even = simulate(plain(translation.case), translation.duration)
    assert not even.drive_torque.values.any()
    assert np.abs(even.angular_velocity.sel(axis="z")).max() < 1e-6


def test_numbers_do_not_depend_on_how_many_threads_there_are():
    """The terrain's 32 coordinates are enough for threads to share their products."""
    case = Case.stress("coarse").with_(flexible=None)
    ends = []
    for threads in (1, 2):
        with threadpool_limits(threads, user_api="blas"):
            ends.append(simulate(case, 0.01, progress=False).dataset.isel(time=-1))
    assert ends[0].identical(ends[1])


def test_the_track_as_a_whole_and_every_shoe_with_its_joints_obey_newton_and_euler(run):
    whole, single = track_imbalance(run, about=(14.0, 9.29, 0.0)), shoe_imbalance(run)
    for off, arm in ((whole, 4.0), (single, 1.0)):  # m; 4 is half the track's length
        assert np.abs(off.force).max() < 1e-6 * WEIGHT
        assert np.abs(off.moment).max() < 1e-6 * WEIGHT * arm


def test_the_balance_would_notice_one_missing_force(translation):
    less = translation.dataset.assign(joint_force=translation.joint_force * (1.0 + 1e-3))
    history = type(translation)(case=translation.case, dataset=less)
    assert np.abs(shoe_imbalance(history).force).max() > 1e-6 * WEIGHT


def test_pins_stay_together_and_their_axes_parallel(run):
    frames = rotation_matrices(run.angles.values)
    pins = [run.position.values + frames @ pin for pin in (run.case.track.front_pin, run.case.track.rear_pin)]
    assert pins[0][:, :-1] == pytest.approx(pins[1][:, 1:], abs=1e-7)  # m, links of 0.6 m
    axis = frames[..., 1]
    assert np.abs(np.cross(axis[:, :-1], axis[:, 1:])).max() < 1e-7


def test_every_variable_of_a_history_is_an_attribute(translation):
    for name, values in translation.dataset.variables.items():
        assert getattr(translation, name).shape == values.shape
        assert name in translation.dataset.coords or values.attrs["units"]


@pytest.mark.parametrize("progress", [None, False])
def test_a_run_that_compiles_says_so(monkeypatch, capsys, progress):
    monkeypatch.setattr("exudyn_crawler.run.folder.progress.LINE_EVERY", 0.05)
    monkeypatch.setattr(simulation.compiling, "compile_equations", lambda: clock.sleep(0.3))
    monkeypatch.setattr(simulation, "integrate", lambda *_, **__: None)
    simulate(Case.translation(), 0.01, progress)
    told = set(capsys.readouterr().err.splitlines())
    line = "translation: compile the equations: 0 s so far, 0 of about 50 s of processor time"
    assert told == (set() if progress is False else {line})


@pytest.mark.parametrize(
    ("output", "checkpoint", "expected"),
    [(0.01, 10.0, [0.0, 0.01, 0.02, 0.03, 0.04, 0.05]), (0.5, 0.02, [0.0, 0.04, 0.06, 0.08, 0.1])],
)
def test_states_are_stored_at_the_output_interval_and_of_every_stage_however_seldom_that_is(
    output, checkpoint, expected
):
    intervals = {"solver.output_interval": output, "solver.checkpoint_interval": checkpoint}
    times = simulate(Case.translation().with_(intervals), expected[-1]).time.values
    assert times == pytest.approx(expected, abs=1e-12)


def test_a_step_that_fails_stops_the_run_and_keeps_what_there_is():
    # two iterations that may not cut the step: enough while the track creeps, not when it slips
    impatient = Case.translation().with_({"solver.maximum_iterations": 2, "solver.minimum_step": 1.5e-3})
    failed = r"stopped at t = .* s: Newton's method failed at the least step 0\.0015 s; "
    with pytest.raises(SimulationStopped, match=failed + r"greatest residual at shoe \d+ \(.*\)$") as stop:
        simulate(impatient, 3.0)
    kept = stop.value.history
    assert 0.0 <= stop.value.time < 3.0
    assert kept.duration == pytest.approx(stop.value.time, abs=1e-12)
    assert np.isfinite(kept.position.values).all()


@pytest.fixture(params=[signal.SIGINT, signal.SIGTERM] if sys.platform != "win32" else [signal.SIGINT])
def interrupt(request):
    """Signal that raises KeyboardInterrupt within the test."""
    before = signal.signal(request.param, signal.default_int_handler)
    yield request.param
    signal.signal(request.param, before)


def calls_then_signal(monkeypatch, place, number):
    """Let a function of the program be interrupted within its 10th call."""
    calls, function = [], pkgutil.resolve_name(place)

    def called(*arguments):
        calls.append(1)
        if len(calls) == 10:
            signal.raise_signal(number)
        return function(*arguments)

    monkeypatch.setattr(place.replace(":", "."), called)


@pytest.mark.parametrize(
    ("changes", "place", "least", "most"),
    [
        ({}, "model.compiled_system:predict", 0.011, 0.03),
        ({}, "model.newton:step", 0.011, 0.03),
        ({}, "run.solve.stages:Recorder.store", 0.011, 0.03),
        ({"formulation": "engine"}, "run.solve.stages:Recorder.store", 0.011, 0.03),
        # between stages
        ({"solver.checkpoint_interval": 0.01}, "run.solve.stages:Recorder.end_stage", 0.1, 0.11),
    ],
)
def test_an_interrupt_ends_the_run_after_its_step_or_stage_and_keeps_the_history(
    monkeypatch, interrupt, changes, place, least, most
):
    case = Case.translation().with_(changes)
    calls_then_signal(monkeypatch, f"exudyn_crawler.{place}", interrupt)
    with pytest.raises(SimulationStopped, match="interrupted") as stop:
        simulate(case, 0.2)
    assert least <= stop.value.time < most
    assert stop.value.history.duration == pytest.approx(stop.value.time, abs=1e-12)
    assert signal.getsignal(interrupt) is signal.default_int_handler


def test_an_interrupt_that_is_ignored_ends_nothing(monkeypatch):
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    calls_then_signal(monkeypatch, "exudyn_crawler.run.solve.stages:Recorder.store", signal.SIGINT)
    try:
        assert simulate(Case.translation(), 0.05).duration == pytest.approx(0.05)
    finally:
        signal.signal(signal.SIGINT, before)


def test_progress_is_quiet_off_a_terminal_and_shows_time_and_speed_when_asked(capfd):
    simulate(Case.translation(), 0.01)
    assert capfd.readouterr() == ("", "")
    simulate(Case.translation(), 0.01, progress=True)
    shown = capfd.readouterr().err
    for words in ("translation", "0.01 of 0.01 s", "s wall per s"):
        assert words in shown


@pytest.mark.parametrize(
    ("case", "formulation"),
    [(Case.translation(), "compiled"), (Case.translation(), "engine"), (small_case(), "engine")],
)
def test_nothing_of_a_run_stays_in_memory(case, formulation, monkeypatch):
    built, build = [], simulation.formulation.track_system

    def noted(case):
        system = build(case)
        built.append(weakref.ref(system))
        return system

    monkeypatch.setattr(simulation.formulation, "track_system", noted)
    simulate(case.with_({"formulation": formulation}), 0.01, progress=False)
    gc.collect()
    assert [one() for one in built] == [None]


@pytest.fixture(scope="module")
def rest():
    return static_equilibrium(Case.translation())


def pushed(rest, coordinate, size, monkeypatch):
    """Track whose contact pushes coordinates to and fro from some time on, so that no step can settle."""
    calls, forces = 0, PairGroundContact.forces

    def pushing(contact, q, q_t):
        nonlocal calls
        calls += 1
        found = forces(contact, q, q_t)
        if calls > 250:
            found[coordinate] += size * (-1) ** calls
        return found

    monkeypatch.setattr(PairGroundContact, "forces", pushing)
    # a trial of a step that cannot settle takes long
    limits = {"solver.minimum_step": LEAST, "solver.maximum_iterations": 10}
    system = ExudynSystem(Case.translation().with_(limits))
    system.set_initial(rest)
    return system


@pytest.mark.parametrize(
    ("coordinate", "size", "said"),
    [
        (6 * 6 + 2, 1e9, r"greatest residual at shoe 7 \(z\)"),
        (6 * 3 + 4, 1e9, r"greatest residual at shoe 4 \(rotation about y\)"),
        (slice(6 * 13, None), 1e9, r"greatest residual at terrain \(coordinate \d+\)"),
        (2, np.nan, "the residual is not finite"),
    ],
)
def test_a_failed_step_names_the_coordinate_that_does_not_settle(rest, coordinate, size, said, monkeypatch):
    with pytest.raises(SimulationStopped, match=f"least step {LEAST:g} s; {said}$"):
        integrate(pushed(rest, coordinate, size, monkeypatch), 0.1)


def test_a_track_that_nothing_carries_is_singular(rest, monkeypatch):
    monkeypatch.setattr(PairGroundContact, "forces", lambda _contact, q, _q_t: np.zeros_like(q))
    system = ExudynSystem(Case.translation(), static=True)
    system.set_initial(rest)
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    with pytest.raises(NewtonError) as failed:
        system.rest(settings)
    # the springs of the units push up what no shoe holds down
    fault = failed.value.fault(system.layout)
    assert fault == "the equations are singular, greatest residual at terrain (coordinate 2)"


@pytest.mark.parametrize(
    ("equation", "name"),
    [
        (6 * 6 + 2, r"shoe 7 \(z\)"),
        (6 * 13, r"terrain \(coordinate 1\)"),
        (93 + 5 * 3 + 1, "right pin of link 4"),
        (93 + 5 * 12, "drive"),
    ],
)
def test_a_failed_step_of_the_compiled_equations_names_it_too(rest, equation, name, monkeypatch):
    system = compiled_system(Case.translation())
    assert system.layout.coordinate_count == 93

    def failing(_system, _state, _multipliers, _inputs, _weights, _limits, scratch):
        scratch[0][:] = 1.0
        scratch[0][equation] = 1e13
        return newton.Outcome(False, 40, 3, 1e9)

    monkeypatch.setattr(newton, "step", failing)
    system.set_initial(rest)
    with pytest.raises(SimulationStopped, match=f"least step 1e-06 s; greatest residual at {name}$"):
        integrate(system, 0.1)


@pytest.mark.filterwarnings("ignore::exudyn_crawler.errors.ImplausibleWarning")
def test_a_search_for_rest_names_what_does_not_come_to_rest():
    loads = LoadCycle.constant([-1e6] * 13)  # pulled up
    said = r"no static equilibrium of case 'lifted'.* failed, the equations are singular, greatest residual"
    with pytest.raises(EquilibriumError, match=said + r" at shoe \d+ \(z\)"):
        simulate(Case.translation().with_(name="lifted", loads=loads), 0.01)


@pytest.mark.usefixtures("interruptible")
def test_a_search_for_rest_is_interrupted_within_the_engine(monkeypatch):
    calls, forces = [], PairGroundContact.forces

    def pressed(contact, q, q_t):
        calls.append(q)
        if len(calls) == 3:
            signal.raise_signal(signal.SIGINT)
        return forces(contact, q, q_t)

    monkeypatch.setattr(PairGroundContact, "forces", pressed)
    with pytest.raises(KeyboardInterrupt):
        static_equilibrium(Case.translation().with_(terrain_formulation="constrained"))
    assert len(calls) > 3  # Exudyn has ended its search itself


def test_states_are_stored_at_the_asked_times_behind_a_step_that_was_halved(monkeypatch):
    """Exudyn goes on with whole steps behind half of one: all rows were half a step off."""
    calls, solve_step = [], newton.step

    def failing(*arguments):
        calls.append(1)
        found = solve_step(*arguments)
        return found._replace(converged=False) if len(calls) in (4, 9, 10) else found

    monkeypatch.setattr(newton, "step", failing)
    times = simulate(Case.translation().with_({"solver.output_interval": 4e-3}), 0.04).time.values
    assert len(calls) > 20 + 3
    assert times == pytest.approx(np.arange(0.0, 0.041, 4e-3), abs=1e-12)


@pytest.mark.parametrize("formulation", ["compiled", "engine"])
def test_states_are_stored_at_the_asked_times_where_steps_do_not_go_into_them(formulation):
    case = Case.translation().with_({"solver.output_interval": 5e-3, "formulation": formulation})
    times = simulate(case, 0.0173).time.values
    assert times == pytest.approx([0.0, 5e-3, 1e-2, 1.5e-2, 0.0173], abs=1e-12)


@pytest.mark.parametrize(
    ("stage", "step", "interval", "expected"),
    [
        ((0.0, 0.01), 2e-3, 2e-3, [2e-3, 4e-3, 6e-3, 8e-3, 1e-2]),
        # a part of a step is divided evenly, and the interval anchors at t = 0
        ((0.0, 0.01), 2e-3, 5e-3, [5e-3 / 3, 1e-2 / 3, 5e-3, 2e-2 / 3, 2.5e-2 / 3, 1e-2]),
        ((0.007, 0.012), 2e-3, 4e-3, [8e-3, 1e-2, 1.2e-2]),
        # an output next to the end of a stage would be reached by a step that is far too short
        ((0.0, 0.0040001), 2e-3, 2e-3, [2e-3, 3.00005e-3, 4.0001e-3]),
        # quiet steps are longer than the interval
        ((3.0, 3.03), 1e-2, 2e-3, [3.01, 3.02, 3.03]),
        ((0.0, 5e-4), 2e-3, 2e-3, [5e-4]),
    ],
)
def test_steps_end_at_output_times_and_are_even_between(stage, step, interval, expected):
    next_end = stages.step_ends(*stage, step, interval)
    time, ends = stage[0], []
    while time < stage[1] - 1e-12:
        time = next_end(time)
        ends.append(time)
    assert ends == pytest.approx(expected, abs=1e-12)
    # a step that was halved ends where the whole one would have
    for first, last in itertools.pairwise([stage[0], *ends]):
        assert next_end(0.5 * (first + last)) == last
