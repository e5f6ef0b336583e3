"""Rest of a machine under the weight of a user's model, and the part of its frame that is an Exudyn body."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from exudyn_crawler.case import Case, Machine, Part
from exudyn_crawler.case.gear.base import SIDE_FRAME
from exudyn_crawler.case.gear.running_gear import RunningGear
from exudyn_crawler.case.parameters.base import inertia_tensor
from exudyn_crawler.model.assemble import assemble
from exudyn_crawler.model.bodies import second_moment
from exudyn_crawler.model.compiled_system import CompiledSystem
from exudyn_crawler.run.solve import simulation

SHARE = 0.01
"""Part of the car body's mass that its Exudyn body has. Each side needs an inertia of its own; the less the
body has, the more are the forces between both sides those of the user's model."""

TENSOR = (0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)
"""Places of a case's components of inertia in the tensor."""


class Mass(NamedTuple):
    """Integrals over a mass in the axes of the car body."""

    mass: float  # kg
    first: np.ndarray  # (3,), kg m
    second: np.ndarray  # (3, 3): of x_a x_b, kg m2

    @classmethod
    def of(cls, parts: list[Part]) -> "Mass":
        """Return the integrals over parts."""
        return cls(
            sum(part.mass for part in parts),
            np.sum([part.mass * part.com for part in parts], axis=0),
            np.sum([second_moment(part.mass, part.inertia, part.com) for part in parts], axis=0),
        )

    def times(self, factor: float) -> "Mass":
        """Return the integrals over a fraction of the mass."""
        return Mass(factor * self.mass, factor * self.first, factor * self.second)

    @property
    def inertia(self) -> np.ndarray:
        """Inertia tensor about the car body's origin, kg m2: array (3, 3)."""
        return np.asarray(np.trace(self.second) * np.eye(3) - self.second)


class Rest(NamedTuple):
    """Machine at rest under the weight of a user's model, without that model."""

    system: CompiledSystem
    frame: int  # number of the car body among its bodies
    car_body: Mass  # mass of the car body
    wrench: np.ndarray  # (6,): weight of all but the frame of the system, about the origin, N and N m


def rest_under(case: Case, mass: float, com: np.ndarray, replaces_upper: bool) -> Rest:
    """Return the rest of a case's machine under an added mass (kg) with a COM (3,), m, in its axes.

    The mass takes the place of the upper structure if `replaces_upper`. ParameterError if the machine cannot
    carry it; ValueError if it has no upper structure to replace; EquilibriumError without a rest.
    """
    gear = case.part(RunningGear)
    if replaces_upper and not isinstance(gear, Machine):
        raise ValueError(
            f"replaces_upper must be False with gear.kind {gear.kind!r}, which has no upper structure"
        )
    changes = _loaded(case, mass, com, replaces_upper)
    rest = _rest_of(case.with_(changes))
    case = rest.case.with_({path: _value(case, path) for path in changes})
    parts = gear.frame_parts[:-1] if replaces_upper else gear.frame_parts
    car_body = Mass.of(parts)
    assembly = assemble(case)
    frame = case.track.shoe_count + assembly.bodies.index(SIDE_FRAME)
    table = assembly.tables.bodies
    table.mass[frame], table.first[frame], table.second[frame] = car_body.times(1.0 - SHARE)
    system = CompiledSystem(case, assembly)
    row = np.zeros(system.layout.size)
    system.layout.part(row, "coordinates")[:] = rest.q
    system.layout.part(row, "coordinates rate")[:] = rest.q_t
    system.set_state(row, {name: values.copy() for name, values in rest.memory.items()})
    gravity = case.gravity_vector()
    weight = (SHARE * car_body.mass + mass) * gravity
    moment = np.cross(SHARE * car_body.first + mass * com, gravity)
    return Rest(system, frame, car_body, np.concatenate((weight, moment)))


class _CaseRest(NamedTuple):
    """Rest of a case."""

    case: Case  # with the take-up for its chains' tension
    q: np.ndarray  # coordinates
    q_t: np.ndarray  # their rates
    memory: dict[str, np.ndarray]  # of the ground


@lru_cache(maxsize=8)
def _rest_of(case: Case) -> _CaseRest:
    """Return the rest of a case; equal machines of a model, or of several ones, have the same."""
    system = simulation.started(case, progress=False)
    assert isinstance(system, CompiledSystem)  # of a case with rollers
    q, q_t, _ = system.motion
    return _CaseRest(system.case, q, q_t, system.memory())


def _loaded(case: Case, mass: float, com: np.ndarray, replaces_upper: bool) -> dict[str, Any]:
    """Return the changes of a case, by path, that add the mass of a user's model to its machine."""
    gear = case.part(RunningGear)
    if isinstance(gear, Machine) and replaces_upper:
        body = "gear.car_body"
        return {
            f"{body}.upper_mass": mass,
            f"{body}.upper_com": tuple(com.tolist()),
            f"{body}.slew": 0.0,
        }
    if mass == 0.0:
        return {}
    part = gear.car_body if isinstance(gear, Machine) else gear
    path = "gear.car_body" if isinstance(gear, Machine) else "gear"
    frame = Part(part.mass, np.array(part.com), inertia_tensor(part.inertia))
    whole = Mass.of([frame, Part(mass, com, np.zeros((3, 3)))])
    center = whole.first / whole.mass
    about = Mass(whole.mass, whole.first, whole.second - whole.mass * np.outer(center, center)).inertia
    return {
        f"{path}.mass": whole.mass,
        f"{path}.com": tuple(center.tolist()),
        f"{path}.inertia": tuple(about[place].item() for place in TENSOR),
    }


def _value(case: Case, path: str) -> Any:
    """Return the value of a case at a path."""
    value: Any = case
    for name in path.split("."):
        value = getattr(value, name)
    return value
