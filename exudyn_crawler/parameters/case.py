"""Everything that a run depends on."""

from typing import Literal, Self

import numpy as np
from pydantic import model_validator

from exudyn_crawler.parameters.base import Parameters, quantity
from exudyn_crawler.parameters.contact import ContactLaw
from exudyn_crawler.parameters.drive import Drive
from exudyn_crawler.parameters.loads import LoadCycle
from exudyn_crawler.parameters.shoe import Shoe
from exudyn_crawler.parameters.solver import Solver
from exudyn_crawler.parameters.terrain import Terrain
from exudyn_crawler.parameters.track import Track


class Case(Parameters):
    """Track, terrain, contact, drive, loads and solver of one run.

    Raises
    ------
    pydantic.ValidationError
        Where the parts do not fit each other: loads for another number of shoes, or a track that does
        not stand on the terrain.
    """

    name: str = "case"
    shoe: Shoe
    track: Track
    terrain: Terrain
    contact: ContactLaw
    drive: Drive
    loads: LoadCycle
    solver: Solver = Solver()
    terrain_formulation: Literal["reduced", "constrained"] = "reduced"
    gravity: float = quantity("m/s2", "acceleration of gravity, along -z", ge=0, default=9.81)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.loads.shoe_count != self.track.shoe_count:
            raise ValueError(
                f"loads must name every shoe of the track ({self.track.shoe_count}), "
                f"got loads for {self.loads.shoe_count}"
            )
        if self.track.pitch + 1e-9 < self.shoe.length:
            raise ValueError(
                f"shoe.length must not exceed the track's pitch {self.track.pitch}, "
                f"got {self.shoe.length}: neighbours would share ground"
            )
        self.check_support(0.0)
        return self

    @classmethod
    def translation(cls) -> Self:
        """Straight propel of the K-chapter, the K-paper and the F-paper."""
        return cls(
            name="translation",
            shoe=Shoe.ph4100c(),
            track=Track.ph4100c(),
            terrain=Terrain.kinematics(),
            contact=ContactLaw.oil_sand(),
            drive=Drive.translation(),
            loads=LoadCycle.propel(),
        )

    @classmethod
    def turning(cls) -> Self:
        """Propel with a turn of the K-chapter, the K-paper and the F-paper."""
        return cls.translation().with_(name="turning", drive=Drive.turning())

    def check_support(self, duration: float) -> None:
        """Refuse a drive that takes the track off the terrain within `duration` (s).

        The track is rigid seen from above, since its hinges only pitch: its outline is carried along
        by the drive and turned about its middle.

        Raises
        ------
        ValueError
            With the time, the place and the terrain's extent.
        """
        footprint = self.shoe.footprint
        coms = self.track.com_positions(self.shoe.com_height)
        x = np.array([coms[0, 0] + footprint[0], coms[-1, 0] + footprint[1]])
        y = coms[0, 1] + footprint[2:4]
        corners = np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
        middle = corners.mean(axis=0)
        end = duration if self.drive.off_time is None else min(duration, self.drive.off_time)
        for time in np.linspace(0.0, end, 101 if end > 0.0 else 1):
            angle = 0.0 if self.drive.turn_rate is None else self.drive.turn_rate.integral(time)
            c, s = np.cos(angle), np.sin(angle)
            placed = middle + (corners - middle) @ np.array([[c, s], [-s, c]])
            placed[:, 0] += self.drive.speed.integral(time)
            for axis, extent, side in ((0, self.terrain.extent[0], "x"), (1, self.terrain.extent[1], "y")):
                low, high = placed[:, axis].min(), placed[:, axis].max()
                if low < 0.0 or high > extent:
                    raise ValueError(
                        f"terrain must carry the track over the whole drive: at t = {time:.3g} s the "
                        f"track reaches {side} = {low:.3f}..{high:.3f} m, the terrain 0..{extent:g} m"
                    )
