"""What may happen to a closed chain in a run: it breaks, comes off, folds or jumps a tooth."""

import math

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.ground.rotations import rotation_matrices
from exudyn_crawler.model.state import SIDE_FRAME, TUMBLERS, StateLayout

LOOK, WORN, SLACK_TENSION = 0.02, 0.005, 2e4
"""s between two looks at a closed chain: a lug of the M113's pitch takes five times as long over a tooth
at 1.5 m/s; growth of the pitch by which a chain is called worn; N, a tension by which it is called slack, a
third of a metre's weight."""


class ChainWatch:
    """Says what has happened to the chains of closed tracks, from rows of the states as they come."""

    def __init__(self, case: Case, layout: StateLayout) -> None:
        self.case, self.layout, self.closed = case, layout, case.closed_gear()
        self._teeth, _, _, self._addendum, _ = self.closed.tumbler.profile(case.track)
        _, self._lug = self.closed.lugs(case.track)[0]
        self._gaps = np.full(case.track.shoe_count, -1)
        self._ahead = case.links[:, 1] - 1
        self._shoes, self._frame = case.shoe_reference, case.frame_start
        self._tumblers = case.tumbler_reference
        self._middles = np.repeat(case.track_middles, case.loop.shoe_count)
        self._pins = [
            (int(name.rpartition(" ")[2]), layout.first_multiplier(name))
            for name, _ in layout.multipliers
            if " pin of link " in name
        ]
        self.next_look = 0.0

    def fault(self, row: np.ndarray) -> str:
        """Shoe and likely cause of what is wrong; empty if nothing is."""
        self.next_look = float(self.layout.part(row, "time")) + LOOK
        shoes = self.layout.part(row, "shoes") + self._shoes
        tension = self._tension(row)
        found = (
            self._broken(tension),
            self._off(row, shoes),
            self._folded(shoes),
            self._jumped(row, shoes, tension),
        )
        return next((one for one in found if one), "")

    def _tension(self, row: np.ndarray) -> np.ndarray:
        """Force of every link in the chain's plane, N."""
        forces, multipliers = np.zeros((self.case.track.shoe_count, 2)), self.layout.part(row, "multipliers")
        for link, first in self._pins:
            forces[link - 1] += multipliers[[first, first + 2]]
        return np.hypot(*forces.T)

    def _broken(self, tension: np.ndarray) -> str:
        limit, link = self.closed.tension_limit, int(tension.argmax())
        if limit is None or tension[link] <= limit:
            return ""
        return (
            f"link {link + 1}-{self._ahead[link] + 1} broke: its tension of {tension[link]:.4g} N is beyond "
            f"closed_track.tension_limit = {limit:.4g} N; likely a chain too taut for its wheels "
            "(idler.slack, idler.take_up), or a load that is too great"
        )

    def _off(self, row: np.ndarray, shoes: np.ndarray) -> str:
        frame, limit = self.layout.part(row, SIDE_FRAME), self.closed.offset_limit
        turn = rotation_matrices(frame[3:])
        aside = (shoes[:, :3] - frame[:3] - self._frame) @ turn[:, 1] - self._middles
        step = np.abs(aside - aside[self._ahead])
        shoe = int(np.maximum(np.abs(aside), step).argmax())
        if max(abs(aside[shoe]), step[shoe]) <= limit:
            return ""
        return (
            f"shoe {shoe + 1} came off sideways: it is {aside[shoe]:+.4f} m from the track's middle and "
            f"{step[shoe]:.4f} m from shoe {self._ahead[shoe] + 1}, beyond closed_track.offset_limit = "
            f"{limit:g} m; likely a side force that the flanges do not hold (guide_height, guide_stiffness), "
            "or a chain too slack to stay between them"
        )

    def _folded(self, shoes: np.ndarray) -> str:
        bend, limit = shoes[:, 4] - shoes[self._ahead, 4], self.closed.fold_limit
        bend[self._ahead < np.arange(len(bend))] += 2.0 * math.pi
        link = int(np.abs(bend).argmax())
        if abs(bend[link]) <= limit:
            return ""
        return (
            f"the chain folded: shoes {link + 1} and {self._ahead[link] + 1} are at {bend[link]:+.3f} rad, "
            f"beyond closed_track.fold_limit = {limit:g} rad; likely a chain too slack (idler.slack, "
            "idler.take_up), or one that piles up where it is pushed"
        )

    def _jumped(self, row: np.ndarray, shoes: np.ndarray, tension: np.ndarray) -> str:
        """A lug in another gap than before, or than its neighbours say, or none in any."""
        own = np.array([self.layout.part(row, name) for name in TUMBLERS[self.case.tracks]])
        own = np.repeat(own + self._tumblers, len(self._middles) // len(own), axis=0)
        lugs = shoes[:, :3] + rotation_matrices(shoes[:, 3:]) @ self._lug - own[:, :3]
        x, _, z = np.einsum("sji,sj->is", rotation_matrices(own[:, 3:]), lugs)
        radius, angle = np.hypot(x, z), np.arctan2(z, x)
        inside = radius < self._addendum
        gaps = np.where(inside, np.rint(angle * self._teeth / (2.0 * np.pi)) % self._teeth, -1.0).astype(int)
        after = gaps[self._ahead]
        other = inside & (self._gaps >= 0) & (gaps != self._gaps)
        other |= inside & (after >= 0) & ((after - gaps) % int(self._teeth) != 1)
        self._gaps = gaps
        on = inside.reshape(self.case.tracks, -1).any(axis=1)
        if on.all() and not other.any():
            return ""
        shoe = (
            int(
                other.argmax()
                if other.any()
                else np.where(np.repeat(on, len(x) // len(on)), np.inf, radius).argmin()
            )
            + 1
        )
        slack = "too slack to stay on the tumbler (idler.slack, idler.take_up)"
        pulled = "pulled harder than such teeth hold (tumbler.reach, tumbler.depth)"
        why = slack if tension.min() < SLACK_TENSION else pulled
        if self.closed.pitch_growth > WORN:
            why += f", or worn: its pitch has grown by {self.closed.pitch_growth:g}"
        return (
            f"shoe {shoe} jumped a tooth of the tumbler, at tensions of {tension.min():.3g} to "
            f"{tension.max():.3g} N; likely a chain {why}"
        )
