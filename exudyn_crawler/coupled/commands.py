"""Speeds and torques of the drive of a track that a user's model commands."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from exudyn_crawler.model.compiled_system import CompiledSystem
from exudyn_crawler.model.inputs import Inputs

SPEEDS, TORQUES = "speeds", "torques"
"""Names of stored commands."""
FAR = 1e6
"""Lag of a motor with a commanded torque, in lags at which a motor has 0.7 of its greatest torque."""


class Commands:
    """Commanded speeds or torques of tracks, the right one first; without a command the case's drive acts."""

    def __init__(self, system: CompiledSystem) -> None:
        self._system = system
        self._limits = system.tables.joints.motors.limit.copy()
        self._speeds = np.zeros(0)
        self._torques = np.zeros(0)

    def speeds(self, speeds: ArrayLike) -> None:
        """Command the speed of each track over the ground, m/s: (tracks,)."""
        self._speeds, self._torques = self._checked("speeds", speeds), np.zeros(0)
        self._system.tables.joints.motors.limit[:] = self._limits

    def torques(self, torques: ArrayLike) -> None:
        """Command the torque of each tumbler's motor, N m, positive to drive forward: (tracks,)."""
        case = self._system.case
        if not case.gear.tumblers:
            raise ValueError(
                f"a track with gear.kind {case.gear.kind!r} has no motors whose torque can be set"
            )
        self._torques, self._speeds = self._checked("torques", torques), np.zeros(0)
        limit = self._system.tables.joints.motors.limit
        limit[:] = self._limits
        limit[: len(self._torques)] = np.abs(self._torques)

    def _checked(self, name: str, values: ArrayLike) -> np.ndarray:
        count = self._system.case.gear.tracks
        command = np.array(values, dtype=float).reshape(-1)
        if len(command) != count or not np.isfinite(command).all():
            raise ValueError(
                f"{name} must be {count} finite numbers, one for each track, got {command.tolist()}"
            )
        return command

    def applied(self, inputs: Inputs) -> Inputs:
        """Return loads and drive of a case with the commanded drive."""
        case = self._system.case
        if self._torques.size:
            motors = inputs.motors.copy()
            lag = self._system.tables.joints.motors.lag[: len(self._torques)]
            motors[: len(self._torques)] = np.sign(self._torques) * FAR * lag
            return inputs._replace(motors=motors)
        if not self._speeds.size:
            return inputs
        if inputs.motors.size:
            return inputs._replace(motors=case.gear.motors(self._speeds, case.track))
        return inputs._replace(speeds=np.array([self._speeds[0], inputs.speeds[1]]))

    def stored(self) -> dict[str, np.ndarray]:
        """Return the commands as arrays by name, empty without a command."""
        return {SPEEDS: self._speeds.copy(), TORQUES: self._torques.copy()}

    def restore(self, stored: Mapping[str, np.ndarray]) -> None:
        """Set stored commands."""
        self._speeds = self._torques = np.zeros(0)
        self._system.tables.joints.motors.limit[:] = self._limits
        if len(stored[SPEEDS]):
            self.speeds(stored[SPEEDS])
        if len(stored[TORQUES]):
            self.torques(stored[TORQUES])
