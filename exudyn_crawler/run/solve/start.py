"""Start of a run: the system at rest or in steady creep by friction, and a warning of a residual force."""

import numpy as np

from exudyn_crawler.case import Case, PairContact
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.parameters.checks import warn_of
from exudyn_crawler.errors import UnbalancedWarning
from exudyn_crawler.ground.terrain import TerrainModes
from exudyn_crawler.model.compiled_system import CompiledSystem, compiled_system
from exudyn_crawler.model.diagnostics import NewtonError, no_rest
from exudyn_crawler.model.track_system import TrackSystem
from exudyn_crawler.results.history import states
from exudyn_crawler.results.history.summary import unbalanced
from exudyn_crawler.run.solve.equilibrium import static_equilibrium
from exudyn_crawler.run.solve.rest import settle, steady

UNBALANCED = 0.01
"""Greatest residual force at the start without a warning, fraction of the weight."""


def begin(system: TrackSystem) -> np.ndarray:
    """Set a system to its rest at t = 0, or to its steady creep if friction holds it there.

    Return its coordinates and rates (2, coordinates). On cells shoes settle and stay. EquilibriumError if
    there is no rest.
    """
    q = static_equilibrium(system.case)
    try:
        motion = _start_of(system, q)
        system.set_initial(*motion)
    except NewtonError as failed:
        raise no_rest(system, failed) from failed
    return motion


def _start_of(system: TrackSystem, q: np.ndarray) -> np.ndarray:
    """Return the initial coordinates and rates (2, coordinates) of a run from a rest `q`; cells store it."""
    case = system.case
    if system.sticks:
        if isinstance(system, CompiledSystem):
            q = settle(system, q)
        else:
            twin = compiled_system(case)
            q = settle(twin, q)
            system.remember(twin.memory())
    elif _is_held_by_slip(case):
        if not isinstance(system.contact.coordinates, TerrainModes):
            return _steady_with_units(system, q)
        return steady(system if isinstance(system, CompiledSystem) else compiled_system(case), q)
    return np.stack((q, np.zeros_like(q)))


def _is_held_by_slip(case: Case) -> bool:
    """Return True if friction, which needs slip, has to hold a track on units."""
    if not isinstance(case.contact, PairContact):
        return False
    if isinstance(case.gear, Closed):
        return case.gear.support == "ground"
    return bool(case.gear.bodies) or bool(case.terrain.down[2] > -1.0)


def _steady_with_units(system: TrackSystem, q: np.ndarray) -> np.ndarray:
    """Return coordinates and rates (2, coordinates) of steady creep for units as bodies, near to a rest `q`.

    Displacements of shoes and units from rest are those in the terrain's independent coordinates.
    """
    reduced = system.case.with_(terrain_formulation="reduced")
    twin = compiled_system(reduced)
    rest = static_equilibrium(reduced)
    modes = twin.contact.coordinates
    assert isinstance(modes, TerrainModes)
    shoes = 6 * twin.layout.shoes
    motion = np.zeros((2, len(q)))
    motion[0] = q
    creep, creep_t = steady(twin, rest)
    for row, moved in zip(motion, (creep - rest, creep_t), strict=True):
        row[:shoes] += moved[:shoes]
        units = row[shoes:].reshape(-1, 6)
        by_modes = modes.motion(moved[shoes : shoes + modes.size])
        units[:, :3] += by_modes[:, :3]
        units[:, 3 + modes.tilt_axis] += by_modes[:, 3]
    return motion


def warn_unbalanced(system: TrackSystem, start: np.ndarray) -> None:
    """Warn, by an `UnbalancedWarning`, of a residual force at the start above `UNBALANCED` times the weight.

    `start` is the row of the state at t = 0, with its accelerations.
    """
    history = states.system_history(system, start[None])
    body, force = unbalanced(history)
    case = system.case
    weight = system.mass * case.gravity + case.loads.loads(0.0)[0].sum()
    if force > UNBALANCED * weight:
        line = (
            f"residual force at the start: {1e-3 * force:.4g} kN on {body}, {100.0 * force / weight:.3g} % "
            f"of the weight of {1e-3 * weight:.4g} kN; see what cannot rest there (a slope beyond friction, "
            "a machine in the air), or leave out the first instants"
        )
        warn_of([line], UnbalancedWarning)
