"""Forces of the kernels on a machine of Exudyn's items: of ground, wheels, teeth and arms.

The kernels write the rows of all force elements at a state (`model.kinds`). Their wrenches and tangents
become forces and a stiffness on Exudyn's coordinates, which are one user force of the system.
"""

import numpy as np

from exudyn_crawler.engine.euler_parameters import BodyCoordinates
from exudyn_crawler.ground.rows import NO_DERIVATIVES, ForceRows, Weights
from exudyn_crawler.model.compiled_system import CompiledSystem
from exudyn_crawler.model.newton import TANGENTS


class KernelForces:
    """Forces of all kernels at Exudyn's coordinates and their rates.

    `kernels` are the compiled equations of the same tables. Only the forces that they write are used, and the
    directions of a drive's pull on the chain (`joints.pull`): Exudyn's constraint of the frame's speed pushes
    the frame, but has no force on other bodies.
    """

    def __init__(self, kernels: CompiledSystem, coordinates: BodyCoordinates) -> None:
        self._kernels = kernels
        self._coordinates = coordinates
        self._time = -np.inf
        self._matrices = 0  # at this time

    def _motions(self, rows: ForceRows) -> np.ndarray:
        """Return the motions of the acting elements by a state's coordinates: array (elements, r, n)."""
        tables = self._kernels.tables
        count = rows.acting[0]
        motions = np.zeros((count, rows.wrench.shape[1], self._kernels.layout.coordinate_count))
        numbers = np.arange(count)
        for side in range(2):
            bodies = rows.bodies[:count, side]
            for first, part in (
                (np.where(bodies < 0, -1, tables.bodies.coordinate[bodies]), slice(0, 6)),
                (np.where(bodies < 0, -1, tables.bodies.modal[bodies]), slice(6, None)),
            ):
                factors = rows.jacobian[:count, side, :, part]
                has = numbers[first >= 0]
                places = first[has, None] + np.arange(factors.shape[2])
                motions[has[:, None], :, places] += factors[has].transpose(0, 2, 1)
        has = numbers[rows.unit[:count] >= 0]
        units = rows.unit[has]
        ground = tables.terrain
        by_unit = np.stack((ground.heave[units], ground.tilt[units]), axis=1)
        of_terrain = slice(ground.first, ground.first + ground.heave.shape[1])
        motions[has, :, of_terrain] += np.einsum("prc,pck->prk", rows.unit_jacobian[has], by_unit)
        return motions

    def _write_rows(
        self, time: float, q: np.ndarray, q_t: np.ndarray, weights: Weights
    ) -> tuple[ForceRows, ...]:
        """Return the rows of all elements at Exudyn's coordinates and rates, with weighted tangents."""
        state = np.zeros((3, self._kernels.layout.coordinate_count))
        state[:2] = self._coordinates.to_state(q, q_t)
        self._kernels.residual(state, self._kernels.inputs(time), None, weights)
        return self._kernels.work.forces.rows

    def forces(self, time: float, q: np.ndarray, q_t: np.ndarray, drive_force: float) -> np.ndarray:
        """Return the forces on Exudyn's coordinates at a time (s): array (coordinates,).

        `drive_force` (N) is the multiplier of the frame's speed.
        """
        forces = np.zeros(self._kernels.layout.coordinate_count)
        for rows in self._write_rows(time, q, q_t, NO_DERIVATIVES):
            forces += np.einsum("prk,pr->k", self._motions(rows), rows.wrench[: rows.acting[0]])
        forces -= drive_force * self._pulled()
        return self._coordinates.forces_of_state(q, forces)

    def _pulled(self) -> np.ndarray:
        """Return the forces of a unit of the drive's force that Exudyn's constraint of the speed lacks."""
        tables = self._kernels.tables
        joints = self._kernels.work.joints
        pulled = np.zeros(self._kernels.layout.coordinate_count)
        if not len(tables.joints.pull.markers):
            return pulled
        for body, along in zip(joints.acted_on[0], joints.directions[0], strict=True):
            first = tables.bodies.coordinate[body]
            pulled[first : first + 6] += along[:6]
            modal = tables.bodies.modal[body]
            if modal >= 0:
                pulled[modal : modal + len(along) - 6] += along[6:]
        pulled[tables.bodies.coordinate[tables.joints.pull.frame]] -= 1.0
        return pulled

    def stiffness(
        self, time: float, q: np.ndarray, q_t: np.ndarray, position: float, velocity: float
    ) -> np.ndarray:
        """Return the weighted derivative of the negative forces by Exudyn's coordinates and their rates.

        The rotation of the forces with the bodies is left out, as in the matrix of the compiled equations. As
        there, the later matrices of a step have the secant of the friction curve.
        """
        self._matrices = self._matrices + 1 if time == self._time else 1
        self._time = time
        weights = Weights(position, velocity, 0.0, self._matrices > TANGENTS, 1.0)
        size = self._kernels.layout.coordinate_count
        stiffness = np.zeros((size, size))
        for rows in self._write_rows(time, q, q_t, weights):
            motions = self._motions(rows)
            pushed = rows.tangent[: len(motions)] @ motions
            stiffness += motions.reshape(-1, size).T @ pushed.reshape(-1, size)
        turned = self._coordinates.motions(q)
        return turned.T @ stiffness @ turned
