"""Everything that a run depends on."""

from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from exudyn_crawler.parameters.base import Parameters, quantity
from exudyn_crawler.parameters.contact import ContactLaw
from exudyn_crawler.parameters.drive import Drive
from exudyn_crawler.parameters.flexible import FlexibleShoes
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

    name: str = Field(default="case", description="name of the case in results and figures")
    shoe: Shoe
    track: Track
    terrain: Terrain
    contact: ContactLaw
    drive: Drive
    loads: LoadCycle
    flexible: FlexibleShoes | None = None
    solver: Solver = Solver()
    terrain_formulation: Literal["reduced", "constrained"] = Field(
        default="reduced",
        description="independent coordinates of the terrain, or all of them with its joints",
    )
    gravity: float = quantity("m/s2", "acceleration of gravity, along -z", ge=0, default=9.81)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not self.name.isprintable():
            raise ValueError(f"name must be printable, got {self.name!r}")
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
        if self.flexible is not None:
            if self.flexible.shoes[0] < 1 or self.flexible.shoes[-1] > self.track.shoe_count:
                raise ValueError(
                    f"flexible.shoes must be in 1..{self.track.shoe_count}, got {self.flexible.shoes}"
                )
            if self.terrain_formulation != "reduced":
                raise ValueError("flexible shoes need terrain_formulation 'reduced'")
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

    def outline(self, time: float) -> NDArray:
        """Corners of the track on the ground at a time: array (4, 2), m, global x and y.

        The track is rigid seen from above, since its hinges only pitch: the drive carries its outline
        along and turns it about its middle.
        """
        footprint = self.shoe.footprint
        coms = self.track.com_positions(self.shoe.com_height)
        x = np.array([coms[0, 0] + footprint[0], coms[-1, 0] + footprint[1]])
        y = coms[0, 1] + footprint[2:4]
        corners = np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]])
        middle = corners.mean(axis=0)
        if self.drive.off_time is not None:
            time = min(time, self.drive.off_time)
        angle = 0.0 if self.drive.turn_rate is None else float(self.drive.turn_rate.integral(time))
        c, s = np.cos(angle), np.sin(angle)
        travel = np.array([float(self.drive.speed.integral(time)), 0.0])
        return middle + (corners - middle) @ np.array([[c, s], [-s, c]]) + travel

    def check_support(self, duration: float) -> None:
        """Refuse a drive that takes the track off the terrain within `duration` (s).

        Raises
        ------
        ValueError
            With the time, the place and the terrain's extent.
        """
        for time in np.linspace(0.0, duration, 101 if duration > 0.0 else 1):
            corners = self.outline(time)
            for axis, name in enumerate("xy"):
                low, high = corners[:, axis].min(), corners[:, axis].max()
                least, greatest = self.terrain.bounds[axis]
                if low < least or high > greatest:
                    raise ValueError(
                        f"terrain must carry the track over the whole drive: at t = {time:.3g} s the "
                        f"track reaches {name} = {low:.3f}..{high:.3f} m, "
                        f"the terrain {least:g}..{greatest:g} m"
                    )
