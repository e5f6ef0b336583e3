"""Loads and drive of a case at every time: the external inputs of a system."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from exudyn_crawler.case import Case, StepProfile
from exudyn_crawler.ground.frames import Vector
from exudyn_crawler.ground.packed import FloatArray
from exudyn_crawler.model.forces.loads import profiles_of, values_at

NOTHING = StepProfile.constant(0.0)


class Inputs(NamedTuple):
    """Loads and drive at a time."""

    gravity: Vector  # m/s2, global
    loads: FloatArray  # (loads, 6): forces (N) and moments (N m), global
    shift: float  # how far those that shift act to the left of their places, m
    active: FloatArray  # (2,): 1 where drive and turn act, else 0
    speeds: FloatArray  # (2,): of drive and turn, m/s and rad/s
    resists: float = 1.0  # part of their resistance that wheels have; none as a rest is looked for
    motors: FloatArray = np.zeros(0)  # (motors,): speeds of the tumblers against their frames, rad/s


class TimedInputs:
    """Loads and drive of a case over time, with `loads` loads.

    `commands` is a function of the time (s). It gives a speed (m/s), a rate of turning (rad/s) and a wrench
    (6,) on the side frame, which replace those of the case; with None those of the case act.
    """

    def __init__(self, case: Case, loads: int) -> None:
        self._case = case
        self._load_count = loads
        machine = [NOTHING] * 6 if case.machine is None else case.machine.components
        turn = case.drive.turn_rate or NOTHING
        slip = case.drive.slip or NOTHING
        profiles = [*case.loads.of_shoes, case.drive.speed, turn, case.loads.side_shift, slip, *machine]
        self._profiles = profiles_of(profiles)
        self._middles = case.gear.middles
        self._still = case.gear.motors(self._speeds_of_tracks(np.zeros(2)), case.track)
        turned = case.drive.turn_rate is not None
        drawn = case.drive.slip is not None
        self._active = {
            driven: case.gear.active(driven, driven and turned, drawn) for driven in (False, True)
        }
        self._gravity = tuple(case.gravity_vector().tolist())
        self._down = case.terrain.down
        self.commands: Callable[[float], tuple[np.ndarray, np.ndarray]] | None = None

    def at(self, time: float, driven: bool) -> Inputs:
        """Return loads and drive at a time (s); a track that is not `driven` has no drive."""
        case = self._case
        count = self._case.track.shoe_count
        shoes, speeds, machine = self._applied(time)
        loads = np.zeros((self._load_count, 6))
        loads[:count, :3] = shoes[:, None] * self._down
        loads[count:] = case.gear.wrenches(machine)
        motors = self._still
        if motors.size:
            motors = case.gear.motors(self._speeds_of_tracks(speeds), case.track)
        # a drawbar lets the frame go slower than its tracks
        speeds[0] *= 1.0 - speeds[3]
        return Inputs(self._gravity, loads, float(speeds[2]), self._active[driven], speeds[:2], 1.0, motors)

    def _applied(self, time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the applied values at a time (s).

        They are the loads of shoes; speed, rate of turning, side shift and slip; and the wrench on the frame.
        """
        count = self._case.track.shoe_count
        values = np.zeros(count + 10)
        values_at(self._profiles, time, values)
        speeds = values[count : count + 4]
        machine = values[count + 4 :]
        if self.commands is not None:
            speeds[:2], machine = self.commands(time)
        return values[:count], speeds, machine

    def _speeds_of_tracks(self, speeds: np.ndarray) -> np.ndarray:
        """Return speeds of tracks (..., tracks), m/s: a turn makes the right one faster than the left one."""
        return speeds[..., :1] - speeds[..., 1:2] * self._middles
