"""Forces of wheels and teeth on the shoes, at the states of a history."""

from typing import NamedTuple

import numpy as np

from exudyn_crawler.ground.compiled import inner, kernel
from exudyn_crawler.ground.packed import FloatArray, IntArray
from exudyn_crawler.ground.rows import NO_DERIVATIVES
from exudyn_crawler.model.bodies import write_angles
from exudyn_crawler.model.forces import teeth, wheels
from exudyn_crawler.model.joints import play
from exudyn_crawler.model.tables import Workspace, read_system


class GearForces(NamedTuple):
    """Forces at t times, global, on all n shoes and, one by one, on f of them."""

    wheel: FloatArray  # (t, n, 6): force (N) and moment about the COM (N m) of all wheels
    tooth: FloatArray  # (t, n, 6): of the teeth
    guide: FloatArray  # (t, n): part of both across the track, N
    on_wheels: FloatArray  # (t, wheels, 3): of all shoes on every wheel, N
    energy: FloatArray  # (t, 3): in the contacts of wheels, of teeth and of pins with play, J
    strip_wheel: IntArray  # (t, f, slots): as in `forces.wheels.WheelWorkspace`, as are all strips
    strip_force: FloatArray  # (t, f, slots, strips, 3)
    strip_foot: FloatArray  # (t, f, slots, strips, 3)
    strip_guide: FloatArray  # (t, f, slots, strips)
    lug_force: FloatArray  # (t, f, lugs, 3): as in `forces.teeth.TeethWorkspace`, as are all lugs
    lug_guide: FloatArray  # (t, f, lugs)

    @classmethod
    def allocate(cls, times: int, shoes: int, some: int, work: Workspace) -> "GearForces":
        """Return arrays of zeros for a workspace, with `some` shoes one by one."""
        of_wheels = work.forces.wheels
        lugs = len(work.forces.teeth.guide) // shoes
        return cls(
            wheel=np.zeros((times, shoes, 6)),
            tooth=np.zeros((times, shoes, 6)),
            guide=np.zeros((times, shoes)),
            on_wheels=np.zeros((times, *of_wheels.on_wheels.shape)),
            energy=np.zeros((times, 3)),
            strip_wheel=np.zeros((times, some, *of_wheels.wheel.shape[1:]), dtype=np.int64),
            strip_force=np.zeros((times, some, *of_wheels.force.shape[1:])),
            strip_foot=np.zeros((times, some, *of_wheels.foot.shape[1:])),
            strip_guide=np.zeros((times, some, *of_wheels.guide.shape[1:])),
            lug_force=np.zeros((times, some, lugs, 3)),
            lug_guide=np.zeros((times, some, lugs)),
        )


@inner
def _copy(values: FloatArray, out: FloatArray) -> None:
    for k in range(out.shape[0]):
        out[k] = values[k]


@kernel
def write_gear_forces(
    system: IntArray,
    coordinates: FloatArray,
    rates: FloatArray,
    some: IntArray,
    forces: GearForces,
) -> None:
    """Write `GearForces` at coordinates and rates (times, coordinates).

    `system` is a block of `tables.System`; `some` (f,) are the numbers of the shoes whose forces are wanted
    one by one.
    """
    tables = read_system(system).tables
    work = read_system(system).work
    bodies = tables.bodies
    weights = NO_DERIVATIVES
    of_wheels = work.forces.wheels
    of_teeth = work.forces.teeth
    state = np.empty((2, coordinates.shape[1]))
    shoes = forces.guide.shape[1]
    lugs = forces.lug_guide.shape[2]
    for t in range(coordinates.shape[0]):
        _copy(coordinates[t], state[0])
        _copy(rates[t], state[1])
        write_angles(bodies, state[0])
        teeth.write_rows(tables.forces.teeth, bodies, tables.markers, state, weights, of_teeth)
        wheels.write_rows(tables.forces.wheels, bodies, state, 1.0, weights, of_wheels)
        _copy(of_wheels.on_shoes.reshape(-1), forces.wheel[t].reshape(-1))
        _copy(of_wheels.on_wheels.reshape(-1), forces.on_wheels[t].reshape(-1))
        forces.energy[t, 0] = of_wheels.energy[0]
        forces.energy[t, 1] = of_teeth.energy[0]
        forces.energy[t, 2] = play.stored_energy(
            tables.joints.plays, bodies, tables.markers, state, work.joints.scratch
        )
        for s in range(shoes):
            forces.guide[t, s] = np.sum(of_wheels.guide[s]) + np.sum(
                of_teeth.guide[s * lugs : (s + 1) * lugs]
            )
            for lug in range(s * lugs, (s + 1) * lugs):
                for c in range(3):
                    forces.tooth[t, s, c] += of_teeth.force[lug, c]
                    forces.tooth[t, s, 3 + c] += of_teeth.moment[lug, c]
        for k in range(some.shape[0]):
            s = some[k]
            _copy(of_wheels.wheel[s], forces.strip_wheel[t, k])
            _copy(of_wheels.force[s].reshape(-1), forces.strip_force[t, k].reshape(-1))
            _copy(of_wheels.foot[s].reshape(-1), forces.strip_foot[t, k].reshape(-1))
            _copy(of_wheels.guide[s].reshape(-1), forces.strip_guide[t, k].reshape(-1))
            _copy(of_teeth.force[s * lugs : (s + 1) * lugs].reshape(-1), forces.lug_force[t, k].reshape(-1))
            _copy(of_teeth.guide[s * lugs : (s + 1) * lugs], forces.lug_guide[t, k])
