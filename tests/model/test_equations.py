"""Compiled equations: against those of Exudyn's items and their own derivatives, references, compiling."""

import itertools
import json
import os
import subprocess
import sys
from functools import cache

import numpy as np
import pytest
import scipy.linalg

from exudyn_crawler import Case, FlexibleShoes, PairContact, Terrain, simulate
from exudyn_crawler.ground.cells.laws.bekker import BekkerSoil
from exudyn_crawler.ground.rows import Weights
from exudyn_crawler.model.compiled_system import compiled_system
from exudyn_crawler.model.compiling import calls_of
from exudyn_crawler.model.newton import Limits
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from tests.model.both import by_engine, compiled, gaps_of, matrix_errors, random_state, residual_of
from tests.rolled import small_flexible_case
from tests.small_shoe import SMALL_SHOE

pytestmark = pytest.mark.simulation

FLEXIBLE = Case.stress(SMALL_SHOE).with_(
    flexible=FlexibleShoes.ph4100c(SMALL_SHOE).with_(shoes=(6, 7, 13), highest_frequency=1000.0)
)
CASES = {
    "straight": Case.translation(),
    "turning": Case.turning(),
    "uneven": Case.turning("uneven"),
    "flexible": FLEXIBLE,
    "flexible, leaning": FLEXIBLE.with_(terrain=Terrain.kinematics(), contact=PairContact.adams()),
}


@cache
def rested(name):
    return static_equilibrium(CASES[name])


@cache
def both_at(name, is_bent):
    """Both formulations' equations at a random state, and that state; unbent shoes are about to be bent."""
    case = CASES[name]
    q, q_t = random_state(case, rested(name), seed=11)
    layout = compiled_system(case).layout
    if not is_bent:
        q[len(q) - len(layout.flexible_shoes) * layout.modes :] = 0.0
    return case, q, q_t, by_engine(case, q, q_t), compiled(case, q, q_t)


@pytest.fixture(params=CASES)
def both(request):
    return both_at(request.param, is_bent=True)


@pytest.fixture(params=CASES)
def unbent(request):
    """The same where no flexible shoe is bent."""
    return both_at(request.param, is_bent=CASES[request.param].flexible is None)


def test_mass_matrices_forces_and_gaps_agree(both):
    *_, engine, own = both
    for name in ("mass", "forces"):
        expected = getattr(engine, name)
        most = 1e-9 * np.abs(expected).max()
        np.testing.assert_allclose(getattr(own, name), expected, rtol=0.0, atol=most, err_msg=name)
    np.testing.assert_allclose(own.gaps, engine.gaps, rtol=0.0, atol=1e-12)


def test_directions_of_the_constraints_agree(unbent):
    *_, engine, own = unbent
    np.testing.assert_allclose(own.directions, engine.directions, rtol=0.0, atol=1e-9)


def test_directions_are_the_gradients_of_the_gaps(both):
    case, q, q_t, _, own = both
    system = compiled_system(case)

    def gaps(q):
        residual_of(system, q, q_t)
        return gaps_of(system)[: system.pin_rows]

    changes = 1e-6 * np.eye(len(q))
    gradients = np.array([(gaps(q + change) - gaps(q - change)) / 2e-6 for change in changes])
    np.testing.assert_allclose(own.directions[:, : system.pin_rows], gradients, rtol=0.0, atol=1e-8)


def test_exudyns_directions_are_not_where_a_pins_lug_has_turned():
    """The forces of a joint on a bent body turn with the wrong tangent: by as much as the lug has turned."""
    *_, engine, own = both_at("flexible", is_bent=True)
    assert np.abs(own.directions - engine.directions).max() > 1e-7


def test_accelerations_agree(unbent):
    """Of both systems with their constraints."""
    *_, engine, own = unbent
    found = []
    for equations in (engine, own):
        # what the constraints' own turning asks for is the same for both: leave it out
        n, rows = equations.directions.shape
        scaled = 1e4 * equations.directions
        matrix = np.block([[equations.mass, scaled], [scaled.T, np.zeros((rows, rows))]])
        right = np.concatenate((equations.forces, np.zeros(rows)))
        found.append(scipy.linalg.solve(matrix, right)[:n])
    np.testing.assert_allclose(found[1], found[0], rtol=0.0, atol=1e-9 * np.abs(found[0]).max())


# of the last case joint forces differ by 0.2 N, 5e-6 of the greatest, in the first steps: each formulation
# finds its own rest of bent shoes, to 1e-3 N
@pytest.mark.parametrize("name", list(CASES)[:-1])
def test_a_short_run_is_the_same_in_both_formulations(name):
    case = CASES[name]
    runs = [
        simulate(case.with_(formulation=one, solver=case.solver.with_(residual=1e-3)), 0.1, progress=False)
        for one in ("compiled", "engine")
    ]
    for variable in ("position", "angles", "joint_force", "drive_force", "unit_heave"):
        own, engine = (run.dataset[variable].values for run in runs)
        scale = np.abs(engine).max()
        np.testing.assert_allclose(own, engine, rtol=0.0, atol=1e-6 * scale, err_msg=variable)


@pytest.mark.parametrize("name", CASES)
def test_newtons_matrix_is_the_derivative_of_the_residual(name):
    """At rest and with light loads, where what it leaves out (turning forces, moving outlines) is small."""
    case, q = CASES[name], rested(name)
    q_t = np.zeros(len(q))
    q_t[: 6 * case.track.shoe_count : 6] = 0.02
    assert matrix_errors(compiled_system(case), q, q_t).max() < 0.02


def arrays_of(values):
    """All arrays of a tuple and the tuples in it."""
    if isinstance(values, np.ndarray):
        return [values]
    return [one for value in values for one in arrays_of(value)] if isinstance(values, tuple) else []


@pytest.mark.parametrize(
    "case",
    [
        FLEXIBLE,
        pytest.param(small_flexible_case(), marks=pytest.mark.slow),
        pytest.param(small_flexible_case().on_cells(BekkerSoil.lete_sand()), marks=pytest.mark.slow),
        Case.closed(),
    ],
    ids=["dragged", "rolled", "rolled on cells", "closed"],
)
def test_compiled_code_gives_back_every_reference_to_an_array(case):
    system = compiled_system(case)
    cells = system.cells
    state = np.zeros((3, system.layout.coordinate_count))
    state[0] = system.first_guess()
    multipliers = np.zeros(system.tables.multipliers)
    arrays = [*arrays_of(system.tables), *arrays_of(system.work), state, multipliers, *system.scratch]

    def step():
        # whether it converges does not matter
        weights = Weights(1.0, 1e3, 1e5, False, 1e-3)
        system.step(state, multipliers, system.inputs(0.0), weights, Limits(1e-2, 3, False))
        for function, arguments in itertools.chain.from_iterable(calls_of(system).values()):
            function(*arguments)
        if cells is not None:
            cells.commit()

    step()
    before = [sys.getrefcount(one) for one in arrays]
    for _ in range(3):
        step()
    assert [sys.getrefcount(one) for one in arrays] == before


SCRIPT = """
import json
from exudyn_crawler import Case, FlexibleShoes, simulate
from exudyn_crawler.model.equations import matrix, residual
from exudyn_crawler.model.newton import step

few = FlexibleShoes.ph4100c("coarse").with_(shoes=(12, 13), fixed_modes=2, recovered_modes=2)
simulate(Case.turning(), 0.002, progress=False)
simulate(Case.stress("coarse").with_(flexible=few), 0.002, progress=False)
stats = [one.stats for one in (residual, matrix, step)]
print(json.dumps([[sum(one.cache_hits.values()), sum(one.cache_misses.values())] for one in stats]))
"""


@pytest.mark.slow
def test_the_matrix_is_compiled_beside_the_residual_and_once_for_all_tracks(tmp_path):
    """By another process, where no disk keeps the equations yet."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", SCRIPT]
    for hits_and_misses in ([0, 1], [1, 0]):
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        residual, matrix, step = json.loads(done.stdout.splitlines()[-1])
        assert (residual, step, matrix[1]) == (hits_and_misses, hits_and_misses, 0)
