"""Pull of a track over its slip in closed form, with even pressure below a rigid track."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from exudyn_crawler.case import Case
from exudyn_crawler.case.gear.closed import Closed

STEPS = 400  # of the sinkage, over which work is summed


@dataclass(frozen=True)
class EvenTrack:
    """Track, or two, below which the pressure is even.

    Its thrust is Janosi and Hanamoto's shear, ``T (1 - exp(-j / K))`` with ``j = i x``, over its length
    (1st Int. Conf. on the Mechanics of Soil-Vehicle Systems, 1961), its resistance Bekker's work of
    compaction (Introduction to Terrain-Vehicle Systems, 1969), less what the ground gives back as it springs.
    Ground that springs back little carries below the rollers alone: pressure between them falls to zero, and
    shear starts again from zero below each, over their distance in place of the whole length.
    """

    law: Any  # of the cells
    length: float  # m, from front to rear of the loaded part
    width: float  # m, of a shoe
    area: float  # m2, of all shoes that are loaded
    weight: float  # N, on them
    tracks: int
    rollers: int  # of a track

    @property
    def pressure(self) -> float:
        """Mean pressure, Pa."""
        return self.weight / self.area

    @property
    def sinkage(self) -> float:
        """Sinkage of a plate as wide as the shoe at the mean pressure, m."""
        return float(self.law.sinkage(self.pressure, self.width))

    @property
    def strength(self) -> float:
        """Greatest thrust, N: the shear strength of the ground at the mean pressure, over the area."""
        depth = np.full(2, self.sinkage)
        slip = np.array([0.0, 1e3 * self.law.shear_deformation])
        _, stress = self.law.drive(depth, slip, self.width)
        return float(stress[-1]) * self.area

    @property
    def rebound(self) -> float:
        """Part of its sinkage by which the ground springs back from the mean pressure, 0 to 1."""
        pressure = self._loop()[1][STEPS:]
        # a secant ends at zero but for rounding
        return float(np.count_nonzero(pressure > 1e-9 * pressure[0]) / (STEPS - 1))

    def thrust(self, slip: np.ndarray, starts: int = 1) -> np.ndarray:
        """Thrust at slips from zero on, where shear starts so often along the length: of their shape, N."""
        shears = np.maximum(slip, 1e-9) * self.length / starts / self.law.shear_deformation
        return self.strength * (1.0 + np.expm1(-shears) / shears)

    @property
    def resistance(self) -> float:
        """Work of compaction per metre, N: work of loading less that of unloading, over the loaded width."""
        depth, pressure = self._loop()
        work = float(np.trapezoid(pressure, depth))
        return self.tracks * self.width * work

    def _loop(self) -> tuple[np.ndarray, np.ndarray]:
        """Depths (m) down to the mean pressure's sinkage and back, and the pressures (Pa) there."""
        down = np.linspace(0.0, self.sinkage, STEPS)
        path = np.concatenate((down, down[::-1]))
        pressure, _ = self.law.drive(path, np.zeros_like(path), self.width)
        return path, pressure

    def pull(self, slip: np.ndarray, starts: int = 1) -> np.ndarray:
        """Pull at slips from zero on: `thrust` less resistance; array of their shape, N."""
        return self.thrust(slip, starts) - self.resistance


def even_track(case: Case) -> EvenTrack:
    """Track of a case, loaded from half a pitch behind its rear roller to as much ahead of its front one.

    ValueError if the case has no closed track, or no ground of cells.
    """
    gear = case.gear
    if not isinstance(gear, Closed):
        raise ValueError(f"gear.kind must be 'closed' or 'machine' for a drawbar test, got {gear.kind!r}")
    law: Any = case.cell_contact().law
    pitch = gear.chain_pitch(case.track)
    length = gear.rollers[-1] - gear.rollers[0] + pitch
    area = gear.tracks * length / pitch * case.shoe.ground_area
    masses = gear.carried_mass + case.track.shoe_count * case.shoe.mass
    weight = float(masses * -case.gravity_vector()[2]) - float(case.machine_wrench(0.0)[0][0, 2])
    return EvenTrack(law, length, case.shoe.width, area, weight, gear.tracks, len(gear.rollers))
