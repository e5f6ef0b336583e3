"""One Newton's method for tracks and a user's model together, as user functions of an Exudyn solver.

In every iteration the tracks are eliminated: their factored matrices say how the car bodies answer to forces.
The user's model is then solved with these answers, until each of its car bodies is where that of the track
will be, which is cheap beside a residual of a track. The tracks follow, and their residuals decide.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from exudyn_crawler.coupled.block import Step, TrackBlock
from exudyn_crawler.coupled.user_model import UserModel
from exudyn_crawler.model.exudyn import exu

USER_RESIDUAL = 0.25
"""Residual of the user's equations of motion, fraction of the least one of the tracks."""
GAP = 1e-10
"""Greatest gap of the user's constraints and between both bodies of a car body, m and rad: with gaps of 1e-9
the forces between them alternate from step to step and grow."""
MOST = 15
"""Greatest number of iterations of the user's model within one of the tracks."""
SLOW = 0.5
"""Ratio of successive residuals above which the user's matrix is formed anew at once."""
WORTH = 10
"""Number of iterations of a user's model that cost as much as a new matrix (20 bodies: 0.2 and 2 ms)."""
UNIT = 1e4
"""Unit wrench (N, N m) whose initial accelerations are found as the difference of two solutions: as large as
loads, so that rounding does not show in the difference."""


class CoupledStep:
    """Newton's method of a user's model and its machines: Exudyn calls `newton` and `accept` at each step.

    `blocks` are the machines' equations in the order of the model's car bodies.
    """

    def __init__(self, model: UserModel, blocks: Sequence[TrackBlock]) -> None:
        self._model = model
        self._blocks = blocks
        self._limit = USER_RESIDUAL * min(block.system.case.solver.residual for block in blocks)
        # from the cases' frames to the user's, for the wrenches and poses of all car bodies
        self._turn = block_diag(*(block.placement.of_wrench for block in blocks))
        self._closing: np.ndarray | None = None  # wrenches on tracks that close gaps
        self._wasted = 0  # iterations of the user's model that a new matrix would have saved
        self._solved: Step | None = None  # step that waits for its acceptance
        # track that made the last step fail, None for the user's model
        self._failed: TrackBlock | None = None

    def newton(self, solver: Any, _mbs: "exu.MainSystem", settings: "exu.SimulationSettings") -> bool:
        """Solve a step; if it fails, Exudyn calls it again with half the step."""
        size = solver.it.currentStepSize
        alphas = solver.alphaM, solver.alphaF
        step = Step(solver.it.currentTime - size, size, *alphas, solver.newmarkBeta, solver.newmarkGamma)
        # Exudyn repeats a solved step after a change of its own data coordinates
        repeated = step == self._solved
        self._solved = None
        if repeated:
            self._model.resume()
        else:
            self._model.begin(solver, settings, step)
        for block in self._blocks:
            if not (block.resume() if repeated else block.begin(step)):
                self._failed = block
                return False
        solved = self._solve()
        self._solved = step if solved else None
        return solved

    def accept(self) -> None:
        """Accept the solved step, if there is one; Exudyn has accepted its own part."""
        if self._solved is None:
            return
        self._model.accept()
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
        number = 1 + list(self._blocks).index(self._failed)
        return f"machine {number} {self._failed.system.case.name!r}: {where}"

    def _solve(self) -> bool:
        """Solve the step from its prediction; return False if the search is given up."""
        while True:
            for block in self._blocks:
                try:
                    is_new = block.reduce()
                except np.linalg.LinAlgError:  # its matrix is singular
                    self._failed = block
                    return False
                if is_new:
                    self._closing = None
            try:
                wrenches = self._joining_wrenches()
            except np.linalg.LinAlgError:
                wrenches = None
            if wrenches is None:
                self._failed = None
                return False
            pairs = zip(self._blocks, wrenches.reshape(-1, 6), strict=True)
            outcomes = [block.advance(wrench) for block, wrench in pairs]
            if False in outcomes:
                self._failed = self._blocks[outcomes.index(False)]
                return False
            if all(outcomes):
                return True

    def _joining_wrenches(self) -> np.ndarray | None:
        """Find the wrenches with which each car body is at one place in the user's model and in its track.

        This is Newton's method of the user's model within one iteration of the tracks. Unknowns are the
        user's coordinates and the wrenches on the tracks, whose opposites load the user's car bodies. A
        track is eliminated, so that the place of its car body is a linear function of the wrench.

        Returns
        -------
        ndarray or None
            Wrenches on the tracks (6 cars,), in the frames of their cases; None if the search fails.

        Raises
        ------
        numpy.linalg.LinAlgError
            If a matrix is singular.
        """
        model = self._model
        wrenches = np.concatenate([block.wrench for block in self._blocks])
        error_before = math.inf
        for iteration in range(MOST):
            norm, constraint_gap = model.residual(-self._turn @ wrenches)
            pairs = zip(self._blocks, wrenches.reshape(-1, 6), strict=True)
            gaps = model.gaps([block.place_with(wrench) for block, wrench in pairs])
            # greatest of all errors over their limits
            error = max(norm / self._limit, constraint_gap / GAP, np.abs(gaps).max() / GAP)
            if error <= 1.0:
                return wrenches
            if not error < math.inf:
                return None
            # a new matrix needs one iteration; those beyond may cost as much as it does
            self._wasted += iteration > 0
            is_slow = iteration > 1 and error > SLOW * error_before
            if not model.is_factored or self._wasted > WORTH or is_slow:
                model.factor()
                self._closing = None
                self._wasted = 0
            error_before = error
            if self._closing is None:
                self._closing = np.linalg.inv(self._closed(model.answers))
            # with the old wrenches the correction moves the user's car bodies; the change closes what is left
            correction = model.solve()
            change = self._closing @ (gaps - model.turned(correction))
            wrenches = wrenches + change
            model.correct(correction, -self._turn @ change)
        return None

    def accelerate(self, time: float, settings: "exu.SimulationSettings") -> None:
        """Compute the initial accelerations at a time (s); all of them depend linearly on the wrenches."""
        model = self._model
        wrenches = np.concatenate([block.wrench for block in self._blocks])
        loads = -self._turn @ wrenches
        start = model.accelerations(loads, settings)
        units = UNIT * np.eye(len(loads))
        answers = np.array([model.accelerations(loads + unit, settings) - start for unit in units]).T / UNIT
        apart = start - self._turn @ self._accelerations(time, wrenches)
        wrenches += np.linalg.solve(self._closed(answers), apart)
        self._accelerations(time, wrenches)
        model.accelerations(-self._turn @ wrenches, settings)
        model.keep()

    def _accelerations(self, time: float, wrenches: np.ndarray) -> np.ndarray:
        """Compute the accelerations of the tracks; return those of their car bodies (6 cars,)."""
        pairs = zip(self._blocks, wrenches.reshape(-1, 6), strict=True)
        return np.concatenate([block.accelerate(time, wrench) for block, wrench in pairs])

    def _closed(self, answers: np.ndarray) -> np.ndarray:
        """Return how much gaps close per unit of the wrenches on the tracks: array (6 cars, 6 cars).

        `answers` are the changes of the user's poses per unit of the wrenches on them. For initial
        accelerations, gaps are differences of accelerations, and `answers` their changes.
        """
        closed = answers @ self._turn
        for k, block in enumerate(self._blocks):
            own = slice(6 * k, 6 * k + 6)
            closed[own, own] += block.placement.of_wrench @ block.turning @ block.response
        return np.asarray(closed)
