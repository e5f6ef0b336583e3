"""Pull of a track over its slip in closed form, for uniform pressure below a rigid track."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from exudyn_crawler.case import Case, statics
from exudyn_crawler.case.gear.closed import Closed
from exudyn_crawler.case.parameters.terrain import CellContact

STEPS = 400  # number of steps of the sinkage in the sum of the work


@dataclass(frozen=True)
class EvenTrack:
    """Track, or two tracks, with uniform ground pressure.

    The thrust is Janosi and Hanamoto's shear, ``T (1 - exp(-j / K))`` with ``j = i x``, over the length (1st
    Int. Conf. on the Mechanics of Soil-Vehicle Systems, 1961). The resistance is Bekker's work of compaction
    (Introduction to Terrain-Vehicle Systems, 1969), less the work of the ground's rebound. Ground with little
    rebound carries below the rollers alone. The pressure between them falls to zero, and shear starts from
    zero below each roller, over the distance of rollers instead of the whole length.
    """

    law: Any  # soil law of the cells
    length: float  # length of the loaded part, m
    width: float  # width of a shoe, m
    area: float  # area of all loaded shoes, m2
    weight: float  # weight on them, N
    tracks: int
    rollers: int  # number of rollers of a track

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
        """Greatest thrust, N: shear strength of the ground at the mean pressure times the area."""
        depth = np.full(2, self.sinkage)
        slip = np.array([0.0, 1e3 * self.law.shear_deformation])
        _, stress = self.law.drive(depth, slip, self.width)
        return float(stress[-1]) * self.area

    @property
    def rebound(self) -> float:
        """Rebound of the ground from the mean pressure, fraction of the sinkage (0 to 1)."""
        pressure = self._loop()[1][STEPS:]
        # a secant ends at zero but for rounding
        return float(np.count_nonzero(pressure > 1e-9 * pressure[0]) / (STEPS - 1))

    def thrust(self, slip: np.ndarray, starts: int = 1) -> np.ndarray:
        """Return the thrust, N, at slips of at least zero; shear starts `starts` times along the length."""
        shears = np.maximum(slip, 1e-9) * self.length / starts / self.law.shear_deformation
        return self.strength * (1.0 + np.expm1(-shears) / shears)

    @property
    def resistance(self) -> float:
        """Work of compaction per length, N: work of loading less that of unloading, over the loaded width."""
        depth, pressure = self._loop()
        work = float(np.trapezoid(pressure, depth))
        return self.tracks * self.width * work

    def _loop(self) -> tuple[np.ndarray, np.ndarray]:
        """Return depths (m) down to the mean pressure's sinkage and back, and the pressures (Pa) there."""
        down = np.linspace(0.0, self.sinkage, STEPS)
        path = np.concatenate((down, down[::-1]))
        pressure, _ = self.law.drive(path, np.zeros_like(path), self.width)
        return path, pressure

    def pull(self, slip: np.ndarray, starts: int = 1) -> np.ndarray:
        """Return the pull at slips of at least zero, N: `thrust` less resistance, in the slips' shape."""
        return self.thrust(slip, starts) - self.resistance


def even_track(case: Case) -> EvenTrack:
    """Return the track of a case; its load ends half a pitch beyond the rear and the front roller.

    ValueError if the case has no closed track, or no ground of cells.
    """
    gear = case.gear
    if not isinstance(gear, Closed):
        raise ValueError(f"gear.kind must be 'closed' or 'machine' for a drawbar test, got {gear.kind!r}")
    law: Any = case.part(CellContact).law
    pitch = gear.chain_pitch(case.track)
    length = gear.rollers[-1] - gear.rollers[0] + pitch
    area = gear.tracks * length / pitch * case.shoe.ground_area
    masses = gear.carried_mass + case.track.shoe_count * case.shoe.mass
    weight = float(masses * -case.gravity_vector()[2]) - float(statics.machine_wrench(case, 0.0)[0][0, 2])
    return EvenTrack(law, length, case.shoe.width, area, weight, gear.tracks, len(gear.rollers))
