"""One Newton's method for tracks and a user's model together, as user functions of an Exudyn solver.

In every iteration the tracks are eliminated: their factored matrices say how the car bodies answer to forces.
The user's model is then solved with these answers, until each of its car bodies is where that of the track
will be, which is cheap beside a residual of a track. The tracks follow, and their residuals decide.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from exudyn_crawler.coupled.block import Step, TrackBlock
from exudyn_crawler.coupled.user_model import UserModel
from exudyn_crawler.model.exudyn import exu

USER_RESIDUAL = 0.05
"""Residual of the user's equations of motion, fraction of the least one of the tracks."""
GAP = 1e-11
"""Greatest gap of the user's constraints and between both bodies of a car body, m and rad: with gaps of 1e-9
the forces between them alternate from step to step and grow."""
MOST = 15
"""Greatest number of iterations of the user's model within one of the tracks."""
SLOW = 0.1
"""Ratio of successive residuals above which the user's matrix is formed anew."""


UNIT = 1e4
"""Wrench, N and N m, by which the answers of initial accelerations are found: as large as loads are."""


class CoupledStep:
    """Solution of the steps of tracks and a user's model; the arguments are in the same order."""

    def __init__(self, model: UserModel, blocks: Sequence[TrackBlock]) -> None:
        self._model = model
        self._blocks = blocks
        self._limit = USER_RESIDUAL * min(block.system.case.solver.residual for block in blocks)
        self._solved: Step | None = None  # step that waits for its acceptance
        self._failed: TrackBlock | None = None  # track that made the last step fail, None for the user's model
        self._answer: np.ndarray | None = None  # wrenches on tracks that close gaps

    def newton(self, solver: Any, _mbs: "exu.MainSystem", settings: "exu.SimulationSettings") -> bool:
        """Solve a step; if it fails, Exudyn calls it again with half the step."""
        size = solver.it.currentStepSize
        alphas = solver.alphaM, solver.alphaF
        step = Step(solver.it.currentTime - size, size, *alphas, solver.newmarkBeta, solver.newmarkGamma)
        # Exudyn repeats a solved step after a change of its own data coordinates
        repeated = step == self._solved
        self._solved = None
        if not repeated:
            self._model.begin(solver, settings, step)
        for block in self._blocks:
            if not (block.resume() if repeated else block.begin(step)):
                self._failed = block
                return False
        try:
            solved = self._solve()
        except (np.linalg.LinAlgError, RuntimeError):  # singular matrices, of tracks and of the user's model
            solved = False
        self._solved = step if solved else None
        return solved

    def accept(self) -> None:
        """Accept the solved step, if there is one; Exudyn has accepted its own part."""
        if self._solved is None:
            return
        for block in self._blocks:
            block.accept(self._solved)
        self._solved = None

    def fault(self) -> str:
        """Return the cause of the last failure."""
        if self._failed is None:
            return "Newton's method failed in the user's model"
        system = self._failed.system
        failure = system.failure()
        where = failure.cause or f"Newton's method failed, {failure.fault(system.layout)}"
        return f"track {1 + list(self._blocks).index(self._failed)}: {where}"

    def _solve(self) -> bool:
        while True:
            # all of them: a list, not the first new one
            new = any([block.reduce() for block in self._blocks])
            wrenches = self._meet(new)
            if wrenches is None:
                self._failed = None
                return False
            found = [block.advance(wrench) for block, wrench in zip(self._blocks, wrenches, strict=True)]
            if False in found:
                self._failed = self._blocks[found.index(False)]
                return False
            if all(found):
                return True

    def _meet(self, new: bool) -> list[np.ndarray] | None:
        """Solve the user's model for the reduced tracks; return the wrenches on these, None if it fails."""
        model = self._model
        blocks = self._blocks
        wrenches = [block.wrench for block in blocks]
        last = np.inf
        if new:
            self._answer = None
        for iteration in range(MOST):
            norm, gap = model.residual(self._on_user(wrenches))
            pairs = enumerate(zip(blocks, wrenches, strict=True))
            apart = np.concatenate([model.pose(k).gap(block.pose_with(one)) for k, (block, one) in pairs])
            left = max(norm / self._limit, gap / GAP, np.abs(apart).max() / GAP)
            if left <= 1.0:
                return wrenches
            if not left < np.inf:
                return None
            if not model.is_factored or (iteration > 1 and left > SLOW * last):
                model.factor()
                self._answer = None
            last = left
            if self._answer is None:
                self._answer = np.linalg.inv(self._closed(model.answers))
            change = model.solve()
            changes = np.split(self._answer @ (apart - self._own(model.turned(change))), len(blocks))
            wrenches = [wrench + one for wrench, one in zip(wrenches, changes, strict=True)]
            model.correct(change, np.concatenate(self._on_user(changes)))
        return None

    def accelerate(self, time: float, settings: "exu.SimulationSettings") -> None:
        """Compute the initial accelerations at a time (s); all of them depend linearly on the wrenches."""
        model = self._model
        blocks = self._blocks
        wrenches = [block.wrench for block in blocks]
        start = model.accelerations(self._on_user(wrenches), settings)
        units = UNIT * np.eye(6 * len(blocks))
        loads = np.concatenate(self._on_user(wrenches))
        by_units = [model.accelerations(np.split(loads + unit, len(blocks)), settings) for unit in units]
        answers = np.transpose(np.array(by_units) - start) / UNIT
        pairs = zip(blocks, wrenches, strict=True)
        apart = self._own(start) - np.concatenate([block.accelerate(time, one) for block, one in pairs])
        changes = np.split(np.linalg.solve(self._closed(answers), apart), len(blocks))
        wrenches = [wrench + change for wrench, change in zip(wrenches, changes, strict=True)]
        for block, wrench in zip(blocks, wrenches, strict=True):
            block.accelerate(time, wrench)
        model.accelerations(self._on_user(wrenches), settings)
        model.keep()

    def _on_user(self, wrenches: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Return the wrenches on the user's car bodies, in the user's frame, by those on the tracks."""
        return [-block.placement.of_wrench @ one for block, one in zip(self._blocks, wrenches, strict=True)]

    def _own(self, poses: np.ndarray) -> np.ndarray:
        """Turn changes of poses (6 cars, ...) from the user's frame into those of the cases."""
        parts = np.split(poses, len(self._blocks))
        return np.concatenate(
            [block.placement.of_wrench.T @ part for block, part in zip(self._blocks, parts, strict=True)]
        )

    def _closed(self, answers: np.ndarray) -> np.ndarray:
        """Return how much gaps close per unit of the wrenches on the tracks: array (6 cars, 6 cars).

        `answers` are the changes of the user's poses per unit of the wrenches on them.
        """
        closed = self._own(self._own(answers).T).T
        for k, block in enumerate(self._blocks):
            own = slice(6 * k, 6 * k + 6)
            closed[own, own] += block.turning @ block.compliance
        return closed
