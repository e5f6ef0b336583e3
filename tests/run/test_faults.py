"""Failed steps and searches name what they hang on."""

import signal

import numpy as np
import pytest

from exudyn_crawler import Case, LoadCycle, simulate
from exudyn_crawler.errors import EquilibriumError, SimulationStopped
from exudyn_crawler.ground.contact import PairGroundContact
from exudyn_crawler.model import newton
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.engine import exu
from exudyn_crawler.model.exudyn.system import ExudynSystem
from exudyn_crawler.model.track_system import NewtonError
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.run.solve.simulation import integrate

pytestmark = pytest.mark.simulation

LEAST = 1e-3
"""s, least step of Exudyn's items."""


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
    ("coordinate", "name"),
    [
        (6 * 6 + 2, r"shoe 7 \(z\)"),
        (6 * 3 + 4, r"shoe 4 \(rotation about y\)"),
        (slice(6 * 13, None), r"terrain \(coordinate \d+\)"),
    ],
)
def test_a_failed_step_names_the_coordinate_that_does_not_settle(rest, coordinate, name, monkeypatch):
    with pytest.raises(SimulationStopped, match=f"least step {LEAST:g} s; greatest residual at {name}$"):
        integrate(pushed(rest, coordinate, 1e9, monkeypatch), 0.1)


def test_forces_that_are_no_numbers_are_told(rest, monkeypatch):
    with pytest.raises(SimulationStopped, match=r"; the residual is not finite$"):
        integrate(pushed(rest, 2, np.nan, monkeypatch), 0.1)


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
    case = Case.translation()
    system = compiled_system(case)
    assert system.layout.coordinate_count == 93

    def failing(_system, _state, _multipliers, _inputs, _weights, _limits, scratch):
        scratch[0][:] = 1.0
        scratch[0][equation] = 1e13
        return False, 40, 3, 1e9

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
